//! How likely each quantised coefficient is, given those before it: the one thing the writer and
//! the reader of the compact form must agree about to the last bit.
//!
//! The magnitude to expect at (l, m) is a weighted mean of what stands at nearby orders of the same
//! and the three degrees before, and of a power law over the degree, E_1 l^-p, whose numbers the
//! file carries. The law of the deviations is Student's t of 2, 4, 8 or 16 degrees of freedom: long
//! tails forgive a wrong expectation, and for an even number of degrees of freedom its cumulative
//! function is algebraic (Abramowitz and Stegun 26.7.4),
//!
//! ```text
//! F(t) = 1/2 + s/2 (1 + c/2 (1 + 3c/4 (1 + 5c/6 (...)))),
//! s = t / sqrt(t^2 + nu),   c = nu / (t^2 + nu).
//! ```
//!
//! So only + - * / and sqrt take part, which IEEE 754 rounds alike on every machine, and no exp or
//! log of a system's library.

use std::borrow::Borrow;
use std::f64::consts::SQRT_2;
use std::num::NonZeroU32;

use constriction::stream::model::{DecoderModel, EncoderModel, EntropyModel};

/// The binary digits of a probability.
pub(super) const PRECISION: usize = 24;

/// Ends the range of values that the distribution knows; what is beyond is written out.
pub(super) const END: i32 = 1 << 11;

/// The largest magnitude that is coded; whole numbers stay exact in f64.
pub(super) const LARGEST: i64 = 1 << 50;

/// Keeps every value possible. Two units each: rounding may take one.
const LEAST: u32 = 2;

/// Expected magnitudes above this are coded without their last bits, which are nearly uniform.
const FINEST: f64 = 64.0;

/// The least magnitude to expect: the price of a surprise after many zeros.
const FLOOR: f64 = 1.0 / 32.0;

/// Weights by distance in degree and in order, and that of the power law.
const DEGREE_WEIGHTS: [u32; 4] = [4, 4, 2, 1];
const ORDER_WEIGHTS: [u32; 5] = [60, 30, 20, 15, 12];
const LAW_WEIGHT: f64 = 120.0;

/// Half the degrees of freedom, and the mean magnitude E|t|, of the distributions that a file can
/// choose.
const TAILS: [(u32, f64); 4] = [(1, SQRT_2), (2, 1.0), (4, 0.883_883_476), (8, 0.838_018_3)];

/// Numbers a coefficient: degree, order, and whether it is that of the sine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) l: usize,
    pub(super) m: usize,
    pub(super) sine: bool,
}

impl Place {
    /// Lists all coefficients past degree 0, in the order of the file.
    pub(super) fn all(lmax: usize) -> impl Iterator<Item = Self> {
        let degree = |l: usize| {
            (0..=l).flat_map(move |m| {
                [false, true].into_iter().filter(move |sine| m > 0 || !sine).map(move |sine| Self {
                    l,
                    m,
                    sine,
                })
            })
        };
        (1..=lmax).flat_map(degree)
    }

    /// Returns the index in a degree-major list without the sines of order 0: l^2 + 2m - 1 or + 2m,
    /// l^2 at order 0.
    pub(super) const fn index(self) -> usize {
        self.l * self.l + (2 * self.m + self.sine as usize).saturating_sub(1)
    }

    /// Returns by one bit each whether a mirror at the planes x = 0, y = 0, z = 0 turns the sign of
    /// the basis function.
    const fn parity(self) -> u8 {
        let sine = self.sine as usize;
        (((self.m + sine) & 1) | sine << 1 | ((self.l + self.m) & 1) << 2) as u8
    }
}

/// Holds the two bytes by which a file chooses its law of expectation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Law {
    /// The mirrors (one bit each for x, y, z) that coefficients must share to tell of one another,
    /// 0 to 7.
    pub(super) mirrors: u8,
    /// The row of the table of distributions, 0 to 3.
    pub(super) tail: u8,
    /// Twice the power p, 0 to 7.
    pub(super) decay: u8,
    /// The magnitude expected at degree 1, 2^(level / 4) / 4 with straight lines between the powers
    /// of two.
    pub(super) level: u8,
}

impl Law {
    pub(super) const fn to_bytes(self) -> [u8; 2] {
        [self.mirrors | self.tail << 3 | self.decay << 5, self.level]
    }

    pub(super) const fn from_bytes([first, level]: [u8; 2]) -> Self {
        Self { mirrors: first & 7, tail: first >> 3 & 3, decay: first >> 5, level }
    }

    /// Returns the distribution at degree l in such surroundings.
    pub(super) fn distribution(self, l: usize, around: Surroundings) -> Distribution {
        let expected = (around.sum + LAW_WEIGHT * self.expected(l)) / (around.weights + LAW_WEIGHT);
        Distribution::new(expected + FLOOR, self.tail)
    }

    /// Returns the magnitude that the power law expects at degree l >= 1.
    fn expected(self, l: usize) -> f64 {
        let quarters = f64::from(4 + u32::from(self.level % 4)) / 16.0;
        let start = quarters * (1_u64 << (self.level / 4).min(63)) as f64;
        let root = (l as f64).sqrt();
        (0..self.decay).fold(start, |level, _| level / root)
    }
}

/// Holds the weighted sum of the magnitudes around a place, and the sum of the weights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surroundings {
    sum: f64,
    weights: f64,
}

/// Remembers the quantised coefficients so far, and expects the next.
#[derive(Debug, Clone)]
pub(super) struct Context {
    law: Law,
    /// In the order of [`Place::index`]; 0 at degree 0.
    values: Vec<i64>,
}

impl Context {
    /// Begins after degree 0, which tells nothing of the others.
    pub(super) fn new(law: Law) -> Self {
        Self { law, values: vec![0] }
    }

    /// Takes the value at the next place.
    pub(super) fn push(&mut self, value: i64) {
        self.values.push(value);
    }

    /// Returns all values past degree 0.
    pub(super) fn into_values(mut self) -> Vec<i64> {
        self.values.remove(0);
        self.values
    }

    /// Returns the distribution at the next place, which must be `place`.
    pub(super) fn next(&self, place: Place) -> Distribution {
        self.law.distribution(place.l, self.surroundings(place))
    }

    /// Sums what is known around the next place, which must be `place`.
    pub(super) fn surroundings(&self, place: Place) -> Surroundings {
        let mut all = Surroundings { sum: 0.0, weights: 0.0 };
        for (back, degree_weight) in DEGREE_WEIGHTS.into_iter().enumerate() {
            if place.l <= back {
                break;
            }
            let (sum, weights) = self.nearby(place, place.l - back);
            all.sum += f64::from(degree_weight) * sum;
            all.weights += f64::from(degree_weight * weights);
        }
        all
    }

    /// Sums weighted magnitudes, and the weights, over the known nearby orders of degree l.
    fn nearby(&self, place: Place, l: usize) -> (f64, u32) {
        let (mut sum, mut weights) = (0.0, 0);
        let reach = ORDER_WEIGHTS.len() - 1;
        for m in place.m.saturating_sub(reach)..=(place.m + reach).min(l) {
            for sine in [false, true] {
                let other = Place { l, m, sine };
                let differs = (other.parity() ^ place.parity()) & self.law.mirrors != 0;
                if differs || (m == 0 && sine) {
                    continue;
                }
                if let Some(value) = self.values.get(other.index()) {
                    let weight = ORDER_WEIGHTS[m.abs_diff(place.m)];
                    sum += f64::from(weight) * value.unsigned_abs() as f64;
                    weights += weight;
                }
            }
        }
        (sum, weights)
    }
}

/// Assigns each whole number from -[`END`] to [`END`] a probability; the ends stand for all beyond.
#[derive(Debug, Clone, Copy)]
pub(super) struct Distribution {
    scale: f64,
    half_freedom: u32,
    /// How many last bits of a value are left to be written out.
    pub(super) shift: u32,
}

impl Distribution {
    fn new(expected: f64, tail: u8) -> Self {
        let (half_freedom, mean) = TAILS[usize::from(tail)];
        let (mut scale, mut shift) = (expected / mean, 0);
        while scale > FINEST {
            scale *= 0.5;
            shift += 1;
        }
        Self { scale, half_freedom, shift }
    }

    /// Splits a value into what the distribution codes and the rest, below 2^shift.
    pub(super) const fn split(self, value: i64) -> (i64, u64) {
        if self.shift == 0 {
            return (value, 0);
        }
        let raised = value + (1 << (self.shift - 1));
        (raised >> self.shift, (raised & ((1 << self.shift) - 1)) as u64)
    }

    /// Joins what [`Self::split`] has split; `None` beyond [`LARGEST`].
    pub(super) fn join(self, coarse: i64, rest: u64) -> Option<i64> {
        let half = if self.shift == 0 { 0 } else { 1_i128 << (self.shift - 1) };
        let value = (i128::from(coarse) << self.shift) + i128::from(rest) - half;
        i64::try_from(value).ok().filter(|value| value.unsigned_abs() <= LARGEST.unsigned_abs())
    }

    /// Returns the information in a value, bits.
    pub(super) fn bits(self, value: i64) -> f64 {
        let (coarse, _) = self.split(value);
        let symbol = clamp(coarse);
        let (from, to) = (self.cumulative(symbol), self.cumulative(symbol + 1));
        let beyond = coarse.unsigned_abs().saturating_sub(END as u64);
        let escaped =
            if symbol.abs() == END { 2.0 * (beyond as f64 + 1.0).log2() + 1.0 } else { 0.0 };
        PRECISION as f64 - f64::from(to - from).log2() + f64::from(self.shift) + escaped
    }

    /// Returns the probability of all numbers below `symbol`, in units of 2^-[`PRECISION`].
    fn cumulative(self, symbol: i32) -> u32 {
        if symbol <= -END {
            return 0;
        }
        if symbol > END {
            return 1 << PRECISION;
        }
        let shared = (1 << PRECISION) - LEAST * (2 * END as u32 + 1);
        let below = f64::from(shared) * self.student((f64::from(symbol) - 0.5) / self.scale);
        below as u32 + LEAST * (symbol + END) as u32
    }

    /// Returns Student's cumulative function.
    fn student(self, t: f64) -> f64 {
        let freedom = f64::from(2 * self.half_freedom);
        let square = t * t + freedom;
        let (sine, cosine2) = (t / square.sqrt(), freedom / square);
        let series = (1..self.half_freedom)
            .rev()
            .fold(1.0, |inner, k| 1.0 + f64::from(2 * k - 1) / f64::from(2 * k) * cosine2 * inner);
        0.5 + 0.5 * sine * series
    }
}

/// Limits a value to the range of the distribution.
pub(super) fn clamp(coarse: i64) -> i32 {
    coarse.clamp(i64::from(-END), i64::from(END)) as i32
}

impl EntropyModel<PRECISION> for Distribution {
    type Symbol = i32;
    type Probability = u32;
}

impl EncoderModel<PRECISION> for Distribution {
    fn left_cumulative_and_probability(
        &self,
        symbol: impl Borrow<i32>,
    ) -> Option<(u32, NonZeroU32)> {
        let symbol = *symbol.borrow();
        let from = self.cumulative(symbol);
        let probability = self.cumulative(symbol + 1).checked_sub(from)?;
        Some((from, NonZeroU32::new(probability)?))
    }
}

impl DecoderModel<PRECISION> for Distribution {
    fn quantile_function(&self, quantile: u32) -> (i32, u32, NonZeroU32) {
        // The last symbol whose cumulative probability is not above the quantile.
        let (mut low, mut high) = (-END, END + 1);
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if self.cumulative(middle) <= quantile { low = middle } else { high = middle }
        }
        let from = self.cumulative(low);
        let probability = self.cumulative(low + 1).saturating_sub(from);
        (low, from, NonZeroU32::new(probability).unwrap_or(NonZeroU32::MIN))
    }
}
