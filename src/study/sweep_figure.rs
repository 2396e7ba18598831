//! The figure of a sweep: errors over bytes.

use super::{SweepRow, SweptSeries};
use crate::plots::{Axis, Curve, Figure};

/// Plots the errors of a sweep against the bytes they cost.
pub fn sweep_figure(rows: &[SweepRow]) -> Figure {
    let series = || rows.iter().filter_map(|row| Some((row.series?, row.bytes as f64)));
    let curve = |name: &str, error: fn(&SweptSeries) -> f64| {
        Curve::new(name, series().map(|(s, bytes)| [bytes, 100.0 * error(&s)]).collect())
    };
    let degrees = || series().map(|(s, _)| s.degree);
    let bytes = match (degrees().min(), degrees().max()) {
        (Some(first), Some(last)) if first < last => {
            format!("bytes in f32, degree {first} to {last}")
        }
        _ => "bytes in f32".to_owned(),
    };
    Figure::new(
        "Radial error of the coefficients",
        [Axis::logarithmic(bytes), Axis::logarithmic("error, % of the mean radius")],
        vec![curve("largest", |s| s.relative_max), curve("RMS", |s| s.relative_rms)],
    )
}
