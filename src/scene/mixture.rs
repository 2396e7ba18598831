//! Mixtures of reflections side by side, finer than the eye sees: f = sum of shares times f of the
//! parts.
//!
//! Diffuse parts add up to one diffuse part and mirrors to one mirror, so that a mixture of
//! mixtures is again a list of a diffuse part, glossy parts and a mirror.

use std::sync::Arc;

use glam::DVec3;

use crate::math::Rgb;
use crate::{Error, Result};

use super::brdf::{Brdf, BrdfSample};

/// How far the shares of a mixture may be from 1 together: what is left of rounding.
const ROUNDING: f64 = 1e-9;

/// A weighted sum of reflections.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mixture {
    /// Shares and reflections of the parts with a density: at most one diffuse, then the glossy
    /// ones.
    parts: Vec<(f64, Brdf)>,
    /// What is reflected as by a mirror.
    mirror: Rgb,
}

impl Mixture {
    /// Mixes reflections by their shares of the area.
    ///
    /// # Errors
    /// [`Error::Parameter`] when a share is not above 0, or the shares do not add up to 1.
    pub fn new(parts: &[(f64, &Brdf)]) -> Result<Self> {
        let sum: f64 = parts.iter().map(|(share, _)| share).sum();
        let all_positive = parts.iter().all(|(share, _)| *share > 0.0);
        if !(all_positive && (sum - 1.0).abs() <= ROUNDING) {
            return Err(Error::Parameter(format!(
                "the shares of a mixture must be above 0 and add up to 1, found {:?}",
                parts.iter().map(|(share, _)| *share).collect::<Vec<_>>()
            )));
        }
        let (mut diffuse, mut mixture) = (Rgb::BLACK, Self::default());
        for (share, brdf) in parts {
            mixture.add(*share, brdf, &mut diffuse);
        }
        if !diffuse.is_black() {
            mixture.parts.insert(0, (1.0, Brdf::Lambert { reflectance: diffuse }));
        }
        Ok(mixture)
    }

    fn add(&mut self, share: f64, brdf: &Brdf, diffuse: &mut Rgb) {
        match brdf {
            Brdf::Lambert { reflectance } => *diffuse += *reflectance * share,
            Brdf::Glossy(_) => self.parts.push((share, brdf.clone())),
            Brdf::Mirror { reflectance } => self.mirror += *reflectance * share,
            Brdf::Mixture(other) => {
                self.mirror += other.mirror * share;
                other.parts.iter().for_each(|(s, part)| self.add(s * share, part, diffuse));
            }
        }
    }

    /// Returns the plainest reflection that is the same.
    pub(super) fn simplified(self) -> Brdf {
        match (self.parts.as_slice(), self.mirror.is_black()) {
            ([], true) => Brdf::Lambert { reflectance: Rgb::BLACK },
            ([], false) => Brdf::Mirror { reflectance: self.mirror },
            ([(1.0, part)], true) => part.clone(),
            _ => Brdf::Mixture(Arc::new(self)),
        }
    }

    /// Returns what is reflected into the mirrored direction alone.
    pub(super) fn mirror(&self) -> Rgb {
        self.mirror
    }

    pub(super) fn eval(&self, normal: DVec3, incident: DVec3, outgoing: DVec3) -> Rgb {
        self.parts.iter().map(|(share, part)| part.eval(normal, incident, outgoing) * *share).sum()
    }

    pub(super) fn albedo(&self, normal: DVec3, outgoing: DVec3) -> f64 {
        self.parts.iter().map(|(share, part)| share * part.albedo(normal, outgoing)).sum()
    }

    /// Samples a part in proportion to what it reflects, and a direction of it.
    pub(super) fn sample(&self, normal: DVec3, outgoing: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        let mut left = u[0] * self.albedo(normal, outgoing);
        let (mut chosen, mut within) = (None, 0.0);
        for (share, part) in &self.parts {
            let albedo = share * part.albedo(normal, outgoing);
            if albedo > 0.0 {
                within = (left / albedo).clamp(0.0, 1.0 - f64::EPSILON);
                chosen = Some(part);
                if left < albedo {
                    break;
                }
                left -= albedo;
            }
        }
        let direction = chosen?.sample(normal, outgoing, [within, u[1]])?.direction;
        let density = self.density(normal, direction, outgoing);
        let weight = self.eval(normal, direction, outgoing) * (direction.dot(normal) / density);
        Some(BrdfSample { direction, weight, density })
    }

    pub(super) fn density(&self, normal: DVec3, incident: DVec3, outgoing: DVec3) -> f64 {
        let (mut density, mut all) = (0.0, 0.0);
        for (share, part) in &self.parts {
            let albedo = share * part.albedo(normal, outgoing);
            if albedo > 0.0 {
                density += albedo * part.density(normal, incident, outgoing);
                all += albedo;
            }
        }
        if all > 0.0 { density / all } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sampling;
    use crate::scene::Glossy;

    const NORMAL: DVec3 = DVec3::new(0.6, 0.0, 0.8);

    fn glossy(surface: Result<Glossy>) -> Brdf {
        Brdf::Glossy(Arc::new(surface.expect("valid")))
    }

    /// A mixture that holds a mixture: half diffuse, a quarter metal, an eighth each of varnish and
    /// mirror.
    fn mixture() -> Mixture {
        let diffuse = Brdf::Lambert { reflectance: Rgb([0.2, 0.4, 0.6]) };
        let metal = glossy(Glossy::metal(Rgb([0.9, 0.7, 0.4]), 0.5));
        let varnish = glossy(Glossy::coated(Rgb::grey(0.4), 1.5, 0.6));
        let mirror = Brdf::Mirror { reflectance: Rgb::grey(0.8) };
        let shiny = Mixture::new(&[(0.5, &varnish), (0.5, &mirror)]).expect("valid");
        let shiny = Brdf::Mixture(Arc::new(shiny));
        Mixture::new(&[(0.5, &diffuse), (0.25, &metal), (0.25, &shiny)]).expect("valid")
    }

    /// Averages over a midpoint grid of the unit square.
    fn mean(n: u32, f: impl Fn([f64; 2]) -> f64) -> f64 {
        let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        let sum: f64 = (0..n * n).map(|k| f([middle(k / n), middle(k % n)])).sum();
        sum / f64::from(n * n)
    }

    #[test]
    fn shares_multiply_and_mirrors_are_kept_apart() {
        let mixture = mixture();
        let shares: Vec<f64> = mixture.parts.iter().map(|(share, _)| *share).collect();
        assert_eq!(shares, [1.0, 0.25, 0.125]);
        assert!((mixture.mirror().luminance() - 0.1).abs() <= 1e-15);
    }

    #[test]
    fn directions_may_change_places() {
        let (a, b) = (DVec3::Z, DVec3::new(0.8, 0.6, 0.0));
        let [there, back] = [mixture().eval(NORMAL, a, b), mixture().eval(NORMAL, b, a)];
        assert!((there.luminance() - back.luminance()).abs() <= 1e-12 && !there.is_black());
    }

    #[test]
    fn samples_have_their_density_weight_and_albedo() {
        let (mixture, outgoing) = (mixture(), DVec3::Z);
        let sample = |u| mixture.sample(NORMAL, outgoing, u);
        for u in [[0.1, 0.5], [0.5, 0.2], [0.62, 0.9], [0.9, 0.4], [0.999, 0.7]] {
            let Some(s) = sample(u) else { continue };
            let weight = mixture.eval(NORMAL, s.direction, outgoing) * s.direction.dot(NORMAL);
            assert!((s.weight.luminance() * s.density - weight.luminance()).abs() <= 1e-12);
            assert!((s.density - mixture.density(NORMAL, s.direction, outgoing)).abs() <= 1e-12);
        }
        let by_samples = mean(700, |u| sample(u).map_or(0.0, |s| s.direction.x.powi(2)));
        let by_density = mean(1000, |u| {
            let d = sampling::uniform_sphere(u);
            let density = mixture.density(NORMAL, d, outgoing);
            if d.dot(NORMAL) > 0.0 {
                d.x.powi(2) * density * 4.0 * std::f64::consts::PI
            } else {
                0.0
            }
        });
        assert!((by_samples - by_density).abs() <= 2e-3, "{by_samples} {by_density}");
        let reflected = mean(700, |u| sample(u).map_or(0.0, |s| s.weight.luminance()));
        let albedo = mixture.albedo(NORMAL, outgoing);
        assert!((reflected - albedo).abs() <= 2e-3, "{reflected} {albedo}");
    }
}
