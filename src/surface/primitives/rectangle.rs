//! The flat rectangle: a corner and two perpendicular edges.

use glam::{DVec2, DVec3};

use super::{checks, plane};
use crate::math::{Aabb, Ray};
use crate::surface::{AreaPoint, Division, Facet, Hit, Outline, SampleArea, Surface, facets};
use crate::{Error, Result};

/// Holds the rectangle `corner + a edge_u + b edge_v`, 0 <= a, b <= 1; its outer side is that of
/// `edge_u x edge_v`.
///
/// ```
/// use glam::DVec3;
/// use harmolux::math::Ray;
/// use harmolux::surface::{Surface, primitives::Rectangle};
///
/// let table = Rectangle::new(DVec3::Z, 2.0 * DVec3::X, DVec3::Y)?;
/// let hit = table.hit(&Ray::new(DVec3::new(1.5, 0.5, 4.0), DVec3::NEG_Z)).expect("above it");
/// assert_eq!((hit.distance, hit.normal), (3.0, DVec3::Z));
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    pub(super) corner: DVec3,
    pub(super) edge_u: DVec3,
    pub(super) edge_v: DVec3,
    pub(super) normal: DVec3,
    pub(super) lengths: DVec2,
}

impl Rectangle {
    /// Makes a rectangle. `edge_v` is made exactly perpendicular to `edge_u`, from which it may
    /// deviate by 1e-9 of its length.
    ///
    /// # Errors
    /// [`Error::Parameter`] when a number is not finite, an edge is zero or lost in rounding at the
    /// corner, or the edges are not perpendicular.
    pub fn new(corner: DVec3, edge_u: DVec3, edge_v: DVec3) -> Result<Self> {
        let corner = checks::point("the corner of a rectangle", corner)?;
        let unit_u = checks::direction("an edge of a rectangle", edge_u)?;
        let unit_v = checks::direction("an edge of a rectangle", edge_v)?;
        let cos = unit_u.dot(unit_v);
        if cos.abs() > 1e-9 {
            return Err(Error::Parameter(format!(
                "the edges {edge_u} and {edge_v} of a rectangle must be perpendicular, the cosine \
                 between them is {cos:.3e}"
            )));
        }
        let edge_v = edge_v - (edge_v.dot(edge_u) / edge_u.length_squared()) * edge_u;
        let lengths = DVec2::new(edge_u.length(), edge_v.length());
        checks::resolvable("an edge of a rectangle", lengths.min_element(), corner)?;
        checks::resolvable("the shorter edge of a rectangle", lengths.min_element(), edge_u)?;
        checks::resolvable("the shorter edge of a rectangle", lengths.min_element(), edge_v)?;
        let normal = edge_u.cross(edge_v).normalize();
        Ok(Self { corner, edge_u, edge_v, normal, lengths })
    }

    /// Returns the corner, metres.
    pub const fn corner(&self) -> DVec3 {
        self.corner
    }

    /// Returns the first edge, metres.
    pub const fn edge_u(&self) -> DVec3 {
        self.edge_u
    }

    /// Returns the second edge, metres, perpendicular to the first.
    pub const fn edge_v(&self) -> DVec3 {
        self.edge_v
    }

    /// Returns the unit normal, along `edge_u x edge_v`.
    pub const fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Makes the hit at parameters within the unit square.
    ///
    /// Error: the exact point of these parameters is on the rectangle; products and their sum lose
    /// 2u(a|U| + b|V|), the sum with the corner u|p|. Side test of a departed ray: the computed
    /// normal is tilted by less than 4u and its product with corner - origin is good to 4u of that
    /// length, 8u(a|U| + b|V|) in all against 2.5 times the 6u below.
    fn place(&self, at: DVec2, distance: f64) -> Hit {
        let point = self.corner + (at.x * self.edge_u + at.y * self.edge_v);
        let error = f64::EPSILON * (3.0 * at.dot(self.lengths) + point.length());
        Hit { distance, point, normal: self.normal, shading_normal: self.normal, error, part: 0 }
    }
}

impl Surface for Rectangle {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        let distance = plane::crossing(ray, self.corner, self.normal)?;
        let offset = ray.origin - self.corner + distance * ray.direction;
        let at = DVec2::new(offset.dot(self.edge_u), offset.dot(self.edge_v))
            / (self.lengths * self.lengths);
        let inside = DVec2::ZERO.cmple(at).all() && at.cmple(DVec2::ONE).all();
        inside.then(|| self.place(at, distance))
    }

    fn as_rectangle(&self) -> Option<&Self> {
        Some(self)
    }

    fn bounds(&self) -> Aabb {
        let (u, v) = (self.edge_u, self.edge_v);
        let bounds =
            Aabb::of_points([self.corner, self.corner + u, self.corner + v, self.corner + (u + v)]);
        // Two sums, each rounded once.
        let rounding = f64::EPSILON * (self.corner.abs() + u.abs() + v.abs());
        Aabb { min: bounds.min - rounding, max: bounds.max + rounding }
    }
}

impl SampleArea for Rectangle {
    fn area(&self) -> f64 {
        self.lengths.x * self.lengths.y
    }

    fn sample_area(&self, u: DVec2) -> AreaPoint {
        let hit = self.place(u.clamp(DVec2::ZERO, DVec2::ONE), 0.0);
        AreaPoint { hit, density: 1.0 / self.area() }
    }

    fn density(&self, _: &Hit) -> f64 {
        1.0 / self.area()
    }

    fn outline(&self) -> Outline {
        Outline::Polygons
    }

    fn facets(&self, division: &Division) -> Vec<Facet> {
        facets::rectangle(self.lengths, division.count, |at| self.place(at, 0.0))
    }
}
