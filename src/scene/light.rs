//! Lights that are no surfaces: points, by how their intensity depends on the direction.

use std::f64::consts::PI;

use glam::DVec3;

use crate::math::{Frame, Rgb, sampling};

/// Shines from a point.
#[derive(Debug, Clone, PartialEq)]
pub struct PointLight {
    /// The name in the scene file.
    pub name: String,
    /// The position, metres.
    pub at: DVec3,
    /// The largest intensity, cd: along the axis where there is one.
    pub intensity: Rgb,
    /// How the intensity depends on the direction.
    pub distribution: Distribution,
}

/// How the intensity of a point light depends on the direction, relative to its largest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Distribution {
    /// The same in all directions.
    #[default]
    Isotropic,
    /// I = I0 cos, nothing behind: a small flat lamp.
    Lambert {
        /// The unit vector to which it shines most.
        axis: DVec3,
    },
    /// I0 within the inner cone, 0 outside the outer one, between them a smooth step 3 t^2 - 2 t^3
    /// of the cosine.
    Spot {
        /// The unit vector along the middle of the cones.
        axis: DVec3,
        /// The cosine of the half angle of the inner cone.
        inner: f64,
        /// The cosine of the half angle of the outer cone, at most `inner`.
        outer: f64,
    },
}

impl PointLight {
    /// Makes a light that shines equally in all directions.
    pub fn isotropic(name: &str, at: DVec3, intensity: Rgb) -> Self {
        Self { name: name.to_owned(), at, intensity, distribution: Distribution::Isotropic }
    }

    /// Returns the intensity, cd, towards the unit vector `direction`.
    pub fn towards(&self, direction: DVec3) -> Rgb {
        self.intensity * self.distribution.relative(direction)
    }

    /// Returns the total flux, lm.
    pub fn flux(&self) -> Rgb {
        self.intensity * self.distribution.integral()
    }

    /// Samples a direction to shine to, and gives it with the intensity over the density there, lm.
    pub fn sample(&self, u: [f64; 2]) -> (DVec3, Rgb) {
        let (direction, weight) = self.distribution.sample(u);
        (direction, self.intensity * weight)
    }
}

impl Distribution {
    /// Returns the intensity towards a unit vector, relative to the largest: 0 to 1.
    pub fn relative(&self, direction: DVec3) -> f64 {
        match *self {
            Self::Isotropic => 1.0,
            Self::Lambert { axis } => axis.dot(direction).max(0.0),
            Self::Spot { axis, inner, outer } => {
                let cos = axis.dot(direction);
                if cos >= inner {
                    1.0
                } else if cos <= outer {
                    0.0
                } else {
                    let t = (cos - outer) / (inner - outer);
                    t * t * (3.0 - 2.0 * t)
                }
            }
        }
    }

    /// Returns the integral of [`Distribution::relative`] over all directions, sr: the flux over
    /// the largest intensity.
    pub fn integral(&self) -> f64 {
        match *self {
            Self::Isotropic => 4.0 * PI,
            Self::Lambert { .. } => PI,
            // The smooth step is a half in the mean, and solid angle is uniform in the cosine.
            Self::Spot { inner, outer, .. } => 2.0 * PI * (1.0 - 0.5 * (inner + outer)),
        }
    }

    /// Samples a direction and gives it with the relative intensity over its density, sr.
    fn sample(&self, u: [f64; 2]) -> (DVec3, f64) {
        match *self {
            Self::Isotropic => (sampling::uniform_sphere(u), self.integral()),
            Self::Lambert { axis } => {
                let local = sampling::cosine_hemisphere(u);
                (Frame::about(axis).to_world(local), self.integral())
            }
            Self::Spot { axis, outer, .. } => {
                let direction = Frame::about(axis).to_world(sampling::uniform_cone(outer, u));
                (direction, 2.0 * PI * (1.0 - outer) * self.relative(direction))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distributions() -> [Distribution; 4] {
        let axis = DVec3::new(0.6, 0.0, 0.8);
        let spot = |inner: f64, outer: f64| Distribution::Spot {
            axis,
            inner: inner.to_radians().cos(),
            outer: outer.to_radians().cos(),
        };
        [
            Distribution::Isotropic,
            Distribution::Lambert { axis },
            spot(10.0, 25.0),
            spot(30.0, 30.0),
        ]
    }

    #[test]
    fn integral_is_that_of_the_relative_intensity_and_of_the_samples() {
        for light in distributions() {
            // The midpoint rule in cosine and azimuth; a jump costs half a cell of 1/1000 of the
            // sphere's height.
            let (n, mut sum) = (1000, 0.0);
            for i in 0..n * n {
                let u = [i / n, i % n].map(|k| (f64::from(k) + 0.5) / f64::from(n));
                sum += light.relative(sampling::uniform_sphere(u)) * 4.0 * PI / f64::from(n * n);
            }
            assert!((sum - light.integral()).abs() <= 2e-3, "{light:?}: {sum}");
            let mut mean = 0.0;
            for i in 0..n * n {
                let u = [i / n, i % n].map(|k| (f64::from(k) + 0.5) / f64::from(n));
                let (direction, weight) = light.sample(u);
                assert!((direction.length() - 1.0).abs() <= 1e-12);
                mean += weight / f64::from(n * n);
            }
            assert!((mean - light.integral()).abs() <= 1e-5, "{light:?}: {mean}");
        }
    }

    #[test]
    fn samples_have_the_density_they_are_weighted_with() {
        // E over samples of weight g(direction) must be the integral of relative g, here for g =
        // x^2.
        for light in distributions() {
            let (n, mut by_samples, mut by_sphere) = (1000, 0.0, 0.0);
            for i in 0..n * n {
                let u = [i / n, i % n].map(|k| (f64::from(k) + 0.5) / f64::from(n));
                let (direction, weight) = light.sample(u);
                by_samples += weight * direction.x.powi(2) / f64::from(n * n);
                let all = sampling::uniform_sphere(u);
                by_sphere += light.relative(all) * all.x.powi(2) * 4.0 * PI / f64::from(n * n);
            }
            assert!((by_samples - by_sphere).abs() <= 2e-3, "{light:?}: {by_samples} {by_sphere}");
        }
    }
}
