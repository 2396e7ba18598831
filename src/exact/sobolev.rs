//! The Sobolev problem: an isotropic point source between two infinite parallel Lambert planes.
//!
//! Follows V. V. Sobolev's solution as quoted in eq. (7) of Budak, Zheltov, Kalakutsky 2012, with
//! its misprint corrected: the factor K1(k) J0(kr) k^2 multiplies both terms of the bracket. In
//! units of the gap, with q(k) = k K1(k) and D = 1 - rho1 rho2 q^2,
//!
//! E1(r) = h1/(h1^2 + r^2)^1.5 + rho2 int_0^inf [rho1 q e^(-h1 k) + e^(-h2 k)] q k J0(kr)/D dk,
//!
//! and E2 by exchange of the indices. Finite discs instead of planes:
//! [`SobolevDiscs`](super::SobolevDiscs).

use std::f64::consts::PI;

use pxfm::{f_j0, f_k1};

use super::ranges::{accept, not_negative, positive, reflectance};
use crate::math::quadrature::Rule;
use crate::{Error, Result};

/// Names one of the two planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plane {
    /// The plane z = 0, the paper's plane 1; the source height is counted from it.
    Lower,
    /// The plane z = gap, the paper's plane 2.
    Upper,
}

impl Plane {
    /// Returns the place of this plane in arrays of two.
    pub(super) const fn index(self) -> usize {
        self as usize
    }

    /// Returns the opposite plane.
    pub(super) const fn other(self) -> Self {
        match self {
            Self::Lower => Self::Upper,
            Self::Upper => Self::Lower,
        }
    }
}

/// Describes two parallel Lambert planes with an isotropic point source between them.
///
/// ```
/// use harmolux::exact::{Plane, SobolevProblem};
///
/// let reflectance = [0.8, 0.3];
/// let problem = SobolevProblem { reflectance, source_height: 0.7, ..Default::default() };
/// let below_the_source = problem.illuminance(Plane::Lower, 0.0)?;
/// assert!((below_the_source - 2.472169062193).abs() <= 1e-12);
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SobolevProblem {
    /// The reflectances of the lower and the upper plane, each in [0, 1]; infinite planes need a
    /// product below 1.
    pub reflectance: [f64; 2],
    /// The height of the source over the lower plane, metres, between 0 and `gap`.
    pub source_height: f64,
    /// The distance of the planes, metres, above 0.
    pub gap: f64,
    /// The intensity of the source, cd, the same in all directions; at least 0.
    pub intensity: f64,
}

/// Case A of the references: both reflectances 0.5, the source half way, gap and intensity 1.
impl Default for SobolevProblem {
    fn default() -> Self {
        Self { reflectance: [0.5; 2], source_height: 0.5, gap: 1.0, intensity: 1.0 }
    }
}

/// The Hankel integrals are cut here: all of them decay at least as k^1.5 e^-k, which is 1e-17 at
/// this wave number.
const CUT: f64 = 45.0;
/// The largest distance, in gaps, for which the oscillations of J0 are followed.
const FARTHEST: f64 = 1000.0;

impl SobolevProblem {
    /// Returns the illuminance, lx, at distance `r` (metres, 0 to 1000 gaps) from the foot of the
    /// source on infinite planes.
    ///
    /// The absolute error is about 1e-13 intensity/gap^2; a call costs about a millisecond.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a field or `r` outside its range; the product of the reflectances
    /// must be below 1.
    pub fn illuminance(&self, plane: Plane, r: f64) -> Result<f64> {
        Ok(self.direct(plane, r)? + self.indirect(plane, r)?)
    }

    /// Returns the luminance, cd/m2, of `plane` at distance `r`, rho E/pi, the same in all
    /// directions.
    ///
    /// # Errors
    /// As [`SobolevProblem::illuminance`].
    pub fn luminance(&self, plane: Plane, r: f64) -> Result<f64> {
        Ok(self.reflectance[plane.index()] * self.illuminance(plane, r)? / PI)
    }

    /// Returns the part of the illuminance, lx, that comes straight from the source: I h/(h^2 +
    /// r^2)^1.5.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a field or `r` outside its range.
    pub fn direct(&self, plane: Plane, r: f64) -> Result<f64> {
        self.check()?;
        not_negative("the distance r", r)?;
        Ok(self.unit() * direct(self.heights()[plane.index()], r / self.gap))
    }

    /// Returns the part of the illuminance, lx, that was reflected at least once.
    ///
    /// # Errors
    /// As [`SobolevProblem::illuminance`].
    pub fn indirect(&self, plane: Plane, r: f64) -> Result<f64> {
        self.check()?;
        self.check_infinite()?;
        let (own, other) = (plane.index(), plane.other().index());
        let (rho, h) = (self.reflectance, self.heights());
        let product = rho[0] * rho[1];
        let integral = self.hankel(r, |k| {
            let q = k * f_k1(k);
            let bracket = rho[own] * q * (-h[own] * k).exp() + (-h[other] * k).exp();
            bracket * q / (1.0 - product * q * q)
        })?;
        Ok(self.unit() * rho[other] * integral)
    }

    /// Returns the illuminance, lx, by light reflected exactly `order` times; order 0 is the direct
    /// part.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a field or `r` outside its range.
    pub fn order(&self, plane: Plane, order: u16, r: f64) -> Result<f64> {
        self.check()?;
        if order == 0 {
            return self.direct(plane, r);
        }
        let (own, other) = (plane.index(), plane.other().index());
        let m = i32::from(order);
        let coefficient =
            self.reflectance[other].powi((m + 1) / 2) * self.reflectance[own].powi(m / 2);
        // The first reflection happens on the other plane when their number is odd.
        let h = self.heights()[if m % 2 == 1 { other } else { own }];
        let integral = self.hankel(r, |k| (-h * k).exp() * (k * f_k1(k)).powi(m))?;
        Ok(self.unit() * coefficient * integral)
    }

    /// Integrates f(k) J0(kr) k over k, r in metres.
    fn hankel(&self, r: f64, f: impl Fn(f64) -> f64) -> Result<f64> {
        let r = r / self.gap;
        let range = "at least 0 and at most 1000 gaps for infinite planes";
        accept((0.0..=FARTHEST).contains(&r), "the distance r, in gaps,", r, range)?;
        let base = Rule::gauss_legendre(16);
        let panels = panels(r).map(|(a, b)| (0.5 * (b - a), 0.5 * (a + b)));
        let integrand = |k: f64| f(k) * f_j0(k * r) * k;
        Ok(panels.map(|(half, mid)| half * base.integrate(|x| integrand(mid + half * x))).sum())
    }

    /// Returns the heights of the source over the two planes in units of the gap.
    pub(super) fn heights(&self) -> [f64; 2] {
        let h = self.source_height / self.gap;
        [h, (self.gap - self.source_height) / self.gap]
    }

    /// Returns the illuminance that stands for 1 in units of gap and intensity.
    pub(super) fn unit(&self) -> f64 {
        self.intensity / (self.gap * self.gap)
    }

    /// Rejects fields outside the ranges that hold for planes and discs alike.
    pub(super) fn check(&self) -> Result<()> {
        reflectance("the reflectance of the lower plane", self.reflectance[0])?;
        reflectance("the reflectance of the upper plane", self.reflectance[1])?;
        positive("the gap", self.gap)?;
        not_negative("the intensity", self.intensity)?;
        let h = self.source_height;
        accept(h > 0.0 && h < self.gap, "the source height", h, "between 0 and the gap")
    }

    /// Rejects infinite planes that absorb nothing: the integral diverges.
    fn check_infinite(&self) -> Result<()> {
        if self.reflectance[0] * self.reflectance[1] < 1.0 {
            return Ok(());
        }
        Err(Error::Parameter(
            "two infinite planes of reflectance 1 have no finite illuminance; lower one of them, \
             or take finite discs"
                .into(),
        ))
    }
}

/// Returns the direct illuminance h/(h^2 + r^2)^1.5 of a unit source at height h.
pub(super) fn direct(h: f64, r: f64) -> f64 {
    let square = h * h + r * r;
    h / (square * square.sqrt())
}

/// Lists panels (from, to) of (0, CUT): doubling away from the logarithm at 0, then short enough
/// for J0(kr).
fn panels(r: f64) -> impl Iterator<Item = (f64, f64)> {
    let widest = 0.5_f64.min(8.0 / r);
    let first = (0.0, 0.5_f64.powi(24));
    std::iter::successors(Some(first), move |&(_, k)| (k < CUT).then_some((k, k + k.min(widest))))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::SQRT_2;

    use super::*;

    const B: SobolevProblem =
        SobolevProblem { reflectance: [0.8, 0.3], source_height: 0.7, gap: 1.0, intensity: 1.0 };

    /// The references are printed to 12 decimals; quadrature adds less than the last of them.
    const PRINTED: f64 = 1e-12;

    #[test]
    fn senseless_parameters_are_refused() {
        let a = SobolevProblem::default();
        for wrong in [
            SobolevProblem { reflectance: [1.0, 1.0], ..a },
            SobolevProblem { reflectance: [1.1, 0.2], ..a },
            SobolevProblem { reflectance: [f64::NAN, 0.2], ..a },
            SobolevProblem { source_height: 0.0, ..a },
            SobolevProblem { source_height: 1.0, ..a },
            SobolevProblem { gap: 0.0, ..a },
            SobolevProblem { intensity: -1.0, ..a },
        ] {
            let answer = wrong.illuminance(Plane::Lower, 0.0);
            assert!(matches!(answer, Err(Error::Parameter(_))), "{wrong:?}");
        }
        for r in [-1.0, f64::NAN, f64::INFINITY, 2000.0] {
            assert!(a.illuminance(Plane::Upper, r).is_err(), "{r}");
        }
    }

    #[test]
    fn black_opposite_plane_leaves_direct_light_only() {
        let p = SobolevProblem { reflectance: [0.9, 0.0], ..B };
        assert_eq!(p.indirect(Plane::Lower, 0.5).unwrap(), 0.0);
        assert!(p.indirect(Plane::Upper, 0.5).unwrap() > 0.0);
        assert_eq!(p.luminance(Plane::Upper, 0.5).unwrap(), 0.0);
    }

    #[test]
    fn case_a_is_the_printed_table() {
        let a = SobolevProblem::default();
        for (r, total, direct) in [
            (0.0, 4.528_129_525_817, 4.0),
            (0.25, 3.367_492_450_477, 2.862_167_011_200),
            (0.5, 1.860_290_080_710, SQRT_2),
            (1.0, 0.653_442_317_194, 0.357_770_876_400),
            (1.5, 0.306_312_045_082, 0.126_491_106_407),
            (2.0, 0.166_497_749_941, 0.057_067_205_891),
            (3.0, 0.062_150_240_621, 0.017_772_863_492),
            (4.0, 0.028_066_583_982, 0.007_632_906_744),
            (5.0, 0.014_392_632_466, 0.003_940_741_347),
            (10.0, 0.001_509_430_494, 0.000_498_130_842),
        ] {
            for plane in [Plane::Lower, Plane::Upper] {
                let error = (a.illuminance(plane, r).unwrap() - total).abs();
                assert!(error <= PRINTED, "r = {r}: {error:e}");
                assert!((a.direct(plane, r).unwrap() - direct).abs() <= PRINTED);
            }
        }
    }

    #[test]
    fn case_b_is_the_printed_table() {
        for (r, lower, upper) in [
            (0.0, 2.472_169_062_193, 11.745_207_517_055),
            (0.25, 2.111_673_591_448, 5.649_179_743_003),
            (0.5, 1.446_906_507_573, 2.064_802_456_850),
            (1.0, 0.597_786_635_546, 0.649_601_635_131),
            (1.5, 0.278_627_603_911, 0.327_592_826_674),
            (2.0, 0.148_618_680_592, 0.187_174_413_967),
            (3.0, 0.054_784_166_608, 0.072_677_877_713),
            (5.0, 0.012_835_717_407, 0.017_076_336_785),
        ] {
            assert!((B.illuminance(Plane::Lower, r).unwrap() - lower).abs() <= PRINTED, "r = {r}");
            assert!((B.illuminance(Plane::Upper, r).unwrap() - upper).abs() <= PRINTED, "r = {r}");
        }
    }

    #[test]
    fn orders_are_the_printed_ones() {
        let a = SobolevProblem::default();
        let printed = [
            (
                0.0,
                [
                    4.0,
                    0.387_733_898,
                    0.093_782_800,
                    0.029_420_251,
                    0.010_447_376,
                    0.003_988_756,
                    0.001_596_907,
                ],
            ),
            (
                1.0,
                [
                    0.357_770_876,
                    0.190_058_686,
                    0.066_525_063,
                    0.023_888_159,
                    0.009_052_821,
                    0.003_585_912,
                    0.001_469_242,
                ],
            ),
        ];
        for (r, values) in printed {
            for (m, value) in (0..).zip(values) {
                // Printed to nine decimals.
                assert!((a.order(Plane::Lower, m, r).unwrap() - value).abs() <= 5.1e-10, "{m} {r}");
            }
        }
    }

    #[test]
    fn orders_add_up_to_the_whole() {
        for plane in [Plane::Lower, Plane::Upper] {
            let sum: f64 = (0..50).map(|m| B.order(plane, m, 0.8).unwrap()).sum();
            // Each pair of reflections leaves at most 0.24 of the light: 0.24^25 is 3e-16.
            assert!((sum - B.illuminance(plane, 0.8).unwrap()).abs() <= 1e-13);
        }
    }

    #[test]
    fn flux_on_a_plane_is_the_closed_form() {
        let edge = |i: i32| 0.01 * (1.25_f64.powi(i) - 1.0);
        let panel = |i: i32| Rule::gauss_legendre(8).on(edge(i), edge(i + 1));
        let end = edge(40);
        let p = SobolevProblem { reflectance: [0.2, 0.3], source_height: 0.7, ..B };
        let ring = |r: f64| 2.0 * PI * r * p.illuminance(Plane::Lower, r).unwrap();
        let inside: f64 = (0..40).map(|i| panel(i).integrate(ring)).sum();
        let whole = 2.0 * PI * (1.0 + 0.3) / (1.0 - 0.06);
        // Far away E = c/r^3 + d/r^4 + O(ln r/r^5); c and d from two points leave 1e-3 of a tail
        // that is 1e-2 of the whole.
        let cubed = |r: f64| r.powi(3) * p.illuminance(Plane::Lower, r).unwrap();
        let d = 2.0 * end * (cubed(end) - cubed(2.0 * end));
        let tail = 2.0 * PI * (cubed(end) / end - 0.5 * d / (end * end));
        let share = (inside + tail) / whole;
        assert!((share - 1.0).abs() <= 1e-5, "{share}");
    }

    #[test]
    fn gap_and_intensity_scale() {
        let scaled = SobolevProblem { source_height: 2.1, gap: 3.0, intensity: 90.0, ..B };
        let (big, small) =
            (scaled.illuminance(Plane::Upper, 1.5), B.illuminance(Plane::Upper, 0.5));
        assert!((big.unwrap() / 10.0 - small.unwrap()).abs() <= 1e-13);
    }

    #[test]
    fn turning_the_problem_over_exchanges_the_planes() {
        let turned = SobolevProblem { reflectance: [0.3, 0.8], source_height: 0.3, ..B };
        let pair = (turned.illuminance(Plane::Lower, 0.7), B.illuminance(Plane::Upper, 0.7));
        assert!((pair.0.unwrap() - pair.1.unwrap()).abs() <= 1e-13);
    }

    #[test]
    fn nearly_white_planes_and_grazing_sources_stay_finite() {
        let p = SobolevProblem { reflectance: [1.0, 0.999_99], source_height: 1e-3, ..B };
        let near = p.illuminance(Plane::Lower, 0.0).unwrap();
        assert!(near.is_finite() && near > 1e6);
        assert!(p.illuminance(Plane::Upper, 900.0).unwrap() > 0.0);
    }
}
