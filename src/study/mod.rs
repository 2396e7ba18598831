//! What needs several rooms: fitting a mesh, loading a scene, sweeping truncation degrees.

mod fit;
mod grids;
mod load;
mod reshape;
mod solids;
mod sweep;

pub use fit::{Fit, FitSettings, Projection, fit, mesh_bytes, series_bytes};
pub use load::{FittedObject, Loaded, SensorGroup, camera, load};
pub use reshape::{NewCentre, Reshaped, Steps, Turn, reshape};
pub use sweep::{SweepRow, sweep};
