//! What `render` keeps of a run under way: the checkpoint and the picture so far.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use harmolux::estimators::{Ending, ImageSettings, REPLICATES, Rendering};
use harmolux::io::checkpoint::{self, Fingerprint};
use harmolux::io::output::{Claim, Kind, Output, Stage};
use harmolux::io::scene_file::SceneFile;
use harmolux::scene::{Camera, Film};
use harmolux::study::Loaded;
use harmolux::{Error, Result};

use crate::common::advice;
use crate::common::say;
use crate::common::target::write_all;
use crate::render::Render;
use crate::render::target::{Image, Write, estimator_name};

/// The time between checkpoints unless the scene says another.
const EVERY: Duration = Duration::from_secs(60);

/// Where the state of a run is to go, before the run.
pub(crate) struct Place {
    claim: Claim,
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
        let path = given.unwrap_or(&default).clone();
        let claim = Claim::open(&path, &Kind::CHECKPOINT, verb.force)?;
        if resume.as_ref() != Some(&path) && !verb.force && !holds_nothing(&path) {
            return Err(Error::Parameter(format!(
                "{} is of a run that was interrupted or can be added to: go on with it by \
                 `--resume={}`, or replace it with `--force`",
                path.display(),
                path.display()
            )));
        }
        Ok(Self { claim, named: given.is_some(), resume })
    }

    /// Returns the film to go on with, that of the checkpoint to resume or an empty one, and what
    /// keeps it. The pictures that stand there must be those of this run.
    pub(crate) fn take(
        self,
        file: &SceneFile,
        camera: &Camera,
        settings: &ImageSettings,
        loaded: &Loaded,
        outputs: &mut [(Image, Output)],
    ) -> Result<(Film, Kept)> {
        let Self { claim, named, resume } = self;
        let fingerprint = fingerprint(file, camera, settings)?.with_files(&loaded.files);
        let from = resume.as_ref().filter(|path| !holds_nothing(path));
        let film = match from {
            None => Film::new(camera.window().size(), REPLICATES)?,
            Some(path) if path == claim.path() => {
                checkpoint::read_from(path, claim.file()?, &fingerprint)?
            }
            Some(path) => checkpoint::read(path, &fingerprint)?,
        };
        if let Some(path) = &resume {
            let run = fingerprint.run();
            outputs.iter_mut().try_for_each(|(_, output)| output.check_run(&run))?;
            let path = path.display();
            say::note(&match from {
                Some(_) => format!("going on after {} passes of {path}", film.passes()),
                None => format!("nothing to go on with in {path}: beginning anew"),
            });
        }
        Ok((film, Kept { claim, fingerprint, named, told: [false; 2] }))
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

/// Whether a run saved nothing, was complete, or never was.
fn holds_nothing(path: &Path) -> bool {
    match std::fs::metadata(path) {
        Ok(data) => data.len() == 0,
        Err(e) => e.kind() == ErrorKind::NotFound,
    }
}

/// Where the state of a run goes, and whose it is.
pub(crate) struct Kept {
    claim: Claim,
    fingerprint: Fingerprint,
    named: bool,
    /// Whether it was said where the picture so far is, and that it cannot be written.
    told: [bool; 2],
}

impl Kept {
    /// Returns the text that tells of which run a picture is.
    pub(crate) fn run(&self) -> String {
        self.fingerprint.run()
    }

    /// Returns the time between checkpoints.
    pub(crate) fn every(file: &SceneFile) -> Duration {
        file.render.checkpoint.unwrap_or(EVERY)
    }

    /// Saves state and picture of a run under way; what fails is said and does not end the run.
    pub(crate) fn save(
        &mut self,
        rendering: &Rendering,
        outputs: &mut [(Image, Output)],
        write: Write,
    ) {
        if !self.write(&rendering.film) {
            return;
        }
        let told = self.told;
        for (image, output) in outputs {
            let written = write(*image, output, Stage::Preview, rendering);
            let which = usize::from(written.is_err());
            self.told[which] = true;
            match written {
                _ if told[which] => {}
                Ok(()) => {
                    let path = output.path_at(Stage::Preview).display();
                    say::note(&format!("the picture so far is {path}"));
                }
                Err(error) => {
                    let error = advice::told(&error);
                    say::warning(&format!("the picture so far was not written: {error}"));
                }
            }
        }
    }

    /// Saves the state of a run that is over, if it is to go on or the file was named.
    fn keep(&mut self, rendering: &Rendering, to_go_on: bool) {
        if rendering.unfinished.is_some() {
            // No complete pass, nothing to go on from.
            return;
        }
        let written = (to_go_on || self.named) && self.write(&rendering.film);
        if written && to_go_on {
            let path = self.claim.path().display();
            say::note(&format!("go on with the same command and `--resume={path}`"));
        }
    }

    /// Ends the run, and removes the state that is neither to go on nor asked for.
    pub(crate) fn end(self, rendering: &Rendering, to_go_on: bool) {
        // Without a complete pass nothing was saved, and what stands there is an earlier run's.
        if self.named || to_go_on || rendering.unfinished.is_some() {
            return;
        }
        if let Err(error) = self.claim.remove() {
            say::warning(&advice::told(&error));
        }
    }

    /// Writes the state; says what fails, and tells whether it is saved, be it elsewhere.
    fn write(&mut self, film: &Film) -> bool {
        let before = self.claim.path().to_owned();
        let written = checkpoint::write(&mut self.claim, &self.fingerprint, film);
        if let Err(error) = &written {
            say::warning(&advice::told(error));
        }
        written.is_ok() || self.claim.path() != before
    }
}

/// Writes the pictures, and keeps the state of a run that is to go on: one that was interrupted, or
/// of which a picture found no place. Returns where they are.
pub(crate) fn finish(
    mut kept: Kept,
    outputs: &mut [(Image, Output)],
    rendering: &Rendering,
    write: Write,
) -> Result<Vec<PathBuf>> {
    let interrupted = rendering.ending == Ending::Interrupted;
    let stage = stage(rendering);
    kept.keep(rendering, interrupted);
    let writes = outputs.iter_mut().map(|(image, to)| write(*image, to, stage, rendering));
    let written = write_all(writes);
    if written.is_err() && !interrupted {
        kept.keep(rendering, true);
    }
    kept.end(rendering, interrupted || written.is_err());
    written.map(|()| outputs.iter().map(|(_, to)| to.path_at(stage).to_owned()).collect())
}

/// Says how far a picture is.
fn stage(rendering: &Rendering) -> Stage {
    let is_whole = rendering.ending != Ending::Interrupted && rendering.unfinished.is_none();
    if is_whole { Stage::Complete } else { Stage::Unfinished }
}
