//! Materials: how a surface reflects, and what it emits.

use super::reflectance::check_reflectance;
use std::sync::Arc;

use crate::Result;
use crate::math::Rgb;

use super::brdf::Brdf;
use super::glossy::Glossy;
use super::mixture::Mixture;

/// Pairs a reflection with a Lambertian emission.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// The bidirectional reflectance distribution function, the same on both sides.
    pub brdf: Brdf,
    /// The exitance of the surface by itself, lm/m2, leaving on the side of the normal; its
    /// luminance is exitance / pi.
    pub exitance: Rgb,
}

impl Material {
    /// Makes a Lambertian material that does not emit.
    ///
    /// # Errors
    /// [`Error::Parameter`](crate::Error::Parameter) when a component of the reflectance is outside
    /// [0, 1).
    pub fn lambert(reflectance: Rgb) -> Result<Self> {
        check_reflectance(reflectance)?;
        Ok(Self { brdf: Brdf::Lambert { reflectance }, exitance: Rgb::BLACK })
    }

    /// Makes a glossy material that does not emit.
    pub fn glossy(surface: Glossy) -> Self {
        Self { brdf: Brdf::Glossy(Arc::new(surface)), exitance: Rgb::BLACK }
    }

    /// Makes a mirror that does not emit.
    ///
    /// # Errors
    /// [`Error::Parameter`](crate::Error::Parameter) when a component of the reflectance is outside
    /// [0, 1).
    pub fn mirror(reflectance: Rgb) -> Result<Self> {
        check_reflectance(reflectance)?;
        Ok(Self { brdf: Brdf::Mirror { reflectance }, exitance: Rgb::BLACK })
    }

    /// Mixes materials, each by its share of the area: reflection and exitance are the weighted
    /// sums.
    ///
    /// # Errors
    /// [`Error::Parameter`](crate::Error::Parameter) when a share is not above 0, or the shares do
    /// not add up to 1.
    pub fn mixture(parts: &[(f64, Self)]) -> Result<Self> {
        let brdfs: Vec<(f64, &Brdf)> = parts.iter().map(|(share, m)| (*share, &m.brdf)).collect();
        let brdf = Mixture::new(&brdfs)?.simplified();
        let exitance = parts.iter().map(|(share, m)| m.exitance * *share).sum();
        Ok(Self { brdf, exitance })
    }

    /// Adds an exitance, lm/m2.
    pub fn emitting(mut self, exitance: Rgb) -> Self {
        self.exitance = exitance;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn perfect_reflectors_and_nan_are_refused() {
        for r in [1.0, 1.5, -0.1, f64::NAN] {
            assert!(Material::lambert(Rgb::grey(r)).is_err());
            assert!(Material::mirror(Rgb::grey(r)).is_err());
        }
    }

    #[test]
    fn mixtures_add_what_their_parts_reflect_and_emit() {
        let dull = Material::lambert(Rgb::grey(0.25)).expect("valid").emitting(Rgb::grey(10.0));
        let bright = Material::lambert(Rgb::grey(0.75)).expect("valid");
        let mixed = Material::mixture(&[(0.5, dull.clone()), (0.5, bright)]).expect("valid");
        assert_eq!(
            mixed,
            Material::lambert(Rgb::grey(0.5)).expect("valid").emitting(Rgb::grey(5.0))
        );
        for shares in [[0.5, 0.4], [0.0, 1.0], [-0.5, 1.5], [f64::NAN, 1.0]] {
            assert!(Material::mixture(&shares.map(|s| (s, dull.clone()))).is_err(), "{shares:?}");
        }
        assert!(Material::mixture(&[]).is_err());
    }
}
