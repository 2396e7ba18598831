//! Scenes as several verbs read them.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use harmolux::Result;
use harmolux::error::shown;
use harmolux::io::scene_file::{SceneFile, StopSpec, split_override};
use harmolux::scene::Camera;
use harmolux::study::{FittedObject, Loaded, LoadingStage, Preparation, load_for_camera};

use crate::common::progress::Meter;
use crate::common::say;

/// Reads a scene with the overrides of the command line.
pub(crate) fn read_scene(path: &Path, define: &[String]) -> Result<SceneFile> {
    let overrides: Vec<(&str, &str)> =
        define.iter().map(|text| split_override(text)).collect::<Result<_>>()?;
    SceneFile::read(path, &overrides)
}

/// Builds the scene, for a picture if a camera is given, shows what it is at and says what was
/// noticed.
pub(crate) fn load_scene(
    file: &SceneFile,
    camera: Option<&Camera>,
    meter: &Meter,
) -> Result<Loaded> {
    let observer = |stage: LoadingStage| meter.stage(&stage.to_string());
    load_for_camera(file, camera, &observer).map(tell)
}

/// Says what was noticed.
fn tell(loaded: Loaded) -> Loaded {
    for warning in &loaded.warnings {
        say::warning(warning);
    }
    for FittedObject { name, fit } in distinct(&loaded.fits) {
        say::note(&format!(
            "fitted `{}`: degree {}, RMS error {} of the mean radius, {:.0} ms",
            shown(name),
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

/// Takes the stop of the scene file; a quick look takes a tenth of the walks, which is sqrt(10)
/// times the error.
pub(crate) fn stop(spec: StopSpec, quick: bool) -> StopSpec {
    if !quick {
        return spec;
    }
    StopSpec {
        relative_error: spec.relative_error.map(|e| e * 10.0_f64.sqrt()),
        time: spec.time,
        walks: spec.walks.map(|w| w.div_ceil(10)),
    }
}

/// Returns each fit once, under the name of the first object that has it.
pub(crate) fn distinct(fits: &[FittedObject]) -> impl Iterator<Item = &FittedObject> {
    let mut seen = HashSet::new();
    fits.iter().filter(move |fitted| seen.insert(Arc::as_ptr(&fitted.fit)))
}
