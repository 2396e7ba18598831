//! `[materials.NAME.TYPE]`: how surfaces reflect and emit.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer};

use super::source::Entry;
use super::values::{Albedo, AreaShare, AtLeast0, Index, Number, Roughness, number};
use super::vectors::spectrum;
use crate::Result;
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
    /// A perfectly smooth mirror.
    Mirror(MirrorSpec),
    /// Several of these side by side.
    Mixture(MixtureSpec),
}

impl MaterialSpec {
    /// Checks what depends on several keys.
    pub(super) fn check(&self, entry: &Entry) -> Result<()> {
        match self {
            Self::Mixture(spec) => spec.check(entry),
            _ => Ok(()),
        }
    }

    /// Returns the word for this type in a scene file.
    pub(super) fn type_name(&self) -> &'static str {
        match self {
            Self::Lambert(_) => "lambert",
            Self::Metal(_) => "metal",
            Self::Coated(_) => "coated",
            Self::Mirror(_) => "mirror",
            Self::Mixture(_) => "mixture",
        }
    }
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

/// Describes a diffuse base under a clear coat, such as varnish, glaze or linoleum, that may also
/// emit.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoatedSpec {
    /// The part of what enters through the coat that the base sends out again, from 0 to below 1 in
    /// each component.
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

/// Describes a mirror that may also emit.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MirrorSpec {
    /// The reflected part of the flux, from 0 to below 1 in each component.
    #[serde(deserialize_with = "spectrum::<Albedo, _>")]
    pub reflectance: Rgb,
    /// The emitted flux per area, lm/m2, Lambertian on the normal's side; 0 or more.
    #[serde(default, deserialize_with = "spectrum::<AtLeast0, _>")]
    pub exitance: Rgb,
}

/// Describes a mixture of other materials, finer than the eye sees: it reflects and emits the
/// weighted sum of theirs.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MixtureSpec {
    /// The shares of the area by the names of two materials or more, between 0 and 1, 1 together.
    #[serde(deserialize_with = "shares")]
    pub of: BTreeMap<String, f64>,
}

/// How far shares may be from 1 together, for thirds and sevenths written with a few digits.
const ROUNDING: f64 = 1e-3;

/// Shows what the key may look like.
const LIKE: &str = "write them like `of = { silver = 0.85, dust = 0.15 }`";

impl MixtureSpec {
    /// Checks that there are several shares, and that they are those of a whole; what is left of
    /// rounding is divided among them.
    fn check(&self, entry: &Entry) -> Result<()> {
        let few = "a mixture needs two materials or more, found";
        match (self.of.first_key_value(), self.of.len()) {
            (None, _) => return Err(entry.error("of", format!("{few} none"), LIKE)),
            (Some((name, _)), 1) => {
                let instead = format!("`material = {name:?}` where `{}` stands", entry.path[1]);
                let help = format!("add what it is mixed with, or write {instead}");
                return Err(entry.error("of", format!("{few} only `{name}`"), &help));
            }
            _ => {}
        }
        let sum: f64 = self.of.values().sum();
        if (sum - 1.0).abs() <= ROUNDING {
            return Ok(());
        }
        let found = (sum * 1e4).round() / 1e4;
        let message = format!("the shares of a mixture must add up to 1, found {found}");
        let help = format!("{LIKE}; a part that reflects nothing is a lambert of reflectance 0");
        Err(entry.error("of", message, &help))
    }

    /// Returns the names with shares that add up to 1.
    pub fn shares(&self) -> impl Iterator<Item = (&str, f64)> {
        let sum: f64 = self.of.values().sum();
        self.of.iter().map(move |(name, share)| (name.as_str(), share / sum))
    }
}

/// Reads shares by name.
fn shares<'de, D: Deserializer<'de>>(d: D) -> std::result::Result<BTreeMap<String, f64>, D::Error> {
    let written = BTreeMap::<String, Number<AreaShare>>::deserialize(d)?;
    Ok(written.into_iter().map(|(name, share)| (name, share.0)).collect())
}
