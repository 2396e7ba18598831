//! Drives an image: pass after pass of one sample per pixel, each pass a part of one replicate.

mod pass;
mod splat;

use std::time::Duration;

use crate::math::Randomness;
use crate::scene::{Camera, Film, Filter, Scene};
use crate::{Error, Result};

pub use self::pass::walks_per_sample;

use self::pass::Pass;
use super::connect::SplitLight;
use super::estimator::Estimator;
use super::known_lights::KnownLights;
use super::replicates::{Control, Ending, Known, Observer, REPLICATES, Stop, Watch};
use super::walk::Launcher;

/// Sets an image run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageSettings {
    /// How a pixel is estimated: by [`Estimator::Local`], the double local estimate (eq. 11, 12),
    /// whose walk hits are connected to the visible point, to a sampled intermediate point, or to
    /// both as the weighting says (also known as instant radiosity with walks of its own for every
    /// sample), or by [`Estimator::Path`].
    pub estimator: Estimator,
    /// Where random numbers come from.
    pub randomness: Randomness,
    /// The seed: the same seed gives the same bytes on any number of threads.
    pub seed: u64,
    /// When to stop.
    pub stop: Stop,
    /// How samples weigh in a pixel.
    pub filter: Filter,
}

/// Holds a finished image and how it came about.
#[derive(Debug, Clone)]
pub struct Rendering {
    /// Mean and standard error of every pixel.
    pub film: Film,
    /// Why the run ended.
    pub ending: Ending,
    /// Walks (or paths) per pixel: 32 (or 8) a sample.
    pub walks_per_pixel: u64,
    /// The same in the mean over pixels; fewer when pixels rested.
    pub mean_walks_per_pixel: f64,
    /// The share of the walks' flux that left an open scene.
    pub escaped: f64,
    /// The share of all light that point lights shed on mirrors and these send on: where it falls
    /// is dark when seen in a mirror itself, and by path tracing wherever it is seen.
    pub caustic: f64,
    /// The share of the rows that were done when the run ended in its very first pass; the others
    /// are black, and no error is known. `None` after a complete pass.
    pub unfinished: Option<f64>,
    /// The time it took.
    pub elapsed: Duration,
}

/// Saves a run now and then, so that it can be taken up again.
pub struct Checkpointer<'a> {
    /// The least time between the end of one saving and the next; longer where saving takes more
    /// than a tenth of the time.
    pub every: Duration,
    /// Saves what there is after a complete pass.
    pub save: &'a mut dyn FnMut(&Rendering),
}

/// Passes that are made however few walks are asked for: two replicates are the least that give an
/// error.
const FEWEST_PASSES: usize = 2;

/// Passes from which the observer is told an error before the first stage is complete.
const FEWEST_FORETOLD: usize = 4;

/// The share of the pixels that must meet the target error.
pub const SHARE_WITHIN: f64 = 0.95;

/// Renders the luminance, cd/m2, of every pixel of a camera.
///
/// Only the window of the camera is computed; without a target error its pixels are, to the bit,
/// those that the whole picture has there after as many walks. The pixel filter is sampled in
/// proportion to itself. Errors come from [`REPLICATES`] independent replicates and are checked
/// when the number of samples has doubled. With a target error, pixels that are known well enough
/// rest for part of the samples ([`Film::plan`]), and the run ends when [`SHARE_WITHIN`] of the
/// pixels meet it. Time limits and interruption abandon the pass under way, the very first one too:
/// then the rows that are done make the picture ([`Rendering::unfinished`]). Before two passes no
/// error is known.
///
/// # Errors
/// [`crate::Error::Parameter`] when the scene has no light or the image has too many pixels.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    settings: &ImageSettings,
    observer: Observer,
) -> Result<Rendering> {
    let film = Film::new(camera.window().size(), REPLICATES)?;
    resume(scene, camera, settings, film, observer, None)
}

/// Goes on with a film that [`render`] left, until `settings.stop` is met anew (walks count from
/// the very start, time from now).
///
/// All but the stop must be as it was; then the result is, to the bit, that of a run never
/// interrupted. `keeper` is asked to save in between.
///
/// # Errors
/// As [`render`]; also when the film is not of the camera's size or not of [`REPLICATES`]
/// replicates.
pub fn resume(
    scene: &Scene,
    camera: &Camera,
    settings: &ImageSettings,
    film: Film,
    observer: Observer,
    keeper: Option<Checkpointer>,
) -> Result<Rendering> {
    if matches!(settings.estimator, Estimator::Radiosity(_) | Estimator::Photon { .. }) {
        let message = "pictures are estimated by local estimates or paths; radiosity and photons \
                       are for sensors";
        return Err(Error::Parameter(message.to_owned()));
    }
    let launcher = Launcher::new(scene)?;
    let known_lights = KnownLights::of(scene);
    check_film(&film, camera.window().size())?;
    let mut control = Control::new(settings.stop);
    let caustic = launcher.caustic_share(settings.randomness, settings.seed);
    let mut run = Rendering::begun(film, caustic);
    let mut samples = Vec::new();
    let mut keeper = keeper.map(Keeping::new);
    loop {
        run.account(&launcher, settings, &control);
        if let Some(ending) = run.ending(&mut control, observer) {
            run.ending = ending;
            // The time may be up before the first pass.
            run.unfinished = (run.film.passes() == 0).then_some(0.0);
            return Ok(run);
        }
        if let Some(keeper) = &mut keeper
            && keeper.is_due(&control)
        {
            // The film and what is written of it need the memory.
            samples = Vec::new();
            keeper.save(&run, &control);
        }
        if run.film.is_between_stages() {
            run.film.plan(settings.stop.relative_error);
        }
        samples.resize(run.film.size().iter().product(), SplitLight::default());
        let watch = Watch::new(&control, observer, run.walks_per_pixel);
        if run.pass(scene, (&launcher, &known_lights), camera, (settings, &watch), &mut samples) {
            run.account(&launcher, settings, &control);
            run.ending = watch.ending();
            return Ok(run);
        }
    }
}

impl Rendering {
    fn begun(film: Film, caustic: f64) -> Self {
        Self {
            film,
            ending: Ending::Interrupted,
            walks_per_pixel: 0,
            mean_walks_per_pixel: 0.0,
            escaped: 0.0,
            caustic,
            unfinished: None,
            elapsed: Duration::ZERO,
        }
    }

    /// Brings the figures up to the film.
    fn account(&mut self, launcher: &Launcher, settings: &ImageSettings, control: &Control) {
        let emitted = launcher.power() * self.film.passes() as f64;
        let walks = walks_per_sample(&settings.estimator);
        let pixels: usize = self.film.size().iter().product();
        self.walks_per_pixel = (self.film.passes() * walks) as u64;
        self.mean_walks_per_pixel = self.film.samples() as f64 * walks as f64 / pixels as f64;
        self.escaped = if emitted > 0.0 { self.film.escaped().luminance() / emitted } else { 0.0 };
        self.elapsed = control.elapsed();
    }

    /// Whether and why a run is over after a complete pass.
    fn ending(&self, control: &mut Control, observer: Observer) -> Option<Ending> {
        let walks = self.walks_per_pixel;
        let known = || {
            let error = self.film.relative_error_of(SHARE_WITHIN)?;
            let each = walks / self.film.passes() as u64;
            Some(Known { error, walks, judged: self.film.stage_end() * each })
        };
        if self.film.is_between_stages() {
            if control.meets_target(known()) {
                return Some(Ending::Error);
            }
            if control.is_open_ended() {
                return Some(Ending::Walks);
            }
        } else if self.film.passes() >= FEWEST_FORETOLD && self.film.passes().is_power_of_two() {
            control.note(known());
        }
        // A number of walks is no haste.
        let hastes =
            |ending: &Ending| *ending != Ending::Walks || self.film.passes() >= FEWEST_PASSES;
        let over = control.is_over(walks).filter(hastes);
        let broken = || control.report(walks, observer).is_break();
        over.or_else(|| broken().then_some(Ending::Interrupted))
    }

    /// Takes a pass; tells whether it was abandoned, in which case the film is as it was, unless it
    /// was the very first.
    fn pass(
        &mut self,
        scene: &Scene,
        (launcher, known_lights): (&Launcher, &KnownLights),
        camera: &Camera,
        (settings, watch): (&ImageSettings, &Watch),
        samples: &mut [SplitLight],
    ) -> bool {
        let pass = Pass::new(scene, launcher, known_lights, settings, &self.film, watch);
        let complete = pass.fill(camera, samples);
        let unfinished = (!complete && self.film.passes() == 0).then(|| pass.share());
        if complete {
            pass.splat(camera, samples);
            let escaped = pass.escaped();
            self.film.add_escaped(escaped);
        }
        if complete || unfinished.is_some_and(|share| share > 0.0) {
            self.film.add_pass(samples);
        }
        self.unfinished = unfinished;
        !complete
    }
}

/// When a checkpointer saved last, and how long it took.
struct Keeping<'a> {
    own: Checkpointer<'a>,
    at: Duration,
    took: Duration,
}

impl<'a> Keeping<'a> {
    fn new(own: Checkpointer<'a>) -> Self {
        Self { own, at: Duration::ZERO, took: Duration::ZERO }
    }

    fn is_due(&self, control: &Control) -> bool {
        control.elapsed() >= self.at + self.own.every.max(9 * self.took)
    }

    fn save(&mut self, run: &Rendering, control: &Control) {
        let start = control.elapsed();
        (self.own.save)(run);
        self.at = control.elapsed();
        self.took = self.at.saturating_sub(start);
    }
}

fn check_film(film: &Film, resolution: [u32; 2]) -> Result<()> {
    let size = resolution.map(|n| n as usize);
    if film.size() == size && film.replicates == REPLICATES {
        return Ok(());
    }
    Err(Error::Parameter(format!(
        "a film of {} x {} pixels cannot go on as {} x {}",
        film.size()[0],
        film.size()[1],
        size[0],
        size[1]
    )))
}
