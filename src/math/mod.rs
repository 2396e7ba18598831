//! The ground floor: rays, boxes, frames, quadrature, sampling, random streams, statistics, fields
//! on grids. Names no other room.

mod aabb;
pub(crate) mod choice;
mod colour;
mod frame;
pub(crate) mod lanes;
mod lengths;
mod placement;
pub mod quadrature;
mod ray;
mod rotation;
pub mod sampling;
pub mod stats;
mod streams;
mod unit;

pub use aabb::Aabb;
pub use choice::Choice;
pub use colour::Rgb;
pub use frame::Frame;
pub(crate) use lengths::require_measurable;
pub use placement::Placement;
pub use ray::{Ray, unit};
pub use rotation::{EulerAngles, Rotation};
pub use streams::{Randomness, Stream, hash};
pub use unit::Unit;
