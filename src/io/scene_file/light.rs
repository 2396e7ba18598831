//! `[lights.NAME.TYPE]`: light sources that are no surface.

use glam::DVec3;
use serde::Deserialize;

use super::source::Entry;
use super::values::{Above0, HalfTurn, number, number_if};
use super::vectors::{colour, direction, point};
use crate::{Result, math::Rgb};

/// Describes a point light.
#[derive(Debug, Clone, PartialEq)]
pub struct LightSpec {
    /// Where it is, metres.
    pub at: DVec3,
    /// How strong it is, in the unit that was written.
    pub strength: Strength,
    /// Its colour, of luminance 1.
    pub colour: Rgb,
    /// How its intensity depends on the direction.
    pub distribution: DistributionSpec,
}

/// Says how the intensity of a light depends on the direction.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum DistributionSpec {
    /// It does not: `point`.
    Isotropic,
    /// By the cosine to the axis: `lambert`.
    Lambert {
        /// Where it shines most, of length 1.
        direction: DVec3,
    },
    /// In a cone: `spot`.
    Spot {
        /// The middle of the cone, of length 1.
        direction: DVec3,
        /// The half angle up to which it shines in full, degrees, 0 to `outer`.
        inner: f64,
        /// The half angle from which on it does not shine, degrees, above 0 and at most 180.
        outer: f64,
    },
}

impl LightSpec {
    /// Returns the name of its type in a scene file.
    pub const fn type_name(&self) -> &'static str {
        match self.distribution {
            DistributionSpec::Isotropic => "point",
            DistributionSpec::Lambert { .. } => "lambert",
            DistributionSpec::Spot { .. } => "spot",
        }
    }
}

/// Measures a light; above 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Strength {
    /// The largest luminous intensity, cd.
    Intensity(f64),
    /// Luminous flux, lm.
    Flux(f64),
}

/// What the file says, before it is known that exactly one of intensity and flux is given.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum WrittenLight {
    /// A point that shines alike in all directions.
    Point(WrittenPoint),
    /// A point that shines by the cosine to its direction.
    Lambert(WrittenLambert),
    /// A point that shines in a cone.
    Spot(WrittenSpot),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenPoint {
    /// Where it is, metres.
    #[serde(deserialize_with = "point")]
    at: DVec3,
    /// The largest luminous intensity, cd. Exactly one of this and `flux` is given.
    #[serde(default, deserialize_with = "number_if::<Above0, _>")]
    intensity: Option<f64>,
    /// The luminous flux, lm.
    #[serde(default, deserialize_with = "number_if::<Above0, _>")]
    flux: Option<f64>,
    /// Its colour, of which only the ratio counts; white when left out.
    #[serde(default = "white", deserialize_with = "colour")]
    colour: Rgb,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenLambert {
    /// Where it is, metres.
    #[serde(deserialize_with = "point")]
    at: DVec3,
    /// Where it shines most: the middle of its light.
    #[serde(deserialize_with = "direction")]
    direction: DVec3,
    /// The largest luminous intensity, cd. Exactly one of this and `flux` is given.
    #[serde(default, deserialize_with = "number_if::<Above0, _>")]
    intensity: Option<f64>,
    /// The luminous flux, lm.
    #[serde(default, deserialize_with = "number_if::<Above0, _>")]
    flux: Option<f64>,
    /// Its colour, of which only the ratio counts; white when left out.
    #[serde(default = "white", deserialize_with = "colour")]
    colour: Rgb,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenSpot {
    /// Where it is, metres.
    #[serde(deserialize_with = "point")]
    at: DVec3,
    /// Where it shines most: the middle of its light.
    #[serde(deserialize_with = "direction")]
    direction: DVec3,
    /// The half angle up to which it shines in full, degrees; at most `outer`.
    #[serde(deserialize_with = "number::<HalfTurn, _>")]
    inner: f64,
    /// The half angle from which on it does not shine, degrees, above 0.
    #[serde(deserialize_with = "number::<HalfTurn, _>")]
    outer: f64,
    /// The largest luminous intensity, cd. Exactly one of this and `flux` is given.
    #[serde(default, deserialize_with = "number_if::<Above0, _>")]
    intensity: Option<f64>,
    /// The luminous flux, lm.
    #[serde(default, deserialize_with = "number_if::<Above0, _>")]
    flux: Option<f64>,
    /// Its colour, of which only the ratio counts; white when left out.
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
            Self::Lambert(_) => "lambert",
            Self::Spot(_) => "spot",
        }
    }

    pub(super) fn check(self, entry: &Entry) -> Result<LightSpec> {
        match self {
            Self::Point(WrittenPoint { at, intensity, flux, colour }) => {
                let distribution = DistributionSpec::Isotropic;
                let strength = strength(intensity, flux, entry)?;
                Ok(LightSpec { at, strength, colour, distribution })
            }
            Self::Lambert(WrittenLambert { at, direction, intensity, flux, colour }) => {
                let distribution = DistributionSpec::Lambert { direction };
                let strength = strength(intensity, flux, entry)?;
                Ok(LightSpec { at, strength, colour, distribution })
            }
            Self::Spot(written) => written.check(entry),
        }
    }
}

impl WrittenSpot {
    fn check(self, entry: &Entry) -> Result<LightSpec> {
        let Self { at, direction, inner, outer, intensity, flux, colour } = self;
        if outer <= 0.0 || inner > outer {
            let message = format!(
                "the cone of {} is empty or inside out: `inner` is {inner}, `outer` is {outer} \
                 degrees",
                entry.header()
            );
            let help = "write half angles from the axis, `inner` at most `outer`, `outer` above 0";
            return Err(entry.error(entry.culprit("inner", "outer"), message, help));
        }
        let distribution = DistributionSpec::Spot { direction, inner, outer };
        Ok(LightSpec { at, strength: strength(intensity, flux, entry)?, colour, distribution })
    }
}

/// Takes the one of intensity and flux that is given.
fn strength(intensity: Option<f64>, flux: Option<f64>, entry: &Entry) -> Result<Strength> {
    match (intensity, flux) {
        (Some(candela), None) => Ok(Strength::Intensity(candela)),
        (None, Some(lumen)) => Ok(Strength::Flux(lumen)),
        (None, None) => {
            let message = format!("missing key `intensity` or `flux` in {}", entry.header());
            Err(entry.error("", message, "add `intensity = 100` (cd) or `flux = 1000` (lm)"))
        }
        (Some(_), Some(_)) => {
            let message = format!("both `intensity` and `flux` in {}", entry.header());
            Err(entry.error(entry.culprit("intensity", "flux"), message, "keep one of them"))
        }
    }
}
