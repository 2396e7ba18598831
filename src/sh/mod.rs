//! Spherical harmonics: conventions, Legendre functions, series, grids, transforms, bounds. Knows no mesh.

mod coefficients;
mod legendre;
mod series;

pub use coefficients::Coefficients;
pub use legendre::MAX_DEGREE;
pub use series::{Jet, Series};
