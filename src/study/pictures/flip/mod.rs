//! FLIP: how different two pictures look when one flips between them, from 0 to 1 at each pixel.
//!
//! LDR-FLIP is that of Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astroem and Fairchild,
//! "FLIP: a difference evaluator for alternating images", Proc. ACM CGIT 3(2), 2020: both pictures
//! are filtered by the contrast sensitivity of the eye in YCxCz, their colours compared by HyAB in
//! Hunt-adjusted L*a*b*, and what differs in edges and points weighs more. HDR-FLIP is that of
//! Andersson, Nilsson, Shirley and Akenine-Moeller, "Visualizing errors in rendered high dynamic
//! range images", Eurographics 2021: at each pixel the largest LDR-FLIP of several exposures. The
//! filters are separable, as in the authors' own program, to which the tests hold the results.

mod exposures;
mod opponent;

use std::f64::consts::{PI, SQRT_2};

use rayon::prelude::*;

use self::exposures::{exposures, shown};
use crate::math::Rgb;
use crate::{Error, Result, memory};

/// The pixels per degree of the eye that FLIP takes by default: a screen 0.7 m wide of 3840 pixels
/// seen from 0.7 m, 67.02.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;

/// The exponent of colour differences, and how they are stretched: `SPLIT` of the largest becomes
/// `SPLIT_TO`.
const COLOUR_EXPONENT: f64 = 0.7;
const SPLIT: f64 = 0.4;
const SPLIT_TO: f64 = 0.95;
/// The exponent of differences in features, and the width of these, degrees.
const FEATURE_EXPONENT: f64 = 0.5;
const FEATURE_WIDTH: f64 = 0.082;
/// The Gaussians of the contrast sensitivity: a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees, of
/// Y and Cx, and the two whose sum is that of Cz.
const SENSITIVITY: [[f64; 2]; 4] = [[1.0, 0.0047], [1.0, 0.0053], [34.1, 0.04], [13.5, 0.025]];
/// What it takes for a pixel at most, bytes.
const BYTES: f64 = 400.0;
/// The pixels per degree that are possible: fewer leave no filter, more make it endless.
const POSSIBLE: std::ops::RangeInclusive<f64> = 1.0..=10_000.0;

/// Holds the FLIP error of each pixel, from 0 (they look the same) to 1, and what it comes to.
#[derive(Debug, Clone, PartialEq)]
pub struct Flip {
    /// The error of each pixel, top row first.
    pub map: Vec<f64>,
    /// The mean.
    pub mean: f64,
    /// The error that 95 % of the pixels stay below.
    pub percentile_95: f64,
    /// The largest.
    pub max: f64,
}

impl Flip {
    fn of(map: Vec<f64>) -> Self {
        let mut sorted = map.clone();
        let at = (sorted.len() * 95 / 100).min(sorted.len() - 1);
        let percentile_95 = *sorted.select_nth_unstable_by(at, f64::total_cmp).1;
        let mean = map.iter().sum::<f64>() / map.len() as f64;
        let max = map.iter().fold(0.0, |a: f64, b| a.max(*b));
        Self { map, mean, percentile_95, max }
    }
}

/// Computes HDR-FLIP of `test` against `reference`: pictures of `size` columns and rows in linear
/// Rec. 709, of whatever unit, top row first. [`PIXELS_PER_DEGREE`] is the usual last argument.
///
/// Exposures follow from the reference, or from the test where that is black. Light below zero
/// counts as none.
///
/// ```
/// use harmolux::math::Rgb;
/// use harmolux::study::{PIXELS_PER_DEGREE, flip};
///
/// let reference: Vec<Rgb> = (0..12).map(|i| Rgb::grey(f64::from(i))).collect();
/// let test: Vec<Rgb> = reference.iter().map(|p| *p * 1.1).collect();
/// let found = flip(&reference, &test, [4, 3], PIXELS_PER_DEGREE)?;
/// assert!(found.mean > 0.0 && found.max < 1.0);
/// assert_eq!(flip(&test, &test, [4, 3], PIXELS_PER_DEGREE)?.max, 0.0);
/// # Ok::<(), harmolux::Error>(())
/// ```
///
/// # Errors
/// [`Error::Parameter`] when a picture has not that size, no pixel, or one that is not finite, or
/// the pixels per degree are not from 1 to 10 000; [`Error::Memory`] for more than is free.
pub fn flip(
    reference: &[Rgb],
    test: &[Rgb],
    size: [usize; 2],
    pixels_per_degree: f64,
) -> Result<Flip> {
    let eye = Eye::new([reference, test], size, pixels_per_degree)?;
    let mut levels = exposures(reference);
    if levels.is_empty() {
        levels = exposures(test);
    }
    let mut map = vec![0.0; reference.len()];
    for level in levels {
        let [one, other] =
            [reference, test].map(|p| p.par_iter().map(|c| shown(*c, level)).collect::<Vec<_>>());
        let found = eye.difference(&one, &other);
        map.par_iter_mut().zip(found).for_each(|(most, error)| *most = f64::max(*most, error));
    }
    Ok(Flip::of(map))
}

/// Computes LDR-FLIP of `test` against `reference`: pictures as a screen shows them, in linear Rec.
/// 709 from 0 to 1; what is outside is clamped.
///
/// # Errors
/// As [`flip`].
pub fn flip_ldr(
    reference: &[Rgb],
    test: &[Rgb],
    size: [usize; 2],
    pixels_per_degree: f64,
) -> Result<Flip> {
    let eye = Eye::new([reference, test], size, pixels_per_degree)?;
    let clamped =
        |p: &[Rgb]| p.iter().map(|c| Rgb(c.0.map(|v| v.clamp(0.0, 1.0)))).collect::<Vec<_>>();
    Ok(Flip::of(eye.difference(&clamped(reference), &clamped(test))))
}

/// What filters a picture as the eye does.
struct Eye {
    size: [usize; 2],
    /// Each tap of the contrast sensitivity: Y, Cx, and both parts of Cz.
    sensitivity: Vec<[f64; 4]>,
    /// Each tap of a Gaussian and of its first and second derivative.
    features: Vec<[f64; 3]>,
    /// The largest colour difference.
    largest: f64,
}

/// A pixel as the eye sees it.
struct Seen {
    colour: [f64; 3],
    /// How much of an edge and of a point it is.
    features: [f64; 2],
}

impl Eye {
    fn new(pictures: [&[Rgb]; 2], size: [usize; 2], pixels_per_degree: f64) -> Result<Self> {
        let refuse = |text: String| Err(Error::Parameter(text));
        let [width, height] = size;
        for picture in pictures {
            let n = picture.len();
            if n == 0 || width.checked_mul(height) != Some(n) {
                return refuse(format!("{n} pixels are no picture of {width} x {height}"));
            }
            if let Some(i) = picture.iter().position(|p| !p.is_finite()) {
                let (x, y) = (i % width, i / width);
                return refuse(format!("pixel ({x}, {y}) is not finite: it has no FLIP error"));
            }
        }
        if !POSSIBLE.contains(&pixels_per_degree) {
            return refuse(format!(
                "{pixels_per_degree} pixels per degree: FLIP takes 1 to 10 000, and 67 for a \
                 screen at arm's length"
            ));
        }
        let bytes = BYTES * pictures[0].len() as f64;
        memory::ask(bytes, format_args!("FLIP of {width} x {height} pixels"), |share| {
            format!("about {:.0} % of it would fit; compare parts of the pictures", 100.0 * share)
        })?;
        Ok(Self {
            size,
            sensitivity: sensitivity(pixels_per_degree),
            features: features(0.5 * FEATURE_WIDTH * pixels_per_degree),
            largest: opponent::green_from_blue().powf(COLOUR_EXPONENT),
        })
    }

    /// Returns LDR-FLIP at each pixel.
    fn difference(&self, reference: &[Rgb], test: &[Rgb]) -> Vec<f64> {
        let [one, other] = [reference, test].map(|picture| self.see(picture));
        one.par_iter().zip(&other).map(|(one, other)| self.error(one, other)).collect()
    }

    fn error(&self, one: &Seen, other: &Seen) -> f64 {
        let colour = self.stretched(opponent::hyab(one.colour, other.colour));
        let apart = |i: usize| (one.features[i] - other.features[i]).abs();
        let feature = (apart(0).max(apart(1)) / SQRT_2).powf(FEATURE_EXPONENT);
        colour.powf(1.0 - feature)
    }

    /// Brings a distance of colours to 0 to 1.
    fn stretched(&self, distance: f64) -> f64 {
        let (power, split) = (distance.powf(COLOUR_EXPONENT), SPLIT * self.largest);
        if power < split {
            return power * SPLIT_TO / split;
        }
        SPLIT_TO + (power - split) / (self.largest - split) * (1.0 - SPLIT_TO)
    }

    fn see(&self, picture: &[Rgb]) -> Vec<Seen> {
        let opponents: Vec<[f64; 3]> =
            picture.par_iter().map(|colour| opponent::ycxcz(*colour)).collect();
        let across = self.filtered(Across, self.sensitivity.len(), |i, k| {
            let ([y, cx, cz], tap) = (opponents[i], self.sensitivity[k]);
            [y * tap[0], cx * tap[1], cz * tap[2], cz * tap[3]]
        });
        let both = self.filtered(Down, self.sensitivity.len(), |i, k| {
            std::array::from_fn::<f64, 4, _>(|c| across[i][c] * self.sensitivity[k][c])
        });
        let colours: Vec<[f64; 3]> =
            both.par_iter().map(|[y, cx, a, b]| opponent::seen([*y, *cx, a + b])).collect();
        let across = self.filtered(Across, self.features.len(), |i, k| {
            self.features[k].map(|tap| tap * opponent::grey(opponents[i][0]))
        });
        let both = self.filtered(Down, self.features.len(), |i, k| {
            let ([smooth, slope, bend], [g, first, second]) = (across[i], self.features[k]);
            [slope * g, smooth * first, bend * g, smooth * second]
        });
        let features = both.par_iter().map(|[x, y, xx, yy]| [x.hypot(*y), xx.hypot(*yy)]);
        let seen = colours.into_par_iter().zip(features);
        seen.map(|(colour, features)| Seen { colour, features }).collect()
    }

    /// Adds up what each tap of a filter takes of a pixel along it; the picture goes on beyond its
    /// border as it ends there.
    fn filtered<const N: usize>(
        &self,
        along: Direction,
        taps: usize,
        of: impl Fn(usize, usize) -> [f64; N] + Sync,
    ) -> Vec<[f64; N]> {
        let [width, height] = self.size;
        let sum = |i: usize| {
            let (x, y) = (i % width, i / width);
            let mut sums = [0.0; N];
            for k in 0..taps {
                let at = |n: usize, end: usize| (n + k).saturating_sub(taps / 2).min(end - 1);
                let pixel = match along {
                    Across => y * width + at(x, width),
                    Down => at(y, height) * width + x,
                };
                sums.iter_mut().zip(of(pixel, k)).for_each(|(sum, value)| *sum += value);
            }
            sums
        };
        (0..width * height).into_par_iter().map(sum).collect()
    }
}

/// The way of a filter.
#[derive(Clone, Copy)]
enum Direction {
    Across,
    Down,
}
use Direction::{Across, Down};

/// Lists the taps of the contrast sensitivity. A sum of two Gaussians is no product of filters
/// across and down; each of both is, so they stay apart until the end.
fn sensitivity(pixels_per_degree: f64) -> Vec<[f64; 4]> {
    let widest = SENSITIVITY.iter().fold(0.0, |b: f64, gaussian| b.max(gaussian[1]));
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
    let tap = |k: usize| {
        let x = (k as f64 - radius as f64) / pixels_per_degree;
        let fall = SENSITIVITY.map(|[_, b]| (-PI * PI * x * x / b).exp());
        // The parts of Cz keep their weights to each other, half of it each way.
        let heights = SENSITIVITY.map(|[a, b]| (a * (PI / b).sqrt()).sqrt());
        [fall[0], fall[1], heights[2] * fall[2], heights[3] * fall[3]]
    };
    let taps: Vec<[f64; 4]> = (0..=2 * radius).map(tap).collect();
    let sums: [f64; 4] = std::array::from_fn(|c| taps.iter().map(|tap| tap[c]).sum());
    let blue = sums[2].hypot(sums[3]);
    let sums = [sums[0], sums[1], blue, blue];
    taps.into_iter().map(|tap| std::array::from_fn(|c| tap[c] / sums[c])).collect()
}

/// Lists the taps of a Gaussian and of its derivatives, `deviation` in pixels: those of the
/// Gaussian add up to one, the positive ones of a derivative too, the negative ones to -1.
fn features(deviation: f64) -> Vec<[f64; 3]> {
    let radius = (3.0 * deviation).ceil() as usize;
    let tap = |k: usize| {
        let x = k as f64 - radius as f64;
        let squares = (x / deviation).powi(2);
        let g = (-0.5 * squares).exp();
        [g, -x * g, (squares - 1.0) * g]
    };
    let taps: Vec<[f64; 3]> = (0..=2 * radius).map(tap).collect();
    let sum = |c: usize, sign: f64| taps.iter().map(|tap| (sign * tap[c]).max(0.0)).sum::<f64>();
    let sums: [[f64; 2]; 3] = std::array::from_fn(|c| [sum(c, -1.0), sum(c, 1.0)]);
    let part = |c: usize, value: f64| match sums[c][usize::from(value > 0.0)] {
        sum if sum > 0.0 => value / sum,
        _ => 0.0,
    };
    taps.iter().map(|tap| std::array::from_fn(|c| part(c, tap[c]))).collect()
}

#[cfg(test)]
mod tests;
