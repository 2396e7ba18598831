//! Shapes: fits, files, rays and storage, against figures of other packages and slower ways.

#[path = "../common/mod.rs"]
mod common;

mod head;
mod interop;
mod meshes;
mod rays;
mod storage;
