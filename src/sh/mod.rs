//! Spherical harmonics: conventions, Legendre functions, series, grids, transforms, bounds. Knows no mesh.

mod coefficients;
mod normalisation;

pub use coefficients::Coefficients;
pub use normalisation::{CondonShortley, Convention, Normalisation};
