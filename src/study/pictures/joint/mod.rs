//! Whether two pictures differ by more than their errors allow: all pixels together, and the means
//! of blocks of pixels, in which a difference that is small but wide stands out.
//!
//! z = (a - b) / sqrt(s_a^2 + s_b^2), and the largest |z| of a family of n is held to the quantile
//! of Student's t for the false-alarm rate divided by n (Bonferroni), as
//! [`Estimate::agrees_with`](crate::math::stats::Estimate::agrees_with) does with single values.

use super::Picture;
use crate::math::stats::student_t;

/// How often equal pictures are said to differ, all pixels and blocks together.
pub const FALSE_ALARMS: f64 = 1e-3;

/// The side of the blocks of one level over that of the one before.
const GROWTH: usize = 4;
/// Pixels of a picture pick the walks that light them among 256 clouds in each pass
/// (`estimators::image`), so that two of them share their noise as often as that.
const SHARED: f64 = 1.0 / 256.0;
/// Values of single precision differ by so much of themselves though they are the same: two
/// roundings of 2^-24 and what sums of them add.
pub(super) const ROUNDING: f64 = 1.0 / (1_u64 << 22) as f64;
/// The fewest replicates whose errors can judge: with two, Student's t of one degree of freedom
/// allows any difference.
pub const FEWEST_REPLICATES: usize = 4;
/// Stands for errors that are exact: more replicates change nothing.
const EXACT: usize = 10_000;

/// Holds the joint test of two pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct JointTest {
    /// The largest deviations: of pixels, then of larger and larger blocks, the last of which is
    /// the whole picture.
    pub levels: Vec<JointLevel>,
    /// How many independent replicates the errors come from, the fewer of both pictures; `None`
    /// where neither says it.
    pub replicates: Option<usize>,
    /// The share of the tested pixels that lie outside their own 95 % interval: 5 % in the mean if
    /// the pictures are the same.
    pub beyond_95: f64,
    /// How many pixels have no known error in one picture; they are not tested.
    pub unknown: usize,
    /// How many pixels have an error of zero in both: they must be equal, but for rounding.
    pub exact: usize,
    /// How many pixels were tested, exact ones among them.
    pub tested: usize,
}

/// Holds the largest deviation of blocks of one size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLevel {
    /// The side of the blocks, pixels; those at the right and lower border may be cut.
    pub side: usize,
    /// How many blocks there are.
    pub blocks: usize,
    /// The deviation of largest magnitude, standard errors; infinite where pixels without an error
    /// differ.
    pub z: f64,
    /// Its block: column and row of its first pixel.
    pub at: [usize; 2],
    /// The magnitude that no deviation exceeds if the pictures are the same, but for the false
    /// alarms of this level.
    pub limit: f64,
    /// How many blocks exceed it.
    pub beyond: usize,
}

impl JointTest {
    /// Whether the pictures differ.
    pub fn differ(&self) -> bool {
        self.levels.iter().any(|level| level.beyond > 0)
    }
}

/// Tests whether two pictures of one size are the same but for their errors, with
/// [`FALSE_ALARMS`] in all. `None` where one has no errors, or no pixel has one, or they come from
/// fewer than [`FEWEST_REPLICATES`].
///
/// The error of a block is more than that of independent pixels: two pixels may share walks, and
/// with them at most 1/256 of their variance. Errors must be independent between the pictures: two
/// runs with one seed agree by more than chance.
pub fn joint_test(a: &Picture, b: &Picture) -> Option<JointTest> {
    let n = a.pixels.len();
    if a.size != b.size || a.errors.len() != n || b.errors.len() != n {
        return None;
    }
    let pixels: Vec<_> = (0..n).map(|i| Sum::of_pixel(a, b, i)).collect();
    let tested = pixels.iter().filter(|sum| sum.pixels > 0).count();
    let replicates = [a.replicates, b.replicates].into_iter().flatten().min();
    if replicates.is_some_and(|n| n < FEWEST_REPLICATES) {
        return None;
    }
    let freedom = replicates.map_or(EXACT, |n| n - 1);
    let sides = sides(a.size);
    let share = FALSE_ALARMS / sides.len() as f64;
    let levels = sides.into_iter().map(|side| level(&pixels, a.size, side, share, freedom));
    let usual = student_t(0.05, freedom);
    let outside = pixels.iter().filter(|sum| sum.z().is_some_and(|z| z.abs() > usual)).count();
    (tested > 0).then(|| JointTest {
        levels: levels.collect(),
        replicates,
        beyond_95: outside as f64 / tested as f64,
        unknown: n - tested,
        exact: pixels.iter().filter(|sum| sum.pixels > 0 && sum.errors == 0.0).count(),
        tested,
    })
}

/// Returns z of each pixel, top row first; NaN where an error is not known.
pub(super) fn deviations(a: &Picture, b: &Picture) -> Vec<f64> {
    let z = |i| Sum::of_pixel(a, b, i).z().unwrap_or(f64::NAN);
    (0..a.pixels.len()).map(z).collect()
}

/// Returns the standard error of the difference of two pixels; NaN where it is not known.
pub(super) fn error(a: &Picture, b: &Picture, pixel: usize) -> f64 {
    let [one, other] = [a, b].map(|p| p.errors.get(pixel).copied().unwrap_or(f64::NAN));
    let is_known = [one, other].iter().all(|s| s.is_finite() && *s >= 0.0);
    if is_known { one.hypot(other) } else { f64::NAN }
}

/// What pixels of a block add up to; those of unknown error left out.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    pixels: usize,
    difference: f64,
    /// What of the difference may be rounding.
    rounding: f64,
    variances: f64,
    errors: f64,
}

impl Sum {
    fn of_pixel(a: &Picture, b: &Picture, i: usize) -> Self {
        let [x, y] = [a, b].map(|picture| picture.pixels[i].luminance());
        let error = error(a, b, i);
        if error.is_nan() {
            return Self::default();
        }
        Self {
            pixels: 1,
            difference: x - y,
            rounding: ROUNDING * x.abs().max(y.abs()),
            variances: error * error,
            errors: error,
        }
    }

    fn add(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            difference: self.difference + other.difference,
            rounding: self.rounding + other.rounding,
            variances: self.variances + other.variances,
            errors: self.errors + other.errors,
        }
    }

    /// Returns the deviation; `None` without any pixel of known error.
    fn z(self) -> Option<f64> {
        let variance = (1.0 - SHARED) * self.variances + SHARED * self.errors * self.errors;
        let apart = (self.difference.abs() - self.rounding).max(0.0);
        let z = if apart > 0.0 { apart / variance.sqrt() } else { 0.0 };
        (self.pixels > 0).then(|| z.copysign(self.difference))
    }
}

/// Lists the sides of blocks: 1, 4, 16, ..., until one block holds the picture.
fn sides(size: [usize; 2]) -> Vec<usize> {
    let longest = size[0].max(size[1]).max(1);
    let mut sides: Vec<usize> =
        std::iter::successors(Some(1), |side: &usize| side.checked_mul(GROWTH))
            .take_while(|side| *side < longest)
            .collect();
    sides.push(longest);
    sides
}

fn level(pixels: &[Sum], size: [usize; 2], side: usize, share: f64, freedom: usize) -> JointLevel {
    let [columns, rows] = size.map(|n| n.div_ceil(side));
    let mut blocks = vec![Sum::default(); columns * rows];
    for (i, pixel) in pixels.iter().enumerate() {
        let (x, y) = (i % size[0] / side, i / size[0] / side);
        blocks[y * columns + x] = blocks[y * columns + x].add(*pixel);
    }
    let found = blocks.iter().enumerate().filter_map(|(i, sum)| Some((i, sum.z()?)));
    let count = found.clone().count();
    let limit = student_t(share / count.max(1) as f64, freedom);
    let largest = |a: (usize, f64), b: (usize, f64)| if b.1.abs() > a.1.abs() { b } else { a };
    let (at, z) = found.clone().reduce(largest).unwrap_or((0, 0.0));
    JointLevel {
        side,
        blocks: count,
        z,
        at: [at % columns * side, at / columns * side],
        limit,
        beyond: found.filter(|(_, z)| z.abs() > limit).count(),
    }
}

#[cfg(test)]
mod tests;
