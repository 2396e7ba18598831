//! A proper rotation of space: a matrix that is orthonormal to rounding and keeps handedness.

use glam::{DMat3, DQuat, DVec3};

use super::unit;
use crate::{Error, Result};

/// Turns vectors about the origin.
///
/// ```
/// use glam::DVec3;
/// use harmolux::math::Rotation;
///
/// let quarter = Rotation::about(DVec3::Z, std::f64::consts::FRAC_PI_2)?;
/// assert!((quarter.matrix() * DVec3::X - DVec3::Y).length() <= 1e-15);
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotation {
    matrix: DMat3,
}

/// Holds the angles of R = Rz(alpha) Ry(beta) Rz(gamma), radians: the body turns by gamma about z,
/// then by beta about y, then by alpha about z, all three axes fixed in space (active, z-y-z). To
/// pyshtools this is `rotate(alpha, beta, gamma, convention='y', body=True)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EulerAngles {
    /// The last turn, about z.
    pub alpha: f64,
    /// The turn about y; 0 to pi when it was taken from a rotation.
    pub beta: f64,
    /// The first turn, about z.
    pub gamma: f64,
}

/// How far from orthonormal a given matrix may be: what six decimals of each entry leave.
const DEFECT: f64 = 1e-5;

impl Rotation {
    /// Leaves everything where it is.
    pub const IDENTITY: Self = Self { matrix: DMat3::IDENTITY };

    /// Takes a matrix that acts on column vectors. Entries rounded to six decimals will do: the
    /// nearest rotation is taken.
    ///
    /// # Errors
    /// [`Error::Parameter`] when M^T M differs from the identity by more than 1e-5 in an entry, or
    /// the determinant is negative (a reflection).
    pub fn from_matrix(matrix: DMat3) -> Result<Self> {
        let defect = (matrix.transpose() * matrix - DMat3::IDENTITY)
            .to_cols_array()
            .into_iter()
            .fold(0.0, |worst: f64, d| if d.is_nan() { f64::INFINITY } else { worst.max(d.abs()) });
        if defect > DEFECT {
            return Err(Error::Parameter(format!(
                "this matrix is no rotation: its columns are not unit vectors at right angles (off \
                 by {defect:.1e}); give the scale apart"
            )));
        }
        if matrix.determinant() < 0.0 {
            return Err(Error::Parameter(
                "this matrix is no rotation: its determinant is -1, it turns left into right; \
                 mirror the shape first, then rotate it"
                    .into(),
            ));
        }
        // Each step squares the defect: 1e-5, 1e-10, rounding.
        Ok(Self { matrix: (0..3).fold(matrix, |m, _| orthonormalised(m)) })
    }

    /// Takes a quaternion x i + y j + z k + w of any length but zero.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the quaternion is zero or not finite.
    pub fn from_quaternion(quaternion: DQuat) -> Result<Self> {
        let length = quaternion.length();
        if !(length.is_finite() && length > 1e-100) {
            return Err(Error::Parameter(format!(
                "a rotation needs a finite quaternion that is not zero, found {quaternion}"
            )));
        }
        Ok(Self { matrix: orthonormalised(DMat3::from_quat(quaternion / length)) })
    }

    /// Turns by `angle`, radians, about an axis of any length but zero, by the rule of the right
    /// hand.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the axis is zero or a number is not finite.
    pub fn about(axis: DVec3, angle: f64) -> Result<Self> {
        match unit(axis) {
            Some(axis) if angle.is_finite() => {
                Ok(Self { matrix: orthonormalised(DMat3::from_axis_angle(axis, angle)) })
            }
            _ => Err(Error::Parameter(format!(
                "a rotation needs an axis that is not zero and a finite angle, found {axis} and \
                 {angle}"
            ))),
        }
    }

    /// Turns by Euler angles.
    ///
    /// # Errors
    /// [`Error::Parameter`] when an angle is not finite.
    pub fn from_euler(angles: EulerAngles) -> Result<Self> {
        let EulerAngles { alpha, beta, gamma } = angles;
        if ![alpha, beta, gamma].iter().all(|a| a.is_finite()) {
            return Err(Error::Parameter(format!(
                "Euler angles must be finite, found {alpha}, {beta}, {gamma}"
            )));
        }
        let [alpha, gamma] = [alpha, gamma].map(DMat3::from_rotation_z);
        Ok(Self { matrix: orthonormalised(alpha * DMat3::from_rotation_y(beta) * gamma) })
    }

    /// Returns the matrix, for column vectors.
    pub const fn matrix(&self) -> DMat3 {
        self.matrix
    }

    /// Returns the Euler angles; alpha is 0 where the rotation is about z alone.
    pub fn euler(&self) -> EulerAngles {
        let m = self.matrix;
        let alpha =
            if m.z_axis.x == 0.0 && m.z_axis.y == 0.0 { 0.0 } else { m.z_axis.y.atan2(m.z_axis.x) };
        // What is left after alpha is undone: so beta and gamma suit this alpha even where
        // sin(beta) is all rounding.
        let rest = DMat3::from_rotation_z(-alpha) * m;
        EulerAngles {
            alpha,
            beta: rest.z_axis.x.atan2(rest.z_axis.z),
            gamma: rest.x_axis.y.atan2(rest.y_axis.y),
        }
    }

    /// Returns the angle of the turn, 0 to pi radians.
    pub fn angle(&self) -> f64 {
        let m = self.matrix;
        let twice_sine =
            DVec3::new(m.y_axis.z - m.z_axis.y, m.z_axis.x - m.x_axis.z, m.x_axis.y - m.y_axis.x);
        let twice_cosine = m.x_axis.x + m.y_axis.y + m.z_axis.z - 1.0;
        twice_sine.length().atan2(twice_cosine)
    }

    /// Returns the rotation that undoes this one.
    pub fn inverse(&self) -> Self {
        Self { matrix: self.matrix.transpose() }
    }

    /// Composes: first `self`, then `next`.
    pub fn then(&self, next: &Self) -> Self {
        Self { matrix: orthonormalised(next.matrix * self.matrix) }
    }
}

/// Takes one Newton step towards the nearest orthogonal matrix; a defect of 1e-15 goes down to
/// rounding.
pub(super) fn orthonormalised(m: DMat3) -> DMat3 {
    m * (1.5 * DMat3::IDENTITY - 0.5 * (m.transpose() * m))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    fn difference(a: DMat3, b: DMat3) -> f64 {
        (a - b).to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max)
    }

    #[test]
    fn what_is_no_rotation_is_refused() {
        let reflection = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        let error = Rotation::from_matrix(reflection).expect_err("a reflection").to_string();
        assert!(error.contains("determinant"), "{error}");
        for matrix in [DMat3::ZERO, DMat3::IDENTITY * 1.01, DMat3::IDENTITY * f64::NAN] {
            assert!(Rotation::from_matrix(matrix).is_err(), "{matrix}");
        }
        assert!(Rotation::from_quaternion(DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)).is_err());
        assert!(Rotation::from_quaternion(DQuat::NAN).is_err());
        assert!(Rotation::about(DVec3::ZERO, 1.0).is_err());
        assert!(Rotation::about(DVec3::X, f64::INFINITY).is_err());
        let nan = EulerAngles { alpha: f64::NAN, beta: 0.0, gamma: 0.0 };
        assert!(Rotation::from_euler(nan).is_err());
    }

    #[test]
    fn six_decimals_make_a_rotation() {
        let (cos, sin) = (0.866_025, 0.5);
        let matrix = DMat3::from_cols_array(&[cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0]);
        let rotation = Rotation::from_matrix(matrix).expect("near enough");
        let matrix = rotation.matrix();
        assert!(difference(matrix.transpose() * matrix, DMat3::IDENTITY) <= 4.0 * f64::EPSILON);
        assert!(difference(matrix, DMat3::from_rotation_z(PI / 6.0)) <= 1e-6);
    }

    #[test]
    fn euler_angles_turn_about_z_then_y_then_z_of_space() {
        let quarter = EulerAngles { alpha: 0.0, beta: FRAC_PI_2, gamma: FRAC_PI_2 };
        let rotation = Rotation::from_euler(quarter).expect("finite");
        // x goes to y by gamma and stays there under beta; y goes to -x and then to z.
        assert!((rotation.matrix() * DVec3::X - DVec3::Y).length() <= 1e-15);
        assert!((rotation.matrix() * DVec3::Y - DVec3::Z).length() <= 1e-15);
    }

    #[test]
    fn euler_angles_bring_the_rotation_back_near_the_poles_too() {
        for beta in [0.0, 1e-300, 1e-17, 1e-12, 1e-6, 0.7, FRAC_PI_2, 3.0, PI - 1e-9, PI] {
            for (alpha, gamma) in [(0.0, 0.0), (1.0, 2.0), (-2.5, 0.3), (3.1, -3.1)] {
                let given = EulerAngles { alpha, beta, gamma };
                let rotation = Rotation::from_euler(given).expect("finite");
                let again = Rotation::from_euler(rotation.euler()).expect("finite");
                // A dozen roundings of entries up to 1.
                let error = difference(rotation.matrix(), again.matrix());
                assert!(error <= 12.0 * f64::EPSILON, "{given:?}: {error:e}");
            }
        }
    }

    #[test]
    fn inverse_and_composition_fit() {
        let a = Rotation::about(DVec3::new(1.0, 2.0, -0.5), 0.7).expect("valid");
        let b = Rotation::from_quaternion(DQuat::from_xyzw(0.5, -1.0, 2.0, 3.0)).expect("valid");
        let v = DVec3::new(0.3, 0.4, -0.7);
        let both = a.then(&b).matrix() * v;
        assert!((both - b.matrix() * (a.matrix() * v)).length() <= 4.0 * f64::EPSILON);
        assert!(a.then(&a.inverse()).angle() <= 4.0 * f64::EPSILON);
        assert!((a.angle() - 0.7).abs() <= 4.0 * f64::EPSILON);
        assert!((Rotation::about(DVec3::Y, PI).expect("valid").angle() - PI).abs() <= 1e-15);
    }
}
