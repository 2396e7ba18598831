//! Weighted least squares: the series that comes closest to scattered samples.
//!
//! Minimises sum_j w_j (f(omega_j) - v_j)^2 + lambda sum_l l^2 (l+1)^2 c_l^2, weights scaled to add
//! up to 4 pi, c the coefficients in the orthonormal basis: Tikhonov's term with the Laplacian of f
//! on the sphere. The normal matrix of (lmax+1)^2 rows is summed over blocks of samples, each block
//! a product of matrices, and factorised in place; the table of samples x coefficients is never
//! whole. For samples that cover the sphere with weights that are their solid angles the matrix is
//! near the identity, so that squaring the condition costs nothing; one step of refinement takes
//! the rounding of sums and factors back.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::{Coefficients, Moments, Series, StandardError};
use crate::{Error, Result};

/// The highest degree: its normal matrix takes 0.8 GB.
pub const MAX_LEAST_SQUARES_DEGREE: usize = 100;

/// Samples whose basis functions are tabulated at once.
const BLOCK: usize = 256;

/// Columns of the normal matrix that are worked on together.
pub(super) const PANEL: usize = 96;

/// The smallest part of a basis function, squared, that the others may leave unexplained at the
/// samples: below it too few digits would be right.
const INDEPENDENT: f64 = 1e-10;

/// Fits a series of degree `lmax` to values at scattered directions.
///
/// `directions` are unit vectors; `values` (any unit) and `weights` (at least 0, their scale does
/// not matter) have as many entries; a weight is best the solid angle a sample stands for, or one
/// over the variance of its value. `lambda`, at least 0, damps the Laplacian of the series: 0
/// leaves the samples alone, 1e-6 damps what degrees above about 30 have no samples for. The result
/// does not depend on the number of threads.
///
/// # Errors
/// [`Error::Parameter`] when lengths differ, a number is not finite, a weight or `lambda` negative,
/// the degree above [`MAX_LEAST_SQUARES_DEGREE`]; [`Error::Geometry`] when the samples do not
/// determine the series: too few, or leaving a gap on the sphere.
///
/// ```
/// use glam::DVec3;
/// use harmolux::sh::scattered_fit;
///
/// let directions = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
/// let values = directions.map(|w| 2.0 + 0.5 * w.z);
/// let f = scattered_fit(&directions, &values, &[1.0; 6], 1, 0.0)?;
/// assert!((f.mean() - 2.0).abs() < 1e-14 && (f.get(1, 0).0 - 0.5).abs() < 1e-14);
/// # Ok::<(), harmolux::Error>(())
/// ```
pub fn scattered_fit(
    directions: &[DVec3],
    values: &[f64],
    weights: &[f64],
    lmax: usize,
    lambda: f64,
) -> Result<Coefficients> {
    Ok(Solved::of(&Samples::checked(directions, values, weights)?, lmax, lambda)?.fit)
}

/// Fits as [`scattered_fit`] does, and estimates the error that the scatter of the values leaves in
/// the series; `None` where there are no more samples than coefficients.
///
/// # Errors
/// As [`scattered_fit`].
pub fn fit_with_error(
    directions: &[DVec3],
    values: &[f64],
    weights: &[f64],
    lmax: usize,
    lambda: f64,
) -> Result<(Coefficients, Option<StandardError>)> {
    let samples = Samples::checked(directions, values, weights)?;
    let Solved { fit, basis, factor } = Solved::of(&samples, lmax, lambda)?;
    let free = samples.counted.saturating_sub(fit.count());
    let error = if free == 0 {
        None
    } else {
        let variance = samples.square(&Series::new(&fit)?) / free as f64;
        Some(StandardError::of(&factor, &basis, variance))
    };
    Ok((fit, error))
}

/// The series, and the factor of its normal matrix.
struct Solved {
    fit: Coefficients,
    basis: Basis,
    factor: DMatrix<f64>,
}

impl Solved {
    fn of(samples: &Samples, lmax: usize, lambda: f64) -> Result<Self> {
        check_degree(samples.counted, lmax, lambda)?;
        let basis = Basis::new(lmax)?;
        let mut factor = samples.normal_matrix(&basis);
        for (i, damping) in basis.damping(lambda).enumerate() {
            factor[(i, i)] += damping;
        }
        let unexplained = factorise(&mut factor);
        if unexplained.is_none_or(|(_, part)| part < INDEPENDENT) {
            return Err(undetermined(samples.counted, lmax, lambda, unexplained, &basis));
        }
        let mut fit = Coefficients::zeros(lmax);
        // The first pass solves, the second refines by what the first leaves of the samples.
        for _ in 0..2 {
            let mut x = samples.right_side(&basis, &fit, lambda)?;
            solve(&factor, &mut x);
            fit = basis.plus(&fit, &x);
        }
        Ok(Self { fit, basis, factor })
    }
}

/// The samples, checked, and the factor that makes the weights add up to 4 pi.
struct Samples<'a> {
    directions: &'a [DVec3],
    values: &'a [f64],
    weights: &'a [f64],
    scale: f64,
    /// How many weigh anything.
    counted: usize,
}

impl<'a> Samples<'a> {
    fn checked(directions: &'a [DVec3], values: &'a [f64], weights: &'a [f64]) -> Result<Self> {
        let n = directions.len();
        if values.len() != n || weights.len() != n {
            return Err(Error::Parameter(format!(
                "{n} directions take as many values and weights, found {} and {}",
                values.len(),
                weights.len()
            )));
        }
        let wrong = |i: usize| {
            // A NaN must fail, too.
            let unit = (directions[i].length_squared() - 1.0).abs() <= 1e-6;
            let weight = weights[i].is_finite() && weights[i] >= 0.0;
            !(unit && weight && values[i].is_finite())
        };
        if let Some(i) = (0..n).find(|&i| wrong(i)) {
            return Err(Error::Parameter(format!(
                "sample {i} (from 0) needs a unit vector, a finite value and a finite weight from \
                 0 on, found {}, {}, {}",
                directions[i], values[i], weights[i]
            )));
        }
        let sum: f64 = weights.iter().sum();
        let counted = weights.iter().filter(|w| **w > 0.0).count();
        if counted == 0 || !sum.is_finite() {
            return Err(Error::Parameter(format!(
                "the weights of {n} samples add up to {sum}: at least one must be above 0, and \
                 their sum finite"
            )));
        }
        Ok(Self { directions, values, weights, scale: 4.0 * PI / sum, counted })
    }

    /// Sums the lower triangle of the normal matrix, block after block; each entry in one fixed
    /// order.
    fn normal_matrix(&self, basis: &Basis) -> DMatrix<f64> {
        let n = basis.norms.len();
        let mut matrix = DMatrix::zeros(n, n);
        for first in (0..self.directions.len()).step_by(BLOCK) {
            let last = (first + BLOCK).min(self.directions.len());
            let columns: Vec<Vec<f64>> = (first..last)
                .into_par_iter()
                .map(|i| basis.at(self.directions[i], (self.scale * self.weights[i]).sqrt()))
                .collect();
            let table = DMatrix::from_fn(n, columns.len(), |row, column| columns[column][row]);
            add_products(&mut matrix, &table, 0, 1.0);
        }
        matrix
    }

    /// Sums the weighted squares of what a series leaves of the samples.
    fn square(&self, series: &Series) -> f64 {
        let samples = self.directions.iter().zip(self.values).zip(self.weights);
        let square =
            |((w, v), weight): ((&DVec3, &f64), &f64)| weight * (v - series.value(*w)).powi(2);
        self.scale * samples.map(square).sum::<f64>()
    }

    /// Returns what the normal equations ask for beyond a first solution.
    fn right_side(&self, basis: &Basis, fit: &Coefficients, lambda: f64) -> Result<DVector<f64>> {
        let series = Series::new(fit)?;
        let parts: Vec<Moments> = self
            .directions
            .par_chunks(16 * BLOCK)
            .enumerate()
            .map(|(chunk, directions)| {
                let mut moments = basis.empty.clone();
                for (i, direction) in directions.iter().enumerate() {
                    let i = i + chunk * 16 * BLOCK;
                    let left = self.values[i] - series.value(*direction);
                    moments.add(*direction, self.scale * self.weights[i] * left);
                }
                moments
            })
            .collect();
        let mut total = basis.empty.clone();
        for part in &parts {
            total.merge(part);
        }
        let mut side = basis.orthonormal(&total.coefficients());
        let present = basis.orthonormal(fit);
        for (i, damping) in basis.damping(lambda).enumerate() {
            side[i] -= damping * present[i];
        }
        Ok(side)
    }
}

/// The orthonormal basis, its functions numbered degree by degree: A_l0, A_l1, B_l1, A_l2, ...
pub(super) struct Basis {
    empty: Moments,
    /// The degree of each function.
    degrees: Vec<usize>,
    /// The factor from orthonormal coefficients to ours, (2l+1)/(2 pi eps_m) under the root.
    norms: Vec<f64>,
}

impl Basis {
    pub(super) fn new(lmax: usize) -> Result<Self> {
        let degrees: Vec<usize> =
            (0..=lmax).flat_map(|l| std::iter::repeat_n(l, 2 * l + 1)).collect();
        let norm = |i: usize| {
            let l = degrees[i];
            let squared_norm = if i == l * l { 4.0 * PI } else { 2.0 * PI };
            ((2 * l + 1) as f64 / squared_norm).sqrt()
        };
        let norms = (0..degrees.len()).map(norm).collect();
        Ok(Self { empty: Moments::new(lmax)?, norms, degrees })
    }

    pub(super) fn lmax(&self) -> usize {
        self.degrees.last().copied().unwrap_or(0)
    }

    /// Evaluates all functions at a direction, times `factor`.
    pub(super) fn at(&self, direction: DVec3, factor: f64) -> Vec<f64> {
        let mut moments = self.empty.clone();
        moments.add(direction, factor);
        self.orthonormal(&moments.coefficients()).as_slice().to_vec()
    }

    /// Turns coefficients (or moments with our norm) into those of the orthonormal basis.
    fn orthonormal(&self, c: &Coefficients) -> DVector<f64> {
        let mut all = DVector::zeros(self.norms.len());
        for l in 0..=c.lmax() {
            all[l * l] = c.get(l, 0).0 / self.norms[l * l];
            for m in 1..=l {
                let (i, (a, b)) = (l * l + 2 * m - 1, c.get(l, m));
                (all[i], all[i + 1]) = (a / self.norms[i], b / self.norms[i + 1]);
            }
        }
        all
    }

    /// Adds orthonormal coefficients to ours.
    fn plus(&self, c: &Coefficients, x: &DVector<f64>) -> Coefficients {
        let mut sum = c.clone();
        let ours = |i: usize| x[i] * self.norms[i];
        for l in 0..=c.lmax() {
            sum.set(l, 0, c.get(l, 0).0 + ours(l * l), 0.0);
            for m in 1..=l {
                let (i, (a, b)) = (l * l + 2 * m - 1, c.get(l, m));
                sum.set(l, m, a + ours(i), b + ours(i + 1));
            }
        }
        sum
    }

    /// Lists lambda l^2 (l+1)^2 function by function.
    fn damping(&self, lambda: f64) -> impl Iterator<Item = f64> {
        self.degrees.iter().map(move |&l| lambda * ((l * (l + 1)) as f64).powi(2))
    }
}

fn check_degree(samples: usize, lmax: usize, lambda: f64) -> Result<()> {
    if !(lambda.is_finite() && lambda >= 0.0) {
        return Err(Error::Parameter(format!(
            "lambda is a finite number from 0 on, found {lambda}; 1e-6 is a mild one"
        )));
    }
    if lmax > MAX_LEAST_SQUARES_DEGREE {
        return Err(Error::Parameter(format!(
            "least squares of degree {lmax} would need a matrix of {:.1} GB; the highest degree is \
             {MAX_LEAST_SQUARES_DEGREE}: lower the degree, or project a mesh by its faces",
            8e-9 * ((lmax + 1) as f64).powi(4)
        )));
    }
    let unknowns = (lmax + 1) * (lmax + 1);
    if samples < unknowns && lambda == 0.0 {
        return Err(Error::Geometry(format!(
            "{samples} samples cannot determine the {unknowns} coefficients of degree {lmax}: \
             lower the degree to {} or less, or damp the series by a lambda such as 1e-6",
            samples.isqrt().saturating_sub(1)
        )));
    }
    Ok(())
}

/// Says which degree the samples do not determine.
fn undetermined(
    samples: usize,
    lmax: usize,
    lambda: f64,
    unexplained: Option<(usize, f64)>,
    basis: &Basis,
) -> Error {
    let l = unexplained.map_or(lmax, |(i, _)| basis.degrees[i]);
    let more = if lambda == 0.0 {
        "a lambda such as 1e-6".to_owned()
    } else {
        format!("a lambda above {lambda}")
    };
    Error::Geometry(format!(
        "the {samples} samples do not determine the series of degree {lmax}: they leave a gap on \
         the sphere, or coincide, so that a function of degree {l} is (nearly) a sum of others at \
         all of them; lower the degree below {}, add samples, or damp the series by {more}",
        l.max(1)
    ))
}

/// Factorises the lower triangle of a symmetric matrix in place, M = L L^T, panel by panel, and
/// gives the row with the smallest part of its diagonal entry left after the rows before it, and
/// that part; `None` when nothing is left.
fn factorise(matrix: &mut DMatrix<f64>) -> Option<(usize, f64)> {
    let n = matrix.nrows();
    let diagonal: Vec<f64> = matrix.diagonal().iter().copied().collect();
    let mut least = (0, 1.0);
    for first in (0..n).step_by(PANEL) {
        let last = (first + PANEL).min(n);
        for j in first..last {
            // Columns of this panel before j; those of earlier panels are taken off already.
            let (before, from_j) = matrix.as_mut_slice().split_at_mut(j * n);
            for column in before[first * n..].chunks_exact(n) {
                let factor = column[j];
                from_j[j..n].iter_mut().zip(&column[j..]).for_each(|(x, y)| *x -= factor * y);
            }
            let pivot = matrix[(j, j)];
            let part = pivot / diagonal[j];
            if part.is_nan() || part <= 0.0 {
                return None;
            }
            if part < least.1 {
                least = (j, part);
            }
            let root = pivot.sqrt();
            matrix.view_mut((j, j), (n - j, 1)).scale_mut(1.0 / root);
        }
        let table = matrix.view((last, first), (n - last, last - first)).into_owned();
        add_products(matrix, &table, last, -1.0);
    }
    Some(least)
}

/// Adds `sign` times table * table^T to the lower triangle of the square from row and column `from`
/// on, panel by panel in parallel.
fn add_products(matrix: &mut DMatrix<f64>, table: &DMatrix<f64>, from: usize, sign: f64) {
    let n = matrix.nrows();
    let transposed = table.transpose();
    let columns = &mut matrix.as_mut_slice()[from * n..];
    columns.par_chunks_mut(n * PANEL).enumerate().for_each(|(panel, entries)| {
        let (width, above) = (entries.len() / n, panel * PANEL);
        let left = n - from - above;
        let mut columns = nalgebra::DMatrixViewMut::from_slice(entries, n, width);
        columns.rows_mut(from + above, left).gemm(
            sign,
            &table.rows(above, left),
            &transposed.columns(above, width),
            1.0,
        );
    });
}

/// Solves L L^T x = b in place.
fn solve(lower: &DMatrix<f64>, x: &mut DVector<f64>) {
    // The pivots are known to be above 0.
    let _ = lower.solve_lower_triangular_mut(x);
    let _ = lower.tr_solve_lower_triangular_mut(x);
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::math::sampling::uniform_sphere;

    /// Points spread evenly over the sphere by the golden angle.
    fn spiral(n: usize) -> Vec<DVec3> {
        let turn = PI * (3.0 - 5.0_f64.sqrt());
        let point = |i: usize| {
            let z = 1.0 - (2 * i + 1) as f64 / n as f64;
            let (s, phi) = ((1.0 - z * z).sqrt(), turn * i as f64);
            DVec3::new(s * phi.cos(), s * phi.sin(), z)
        };
        (0..n).map(point).collect()
    }

    fn random_series(lmax: usize) -> Coefficients {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let mut c = Coefficients::zeros(lmax);
        for l in 0..=lmax {
            (0..=l).for_each(|m| c.set(l, m, rng.random::<f64>() - 0.5, rng.random()));
        }
        c
    }

    fn values(f: &Coefficients, at: &[DVec3]) -> Vec<f64> {
        let series = Series::new(f).expect("small degree");
        at.iter().map(|w| series.value(*w)).collect()
    }

    fn difference(a: &Coefficients, b: &Coefficients) -> f64 {
        let all = a.cosines().iter().chain(a.sines());
        all.zip(b.cosines().iter().chain(b.sines())).fold(0.0, |w, (x, y)| w.max((x - y).abs()))
    }

    fn refusal(directions: &[DVec3], lmax: usize, lambda: f64) -> String {
        let n = directions.len();
        let fit = scattered_fit(directions, &vec![1.0; n], &vec![1.0; n], lmax, lambda);
        fit.expect_err("refused").to_string()
    }

    #[test]
    fn too_few_and_gapped_samples_are_refused_with_a_way_on() {
        assert!(refusal(&[], 0, 0.0).contains("at least one must be above 0"));
        let text = refusal(&spiral(30), 5, 0.0);
        assert!(
            text.contains("30 samples cannot determine the 36") && text.contains("to 4 or less")
        );
        // Samples on one circle know nothing of its normal.
        let circle: Vec<_> =
            (0..40).map(|i| DVec3::new(f64::from(i).cos(), f64::from(i).sin(), 0.0)).collect();
        let text = refusal(&circle, 1, 0.0);
        assert!(
            text.contains("do not determine") && text.contains("lambda such as 1e-6"),
            "{text}"
        );
        // All at one place.
        assert!(refusal(&[DVec3::X; 50], 3, 0.0).contains("do not determine"));
        assert!(refusal(&spiral(9), 101, 1.0).contains("GB; the highest degree is 100"));
        assert!(refusal(&spiral(9), 1, -1.0).contains("found -1"));
        assert!(refusal(&spiral(9), 1, f64::NAN).contains("found NaN"));
    }

    #[test]
    fn unusable_numbers_are_refused_by_their_place() {
        let w = spiral(4);
        let fit = |v: f64, weight: f64| {
            scattered_fit(&w, &[1.0, 1.0, v, 1.0], &[1.0, 1.0, weight, 1.0], 1, 0.0)
        };
        for (v, weight) in [(f64::NAN, 1.0), (1.0, -1.0), (1.0, f64::INFINITY)] {
            assert!(fit(v, weight).expect_err("refused").to_string().starts_with("sample 2"));
        }
        assert!(scattered_fit(&[DVec3::ZERO], &[1.0], &[1.0], 0, 0.0).is_err());
        assert!(scattered_fit(&w, &[1.0; 3], &[1.0; 4], 0, 0.0).is_err());
    }

    #[test]
    fn a_series_is_found_again_from_its_values() {
        // 400 samples, 169 coefficients: several panels and blocks. Weights of any scale and spread
        // change nothing for values without noise.
        let (truth, w) = (random_series(12), spiral(400));
        let weights: Vec<f64> = (0..400).map(|i| 1e6 * f64::from(1 + i % 7)).collect();
        let fit = scattered_fit(&w, &values(&truth, &w), &weights, 12, 0.0).expect("determined");
        assert!(difference(&fit, &truth) <= 1e-12, "{:e}", difference(&fit, &truth));
    }

    #[test]
    fn random_samples_determine_it_as_well() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(9);
        let w: Vec<_> = (0..900).map(|_| uniform_sphere(rng.random())).collect();
        let truth = random_series(8);
        let fit = scattered_fit(&w, &values(&truth, &w), &[1.0; 900], 8, 0.0).expect("determined");
        assert!(difference(&fit, &truth) <= 1e-12);
    }

    #[test]
    fn samples_without_weight_do_not_count() {
        let (truth, w) = (random_series(3), spiral(60));
        let mut noisy = values(&truth, &w);
        let mut weights = vec![1.0; 60];
        for i in (0..60).step_by(10) {
            (noisy[i], weights[i]) = (1e3, 0.0);
        }
        let fit = scattered_fit(&w, &noisy, &weights, 3, 0.0).expect("determined");
        assert!(difference(&fit, &truth) <= 1e-12);
    }

    #[test]
    fn the_normal_equations_hold_with_damping() {
        // At the minimum the gradient vanishes: sum w Y (v - f) = lambda l^2 (l+1)^2 c for each
        // function, checked by plain sums.
        let (w, lambda, lmax) = (spiral(80), 1e-3, 5);
        let v: Vec<f64> = w.iter().map(|w| (3.0 * w.x).sin() + w.z.abs()).collect();
        let fit = scattered_fit(&w, &v, &[2.0; 80], lmax, lambda).expect("determined");
        let at = values(&fit, &w);
        let basis = Basis::new(lmax).expect("degree 5");
        let c = basis.orthonormal(&fit);
        for i in 0..36 {
            let sum: f64 =
                (0..80).map(|j| 4.0 * PI / 80.0 * basis.at(w[j], 1.0)[i] * (v[j] - at[j])).sum();
            let l = basis.degrees[i] as f64;
            let damping = lambda * (l * (l + 1.0)).powi(2) * c[i];
            assert!((sum - damping).abs() <= 1e-13, "{i}: {sum:e} {damping:e}");
        }
        // With lambda fewer samples than coefficients will do.
        assert!(scattered_fit(&w[..20], &v[..20], &[1.0; 20], lmax, lambda).is_ok());
    }

    #[test]
    fn damped_and_weighted_fit_matches_an_independent_solver() {
        // NumPy's lstsq on the rows sqrt(w) Y and sqrt(lambda) l (l+1), Y from SciPy's lpmv,
        // weights scaled to 4 pi.
        let w = spiral(40);
        let v: Vec<f64> = w.iter().map(|w| w.x.exp() + w.z * w.z).collect();
        let weights: Vec<f64> = (0..40).map(|i| f64::from(1 + i % 3)).collect();
        let fit = scattered_fit(&w, &v, &weights, 2, 1e-3).expect("determined");
        for (l, m, a, b) in [
            (0, 0, 1.507_428_444_140_150_2, 0.0),
            (1, 0, -0.002_442_826_423_119_552_4, 0.0),
            (1, 1, -1.553_816_684_967_657_3, -0.000_570_393_222_126_253_6),
            (2, 0, 0.474_673_090_245_335_77, 0.0),
            (2, 1, -0.002_988_989_686_641_529_3, 0.002_504_629_543_474_341),
            (2, 2, 0.419_327_372_616_920_5, -0.001_394_083_043_040_800_3),
        ] {
            let found = fit.get(l, m);
            assert!((found.0 - a).abs() <= 1e-13 && (found.1 - b).abs() <= 1e-13, "({l}, {m})");
        }
    }
}
