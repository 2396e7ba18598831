//! What `render` says of a picture: warnings, a report for people, and one as JSON.

use std::path::PathBuf;

use harmolux::error::shown;
use harmolux::estimators::{Ending, Rendering, SHARE_WITHIN};
use harmolux::fit::{mesh_bytes, series_bytes};
use harmolux::scene::Film;
use harmolux::study::{FittedObject, Loaded};
use serde_json::json;

use super::detail;
use crate::common::scenes::distinct;
use crate::common::{paths, progress, say};

/// Says what may be wrong with the picture.
pub(super) fn warn(rendering: &Rendering) {
    if rendering.film.non_finite() > 0 {
        say::warning(&format!(
            "{} samples were not finite; they are counted here and nowhere else",
            rendering.film.non_finite()
        ));
    }
    let mean = rendering.film.mean().0;
    if mean == 0.0 {
        say::warning("no light came to any pixel: see where camera, lamps and walls are");
    } else if mean.is_nan() || mean.abs() > f64::from(f32::MAX) {
        say::warning(
            "luminances are beyond what a picture can hold (3e38 cd/m2): see the strength of the \
             lamps",
        );
    }
    if rendering.escaped > 0.0 {
        say::warning(&format!("{} of the light left the scene", say::percent(rendering.escaped)));
    }
    if rendering.caustic > 0.0 {
        say::warning(&format!(
            "{} of the light goes from point lights to mirrors, which send it on; what it lights \
             is missing where those places are seen in a mirror (with the estimator `path`, \
             everywhere), since no ray finds a point in a mirror; give those lights a size: a \
             sphere or a rectangle with an exitance",
            say::percent(rendering.caustic)
        ));
    }
    if let Some(share) = rendering.unfinished {
        say::warning(&format!(
            "ended in its first pass: {} of the rows are done, the others are black, and no error \
             is known; give it more time (`render.stop.time`), or take a smaller `--size`",
            say::percent(share)
        ));
    } else if rendering.ending == Ending::Interrupted {
        say::warning("interrupted: the files hold the picture so far");
    }
}

fn object_lines(fits: &[FittedObject]) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
    for FittedObject { name, fit } in distinct(fits) {
        let lmax = fit.coefficients.lmax();
        let (own, mesh) = (series_bytes(lmax), mesh_bytes(fit.mesh_size));
        lines.push((
            "object",
            format!("{}: degree {lmax}, {} coefficients", shown(name), fit.coefficients.count()),
        ));
        lines.push((
            "storage",
            format!(
                "{} against {} of the mesh, 1/{:.0}",
                say::bytes(own),
                say::bytes(mesh),
                mesh as f64 / own as f64
            ),
        ));
        lines.push((
            "error of the fit",
            format!(
                "RMS {}, largest {} of the mean radius",
                say::percent(fit.relative_rms()),
                say::percent(fit.relative_max())
            ),
        ));
    }
    lines
}

/// Prints what was rendered, for people.
pub(super) fn print(fits: &[FittedObject], rendering: &Rendering, written: &[PathBuf]) {
    let mut lines = object_lines(fits);
    let film = &rendering.film;
    let [width, height] = film.size();
    let error = film.median_relative_error().map_or("unknown".to_owned(), say::percent);
    lines.push((
        "image",
        format!("{width} x {height}, mean {} cd/m2", say::significant(film.mean().0, 4)),
    ));
    let walks = rendering.walks_per_pixel;
    let mean = rendering.mean_walks_per_pixel;
    let rested = if mean < 0.995 * walks as f64 {
        format!(" at most, {mean:.0} in the mean,")
    } else {
        String::new()
    };
    let replicates = film.replicates();
    lines.push(("walks", format!("{walks} per pixel{rested} in {replicates} replicates")));
    lines.push(("time", progress::duration(rendering.elapsed)));
    let most = known_error(film).map_or("unknown".to_owned(), say::percent);
    lines.push((
        "relative error",
        format!("{error} (median standard error of a pixel), at most {most} in 95 % of the pixels"),
    ));
    for path in written {
        lines.push(("written", path.display().to_string()));
    }
    say::pairs(&lines);
}

/// Returns the relative error of 95 % of the pixels, if it is known.
fn known_error(film: &Film) -> Option<f64> {
    let is_known = film.median_relative_error().is_some_and(f64::is_finite);
    film.relative_error_of(SHARE_WITHIN).filter(|_| is_known)
}

/// Returns what was rendered; `target` is the error that was asked for.
pub(super) fn json(
    loaded: &Loaded,
    rendering: &Rendering,
    target: Option<f64>,
    written: &[PathBuf],
) -> serde_json::Value {
    let film = &rendering.film;
    let objects: Vec<_> = loaded
        .fits
        .iter()
        .map(|FittedObject { name, fit }| {
            json!({
                "name": name,
                "degree": fit.coefficients.lmax(),
                "coefficients": fit.coefficients.count(),
                "bytes": series_bytes(fit.coefficients.lmax()),
                "mesh_bytes": mesh_bytes(fit.mesh_size),
                "relative_rms": fit.relative_rms(),
                "relative_max": fit.relative_max(),
            })
        })
        .collect();
    let (mean, standard_error) = film.mean();
    let mut value = json!({
        "objects": objects,
        "details": detail::json(&loaded.details),
        "patch_bytes": loaded.preparation.patch_bytes,
        "preparation_seconds": loaded.preparation.time.as_secs_f64(),
        "resolution": film.size(),
        "mean_luminance": mean,
        "mean_luminance_standard_error": standard_error,
        "walks_per_pixel": rendering.walks_per_pixel,
        "mean_walks_per_pixel": rendering.mean_walks_per_pixel,
        "replicates": film.replicates(),
        "seconds": rendering.elapsed.as_secs_f64(),
        "median_relative_error": film.median_relative_error(),
        "relative_error_of_95_percent": known_error(film),
        "share_within_target": target.map(|target| film.share_within(target)),
        "escaped_share": rendering.escaped,
        "caustic_share": rendering.caustic,
        "non_finite_samples": film.non_finite(),
        "first_pass_share": rendering.unfinished,
        "ending": rendering.ending.name(),
    });
    paths::put_all(&mut value, "written", written.iter().map(PathBuf::as_path));
    value
}
