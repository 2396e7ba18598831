//! What `render` keeps of a run under way: the checkpoint and the picture so far.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use harmolux::estimators::{Ending, ImageSettings, REPLICATES, Rendering};
use harmolux::io::checkpoint::{self, Fingerprint};
use harmolux::io::output::{Kind, Output};
use harmolux::io::scene_file::SceneFile;
use harmolux::scene::{Camera, Film};
use harmolux::{Error, Result};

use super::render::Render;
use super::render_target::{Image, estimator_name};
use super::say;

/// The time between checkpoints unless the scene says another.
const EVERY: Duration = Duration::from_secs(60);

/// Where the state of a run goes, and whose it is.
pub(crate) struct Kept {
    output: Output,
    fingerprint: Fingerprint,
    /// Whether the user named the file: then it stays when the run is complete.
    named: bool,
    resume: Option<PathBuf>,
}

impl Kept {
    /// Opens the checkpoint before anything takes long; its name is that of the picture unless one was given.
    pub(crate) fn open(verb: &Render, outputs: &[(Image, Output)]) -> Result<Self> {
        let picture = outputs.first().map_or(verb.common.scene.as_path(), |(_, o)| o.path());
        let default = picture.with_extension("checkpoint");
        let resume = verb.resume.as_ref().map(|f| f.clone().unwrap_or_else(|| default.clone()));
        let given = verb.checkpoint.as_ref().or(verb.resume.as_ref().and_then(Option::as_ref));
        let path: &Path = given.unwrap_or(&default);
        let output = Output::open(path, &Kind::CHECKPOINT, verb.force)?;
        if resume.is_none() && !verb.force && path.exists() {
            return Err(Error::Parameter(format!(
                "{} is of a run that was interrupted or can be added to: go on with it by `--resume={}`, or begin anew with `--force`",
                path.display(),
                path.display()
            )));
        }
        Ok(Self { output, fingerprint: Fingerprint::new(), named: given.is_some(), resume })
    }

    /// Gives the film to go on with: that of the checkpoint to resume, else an empty one.
    pub(crate) fn film(
        &mut self,
        file: &SceneFile,
        camera: &Camera,
        settings: &ImageSettings,
    ) -> Result<Film> {
        let [width, height] = camera.resolution();
        let window = camera.window();
        self.fingerprint = Fingerprint::new()
            .with("size", format!("{width} x {height}"))
            .with("the crop", format!("{:?} of {:?}", window.size(), window.min()))
            .with("seed", settings.seed.to_string())
            .with("the estimator", estimator_name(settings).to_owned())
            .with("the filter", settings.filter.name().to_owned())
            .with("the camera", format!("{camera:?}"))
            .with("render.detail", format!("{:?}", file.render.detail))
            .with_scene(file)?;
        let Some(path) = &self.resume else { return Film::new(window.size(), REPLICATES) };
        let film = checkpoint::read(path, &self.fingerprint)?;
        say::note(&format!("going on after {} passes of {}", film.passes(), path.display()));
        Ok(film)
    }

    /// Gives the time between checkpoints.
    pub(crate) fn every(file: &SceneFile) -> Duration {
        file.render.checkpoint.unwrap_or(EVERY)
    }

    /// Saves state and picture of a run under way; what fails is said and does not end the run.
    pub(crate) fn save(
        &self,
        rendering: &Rendering,
        outputs: &[(Image, Output)],
        encode: &dyn Fn(Image, &Rendering) -> Result<Vec<u8>>,
    ) {
        if self.write(&rendering.film) {
            for (image, output) in outputs {
                let written = encode(*image, rendering)
                    .and_then(|bytes| output.write_with(&mut |to| to.write_all(&bytes)));
                if let Err(error) = written {
                    say::warning(&format!("the picture so far was not written: {error}"));
                }
            }
        }
    }

    /// Saves the state of a run that is over, if it was interrupted or the file was named.
    pub(crate) fn keep(&self, rendering: &Rendering) {
        let interrupted = rendering.ending == Ending::Interrupted;
        let written = (interrupted || self.named) && self.write(&rendering.film);
        if written && interrupted {
            let path = self.output.path().display();
            say::note(&format!("go on with the same command and `--resume={path}`"));
        }
    }

    /// Removes, once the picture is written, the state that nobody asked to keep.
    pub(crate) fn clear(&self, rendering: &Rendering) {
        if self.named || rendering.ending == Ending::Interrupted {
            return;
        }
        let path = self.output.path();
        if let Err(error) = std::fs::remove_file(path)
            && error.kind() != ErrorKind::NotFound
        {
            say::warning(&format!("{} could not be removed: {error}", path.display()));
        }
    }

    fn write(&self, film: &Film) -> bool {
        let written = checkpoint::write(&self.output, &self.fingerprint, film);
        if let Err(error) = &written {
            say::warning(&format!("no checkpoint was written, the run goes on: {error}"));
        }
        written.is_ok()
    }
}
