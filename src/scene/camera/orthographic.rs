//! Parallel rays: lengths across the view are the same at every distance.

use glam::{DVec2, DVec3};

use crate::{Error, Result};

/// Holds the height of the film, metres. Its plane is at right angles to the view and holds the
/// eye; what is behind it is not seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Orthographic {
    height: f64,
}

impl Orthographic {
    pub(super) fn new(height: f64) -> Result<Self> {
        if height > 0.0 && height.is_finite() {
            return Ok(Self { height });
        }
        Err(Error::Parameter(format!(
            "the height of a picture must be a length above 0, found {height}"
        )))
    }

    /// Returns the pixels per metre.
    pub(super) fn scale(self, size: DVec2) -> f64 {
        size.y / self.height
    }

    /// Returns where the ray of a film position starts, as the camera has it.
    pub(super) fn origin(self, film: DVec2, size: DVec2) -> DVec3 {
        ((film - 0.5 * size) / self.scale(size)).extend(0.0)
    }

    pub(super) fn film(self, point: DVec3, size: DVec2) -> Option<DVec2> {
        (point.z > 0.0).then(|| 0.5 * size + self.scale(size) * point.truncate())
    }
}
