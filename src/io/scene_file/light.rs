//! `[lights.NAME.TYPE]`: light sources that are no surface.

use std::f64::consts::PI;

use glam::DVec3;
use serde::Deserialize;

use super::source::Entry;
use super::values::{Above0, number_if};
use super::vectors::{colour, point};
use crate::{Result, math::Rgb};

/// Describes a light.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum LightSpec {
    /// A point that shines alike in all directions.
    Point(PointLightSpec),
}

/// Describes an isotropic point light.
#[derive(Debug, Clone, PartialEq)]
pub struct PointLightSpec {
    /// Where it is, metres.
    pub at: DVec3,
    /// How strong it is, in the unit that was written.
    pub strength: Strength,
    /// Its colour, of luminance 1.
    pub colour: Rgb,
}

impl PointLightSpec {
    /// Gives the luminous intensity, cd, with colour; of a flux, flux/(4 pi).
    pub fn intensity(&self) -> Rgb {
        match self.strength {
            Strength::Intensity(candela) => self.colour * candela,
            Strength::Flux(lumen) => self.colour * (lumen / (4.0 * PI)),
        }
    }
}

/// Measures a light; above 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Strength {
    /// Luminous intensity, cd.
    Intensity(f64),
    /// Luminous flux, lm.
    Flux(f64),
}

/// What the file says, before it is known that exactly one of intensity and flux is given.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum WrittenLight {
    Point(WrittenPoint),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenPoint {
    #[serde(deserialize_with = "point")]
    at: DVec3,
    #[serde(default, deserialize_with = "number_if::<Above0, _>")]
    intensity: Option<f64>,
    #[serde(default, deserialize_with = "number_if::<Above0, _>")]
    flux: Option<f64>,
    #[serde(default = "white", deserialize_with = "colour")]
    colour: Rgb,
}

const fn white() -> Rgb {
    Rgb::WHITE
}

impl WrittenLight {
    pub(super) const fn type_name(&self) -> &'static str {
        match self {
            Self::Point(_) => "point",
        }
    }

    pub(super) fn check(self, entry: &Entry) -> Result<LightSpec> {
        match self {
            Self::Point(written) => written.check(entry).map(LightSpec::Point),
        }
    }
}

impl WrittenPoint {
    fn check(self, entry: &Entry) -> Result<PointLightSpec> {
        let Self { at, colour, .. } = self;
        let strength = match (self.intensity, self.flux) {
            (Some(candela), None) => Strength::Intensity(candela),
            (None, Some(lumen)) => Strength::Flux(lumen),
            (None, None) => {
                let message = format!("missing key `intensity` or `flux` in {}", entry.header());
                return Err(entry.error(
                    "",
                    message,
                    "add `intensity = 100` (cd) or `flux = 1000` (lm)",
                ));
            }
            (Some(_), Some(_)) => {
                let key = entry.culprit("intensity", "flux");
                let message = format!("both `intensity` and `flux` in {}", entry.header());
                return Err(entry.error(key, message, "keep one of them"));
            }
        };
        Ok(PointLightSpec { at, strength, colour })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flux_becomes_intensity_and_colour_keeps_the_luminance() {
        let colour = Rgb([2.0, 1.0, 0.5]) / Rgb([2.0, 1.0, 0.5]).luminance();
        let strength = Strength::Flux(4.0 * PI * 7.0);
        let light = PointLightSpec { at: DVec3::ZERO, strength, colour };
        // Three roundings of numbers near 7.
        assert!((light.intensity().luminance() - 7.0).abs() <= 1e-14);
    }
}
