//! What needs several rooms: fitting a mesh, loading a scene, sweeping truncation degrees.

mod check;
mod fit;
mod grids;
mod load;
mod solids;
mod sweep;

pub use check::{Check, CheckSettings, FaceFault, SOUND, StarCheck};
pub use fit::{Fit, FitSettings, Projection, fit, mesh_bytes, series_bytes};
pub use load::{FittedObject, Loaded, SensorGroup, camera, load};
pub use sweep::{SweepRow, sweep};
