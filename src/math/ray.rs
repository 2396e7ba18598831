//! A ray: where it starts, where it goes, and between which distances it counts.

use glam::DVec3;

/// Carries a half line or a segment: `origin + t direction` for `t_min <= t <= t_max`.
///
/// The direction has unit length, so `t` is a distance in metres. There is no epsilon in a ray: a
/// ray that leaves a surface starts where [`crate::surface::Hit::departure`] says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// The starting point, metres.
    pub origin: DVec3,
    /// The unit direction.
    pub direction: DVec3,
    /// The smallest distance that counts, metres; 0 unless set.
    pub t_min: f64,
    /// The largest distance that counts, metres; infinite unless set.
    pub t_max: f64,
}

impl Ray {
    /// Makes a half line from `origin` along the unit vector `direction`.
    pub const fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f64::INFINITY }
    }

    /// Makes the segment between two points; `None` when they coincide, being less than 1e-150 m
    /// apart, where a length has lost its digits, or when their distance is not finite.
    pub fn between(from: DVec3, to: DVec3) -> Option<Self> {
        let d = to - from;
        let length = d.length();
        (length >= 1e-150 && length.is_finite()).then(|| Self::new(from, d / length).up_to(length))
    }

    /// Ends the ray at distance `t_max` at the latest.
    pub const fn up_to(mut self, t_max: f64) -> Self {
        self.t_max = t_max;
        self
    }

    /// Returns the point at distance `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }

    /// Whether distance `t` counts.
    pub fn contains(&self, t: f64) -> bool {
        self.t_min <= t && t <= self.t_max
    }
}

/// Returns the unit vector along a vector of any finite length but zero; of one below 1e-154 or
/// above 1e154 too, whose squared length is no normal number.
pub fn unit(vector: DVec3) -> Option<DVec3> {
    (vector / vector.abs().max_element()).try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coincident_points_have_no_ray_between_them() {
        assert_eq!(Ray::between(DVec3::ONE, DVec3::ONE), None);
        assert_eq!(Ray::between(DVec3::ONE, DVec3::splat(f64::NAN)), None);
        assert_eq!(Ray::between(DVec3::ZERO, DVec3::new(0.0, 1e-160, 3e-161)), None);
    }

    #[test]
    fn vectors_of_every_length_have_a_direction() {
        let along = DVec3::new(0.6, 0.0, -0.8);
        for exponent in [-307, -160, 0, 160, 307] {
            let found = unit(10_f64.powi(exponent) * along).expect("has a direction");
            assert!(found.distance(along) <= 1e-15, "{exponent}: {found}");
        }
        assert_eq!(unit(5e-324 * DVec3::X), Some(DVec3::X));
        for none in [DVec3::ZERO, DVec3::NAN, DVec3::new(1.0, f64::INFINITY, 0.0)] {
            assert_eq!(unit(none), None, "{none}");
        }
    }

    #[test]
    fn segment_ends_at_its_second_point() {
        let ray = Ray::between(DVec3::ZERO, DVec3::new(3.0, 4.0, 0.0)).expect("distinct points");
        assert!((ray.t_max - 5.0).abs() <= 1e-15);
        assert!(ray.contains(5.0) && !ray.contains(5.1));
    }
}
