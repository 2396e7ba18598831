//! How a shape from a file is put into the room: unit, up axis, scale, rotation, position.

use glam::{DMat3, DQuat, DVec3};
use serde::Deserialize;

use crate::Result;
use crate::math::{Placement, Unit};
use crate::mesh::UpAxis;

use super::values::{Any, Inline, number};
use super::vectors::direction;

/// Says how a shape is put into the room: unit and up axis first, then scale and rotation, then
/// position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacementSpec {
    /// Where the file's own origin goes, metres.
    pub at: DVec3,
    /// The magnification, above 0.
    pub scale: f64,
    /// The rotation after `up` was turned to z.
    pub rotate: Rotation,
    /// The unit of the file's numbers.
    pub unit: Unit,
    /// The axis of the file that becomes z.
    pub up: UpAxis,
}

impl PlacementSpec {
    /// Returns the placement that carries the point `origin` of the file, and all about it, into
    /// the room.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] when the numbers leave what a placement can hold.
    pub fn about(&self, origin: DVec3) -> Result<Placement> {
        let up = self.up;
        let turn = DMat3::from_cols(up.to_z(DVec3::X), up.to_z(DVec3::Y), up.to_z(DVec3::Z));
        let rotation = self.rotate.quaternion() * DQuat::from_mat3(&turn);
        let scale = self.scale * self.unit.metres();
        let own = Placement::new(rotation, scale, self.at)?;
        Placement::new(rotation, scale, own.apply(origin))
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
    /// Returns the rotation.
    pub fn quaternion(&self) -> DQuat {
        DQuat::from_axis_angle(self.axis, self.degrees.to_radians())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_and_up_come_before_scale_rotation_and_position() {
        let rotate = Rotation { axis: DVec3::Z, degrees: 90.0 };
        let spec = PlacementSpec {
            at: DVec3::X,
            scale: 2.0,
            rotate,
            unit: Unit::Millimetre,
            up: UpAxis::Y,
        };
        // (0, 0, 1) of a y-up file is -y here, and a quarter turn later +x; sine and cosine of 90
        // degrees round to 1e-16.
        let found = spec.about(DVec3::ZERO).expect("valid").apply(DVec3::Z);
        assert!((found - DVec3::new(1.002, 0.0, 0.0)).length() <= 1e-15);
        // About another origin the same point of the file goes to the same place.
        let about = spec.about(DVec3::Z).expect("valid").apply(DVec3::ZERO);
        assert!((about - found).length() <= 1e-15);
    }
}
