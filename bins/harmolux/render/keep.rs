//! What `render` keeps of a run under way: the checkpoint and the picture so far.

use std::path::{Path, PathBuf};
use std::time::Duration;

use harmolux::estimators::{Ending, ImageSettings, REPLICATES, Rendering};
use harmolux::io::checkpoint::{self, Fingerprint};
use harmolux::io::output::{Claim, Kind, Output};
use harmolux::io::scene_file::SceneFile;
use harmolux::scene::{Camera, Film};
use harmolux::study::Loaded;
use harmolux::{Error, Result};

use crate::common::advice;
use crate::common::say;
use crate::render::Render;
use crate::render::target::{Image, estimator_name};

/// The time between checkpoints unless the scene says another.
const EVERY: Duration = Duration::from_secs(60);

/// Where the state of a run is to go, before the run.
pub(crate) struct Place {
    output: Output,
    /// Whether the user named the file: then it stays when the run is complete.
    named: bool,
    resume: Option<PathBuf>,
}

impl Place {
    /// Opens the checkpoint before anything takes long; its name is that of the picture unless one
    /// was given.
    pub(crate) fn open(verb: &Render, outputs: &[(Image, Output)]) -> Result<Self> {
        let picture = outputs.first().map_or(verb.common.scene.as_path(), |(_, o)| o.path());
        let default = picture.with_extension("checkpoint");
        let resume = verb.resume.as_ref().map(|f| f.clone().unwrap_or_else(|| default.clone()));
        let given = verb.checkpoint.as_ref().or(verb.resume.as_ref().and_then(Option::as_ref));
        let path: &Path = given.unwrap_or(&default);
        let output = Output::open(path, &Kind::CHECKPOINT, verb.force)?;
        output.check_unclaimed()?;
        if resume.is_none() && !verb.force && path.exists() && !is_empty(path) {
            return Err(Error::Parameter(format!(
                "{} is of a run that was interrupted or can be added to: go on with it by \
                 `--resume={}`, or begin anew with `--force`",
                path.display(),
                path.display()
            )));
        }
        Ok(Self { output, named: given.is_some(), resume })
    }

    /// Takes the place, and gives the film to go on with: that of the checkpoint to resume, else an
    /// empty one.
    pub(crate) fn take(
        self,
        file: &SceneFile,
        camera: &Camera,
        settings: &ImageSettings,
        loaded: &Loaded,
    ) -> Result<(Film, Kept)> {
        let window = camera.window();
        let fingerprint = fingerprint(file, camera, settings)?.with_files(&loaded.files);
        let film = match self.resume.filter(|path| !said_empty(path)) {
            None => Film::new(window.size(), REPLICATES)?,
            Some(path) => {
                let film = checkpoint::read(&path, &fingerprint)?;
                say::note(&format!(
                    "going on after {} passes of {}",
                    film.passes(),
                    path.display()
                ));
                film
            }
        };
        Ok((film, Kept { claim: self.output.claim()?, fingerprint, named: self.named }))
    }
}

/// Says what must be the same for a run to go on.
fn fingerprint(file: &SceneFile, camera: &Camera, settings: &ImageSettings) -> Result<Fingerprint> {
    let [width, height] = camera.resolution();
    let window = camera.window();
    let ([x0, y0], [x1, y1]) = (window.min(), window.max());
    Ok(Fingerprint::new()
        .with_scene(file)?
        .with("size", format!("{width} x {height}"))
        .with("the crop", format!("{x0},{y0},{x1},{y1}"))
        .with("seed", settings.seed.to_string())
        .with("the estimator", estimator_name(settings).to_owned())
        .with("the filter", settings.filter.name().to_owned()))
}

/// Whether a run was killed before it saved anything.
fn is_empty(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|data| data.len() == 0)
}

fn said_empty(path: &Path) -> bool {
    if is_empty(path) {
        say::note(&format!("{} holds nothing yet: beginning anew", path.display()));
        return true;
    }
    false
}

/// Where the state of a run goes, and whose it is.
pub(crate) struct Kept {
    claim: Claim,
    fingerprint: Fingerprint,
    named: bool,
}

impl Kept {
    /// Returns the time between checkpoints.
    pub(crate) fn every(file: &SceneFile) -> Duration {
        file.render.checkpoint.unwrap_or(EVERY)
    }

    /// Saves state and picture of a run under way; what fails is said and does not end the run.
    pub(crate) fn save(
        &mut self,
        rendering: &Rendering,
        outputs: &[(Image, Output)],
        write: &dyn Fn(Image, &Output, &Rendering) -> Result<()>,
    ) {
        if self.write(&rendering.film) {
            for (image, output) in outputs {
                if let Err(error) = write(*image, output, rendering) {
                    let error = advice::told(&error);
                    say::warning(&format!("the picture so far was not written: {error}"));
                }
            }
        }
    }

    /// Saves the state of a run that is over, if it was interrupted or the file was named.
    pub(crate) fn keep(&mut self, rendering: &Rendering) {
        if rendering.unfinished.is_some() {
            // No complete pass, nothing to go on from.
            return;
        }
        let interrupted = rendering.ending == Ending::Interrupted;
        let written = (interrupted || self.named) && self.write(&rendering.film);
        if written && interrupted {
            let path = self.claim.path().display();
            say::note(&format!("go on with the same command and `--resume={path}`"));
        }
    }

    /// Ends the run once the picture is written, and removes the state that nobody asked to keep.
    pub(crate) fn end(self, rendering: &Rendering) {
        let to_go_on = self.named || rendering.ending == Ending::Interrupted;
        if to_go_on && rendering.unfinished.is_none() {
            return;
        }
        if let Err(error) = self.claim.remove() {
            say::warning(&advice::told(&error));
        }
    }

    fn write(&mut self, film: &Film) -> bool {
        let written = checkpoint::write(&mut self.claim, &self.fingerprint, film);
        if let Err(error) = &written {
            let error = advice::told(error);
            say::warning(&format!("no checkpoint was written, the run goes on: {error}"));
        }
        written.is_ok()
    }
}
