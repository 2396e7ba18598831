//! Values and gradients of a series at many directions at once, eight directions side by side.
//!
//! The sums are those of `series`, on the two-step recurrence: for each order m the even and odd
//! parts of sum_l A_lm R_l^m, and of what the order contributes to d/dz, -sqrt((l-m+1)(l+m))
//! A_l(m-1) R_l^m. Exact to rounding, whatever the directions.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f64x8};
use glam::DVec3;

use super::Coefficients;
use super::legendre::{LANES, Lanes};
use super::series::{Jet, slope};
use super::two_step::{Quad, Step, TwoStep, sum_steps};

/// Holds a series folded for evaluation at many directions.
#[derive(Debug, Clone)]
pub(super) struct Batch {
    recurrence: TwoStep,
    /// Per order: its steps with the folded coefficients of f and of d/dz.
    orders: Vec<Vec<Term>>,
    level: Level,
}

/// One step of the recurrence and what p_k is multiplied with.
#[derive(Debug, Clone, Copy)]
struct Term {
    step: Step,
    value: Quad,
    /// `value`, and the same for d/dz.
    value_and_slope: [f64; 8],
}

impl Batch {
    /// Folds the coefficients.
    pub(super) fn new(coefficients: &Coefficients) -> Self {
        let recurrence = TwoStep::new(coefficients.lmax());
        let (mut values, mut slopes) = (Vec::new(), Vec::new());
        let mut order = |m| {
            recurrence.fold(m, coefficients.column(m), &mut values);
            recurrence.fold(
                m,
                (m..=coefficients.lmax()).map(|l| slope(coefficients, l, m)),
                &mut slopes,
            );
            let terms = recurrence.steps(m).iter().zip(values.iter().zip(&slopes));
            terms
                .map(|(step, (value, slope))| Term {
                    step: *step,
                    value: *value,
                    value_and_slope: joined(*value, *slope),
                })
                .collect()
        };
        let orders = (0..=coefficients.lmax()).map(&mut order).collect();
        Self { recurrence, orders, level: Level::new() }
    }

    /// Evaluates f at unit vectors.
    pub(super) fn values(&self, directions: &[DVec3], values: &mut [f64]) {
        dispatch!(self.level, simd => {
            for_each_group(directions, values, #[inline(always)] |group, values| {
                match group.len() {
                    2 => self.values_at::<_, 2>(simd, group, values),
                    _ => self.values_at::<_, 1>(simd, group, values),
                }
            });
        });
    }

    /// Evaluates f and its surface gradient at unit vectors.
    pub(super) fn jets(&self, directions: &[DVec3], jets: &mut [Jet]) {
        dispatch!(self.level, simd => {
            for_each_group(directions, jets, #[inline(always)] |group, jets| {
                match group.len() {
                    2 => self.jets_at::<_, 2>(simd, group, jets),
                    _ => self.jets_at::<_, 1>(simd, group, jets),
                }
            });
        });
    }

    #[inline(always)]
    fn values_at<S: Simd, const N: usize>(&self, simd: S, at: &[Point], values: &mut [f64]) {
        let zero = f64x8::splat(simd, 0.0);
        let [x, y, z] = coordinates::<S, N>(simd, at);
        let squares = z.map(
            #[inline(always)]
            |z| z * z,
        );
        let (mut re, mut im) = ([f64x8::splat(simd, 1.0); N], [zero; N]);
        let mut f = [zero; N];
        for (m, terms) in self.orders.iter().enumerate() {
            let terms = terms.iter().map(
                #[inline(always)]
                |t| (&t.step, t.value),
            );
            let sums = sum_steps(simd, self.recurrence.start(m), squares, terms);
            for i in 0..N {
                let [ea, eb, oa, ob] = sums[i];
                let (a, b) = (z[i].mul_add(oa, ea), z[i].mul_add(ob, eb));
                f[i] = re[i].mul_add(a, im[i].mul_add(b, f[i]));
                (re[i], im[i]) = turned(re[i], im[i], x[i], y[i]);
            }
        }
        for (value, lane) in values.iter_mut().zip(f.iter().flat_map(|v| Lanes::from(*v))) {
            *value = lane;
        }
    }

    #[inline(always)]
    fn jets_at<S: Simd, const N: usize>(&self, simd: S, at: &[Point], jets: &mut [Jet]) {
        let zero = f64x8::splat(simd, 0.0);
        let [x, y, z] = coordinates::<S, N>(simd, at);
        let squares = z.map(
            #[inline(always)]
            |z| z * z,
        );
        let (mut re, mut im) = ([f64x8::splat(simd, 1.0); N], [zero; N]);
        // (x + iy)^(m-1).
        let (mut last_re, mut last_im) = ([zero; N], [zero; N]);
        let mut sums = [[zero; 4]; N];
        for (m, terms) in self.orders.iter().enumerate() {
            let order = f64x8::splat(simd, m as f64);
            let terms = terms.iter().map(
                #[inline(always)]
                |t| (&t.step, t.value_and_slope),
            );
            let degrees = sum_steps(simd, self.recurrence.start(m), squares, terms);
            for i in 0..N {
                let [ea, eb, oa, ob, sea, seb, soa, sob] = degrees[i];
                let (a, b) = (z[i].mul_add(oa, ea), z[i].mul_add(ob, eb));
                let (da, db) = (z[i].mul_add(soa, sea), z[i].mul_add(sob, seb));
                let (c, s) = (last_re[i] * order, last_im[i] * order);
                let [f, fx, fy, fz] = &mut sums[i];
                *f = re[i].mul_add(a, im[i].mul_add(b, *f));
                *fx = c.mul_add(a, s.mul_add(b, *fx));
                *fy = c.mul_add(b, (-s).mul_add(a, *fy));
                *fz = last_re[i].mul_add(da, last_im[i].mul_add(db, *fz));
                (last_re[i], last_im[i]) = (re[i], im[i]);
                (re[i], im[i]) = turned(re[i], im[i], x[i], y[i]);
            }
        }
        for (sums, (point, jets)) in sums.iter().zip(at.iter().zip(jets.chunks_mut(LANES))) {
            let [f, fx, fy, fz] = sums.map(Lanes::from);
            for (lane, jet) in jets.iter_mut().enumerate() {
                let full = DVec3::new(fx[lane], fy[lane], fz[lane]);
                let w = DVec3::new(point[0][lane], point[1][lane], point[2][lane]);
                *jet = Jet { value: f[lane], gradient: full - w * w.dot(full) };
            }
        }
    }
}

fn joined([a, b, c, d]: Quad, [e, f, g, h]: Quad) -> [f64; 8] {
    [a, b, c, d, e, f, g, h]
}

/// Eight directions: their x, y and z.
type Point = [Lanes; 3];

/// Cuts directions and results into groups of up to two vectors; missing directions are zero.
#[inline(always)]
fn for_each_group<T>(
    directions: &[DVec3],
    results: &mut [T],
    mut visit: impl FnMut(&[Point], &mut [T]),
) {
    const WIDE: usize = 2;
    for (directions, results) in
        directions.chunks(WIDE * LANES).zip(results.chunks_mut(WIDE * LANES))
    {
        let mut group = [[[0.0; LANES]; 3]; WIDE];
        for (i, w) in directions.iter().enumerate() {
            for (axis, value) in w.to_array().into_iter().enumerate() {
                group[i / LANES][axis][i % LANES] = value;
            }
        }
        visit(&group[..directions.len().div_ceil(LANES)], results);
    }
}

/// Returns x, y and z of N times eight directions as vectors.
#[inline(always)]
fn coordinates<S: Simd, const N: usize>(simd: S, at: &[Point]) -> [[f64x8<S>; N]; 3] {
    let mut result = [[f64x8::splat(simd, 0.0); N]; 3];
    for axis in 0..3 {
        for i in 0..N {
            result[axis][i] = f64x8::simd_from(simd, at[i][axis]);
        }
    }
    result
}

/// Multiplies re + i im by x + iy.
#[inline(always)]
fn turned<S: Simd>(re: f64x8<S>, im: f64x8<S>, x: f64x8<S>, y: f64x8<S>) -> (f64x8<S>, f64x8<S>) {
    (re.mul_sub(x, im * y), re.mul_add(y, im * x))
}
