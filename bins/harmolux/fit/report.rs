//! What `harmolux fit` says about one fit.

use std::time::Duration;

use glam::DVec3;
use harmolux::fit::{Fit as MeshFit, PointFit, mesh_bytes, series_bytes};
use harmolux::sh::{Coefficients, Filter};
use serde_json::{Value, json};

use crate::common::{paths, progress, say};
use crate::fit::{Done, Fit, Fitted};

/// The part of the mean radius from which an RMS error of a fit, or a standard error in one
/// direction, is warned of; and from which an RMS standard error is.
const POOR: f64 = 0.05;
const UNCERTAIN: f64 = 0.01;

/// Lists what is to be minded of a fit, and what helps.
pub(crate) fn warnings(verb: &Fit, fitted: &Fitted) -> Vec<String> {
    match fitted {
        Fitted::Mesh(fit) => {
            let poor =
                poor(fit.error.rms, &fit.coefficients, "look at the mesh with `harmolux check`");
            ringing(verb, fit).into_iter().chain(poor).collect()
        }
        Fitted::Points(fit) => {
            let poor =
                poor(fit.rms, &fit.coefficients, "look for points that are no part of the shape");
            poor.into_iter().chain(uncertain(verb, fit)).collect()
        }
    }
}

/// Says that a series is far from what it stands for.
fn poor(rms: f64, series: &Coefficients, look: &str) -> Option<String> {
    let part = rms / series.mean().abs();
    (part > POOR).then(|| {
        format!(
            "the series is off by {} of the mean radius (RMS): raise the degree, `-l`, choose another \
             centre, `--centre`, or {look}",
            say::percent(part)
        )
    })
}

/// Says that the points do not tell the series well.
fn uncertain(verb: &Fit, fit: &PointFit) -> Option<String> {
    let (error, mean) = (fit.error?, fit.coefficients.mean().abs());
    let lambda = match verb.lambda.unwrap_or(0.0) {
        0.0 => "`--lambda 1e-6`".to_owned(),
        lambda => format!("a `--lambda` above {lambda}"),
    };
    (error.rms > UNCERTAIN * mean || error.largest > POOR * mean).then(|| {
        format!(
            "the points leave the series uncertain, by {} of the mean radius (RMS) and by {} {}: they \
             have a gap, or are few; lower the degree, `-l`, or damp the series, {lambda}",
            say::percent(error.rms / mean),
            say::percent(error.largest / mean),
            towards(error.direction)
        )
    })
}

fn towards(direction: DVec3) -> String {
    let [x, y, z] = direction.to_array().map(|v| format!("{v:.2}"));
    format!("towards ({x}, {y}, {z})")
}

/// Says that a series rings, and what helps; nothing where it does not.
fn ringing(verb: &Fit, fit: &MeshFit) -> Option<String> {
    let target = if fit.folds.is_some() { "the envelope" } else { "the mesh" };
    let advice = match verb.shaping.filter {
        Some(Filter::Lanczos) => "even with `--filter lanczos`: lower the degree, `-l`",
        _ => "add `--filter lanczos`, or lower the degree, `-l`",
    };
    fit.rings().then(|| {
        format!(
            "the series rings about jumps of the radius: its area is {} above that of {target}, \
             its normals are off by {} degrees in the mean; {advice}",
            say::percent(fit.excess_area()),
            say::significant(fit.error.normal_mean.to_degrees(), 3)
        )
    })
}

/// Prints the report.
pub(crate) fn print(verb: &Fit, done: &Done, elapsed: Duration, as_json: bool) {
    let Done { fitted, turn, .. } = done;
    for warning in warnings(verb, fitted) {
        say::warning(&warning);
    }
    if as_json {
        let mut report = match fitted {
            Fitted::Mesh(fit) => mesh_json(fit),
            Fitted::Points(fit) => points_json(fit),
        };
        report["filter"] = json!(verb.shaping.filter.map(|f| f.to_string()));
        report["rotation"] = json!(turn.map(|turn| turn.matrix().transpose().to_cols_array_2d()));
        report["seconds"] = json!(elapsed.as_secs_f64());
        paths::put(&mut report, "written", &verb.output);
        say::json(&report);
        return;
    }
    let (mut pairs, projection) = match fitted {
        Fitted::Mesh(fit) => (mesh_pairs(fit), fit.projection_time),
        Fitted::Points(fit) => (points_pairs(fit), fit.projection_time),
    };
    if let Some(filter) = verb.shaping.filter {
        pairs.push(("filter", format!("{filter}; the errors are those of the filtered series")));
    }
    if let Some(turn) = turn {
        pairs.push(("turned", say::turn(turn)));
    }
    let projection = 1e3 * projection.as_secs_f64();
    let all = progress::duration(elapsed);
    pairs.push(("time", format!("{all} in all, projection {projection:.0} ms")));
    let size = std::fs::metadata(&verb.output).map_or(0, |file| file.len() as usize);
    pairs.push(("written", format!("{}, {}", verb.output.display(), say::bytes(size))));
    say::pairs(&pairs);
}

fn mesh_json(fit: &MeshFit) -> Value {
    let lmax = fit.coefficients.lmax();
    let error = &fit.error;
    let folds = fit.folds.map(|f| {
        json!({
            "envelope": f.envelope.to_string(),
            "share": f.share,
            "quadrature_defect": f.defect,
        })
    });
    json!({
        "degree": lmax,
        "coefficients": fit.coefficients.count(),
        "bytes": series_bytes(lmax),
        "mesh_bytes": mesh_bytes(fit.mesh_size),
        "centre": fit.centre.to_array(),
        "clearance": fit.clearance,
        "not_star": folds,
        "mean_radius": fit.coefficients.mean(),
        "rms": error.rms,
        "rms_by_parseval": fit.parseval,
        "max": error.max,
        "normal_mean_degrees": error.normal_mean.to_degrees(),
        "normal_95_degrees": error.normal_95.to_degrees(),
        "volume": error.volume[1],
        "mesh_volume": error.volume[0],
        "rings": fit.rings(),
        "area": error.area[1],
        "mesh_area": error.area[0],
        "projection_seconds": fit.projection_time.as_secs_f64(),
    })
}

fn points_json(fit: &PointFit) -> Value {
    let lmax = fit.coefficients.lmax();
    json!({
        "degree": lmax,
        "coefficients": fit.coefficients.count(),
        "bytes": series_bytes(lmax),
        "points": fit.count,
        "centre": fit.centre.to_array(),
        "mean_radius": fit.coefficients.mean(),
        "rms": fit.rms,
        "max": fit.max,
        "standard_error": fit.error.map(|e| e.rms),
        "largest_standard_error": fit.error.map(|e| e.largest),
        "largest_standard_error_towards": fit.error.map(|e| e.direction.to_array()),
        "projection_seconds": fit.projection_time.as_secs_f64(),
    })
}

fn mesh_pairs(fit: &MeshFit) -> Vec<(&'static str, String)> {
    let [vertices, faces] = fit.mesh_size;
    let error = &fit.error;
    let storage = format!(
        "{} in f32 against {} of the mesh ({vertices} vertices, {faces} faces)",
        say::bytes(series_bytes(fit.coefficients.lmax())),
        say::bytes(mesh_bytes(fit.mesh_size)),
    );
    let clears = match fit.clearance {
        c if c > 0.0 => format!("every face clears it by {} m", say::significant(c, 3)),
        c => format!("{} m behind a face", say::significant(-c, 3)),
    };
    let mean = fit.coefficients.mean();
    let mut pairs = vec![
        degree(&fit.coefficients),
        ("storage", storage),
        ("centre", format!("{}, {clears}", place(fit.centre))),
    ];
    if let Some(folds) = fit.folds {
        let share =
            format!("{:.3} % of the directions meet the mesh more than once", 100.0 * folds.share);
        pairs.push(("folds", format!("{share}: the {} radius stands for them", folds.envelope)));
    }
    let named = |name: &str, [mesh, series]: [f64; 2], unit: &str| {
        let excess = 100.0 * (series / mesh - 1.0);
        let [of_series, of_mesh] = [series, mesh].map(|value| say::significant(value, 6));
        format!("{of_series} {unit}, {name} {of_mesh} {unit}, {excess:+.3} %")
    };
    let target = if fit.folds.is_some() { "envelope" } else { "mesh" };
    let parseval = fit
        .parseval
        .map_or(String::new(), |p| format!(" (by Parseval {})", say::percent(p / mean)));
    pairs.extend([
        mean_radius(&fit.coefficients),
        ("RMS error", format!("{}{parseval}", relative(error.rms, mean))),
        ("largest error", relative(error.max, mean)),
        (
            "normals",
            format!(
                "off by {} degrees in the mean, 95 % of the area below {}",
                say::significant(error.normal_mean.to_degrees(), 3),
                say::significant(error.normal_95.to_degrees(), 3)
            ),
        ),
        ("volume", named(target, error.volume, "m3")),
        ("area", named(target, error.area, "m2")),
    ]);
    pairs
}

fn points_pairs(fit: &PointFit) -> Vec<(&'static str, String)> {
    let mean = fit.coefficients.mean();
    let scatter = fit.error.map_or("unknown: no more points than coefficients".to_owned(), |e| {
        let largest = format!("{} {}", relative(e.largest, mean), towards(e.direction));
        let rms = relative(e.rms, mean);
        format!("{rms} (RMS), at most {largest}, if the points scatter independently")
    });
    vec![
        degree(&fit.coefficients),
        ("points", fit.count.to_string()),
        ("centre", place(fit.centre)),
        mean_radius(&fit.coefficients),
        ("RMS residual", relative(fit.rms, mean)),
        ("largest", relative(fit.max, mean)),
        ("standard error", scatter),
    ]
}

fn degree(series: &Coefficients) -> (&'static str, String) {
    ("degree", format!("{}, {} coefficients", series.lmax(), series.count()))
}

fn mean_radius(series: &Coefficients) -> (&'static str, String) {
    ("mean radius", format!("{} m", say::significant(series.mean(), 7)))
}

fn place(centre: DVec3) -> String {
    let [x, y, z] = centre.to_array().map(|v| say::significant(v, 4));
    format!("({x}, {y}, {z}) m")
}

fn relative(length: f64, mean: f64) -> String {
    format!("{} m, {}", say::significant(length, 3), say::percent(length / mean))
}
