//! Spherical harmonics: conventions, Legendre functions, series, grids, transforms, bounds. Knows no mesh.

mod batch;
mod bounds;
mod coefficients;
mod grid;
mod legendre;
mod moments;
mod normalisation;
mod position;
mod rotation_generators;
mod series;
mod shape;
mod transform;
mod two_step;

pub use bounds::{Bounds, range, rounding};
pub use coefficients::Coefficients;
pub use grid::Grid;
pub use legendre::MAX_DEGREE;
pub use moments::Moments;
pub use normalisation::{CondonShortley, Convention, Normalisation};
pub use position::{RadialPart, positions, radius_of};
pub use rotation_generators::rotation_derivatives;
pub use series::{Jet, Series};
pub use shape::volume;
pub use transform::{Transform, analysis, synthesis};
