//! The box whose faces are parallel to the coordinate planes: a solid seen from outside, or a room
//! seen from inside.
//!
//! Why a closed room does not leak:
//! 1. A ray that starts in the closed box meets its walls only from inside: entries are not looked
//!    at. Every exit distance is then a
//!    quotient of two numbers of one sign, so it is not negative, and the smallest is a hit,
//!    through edges and corners too.
//! 2. A hit point has the coordinate of its face to the bit, and its other two coordinates are held
//!    a few dozen roundings off the
//!    neighbouring faces. So it is exactly on the box, and departing along an axis from one wall
//!    never goes behind another.
//! 3. The distance kept off the edges is sixteen error bounds. The rounding of a rotated and moved
//!    copy
//!    ([`crate::surface::Instance`]) therefore does not push a departed point behind a wall either,
//!    as long as the copy is not
//!    moved farther than a few times the box's own largest coordinate.

use glam::{DVec2, DVec3};

use super::checks;
use crate::math::{Aabb, Ray, sampling};
use crate::surface::{AreaPoint, Division, Facet, Hit, Outline, SampleArea, Surface, facets};
use crate::{Error, Result};

/// Holds an axis-aligned box; its outer side is the outside, or the inside when it is turned
/// inward.
///
/// The `part` of a hit is its face: 0 to 5 for `x_min`, `x_max`, `y_min`, `y_max`, `z_min`,
/// `z_max`.
///
/// ```
/// use glam::DVec3;
/// use harmolux::math::Ray;
/// use harmolux::surface::{Surface, primitives::AxisBox};
///
/// let room = AxisBox::new(DVec3::ZERO, DVec3::new(4.0, 5.0, 3.0))?.turned_inward(true);
/// let hit = room.hit(&Ray::new(DVec3::ONE, DVec3::NEG_Z)).expect("from inside every ray hits");
/// assert_eq!((hit.distance, hit.normal, hit.part), (1.0, DVec3::Z, 4));
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisBox {
    faces: Aabb,
    inward: bool,
    error: f64,
}

/// How many error bounds a hit point keeps off the edges of its face.
const INSET: f64 = 16.0;

impl AxisBox {
    /// Makes the box between two corners; the normals point outward.
    ///
    /// # Errors
    /// [`Error::Parameter`] when a coordinate is not finite, or `min < max` does not hold on every
    /// axis by more than rounding.
    pub fn new(min: DVec3, max: DVec3) -> Result<Self> {
        let min = checks::point("the lower corner of a box", min)?;
        let max = checks::point("the upper corner of a box", max)?;
        if !min.cmplt(max).all() {
            return Err(Error::Parameter(format!(
                "a box needs min < max on every axis, found {min} and {max}; a flat one is a \
                 rectangle"
            )));
        }
        let largest = min.abs().max(max.abs());
        let thinnest = checks::length("the thinnest side of a box", (max - min).min_element())?;
        checks::resolvable("the thinnest side of a box", thinnest, largest)?;
        // The points are exactly on their face, so any number would do as a bound; this one gives a
        // departing ray eight roundings of the largest coordinate, which it keeps when it is added
        // to any coordinate of the box.
        let error = 2.0 * f64::EPSILON * largest.max_element();
        Ok(Self { faces: Aabb { min, max }, inward: false, error })
    }

    /// Turns the normals to the inside (`true`) or the outside (`false`).
    pub const fn turned_inward(mut self, inward: bool) -> Self {
        self.inward = inward;
        self
    }

    /// Whether the normals point to the inside.
    pub const fn is_inward(&self) -> bool {
        self.inward
    }

    /// Returns the unit normal of face `part` (0 to 5).
    pub fn normal(&self, part: u32) -> DVec3 {
        let mut normal = DVec3::ZERO;
        normal[axis(part)] = if is_upper(part) == self.inward { -1.0 } else { 1.0 };
        normal
    }

    /// Makes the hit on face `part` nearest to `near`.
    fn place(&self, part: u32, near: DVec3, distance: f64) -> Hit {
        let inset = INSET * self.error;
        let mut point = near.max(self.faces.min + inset).min(self.faces.max - inset);
        let side = if is_upper(part) { self.faces.max } else { self.faces.min };
        point[axis(part)] = side[axis(part)];
        let normal = self.normal(part);
        Hit { distance, point, normal, shading_normal: normal, error: self.error, part }
    }

    /// Returns the distances at which the line enters and leaves the closed box, each with its
    /// face; `None` when it passes by.
    fn crossings(&self, ray: &Ray) -> Option<[(f64, u32); 2]> {
        let (mut enter, mut exit) = ((f64::NEG_INFINITY, 0), (f64::INFINITY, 0));
        let (below, above) = (self.faces.min - ray.origin, self.faces.max - ray.origin);
        for (axis, part) in [(0, 0), (1, 2), (2, 4)] {
            let d = ray.direction[axis];
            if d == 0.0 {
                if below[axis] > 0.0 || above[axis] < 0.0 {
                    return None;
                }
                continue;
            }
            let (low, high) = ((below[axis] / d, part), (above[axis] / d, part + 1));
            let (first, last) = if d > 0.0 { (low, high) } else { (high, low) };
            enter = if first.0 > enter.0 { first } else { enter };
            exit = if last.0 < exit.0 { last } else { exit };
        }
        (enter.0 <= exit.0).then_some([enter, exit])
    }

    /// Returns the areas of the six faces added up, by part.
    fn cumulative_areas(&self) -> [f64; 6] {
        let e = self.faces.extent();
        let areas = [e.y * e.z, e.z * e.x, e.x * e.y];
        let mut sum = 0.0;
        std::array::from_fn(|part| {
            sum += areas[part / 2];
            sum
        })
    }
}

/// Returns the axis to which face `part` is perpendicular.
const fn axis(part: u32) -> usize {
    (part / 2) as usize
}

/// Whether face `part` is the one with the larger coordinate.
const fn is_upper(part: u32) -> bool {
    part % 2 == 1
}

impl Surface for AxisBox {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        if !(ray.origin.is_finite() && ray.direction.is_finite()) {
            return None;
        }
        let [enter, exit] = self.crossings(ray)?;
        let starts_outside = !self.faces.contains(ray.origin);
        let (distance, part) = if starts_outside && ray.contains(enter.0) { enter } else { exit };
        (distance.is_finite() && ray.contains(distance))
            .then(|| self.place(part, ray.at(distance), distance))
    }

    fn bounds(&self) -> Aabb {
        self.faces
    }
}

impl SampleArea for AxisBox {
    fn area(&self) -> f64 {
        self.cumulative_areas()[5]
    }

    fn sample_area(&self, u: DVec2) -> AreaPoint {
        let (part, x) = sampling::discrete(&self.cumulative_areas(), u.x);
        let mut at = DVec3::ZERO;
        at[(part / 2 + 1) % 3] = x;
        at[(part / 2 + 2) % 3] = u.y;
        let near = self.faces.min + at * self.faces.extent();
        AreaPoint { hit: self.place(part as u32, near, 0.0), density: 1.0 / self.area() }
    }

    fn density(&self, _: &Hit) -> f64 {
        1.0 / self.area()
    }

    fn outline(&self) -> Outline {
        Outline::Polygons
    }

    fn facets(&self, division: &Division) -> Vec<Facet> {
        let (extent, area) = (self.faces.extent(), self.area());
        let face = |part: u32| {
            let [u, v] = [1, 2].map(|k| (axis(part) + k) % 3);
            let lengths = DVec2::new(extent[u], extent[v]);
            let share = lengths.x * lengths.y / area;
            let count = (division.count as f64 * share).round().max(1.0) as usize;
            facets::rectangle(lengths, count, move |at| {
                let mut near = self.faces.min;
                near[u] += at.x * lengths.x;
                near[v] += at.y * lengths.y;
                self.place(part, near, 0.0)
            })
        };
        (0..6).flat_map(face).collect()
    }
}
