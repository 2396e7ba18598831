//! The sphere.
//!
//! The quadratic after Haines, Guenther, Akenine-Moeller, "Precision Improvements for Ray/Sphere
//! Intersection", Ray Tracing Gems, 2019, chapter 7: the discriminant is taken at the point of
//! closest approach, which keeps its digits for far origins, and the smaller root comes from the
//! product of the roots.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::checks;
use crate::Result;
use crate::math::{Aabb, Ray, sampling};
use crate::surface::{AreaPoint, Division, Facet, Hit, Outline, SampleArea, Surface, facets};

/// Holds a sphere; its outer side is the outside, or the inside when it is turned inward.
///
/// ```
/// use glam::DVec3;
/// use harmolux::math::Ray;
/// use harmolux::surface::{Surface, primitives::Sphere};
///
/// let room = Sphere::new(DVec3::ZERO, 2.0)?.turned_inward(true);
/// let hit = room.hit(&Ray::new(DVec3::ZERO, DVec3::X)).expect("from inside every ray hits");
/// assert_eq!((hit.distance, hit.normal), (2.0, DVec3::NEG_X));
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    centre: DVec3,
    radius: f64,
    inward: bool,
}

impl Sphere {
    /// Makes a sphere whose normal points outward.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] when a number is not finite or the radius is not positive or is
    /// lost in rounding at the centre.
    pub fn new(centre: DVec3, radius: f64) -> Result<Self> {
        let centre = checks::point("the centre of a sphere", centre)?;
        let radius = checks::length("the radius of a sphere", radius)?;
        checks::resolvable("the radius of a sphere", radius, centre)?;
        Ok(Self { centre, radius, inward: false })
    }

    /// Turns the normal to the inside (`true`) or the outside (`false`).
    pub const fn turned_inward(mut self, inward: bool) -> Self {
        self.inward = inward;
        self
    }

    /// Returns the centre, metres.
    pub const fn centre(&self) -> DVec3 {
        self.centre
    }

    /// Returns the radius, metres.
    pub const fn radius(&self) -> f64 {
        self.radius
    }

    /// Whether the normal points to the inside.
    pub const fn is_inward(&self) -> bool {
        self.inward
    }

    /// Makes the hit at `centre + offset`, the offset first brought to the length of the radius.
    ///
    /// Error: |v| is good to 2.5u, the quotient and the product add 2u, so |q| = R (1 +- 4.5u); the
    /// last sum adds u|p|. Side test of a departed ray: |origin - centre|^2 - R^2 is good to 6u
    /// R^2, against 2.5 bounds times 2R, 30u R^2 at least.
    fn place(&self, offset: DVec3, distance: f64) -> Hit {
        let length = offset.length();
        let outward = offset / length;
        let point = self.centre + offset * (self.radius / length);
        let normal = if self.inward { -outward } else { outward };
        let error = f64::EPSILON * (3.0 * self.radius + point.length());
        Hit { distance, point, normal, shading_normal: normal, error, part: 0 }
    }
}

impl Surface for Sphere {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        let from = ray.origin - self.centre;
        let towards = -from.dot(ray.direction);
        let closest = from + towards * ray.direction;
        let squared = self.radius * self.radius;
        // The product of the roots; negative inside, where the discriminant is at least its size
        // whatever rounding says.
        let product = from.length_squared() - squared;
        let discriminant = (squared - closest.length_squared()).max(-product);
        if !(discriminant >= 0.0 && ray.direction.is_finite() && ray.direction != DVec3::ZERO) {
            return None;
        }
        let half_chord = discriminant.sqrt();
        // Both summands have one sign: nothing cancels in the larger root, and the product gives
        // the smaller.
        let larger = towards + half_chord.copysign(towards);
        let smaller = if larger == 0.0 { 0.0 } else { product / larger };
        let (near, far) = if larger > 0.0 { (smaller, larger) } else { (larger, smaller) };
        let (distance, along) =
            if ray.contains(near) { (near, -half_chord) } else { (far, half_chord) };
        (distance.is_finite() && ray.contains(distance))
            .then(|| self.place(closest + along * ray.direction, distance))
    }

    fn bounds(&self) -> Aabb {
        let bounds = Aabb::of_ball(self.centre, self.radius);
        let rounding = f64::EPSILON * (self.centre.abs() + self.radius);
        Aabb { min: bounds.min - rounding, max: bounds.max + rounding }
    }
}

impl SampleArea for Sphere {
    fn area(&self) -> f64 {
        4.0 * PI * self.radius * self.radius
    }

    fn sample_area(&self, u: DVec2) -> AreaPoint {
        let hit = self.place(sampling::uniform_sphere(u.to_array()), 0.0);
        AreaPoint { hit, density: 1.0 / self.area() }
    }

    fn density(&self, _: &Hit) -> f64 {
        1.0 / self.area()
    }

    fn outline(&self) -> Outline {
        if self.inward {
            Outline::Other
        } else {
            Outline::Sphere { centre: self.centre, radius: self.radius }
        }
    }

    fn facets(&self, division: &Division) -> Vec<Facet> {
        let at = |direction| (self.place(direction, 0.0), self.radius * self.radius);
        facets::around(division.count, 2, at).collect()
    }
}
