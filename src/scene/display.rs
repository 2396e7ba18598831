//! How luminance becomes a picture to look at: a factor and a curve, before the screen's own
//! encoding.

use std::str::FromStr;

use crate::math::Rgb;
use crate::math::choice::choice;
use crate::{Error, Result};

/// The luminance to which the geometric mean of an image is exposed: the grey card of photography.
const MIDDLE_GREY: f64 = 0.18;
/// The curve of ACES as K. Narkowicz fitted it (2015), with its exposure of 0.6: (a x^2 + b x) /
/// (c x^2 + d x + e).
pub(crate) const ACES: [f64; 5] =
    [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];

/// Says how a picture is shown.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Display {
    /// What luminances are multiplied with.
    pub exposure: Exposure,
    /// What becomes of values near and above white.
    pub tone: Tone,
}

/// Chooses the factor from luminance, cd/m2, to the value shown, of which 1 is white.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Exposure {
    /// The geometric mean of the positive luminances becomes 0.18.
    #[default]
    Mean,
    /// A factor above 0.
    Factor(f64),
    /// The luminance that this share of the pixels does not exceed becomes 1; above 0, at most 1.
    Share(f64),
}

impl Exposure {
    /// Returns the factor for a picture; 1 where no pixel has a positive finite luminance.
    ///
    /// ```
    /// use harmolux::math::Rgb;
    /// use harmolux::scene::Exposure;
    ///
    /// let picture = [1.0, 2.0, 4.0, 500.0].map(Rgb::grey);
    /// assert_eq!(Exposure::Share(0.75).factor(&picture)?, 0.25);
    /// # Ok::<(), harmolux::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] when a factor is not positive and finite, or a share is not in (0, 1].
    pub fn factor(self, pixels: &[Rgb]) -> Result<f64> {
        let lit = |y: &f64| *y > 0.0 && y.is_finite();
        let luminances = || pixels.iter().map(|p| p.luminance());
        let shown_as = |value: f64, luminance: f64| (value / luminance).min(f64::MAX);
        match self {
            Self::Factor(factor) if factor > 0.0 && factor.is_finite() => Ok(factor),
            Self::Factor(factor) => {
                Err(Error::Parameter(format!("the exposure {factor} is not a positive number")))
            }
            Self::Mean => {
                // The product would overflow, the sum of logarithms does not.
                let (count, logarithms) = luminances()
                    .filter(lit)
                    .fold((0_usize, 0.0), |(n, sum), y| (n + 1, sum + y.ln()));
                let mean = (logarithms / count as f64).exp();
                Ok(if count == 0 { 1.0 } else { shown_as(MIDDLE_GREY, mean) })
            }
            Self::Share(share) if share > 0.0 && share <= 1.0 => {
                let mut sorted: Vec<f64> = luminances().filter(|y| y.is_finite()).collect();
                sorted.sort_by(f64::total_cmp);
                let at = (share * sorted.len() as f64).ceil() as usize;
                let brightest = sorted.last().copied().filter(lit);
                let white = sorted.get(at.saturating_sub(1)).copied().filter(lit).or(brightest);
                Ok(white.map_or(1.0, |white| shown_as(1.0, white)))
            }
            Self::Share(share) => {
                Err(Error::Parameter(format!("the exposure of {share} is no share of the pixels")))
            }
        }
    }
}

impl FromStr for Exposure {
    type Err = Error;

    /// Reads a factor, "0.02", or a share of the pixels, "98%".
    fn from_str(text: &str) -> Result<Self> {
        let text = text.trim();
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| *v > 0.0);
        let read = match text.strip_suffix('%') {
            Some(share) => number(share).filter(|v| *v <= 100.0).map(|v| Self::Share(v / 100.0)),
            None => number(text).filter(|v| v.is_finite()).map(Self::Factor),
        };
        read.ok_or_else(|| {
            Error::Parameter(format!(
                "{} is no exposure: write a factor above 0 such as 0.02, or the share of the \
                 pixels that may be up to white, such as 98%",
                crate::error::shown(text)
            ))
        })
    }
}

/// Names a curve from exposed luminance to the value that is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tone {
    /// None: what is shown is proportional to luminance up to white.
    #[default]
    Linear,
    /// That of ACES, as film has it: light above white keeps its differences.
    Filmic,
}

choice!(Tone, "tone curve":
    Linear = "linear" "Proportional to luminance, cut at white",
    Filmic = "filmic" "The curve of ACES: lights above white keep their differences",
);

impl Tone {
    /// Returns what is shown of an exposed value, from 0 to 1.
    pub fn shown(self, value: f64) -> f64 {
        // Filters with negative lobes leave light below zero.
        let x = value.max(0.0);
        match self {
            Self::Linear => x.min(1.0),
            Self::Filmic => {
                let [a, b, c, d, e] = ACES;
                // Infinity over infinity is the end of the curve.
                let y =
                    if x > 1e100 { a / c } else { (a * x * x + b * x) / (c * x * x + d * x + e) };
                y.min(1.0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factor(exposure: Exposure, luminances: &[f64]) -> f64 {
        let pixels: Vec<Rgb> = luminances.iter().map(|y| Rgb::grey(*y)).collect();
        exposure.factor(&pixels).expect("an exposure")
    }

    #[test]
    fn pictures_without_light_have_exposure_one() {
        for exposure in [Exposure::Mean, Exposure::Share(0.9)] {
            assert_eq!(factor(exposure, &[]), 1.0);
            assert_eq!(factor(exposure, &[0.0, f64::NAN, -1.0]), 1.0);
        }
    }

    #[test]
    fn the_geometric_mean_becomes_middle_grey() {
        let mean = factor(Exposure::Mean, &[1.0, 100.0, 0.0, f64::NAN]);
        assert!((mean - 0.018).abs() <= 1e-15);
        // 1000 logarithms of 691, each rounded to 1e-13.
        assert!((factor(Exposure::Mean, &[1e300; 1000]) / 1.8e-301 - 1.0).abs() <= 1e-9);
        // Fainter than one over the largest number: as bright as numbers can make it.
        assert_eq!(factor(Exposure::Mean, &[1e-320]), f64::MAX);
    }

    #[test]
    fn a_share_of_the_pixels_stays_below_white() {
        let room = [[0.5; 98].as_slice(), &[3e4, 2e4]].concat();
        assert_eq!(factor(Exposure::Share(0.98), &room), 2.0);
        assert_eq!(factor(Exposure::Share(0.99), &room), 1.0 / 2e4);
        assert_eq!(factor(Exposure::Share(1.0), &room), 1.0 / 3e4);
        // Where that share is dark, the brightest pixel counts.
        assert_eq!(factor(Exposure::Share(0.5), &[0.0, 0.0, 8.0]), 0.125);
    }

    #[test]
    fn exposures_are_read_and_others_refused() {
        assert_eq!("0.02".parse::<Exposure>().expect("read"), Exposure::Factor(0.02));
        assert_eq!(" 98 % ".parse::<Exposure>().expect("read"), Exposure::Share(0.98));
        for text in ["0", "-1", "nan", "inf", "0%", "101%", "p98", "", "%"] {
            let message = text.parse::<Exposure>().expect_err(text).to_string();
            assert!(message.contains("such as 98%"), "{message}");
        }
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            Exposure::Factor(bad).factor(&[]).expect_err("no factor");
            Exposure::Share(bad).factor(&[]).expect_err("no share");
        }
    }

    #[test]
    fn curves_rise_from_black_to_white() {
        for tone in Tone::ALL {
            let values: Vec<f64> =
                (-10..60).map(|i| tone.shown(f64::from(i) / 10.0 * f64::from(i.max(1)))).collect();
            assert!(values.is_sorted() && values[0] == 0.0 && tone.shown(f64::INFINITY) == 1.0);
        }
        // By hand: (2.51 * 0.6^2 + 0.03 * 0.6) / (2.43 * 0.6^2 + 0.59 * 0.6 + 0.14).
        assert!((Tone::Filmic.shown(1.0) - 0.9216 / 1.3688).abs() <= 1e-12);
    }
}
