//! Where a picture goes: files opened before the run, and how a rendering becomes their bytes.

use std::path::{Path, PathBuf};

use harmolux::Result;
use harmolux::estimators::{Estimator, ImageSettings, Rendering, Weighting};
use harmolux::io::images::{Exr, png};
use harmolux::io::output::{Kind, Output};
use harmolux::io::scene_file::{RenderSpec, SceneFile};

use super::render::Render;
use super::say;

/// A form in which a picture is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Image {
    Png,
    Exr,
}

impl Image {
    /// Encodes a rendering in this form.
    pub(crate) fn encode(
        self,
        rendering: &Rendering,
        file: &SceneFile,
        settings: &ImageSettings,
    ) -> Result<Vec<u8>> {
        match self {
            Self::Png => encode_png(rendering, &file.render),
            Self::Exr => encode_exr(rendering, file, settings),
        }
    }
}

/// Opens the outputs before anything takes long: those named, or both kinds under the scene's name in this folder.
pub(crate) fn open_outputs(verb: &Render) -> Result<Vec<(Image, Output)>> {
    let stem = verb.common.scene.file_stem().unwrap_or_default();
    let both = || ["png", "exr"].map(|e| Path::new(stem).with_extension(e)).to_vec();
    let paths: Vec<PathBuf> = if verb.output.is_empty() { both() } else { verb.output.clone() };
    let open = |path: PathBuf| {
        let exr = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        let (image, kind) = if exr { (Image::Exr, Kind::EXR) } else { (Image::Png, Kind::PNG) };
        Ok((image, Output::open(&path, &kind, verb.force)?))
    };
    paths.into_iter().map(open).collect()
}

fn encode_png(rendering: &Rendering, spec: &RenderSpec) -> Result<Vec<u8>> {
    let [width, height] = rendering.film.size();
    let image = png(width, height, &rendering.film.image(), spec.exposure)?;
    say::note(&format!("exposure {} (PNG value per cd/m2)", say::significant(image.exposure, 4)));
    Ok(image.bytes)
}

fn encode_exr(
    rendering: &Rendering,
    file: &SceneFile,
    settings: &ImageSettings,
) -> Result<Vec<u8>> {
    let film = &rendering.film;
    let [width, height] = film.size();
    let estimator = match settings.estimator {
        Estimator::DoubleLocal(Weighting::Walk) => "double-local-a",
        Estimator::DoubleLocal(Weighting::Gather) => "double-local-b",
        Estimator::DoubleLocal(Weighting::Bounded { .. }) => "double-local",
        Estimator::Path => "path",
    };
    let scene = file.source.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
    Exr::new(width, height)
        .with_colour("", &film.image())?
        .with_channel("stderr.Y", (0..width * height).map(|i| film.standard_error(i)))?
        .with_attribute("scene", scene.as_str())
        .with_attribute("estimator", estimator)
        .with_attribute("unit", "cd/m2")
        .with_attribute("seed", settings.seed.to_string().as_str())
        .with_attribute("replicates", film.replicates() as f64)
        .with_attribute("walksPerPixel", rendering.walks_per_pixel as f64)
        .into_bytes()
}
