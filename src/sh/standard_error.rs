//! How far the scatter of samples leaves a least-squares series from the truth.
//!
//! With s^2 the mean square of a sample of weight 1 about the series and N the normal matrix,
//! damped as it was solved, the coefficients have the covariance s^2 N^-1, and the value towards
//! omega the variance s^2 y^T N^-1 y, y the basis there. Its integral over the sphere is s^2
//! tr(N^-1), which a Gauss-Legendre grid gives exactly. Where samples leave a gap N has small
//! eigenvalues, and the variance there is large, however well the series meets the samples. What
//! damping takes off the truth is not in it.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::Grid;
use super::least_squares::{Basis, PANEL};

/// The directions that are looked at: the grid for this degree at most. Above it the root mean
/// square is an estimate, too.
const FINEST: usize = 40;

/// Directions that are worked on together.
const BLOCK: usize = 128;

/// Estimates the error of a series that the scatter of its samples leaves, if they scatter
/// independently, each with a variance inverse to its weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StandardError {
    /// The root mean square over the sphere, in the unit of the values.
    pub rms: f64,
    /// The largest that was found in one direction.
    pub largest: f64,
    /// This direction, a unit vector.
    pub direction: DVec3,
}

impl StandardError {
    /// Spreads the variance of a sample over the sphere; `lower` is the factor of the normal
    /// matrix.
    pub(super) fn of(lower: &DMatrix<f64>, basis: &Basis, variance: f64) -> Self {
        let grid = Grid::minimal((2 * basis.lmax()).clamp(8, FINEST));
        let on_grid = (0..grid.len()).map(|i| (grid.direction(i), grid.solid_angle(i)));
        // A grid of Gauss has no poles.
        let all: Vec<_> = on_grid.chain([(DVec3::Z, 0.0), (DVec3::NEG_Z, 0.0)]).collect();
        let spread: Vec<f64> = all
            .par_chunks(BLOCK)
            .flat_map_iter(|block| {
                let columns: Vec<Vec<f64>> =
                    block.iter().map(|(direction, _)| basis.at(*direction, 1.0)).collect();
                let mut sides = DMatrix::from_fn(lower.nrows(), block.len(), |i, j| columns[j][i]);
                solve_lower(lower, &mut sides);
                sides.column_iter().map(|x| x.norm_squared()).collect::<Vec<_>>()
            })
            .collect();
        let (mut trace, mut largest) = (0.0, (0.0, DVec3::Z));
        for ((direction, solid_angle), spread) in all.into_iter().zip(spread) {
            trace += solid_angle * spread;
            if spread > largest.0 {
                largest = (spread, direction);
            }
        }
        let root = |spread: f64| (variance * spread).sqrt();
        Self { rms: root(trace / (4.0 * PI)), largest: root(largest.0), direction: largest.1 }
    }
}

/// Solves L x = b in place for every column, panel by panel.
fn solve_lower(lower: &DMatrix<f64>, sides: &mut DMatrix<f64>) {
    let n = lower.nrows();
    for first in (0..n).step_by(PANEL) {
        let last = (first + PANEL).min(n);
        let width = last - first;
        // The pivots are known to be above 0.
        let square = lower.view((first, first), (width, width));
        let _ = square.solve_lower_triangular_mut(&mut sides.rows_mut(first, width));
        let solved = sides.rows(first, width).into_owned();
        let below = lower.view((last, first), (n - last, width));
        sides.rows_mut(last, n - last).gemm(-1.0, &below, &solved, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::math::sampling::uniform_sphere;
    use crate::sh::{Coefficients, Series, difference, fit_with_error};

    const NOISE: f64 = 0.005;

    fn radius(w: DVec3) -> f64 {
        1.0 + 0.1 * w.z * w.z + 0.05 * w.x
    }

    /// Fits points of this radius with noise above a height, and gives the true RMS error and the
    /// one that is stated.
    fn fit(seed: u64, count: usize, above: f64, lmax: usize) -> (f64, StandardError) {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut at = Vec::new();
        while at.len() < count {
            let w = uniform_sphere([rng.random(), rng.random()]);
            at.extend((w.z >= above).then_some(w));
        }
        // The sum of twelve uniform numbers is nearly normal.
        let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let values: Vec<f64> = at.iter().map(|w| radius(*w) * (1.0 + NOISE * normal())).collect();
        let (c, error) =
            fit_with_error(&at, &values, &vec![1.0; count], lmax, 0.0).expect("determined");
        let mut truth = Coefficients::zeros(2);
        truth.set(0, 0, 1.0 + 0.1 / 3.0, 0.0);
        // Order 1 is -sqrt(1/2) x here.
        truth.set(1, 1, -0.05 * 2.0_f64.sqrt(), 0.0);
        truth.set(2, 0, 0.2 / 3.0, 0.0);
        assert!((Series::new(&truth).expect("low").value(at[0]) - radius(at[0])).abs() <= 1e-14);
        let off = difference(&c, &truth);
        ((off.energy() / (4.0 * PI)).sqrt(), error.expect("more points than coefficients"))
    }

    fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
        let (sum, count) = values.fold((0.0, 0.0), |(s, n), x| (s + x * x, n + 1.0));
        (sum / count).sqrt()
    }

    #[test]
    fn stated_error_is_the_true_one_with_and_without_a_gap() {
        for (above, count) in [(-1.0, 200), (-0.7, 400), (-0.4, 400), (0.0, 400)] {
            let fits: Vec<_> = (0..50).map(|seed| fit(seed, count, above, 8)).collect();
            let found = root_mean_square(fits.iter().map(|(found, _)| *found));
            let stated = root_mean_square(fits.iter().map(|(_, error)| error.rms));
            // One function has nearly all of the error, so that the RMS of 50 is off by a tenth: three
            // times that.
            assert!((found / 1.3..=found * 1.3).contains(&stated), "{above}: {found} {stated}");
            let (_, first) = &fits[0];
            assert!(first.largest >= first.rms);
            // A gap is about the south pole.
            assert!(above < -0.9 || first.direction.z <= -0.7, "{first:?}");
        }
    }

    #[test]
    fn even_samples_have_the_error_of_the_formula() {
        // Near the identity the variance is that of a sample by its weight, everywhere.
        let lower = DMatrix::identity(81, 81) * 2.0;
        let error = StandardError::of(&lower, &Basis::new(8).expect("low"), 4.0);
        let expected = (81.0 / (4.0 * PI)).sqrt();
        assert!((error.rms / expected - 1.0).abs() <= 1e-12, "{error:?}");
        assert!((error.largest / expected - 1.0).abs() <= 1e-12, "{error:?}");
    }

    #[test]
    fn panels_solve_what_one_column_after_the_other_does() {
        let n = 2 * PANEL + 17;
        let lower = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => 2.0 + (i % 3) as f64,
            std::cmp::Ordering::Greater => ((7 * i + 3 * j) as f64).sin() / n as f64,
        });
        let sides = DMatrix::from_fn(n, 3, |i, j| ((i + 5 * j) as f64).cos());
        let mut solved = sides.clone();
        solve_lower(&lower, &mut solved);
        assert!((lower * solved - sides).amax() <= 1e-12);
    }
}
