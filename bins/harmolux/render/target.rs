//! Where a picture goes: files opened before the run, and how a rendering becomes their bytes.

use std::path::{Path, PathBuf};

use harmolux::Result;
use harmolux::estimators::{Estimator, ImageSettings, Rendering, Weighting};
use harmolux::io::images::{Attribute, Computed, Exr, Png, colour_channels, colour_samples, png};
use harmolux::io::output::{Kind, Output, Stage};
use harmolux::io::scene_file::{RenderSpec, SceneFile};
use harmolux::scene::{Camera, Exposure, Film, FirstHits, Layer, Scene};
use serde_json::{Map, Value};

use crate::common::plot::unknown_output;
use crate::common::say;
use crate::render::Render;

/// A form in which a picture is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Image {
    Png,
    Exr,
}

/// Writes a rendering, as far as it is, in a form.
pub(crate) type Write<'a> = &'a dyn Fn(Image, &mut Output, Stage, &Rendering) -> Result<()>;

/// What a picture is of, and how it is made.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) camera: &'a Camera,
    pub(crate) file: &'a SceneFile,
    pub(crate) settings: &'a ImageSettings,
}

impl Image {
    /// Writes a rendering in this form; `run` tells of which run it is.
    pub(crate) fn write(
        self,
        output: &mut Output,
        stage: Stage,
        rendering: &Rendering,
        of: View,
        run: &str,
    ) -> Result<()> {
        match self {
            Self::Png => {
                let made = encode_png(rendering, &of.file.render, run)?;
                if stage != Stage::Preview {
                    tell_exposure(rendering, &made, of.file.render.exposure);
                }
                output.write_at(stage, &made.bytes)
            }
            Self::Exr => {
                let [width, height] = rendering.film.size();
                let layers = of.file.render.layers.as_deref().unwrap_or(&Layer::ALL);
                let View { scene, camera, settings, .. } = of;
                let hits = FirstHits { scene, camera, filter: settings.filter };
                let mut exr = Exr::new(width, height);
                // Their rays take long, and whoever asked a run to end waits.
                if stage == Stage::Complete {
                    exr = with_shapes(exr, layers, &hits)?;
                }
                let exr = described(exr, rendering, of)?.with_attribute("run", run);
                let light = light(&rendering.film, layers);
                output.write_with(stage, &mut |to| exr.write(&light, to))
            }
        }
    }
}

/// Opens the outputs before anything takes long: those named, or both kinds under the scene's name
/// in this folder. A run that goes on may find its own there.
pub(crate) fn open_outputs(verb: &Render) -> Result<Vec<(Image, Output)>> {
    let stem = verb.common.scene.file_stem().unwrap_or_default();
    let both = || ["png", "exr"].map(|e| Path::new(stem).with_extension(e)).to_vec();
    let paths: Vec<PathBuf> = if verb.output.is_empty() { both() } else { verb.output.clone() };
    let open = |path: PathBuf| {
        let is = |wanted| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(wanted));
        let (image, kind) = match (is("png"), is("exr")) {
            (true, _) => (Image::Png, Kind::PNG),
            (_, true) => (Image::Exr, Kind::EXR),
            _ => return Err(unknown_output(&path, ".png or .exr")),
        };
        let open = if verb.resume.is_some() { Output::open_again } else { Output::open };
        Ok((image, open(&path, &kind, verb.force)?))
    };
    paths.into_iter().map(open).collect()
}

fn encode_png(rendering: &Rendering, spec: &RenderSpec, run: &str) -> Result<Png> {
    let [width, height] = rendering.film.size();
    png(width, height, &rendering.film.image(), spec.display(), Some(run))
}

/// The largest share of white pixels of a picture that was exposed by a factor of its own.
const MOST_WHITE: f64 = 0.5;

fn tell_exposure(rendering: &Rendering, made: &Png, asked: Exposure) {
    let is_dark = !rendering.film.image().iter().any(|pixel| pixel.luminance() > 0.0);
    say::note(&if is_dark && !matches!(asked, Exposure::Factor(_)) {
        "no exposure: the PNG is black, since no pixel has light".to_owned()
    } else {
        format!("exposure {} (PNG value per cd/m2)", say::significant(made.exposure, 4))
    });
    let image = rendering.film.image();
    let white = image.iter().filter(|p| p.luminance() * made.exposure >= 1.0).count();
    let share = white as f64 / image.len().max(1) as f64;
    if matches!(asked, Exposure::Factor(_)) && share > MOST_WHITE {
        say::warning(&format!(
            "{} of the pixels are white at this exposure; `--exposure 98%` keeps so many below \
             white",
            say::percent(share)
        ));
    }
}

/// Returns the channels of the light, which are computed from the film as they are written: a film
/// is large, and they would be half as much again.
fn light<'a>(film: &'a Film, layers: &[Layer]) -> Computed<'a> {
    let [direct, indirect] = [Layer::Direct, Layer::Indirect].map(|layer| layers.contains(&layer));
    let colours = [("", true), ("direct", direct), ("indirect", indirect)];
    let colours = colours.into_iter().filter(|(_, is_asked)| *is_asked);
    let mut names = vec!["stderr.Y".to_owned()];
    names.extend(colours.flat_map(|(layer, _)| colour_channels(layer)));
    Computed::new(names, move |i, values| {
        let light = film.light(i);
        let parts = [(light.total(), true), (light.direct, direct), (light.indirect, indirect)];
        let parts = parts.into_iter().filter(|(_, is_asked)| *is_asked);
        values[0] = film.standard_error(i) as f32;
        for (values, (colour, _)) in values[1..].chunks_exact_mut(4).zip(parts) {
            values.copy_from_slice(&colour_samples(colour));
        }
    })
}

/// Adds the layers of the shapes from first hits.
fn with_shapes(exr: Exr, layers: &[Layer], hits: &FirstHits) -> Result<Exr> {
    let mut exr = exr;
    let three = |exr: Exr, names: [&str; 3], values: [Vec<f32>; 3]| {
        names.into_iter().zip(values).try_fold(exr, |exr, (n, v)| exr.with_samples(n, v))
    };
    for layer in Layer::ALL.into_iter().filter(|layer| layers.contains(layer)) {
        exr = match layer {
            Layer::Direct | Layer::Indirect => exr,
            Layer::Normal => three(exr, ["normal.X", "normal.Y", "normal.Z"], hits.normal())?,
            Layer::Albedo => three(exr, ["albedo.R", "albedo.G", "albedo.B"], hits.albedo())?,
            Layer::Depth => exr.with_samples("depth.Z", hits.depth())?,
            Layer::Id => {
                let names = hits.scene.objects().iter().zip(1..);
                let names: Map<_, _> =
                    names.map(|(o, number)| (o.name.clone(), Value::from(number))).collect();
                exr.with_samples("id.Y", hits.id())?
                    .with_attribute("objects", Value::Object(names).to_string())
            }
        };
    }
    Ok(exr)
}

/// Says what the picture is of and how it was made: nothing that equal runs would not say alike.
fn described(exr: Exr, rendering: &Rendering, of: View) -> Result<Exr> {
    let View { camera, file, settings, .. } = of;
    let film = &rendering.film;
    let scene = file.source.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
    let rows = camera.world_to_camera().map(|row| row.map(|v| v as f32));
    let mut exr = exr
        .within(camera.resolution(), camera.window().min())
        .with_attribute("scene", scene.as_str())
        .with_attribute("camera", file.camera()?.0)
        .with_attribute("cameraType", camera.kind())
        .with_attribute("worldToCamera", Attribute::Matrix(rows))
        .with_attribute("filter", settings.filter.name())
        .with_attribute("estimator", estimator_name(settings))
        .with_attribute("unit", "cd/m2")
        .with_attribute("seed", settings.seed.to_string().as_str())
        .with_attribute("replicates", film.replicates() as f64)
        .with_attribute("walksPerPixel", rendering.walks_per_pixel as f64);
    if let Exposure::Factor(exposure) = file.render.exposure {
        exr = exr.with_attribute("displayExposure", exposure);
    }
    Ok(exr)
}

/// Returns the name of an estimator, as scene files have it.
pub(crate) const fn estimator_name(settings: &ImageSettings) -> &'static str {
    match settings.estimator {
        Estimator::Local(Weighting::Walk) => "double-local-a",
        Estimator::Local(Weighting::Gather) => "double-local-b",
        Estimator::Local(Weighting::Bounded { .. }) => "double-local",
        // No other estimates pictures.
        Estimator::Path | Estimator::Radiosity(_) | Estimator::Photon { .. } => "path",
    }
}
