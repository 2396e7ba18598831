//! What needs several rooms: fitting a mesh, loading a scene, sweeping truncation degrees.

mod compare;
mod fit;
mod grids;
mod load;
mod solids;
mod sweep;

pub use compare::{
    CompareSettings, Comparison, DistanceMap, Hausdorff, NormalAngles, RadialDifference, Subject,
    compare, distance_map,
};
pub use fit::{Fit, FitSettings, Projection, fit, mesh_bytes, series_bytes};
pub use load::{FittedObject, Loaded, SensorGroup, camera, load};
pub use sweep::{SweepRow, sweep, sweep_figure};
