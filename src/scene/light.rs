//! Lights that are no surfaces.

use std::f64::consts::PI;

use glam::DVec3;

use crate::math::Rgb;

/// Shines equally in all directions from a point.
#[derive(Debug, Clone, PartialEq)]
pub struct PointLight {
    /// The name in the scene file.
    pub name: String,
    /// The position, metres.
    pub at: DVec3,
    /// The intensity, cd.
    pub intensity: Rgb,
}

impl PointLight {
    /// Gives the total flux, lm: 4 pi I.
    pub fn flux(&self) -> Rgb {
        self.intensity * (4.0 * PI)
    }
}
