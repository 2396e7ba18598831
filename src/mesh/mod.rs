//! Triangle meshes: what they are, what is wrong with them and how it is mended, and distances.

pub(crate) mod boundary;
mod doubles;
pub(crate) mod edges;
mod nearest;
mod points;
mod repair;
pub(crate) mod report;
pub(crate) mod triangle;
mod triangle_mesh;

pub use boundary::BoundaryLoop;
pub use doubles::Doubles;
pub use edges::{BadEdge, EdgeFault, edge_faults};
pub use nearest::{Nearest, NearestPoint};
pub use points::Points;
pub use repair::{RepairReport, RepairSettings, repair};
pub use report::MeshReport;
pub use triangle_mesh::{Mesh, UpAxis};

/// Meshes for the tests of all rooms.
#[cfg(test)]
pub(crate) use triangle_mesh::shapes;
