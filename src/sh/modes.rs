//! Principal modes of variation of shapes: what principal component analysis finds in the
//! coefficients of the radius.
//!
//! Coefficients are taken in the 4pi normalisation, where the distance of two lists of them is the
//! RMS radial distance of the shapes: scores and deviations are metres, and the modes do not depend
//! on the axes. The singular values of the n shapes less their mean are sqrt(n - 1) times the
//! standard deviations.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use super::{Coefficients, Convention, difference, mean, places};
use crate::{Error, Result, memory};

/// Holds the mean of shapes and how they vary about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes {
    /// The mean shape, of the highest degree among them.
    pub mean: Coefficients,
    /// The modes, the largest first.
    pub modes: Vec<Mode>,
    /// The variance of all modes, m2: the square of [`scatter`](super::scatter).
    pub variance: f64,
}

/// Holds one mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// The standard deviation, m, RMS over the sphere; n - 1 in the denominator.
    pub deviation: f64,
    /// The share of the variance that it explains, 0 to 1.
    pub explained: f64,
    /// The radial displacement of one standard deviation, m; its largest 4pi-normalised coefficient
    /// is positive.
    pub displacement: Coefficients,
    /// The score of each shape: how far it is from the mean along the mode, m, RMS over the sphere.
    pub scores: Vec<f64>,
}

impl Modes {
    /// Returns the mean moved along a mode by so many standard deviations.
    ///
    /// # Panics
    /// When there is no such mode: a programmer's error.
    pub fn at(&self, mode: usize, deviations: f64) -> Coefficients {
        let displacement = self.modes[mode].displacement.clone().scaled(-deviations);
        difference(&self.mean, &displacement)
    }
}

/// Finds the modes of shapes, at most `count` of those that are more than rounding; lower degrees
/// are padded with zeros.
///
/// # Errors
/// [`Error::Parameter`] for fewer than two shapes, or when they do not differ, or a coefficient is
/// not finite; [`Error::Memory`] when the coefficients of all do not fit.
pub fn modes(members: &[&Coefficients], count: usize) -> Result<Modes> {
    let n = members.len();
    if n < 2 {
        return Err(Error::Parameter(format!("modes need at least two shapes, found {n}")));
    }
    if let Some(i) = members.iter().position(|f| !f.energy().is_finite()) {
        let text = format!("shape {} has a coefficient that is not finite", i + 1);
        return Err(Error::Parameter(text));
    }
    let mean = mean(members)?;
    let lmax = mean.lmax();
    let width = mean.count();
    // The matrix, its singular vectors of both sides, and what the solver holds.
    let bytes = 8.0 * 4.0 * (n * width) as f64 + 16.0 * (n.min(width) as f64).powi(2);
    let advice = |_| "cut the shapes at a lower degree, or take fewer".to_owned();
    memory::ask(bytes, format_args!("finding the modes of {n} shapes of degree {lmax}"), advice)?;
    let mut matrix = DMatrix::zeros(n, width);
    for (f, mut row) in members.iter().zip(matrix.row_iter_mut()) {
        row.copy_from_slice(&vector(&difference(f, &mean))?);
    }
    let svd = matrix.svd(true, true);
    let (Some(left), Some(right)) = (svd.u, svd.v_t) else {
        return Err(Error::Numeric("the modes could not be found".to_owned()));
    };
    let sizes = svd.singular_values;
    let all = sizes.norm_squared();
    let whole = (n as f64 * mean.energy() / (4.0 * PI)).sqrt();
    let rounding = f64::EPSILON * n.max(width) as f64 * whole.max(sizes.max());
    let is_more = |k: &usize| sizes[*k] > rounding;
    let mode = |k: usize| {
        let direction = right.row(k);
        let sign = direction[direction.transpose().iamax()].signum();
        let scores = left.column(k).iter().map(|u| sign * u * sizes[k]).collect();
        let deviation = sizes[k] / (n as f64 - 1.0).sqrt();
        let displacement = direction.iter().map(|c| sign * deviation * c).collect::<Vec<_>>();
        let displacement = series(lmax, &displacement)?;
        Ok(Mode { deviation, explained: sizes[k].powi(2) / all, displacement, scores })
    };
    let modes = (0..sizes.len()).take_while(is_more).take(count).map(mode);
    let modes = modes.collect::<Result<Vec<_>>>()?;
    if modes.is_empty() {
        return Err(Error::Parameter("the shapes do not differ: there are no modes".to_owned()));
    }
    Ok(Modes { mean, modes, variance: all / (n as f64 - 1.0) })
}

/// Returns the coefficients in the 4pi normalisation.
fn vector(f: &Coefficients) -> Result<Vec<f64>> {
    let coefficient = |(l, m, sine)| {
        let (c, s) = Convention::default().export(l, m, f.get(l, m))?;
        Ok(if sine { s } else { c })
    };
    places(f.lmax()).map(coefficient).collect()
}

/// Undoes [`vector`].
fn series(lmax: usize, vector: &[f64]) -> Result<Coefficients> {
    let mut series = Coefficients::zeros(lmax);
    for ((l, m, sine), &value) in places(lmax).zip(vector) {
        let pair = if sine { (0.0, value) } else { (value, 0.0) };
        let (a, b) = Convention::default().import(l, m, pair)?;
        let (c, s) = series.get(l, m);
        series.set(l, m, c + a, s + b);
    }
    Ok(series)
}

#[cfg(test)]
mod tests {
    use nalgebra::SymmetricEigen;

    use super::*;
    use crate::sh::{gaussian, scatter};

    const POWERS: [f64; 7] = [0.0, 1e-3, 5e-3, 3e-3, 2e-3, 1e-3, 5e-4];

    fn shapes(count: u64) -> Vec<Coefficients> {
        let shape = |seed| {
            let mut shape = gaussian(&POWERS, 1000 + seed).expect("powers");
            shape.set(0, 0, 1.0 + 0.01 * (seed as f64).sin(), 0.0);
            shape
        };
        (0..count).map(shape).collect()
    }

    fn found(shapes: &[Coefficients], count: usize) -> Modes {
        modes(&shapes.iter().collect::<Vec<_>>(), count).expect("they differ")
    }

    #[test]
    fn modes_of_200_shapes_are_the_eigenvectors_of_their_covariance() {
        let shapes = shapes(200);
        let found = found(&shapes, usize::MAX);
        let rows: Vec<Vec<f64>> = shapes.iter().map(|f| vector(f).expect("4pi")).collect();
        let matrix = DMatrix::from_fn(200, 49, |i, j| rows[i][j]);
        let centred = DMatrix::from_fn(200, 49, |i, j| matrix[(i, j)] - matrix.column(j).mean());
        let covariance = centred.transpose() * &centred / 199.0;
        let eigen = SymmetricEigen::new(covariance.clone());
        let mut variances: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
        variances.sort_by(|a, b| b.total_cmp(a));
        assert_eq!(found.modes.len(), 49);
        let total: f64 = variances.iter().sum();
        assert!((found.variance / total - 1.0).abs() <= 1e-12);
        for (mode, variance) in found.modes.iter().zip(&variances) {
            // Rounding of the covariance, relative to the largest variance.
            let tolerance = 1e-13 * variances[0];
            assert!((mode.deviation.powi(2) - variance).abs() <= tolerance);
            assert!((mode.explained - variance / total).abs() <= 1e-13);
            let direction = vector(&mode.displacement).expect("4pi");
            let direction = nalgebra::DVector::from_vec(direction) / mode.deviation;
            assert!((direction.norm() - 1.0).abs() <= 1e-13);
            assert!((&covariance * &direction - *variance * &direction).norm() <= tolerance);
            assert!(direction[direction.iamax()] > 0.0);
            let scores = &centred * direction;
            let differ = scores.iter().zip(&mode.scores).map(|(a, b)| (a - b).abs());
            assert!(differ.fold(0.0, f64::max) <= 1e-13);
        }
    }

    #[test]
    fn scores_put_each_shape_together_again() {
        let shapes = shapes(5);
        let found = found(&shapes, 10);
        assert_eq!(found.modes.len(), 4);
        let members: Vec<&Coefficients> = shapes.iter().collect();
        assert!((found.variance.sqrt() - scatter(&members, &found.mean)).abs() <= 1e-14);
        for (i, shape) in shapes.iter().enumerate() {
            let mut sum = found.mean.clone();
            for (k, mode) in found.modes.iter().enumerate() {
                let moved = found.at(k, mode.scores[i] / mode.deviation);
                sum = difference(&sum, &difference(&found.mean, &moved));
            }
            assert!(difference(&sum, shape).energy().sqrt() <= 1e-13);
        }
    }

    #[test]
    fn lower_degrees_are_padded_and_few_modes_are_the_first() {
        let mut shapes = shapes(6);
        shapes[2] = shapes[2].truncated(1);
        let all = found(&shapes, usize::MAX);
        assert_eq!((all.mean.lmax(), all.modes.len()), (6, 5));
        assert_eq!(found(&shapes, 2).modes, all.modes[..2]);
    }

    #[test]
    fn what_has_no_modes_is_refused() {
        let mut shapes = shapes(3);
        let refusal =
            |members: &[&Coefficients]| modes(members, 3).expect_err("no modes").to_string();
        assert!(refusal(&[]).contains("found 0"));
        assert!(refusal(&[&shapes[0]]).contains("at least two shapes, found 1"));
        assert!(refusal(&[&shapes[0]; 3]).contains("do not differ"));
        shapes[1].set(3, 1, f64::NAN, 0.0);
        assert!(refusal(&shapes.iter().collect::<Vec<_>>()).contains("shape 2 has"));
    }
}
