//! Files in and out.

pub mod meshes;
