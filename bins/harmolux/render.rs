//! `harmolux render`: a scene becomes a picture.

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use harmolux::Result;
use harmolux::estimators::{
    Ending, Estimator, ImageSettings, Keeper, Rendering, SHARE_WITHIN, Stop, Weighting, render_on,
};
use harmolux::io::scene_file::{RenderEstimator, RenderSpec, SceneFile, StopSpec, split_override};
use harmolux::math::Randomness;
use harmolux::scene::{Perspective, Scene};
use harmolux::study::{
    FittedObject, Loaded, Preparation, camera, load, load_seen, mesh_bytes, series_bytes,
};
use serde_json::json;

use super::arguments::{SceneArguments, size};
use super::exit::Code;
use super::fit::about;
use super::progress::{self, Meter};
use super::render_keep::Kept;
use super::render_target::open_outputs;
use super::{detail_report, interrupt, say};

/// Render the luminance, cd/m2, that a camera sees
///
/// Writes a PNG to look at and an EXR with the measured values: R, G, B, luminance Y and its standard error stderr.Y.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux render room.toml                          room.png and room.exr, here
  harmolux render room.toml -o out/a.png --quick     only a small PNG, fast
  harmolux render room.toml -D render.stop.time=30s  stop after half a minute
  harmolux render room.toml -D render.estimator=path the reference estimator
  harmolux render room.toml --resume                 go on after Ctrl-C")]
#[allow(clippy::option_option, reason = "--resume is absent, alone, or has a file")]
pub(crate) struct Render {
    #[command(flatten)]
    pub(crate) common: SceneArguments,
    /// Replace output files that another program wrote
    #[arg(long)]
    pub(crate) force: bool,
    /// Where to write: FILE.png or FILE.exr; may be repeated [default: the scene's name, both kinds, in this folder]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
    /// The number of pixels, such as 320x240
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Where the state of the run is saved, and stays [default: NAME.checkpoint beside the picture, removed when the run is complete]
    #[arg(long, value_name = "FILE")]
    pub(crate) checkpoint: Option<PathBuf>,
    /// Go on with an interrupted run, or add walks to a complete one [default: NAME.checkpoint beside the picture]
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    pub(crate) resume: Option<Option<PathBuf>>,
}

/// What the target of a picture is about.
const ERROR: &str = "relative error of 95 % of the pixels";

/// Runs the verb.
pub(crate) fn run(verb: &Render, as_json: bool) -> Result<Code> {
    let file = read_scene(&verb.common)?;
    let camera = sized(camera(&file)?, verb);
    let outputs = open_outputs(verb)?;
    let mut kept = Kept::open(verb, &outputs)?;
    let loaded = tell(load_seen(&file, Some(&camera))?);
    detail_report::tell(&loaded.details);
    let settings = settings(&file.render, &loaded.scene, &verb.common);
    let film = kept.film(&file, &camera, &settings)?;
    interrupt::listen();
    let meter = Meter::start("rendering", ERROR);
    let mut save = |so_far: &Rendering| kept.save(so_far, &outputs, &file, &settings);
    let keeper = Keeper { every: Kept::every(&file), save: &mut save };
    let rendering =
        render_on(&loaded.scene, &camera, &settings, film, &|p| meter.show(p), Some(keeper))
            .map_err(|e| about(&verb.common.scene, e))?;
    meter.finish();
    kept.finish(&rendering);
    let mut written = Vec::new();
    for (image, output) in outputs {
        let path = output.path().to_owned();
        output.write(&image.encode(&rendering, &file, &settings)?)?;
        written.push(path);
    }
    warn(&rendering);
    if as_json {
        say::data(
            &report_json(&loaded, &rendering, settings.stop.relative_error, &written).to_string(),
        );
    } else {
        report(&loaded.fits, &rendering, &written);
    }
    let reached = rendering.film.relative_error_of(SHARE_WITHIN);
    Ok(code(rendering.ending, settings.stop, reached, ERROR))
}

/// Reads a scene with the overrides of the command line.
pub(crate) fn read_scene(common: &SceneArguments) -> Result<SceneFile> {
    let overrides: Vec<(&str, &str)> =
        common.define.iter().map(|text| split_override(text)).collect::<Result<_>>()?;
    SceneFile::read(&common.scene, &overrides)
}

/// Builds the scene and says what was noticed.
pub(crate) fn load_scene(file: &SceneFile) -> Result<Loaded> {
    Ok(tell(load(file)?))
}

/// Says what was noticed.
fn tell(loaded: Loaded) -> Loaded {
    for warning in &loaded.warnings {
        say::warning(warning);
    }
    for FittedObject { name, fit } in distinct(&loaded.fits) {
        say::note(&format!(
            "fitted `{name}`: degree {}, RMS error {} of the mean radius, {:.0} ms",
            fit.coefficients.lmax(),
            say::percent(fit.relative_rms()),
            1e3 * fit.projection_time.as_secs_f64()
        ));
    }
    let Preparation { surfaces, patch_bytes, time } = loaded.preparation;
    if surfaces > 0 {
        let shapes = if surfaces == 1 { "1 shape" } else { &format!("{surfaces} shapes") };
        say::note(&format!(
            "prepared {shapes} for rays: {} of patches, {:.0} ms",
            say::bytes(patch_bytes),
            1e3 * time.as_secs_f64()
        ));
    }
    loaded
}

/// Takes the stop of the scene file; a quick look takes a tenth of the walks, which is sqrt(10) times the error.
pub(crate) fn stop(spec: StopSpec, quick: bool) -> Stop {
    let StopSpec { relative_error, time, walks } = spec;
    if !quick {
        return Stop { relative_error, time, walks };
    }
    Stop {
        relative_error: relative_error.map(|e| e * 10.0_f64.sqrt()),
        time,
        walks: walks.map(|w| w.div_ceil(10)),
    }
}

/// Says how a run ended: a target error that was not met is told by the exit code.
pub(crate) fn code(ending: Ending, stop: Stop, error: Option<f64>, name: &str) -> Code {
    let met = match (stop.relative_error, error) {
        (Some(target), Some(error)) => error <= target,
        (Some(_), None) => false,
        (None, _) => true,
    };
    if let (false, Some(target)) = (met, stop.relative_error) {
        let reached = error.map_or("unknown".to_owned(), say::percent);
        say::warning(&format!(
            "target not met: the {name} is {reached}, asked for {}; allow more time or walks, or relax `relative_error`",
            say::percent(target)
        ));
    }
    match ending {
        Ending::Interrupted => Code::Interrupted,
        _ if met => Code::Done,
        _ => Code::NotMet,
    }
}

fn settings(spec: &RenderSpec, scene: &Scene, common: &SceneArguments) -> ImageSettings {
    ImageSettings {
        estimator: match spec.estimator {
            RenderEstimator::DoubleLocal => Estimator::DoubleLocal(Weighting::of(scene)),
            RenderEstimator::DoubleLocalA => Estimator::DoubleLocal(Weighting::Walk),
            RenderEstimator::DoubleLocalB => Estimator::DoubleLocal(Weighting::Gather),
            RenderEstimator::Path => Estimator::Path,
        },
        randomness: Randomness::Sobol,
        seed: common.seed.unwrap_or(spec.seed),
        stop: stop(spec.stop, common.quick),
    }
}

fn sized(camera: Perspective, verb: &Render) -> Perspective {
    match verb.size {
        Some(size) => camera.with_resolution(size),
        None if verb.common.quick => {
            camera.with_resolution(camera.resolution().map(|n| n.div_ceil(2)))
        }
        None => camera,
    }
}

/// Says what may have spoilt the picture.
fn warn(rendering: &Rendering) {
    if rendering.film.spoilt() > 0 {
        say::warning(&format!(
            "{} samples were not finite; they are counted here and nowhere else",
            rendering.film.spoilt()
        ));
    }
    if rendering.escaped > 0.0 {
        say::warning(&format!("{} of the light left the scene", say::percent(rendering.escaped)));
    }
    if rendering.ending == Ending::Interrupted {
        say::warning("interrupted: the files hold the picture so far");
    }
}

/// Gives each fit once, under the name of the first object that has it.
fn distinct(fits: &[FittedObject]) -> impl Iterator<Item = &FittedObject> {
    let mut seen = HashSet::new();
    fits.iter().filter(move |fitted| seen.insert(Arc::as_ptr(&fitted.fit)))
}

fn report(fits: &[FittedObject], rendering: &Rendering, written: &[PathBuf]) {
    let mut lines = Vec::new();
    for FittedObject { name, fit } in distinct(fits) {
        let lmax = fit.coefficients.lmax();
        let (own, mesh) = (series_bytes(lmax), mesh_bytes(fit.mesh_size));
        lines.push((
            "object",
            format!("{name}: degree {lmax}, {} coefficients", fit.coefficients.count()),
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
    let film = &rendering.film;
    let [width, height] = film.size();
    let error = film.median_relative_error().map_or("unknown".to_owned(), say::percent);
    lines.push((
        "image",
        format!("{width} x {height}, mean {} cd/m2", say::significant(film.mean().0, 4)),
    ));
    let walks = rendering.walks_per_pixel;
    let mean = rendering.mean_walks_per_pixel();
    let rested = if mean < 0.995 * walks as f64 {
        format!(" at most, {mean:.0} in the mean,")
    } else {
        String::new()
    };
    let replicates = film.replicates();
    lines.push(("walks", format!("{walks} per pixel{rested} in {replicates} replicates")));
    lines.push(("time", progress::duration(rendering.elapsed)));
    let most = film.relative_error_of(SHARE_WITHIN).map_or("unknown".to_owned(), say::percent);
    lines.push((
        "relative error",
        format!("{error} (median standard error of a pixel), at most {most} in 95 % of the pixels"),
    ));
    for path in written {
        lines.push(("written", path.display().to_string()));
    }
    say::pairs(&lines);
}

fn report_json(
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
    json!({
        "objects": objects,
        "details": detail_report::json(&loaded.details),
        "patch_bytes": loaded.preparation.patch_bytes,
        "preparation_seconds": loaded.preparation.time.as_secs_f64(),
        "resolution": film.size(),
        "mean_luminance": mean,
        "mean_luminance_stderr": standard_error,
        "walks_per_pixel": rendering.walks_per_pixel,
        "mean_walks_per_pixel": rendering.mean_walks_per_pixel(),
        "replicates": film.replicates(),
        "seconds": rendering.elapsed.as_secs_f64(),
        "median_relative_error": film.median_relative_error(),
        "relative_error_of_95_percent": film.relative_error_of(SHARE_WITHIN),
        "share_within_target": target.map(|target| film.share_within(target)),
        "escaped": rendering.escaped,
        "spoilt_samples": film.spoilt(),
        "ending": format!("{:?}", rendering.ending).to_lowercase(),
        "written": written,
    })
}
