//! Linear combinations of series: mean, difference and scatter of shapes. Series of lower degree
//! are padded with zeros.

use std::f64::consts::PI;

use super::Coefficients;
use crate::{Error, Result};

/// Averages functions with positive weights (of any sum): sum w_i f_i / sum w_i, of the highest
/// degree among them.
///
/// # Errors
/// [`Error::Parameter`] without functions, or when a weight is not positive and finite.
pub fn weighted_mean(members: &[(&Coefficients, f64)]) -> Result<Coefficients> {
    if let Some((i, (_, weight))) =
        members.iter().enumerate().find(|(_, (_, w))| !(w.is_finite() && *w > 0.0))
    {
        return Err(Error::Parameter(format!(
            "weights must be positive and finite; number {} is {weight}",
            i + 1
        )));
    }
    let Some(lmax) = members.iter().map(|(f, _)| f.lmax()).max() else {
        return Err(Error::Parameter("a mean needs at least one shape".into()));
    };
    // Relative to the largest, so that the sum of the weights cannot overflow.
    let largest = members.iter().map(|(_, w)| *w).fold(0.0, f64::max);
    let total: f64 = members.iter().map(|(_, w)| w / largest).sum();
    let mut mean = Coefficients::zeros(lmax);
    for (f, weight) in members {
        mean = plus(&mean, f, weight / largest / total);
    }
    Ok(mean)
}

/// Averages functions: their sum over their number, of the highest degree among them.
///
/// ```
/// use harmolux::sh::{Coefficients, mean};
///
/// let (mut small, mut large) = (Coefficients::zeros(0), Coefficients::zeros(3));
/// small.set(0, 0, 1.0, 0.0);
/// large.set(0, 0, 2.0, 0.0);
/// assert_eq!(mean(&[&small, &large])?.mean(), 1.5);
/// # Ok::<(), harmolux::Error>(())
/// ```
///
/// # Errors
/// [`Error::Parameter`] without functions.
pub fn mean(members: &[&Coefficients]) -> Result<Coefficients> {
    weighted_mean(&members.iter().map(|f| (*f, 1.0)).collect::<Vec<_>>())
}

/// Subtracts `b` from `a`: the function a - b, of the higher degree. The square root of its
/// [`Coefficients::energy`] over 4 pi is the radial RMS distance of two shapes about one centre.
pub fn difference(a: &Coefficients, b: &Coefficients) -> Coefficients {
    plus(a, b, -1.0)
}

/// Measures how far shapes scatter: the root mean square over members and sphere of their distance
/// from `mean`, m; n - 1 in the denominator, NaN for fewer than two.
pub fn scatter(members: &[&Coefficients], mean: &Coefficients) -> f64 {
    let energy: f64 = members.iter().map(|f| difference(f, mean).energy()).sum();
    (energy / (4.0 * PI) / (members.len() as f64 - 1.0)).sqrt()
}

/// Returns a + k b.
fn plus(a: &Coefficients, b: &Coefficients, k: f64) -> Coefficients {
    let mut result = a.truncated(a.lmax().max(b.lmax()));
    for l in 0..=b.lmax() {
        for m in 0..=l {
            let ((a, b), (c, d)) = (a.get(l, m), b.get(l, m));
            result.set(l, m, a + k * c, b + k * d);
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(lmax: usize, k: f64) -> Coefficients {
        let mut c = Coefficients::zeros(lmax);
        for l in 0..=lmax {
            for m in 0..=l {
                c.set(l, m, k * (1 + l + m) as f64, k * (2 + l) as f64);
            }
        }
        c
    }

    #[test]
    fn nothing_and_bad_weights_are_refused() {
        assert!(mean(&[]).is_err());
        let c = ramp(1, 1.0);
        for weight in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = weighted_mean(&[(&c, 1.0), (&c, weight)]).expect_err("bad weight");
            assert!(error.to_string().contains("number 2"), "{error}");
        }
    }

    #[test]
    fn mean_pads_the_lower_degree() {
        let (low, high) = (ramp(1, 2.0), ramp(3, 4.0));
        let both = mean(&[&low, &high]).expect("two");
        assert_eq!((both.lmax(), both.get(1, 1), both.get(3, 2)), (3, (9.0, 9.0), (12.0, 10.0)));
        let weighted = weighted_mean(&[(&low, 3.0), (&high, 1.0)]).expect("two");
        assert_eq!(weighted.get(1, 1), (7.5, 7.5));
        let huge = weighted_mean(&[(&low, f64::MAX), (&low, f64::MAX)]).expect("two");
        assert_eq!(huge, low);
    }

    #[test]
    fn difference_is_antisymmetric_and_pads() {
        let (low, high) = (ramp(1, 2.0), ramp(3, 4.0));
        let there = difference(&low, &high);
        assert_eq!(there, difference(&high, &low).scaled(-1.0));
        assert_eq!((there.lmax(), there.get(1, 0).0, there.get(3, 0).0), (3, -4.0, -16.0));
        assert_eq!(difference(&high, &high), Coefficients::zeros(3));
    }

    #[test]
    fn scatter_of_two_spheres_is_their_sample_deviation() {
        let ball = |r| {
            let mut c = Coefficients::zeros(0);
            c.set(0, 0, r, 0.0);
            c
        };
        let (a, b) = (ball(1.0), ball(2.0));
        assert!((scatter(&[&a, &b], &ball(1.5)) - 0.5_f64.sqrt()).abs() <= 1e-15);
    }
}
