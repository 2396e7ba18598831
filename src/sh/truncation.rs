//! What truncation leaves out, bounded everywhere: the largest |sum_{l > degree} f_l| and the
//! largest slope of that tail.
//!
//! The tail is again a series of degree lmax, so samples bound it as they bound f (see `bounds`);
//! the sum of sigma_l over the tail is about three times as much. The smallest degree that is good
//! enough is found by halving. It takes few samples: those of a grid bound the tail from below as
//! they are and from above when inflated, and only a degree between the two needs a finer grid.

use std::f64::consts::PI;

use super::{Coefficients, Grid, Transform, rotation_derivatives, rounding};
use crate::Result;

/// Bounds the difference between a series truncated to a degree and the whole series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TruncationError {
    /// The degree it is truncated to.
    pub degree: usize,
    /// An upper bound of the difference in any direction, in the unit of the series.
    pub value: f64,
    /// An upper bound of the difference of the surface gradients, per radian.
    pub slope: f64,
}

/// Rings of a grid per degree of the series, coarse to fine: the samples, inflated by 1/cos^2(pi /
/// 2k), are at most 2, 1.18 and 1.04 times too large.
const RINGS: [usize; 3] = [2, 4, 8];

/// The most rings for the slope, which takes three series.
const SLOPE_RINGS: usize = 4;

/// Bounds what truncation to `degree` leaves out; both bounds are 0 from degree lmax on, and at
/// most 4 % (the slope 18 %) above the largest sample.
///
/// # Errors
/// As [`super::synthesis`]: a degree too high to evaluate.
pub fn truncation_error(f: &Coefficients, degree: usize) -> Result<TruncationError> {
    let Some(tail) = tail(f, degree) else {
        return Ok(TruncationError { degree, value: 0.0, slope: 0.0 });
    };
    let (_, value) = value_bracket(&tail, RINGS[2])?;
    let (_, slope) = slope_bracket(&tail, SLOPE_RINGS)?;
    Ok(TruncationError { degree, value, slope })
}

/// Finds a degree whose bounds of value and slope are accepted while those of the degree below are
/// not; where they fall as the degree rises, that is the smallest of all. What accepts two bounds
/// must accept smaller ones. The answer carries its own bounds, as tight as those of
/// [`truncation_error`].
///
/// # Errors
/// As [`super::synthesis`]: a degree too high to evaluate.
pub fn sufficient_degree(
    f: &Coefficients,
    accepts: impl Fn(f64, f64) -> bool,
) -> Result<TruncationError> {
    // Between a degree that is too low, of which nothing is known yet, and one that will do.
    let (mut lowest, mut enough) = (0, f.lmax());
    while lowest < enough {
        let degree = lowest + (enough - lowest) / 2;
        if is_sufficient(f, degree, &accepts)? {
            enough = degree;
        } else {
            lowest = degree + 1;
        }
    }
    let fine = truncation_error(f, enough)?;
    if accepts(fine.value, fine.slope) {
        return Ok(fine);
    }
    // A coarse grid told what the finest, 4 % too high itself, does not.
    Ok(TruncationError { degree: f.lmax(), value: 0.0, slope: 0.0 })
}

/// Whether the bounds of a degree are accepted, on grids no finer than it takes to tell.
fn is_sufficient(
    f: &Coefficients,
    degree: usize,
    accepts: &impl Fn(f64, f64) -> bool,
) -> Result<bool> {
    let Some(tail) = tail(f, degree) else { return Ok(true) };
    for rings in RINGS {
        let (low, high) = value_bracket(&tail, rings)?;
        if accepts(high, f64::INFINITY) {
            return Ok(true);
        }
        if !accepts(low, 0.0) {
            return Ok(false);
        }
        let (flat, steep) = slope_bracket(&tail, rings.min(SLOPE_RINGS))?;
        if accepts(high, steep) {
            return Ok(true);
        }
        if !accepts(low, flat) {
            return Ok(false);
        }
    }
    Ok(false)
}

/// Returns the part of a series above a degree; nothing if there is none.
fn tail(f: &Coefficients, degree: usize) -> Option<Coefficients> {
    if degree >= f.lmax() {
        return None;
    }
    let mut tail = f.clone();
    for (l, m) in (0..=degree).flat_map(|l| (0..=l).map(move |m| (l, m))) {
        tail.set(l, m, 0.0, 0.0);
    }
    Some(tail)
}

/// Returns bounds of the largest |g|, below and above.
fn value_bracket(g: &Coefficients, rings: usize) -> Result<(f64, f64)> {
    let transform = Transform::new(g.lmax(), grid(g, rings))?;
    let largest = transform.synthesis(g)?.into_iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    Ok((largest - rounding(g), largest * inflation(rings) + rounding(g)))
}

/// Returns bounds of the largest |grad_S g|, below and above.
fn slope_bracket(g: &Coefficients, rings: usize) -> Result<(f64, f64)> {
    let transform = Transform::new(g.lmax(), grid(g, rings))?;
    let derivatives = rotation_derivatives(g);
    let mut squares = vec![0.0; transform.grid().len()];
    for derivative in &derivatives {
        for (square, value) in squares.iter_mut().zip(transform.synthesis(derivative)?) {
            *square += value * value;
        }
    }
    let largest = squares.into_iter().fold(0.0, f64::max).sqrt();
    let rounding: f64 = derivatives.iter().map(rounding).sum();
    Ok((largest - rounding, largest * inflation(rings) + rounding))
}

fn grid(g: &Coefficients, rings: usize) -> Grid {
    let half = rings * g.lmax();
    Grid::equispaced(half, 2 * half)
}

/// Returns 1/cos^2(pi lmax / n) for n = 2 rings lmax samples around.
fn inflation(rings: usize) -> f64 {
    (PI / (2 * rings) as f64).cos().powi(-2)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::math::sampling::uniform_sphere;
    use crate::sh::{Series, gaussian, power_law};

    fn random(lmax: usize) -> Coefficients {
        let mut f = gaussian(&power_law(0.01, 3.0, 1, lmax).expect("valid"), 11).expect("valid");
        f.set(0, 0, 1.0, 0.0);
        f
    }

    /// Returns the largest difference of value and of gradient over 20 000 directions.
    fn sampled(f: &Coefficients, degree: usize) -> (f64, f64) {
        let (whole, low) = (Series::new(f), Series::new(&f.truncated(degree)));
        let (whole, low) = (whole.expect("valid"), low.expect("valid"));
        (0..20_000).fold((0.0, 0.0), |(value, slope): (f64, f64), i| {
            let u = [(f64::from(i) + 0.5) / 20_000.0, (f64::from(i) * 0.618_033_988_75).fract()];
            let w: DVec3 = uniform_sphere(u);
            let (a, b) = (whole.jet(w), low.jet(w));
            let steep = (a.gradient - b.gradient).length();
            (value.max((a.value - b.value).abs()), slope.max(steep))
        })
    }

    #[test]
    fn bounds_hold_and_are_tight() {
        let f = random(24);
        for degree in [0, 3, 8, 16, 23] {
            let (value, slope) = sampled(&f, degree);
            let bound = truncation_error(&f, degree).expect("valid");
            assert!(value <= bound.value && slope <= bound.slope, "degree {degree}: {bound:?}");
            // 1.04 and 1.18 above the largest on their grids, which 20 000 directions nearly reach.
            assert!(bound.value <= 1.1 * value && bound.slope <= 1.3 * slope, "degree {degree}");
        }
    }

    #[test]
    fn sums_of_deviations_bound_far_more() {
        let f = random(24);
        let sum: f64 = (9..=24).map(|l| f.degree_deviation(l)).sum();
        assert!(truncation_error(&f, 8).expect("valid").value <= 0.7 * sum);
    }

    #[test]
    fn nothing_is_left_at_full_degree() {
        let f = random(6);
        for degree in [6, 7, 100] {
            let none = TruncationError { degree, value: 0.0, slope: 0.0 };
            assert_eq!(truncation_error(&f, degree).expect("valid"), none);
        }
        let ball = Coefficients::zeros(0);
        assert_eq!(sufficient_degree(&ball, |v, _| v <= 0.0).expect("valid").degree, 0);
    }

    #[test]
    fn sufficient_degrees_are_sufficient_and_no_higher() {
        let f = random(32);
        let free = f64::INFINITY;
        for (value, slope) in [(0.05, free), (1e-3, free), (free, 0.1), (0.01, 0.2)] {
            let found = sufficient_degree(&f, |v, s| v <= value && s <= slope).expect("valid");
            assert!(found.value <= value && found.slope <= slope, "{found:?}");
            assert_eq!(found, truncation_error(&f, found.degree).expect("valid"));
            let below = truncation_error(&f, found.degree - 1).expect("valid");
            assert!(below.value > value || below.slope > slope, "{found:?} {below:?}");
        }
        let degree =
            |accepts: fn(f64, f64) -> bool| sufficient_degree(&f, accepts).map(|e| e.degree);
        assert_eq!(degree(|v, s| v <= 0.0 && s <= 0.0).expect("valid"), 32);
        assert_eq!(degree(|_, _| true).expect("valid"), 0);
    }
}
