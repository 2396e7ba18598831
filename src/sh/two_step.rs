//! The two-step recurrence of the Legendre functions, in the square of z (Ishioka 2018): what the
//! fast sums over degrees run on.
//!
//! With N_l^m = sqrt(2l+1) Q_l^m / sin^m(theta) and e_l = sqrt((l^2 - m^2) / (4 l^2 - 1)), z N_l =
//! e_(l+1) N_(l+1) + e_l N_(l-1). Twice that gives, for the functions of odd l - m divided by z,
//! N_(m+2k+1) / z = s_k p_k with scales s_k chosen so that the last factor is 1,
//!
//! p_(k+1) = (a_k z^2 + b_k) p_k - p_(k-1);
//!
//! those of even l - m follow without division, N_(m+2k) = e_(m+2k+1) s_k p_k + e_(m+2k) s_(k-1)
//! p_(k-1). So one multiplication serves two degrees, and sums with coefficients go over the p_k
//! alone, after the coefficients were folded once. Dividing by sin^m keeps the start p_0 the same
//! at every theta and far from underflow (see `legendre`).

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};

/// Holds what one step k of the recurrence needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
    /// The factor of z^2.
    a: f64,
    /// What is added to it.
    b: f64,
    /// What p_k contributes to Q_l^m / sin^m at l = m + 2k.
    even: f64,
    /// What p_k contributes at l = m + 2k + 2.
    even_above: f64,
    /// What z p_k contributes at l = m + 2k + 1.
    odd: f64,
}

/// Holds the recurrence for all orders of a triangle of degree `lmax`, order after order.
#[derive(Debug, Clone)]
pub(super) struct TwoStep {
    lmax: usize,
    /// Per order: where its steps begin, and p_0; one more at the end.
    orders: Vec<(usize, f64)>,
    steps: Vec<Step>,
}

/// Holds cosine and sine sums over even and odd l - m: [A even, B even, A odd, B odd].
pub(super) type Quad = [f64; 4];

/// Counts the steps of order m: p_k for k = 0..=(lmax - m) / 2.
const fn count(lmax: usize, m: usize) -> usize {
    (lmax - m) / 2 + 1
}

impl TwoStep {
    /// Tabulates the recurrence up to degree `lmax`.
    pub(super) fn new(lmax: usize) -> Self {
        let mut orders = Vec::with_capacity(lmax + 2);
        let mut steps = Vec::with_capacity((0..=lmax).map(|m| count(lmax, m)).sum());
        let mut diagonal = 1.0;
        for m in 0..=lmax {
            if m > 0 {
                diagonal *= -((2 * m - 1) as f64 / (2 * m) as f64).sqrt();
            }
            let start = (((2 * m + 1) * (2 * m + 3)) as f64).sqrt() * diagonal;
            orders.push((steps.len(), start));
            push_order(lmax, m, &mut steps);
        }
        orders.push((steps.len(), 0.0));
        Self { lmax, orders, steps }
    }

    /// Returns the truncation degree.
    pub(super) fn lmax(&self) -> usize {
        self.lmax
    }

    /// Returns p_0 of order `m`.
    pub(super) fn start(&self, m: usize) -> f64 {
        self.orders[m].1
    }

    /// Returns the steps of order `m`.
    pub(super) fn steps(&self, m: usize) -> &[Step] {
        &self.steps[self.orders[m].0..self.orders[m + 1].0]
    }

    /// Folds the coefficients of order `m`, l = m upwards, for sums over p_k: sum_l A_l Q_l / sin^m
    /// = sum_k p_k (even_k + z odd_k).
    pub(super) fn fold(
        &self,
        m: usize,
        mut coefficients: impl Iterator<Item = (f64, f64)>,
        folded: &mut Vec<Quad>,
    ) {
        folded.clear();
        let mut next = || coefficients.next().unwrap_or_default();
        let mut even = next();
        folded.extend(self.steps(m).iter().map(|step| {
            let (odd, above) = (next(), next());
            let quad = [
                step.even * even.0 + step.even_above * above.0,
                step.even * even.1 + step.even_above * above.1,
                step.odd * odd.0,
                step.odd * odd.1,
            ];
            even = above;
            quad
        }));
    }

    /// Unfolds sums of order `m` over nodes, sum f p_k and sum f z p_k, into moments of f against
    /// Q_l / sin^m: the transpose of [`TwoStep::fold`].
    pub(super) fn unfold(&self, m: usize, sums: &[Quad], mut moment: impl FnMut(usize, f64, f64)) {
        let mut below = (0.0, 0.0);
        for (k, (step, sum)) in self.steps(m).iter().zip(sums).enumerate() {
            let l = m + 2 * k;
            moment(l, step.even * sum[0] + below.0, step.even * sum[1] + below.1);
            below = (step.even_above * sum[0], step.even_above * sum[1]);
            if l < self.lmax {
                moment(l + 1, step.odd * sum[2], step.odd * sum[3]);
            }
        }
    }
}

/// Sums p_k times Q numbers a step over the steps of one order, at N times eight values of z^2.
#[inline(always)]
pub(super) fn sum_steps<'a, S: Simd, const N: usize, const Q: usize>(
    simd: S,
    start: f64,
    squares: [f64x8<S>; N],
    terms: impl Iterator<Item = (&'a Step, [f64; Q])>,
) -> [[f64x8<S>; Q]; N] {
    let zero = f64x8::splat(simd, 0.0);
    let mut before = [zero; N];
    let mut p = [f64x8::splat(simd, start); N];
    let mut sums = [[zero; Q]; N];
    for (step, factors) in terms {
        let factors = factors.map(
            #[inline(always)]
            |x| f64x8::splat(simd, x),
        );
        for i in 0..N {
            for (sum, factor) in sums[i].iter_mut().zip(factors) {
                *sum = p[i].mul_add(factor, *sum);
            }
        }
        advance(simd, step, squares, &mut before, &mut p);
    }
    sums
}

/// Moves p_k and p_(k-1) on by one step.
#[inline(always)]
pub(super) fn advance<S: Simd, const N: usize>(
    simd: S,
    step: &Step,
    squares: [f64x8<S>; N],
    before: &mut [f64x8<S>; N],
    p: &mut [f64x8<S>; N],
) {
    let (a, b) = (f64x8::splat(simd, step.a), f64x8::splat(simd, step.b));
    for i in 0..N {
        let next = squares[i].mul_add(a, b).mul_sub(p[i], before[i]);
        before[i] = p[i];
        p[i] = next;
    }
}

/// Appends the steps of one order.
fn push_order(lmax: usize, m: usize, steps: &mut Vec<Step>) {
    let e = |l: usize| (((l - m) * (l + m)) as f64 / ((2 * l - 1) * (2 * l + 1)) as f64).sqrt();
    let norm = |l: usize| 1.0 / ((2 * l + 1) as f64).sqrt();
    // s_(k-1), s_k and s_(k+1); the first two are free.
    let (mut last_scale, mut scale, mut next_scale) = (1.0, 1.0, 1.0);
    let mut last_product = 0.0;
    for k in 0..count(lmax, m) {
        // The degree of p_k, and e_l, e_(l+1), e_(l+2).
        let l = m + 2 * k + 1;
        let [e0, e1, e2] = [e(l), e(l + 1), e(l + 2)];
        let product = e1 * e2;
        if k > 0 {
            next_scale = last_scale * last_product / product;
        }
        let a = scale / (next_scale * product);
        steps.push(Step {
            a,
            b: -a * (e1 * e1 + e0 * e0),
            even: norm(l - 1) * e0 * scale,
            even_above: norm(l + 1) * e1 * scale,
            odd: norm(l) * scale,
        });
        (last_scale, scale, last_product) = (scale, next_scale, product);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns Q_l^m(z) / sin^m by folding a unit coefficient.
    fn function(recurrence: &TwoStep, l: usize, m: usize, z: f64) -> f64 {
        let mut folded = Vec::new();
        recurrence.fold(
            m,
            (m..=l).map(|degree| (f64::from(u8::from(degree == l)), 0.0)),
            &mut folded,
        );
        let (mut before, mut p) = (0.0, recurrence.start(m));
        let mut sum = 0.0;
        for (step, quad) in recurrence.steps(m).iter().zip(&folded) {
            sum += p * (quad[0] + z * quad[2]);
            (before, p) = (p, (step.a * z * z + step.b) * p - before);
        }
        sum
    }

    #[test]
    fn degrees_zero_to_three_match_closed_forms() {
        let recurrence = TwoStep::new(3);
        for z in [-1.0, -0.3, 0.0, 0.7, 1.0] {
            for (l, m, exact) in [
                (0, 0, 1.0),
                (1, 0, z),
                (1, 1, -0.5_f64.sqrt()),
                (2, 0, 0.5 * (3.0 * z * z - 1.0)),
                (2, 1, -(1.5_f64).sqrt() * z),
                (2, 2, (3.0_f64 / 8.0).sqrt()),
                (3, 1, -(3.0_f64.sqrt() / 4.0) * (5.0 * z * z - 1.0)),
                (3, 2, 30.0_f64.sqrt() / 4.0 * z),
                (3, 3, -(5.0_f64.sqrt()) / 4.0),
            ] {
                let found = function(&recurrence, l, m, z);
                assert!((found - exact).abs() <= 4e-15, "({l}, {m}) at {z}: {found} {exact}");
            }
        }
    }

    #[test]
    fn high_degrees_match_values_of_60_digit_arithmetic() {
        // Q_l^m(z) by the classical recurrence and exact factorials in 60 digits.
        let recurrence = TwoStep::new(1400);
        for (l, m, z, expected) in [
            (64, 0, 0.25, -0.083_870_677_970_132_04),
            (64, 17, -0.75, -0.123_255_040_838_961_67),
            (128, 100, 0.5, 0.068_435_144_202_337_19),
            (256, 3, 0.9375, 0.053_124_252_694_964_46),
            (256, 200, 0.125, 0.023_288_169_805_415_09),
            (1000, 500, 0.5, 0.029_155_438_505_408_24),
            (1400, 1, -0.625, -0.002_358_453_799_069_33),
        ] {
            let sine = f64::sqrt(1.0 - z * z).powi(i32::try_from(m).expect("small"));
            let q = function(&recurrence, l, m, z) * sine;
            // The recurrence loses about l^1.5 roundings, the power m.
            let tolerance = 4.0 * f64::EPSILON * (l as f64).powf(1.5);
            assert!((q - expected).abs() <= tolerance, "({l}, {m}): {q:e} against {expected:e}");
        }
    }

    #[test]
    fn unfolding_is_the_transpose_of_folding() {
        for (lmax, m) in [(0, 0), (1, 0), (1, 1), (7, 2), (8, 2), (8, 8)] {
            let recurrence = TwoStep::new(lmax);
            let value = |i: usize| ((i * 7 + 3) as f64).sin();
            let sums: Vec<Quad> =
                (0..count(lmax, m)).map(|k| [0, 1, 2, 3].map(|i| value(4 * k + i))).collect();
            let mut folded = Vec::new();
            let coefficient = |l| (value(l), value(l + 50));
            recurrence.fold(m, (m..=lmax).map(coefficient), &mut folded);
            let left: f64 =
                folded.iter().flatten().zip(sums.iter().flatten()).map(|(x, y)| x * y).sum();
            let mut right = 0.0;
            recurrence.unfold(m, &sums, |l, a, b| {
                let (x, y) = coefficient(l);
                right += a * x + b * y;
            });
            assert!((left - right).abs() <= 1e-13 * (1.0 + left.abs()), "{lmax} {m}");
        }
    }
}
