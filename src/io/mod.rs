//! Files in and out: meshes, coefficients, images, tables, and the rules by which anything is written.

pub mod coefficients;
pub mod images;
pub mod meshes;
pub mod output;
pub mod tables;
