//! The figures of a sweep: errors over bytes and over degree, times over degree, the spectrum.

use super::{Column, Rendition, SweepRow};
use crate::plots::{Axis, Curve, Figure, Style};
use crate::sh::{Coefficients, Spectrum};

/// The names of the figures of a sweep, for files.
pub const SWEEP_FIGURES: [&str; 4] = ["error_bytes", "error_degree", "time_degree", "spectrum"];

/// Draws the figures of a sweep, in the order of their names. `series` is the highest degree that
/// was swept, or the original.
pub fn sweep_figures(rows: &[SweepRow], series: &Coefficients) -> [Figure; 4] {
    [error_bytes(rows), error_degree(rows), time_degree(rows), spectrum(series, rows)]
}

/// Joins a value over another, of the lines of one rendition; shares as per cent.
fn points(
    rows: &[SweepRow],
    of: Rendition,
    x: impl Fn(&SweepRow) -> f64,
    y: Column,
) -> Vec<[f64; 2]> {
    let own = rows.iter().filter(|row| row.rendition == of);
    let factor = if y.unit() == "%" { 100.0 } else { 1.0 };
    let point = |row: &SweepRow| [x(row), factor * row[y]];
    own.map(point).filter(|point| point.iter().all(|v| v.is_finite())).collect()
}

fn by_degree(rows: &[SweepRow], of: Rendition, y: Column) -> Vec<[f64; 2]> {
    points(rows, of, |row| row.degree.map_or(f64::NAN, |l| l as f64), y)
}

fn error_bytes(rows: &[SweepRow]) -> Figure {
    let rms = |of, bytes| points(rows, of, |row| row[bytes], Column::RelativeRms);
    let mut curves = vec![
        Curve::new("decimated mesh, f32", rms(Rendition::Decimated, Column::BytesF32)),
        Curve::new("decimated mesh, quantised", rms(Rendition::Decimated, Column::BytesCompact)),
        Curve::new("coefficients, f32", rms(Rendition::Series, Column::BytesF32)),
        Curve::new("coefficients, .hxc", rms(Rendition::Series, Column::BytesCompact)),
    ];
    curves.retain(|curve| !curve.points.is_empty());
    let least = curves.iter().flat_map(|c| &c.points).map(|p| p[1]).fold(f64::INFINITY, f64::min);
    for original in rows.iter().filter(|row| row.rendition == Rendition::Original) {
        for (name, bytes) in [
            ("mesh, f32", Column::BytesF32),
            ("mesh, PLY", Column::BytesPly),
            ("mesh, STL", Column::BytesStl),
            ("mesh, OBJ", Column::BytesText),
        ] {
            // A mesh has no error, and a logarithm no zero: it stands at the foot.
            if original[Column::BytesStl].is_finite() && least.is_finite() {
                let point = vec![[original[bytes], least]];
                curves.push(Curve::new(name, point).drawn(Style::Points));
            }
        }
    }
    Figure::new(
        "Error against bytes (the mesh, without error, at the foot)",
        [Axis::logarithmic("bytes"), Axis::logarithmic("RMS error, % of the mean radius")],
        curves,
    )
}

fn error_degree(rows: &[SweepRow]) -> Figure {
    let curve = |name, of, column| Curve::new(name, by_degree(rows, of, column));
    let mut curves = vec![
        curve("largest", Rendition::Series, Column::RelativeMax),
        curve("RMS", Rendition::Series, Column::RelativeRms),
        curve("RMS of a mesh of as many bytes", Rendition::Decimated, Column::RelativeRms),
    ];
    curves.retain(|curve| !curve.points.is_empty());
    Figure::new(
        "Error against degree",
        [Axis::logarithmic("degree"), Axis::logarithmic("error, % of the mean radius")],
        curves,
    )
}

fn time_degree(rows: &[SweepRow]) -> Figure {
    let curve = |name, [median, low, high]: [Column; 3]| {
        let own = rows.iter().filter(|row| row.rendition == Rendition::Series);
        let own = own.filter(|row| row[median].is_finite());
        let (points, errors) = own
            .filter_map(|row| {
                let error = [row[median] - row[low], row[high] - row[median]];
                Some(([row.degree? as f64, row[median]], error))
            })
            .unzip();
        Curve::new(name, points).with_errors(errors)
    };
    let mut curves = vec![
        curve("first hit", [Column::Hit, Column::HitLow, Column::HitHigh]),
        curve("batches", [Column::HitBatch, Column::HitBatchLow, Column::HitBatchHigh]),
        curve("occlusion", [Column::Blocked, Column::BlockedLow, Column::BlockedHigh]),
    ];
    let degrees = by_degree(rows, Rendition::Series, Column::Hit).into_iter().map(|[l, _]| l);
    let ends = degrees.fold(None, |ends: Option<[f64; 2]>, l| {
        Some(ends.map_or([l; 2], |[a, b]| [a.min(l), b.max(l)]))
    });
    for original in rows.iter().filter(|row| row.rendition == Rendition::Original) {
        for (name, column) in
            [("original: first hit", Column::Hit), ("original: batches", Column::HitBatch)]
        {
            let line = ends.iter().flatten().map(|l| [*l, original[column]]).collect();
            curves.push(Curve::new(name, line).drawn(Style::Line));
        }
    }
    Figure::new(
        "Time of a ray (bars: quartiles)",
        [Axis::linear("degree"), Axis::linear("time, ns")],
        curves,
    )
}

fn spectrum(series: &Coefficients, rows: &[SweepRow]) -> Figure {
    let spectrum = Spectrum::of(series);
    let degrees = spectrum.degrees().iter().skip(1).filter(|degree| degree.amplitude > 0.0);
    let percent = 100.0 / series.mean();
    let own = degrees.map(|d| [d.degree as f64, percent * d.amplitude]).collect();
    let left_out = by_degree(rows, Rendition::Series, Column::RelativeRms);
    Figure::new(
        "Spectrum",
        [Axis::logarithmic("degree"), Axis::logarithmic("% of the mean radius")],
        vec![Curve::new("amplitude of the degree", own), Curve::new("RMS of all above", left_out)],
    )
}
