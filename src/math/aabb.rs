//! Axis-aligned boxes and their conservative slab test.

use glam::DVec3;

use super::Ray;

/// Bounds a set of points by its smallest and largest coordinates. An empty box has `min > max`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// The smallest coordinates, metres.
    pub min: DVec3,
    /// The largest coordinates, metres.
    pub max: DVec3,
}

impl Aabb {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The box that holds everything.
    pub const ALL: Self = Self { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };

    /// Makes the box between two opposite corners given in any order.
    pub fn new(a: DVec3, b: DVec3) -> Self {
        Self { min: a.min(b), max: a.max(b) }
    }

    /// Bounds a set of points.
    pub fn of_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::with_point)
    }

    /// Bounds the ball about `centre`.
    pub fn of_ball(centre: DVec3, radius: f64) -> Self {
        Self { min: centre - radius, max: centre + radius }
    }

    /// Grows to hold `point`.
    pub fn with_point(self, point: DVec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// Grows to hold another box.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Returns what lies in both boxes; empty when they are disjoint.
    pub fn intersection(self, other: Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// Returns the eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        let end = |upper: bool| if upper { self.max } else { self.min };
        std::array::from_fn(|i| DVec3::new(end(i & 1 == 1).x, end(i & 2 == 2).y, end(i & 4 == 4).z))
    }

    /// Whether nothing is inside.
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// Whether all six bounds are finite.
    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    /// Returns the middle.
    pub fn centre(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// Returns the edge lengths; negative for an empty box.
    pub fn extent(&self) -> DVec3 {
        self.max - self.min
    }

    /// Whether `point` is inside or on the border.
    pub fn contains(&self, point: DVec3) -> bool {
        self.min.cmple(point).all() && point.cmple(self.max).all()
    }

    /// Returns the distances between which the ray is in the box, clipped to the ray's own; `None`
    /// when it passes by.
    ///
    /// Conservative: the exit is widened by the rounding of the slab test (Ize, "Robust BVH Ray
    /// Traversal", 2013), so a ray that touches a face, an edge or a corner is never lost. Zero
    /// direction components are allowed.
    pub fn intersect(&self, ray: &Ray) -> Option<(f64, f64)> {
        const WIDEN: f64 = 1.0 + 4.0 * f64::EPSILON;
        let (mut near, mut far) = (ray.t_min, ray.t_max);
        for axis in 0..3 {
            let (lo, hi) = (self.min[axis] - ray.origin[axis], self.max[axis] - ray.origin[axis]);
            let d = ray.direction[axis];
            if d == 0.0 {
                if lo > 0.0 || hi < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (lo / d, hi / d);
            near = near.max(a.min(b));
            far = far.min(a.max(b) * WIDEN);
        }
        (near <= far).then_some((near, far))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_box_is_missed_and_all_is_hit() {
        let ray = Ray::new(DVec3::ZERO, DVec3::X);
        assert!(Aabb::EMPTY.is_empty() && Aabb::EMPTY.intersect(&ray).is_none());
        assert_eq!(Aabb::ALL.intersect(&ray), Some((0.0, f64::INFINITY)));
    }

    #[test]
    fn boxes_that_touch_share_their_face_and_disjoint_ones_nothing() {
        let cube = Aabb::new(DVec3::ZERO, DVec3::ONE);
        let moved = |x: f64| Aabb::new(DVec3::X * x, DVec3::ONE + DVec3::X * x);
        assert_eq!(cube.intersection(moved(1.0)), Aabb::new(DVec3::X, DVec3::ONE));
        assert!(cube.intersection(moved(1.5)).is_empty());
        assert!(cube.intersection(Aabb::EMPTY).is_empty());
        assert_eq!(Aabb::of_points(cube.corners()), cube);
        assert!(
            (0..8).all(|i| cube.corners().iter().filter(|c| **c == cube.corners()[i]).count() == 1)
        );
    }

    #[test]
    fn ray_along_a_face_counts_as_inside() {
        let cube = Aabb::new(DVec3::ZERO, DVec3::ONE);
        let ray = Ray::new(DVec3::new(-1.0, 0.5, 0.0), DVec3::X);
        let (near, far) = cube.intersect(&ray).expect("grazes the face");
        assert!((near - 1.0).abs() <= 1e-15 && (far - 2.0).abs() <= 1e-14);
    }

    #[test]
    fn ray_behind_its_start_is_missed() {
        let cube = Aabb::new(DVec3::ZERO, DVec3::ONE);
        assert!(cube.intersect(&Ray::new(DVec3::splat(2.0), DVec3::X)).is_none());
    }
}
