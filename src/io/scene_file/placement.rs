//! How a shape from a file is put into the room: unit, up axis, scale, rotation, position.

use glam::{DMat3, DVec3};
use serde::Deserialize;

use super::values::{Any, Inline, number};
use super::vectors::direction;

/// Places a shape: a point p of the file goes to `at` + [`Placement::matrix`] p.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Where the file's own origin goes, metres.
    pub at: DVec3,
    /// The magnification, above 0.
    pub scale: f64,
    /// The rotation after `up` was turned to z.
    pub rotate: Rotation,
    /// The unit of the file's numbers.
    pub unit: Unit,
    /// The axis of the file that becomes z.
    pub up: Up,
}

impl Placement {
    /// Gives the linear part: rotation times up axis times scale times unit.
    pub fn matrix(&self) -> DMat3 {
        self.rotate.matrix() * self.up.matrix() * (self.scale * self.unit.metres())
    }
}

/// Rotates about an axis through the shape's origin, counter-clockwise seen from the axis' tip.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    /// The axis, of length 1.
    #[serde(deserialize_with = "direction")]
    pub axis: DVec3,
    /// The angle, degrees.
    #[serde(deserialize_with = "number::<Any, _>")]
    pub degrees: f64,
}

impl Inline for Rotation {
    const MUST: &'static str = "a table such as { axis = [0, 0, 1], degrees = 25 }";
}

impl Default for Rotation {
    /// Does not rotate.
    fn default() -> Self {
        Self { axis: DVec3::Z, degrees: 0.0 }
    }
}

impl Rotation {
    /// Gives the rotation matrix.
    pub fn matrix(&self) -> DMat3 {
        DMat3::from_axis_angle(self.axis, self.degrees.to_radians())
    }
}

/// Names the unit of a file's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
pub enum Unit {
    /// Metres.
    #[default]
    #[serde(rename = "m")]
    Metre,
    /// Centimetres.
    #[serde(rename = "cm")]
    Centimetre,
    /// Millimetres.
    #[serde(rename = "mm")]
    Millimetre,
    /// Inches.
    #[serde(rename = "in")]
    Inch,
}

impl Unit {
    /// Gives the length of the unit, metres.
    pub const fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 0.01,
            Self::Millimetre => 0.001,
            Self::Inch => 0.0254,
        }
    }
}

/// Names the axis of a file that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// As here.
    #[default]
    Z,
    /// Turned up by 90 degrees about x: (x, y, z) becomes (x, -z, y).
    Y,
    /// Turned up by -90 degrees about y: (x, y, z) becomes (-z, y, x).
    X,
}

impl Up {
    /// Gives the rotation that turns this axis to z.
    pub const fn matrix(self) -> DMat3 {
        match self {
            Self::Z => DMat3::IDENTITY,
            Self::Y => DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
            Self::X => DMat3::from_cols(DVec3::Z, DVec3::Y, DVec3::NEG_X),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_turns_its_axis_to_z_and_keeps_handedness() {
        for (up, axis) in [(Up::X, DVec3::X), (Up::Y, DVec3::Y), (Up::Z, DVec3::Z)] {
            assert_eq!(up.matrix() * axis, DVec3::Z);
            assert_eq!(up.matrix().determinant(), 1.0);
        }
        let v = DVec3::new(1.0, 2.0, 3.0);
        assert_eq!(Up::Y.matrix() * v, DVec3::new(1.0, -3.0, 2.0));
        assert_eq!(Up::X.matrix() * v, DVec3::new(-3.0, 2.0, 1.0));
    }

    #[test]
    fn matrix_turns_up_before_it_rotates() {
        let rotate = Rotation { axis: DVec3::Z, degrees: 90.0 };
        let placement =
            Placement { at: DVec3::ZERO, scale: 2.0, rotate, unit: Unit::Millimetre, up: Up::Y };
        // (0, 0, 1) of a y-up file is -y here, and a quarter turn later +x; sine and cosine of 90 degrees round to 1e-16.
        let found = placement.matrix() * DVec3::Z;
        assert!((found - DVec3::new(0.002, 0.0, 0.0)).length() <= 1e-18);
    }
}
