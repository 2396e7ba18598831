//! The figures of a sweep: errors over bytes and over degree, times over degree, the spectrum.

use super::{Column, Rendition, SweepRow};
use crate::plots::{Axis, Curve, Figure, Style};
use crate::sh::{Coefficients, Spectrum};

/// Lists the figures of a sweep, each with the name of its file. `series` is the highest degree
/// that was swept, or the original.
pub fn sweep_figures(rows: &[SweepRow], series: &Coefficients) -> Vec<(&'static str, Figure)> {
    vec![
        ("error_bytes", error_bytes(rows)),
        ("error_degree", error_degree(rows)),
        ("time_degree", time_degree(rows)),
        ("spectrum", spectrum(series, rows)),
    ]
}

/// Joins a value over another, of the lines of one rendition.
fn points(rows: &[SweepRow], of: Rendition, x: Column, y: Column) -> Vec<[f64; 2]> {
    let own = rows.iter().filter(|row| row.rendition == of);
    let percent =
        |column: Column, value: f64| if column.unit() == "%" { 100.0 * value } else { value };
    let point = |row: &SweepRow| [row[x], percent(y, row[y])];
    own.map(point).filter(|point| point.iter().all(|v| v.is_finite())).collect()
}

fn error_bytes(rows: &[SweepRow]) -> Figure {
    let rms = |of, bytes| points(rows, of, bytes, Column::RelativeRms);
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

fn by_degree(rows: &[SweepRow], of: Rendition, y: Column) -> Vec<[f64; 2]> {
    let own = rows.iter().filter(|row| row.rendition == of);
    let point = |row: &SweepRow| Some([row.degree? as f64, row[y]]);
    own.filter_map(point).filter(|point| point[1].is_finite()).collect()
}

fn error_degree(rows: &[SweepRow]) -> Figure {
    let curve = |name, of, column| {
        let shares = by_degree(rows, of, column).into_iter().map(|[l, share]| [l, 100.0 * share]);
        Curve::new(name, shares.collect())
    };
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
    let left_out = by_degree(rows, Rendition::Series, Column::RelativeRms).into_iter();
    let left_out = left_out.map(|[l, share]| [l, 100.0 * share]).collect();
    Figure::new(
        "Spectrum",
        [Axis::logarithmic("degree"), Axis::logarithmic("% of the mean radius")],
        vec![Curve::new("amplitude of the degree", own), Curve::new("RMS of all above", left_out)],
    )
}
