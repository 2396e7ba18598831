//! Where a camera stands and how it is turned.

use glam::DVec3;

use crate::math::unit;
use crate::{Error, Result};

/// Holds the eye and three axes at right angles, of length 1: to the right and downwards in the
/// picture, and forward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pose {
    pub(super) eye: DVec3,
    /// Where the camera was told to look, of length 1; a panorama turns forward into the
    /// horizontal.
    view: DVec3,
    pub(super) right: DVec3,
    pub(super) down: DVec3,
    pub(super) forward: DVec3,
}

impl Pose {
    /// Looks from one point to another. Up is z, or y where the view is along z.
    pub(super) fn looking(from: DVec3, to: DVec3) -> Result<Self> {
        let Some(view) = unit(to - from) else {
            return Err(Error::Parameter(
                "a camera must look from one point to another, found the same twice".into(),
            ));
        };
        let up = if view.z.abs() > 1.0 - 1e-12 { DVec3::Y } else { DVec3::Z };
        Self { eye: from, view, right: DVec3::X, down: DVec3::Y, forward: view }.with_up(up)
    }

    /// Turns the camera about its view so that `up` points upwards in the picture.
    pub(super) fn with_up(mut self, up: DVec3) -> Result<Self> {
        let Some(right) = unit(self.view.cross(up)) else {
            return Err(Error::Parameter(format!("{up} cannot be up: it is along the view")));
        };
        self.right = right;
        self.forward = self.view;
        self.down = self.view.cross(right);
        Ok(self)
    }

    /// Turns the camera so that `up` is upwards in the picture and the view, seen from above, stays
    /// as it is.
    pub(super) fn upright(self, up: DVec3) -> Result<Self> {
        let turned = self.with_up(up)?;
        // `with_up` has refused what has no direction.
        let down = -unit(up).unwrap_or(up);
        Ok(Self { down, forward: turned.right.cross(down), ..turned })
    }

    /// Turns a vector of the camera (to the right, downwards, forward) into one of the room.
    pub(super) fn turn(&self, v: DVec3) -> DVec3 {
        v.x * self.right + v.y * self.down + v.z * self.forward
    }

    /// Returns a point of the room as the camera has it: to the right, downwards, forward, metres.
    pub(super) fn local(&self, point: DVec3) -> DVec3 {
        let v = point - self.eye;
        DVec3::new(v.dot(self.right), v.dot(self.down), v.dot(self.forward))
    }
}
