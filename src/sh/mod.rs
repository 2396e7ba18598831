//! Spherical harmonics: conventions, Legendre functions, series, grids, transforms, bounds. Knows no mesh.

mod coefficients;

pub use coefficients::Coefficients;
