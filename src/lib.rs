//! Harmolux: star-shaped shapes as spherical-harmonic coefficients, and light in rooms by Monte Carlo local estimates.
//!
//! The rooms of the crate, and who may name whom, are drawn in `docs/architecture.md`; `tests/rooms.rs` holds the code to it.
//! Conventions used everywhere: right-handed axes with z up, metres, radians; photometric units (lm, cd, lx, cd/m2); degree l,
//! order m, truncation `lmax`; the Schmidt semi-normalised basis of `docs/conventions.md`.

pub mod error;
pub mod estimators;
pub mod exact;
pub mod fit;
pub mod io;
pub mod math;
pub mod mesh;
#[cfg(feature = "plots")]
pub mod plots;
pub mod scene;
pub mod sh;
pub mod study;
pub mod surface;

pub use error::{Error, Result};
