//! How a surface reflects: evaluation, sampling and density always as a set, and a mirror's part
//! apart.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

use crate::math::{Frame, Rgb, sampling};

use super::glossy::Glossy;
use super::mixture::Mixture;

/// A bidirectional reflectance distribution function, 1/sr. Directions point away from the surface;
/// the normal is on the side of `outgoing`, so nothing passes through.
///
/// [`Brdf::eval`], [`Brdf::sample`], [`Brdf::density`] and [`Brdf::albedo`] leave out what is
/// reflected as by a mirror, which has no density per solid angle: that is [`Brdf::mirror`].
#[derive(Debug, Clone, PartialEq)]
pub enum Brdf {
    /// Diffuse reflection: f = reflectance / pi.
    Lambert {
        /// The reflected share of the incident flux, 0 <= reflectance < 1 per component.
        reflectance: Rgb,
    },
    /// Glossy reflection, of a metal or of a coat above a diffuse base.
    Glossy(Arc<Glossy>),
    /// Reflection into the one mirrored direction.
    Mirror {
        /// The reflected share of the incident flux, 0 <= reflectance < 1 per component.
        reflectance: Rgb,
    },
    /// Several of these side by side.
    Mixture(Arc<Mixture>),
}

/// Holds a sampled direction of reflection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrdfSample {
    /// Where the path goes on (unit, away from the surface).
    pub direction: DVec3,
    /// f cos / density.
    pub weight: Rgb,
    /// The density per steradian.
    pub density: f64,
}

impl Brdf {
    /// Evaluates f for light that comes from `incident` and leaves to `outgoing`; black when they
    /// are on different sides.
    pub fn eval(&self, normal: DVec3, incident: DVec3, outgoing: DVec3) -> Rgb {
        if incident.dot(normal) <= 0.0 || outgoing.dot(normal) <= 0.0 {
            return Rgb::BLACK;
        }
        match self {
            Self::Lambert { reflectance } => *reflectance / PI,
            Self::Glossy(surface) => {
                let frame = Frame::about(normal);
                surface.eval(frame.to_local(incident), frame.to_local(outgoing))
            }
            Self::Mirror { .. } => Rgb::BLACK,
            Self::Mixture(mixture) => mixture.eval(normal, incident, outgoing),
        }
    }

    /// Samples where light that leaves to `outgoing` came from (or goes on to: f is reciprocal).
    /// `None` where the sample is absorbed.
    pub fn sample(&self, normal: DVec3, outgoing: DVec3, u: [f64; 2]) -> Option<BrdfSample> {
        if outgoing.dot(normal) <= 0.0 {
            return None;
        }
        let frame = Frame::about(normal);
        match self {
            Self::Lambert { reflectance } => {
                let local = sampling::cosine_hemisphere(u);
                (local.z > 0.0).then(|| BrdfSample {
                    direction: frame.to_world(local),
                    weight: *reflectance,
                    density: sampling::cosine_pdf(local.z),
                })
            }
            Self::Glossy(surface) => {
                let outgoing = frame.to_local(outgoing);
                let incident = surface.sample(outgoing, u)?;
                let density = surface.density(incident, outgoing);
                let weight = surface.eval(incident, outgoing) * (incident.z / density);
                Some(BrdfSample { direction: frame.to_world(incident), weight, density })
            }
            Self::Mirror { .. } => None,
            Self::Mixture(mixture) => mixture.sample(normal, outgoing, u),
        }
    }

    /// Returns the density per steradian with which [`Brdf::sample`] picks `incident`.
    pub fn density(&self, normal: DVec3, incident: DVec3, outgoing: DVec3) -> f64 {
        match self {
            Self::Lambert { .. } => sampling::cosine_pdf(incident.dot(normal)),
            Self::Glossy(surface) => {
                if incident.dot(normal) <= 0.0 || outgoing.dot(normal) <= 0.0 {
                    return 0.0;
                }
                let frame = Frame::about(normal);
                surface.density(frame.to_local(incident), frame.to_local(outgoing))
            }
            Self::Mirror { .. } => 0.0,
            Self::Mixture(mixture) => mixture.density(normal, incident, outgoing),
        }
    }

    /// Returns the reflected part, 0 to 1, of the luminance of white light that leaves to
    /// `outgoing` (or comes from there).
    pub fn albedo(&self, normal: DVec3, outgoing: DVec3) -> f64 {
        match self {
            Self::Lambert { reflectance } => reflectance.luminance(),
            Self::Glossy(surface) => surface.albedo(outgoing.dot(normal)),
            Self::Mirror { .. } => 0.0,
            Self::Mixture(mixture) => mixture.albedo(normal, outgoing),
        }
    }

    /// Returns the part of the light, 0 to below 1 per component, that is reflected into the
    /// mirrored direction alone.
    pub fn mirror(&self) -> Rgb {
        match self {
            Self::Lambert { .. } | Self::Glossy(_) => Rgb::BLACK,
            Self::Mirror { reflectance } => *reflectance,
            Self::Mixture(mixture) => mixture.mirror(),
        }
    }

    /// Returns how many times more luminance goes to `outgoing` than a perfect diffuser would send,
    /// when light comes from the mirrored direction; not below 1. Where it is large, connections to
    /// walks vary much.
    pub fn peak(&self, normal: DVec3, outgoing: DVec3) -> f64 {
        match self {
            Self::Lambert { .. } | Self::Mirror { .. } => 1.0,
            Self::Glossy(_) | Self::Mixture(_) => {
                let mirrored = 2.0 * outgoing.dot(normal) * normal - outgoing;
                (PI * self.eval(normal, mirrored, outgoing).luminance()).max(1.0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sample_weight_is_f_cos_over_density() {
        let brdf = Brdf::Lambert { reflectance: Rgb([0.2, 0.4, 0.6]) };
        let (n, wo) = (DVec3::new(0.6, 0.0, 0.8), DVec3::Z);
        for i in 0..50 {
            let u = [(f64::from(i) + 0.5) / 50.0, (f64::from(i) * 0.618 + 0.1).fract()];
            let s = brdf.sample(n, wo, u).expect("above the surface");
            let expected = brdf.eval(n, s.direction, wo) * (s.direction.dot(n) / s.density);
            assert!((s.weight.luminance() - expected.luminance()).abs() <= 1e-12);
            assert!((s.density - brdf.density(n, s.direction, wo)).abs() <= 1e-12);
        }
    }

    #[test]
    fn nothing_passes_through() {
        let brdf = Brdf::Lambert { reflectance: Rgb::grey(0.5) };
        assert!(brdf.eval(DVec3::Z, DVec3::NEG_Z, DVec3::Z).is_black());
        assert!(brdf.sample(DVec3::Z, DVec3::NEG_Z, [0.3, 0.3]).is_none());
    }
}
