//! What a set of values comes to: its extremes and what is not a number.

/// Holds the extremes of values, each with its place among them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tally {
    /// The least finite value; `None` when there is none.
    pub least: Option<(usize, f64)>,
    /// The largest finite value.
    pub largest: Option<(usize, f64)>,
    /// The mean of the finite values; NaN when there is none.
    pub mean: f64,
    /// How many are finite.
    pub finite: usize,
    /// How many are NaN or infinite.
    pub not_finite: usize,
}

impl Tally {
    /// Goes through values with their places; of equal extremes the first counts.
    pub(super) fn of(values: &(impl Iterator<Item = (usize, f64)> + Clone)) -> Self {
        let finite = || values.clone().filter(|(_, v)| v.is_finite());
        let count = finite().count();
        // Dividing first keeps the sum of huge values finite.
        let mean = finite().map(|(_, v)| v / count as f64).sum::<f64>();
        Self {
            least: finite().reduce(|a, b| if b.1 < a.1 { b } else { a }),
            largest: finite().reduce(|a, b| if b.1 > a.1 { b } else { a }),
            mean: if count == 0 { f64::NAN } else { mean },
            finite: count,
            not_finite: values.clone().count() - count,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: &[f64]) -> Tally {
        Tally::of(&values.iter().copied().enumerate())
    }

    #[test]
    fn nothing_finite_has_no_extremes() {
        for values in [&[][..], &[f64::NAN, f64::INFINITY]] {
            let tally = of(values);
            assert!(tally.least.is_none() && tally.largest.is_none() && tally.mean.is_nan());
            assert_eq!((tally.finite, tally.not_finite), (0, values.len()));
        }
    }

    #[test]
    fn extremes_are_the_first_of_their_value() {
        let tally = of(&[2.0, f64::NAN, 1.0, 3.0, 1.0, 3.0]);
        assert_eq!((tally.least, tally.largest), (Some((2, 1.0)), Some((3, 3.0))));
        assert_eq!((tally.mean, tally.finite, tally.not_finite), (2.0, 5, 1));
    }
}
