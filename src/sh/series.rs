//! Values and gradients of a spherical-harmonic series at a direction.
//!
//! The series is evaluated as the polynomial F(x, y, z) = sum_m sum_l R_l^m(z) Re[(A_lm - i
//! B_lm)(x + iy)^m], see `legendre`. Its Cartesian gradient, made tangential, is the surface
//! gradient; d R_l^m / dz = -sqrt((l-m)(l+m+1)) R_l^(m+1).

use std::sync::OnceLock;

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f64x8};
use glam::DVec3;
use rayon::prelude::*;

use super::Coefficients;
use super::batch::Batch;
use super::legendre::{Block, LANES, Lanes, MAX_DEGREE, Powers, Recurrence, blocked, blocks, sum};
use crate::{Error, Result};

/// Directions that one task evaluates.
const PER_TASK: usize = 1024;

/// Evaluates a series at directions; built once from its coefficients.
///
/// ```
/// use glam::DVec3;
/// use harmolux::sh::{Coefficients, Series};
///
/// let mut c = Coefficients::zeros(1);
/// c.set(0, 0, 2.0, 0.0);
/// c.set(1, 0, 0.5, 0.0); // f = 2 + 0.5 cos(theta)
/// let f = Series::new(&c)?;
/// assert!((f.value(DVec3::Z) - 2.5).abs() < 1e-15);
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Series {
    coefficients: Coefficients,
    recurrence: Recurrence,
    /// Per row of the recurrence: A_lm, B_lm.
    values: Vec<[Lanes; 2]>,
    /// Per row: what R_l^m contributes to d/dz, that is -sqrt((l-m+1)(l+m)) times A and B of (l,
    /// m-1).
    slopes: Vec<[Lanes; 2]>,
    /// For many directions at once; made when first asked for.
    batch: OnceLock<Batch>,
    level: Level,
}

/// Holds a value of the series and its surface gradient on the unit sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet {
    /// f(omega).
    pub value: f64,
    /// grad_S f(omega), a tangent vector: orthogonal to omega; same unit as f per radian.
    pub gradient: DVec3,
}

impl Series {
    /// Prepares the evaluation of a series.
    ///
    /// # Errors
    /// [`Error::Parameter`] above degree [`MAX_DEGREE`], where the Legendre functions leave the
    /// range of f64.
    pub fn new(coefficients: &Coefficients) -> Result<Self> {
        let lmax = coefficients.lmax();
        if lmax > MAX_DEGREE {
            return Err(Error::Parameter(format!(
                "degree {lmax} is above {MAX_DEGREE}, the highest that f64 can evaluate; truncate \
                 the series"
            )));
        }
        let pair = |entry: &dyn Fn(usize, usize) -> (f64, f64)| -> Vec<[Lanes; 2]> {
            let a = blocked(lmax, |l, m| entry(l, m).0);
            let b = blocked(lmax, |l, m| entry(l, m).1);
            a.into_iter().zip(b).map(|(a, b)| [a, b]).collect()
        };
        Ok(Self {
            recurrence: Recurrence::new(lmax),
            values: pair(&|l, m| coefficients.get(l, m)),
            slopes: pair(&|l, m| slope(coefficients, l, m)),
            batch: OnceLock::new(),
            coefficients: coefficients.clone(),
            level: Level::new(),
        })
    }

    /// Returns the coefficients the series was made from.
    pub fn coefficients(&self) -> &Coefficients {
        &self.coefficients
    }

    /// Evaluates f at the unit vector `direction`.
    pub fn value(&self, direction: DVec3) -> f64 {
        dispatch!(self.level, simd => self.value_simd(simd, direction))
    }

    /// Evaluates f and its surface gradient at the unit vector `direction`, at the poles too.
    pub fn jet(&self, direction: DVec3) -> Jet {
        dispatch!(self.level, simd => self.jet_simd(simd, direction))
    }

    /// Evaluates f at many unit vectors, on all threads; the same to rounding as [`Series::value`]
    /// at each, and several times as fast.
    pub fn values(&self, directions: &[DVec3]) -> Vec<f64> {
        let mut values = vec![0.0; directions.len()];
        values
            .par_chunks_mut(PER_TASK)
            .zip(directions.par_chunks(PER_TASK))
            .for_each(|(values, directions)| self.batch().values(directions, values));
        values
    }

    /// Evaluates f and its surface gradient at many unit vectors, on all threads; see
    /// [`Series::values`].
    pub fn jets(&self, directions: &[DVec3]) -> Vec<Jet> {
        let mut jets = vec![Jet { value: 0.0, gradient: DVec3::ZERO }; directions.len()];
        jets.par_chunks_mut(PER_TASK)
            .zip(directions.par_chunks(PER_TASK))
            .for_each(|(jets, directions)| self.batch().jets(directions, jets));
        jets
    }

    fn batch(&self) -> &Batch {
        self.batch.get_or_init(|| Batch::new(&self.coefficients))
    }

    #[inline(always)]
    fn value_simd<S: Simd>(&self, simd: S, w: DVec3) -> f64 {
        let mut powers = Powers::new(simd, w.x, w.y);
        let mut total = f64x8::splat(simd, 0.0);
        for block in blocks(self.recurrence.lmax()) {
            let [a, b] = self.amplitudes(simd, block, w.z);
            total += powers.re * a + powers.im * b;
            powers.advance();
        }
        sum(total.into())
    }

    #[inline(always)]
    fn jet_simd<S: Simd>(&self, simd: S, w: DVec3) -> Jet {
        let zero = f64x8::splat(simd, 0.0);
        let mut powers = Powers::new(simd, w.x, w.y);
        // (x + iy)^(m-1): the powers moved up by one lane, the last lane of the block before
        // entering.
        let (mut previous_re, mut previous_im) = (zero, zero);
        let mut orders = f64x8::simd_from(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let [mut f, mut fx, mut fy, mut fz] = [zero; 4];
        for block in blocks(self.recurrence.lmax()) {
            let [mut a, mut b, mut da, mut db] = [zero; 4];
            let rows = self.values[block.row..].iter().zip(&self.slopes[block.row..]);
            let mut rows = rows;
            self.recurrence.sweep(
                simd,
                block,
                w.z,
                #[inline(always)]
                |_, r| {
                    if let Some((values, slopes)) = rows.next() {
                        accumulate(simd, values, r, &mut a, &mut b);
                        accumulate(simd, slopes, r, &mut da, &mut db);
                    }
                },
            );
            let c = previous_re.slide::<7>(powers.re);
            let s = previous_im.slide::<7>(powers.im);
            f += powers.re * a + powers.im * b;
            fx += orders * (c * a + s * b);
            fy += orders * (c * b - s * a);
            fz += c * da + s * db;
            (previous_re, previous_im) = (powers.re, powers.im);
            orders += LANES as f64;
            powers.advance();
        }
        let full = DVec3::new(sum(fx.into()), sum(fy.into()), sum(fz.into()));
        Jet { value: sum(f.into()), gradient: full - w * w.dot(full) }
    }

    /// Sums one block over degrees: sum_l A_lm R_l^m and sum_l B_lm R_l^m.
    #[inline(always)]
    fn amplitudes<S: Simd>(&self, simd: S, block: Block, z: f64) -> [f64x8<S>; 2] {
        let zero = f64x8::splat(simd, 0.0);
        let (mut a, mut b) = (zero, zero);
        let mut rows = self.values[block.row..].iter();
        self.recurrence.sweep(
            simd,
            block,
            z,
            #[inline(always)]
            |_, r| {
                if let Some(row) = rows.next() {
                    accumulate(simd, row, r, &mut a, &mut b);
                }
            },
        );
        [a, b]
    }
}

/// Returns what (A, B) of (l, m - 1) contribute to d/dz by R_l^m, since d R_l^m / dz =
/// -sqrt((l-m)(l+m+1)) R_l^(m+1).
pub(super) fn slope(coefficients: &Coefficients, l: usize, m: usize) -> (f64, f64) {
    if m == 0 {
        return (0.0, 0.0);
    }
    let k = -(((l + 1 - m) * (l + m)) as f64).sqrt();
    let (a, b) = coefficients.get(l, m - 1);
    (k * a, k * b)
}

/// Adds one row: coefficients times Legendre functions.
#[inline(always)]
fn accumulate<S: Simd>(
    simd: S,
    [a, b]: &[Lanes; 2],
    r: f64x8<S>,
    sum_a: &mut f64x8<S>,
    sum_b: &mut f64x8<S>,
) {
    *sum_a = f64x8::simd_from(simd, *a).mul_add(r, *sum_a);
    *sum_b = f64x8::simd_from(simd, *b).mul_add(r, *sum_b);
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::math::sampling::uniform_sphere;

    fn random_series(lmax: usize, seed: u64) -> Series {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut c = Coefficients::zeros(lmax);
        for l in 0..=lmax {
            for m in 0..=l {
                let k = 1.0 / (1 + l) as f64;
                c.set(l, m, k * (rng.random::<f64>() - 0.5), k * (rng.random::<f64>() - 0.5));
            }
        }
        Series::new(&c).expect("small degree")
    }

    #[test]
    fn degree_zero_is_constant() {
        let mut c = Coefficients::zeros(0);
        c.set(0, 0, 3.0, 0.0);
        let jet = Series::new(&c).expect("degree 0").jet(DVec3::Z);
        assert_eq!((jet.value, jet.gradient), (3.0, DVec3::ZERO));
    }

    #[test]
    fn gradient_matches_central_differences_at_the_poles_too() {
        let f = random_series(20, 1);
        let directions = (0..20)
            .map(|i| uniform_sphere([(f64::from(i) + 0.5) / 20.0, (f64::from(i) * 0.618).fract()]));
        for w in directions.chain([DVec3::Z, DVec3::NEG_Z, DVec3::new(1e-9, 0.0, 1.0).normalize()])
        {
            let jet = f.jet(w);
            assert!((jet.value - f.value(w)).abs() <= 1e-14);
            assert!(jet.gradient.dot(w).abs() <= 1e-13);
            let h = 1e-5;
            for t in [w.any_orthonormal_vector(), w.cross(w.any_orthonormal_vector())] {
                let (plus, minus) = ((w + h * t).normalize(), (w - h * t).normalize());
                let slope = (f.value(plus) - f.value(minus)) / (2.0 * h);
                // Truncation h^2 f'''/6 is below 1e-8 here, rounding 1e-15/h.
                assert!((slope - jet.gradient.dot(t)).abs() <= 1e-7, "{w}");
            }
        }
    }

    #[test]
    fn many_directions_are_evaluated_as_one() {
        for (lmax, seed) in [(0, 1), (1, 2), (20, 3), (61, 4)] {
            let f = random_series(lmax, seed);
            let golden = 0.618_033_988_749_895;
            let mut directions: Vec<DVec3> = (0..51)
                .map(|i| {
                    uniform_sphere([(f64::from(i) + 0.5) / 51.0, (f64::from(i) * golden).fract()])
                })
                .collect();
            directions.extend([DVec3::Z, DVec3::NEG_Z, DVec3::X]);
            for count in [0, 1, 8, 9, 17, directions.len()] {
                let (values, jets) = (f.values(&directions[..count]), f.jets(&directions[..count]));
                assert_eq!((values.len(), jets.len()), (count, count));
                for ((w, value), jet) in directions.iter().zip(values).zip(jets) {
                    let one = f.jet(*w);
                    // Sums of lmax^2 terms of order 1/lmax, and as many times lmax for the
                    // gradient.
                    let tolerance = 1e-15 * (8 + lmax * lmax) as f64;
                    assert!((value - one.value).abs() <= tolerance);
                    assert!((jet.value - one.value).abs() <= tolerance);
                    let gap = (jet.gradient - one.gradient).length();
                    assert!(gap <= tolerance * (1 + lmax) as f64, "{lmax} {w} {gap}");
                }
            }
        }
    }

    #[test]
    fn too_high_degrees_are_refused() {
        assert!(Series::new(&Coefficients::zeros(MAX_DEGREE + 1)).is_err());
    }
}
