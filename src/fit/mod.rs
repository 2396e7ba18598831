//! From meshes and points to coefficients and back: whether a mesh is star-shaped, its radial
//! samples, their projection, the error of a fit, and the mesh of a series.

mod check;
mod envelope;
mod face_nodes;
mod fit_error;
mod measures;
mod mesh_fit;
mod point_fit;
mod projection;
mod radial_mesh;
mod reshape;
mod self_intersections;
mod shape;
pub mod star;
mod surface_points;
mod tessellation;

pub use check::{Check, CheckSettings, FAULTLESS_COLOUR, FaceFault, StarCheck};
pub use envelope::{Envelope, least_folded};
pub use fit_error::{FitError, fit_error};
pub use measures::Measures;
pub(crate) use measures::enclosed;
pub use mesh_fit::{
    Centre, Fit, FitSettings, FoldPolicy, Projection, fit, mesh_bytes, series_bytes,
};
pub use point_fit::{PointFit, fit_points};
pub use projection::{project_conforming, project_faces, project_grid, project_rays};
pub use radial_mesh::{Folds, RadialMesh, RadialSamples};
pub use reshape::{NewCentre, Reshaped, Steps, Turn, reshape};
pub use self_intersections::{Crossing, SelfIntersections};
pub use shape::{Shape, Source, SourceHash};
pub use surface_points::{LatLong, SurfacePoint, surface_points};
pub(crate) use tessellation::surface_mesh;
pub use tessellation::{
    ChordError, MAX_FACES, Resolution, Tessellation, parametric_mesh, tessellate,
};
