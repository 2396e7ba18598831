//! What the sensors of a group say together: mean, least, largest and uniformity, each with an
//! interval of its own.

use super::replicates::REPLICATES;
use crate::math::stats::{Estimate, student_t};

/// The intervals hold with this probability of error.
const ALPHA: f64 = 0.05;

/// A value and the interval that holds the truth with 95 %; the ends are NaN where no error is
/// known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bracket {
    /// The value.
    pub value: f64,
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

/// Sums up a group of sensors.
///
/// The least, the largest and the uniformity rest on intervals that hold for all sensors at once
/// (Bonferroni): whichever sensor is the darkest in truth, the least lies above the lowest lower
/// end and below every upper end. Their values are those of the estimates, of which the least is a
/// little too low and the largest too high as long as the intervals of sensors overlap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupSummary {
    /// The mean over the sensors, lx; its error counts that all sensors share their walks.
    pub mean: Bracket,
    /// The least illuminance, lx.
    pub least: Bracket,
    /// The largest illuminance, lx.
    pub largest: Bracket,
    /// U0 = least / mean, 0 to 1; `None` in the dark.
    pub uniformity: Option<Bracket>,
}

impl GroupSummary {
    /// Sums up what each sensor of a group received in each replicate, lx; `None` for no sensors.
    pub fn of(sensors: &[[f64; REPLICATES]]) -> Option<Self> {
        if sensors.is_empty() {
            return None;
        }
        let count = sensors.len() as f64;
        let mut means = [0.0; REPLICATES];
        for sensor in sensors {
            means.iter_mut().zip(sensor).for_each(|(mean, e)| *mean += e / count);
        }
        let mean = Estimate::of_replicates(&means);
        // One quantile serves all sensors.
        let t = student_t(ALPHA / count, REPLICATES - 1);
        let brackets = |estimate: fn(&[f64; REPLICATES], &[f64; REPLICATES], f64) -> Estimate| {
            let estimates = sensors.iter().map(move |s| estimate(s, &means, mean.mean));
            estimates.map(move |e| Bracket::around(e.mean, t * e.standard_error))
        };
        let plain = |sensor: &[f64; REPLICATES], _: &[f64; REPLICATES], _: f64| {
            Estimate::of_replicates(sensor)
        };
        Some(Self {
            mean: Bracket::around(mean.mean, mean.half_width(ALPHA)),
            least: brackets(plain).reduce(Bracket::min)?,
            largest: brackets(plain).reduce(Bracket::max)?,
            uniformity: if mean.mean > 0.0 {
                brackets(ratio).reduce(Bracket::min).map(Bracket::within_one)
            } else {
                None
            },
        })
    }
}

impl GroupSummary {
    /// Sums up the illuminances of a group, lx, whose errors are not known: values without
    /// intervals. `None` for no sensors.
    pub fn without_errors(sensors: &[f64]) -> Option<Self> {
        let least = sensors.iter().copied().reduce(f64::min)?;
        let largest = sensors.iter().copied().reduce(f64::max)?;
        let mean = sensors.iter().sum::<f64>() / sensors.len() as f64;
        let bracket = |value| Bracket::around(value, f64::NAN);
        Some(Self {
            mean: bracket(mean),
            least: bracket(least),
            largest: bracket(largest),
            uniformity: (mean > 0.0).then(|| bracket(least / mean)),
        })
    }
}

/// Estimates E / mean by linearisation: its replicates are r + (E_k - r mean_k) / mean, in which
/// what both share cancels.
fn ratio(sensor: &[f64; REPLICATES], means: &[f64; REPLICATES], mean: f64) -> Estimate {
    let of_means = sensor.iter().sum::<f64>() / (REPLICATES as f64 * mean);
    let replicates: [f64; REPLICATES] =
        std::array::from_fn(|k| of_means + (sensor[k] - of_means * means[k]) / mean);
    Estimate::of_replicates(&replicates)
}

impl Bracket {
    /// Whether the interval is known.
    pub fn has_interval(&self) -> bool {
        !(self.low.is_nan() || self.high.is_nan())
    }

    /// Makes the interval about a value that cannot be negative.
    fn around(value: f64, half_width: f64) -> Self {
        // NaN stays NaN.
        let cut = |x: f64| if x < 0.0 { 0.0 } else { x };
        Self { value: cut(value), low: cut(value - half_width), high: cut(value + half_width) }
    }

    /// Cuts off what is above 1, which a uniformity cannot be.
    fn within_one(self) -> Self {
        Self { high: if self.high > 1.0 { self.value.max(1.0) } else { self.high }, ..self }
    }

    fn min(self, other: Self) -> Self {
        Self {
            value: self.value.min(other.value),
            low: self.low.min(other.low),
            high: self.high.min(other.high),
        }
    }

    fn max(self, other: Self) -> Self {
        Self {
            value: self.value.max(other.value),
            low: self.low.max(other.low),
            high: self.high.max(other.high),
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    #[test]
    fn exact_sensors_have_no_width_and_none_no_summary() {
        let s = GroupSummary::of(&[[2.0; REPLICATES], [6.0; REPLICATES]]).expect("two sensors");
        let exact = |x: f64| Bracket { value: x, low: x, high: x };
        assert_eq!((s.mean, s.least, s.largest), (exact(4.0), exact(2.0), exact(6.0)));
        assert_eq!(s.uniformity, Some(exact(0.5)));
        assert_eq!(GroupSummary::of(&[]), None);
        let dark = GroupSummary::of(&[[0.0; REPLICATES]]).expect("one sensor");
        assert_eq!(dark.uniformity, None);
    }

    #[test]
    fn values_without_errors_have_no_intervals() {
        let s = GroupSummary::without_errors(&[2.0, 6.0]).expect("two sensors");
        let uniformity = s.uniformity.expect("light");
        let values = [s.mean.value, s.least.value, s.largest.value, uniformity.value];
        assert_eq!(values, [4.0, 2.0, 6.0, 0.5]);
        assert!(![s.mean, s.least, s.largest, uniformity].iter().any(Bracket::has_interval));
        assert_eq!(GroupSummary::without_errors(&[]), None);
    }

    /// 2000 groups of 20 sensors of known truth, with noise that half of it is shared. Each
    /// interval is to hold in 95 % of them: fewer than 1840 holds would happen once in 1e8 runs.
    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(20);
        let mut noise = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let truth: Vec<f64> = (0..20).map(|i| 100.0 + f64::from(i % 7)).collect();
        let mean = truth.iter().sum::<f64>() / 20.0;
        let mut held = [0; 4];
        for _ in 0..2000 {
            let shared: [f64; REPLICATES] = std::array::from_fn(|_| 5.0 * noise());
            let sensors: Vec<[f64; REPLICATES]> = truth
                .iter()
                .map(|e| std::array::from_fn(|k| e + shared[k] + 5.0 * noise()))
                .collect();
            let s = GroupSummary::of(&sensors).expect("sensors");
            let holds = |b: Bracket, truth: f64| u32::from(b.low <= truth && truth <= b.high);
            held[0] += holds(s.mean, mean);
            held[1] += holds(s.least, 100.0);
            held[2] += holds(s.largest, 106.0);
            held[3] += holds(s.uniformity.expect("light"), 100.0 / mean);
        }
        assert!(held.iter().all(|h| *h >= 1840), "{held:?}");
    }
}
