//! Exact answers: closed forms and integrals that the estimators, the radiosity solver and the
//! geometry are tested against.
//!
//! Units are those of the crate: metres, lm, cd, lx, lm/m2, cd/m2. Surfaces reflect by Lambert's
//! law, so that M = rho E + M0 and L = M/pi. Numbers outside their documented range are answered
//! with [`Error::Parameter`](crate::Error::Parameter).

mod cube;
mod discs;
mod glazing;
mod ranges;
mod windows;

pub mod cie171;
pub mod enclosures;
pub mod form_factors;
pub mod sobolev;

pub use cube::{Cube, CubeLight};
pub use discs::SobolevDiscs;
pub use glazing::Pane;
pub use sobolev::{Plane, SobolevProblem};
