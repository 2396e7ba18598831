//! A placement: the rotation, uniform scale and translation that carry a shape from its own space
//! into the world.
//!
//! world = scale * rotation * local + translation. The rotation is kept as a matrix whose columns
//! are orthonormal to rounding; after a composition one Newton step towards the orthogonal factor,
//! M (3 I - M^T M)/2, keeps it so however many are chained.

use glam::{DMat3, DQuat, DVec3};

use super::rotation::orthonormalised;
use crate::{Error, Result};

/// Carries points and directions from local space into the world: first rotates, then scales, then
/// moves.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use harmolux::math::Placement;
///
/// let quarter = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
/// let placement = Placement::new(quarter, 2.0, DVec3::Z)?;
/// assert!((placement.apply(DVec3::X) - DVec3::new(0.0, 2.0, 1.0)).length() <= 1e-15);
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    rotation: DMat3,
    scale: f64,
    translation: DVec3,
}

impl Default for Placement {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Placement {
    /// Leaves everything where it is.
    pub const IDENTITY: Self =
        Self { rotation: DMat3::IDENTITY, scale: 1.0, translation: DVec3::ZERO };

    /// Makes a placement; the quaternion may have any positive length, it is normalised.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the quaternion is zero, the scale is not within 1e-100..1e100, or
    /// a number is not finite.
    pub fn new(rotation: DQuat, scale: f64, translation: DVec3) -> Result<Self> {
        let length = rotation.length();
        if !(length.is_finite() && length > 1e-100) {
            return Err(Error::Parameter(format!(
                "a rotation needs a finite quaternion that is not zero, found {rotation}"
            )));
        }
        if !(1e-100..=1e100).contains(&scale) {
            return Err(Error::Parameter(format!(
                "a scale must be positive and finite, found {scale}"
            )));
        }
        if !translation.is_finite() {
            return Err(Error::Parameter(format!(
                "a translation must be finite, found {translation}"
            )));
        }
        // The matrix of a quaternion is off by up to 20 roundings: too much for the error bounds of
        // an instance.
        let rotation = orthonormalised(DMat3::from_quat(rotation / length));
        Ok(Self { rotation, scale, translation })
    }

    /// Returns the rotation matrix, orthonormal to rounding.
    pub const fn rotation(&self) -> DMat3 {
        self.rotation
    }

    /// Returns the scale, world metres per local metre.
    pub const fn scale(&self) -> f64 {
        self.scale
    }

    /// Returns the world point of the local origin, metres.
    pub const fn translation(&self) -> DVec3 {
        self.translation
    }

    /// Carries a local point into the world.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.scale * (self.rotation * point) + self.translation
    }

    /// Turns a local direction or normal into the world; its length stays.
    pub fn apply_direction(&self, direction: DVec3) -> DVec3 {
        self.rotation * direction
    }

    /// Carries a world point into local space.
    pub fn unapply(&self, point: DVec3) -> DVec3 {
        self.rotation.transpose_mul_vec3(point - self.translation) / self.scale
    }

    /// Turns a world direction or normal into local space; its length stays.
    pub fn unapply_direction(&self, direction: DVec3) -> DVec3 {
        self.rotation.transpose_mul_vec3(direction)
    }

    /// Returns the placement that undoes this one.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        let scale = 1.0 / self.scale;
        Self { rotation, scale, translation: -scale * (rotation * self.translation) }
    }

    /// Composes: first `self`, then `outer`.
    pub fn then(&self, outer: &Self) -> Self {
        Self {
            rotation: orthonormalised(outer.rotation * self.rotation),
            scale: outer.scale * self.scale,
            translation: outer.apply(self.translation),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned() -> Placement {
        let rotation = DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 0.7);
        Placement::new(rotation, 2.5, DVec3::new(3.0, -1.0, 0.25)).expect("valid")
    }

    /// What the error of an instance relies on: entries of M^T M - I of at most six unit roundoffs.
    const DEFECT: f64 = 3.0 * f64::EPSILON;

    /// Returns the largest entry of M^T M - I.
    fn defect(m: DMat3) -> f64 {
        let d = m.transpose() * m - DMat3::IDENTITY;
        d.to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max)
    }

    #[test]
    fn degenerate_placements_are_refused() {
        let one = DQuat::IDENTITY;
        for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Placement::new(one, scale, DVec3::ZERO).is_err(), "scale {scale}");
        }
        assert!(Placement::new(DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0), 1.0, DVec3::ZERO).is_err());
        assert!(Placement::new(DQuat::NAN, 1.0, DVec3::ZERO).is_err());
        assert!(Placement::new(one, 1.0, DVec3::splat(f64::NAN)).is_err());
    }

    #[test]
    fn identity_changes_no_bit() {
        let p = DVec3::new(0.1, -1e9, 1.0 / 3.0);
        assert_eq!(Placement::IDENTITY.apply(p), p);
        assert_eq!(Placement::IDENTITY.unapply(p), p);
        assert_eq!(
            Placement::new(DQuat::IDENTITY * 3.0, 1.0, DVec3::ZERO).ok(),
            Some(Placement::default())
        );
    }

    #[test]
    fn inverse_and_unapply_undo() {
        let (placement, p) = (turned(), DVec3::new(0.3, 0.4, -7.0));
        // A dozen roundings of numbers below 20.
        let tolerance = 20.0 * 12.0 * f64::EPSILON;
        let world = placement.apply(p);
        assert!((placement.unapply(world) - p).length() <= tolerance);
        assert!((placement.inverse().apply(world) - p).length() <= tolerance);
        let direction = DVec3::new(0.6, 0.0, 0.8);
        let back = placement.unapply_direction(placement.apply_direction(direction));
        assert!((back - direction).length() <= 4.0 * f64::EPSILON);
    }

    #[test]
    fn composition_is_one_after_the_other() {
        let (inner, p) = (turned(), DVec3::new(0.3, 0.4, -7.0));
        let outer =
            Placement::new(DQuat::from_rotation_x(2.0), 0.1, DVec3::NEG_ONE).expect("valid");
        let both = inner.then(&outer).apply(p);
        assert!((both - outer.apply(inner.apply(p))).length() <= 20.0 * f64::EPSILON);
    }

    #[test]
    fn rotations_stay_orthonormal_after_ten_thousand_compositions() {
        let step =
            Placement::new(DQuat::from_scaled_axis(DVec3::new(0.3, 0.7, 1.1)), 1.0, DVec3::ZERO)
                .expect("valid");
        let mut chain = step;
        for _ in 0..10_000 {
            chain = chain.then(&step);
            assert!(defect(chain.rotation()) <= DEFECT);
        }
    }

    #[test]
    fn rotations_from_quaternions_are_orthonormal_to_rounding() {
        let mut worst = 0.0_f64;
        for i in 0..100_000 {
            let x = f64::from(i);
            let q = DQuat::from_xyzw(x.sin(), (1.7 * x).cos(), (2.3 * x).sin(), (0.37 * x).cos());
            let placement = Placement::new(q, 1.0, DVec3::ZERO).expect("valid");
            worst = worst.max(defect(placement.rotation()));
        }
        assert!(worst <= DEFECT, "{worst:e}");
    }
}
