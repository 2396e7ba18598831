//! Spherical harmonics: conventions, Legendre functions, series, grids, transforms, bounds; rotation, integrals, spectra, means and random
//! shapes. Knows no mesh.

mod align;
mod batch;
mod bounds;
mod coefficients;
mod combination;
mod filter;
mod grid;
mod gridding;
mod least_squares;
mod legendre;
mod mirror;
mod moments;
mod normalisation;
mod position;
mod random;
mod recentre;
mod rotation;
mod rotation_generators;
mod series;
mod shape;
mod spectrum;
mod transform;
mod two_step;

pub use align::{Alignment, Top, align};
pub use bounds::{Bounds, range, rounding};
pub use coefficients::Coefficients;
pub use combination::{difference, mean, scatter, weighted_mean};
pub use filter::Filter;
pub use grid::Grid;
pub use gridding::{GridMoments, GridSeries};
pub use least_squares::{MAX_LEAST_SQUARES_DEGREE, scattered_fit};
pub use legendre::MAX_DEGREE;
pub use mirror::{Axis, mirrored};
pub use moments::Moments;
pub use normalisation::{CondonShortley, Convention, Normalisation};
pub use position::{RadialPart, positions, radius_of};
pub use random::{GaussianSphere, RandomShape, gaussian, power_law};
pub use recentre::{Recentred, recentre};
pub use rotation::rotate;
pub use rotation_generators::rotation_derivatives;
pub use series::{Jet, Series};
pub use shape::{Area, PrincipalAxes, Solid, area, volume};
pub use spectrum::{DegreePower, Spectrum};
pub use transform::{Transform, analysis, synthesis};
