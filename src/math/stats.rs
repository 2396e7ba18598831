//! Statistics of replicates: means, standard errors, intervals.
//!
//! Every estimate of this crate is the mean of R independent replicates; its standard error is
//! their standard deviation over sqrt R, and its interval uses Student's t with R - 1 degrees of
//! freedom.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// Holds an estimate and how far to trust it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The mean over replicates, in the unit of the quantity.
    pub mean: f64,
    /// The standard error of the mean, same unit.
    pub standard_error: f64,
    /// How many independent replicates stand behind it.
    pub replicates: usize,
}

impl Estimate {
    /// Averages independent replicates; an infinite standard error says that fewer than two were
    /// given.
    pub fn of_replicates(values: &[f64]) -> Self {
        let n = values.len();
        let mean = values.iter().sum::<f64>() / n.max(1) as f64;
        let standard_error = if n < 2 {
            f64::INFINITY
        } else {
            let ss: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
            (ss / ((n - 1) * n) as f64).sqrt()
        };
        Self { mean, standard_error, replicates: n }
    }

    /// Takes a value whose error is not known: all errors, widths and deviations are NaN, and it
    /// agrees with nothing.
    pub const fn without_error(mean: f64) -> Self {
        Self { mean, standard_error: f64::NAN, replicates: 1 }
    }

    /// Returns the half width of the two-sided interval that holds the truth with probability `1 -
    /// alpha`.
    pub fn half_width(&self, alpha: f64) -> f64 {
        student_t(alpha, self.replicates.saturating_sub(1)) * self.standard_error
    }

    /// Returns the 95 % half width relative to the mean.
    pub fn relative_half_width(&self) -> f64 {
        self.half_width(0.05) / self.mean.abs()
    }

    /// Returns the standard error relative to the mean.
    pub fn relative_error(&self) -> f64 {
        self.standard_error / self.mean.abs()
    }

    /// Returns how far the estimate lies above an exact value, in standard errors; 0 where they
    /// differ by rounding, at most 1e-13 of the value.
    pub fn deviation(&self, exact: f64) -> f64 {
        let difference = self.mean - exact;
        if difference.abs() <= 1e-13 * exact.abs() { 0.0 } else { difference / self.standard_error }
    }

    /// Whether `reference` (with its own standard error) is consistent with the estimate when
    /// `count` values are judged together with a family false-alarm rate of 1e-3: |x - ref| <=
    /// t(1e-3/count; R-1) sqrt(se^2 + se_ref^2) + 1e-9 |ref|.
    pub fn agrees_with(&self, reference: f64, reference_error: f64, count: usize) -> bool {
        let t = student_t(1e-3 / count.max(1) as f64, self.replicates.saturating_sub(1));
        let se = self.standard_error.hypot(reference_error);
        (self.mean - reference).abs() <= t * se + 1e-9 * reference.abs()
    }
}

/// Returns the two-sided critical value of Student's t: |T| exceeds it with probability `alpha`
/// (infinite for no degree of freedom).
pub fn student_t(alpha: f64, degrees: usize) -> f64 {
    // Far out the quantiles of one and two degrees are beyond what `statrs` finds.
    match degrees {
        1 => return 1.0 / (0.5 * std::f64::consts::PI * alpha).tan(),
        2 => return (1.0 - alpha) / (alpha * (1.0 - 0.5 * alpha)).sqrt(),
        _ => {}
    }
    match StudentsT::new(0.0, 1.0, degrees as f64) {
        Ok(t) => t.inverse_cdf(1.0 - 0.5 * alpha),
        Err(_) => f64::INFINITY,
    }
}

/// Returns the first quartile, the median and the third, each a value that occurs; NaN of nothing.
pub fn quartiles(values: impl IntoIterator<Item = f64>) -> [f64; 3] {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    [1, 2, 3].map(|quarter| {
        let place = quarter * values.len().saturating_sub(1);
        values.get((place + 2) / 4).copied().unwrap_or(f64::NAN)
    })
}

/// Returns the median of the finite values; `None` when there are none.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut finite: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
    if finite.is_empty() {
        return None;
    }
    let middle = finite.len() / 2;
    let (_, upper, _) = finite.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*upper)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_of_a_sequence() {
        assert_eq!(quartiles((1..=21).map(f64::from)), [6.0, 11.0, 16.0]);
        assert_eq!(quartiles([3.0]), [3.0; 3]);
        assert!(quartiles([])[1].is_nan());
    }

    #[test]
    fn one_replicate_has_no_error_bar() {
        let e = Estimate::of_replicates(&[3.0]);
        assert!((e.mean - 3.0).abs() <= 0.0 && e.standard_error.is_infinite());
    }

    #[test]
    fn student_t_matches_tables() {
        assert!((student_t(0.05, 31) - 2.039_513).abs() <= 1e-5);
        assert!((student_t(0.01, 10) - 3.169_273).abs() <= 1e-5);
        assert!((student_t(1e-4, 31) - 4.460_989).abs() <= 1e-5);
        assert!((student_t(0.05, 1) - 12.706_205).abs() <= 1e-5);
        assert!((student_t(0.05, 2) - 4.302_653).abs() <= 1e-5);
        // 2 / (pi alpha), and 1 / sqrt(alpha).
        assert!((student_t(1e-12, 1) / 6.366_197_724e11 - 1.0).abs() <= 1e-9);
        assert!((student_t(1e-12, 2) / 1e6 - 1.0).abs() <= 1e-9);
        assert!(student_t(0.05, 0).is_infinite());
    }

    #[test]
    fn replicates_give_mean_and_error() {
        let e = Estimate::of_replicates(&[1.0, 2.0, 3.0, 4.0]);
        assert!((e.mean - 2.5).abs() <= 1e-15);
        assert!((e.standard_error - (5.0_f64 / 12.0).sqrt()).abs() <= 1e-15);
    }

    #[test]
    fn median_ignores_what_is_not_finite() {
        assert_eq!(median([f64::NAN, 3.0, 1.0, 2.0, f64::INFINITY]), Some(2.0));
        assert_eq!(median([f64::NAN]), None);
    }
}
