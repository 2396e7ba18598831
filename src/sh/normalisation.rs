//! Conversions between the internal basis and the conventions of pyshtools.
//!
//! The internal coefficients are Schmidt semi-normalised with the Condon-Shortley phase and without
//! sqrt(2) (see [`Coefficients`](super::Coefficients)). With d = 1 at m = 0, else 0, and c = (-1)^m
//! for a target without the phase, else 1, A_lm times the factor below gives the cosine coefficient
//! of the target, and B_lm the sine coefficient:
//!
//! | target | factor |
//! |---|---|
//! | 4pi | c / sqrt((2-d)(2l+1)) |
//! | ortho | c sqrt(4 pi) / sqrt((2-d)(2l+1)) |
//! | schmidt | c / sqrt(2-d) |
//! | unnorm | c sqrt((l-m)!/(l+m)!) |

use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::fmt;
use std::str::FromStr;

use crate::{Error, Result};

/// Names how the basis functions of a coefficient file are scaled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Normalisation {
    /// Mean square over the sphere 1: geodesy's 4 pi normalisation, the default of pyshtools.
    #[default]
    FourPi,
    /// Integral of the square over the sphere 1.
    Orthonormal,
    /// Mean square 1/(2l+1): Schmidt semi-normalised, with the sqrt(2) at m > 0 that the internal
    /// basis lacks.
    Schmidt,
    /// Plain associated Legendre functions; coefficients leave the range of f64 near degree 150,
    /// and pyshtools stops at 85.
    Unnormalised,
}

impl Normalisation {
    /// Lists all, in the order of the names `4pi`, `ortho`, `schmidt`, `unnorm`.
    pub const ALL: [Self; 4] = [Self::FourPi, Self::Orthonormal, Self::Schmidt, Self::Unnormalised];

    /// Returns the name that pyshtools uses.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FourPi => "4pi",
            Self::Orthonormal => "ortho",
            Self::Schmidt => "schmidt",
            Self::Unnormalised => "unnorm",
        }
    }
}

impl fmt::Display for Normalisation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Normalisation {
    type Err = Error;

    /// Reads the name that pyshtools uses; [`Error::Parameter`] for any other word.
    fn from_str(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|n| n.name() == name).ok_or_else(|| {
            Error::Parameter(format!(
                "`{name}` is not a normalisation: use 4pi, ortho, schmidt or unnorm"
            ))
        })
    }
}

/// Whether the basis functions carry the Condon-Shortley factor (-1)^m.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CondonShortley {
    /// No factor: csphase = 1 of pyshtools, its default.
    #[default]
    Without,
    /// The factor is part of the basis, as in the internal one: csphase = -1.
    With,
}

impl CondonShortley {
    /// Returns the `csphase` of pyshtools: 1 without, -1 with the phase.
    pub const fn csphase(self) -> i32 {
        match self {
            Self::Without => 1,
            Self::With => -1,
        }
    }
}

impl FromStr for CondonShortley {
    type Err = Error;

    /// Reads a `csphase` of pyshtools, 1 or -1; [`Error::Parameter`] for anything else.
    fn from_str(csphase: &str) -> Result<Self> {
        match csphase {
            "1" | "+1" => Ok(Self::Without),
            "-1" => Ok(Self::With),
            _ => Err(Error::Parameter(format!(
                "`{csphase}` is not a csphase: use 1 (without the Condon-Shortley phase) or -1 \
                 (with it)"
            ))),
        }
    }
}

/// Says how the coefficients of a file are to be understood; the default is that of pyshtools, 4pi
/// without phase.
///
/// ```
/// use harmolux::sh::{CondonShortley, Convention, Normalisation};
///
/// let file = Convention { normalisation: Normalisation::FourPi, phase: CondonShortley::Without };
/// assert_eq!(file, Convention::default());
/// let (c, s) = file.export(1, 1, (0.5, 0.25))?;
/// assert!((c + 0.5 / 6.0_f64.sqrt()).abs() < 1e-15);
/// assert!((file.import(1, 1, (c, s))?.1 - 0.25).abs() < 1e-15);
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Convention {
    /// The scale of the basis functions.
    pub normalisation: Normalisation,
    /// Their sign at odd orders.
    pub phase: CondonShortley,
}

impl Convention {
    /// Returns what A_lm and B_lm are multiplied with to become coefficients of this convention (0
    /// <= m <= l).
    ///
    /// # Errors
    /// [`Error::Numeric`] where the unnormalised factor leaves the normal range of f64 (from degree
    /// 151 on, at high orders).
    pub fn factor(self, l: usize, m: usize) -> Result<f64> {
        let doubled = if m == 0 { 1.0 } else { 2.0 };
        let magnitude = match self.normalisation {
            Normalisation::FourPi => 1.0 / (doubled * (2 * l + 1) as f64).sqrt(),
            Normalisation::Orthonormal => (4.0 * PI / (doubled * (2 * l + 1) as f64)).sqrt(),
            Normalisation::Schmidt if m == 0 => 1.0,
            Normalisation::Schmidt => FRAC_1_SQRT_2,
            Normalisation::Unnormalised => unnormalised(l, m)?,
        };
        let negative = self.phase == CondonShortley::Without && m % 2 == 1;
        Ok(if negative { -magnitude } else { magnitude })
    }

    /// Turns the internal (A_lm, B_lm) into the (cosine, sine) coefficients of this convention.
    ///
    /// # Errors
    /// As [`Convention::factor`].
    pub fn export(self, l: usize, m: usize, (a, b): (f64, f64)) -> Result<(f64, f64)> {
        let factor = self.factor(l, m)?;
        Ok((a * factor, b * factor))
    }

    /// Turns (cosine, sine) coefficients of this convention into the internal (A_lm, B_lm): undoes
    /// [`Convention::export`] to 2 units in the last place, or exactly where the factor is 1 or -1.
    ///
    /// # Errors
    /// As [`Convention::factor`]; also [`Error::Numeric`] when the result overflows f64.
    pub fn import(self, l: usize, m: usize, (c, s): (f64, f64)) -> Result<(f64, f64)> {
        let factor = self.factor(l, m)?;
        let (a, b) = (c / factor, s / factor);
        if a.is_finite() && b.is_finite() {
            return Ok((a, b));
        }
        Err(Error::Numeric(format!(
            "the {} coefficients ({c:e}, {s:e}) of degree {l}, order {m} exceed the range of f64 \
             in the internal basis",
            self.normalisation
        )))
    }
}

/// Computes sqrt((l-m)!/(l+m)!) from the 2m factors that do not cancel; the relative error is below
/// m 2^-51.
fn unnormalised(l: usize, m: usize) -> Result<f64> {
    let mut value = 1.0;
    for k in l - m + 1..=l + m {
        value /= (k as f64).sqrt();
        if value < f64::MIN_POSITIVE {
            return Err(Error::Numeric(format!(
                "unnormalised coefficients of degree {l}, order {m} are outside the range of f64: \
                 use the normalisation 4pi, ortho or schmidt (pyshtools takes unnorm only up to \
                 degree 85)"
            )));
        }
    }
    Ok(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sh::Coefficients;
    use proptest::prelude::*;

    fn conventions() -> impl Iterator<Item = Convention> {
        Normalisation::ALL.into_iter().flat_map(|normalisation| {
            [CondonShortley::Without, CondonShortley::With]
                .map(|phase| Convention { normalisation, phase })
        })
    }

    /// The made-up 4pi, csphase 1 coefficients that pyshtools 4.14.1 was given for the numbers
    /// below.
    fn sample(l: usize, m: usize) -> (f64, f64) {
        let sign = if (l / 2).is_multiple_of(2) { 1.0 } else { -1.0 };
        let s = if m == 0 { 0.0 } else { 1.0 / (2 + 2 * l + m) as f64 };
        (sign / (1 + l + 2 * m) as f64, s)
    }

    #[test]
    fn degree_zero_is_the_mean_everywhere_but_in_ortho() {
        for convention in conventions() {
            let factor = convention.factor(0, 0).expect("in range");
            let expected = if convention.normalisation == Normalisation::Orthonormal {
                (4.0 * PI).sqrt()
            } else {
                1.0
            };
            assert!((factor - expected).abs() <= f64::EPSILON * expected);
        }
    }

    #[test]
    fn low_degrees_match_closed_forms() {
        let factor = |normalisation, l, m| {
            Convention { normalisation, phase: CondonShortley::With }
                .factor(l, m)
                .expect("in range")
        };
        for (found, squared) in [
            (factor(Normalisation::FourPi, 1, 0), 1.0 / 3.0),
            (factor(Normalisation::FourPi, 2, 1), 1.0 / 10.0),
            (factor(Normalisation::Orthonormal, 2, 2), 4.0 * PI / 10.0),
            (factor(Normalisation::Schmidt, 7, 0), 1.0),
            (factor(Normalisation::Schmidt, 7, 3), 0.5),
            (factor(Normalisation::Unnormalised, 1, 1), 1.0 / 2.0),
            (factor(Normalisation::Unnormalised, 2, 1), 1.0 / 6.0),
            (factor(Normalisation::Unnormalised, 3, 3), 1.0 / 720.0),
        ] {
            // A handful of roundings.
            assert!((found * found / squared - 1.0).abs() <= 2e-15);
        }
    }

    #[test]
    fn phase_is_the_sign_of_odd_orders() {
        for normalisation in Normalisation::ALL {
            let factor = |phase, m| Convention { normalisation, phase }.factor(4, m).expect("fits");
            for m in 0..=4 {
                let sign = if m % 2 == 1 { -1.0 } else { 1.0 };
                assert_eq!(
                    factor(CondonShortley::Without, m),
                    sign * factor(CondonShortley::With, m)
                );
            }
        }
    }

    #[test]
    fn degree_12_matches_pyshtools() {
        let expected = [
            ("4pi", 1, 12, 5, 0.043_478_260_869_565_216, 0.032_258_064_516_129_03),
            ("4pi", -1, 12, 5, -0.043_478_260_869_565_216, -0.032_258_064_516_129_03),
            ("4pi", 1, 12, 12, 0.027_027_027_027_027_03, 0.026_315_789_473_684_21),
            ("ortho", 1, 1, 1, 0.886_226_925_452_757_9, 0.708_981_540_362_206_4),
            ("ortho", 1, 3, 0, -0.886_226_925_452_757_9, 0.0),
            ("ortho", 1, 12, 5, 0.154_126_421_817_870_95, 0.114_351_861_348_742_95),
            ("ortho", -1, 12, 12, 0.095_808_316_265_163_02, 0.093_287_044_784_500_82),
            ("schmidt", 1, 1, 1, 0.433_012_701_892_219_3, 0.346_410_161_513_775_46),
            ("schmidt", -1, 12, 5, -0.217_391_304_347_826_08, -0.161_290_322_580_645_16),
            ("unnorm", 1, 3, 0, -0.661_437_827_766_147_7, 0.0),
            ("unnorm", 1, 12, 5, 1.157_279_277_967_014_6e-6, 8.586_265_610_723_012e-7),
            ("unnorm", -1, 12, 5, -1.157_279_277_967_014_6e-6, -8.586_265_610_723_012e-7),
            ("unnorm", 1, 12, 12, 2.426_221_478_228_549e-13, 2.362_373_544_590_955_6e-13),
        ];
        for (name, csphase, l, m, c, s) in expected {
            let internal = Convention::default().import(l, m, sample(l, m)).expect("in range");
            let target = Convention {
                normalisation: name.parse().expect("a name"),
                phase: csphase.to_string().parse().expect("a phase"),
            };
            let (found_c, found_s) = target.export(l, m, internal).expect("in range");
            // Some dozen roundings on our side and on theirs (24 factors at unnorm (12, 12)).
            assert!((found_c - c).abs() <= 5e-15 * c.abs(), "{name} {csphase} ({l}, {m})");
            assert!((found_s - s).abs() <= 5e-15 * s.abs(), "{name} {csphase} ({l}, {m})");
        }
    }

    /// Sums the series by its definition and the recurrences of the design notes.
    fn value(coefficients: &Coefficients, theta: f64, phi: f64) -> f64 {
        let (ct, st) = (theta.cos(), theta.sin());
        let (mut sum, mut sectoral) = (0.0, 1.0);
        for m in 0..=coefficients.lmax() {
            if m > 0 {
                sectoral *= -((2 * m - 1) as f64 / (2 * m) as f64).sqrt() * st;
            }
            let (mut older, mut old) = (0.0, sectoral);
            for l in m..=coefficients.lmax() {
                if l > m {
                    let back = (((l - 1) * (l - 1) - m * m) as f64).sqrt();
                    let next = ((2 * l - 1) as f64 * ct * old - back * older)
                        / ((l * l - m * m) as f64).sqrt();
                    (older, old) = (old, next);
                }
                let (a, b) = coefficients.get(l, m);
                let angle = m as f64 * phi;
                sum += (a * angle.cos() + b * angle.sin()) * old;
            }
        }
        sum
    }

    #[test]
    fn imported_series_has_the_values_pyshtools_gives() {
        let mut coefficients = Coefficients::zeros(12);
        for (l, m) in (0..=12).flat_map(|l| (0..=l).map(move |m| (l, m))) {
            let (a, b) = Convention::default().import(l, m, sample(l, m)).expect("in range");
            coefficients.set(l, m, a, b);
        }
        for (latitude, longitude, expected) in [
            (90.0_f64, 0.0_f64, 1.075_178_418_864_333_6),
            (-30.0, 200.0, -0.158_139_976_416_018_07),
            (17.0, -63.5, 1.045_594_138_527_926_8),
        ] {
            let found =
                value(&coefficients, (90.0 - latitude).to_radians(), longitude.to_radians());
            // 91 terms of magnitude about 1, each good to some 1e-15.
            assert!((found - expected).abs() <= 1e-13, "{found} {expected}");
        }
    }

    #[test]
    fn unnorm_reaches_past_pyshtools_and_stops_with_advice() {
        let unnorm =
            Convention { normalisation: Normalisation::Unnormalised, ..Default::default() };
        // ln(170!)/2 and ln(300!)/2 by an independent lgamma, good to 1e-13 at this size.
        for (degree, half_log) in [(85, 353.286_531_122_893_7), (150, 707.452_924_972_534)] {
            let factor = unnorm.factor(degree, degree).expect("in range");
            assert!((factor.abs().ln() + half_log).abs() <= 1e-12);
        }
        assert!(unnorm.factor(1000, 10).is_ok());
        let message = unnorm.factor(151, 151).expect_err("too small").to_string();
        assert!(message.contains("degree 151, order 151") && message.contains("schmidt"));
        assert!(unnorm.factor(100_000, 100_000).is_err());
        assert!(unnorm.import(150, 150, (100.0, 0.0)).is_err());
    }

    #[test]
    fn names_are_those_of_pyshtools() {
        for normalisation in Normalisation::ALL {
            assert_eq!(normalisation.name().parse::<Normalisation>().ok(), Some(normalisation));
        }
        for phase in [CondonShortley::Without, CondonShortley::With] {
            assert_eq!(phase.csphase().to_string().parse::<CondonShortley>().ok(), Some(phase));
        }
        let message = "full".parse::<Normalisation>().expect_err("unknown").to_string();
        assert_eq!(message, "`full` is not a normalisation: use 4pi, ortho, schmidt or unnorm");
        assert!("0".parse::<CondonShortley>().is_err());
    }

    fn units_apart(a: f64, b: f64) -> u64 {
        a.abs().to_bits().abs_diff(b.abs().to_bits()) + u64::from(a.signum() != b.signum()) * 1000
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            rng_seed: prop::test_runner::RngSeed::Fixed(1),
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        #[test]
        fn import_undoes_export(
            l in 0_usize..60, m in 0_usize..60, a in -10.0..10.0, b in -10.0..10.0
        ) {
            let m = m.min(l);
            for convention in conventions() {
                let there = convention.export(l, m, (a, b)).expect("in range");
                let (a2, b2) = convention.import(l, m, there).expect("in range");
                let exact = convention.factor(l, m).expect("in range").abs() == 1.0;
                let allowed = if exact { 0 } else { 2 };
                prop_assert!(units_apart(a, a2) <= allowed && units_apart(b, b2) <= allowed);
            }
        }
    }
}
