//! Points that measure illuminance, and what was measured.

use glam::DVec3;

use crate::math::stats::Estimate;
use crate::surface::Hit;

/// Measures illuminance at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// The position, metres.
    pub at: DVec3,
    /// The unit normal of the measuring plane, or the axis of the cylinder.
    pub normal: DVec3,
    /// What is lit there.
    pub measure: Measure,
}

/// What the illuminance at a point is that of; in uniform light of luminance L all are pi L.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Measure {
    /// A small plane, on the side its normal points to: W = cos.
    #[default]
    Plane,
    /// The side of a small cylinder, in the mean: W = sin / pi of the angle to its axis.
    Cylinder,
    /// The side of half a cylinder, in the mean: W = (1 + cos phi) sin / pi, phi the azimuth from where it faces.
    SemiCylinder {
        /// Where it faces: a unit vector perpendicular to the axis.
        facing: DVec3,
    },
}

impl Sensor {
    /// Measures the illuminance of a plane on the side its normal points to.
    pub const fn plane(at: DVec3, normal: DVec3) -> Self {
        Self { at, normal, measure: Measure::Plane }
    }

    /// Describes the sensor as a hit, so that its rays leave by the same policy as everywhere: its position is exact to a few roundings,
    /// which is what keeps a sensor that lies on a wall from being shadowed by that wall.
    pub fn as_hit(&self) -> Hit {
        Hit {
            distance: 0.0,
            point: self.at,
            normal: self.normal,
            shading_normal: self.normal,
            error: 4.0 * f64::EPSILON * self.at.abs().max_element().max(1e-3),
            part: 0,
        }
    }
}

/// Holds the illuminance, lx, at a sensor, or the luminance, cd/m2, along a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// All of it.
    pub total: Estimate,
    /// The part that comes straight from lights and emitting surfaces.
    pub direct: Estimate,
    /// Samples that were not finite; counted, never averaged in.
    pub spoilt: u64,
}
