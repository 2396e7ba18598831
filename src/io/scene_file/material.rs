//! `[materials.NAME.TYPE]`: how surfaces reflect and emit.

use serde::Deserialize;

use super::values::{Albedo, AtLeast0};
use super::vectors::spectrum;
use crate::math::Rgb;

/// Describes a material.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum MaterialSpec {
    /// Diffuse: the same luminance in all directions.
    Lambert(LambertSpec),
}

/// Describes a Lambertian surface that may also emit.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LambertSpec {
    /// The reflected part of the flux, from 0 to below 1 in each component.
    #[serde(deserialize_with = "spectrum::<Albedo, _>")]
    pub reflectance: Rgb,
    /// The emitted flux per area, lm/m2, Lambertian on the normal's side; 0 or more.
    #[serde(default, deserialize_with = "spectrum::<AtLeast0, _>")]
    pub exitance: Rgb,
}
