//! The Schmidt semi-normalised Legendre functions by recurrence, eight orders at a time.
//!
//! What is swept is R_l^m(z) = Q_l^m(z) / sin^m(theta), a polynomial in z = cos(theta): together
//! with (x + iy)^m = sin^m(theta) e^(i m phi) it makes every basis function a polynomial of the
//! Cartesian direction, so values and gradients need no division and no case at the poles. R obeys
//! the recurrences of Q,
//!
//! R_m^m = -sqrt((2m-1)/(2m)) R_(m-1)^(m-1),   R_l^m = [(2l-1) z R_(l-1)^m - sqrt((l-1)^2 - m^2)
//! R_(l-2)^m] / sqrt(l^2 - m^2),
//!
//! with the same rounding (5e-14 at l = 32, 3e-12 at l = 256). Its growth is at most the golden
//! ratio to the power l, so f64 holds it up to [`MAX_DEGREE`].

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};

/// Bounds the degree of every series: beyond it R_l^m would leave the range of f64.
pub const MAX_DEGREE: usize = 1400;

/// Orders that are swept side by side.
pub(super) const LANES: usize = 8;

/// One number for each of eight consecutive orders.
pub(super) type Lanes = [f64; LANES];

/// Holds the factors of the recurrence for all degrees up to `lmax`, in blocks of eight orders.
///
/// Block k holds the orders m = 8k + lane and one row for each degree l = 8k..=lmax; rows of
/// successive blocks follow each other.
#[derive(Debug, Clone)]
pub(super) struct Recurrence {
    lmax: usize,
    /// Per row: the factor of z R_(l-1) and the factor of R_(l-2); zero where l <= m.
    rows: Vec<[Lanes; 2]>,
    /// Per order m: R_m^m in the lane of m, 0 elsewhere.
    seeds: Vec<Lanes>,
}

/// Names the rows of one block: its first order (also its first degree) and where its rows start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Block {
    pub(super) first: usize,
    pub(super) row: usize,
}

/// Lists the blocks of a triangle of degree `lmax`.
pub(super) fn blocks(lmax: usize) -> impl Iterator<Item = Block> {
    let mut row = 0;
    (0..=lmax).step_by(LANES).map(move |first| {
        let block = Block { first, row };
        row += lmax + 1 - first;
        block
    })
}

/// Lays a triangle of numbers out in blocked rows: `entry(l, m)` for m <= l, 0 elsewhere.
pub(super) fn blocked(lmax: usize, entry: impl Fn(usize, usize) -> f64) -> Vec<Lanes> {
    blocks(lmax)
        .flat_map(|block| (block.first..=lmax).map(move |l| (block.first, l)))
        .map(|(first, l)| {
            std::array::from_fn(|lane| if first + lane <= l { entry(l, first + lane) } else { 0.0 })
        })
        .collect()
}

/// Returns R_m^m for m = 0..=lmax.
fn diagonal(lmax: usize) -> Vec<f64> {
    let step = |r: &mut f64, m: usize| {
        if m > 0 {
            *r *= -((2 * m - 1) as f64 / (2 * m) as f64).sqrt();
        }
        Some(*r)
    };
    (0..=lmax).scan(1.0, step).collect()
}

/// Returns l^2 - m^2 without loss.
fn difference_of_squares(l: usize, m: usize) -> f64 {
    ((l - m) * (l + m)) as f64
}

impl Recurrence {
    /// Tabulates the factors up to degree `lmax`.
    pub(super) fn new(lmax: usize) -> Self {
        let up = blocked(lmax, |l, m| {
            if l > m { (2 * l - 1) as f64 / difference_of_squares(l, m).sqrt() } else { 0.0 }
        });
        let down = blocked(lmax, |l, m| {
            if l > m + 1 {
                (difference_of_squares(l - 1, m) / difference_of_squares(l, m)).sqrt()
            } else {
                0.0
            }
        });
        let rows = up.into_iter().zip(down).map(|(a, b)| [a, b]).collect();
        let seeds = diagonal(lmax)
            .into_iter()
            .enumerate()
            .map(|(m, r)| std::array::from_fn(|lane| if lane == m % LANES { r } else { 0.0 }));
        Self { lmax, rows, seeds: seeds.collect() }
    }

    /// Returns the truncation degree.
    pub(super) fn lmax(&self) -> usize {
        self.lmax
    }

    /// Sweeps one block upwards in degree at z = cos(theta) and shows each row, numbered from 0
    /// within the block, with its R_l^m.
    #[inline(always)]
    pub(super) fn sweep<S: Simd>(
        &self,
        simd: S,
        block: Block,
        z: f64,
        mut visit: impl FnMut(usize, f64x8<S>),
    ) {
        let rows = &self.rows[block.row..block.row + self.lmax + 1 - block.first];
        let z = f64x8::splat(simd, z);
        let mut before = f64x8::splat(simd, 0.0);
        let mut last = before;
        for (i, [up, down]) in rows.iter().enumerate() {
            let up = f64x8::simd_from(simd, *up) * z;
            let down = f64x8::simd_from(simd, *down) * before;
            let mut next = up.mul_sub(last, down);
            if i < LANES {
                next += f64x8::simd_from(simd, self.seeds[block.first + i]);
            }
            visit(i, next);
            before = last;
            last = next;
        }
    }
}

/// Returns (x + iy)^m for the eight orders of successive blocks, as real and imaginary parts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Powers<S: Simd> {
    pub(super) re: f64x8<S>,
    pub(super) im: f64x8<S>,
    /// (x + iy)^8.
    step: [f64; 2],
}

impl<S: Simd> Powers<S> {
    /// Starts with the orders 0..8.
    #[inline(always)]
    pub(super) fn new(simd: S, x: f64, y: f64) -> Self {
        let p1 = [x, y];
        let p2 = complex_product(p1, p1);
        let p3 = complex_product(p2, p1);
        let p4 = complex_product(p2, p2);
        let p5 = complex_product(p4, p1);
        let p6 = complex_product(p4, p2);
        let p7 = complex_product(p4, p3);
        Self {
            re: [1.0, x, p2[0], p3[0], p4[0], p5[0], p6[0], p7[0]].simd_into(simd),
            im: [0.0, y, p2[1], p3[1], p4[1], p5[1], p6[1], p7[1]].simd_into(simd),
            step: complex_product(p4, p4),
        }
    }

    /// Moves on to the next eight orders.
    #[inline(always)]
    pub(super) fn advance(&mut self) {
        let [c, d] = self.step;
        (self.re, self.im) = (self.re * c - self.im * d, self.re * d + self.im * c);
    }
}

#[inline(always)]
fn complex_product([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}

/// Adds the lanes in one fixed order, the same on every instruction set.
#[inline(always)]
pub(super) fn sum(v: Lanes) -> f64 {
    ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]))
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;

    /// Lists Q_l^m(cos theta), degree-major, from the blocked sweep.
    fn functions(lmax: usize, theta: f64) -> Vec<f64> {
        let recurrence = Recurrence::new(lmax);
        let mut q = vec![0.0; (lmax + 1) * (lmax + 2) / 2];
        for block in blocks(lmax) {
            let simd = fearless_simd::Level::baseline();
            dispatch!(simd, simd => recurrence.sweep(simd, block, theta.cos(), |i, r| {
                let l = block.first + i;
                for (lane, value) in r.as_slice().iter().enumerate().take(l + 1 - block.first) {
                    let m = block.first + lane;
                    let power = i32::try_from(m).expect("small");
                    q[l * (l + 1) / 2 + m] = value * theta.sin().powi(power);
                }
            }));
        }
        q
    }

    #[test]
    fn low_degrees_match_closed_forms() {
        for theta in [0.0_f64, 0.3, 1.2, 2.9] {
            let (s, z) = theta.sin_cos();
            let exact = [
                1.0,
                z,
                -s / 2.0_f64.sqrt(),
                0.5 * (3.0 * z * z - 1.0),
                -(1.5_f64).sqrt() * s * z,
                (3.0_f64 / 8.0).sqrt() * s * s,
                0.5 * (5.0 * z.powi(3) - 3.0 * z),
                -(3.0_f64.sqrt() / 4.0) * s * (5.0 * z * z - 1.0),
                (30.0_f64.sqrt() / 4.0) * s * s * z,
                -(5.0_f64.sqrt() / 4.0) * s.powi(3),
            ];
            for (q, e) in functions(3, theta).iter().zip(exact) {
                assert!((q - e).abs() <= 2e-15, "theta {theta}: {q} against {e}");
            }
        }
    }

    #[test]
    fn high_degrees_match_values_of_60_digit_arithmetic() {
        // Q_l^m(z) by the classical recurrence and exact factorials in 60 digits.
        let table = [
            (64, 0, 0.25, -0.083_870_677_970_132_04),
            (64, 17, -0.75, -0.123_255_040_838_961_67),
            (128, 100, 0.5, 0.068_435_144_202_337_19),
            (256, 3, 0.9375, 0.053_124_252_694_964_46),
            (256, 200, 0.125, 0.023_288_169_805_415_09),
            (1000, 500, 0.5, 0.029_155_438_505_408_24),
            (1400, 1, -0.625, -0.002_358_453_799_069_33),
        ];
        for (l, m, z, expected) in table {
            let q = functions(l, f64::acos(z))[l * (l + 1) / 2 + m];
            // The recurrence loses about l^1.5 roundings; theta = acos(z) costs l more.
            let tolerance = 4.0 * f64::EPSILON * (l as f64).powf(1.5);
            assert!((q - expected).abs() <= tolerance, "({l}, {m}): {q:e} against {expected:e}");
        }
    }

    #[test]
    fn addition_theorem_holds_up_to_degree_256() {
        // Q_l0^2 + 2 sum_m Q_lm^2 = 1; the recurrence loses 5e-14 at l = 32 and 3e-12 at l = 256.
        for theta in [1e-8_f64, 0.1, 0.7, 1.55, 3.0] {
            let q = functions(256, theta);
            for (l, tolerance) in [(32, 1e-13), (256, 1e-11)] {
                let row = &q[l * (l + 1) / 2..(l + 1) * (l + 2) / 2];
                let sum = row[0] * row[0] + 2.0 * row[1..].iter().map(|v| v * v).sum::<f64>();
                assert!((sum - 1.0).abs() <= tolerance, "l {l}, theta {theta}: {sum}");
            }
        }
    }

    #[test]
    fn highest_degree_stays_finite() {
        for theta in [0.0, 1e-3, 0.5, 1.1, 3.1] {
            let q = functions(MAX_DEGREE, theta);
            assert!(q.iter().all(|v| v.abs() <= 1.0 + 1e-9), "theta {theta}");
        }
    }
}
