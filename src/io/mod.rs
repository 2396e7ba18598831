//! Files in and out: meshes, coefficients, scenes, images, tables, and the rules by which anything
//! is written.

pub(crate) mod bytes;
pub mod checkpoint;
pub mod coefficients;
mod decimal;
pub mod directions;
#[cfg(test)]
mod failing;
#[cfg(test)]
mod formats;
#[cfg(feature = "images")]
pub mod images;
pub mod input;
pub mod meshes;
pub mod npy;
pub mod output;
mod ply;
pub mod points;
pub mod rays;
pub mod scene_file;
pub mod sensor_table;
mod source;
pub mod spectra;
pub mod tables;
