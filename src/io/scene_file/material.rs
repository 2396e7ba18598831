//! `[materials.NAME.TYPE]`: how surfaces reflect and emit.

use serde::Deserialize;

use super::values::{Albedo, AtLeast0, Index, Roughness, number};
use super::vectors::spectrum;
use crate::math::Rgb;

/// Describes a material.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum MaterialSpec {
    /// Diffuse: the same luminance in all directions.
    Lambert(LambertSpec),
    /// A rough metal: GGX microfacets.
    Metal(MetalSpec),
    /// A diffuse base under a clear coat.
    Coated(CoatedSpec),
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

/// Describes a rough metal that may also emit.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MetalSpec {
    /// The reflected part of the flux at normal incidence, from 0 to below 1 in each component.
    #[serde(deserialize_with = "spectrum::<Albedo, _>")]
    pub reflectance: Rgb,
    /// How rough it is, from 0.01 (nearly a mirror) to 1; the GGX width is its square.
    #[serde(deserialize_with = "number::<Roughness, _>")]
    pub roughness: f64,
    /// The emitted flux per area, lm/m2, Lambertian on the normal's side; 0 or more.
    #[serde(default, deserialize_with = "spectrum::<AtLeast0, _>")]
    pub exitance: Rgb,
}

/// Describes a diffuse base under a clear coat, such as varnish, glaze or linoleum, that may also emit.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoatedSpec {
    /// The part of what enters through the coat that the base sends out again, from 0 to below 1 in each component.
    #[serde(deserialize_with = "spectrum::<Albedo, _>")]
    pub reflectance: Rgb,
    /// How rough the coat is, from 0.01 (nearly a mirror) to 1; the GGX width is its square.
    #[serde(deserialize_with = "number::<Roughness, _>")]
    pub roughness: f64,
    /// The index of refraction of the coat, above 1 and at most 4; 1.5 when left out.
    #[serde(default = "glass", deserialize_with = "number::<Index, _>")]
    pub index: f64,
    /// The emitted flux per area, lm/m2, Lambertian on the normal's side; 0 or more.
    #[serde(default, deserialize_with = "spectrum::<AtLeast0, _>")]
    pub exitance: Rgb,
}

fn glass() -> f64 {
    1.5
}
