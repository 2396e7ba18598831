//! The infinite plane, and the plane arithmetic it shares with the disc and the rectangle.

use glam::DVec3;

use super::checks;
use crate::Result;
use crate::math::{Aabb, Ray};
use crate::surface::{Hit, Surface};

/// Holds an infinite plane through a point; its outer side is the one the normal points to.
///
/// ```
/// use glam::DVec3;
/// use harmolux::math::Ray;
/// use harmolux::surface::{Surface, primitives::Plane};
///
/// let floor = Plane::new(DVec3::ZERO, DVec3::Z)?;
/// let hit = floor.hit(&Ray::new(DVec3::new(1.0, 2.0, 3.0), DVec3::NEG_Z)).expect("straight down");
/// assert_eq!((hit.distance, hit.point), (3.0, DVec3::new(1.0, 2.0, 0.0)));
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    point: DVec3,
    normal: DVec3,
}

impl Plane {
    /// Makes the plane through `point` perpendicular to `normal`, which may have any length.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] when a coordinate is not finite or the normal is zero.
    pub fn new(point: DVec3, normal: DVec3) -> Result<Self> {
        Ok(Self {
            point: checks::point("the point of a plane", point)?,
            normal: checks::direction("the normal of a plane", normal)?,
        })
    }

    /// Returns the point the plane was made with, metres.
    pub const fn point(&self) -> DVec3 {
        self.point
    }

    /// Returns the unit normal.
    pub const fn normal(&self) -> DVec3 {
        self.normal
    }
}

impl Surface for Plane {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        let distance = crossing(ray, self.point, self.normal)?;
        let offset = ray.origin - self.point + distance * ray.direction;
        let hit = place(self.point, self.normal, offset, distance);
        hit.error.is_finite().then_some(hit)
    }

    fn bounds(&self) -> Aabb {
        let mut bounds = Aabb::ALL;
        for axis in 0..3 {
            // An axis is bounded only if the other two components are zero to the bit: the plane
            // has no end.
            if self.normal[(axis + 1) % 3] == 0.0 && self.normal[(axis + 2) % 3] == 0.0 {
                (bounds.min[axis], bounds.max[axis]) = (self.point[axis], self.point[axis]);
            }
        }
        bounds
    }
}

/// Returns the distance at which the ray crosses the plane; `None` outside its range, parallel to
/// the plane, or for a NaN.
pub(super) fn crossing(ray: &Ray, point: DVec3, normal: DVec3) -> Option<f64> {
    // The same product as in `Hit::departure`: both agree on the side to which a direction looks,
    // to the last bit.
    let distance = normal.dot(point - ray.origin) / normal.dot(ray.direction);
    (distance.is_finite() && ray.contains(distance)).then_some(distance)
}

/// Makes the hit at `centre + offset`, the offset first projected onto the plane.
///
/// Error: with s = n.v and q = v - s n, rounding the product leaves 3u|v|, |n|^2 = 1 +- 4u and the
/// rounding of s n leave 5u|s|, the difference u|q|, the last sum u|p|; a disc's rim test adds
/// 2u|q|. As |s|, |q| <= |v| that is below 12u|v| + 2u|p|. Side test of a departed ray: n.(centre -
/// origin) is good to 4u|v|, a fraction of the 2.5 bounds that remain.
pub(super) fn place(centre: DVec3, normal: DVec3, offset: DVec3, distance: f64) -> Hit {
    let point = centre + (offset - normal.dot(offset) * normal);
    let error = f64::EPSILON * (6.0 * offset.length() + point.length());
    Hit { distance, point, normal, shading_normal: normal, error, part: 0 }
}
