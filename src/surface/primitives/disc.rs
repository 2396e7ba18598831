//! The flat disc.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::{checks, plane};
use crate::Result;
use crate::math::{Aabb, Frame, Ray, sampling};
use crate::surface::{AreaPoint, Division, Facet, Hit, Outline, SampleArea, Surface, facets};

/// Holds a flat disc; its outer side is the one the normal points to.
///
/// ```
/// use glam::DVec3;
/// use harmolux::surface::{SampleArea, primitives::Disc};
///
/// let disc = Disc::new(DVec3::ZERO, DVec3::Z, 2.0)?;
/// assert!((disc.area() - 4.0 * std::f64::consts::PI).abs() <= 1e-14);
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    centre: DVec3,
    normal: DVec3,
    radius: f64,
}

impl Disc {
    /// Makes the disc about `centre` perpendicular to `normal`, which may have any length.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] when a number is not finite, the normal is zero, or the radius
    /// is not positive or is lost in rounding at the centre.
    pub fn new(centre: DVec3, normal: DVec3, radius: f64) -> Result<Self> {
        let centre = checks::point("the centre of a disc", centre)?;
        let normal = checks::direction("the normal of a disc", normal)?;
        let radius = checks::length("the radius of a disc", radius)?;
        checks::resolvable("the radius of a disc", radius, centre)?;
        Ok(Self { centre, normal, radius })
    }

    /// Returns the centre, metres.
    pub const fn centre(&self) -> DVec3 {
        self.centre
    }

    /// Returns the unit normal.
    pub const fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Returns the radius, metres.
    pub const fn radius(&self) -> f64 {
        self.radius
    }
}

impl Surface for Disc {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        let distance = plane::crossing(ray, self.centre, self.normal)?;
        let offset = ray.origin - self.centre + distance * ray.direction;
        let within = offset - self.normal.dot(offset) * self.normal;
        (within.length_squared() <= self.radius * self.radius)
            .then(|| plane::place(self.centre, self.normal, offset, distance))
    }

    fn bounds(&self) -> Aabb {
        let squares = self.normal * self.normal;
        let sines = DVec3::new(squares.y + squares.z, squares.z + squares.x, squares.x + squares.y);
        // A rounding or two in every step: eight cover sines, product, sum and the normal's length.
        let rounding = 8.0 * f64::EPSILON * (self.centre.abs() + self.radius);
        let half = self.radius * sines.map(f64::sqrt) + rounding;
        Aabb { min: self.centre - half, max: self.centre + half }
    }
}

impl SampleArea for Disc {
    fn area(&self) -> f64 {
        PI * self.radius * self.radius
    }

    fn sample_area(&self, u: DVec2) -> AreaPoint {
        let unit = sampling::concentric_disc(u.to_array());
        let frame = Frame::about(self.normal);
        let offset = self.radius * (unit.x * frame.tangent + unit.y * frame.bitangent);
        let hit = plane::place(self.centre, self.normal, offset, 0.0);
        AreaPoint { hit, density: 1.0 / self.area() }
    }

    fn density(&self, _: &Hit) -> f64 {
        1.0 / self.area()
    }

    fn outline(&self) -> Outline {
        Outline::Disc { centre: self.centre, normal: self.normal, radius: self.radius }
    }

    fn facets(&self, division: &Division) -> Vec<Facet> {
        let place = |offset| plane::place(self.centre, self.normal, offset, 0.0);
        facets::disc(self.centre, self.normal, self.radius, division, place)
    }
}
