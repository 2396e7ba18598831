//! Shapes: fits, files, rays and storage, against figures of other packages and slower ways.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/ray_check/mod.rs"]
mod ray_check;

mod head;
mod interop;
mod meshes;
mod rays;
mod rooms;
mod storage;
