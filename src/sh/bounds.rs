//! Certified bounds of a series over the whole sphere: of its value, its slope and its curvature
//! along great circles.
//!
//! A function of degree lmax is a trigonometric polynomial of degree lmax in each angle. For such a
//! polynomial g sampled at n equispaced angles, |g| <= max |sample| / cos(pi lmax / n) (Ehlich and
//! Zeller 1964); two angles give the square. The slope along the great circle about the axis u is
//! (u . L) f and the second derivative (u . L)^2 f, see `rotation_generators`: for every fixed u
//! functions of degree lmax, so the largest |L f| and the largest eigenvalue of the symmetric
//! matrix L_i L_j f over the samples bound them.

use std::f64::consts::PI;

use nalgebra::{Matrix3, SymmetricEigen};

use super::least::{self, Least, SMALLEST, TIGHT};
use super::{Coefficients, Grid, Transform, rotation_derivatives, synthesis};
use crate::Result;

/// Holds bounds that are true everywhere on the sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// A lower bound of f.
    pub min: f64,
    /// An upper bound of f.
    pub max: f64,
    /// An upper bound of |grad_S f|, per radian.
    pub slope: f64,
    /// An upper bound of |d2 f / d alpha2| along any great circle, per square radian.
    pub curvature: f64,
}

/// Returns an absolute bound on the rounding of a value of the series in f64: the recurrence loses
/// below 3e-12 sigma at degree 256 and proportionally less below; |f_l| <= sigma_l.
pub fn rounding(f: &Coefficients) -> f64 {
    let deviations: f64 = (0..=f.lmax()).map(|l| (4 * l + 16) as f64 * f.degree_deviation(l)).sum();
    8.0 * f64::EPSILON * deviations
}

impl Bounds {
    /// Bounds a series by sampling it and its rotation derivatives.
    ///
    /// # Errors
    /// As [`synthesis`]: a degree too high to evaluate.
    pub fn of(f: &Coefficients) -> Result<Self> {
        let (min, max) = range(f)?;
        let first = rotation_derivatives(f);
        let degree = f.lmax();
        let half = 4 * degree.max(1);
        let inflate = inflation(degree, 2 * half);
        let slopes = synthesised::<3>(&first, half)?;
        let slope = largest(slopes.iter().map(|[x, y, z]| (x * x + y * y + z * z).sqrt()));
        Ok(Self { min, max, slope: inflate * slope, curvature: curvature_of(&first)? })
    }
}

/// Bounds |d2 f / d alpha2| along any great circle, per square radian.
pub(super) fn curvature(f: &Coefficients) -> Result<f64> {
    curvature_of(&rotation_derivatives(f))
}

/// Bounds it by the first derivatives of f.
fn curvature_of(first: &[Coefficients; 3]) -> Result<f64> {
    let degree = first[0].lmax();
    let half = 4 * degree.max(1);
    let second: Vec<Coefficients> = first.iter().flat_map(rotation_derivatives).collect();
    let curvature = largest(synthesised::<9>(&second, half)?.iter().map(|m| {
        let full = Matrix3::from_row_slice(m);
        SymmetricEigen::new(0.5 * (full + full.transpose())).eigenvalues.amax()
    }));
    Ok(inflation(degree, 2 * half) * curvature)
}

/// Bounds f alone, below and above. Where it may be positive everywhere, the lower bound is refined
/// until that is decided: see [`least()`].
///
/// # Errors
/// As [`synthesis`]: a degree too high to evaluate.
pub fn range(f: &Coefficients) -> Result<(f64, f64)> {
    let (least, max) = extremes(f)?;
    Ok((least.bound, max))
}

/// Finds the least value of f, roughly, and bounds it from below. Where all values found are
/// positive, the bound is at least half of the least of them, unless that is below a millionth of
/// the largest or the bound takes more work than is reasonable.
///
/// # Errors
/// As [`synthesis`]: a degree too high to evaluate.
pub fn least(f: &Coefficients) -> Result<Least> {
    Ok(extremes(f)?.0)
}

/// Makes sure that f is positive in every direction, as the radius of a body is.
///
/// # Errors
/// As [`Least::require_positive`] and [`synthesis`].
pub fn require_positive(f: &Coefficients) -> Result<()> {
    let (least, largest) = extremes(f)?;
    least.require_positive(largest)
}

/// Finds the least value of f as [`least()`] does, and bounds its largest from above, as [`range`]
/// does: on a finer grid and about its mid-range, |f - c| <= max |sample - c| / cos^2(pi lmax / n),
/// n = 16 lmax; below more closely, where that does not decide whether f is positive.
///
/// # Errors
/// As [`synthesis`]: a degree too high to evaluate.
pub fn extremes(f: &Coefficients) -> Result<(Least, f64)> {
    let degree = f.lmax();
    let half = 8 * degree.max(1);
    let grid = Grid::equispaced(half, 2 * half);
    let samples = synthesis(f, &grid)?;
    let (mut place, mut low, mut high) = (0, f64::INFINITY, f64::NEG_INFINITY);
    for (i, &value) in samples.iter().enumerate() {
        if value < low {
            (place, low) = (i, value);
        }
        high = high.max(value);
    }
    let centre = 0.5 * (low + high);
    let reach = 0.5 * (high - low) * inflation(degree, 2 * half) + rounding(f);
    let (bound, max) = (centre - reach, centre + reach);
    if bound < TIGHT * low && low > SMALLEST * high && max.is_finite() {
        let refined = least::refined(f, &grid, &samples, high)?;
        return Ok((Least { bound: refined.bound.max(bound), ..refined }, max));
    }
    Ok((Least { bound, value: low, direction: grid.direction(place) }, max))
}

/// Returns 1/cos^2(pi lmax / n).
fn inflation(lmax: usize, n: usize) -> f64 {
    (PI * lmax as f64 / n as f64).cos().powi(-2)
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

/// Synthesises several series on one equispaced grid and hands their values out sample by sample.
fn synthesised<const N: usize>(series: &[Coefficients], half: usize) -> Result<Vec<[f64; N]>> {
    let grid = Grid::equispaced(half, 2 * half);
    let mut samples = vec![[0.0; N]; grid.len()];
    let transform = Transform::new(series.first().map_or(0, Coefficients::lmax), grid)?;
    for (k, one) in series.iter().enumerate().take(N) {
        for (sample, value) in samples.iter_mut().zip(transform.synthesis(one)?) {
            sample[k] = value;
        }
    }
    Ok(samples)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sampling::uniform_sphere;
    use crate::sh::Series;

    #[test]
    fn constant_has_tight_bounds() {
        let mut c = Coefficients::zeros(0);
        c.set(0, 0, 2.0, 0.0);
        let b = Bounds::of(&c).expect("degree 0");
        assert!((b.min - 2.0).abs() <= 1e-12 && (b.max - 2.0).abs() <= 1e-12);
        assert_eq!((b.slope, b.curvature), (0.0, 0.0));
    }

    #[test]
    fn dipole_has_known_slope_and_curvature() {
        let mut c = Coefficients::zeros(1);
        c.set(0, 0, 3.0, 0.0);
        c.set(1, 0, 1.0, 0.0); // 3 + cos theta: slope sin theta, curvature cos alpha
        let b = Bounds::of(&c).expect("degree 1");
        assert!(b.min <= 2.0 && b.min >= 1.9 && b.max >= 4.0 && b.max <= 4.1);
        assert!((1.0..=1.18).contains(&b.slope) && (1.0..=1.18).contains(&b.curvature), "{b:?}");
    }

    #[test]
    fn bounds_hold_on_random_shapes() {
        for degree in [2, 5, 16] {
            let mut c = Coefficients::zeros(degree);
            for l in 0..=degree {
                for m in 0..=l {
                    c.set(l, m, ((l * 7 + m * 3) as f64).sin(), ((l + m * 5) as f64).cos());
                }
            }
            let (f, b) = (Series::new(&c).expect("small"), Bounds::of(&c).expect("small"));
            for i in 0..2000 {
                let w = uniform_sphere([
                    (f64::from(i) + 0.5) / 2000.0,
                    (f64::from(i) * 0.618_034).fract(),
                ]);
                let jet = f.jet(w);
                assert!(b.min <= jet.value && jet.value <= b.max);
                assert!(jet.gradient.length() <= b.slope);
                let (t, h) = (w.any_orthonormal_vector(), 1e-4_f64);
                let at = |a: f64| f.value(w * a.cos() + t * a.sin());
                let second = (at(h) - 2.0 * at(0.0) + at(-h)) / (h * h);
                assert!(second.abs() <= b.curvature * (1.0 + 1e-5) + 1e-6);
            }
        }
    }
}
