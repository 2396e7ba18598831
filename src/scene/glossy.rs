//! Glossy reflection: GGX microfacets, and a base that reflects what they leave.
//!
//! f = F D G2 / (4 cos_i cos_o) + base t(cos_i) t(cos_o) / (pi mean t). The first term is single
//! reflection from microfacets of the GGX distribution with the height-correlated masking of Smith
//! (Heitz, "Understanding the Masking-Shadowing Function", JCGT 3(2), 2014), sampled by visible
//! normals (Dupuy and Benyoub 2023). It reflects less than it receives; t(cos) is what it leaves.
//! For a metal that is light reflected among the facets again, which the second term gives back
//! (Kulla and Conty 2017); under a clear coat it is light that enters, which a diffuse base
//! reflects (Kelemen and Szirmay-Kalos 2001). Both terms are symmetric in the two directions, and
//! together they reflect at most all: where nothing is absorbed, all.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::math::quadrature::Rule;
use crate::math::{Rgb, sampling};
use crate::{Error, Result};

use super::reflectance::check_reflectance;

/// A glossy surface, in local coordinates: z is the normal, directions point away from the surface
/// and have z > 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Glossy {
    fresnel: Fresnel,
    /// The width of the distribution of the microfacets' slopes: the square of the roughness.
    alpha: f64,
    base: Base,
    /// The luminance that the microfacets alone reflect of white light from a direction.
    lobe: ByCosine,
}

/// What lies below the microfacets: it reflects with f = reflectance t(cos_i) t(cos_o) / (pi mean
/// t).
#[derive(Debug, Clone, PartialEq)]
struct Base {
    /// The part of what it is left that it reflects, below 1.
    reflectance: Rgb,
    /// What the microfacets leave, t.
    left: ByCosine,
    /// Ascending sums over the cells of the table of 2 int t cos dcos; the last is the mean of t.
    cumulative: Vec<f64>,
}

/// How much a microfacet reflects.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fresnel {
    /// A metal by Schlick's approximation, F0 + (1 - F0)(1 - cos)^5.
    Metal(Rgb),
    /// A clear dielectric of this relative index of refraction, unpolarised.
    Dielectric(f64),
}

/// The smallest roughness: below, a surface is a mirror to the numbers used here.
pub const MIN_ROUGHNESS: f64 = 0.01;

impl Glossy {
    /// Makes a metal of a reflectance at normal incidence and a roughness.
    ///
    /// # Errors
    /// [`Error::Parameter`] when a component of the reflectance is outside [0, 1) or the roughness
    /// outside [[`MIN_ROUGHNESS`], 1].
    pub fn metal(reflectance: Rgb, roughness: f64) -> Result<Self> {
        check_reflectance(reflectance)?;
        Ok(Self::of_metal(reflectance, checked_alpha(roughness)?))
    }

    /// Makes a diffuse base of a reflectance under a clear coat of a relative index of refraction
    /// and a roughness.
    ///
    /// # Errors
    /// [`Error::Parameter`] when a component of the reflectance is outside [0, 1), the index
    /// outside (1, 4] or the roughness outside [[`MIN_ROUGHNESS`], 1].
    pub fn coated(reflectance: Rgb, index: f64, roughness: f64) -> Result<Self> {
        check_reflectance(reflectance)?;
        if !(index > 1.0 && index <= 4.0) {
            return Err(Error::Parameter(format!(
                "an index of refraction of a coat must be above 1 and at most 4, found {index}"
            )));
        }
        let alpha = checked_alpha(roughness)?;
        let fresnel = Fresnel::Dielectric(index);
        let lobe = ByCosine::tabulate(alpha, |cos| reflected(fresnel, alpha, cos));
        let base = Base::below(&lobe, |_| reflectance);
        Ok(Self { fresnel, alpha, base, lobe })
    }

    fn of_metal(reflectance: Rgb, alpha: f64) -> Self {
        let fresnel = Fresnel::Metal(reflectance);
        let lobe = ByCosine::tabulate(alpha, |cos| reflected(fresnel, alpha, cos));
        let all =
            ByCosine::tabulate(alpha, |cos| reflected(Fresnel::Metal(Rgb::WHITE), alpha, cos));
        // What is reflected again and again: the mean Fresnel factor once more each time
        // (Fdez-Aguera 2019).
        let again = |left: f64, f0: f64| {
            let f = f0 + (1.0 - f0) / 21.0;
            f * f * (1.0 - left) / (1.0 - f * left)
        };
        let base = Base::below(&all, |left| Rgb(reflectance.0.map(|f0| again(left, f0))));
        Self { fresnel, alpha, base, lobe }
    }

    /// Evaluates f, 1/sr; it is the same when the directions change places.
    pub(super) fn eval(&self, incident: DVec3, outgoing: DVec3) -> Rgb {
        let half = (incident + outgoing).normalize_or_zero();
        let height = distribution(half, self.alpha);
        let (i, o) = (incident.z, outgoing.z);
        let masking = 0.5 / (o * slope(i, self.alpha) + i * slope(o, self.alpha));
        let lobe = self.fresnel.at(half.dot(outgoing)) * (height * masking);
        lobe + self.base.eval(i, o)
    }

    /// Samples the direction light came from; `None` where the sampled facet sends it below the
    /// surface.
    pub(super) fn sample(&self, outgoing: DVec3, [u, v]: [f64; 2]) -> Option<DVec3> {
        let share = self.lobe_share(outgoing.z);
        let incident = if u < share {
            let half = visible_normal(outgoing, self.alpha, [u / share, v]);
            2.0 * outgoing.dot(half) * half - outgoing
        } else {
            self.base.sample([(u - share) / (1.0 - share), v])
        };
        (incident.z > 0.0).then_some(incident)
    }

    /// Returns the density per steradian of [`Glossy::sample`].
    pub(super) fn density(&self, incident: DVec3, outgoing: DVec3) -> f64 {
        let half = (incident + outgoing).normalize_or_zero();
        // G1 D / (4 cos_o), the density of the reflection about a visible normal.
        let visible =
            distribution(half, self.alpha) / (2.0 * (outgoing.z + slope(outgoing.z, self.alpha)));
        let share = self.lobe_share(outgoing.z);
        share * visible + (1.0 - share) * self.base.density(incident.z)
    }

    /// Returns the reflected part of the luminance of white light that leaves at this cosine to the
    /// normal.
    pub(super) fn albedo(&self, cos: f64) -> f64 {
        self.lobe.at(cos) + self.base.albedo(cos)
    }

    /// Returns the part of the samples that the microfacets take.
    fn lobe_share(&self, cos: f64) -> f64 {
        let lobe = self.lobe.at(cos);
        let all = lobe + self.base.albedo(cos);
        if all > 0.0 { lobe / all } else { 0.0 }
    }
}

impl Base {
    /// Puts a base below microfacets that reflect `lobe`; its reflectance may depend on the mean of
    /// what they leave.
    fn below(lobe: &ByCosine, reflectance: impl Fn(f64) -> Rgb) -> Self {
        // Never nothing, which could not be divided by.
        let left = lobe.values.iter().map(|f| (1.0 - f).max(1e-9)).collect();
        let left = ByCosine { values: left, ..*lobe };
        let sum = |sum: &mut f64, cell: usize| {
            let [low, high] = left.cell(cell);
            let rule = Rule::gauss_legendre(16).on(low, high);
            *sum += rule.integrate(|cos| 2.0 * cos * left.at(cos));
            Some(*sum)
        };
        let cumulative: Vec<f64> = (0..CELLS).scan(0.0, sum).collect();
        let mean = cumulative[CELLS - 1];
        Self { reflectance: reflectance(mean), left, cumulative }
    }

    fn mean_left(&self) -> f64 {
        self.cumulative[CELLS - 1]
    }

    fn eval(&self, incident: f64, outgoing: f64) -> Rgb {
        self.reflectance
            * (self.left.at(incident) * self.left.at(outgoing) / (PI * self.mean_left()))
    }

    fn albedo(&self, cos: f64) -> f64 {
        self.reflectance.luminance() * self.left.at(cos)
    }

    /// Samples a cell in proportion to what is left there, and by the cosine within.
    fn sample(&self, [u, v]: [f64; 2]) -> DVec3 {
        let (cell, rest) = sampling::discrete(&self.cumulative, u);
        let [low, high] = self.left.cell(cell).map(|cos| cos * cos);
        let cos2 = low + rest * (high - low);
        let (sin, cos) = (TAU * v).sin_cos();
        let r = (1.0 - cos2).max(0.0).sqrt();
        DVec3::new(r * cos, r * sin, cos2.sqrt())
    }

    fn density(&self, cos: f64) -> f64 {
        let cell = self.left.place(cos).0;
        let below = if cell == 0 { 0.0 } else { self.cumulative[cell - 1] };
        let share = (self.cumulative[cell] - below) / self.mean_left();
        let [low, high] = self.left.cell(cell);
        share * cos / (PI * (high * high - low * low))
    }
}

impl Fresnel {
    fn at(self, cos: f64) -> Rgb {
        match self {
            Self::Metal(f0) => {
                let grazing = (1.0 - cos).clamp(0.0, 1.0).powi(5);
                f0 + (Rgb::WHITE - f0) * grazing
            }
            Self::Dielectric(index) => {
                let inside = (1.0 - (1.0 - cos * cos) / (index * index)).sqrt();
                let s = (cos - index * inside) / (cos + index * inside);
                let p = (inside - index * cos) / (inside + index * cos);
                Rgb::grey(0.5 * (s * s + p * p))
            }
        }
    }
}

fn checked_alpha(roughness: f64) -> Result<f64> {
    if (MIN_ROUGHNESS..=1.0).contains(&roughness) {
        return Ok(roughness * roughness);
    }
    Err(Error::Parameter(format!(
        "a roughness must be from {MIN_ROUGHNESS} to 1, found {roughness}"
    )))
}

/// Returns the density D of microfacet normals at a unit vector, 1/sr.
fn distribution(half: DVec3, alpha: f64) -> f64 {
    // 1 - z^2 as x^2 + y^2 keeps its digits for the smoothest surfaces.
    let base = alpha * alpha * half.z * half.z + half.x * half.x + half.y * half.y;
    alpha * alpha / (PI * base * base)
}

/// Returns sqrt(alpha^2 + (1 - alpha^2) cos^2), of which Smith's masking is made: G1 = 2 cos /
/// (cos + slope).
fn slope(cos: f64, alpha: f64) -> f64 {
    (alpha * alpha + (1.0 - alpha * alpha) * cos * cos).sqrt()
}

/// Samples a microfacet normal among those that `outgoing` sees.
fn visible_normal(outgoing: DVec3, alpha: f64, [u, v]: [f64; 2]) -> DVec3 {
    let stretched = DVec3::new(alpha * outgoing.x, alpha * outgoing.y, outgoing.z).normalize();
    let z = (1.0 - u) * (1.0 + stretched.z) - stretched.z;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (TAU * v).sin_cos();
    let h = DVec3::new(r * cos, r * sin, z) + stretched;
    DVec3::new(alpha * h.x, alpha * h.y, h.z.max(0.0)).normalize_or(DVec3::Z)
}

/// Integrates what the microfacets reflect of the luminance that leaves at a cosine: the mean of F
/// G2 / G1 over visible normals.
fn reflected(fresnel: Fresnel, alpha: f64, cos: f64) -> f64 {
    let outgoing = DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let heights = Rule::gauss_legendre(NODES_PER_AXIS).on(0.0, 1.0);
    // The azimuth is symmetric about the plane of incidence.
    let azimuths = Rule::gauss_legendre(NODES_PER_AXIS).on(0.0, 0.5);
    let mut sum = 0.0;
    for (root, weight) in heights.iter() {
        // The facets near u = 1 lie most aslant; nodes are denser there.
        let (u, weight) = (1.0 - root * root, 2.0 * root * weight);
        for (v, weight_v) in azimuths.iter() {
            let half = visible_normal(outgoing, alpha, [u, v]);
            let incident = 2.0 * outgoing.dot(half) * half - outgoing;
            if incident.z > 0.0 {
                let (i, o) = (slope(incident.z, alpha), slope(cos, alpha));
                let masking = incident.z * (cos + o) / (cos * i + incident.z * o);
                sum +=
                    2.0 * weight * weight_v * masking * fresnel.at(half.dot(outgoing)).luminance();
            }
        }
    }
    sum
}

/// Quadrature nodes for each of the two axes, and cells of a table: what is reflected is good to
/// 4e-4; facets that reflect below the horizon end the smoothness of the integrand.
const NODES_PER_AXIS: usize = 48;
const CELLS: usize = 128;

/// A function of the cosine, linear between tabulated values in the mean x of cos and (1 + alpha)
/// cos / (alpha + cos): it changes where the cosine is some alpha by masking, and everywhere by
/// Fresnel's law.
#[derive(Debug, Clone, PartialEq)]
struct ByCosine {
    alpha: f64,
    values: Vec<f64>,
}

impl ByCosine {
    fn tabulate(alpha: f64, f: impl Fn(f64) -> f64) -> Self {
        // At grazing itself the limit is 0 / 0; a cosine far below alpha stands for it.
        let cos = |i: usize| Self::cos(alpha, i as f64 / CELLS as f64).max(1e-3 * alpha);
        Self { alpha, values: (0..=CELLS).map(|i| f(cos(i))).collect() }
    }

    fn cos(alpha: f64, x: f64) -> f64 {
        let b = 1.0 + 2.0 * alpha - 2.0 * x;
        let root = (b * b + 8.0 * alpha * x).sqrt();
        if b > 0.0 { 4.0 * alpha * x / (b + root) } else { 0.5 * (root - b) }
    }

    /// Returns the ends of a cell.
    fn cell(&self, cell: usize) -> [f64; 2] {
        [cell, cell + 1].map(|i| Self::cos(self.alpha, i as f64 / CELLS as f64))
    }

    /// Returns the cell of a cosine and the place in it, 0 to 1.
    fn place(&self, cos: f64) -> (usize, f64) {
        let cos = cos.clamp(0.0, 1.0);
        let x = 0.5 * (cos + (1.0 + self.alpha) * cos / (self.alpha + cos)) * CELLS as f64;
        let cell = (x as usize).min(CELLS - 1);
        (cell, x - cell as f64)
    }

    fn at(&self, cos: f64) -> f64 {
        let (cell, t) = self.place(cos);
        self.values[cell] * (1.0 - t) + self.values[cell + 1] * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surfaces() -> Vec<Glossy> {
        let gold = Rgb([0.9, 0.7, 0.3]);
        let metals = [0.05, 0.3, 0.6, 1.0].map(|r| Glossy::metal(gold, r).expect("valid"));
        let coats = [0.1, 0.5].map(|r| Glossy::coated(gold, 1.5, r).expect("valid"));
        metals.into_iter().chain(coats).collect()
    }

    fn direction(cos: f64, azimuth: f64) -> DVec3 {
        let sin = (1.0 - cos * cos).sqrt();
        DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
    }

    /// Averages over a midpoint grid of the unit square.
    fn mean(n: u32, f: impl Fn([f64; 2]) -> f64) -> f64 {
        let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
        let sum: f64 = (0..n * n).map(|k| f([middle(k / n), middle(k % n)])).sum();
        sum / f64::from(n * n)
    }

    /// Averages f cos / density over samples, both lobes apart so that the grid meets no jump.
    fn mean_weight(surface: &Glossy, outgoing: DVec3) -> f64 {
        let weight = |u| {
            surface.sample(outgoing, u).map_or(0.0, |i| {
                surface.eval(i, outgoing).luminance() * i.z / surface.density(i, outgoing)
            })
        };
        let share = surface.lobe_share(outgoing.z);
        let lobe = mean(300, |[u, v]| weight([u * share, v]));
        let base = mean(300, |[u, v]| weight([share + u * (1.0 - share), v]));
        share * lobe + (1.0 - share) * base
    }

    #[test]
    fn directions_may_change_places() {
        for surface in surfaces() {
            for (a, b) in [(0.9, 0.2), (0.01, 0.6), (1e-4, 1e-3), (1.0, 1.0)] {
                let (a, b) = (direction(a, 0.3), direction(b, 2.0));
                let [there, back] = [surface.eval(a, b), surface.eval(b, a)];
                for (x, y) in there.0.into_iter().zip(back.0) {
                    assert!(x > 0.0 && x.is_finite() && (x - y).abs() <= 1e-9 * x, "{x} {y}");
                }
            }
        }
    }

    #[test]
    fn samples_have_the_density_they_are_weighted_with() {
        // The mean of x^2 over samples against its integral with the density, on a grid that sees
        // lobes of this width.
        for surface in surfaces().into_iter().filter(|s| s.alpha >= 0.09) {
            for cos in [0.15, 0.5, 0.95] {
                let outgoing = direction(cos, 0.7);
                let by_samples =
                    mean(500, |u| surface.sample(outgoing, u).map_or(0.0, |i| i.x * i.x));
                let by_density = mean(1000, |u| {
                    let i = sampling::uniform_cone(0.0, u);
                    i.x * i.x * surface.density(i, outgoing) * TAU
                });
                assert!((by_samples - by_density).abs() <= 2e-3, "{by_samples} {by_density}");
            }
        }
    }

    #[test]
    fn albedo_is_the_mean_weight_and_below_one() {
        for surface in surfaces() {
            for cos in [0.02, 0.15, 0.5, 0.95] {
                let outgoing = direction(cos, 0.7);
                let weight = mean_weight(&surface, outgoing);
                let albedo = surface.albedo(cos);
                assert!(
                    albedo < 1.0 && (weight - albedo).abs() <= 1e-3,
                    "{} {cos}: {weight} {albedo}",
                    surface.alpha
                );
            }
        }
    }

    #[test]
    fn what_absorbs_nothing_reflects_all() {
        let white = Rgb::grey(1.0 - 1e-12);
        for roughness in [MIN_ROUGHNESS, 0.1, 0.4, 0.7, 1.0] {
            for surface in [Glossy::metal(white, roughness), Glossy::coated(white, 1.5, roughness)]
            {
                let surface = surface.expect("valid");
                for cos in [0.003, 0.1, 0.5, 1.0] {
                    let outgoing = direction(cos, 0.0);
                    let weight = mean_weight(&surface, outgoing);
                    // The tables are good to 4e-4, the grid of samples to some 1e-3 at grazing.
                    assert!((weight - 1.0).abs() <= 2e-3, "{roughness} {cos}: {weight}");
                }
            }
        }
    }

    #[test]
    fn coat_reflects_as_glass_does() {
        let coat = Fresnel::Dielectric(1.5);
        assert!((coat.at(1.0).luminance() - 0.04).abs() <= 1e-15);
        assert!((coat.at(0.0).luminance() - 1.0).abs() <= 1e-15);
        // Brewster's angle, where one polarisation is not reflected: half of the other.
        let brewster = 1.5_f64.atan().cos();
        let s = ((1.0 - 2.25) / (1.0 + 2.25_f64)).powi(2);
        assert!((coat.at(brewster).luminance() - 0.5 * s).abs() <= 1e-15);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let grey = Rgb::grey(0.5);
        for roughness in [0.0, 0.009, 1.1, -1.0, f64::NAN] {
            assert!(Glossy::metal(grey, roughness).is_err());
            assert!(Glossy::coated(grey, 1.5, roughness).is_err());
        }
        for index in [1.0, 0.5, 4.1, f64::NAN, f64::INFINITY] {
            assert!(Glossy::coated(grey, index, 0.5).is_err());
        }
        assert!(Glossy::metal(Rgb::WHITE, 0.5).is_err());
    }
}
