//! Whether groups of sensors show what `[require]` asks of them: met, not met, or undecided by the
//! interval.

use crate::estimators::{Bracket, GroupSummary};
use crate::io::scene_file::{Limit, Quantity, RequireSpec};

/// Says whether a requirement is met.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The whole interval meets it, or the value that has none.
    Met,
    /// No part of the interval meets it, or not the value that has none.
    NotMet,
    /// The interval holds the limit: more walks would tell.
    Undecided,
}

/// Holds one requirement and how it was judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judged {
    /// What is required.
    pub quantity: Quantity,
    /// Within which limit.
    pub limit: Limit,
    /// What was found; a uniformity in the dark is 0.
    pub found: Bracket,
    /// Whether that is enough.
    pub verdict: Verdict,
}

impl Judged {
    /// Whether the limit lies within the interval.
    pub fn is_within_interval(&self) -> bool {
        verdict(self.limit, self.found) == Verdict::Undecided
    }
}

/// Judges all requirements on a group of sensors; where no interval is known, by the value alone.
/// Without a summary, for no sensor counts, nothing is decided. When light is `missing` the values
/// are too low, and what more light could change is undecided.
pub fn judge(require: &RequireSpec, summary: Option<&GroupSummary>, missing: bool) -> Vec<Judged> {
    let exact = |value| Bracket { value, low: value, high: value };
    let (dark, unknown) = (exact(0.0), exact(f64::NAN));
    require
        .limits()
        .map(|(quantity, limit)| {
            let found = summary.map_or(unknown, |summary| match quantity {
                Quantity::Mean => summary.mean,
                Quantity::Least => summary.least,
                Quantity::Largest => summary.largest,
                Quantity::Uniformity => summary.uniformity.unwrap_or(dark),
            });
            let verdict = match (verdict(limit, found), limit) {
                (Verdict::Met, Limit::AtMost(_)) | (Verdict::NotMet, Limit::AtLeast(_))
                    if missing =>
                {
                    Verdict::Undecided
                }
                _ if missing && quantity == Quantity::Uniformity => Verdict::Undecided,
                (verdict, _) => verdict,
            };
            Judged { quantity, limit, found, verdict }
        })
        .collect()
}

fn verdict(limit: Limit, found: Bracket) -> Verdict {
    let (low, high) =
        if found.has_interval() { (found.low, found.high) } else { (found.value, found.value) };
    let (met, refuted) = match limit {
        Limit::AtLeast(limit) => (low >= limit, high < limit),
        Limit::AtMost(limit) => (high <= limit, low > limit),
    };
    if met {
        Verdict::Met
    } else if refuted {
        Verdict::NotMet
    } else {
        Verdict::Undecided
    }
}

#[cfg(test)]
mod tests {
    use super::Verdict::{Met, NotMet, Undecided};
    use super::*;

    #[test]
    fn interval_decides() {
        let found = Bracket { value: 5.0, low: 4.0, high: 6.0 };
        for (limit, expected) in [
            (Limit::AtLeast(4.0), Verdict::Met),
            (Limit::AtLeast(4.1), Verdict::Undecided),
            (Limit::AtLeast(6.1), Verdict::NotMet),
            (Limit::AtMost(6.0), Verdict::Met),
            (Limit::AtMost(5.9), Verdict::Undecided),
            (Limit::AtMost(3.9), Verdict::NotMet),
        ] {
            assert_eq!(verdict(limit, found), expected, "{limit:?}");
        }
        // Without an interval the value decides.
        let bare = Bracket { value: 5.0, low: f64::NAN, high: f64::NAN };
        assert_eq!(verdict(Limit::AtLeast(5.0), bare), Verdict::Met);
        assert_eq!(verdict(Limit::AtMost(4.9), bare), Verdict::NotMet);
        // Nothing is known of what is not a number.
        let nan = Bracket { value: f64::NAN, low: f64::NAN, high: f64::NAN };
        assert_eq!(verdict(Limit::AtLeast(1.0), nan), Verdict::Undecided);
        let dark = RequireSpec { mean_max: Some(1.0), ..RequireSpec::default() };
        let judged = judge(&dark, None, false);
        assert!(judged.len() == 1 && judged[0].verdict == Verdict::Undecided);
        // More light than was found can only raise an illuminance.
        let of = |value, missing| {
            let summary = GroupSummary::without_errors(&[value]);
            let both = RequireSpec { mean_min: Some(5.0), mean_max: Some(9.0), ..dark };
            judge(&both, summary.as_ref(), missing).iter().map(|j| j.verdict).collect::<Vec<_>>()
        };
        assert_eq!([of(4.0, false), of(4.0, true)], [[NotMet, Met], [Undecided, Undecided]]);
        assert_eq!([of(7.0, false), of(7.0, true)], [[Met, Met], [Met, Undecided]]);
        assert_eq!(of(10.0, true), [Met, NotMet]);
    }
}
