//! The figure of a sweep: errors over bytes.

use super::SweepRow;
use crate::fit::Fit;
use crate::plots::{Axis, Curve, Figure};

/// Plots the errors of a sweep against the bytes they cost.
pub fn sweep_figure(rows: &[SweepRow]) -> Figure {
    let fits = || rows.iter().filter_map(|row| Some((row.fit.as_ref()?, row.bytes as f64)));
    let curve = |name: &str, error: fn(&Fit) -> f64| {
        Curve::new(name, fits().map(|(fit, bytes)| [bytes, 100.0 * error(fit)]).collect())
    };
    let degrees = || fits().map(|(fit, _)| fit.coefficients.lmax());
    let bytes = match (degrees().min(), degrees().max()) {
        (Some(first), Some(last)) if first < last => {
            format!("bytes in f32, degree {first} to {last}")
        }
        _ => "bytes in f32".to_owned(),
    };
    Figure::new(
        "Radial error of the coefficients",
        [Axis::logarithmic(bytes), Axis::logarithmic("error, % of the mean radius")],
        vec![curve("largest", Fit::relative_max), curve("RMS", Fit::relative_rms)],
    )
}
