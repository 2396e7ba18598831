//! Shapes with a closed-form answer to a ray: rectangle, disc, sphere, axis-aligned box, infinite
//! plane.
//!
//! Every hit point is projected back onto its shape, so its error bound is a few roundings of the
//! coordinates however far the ray came from (Pharr, Jakob, Humphreys, "Physically Based
//! Rendering", 4th ed., section 6.8). In the derivations beside the code u = 2^-53 is the unit
//! roundoff, half of `f64::EPSILON`, and terms of order u^2 are dwarfed by the slack of the
//! constants. Each bound is also wide enough that a ray departed from it (four bounds off, of which
//! at least 2.5 remain after the error of the point and the rounding of the shift) is seen on the
//! right side by the shape's own side test.

mod axis_box;
mod checks;
mod disc;
#[cfg(test)]
pub(super) mod exact;
mod plane;
mod rectangle;
mod rectangles;
mod sphere;
#[cfg(test)]
mod tests;

pub use axis_box::AxisBox;
pub use disc::Disc;
pub use plane::Plane;
pub use rectangle::Rectangle;
pub(crate) use rectangles::Rectangles;
pub use sphere::Sphere;
