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
    /// An absolute bound, metres, on the distance between the position and the surface it is meant
    /// to be on; 0 where the position is exact to a few roundings, as one that was written is.
    pub error: f64,
}

/// What the illuminance at a point is that of; in uniform light of luminance L all are pi L.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Measure {
    /// A small plane, on the side its normal points to: W = cos.
    #[default]
    Plane,
    /// The side of a small cylinder, in the mean: W = sin / pi of the angle to its axis.
    Cylinder,
    /// The side of half a cylinder, in the mean: W = (1 + cos phi) sin / pi, phi the azimuth from
    /// where it faces.
    SemiCylinder {
        /// Where it faces: a unit vector perpendicular to the axis.
        facing: DVec3,
    },
}

impl Sensor {
    /// Measures the illuminance of a plane on the side its normal points to.
    pub const fn plane(at: DVec3, normal: DVec3) -> Self {
        Self { at, normal, measure: Measure::Plane, error: 0.0 }
    }

    /// Measures at a point of a surface, on the side its geometric normal points to; it is as exact
    /// as the hit.
    pub const fn on(hit: &Hit, measure: Measure) -> Self {
        Self { at: hit.point, normal: hit.normal, measure, error: hit.error }
    }

    /// Describes the sensor as a hit, so that its rays leave by the same policy as everywhere: the
    /// bound on its position, a few roundings at least, keeps a sensor that lies on a surface from
    /// being shadowed by that surface.
    pub fn as_hit(&self) -> Hit {
        Hit {
            distance: 0.0,
            point: self.at,
            normal: self.normal,
            shading_normal: self.normal,
            error: self.error.max(4.0 * f64::EPSILON * self.at.abs().max_element()),
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
    pub non_finite: u64,
}

impl Measured {
    /// Nothing is known: a sensor that does not count, or that the time was too short for.
    pub const UNKNOWN: Self = Self {
        total: Estimate::without_error(f64::NAN),
        direct: Estimate::without_error(f64::NAN),
        non_finite: 0,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sensor_is_as_exact_as_the_hit_it_is_on_and_never_exacter_than_its_coordinates() {
        let plain = Sensor::plane(DVec3::ONE, DVec3::Z).as_hit();
        let hit = Hit { error: 1e-9, ..plain };
        assert_eq!(Sensor::on(&hit, Measure::Plane).as_hit(), hit);
        assert_eq!(Sensor::on(&Hit { error: 0.0, ..plain }, Measure::Plane).as_hit(), plain);
    }
}
