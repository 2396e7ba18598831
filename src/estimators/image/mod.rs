//! Drives an image: pass after pass of one sample per pixel, each pass a part of one replicate.

mod pass;

use std::time::Duration;

use crate::Result;
use crate::math::{Randomness, Rgb};
use crate::scene::{Camera, Film, Filter, Scene};

use self::pass::{Pass, WALKS_PER_SAMPLE};
use super::connect::Light;
use super::replicates::{Control, Ending, Observer, REPLICATES, Stop};
use super::walk::Launcher;
use super::weighting::Weighting;

/// Chooses how the luminance of a pixel is estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Estimator {
    /// The double local estimate, strategy A: walk hits are connected to the visible point (eq. 11); also known as instant radiosity with
    /// a walk of its own for every sample.
    DoubleLocal(Weighting),
    /// Backward path tracing, the reference.
    Path,
}

/// Sets an image run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageSettings {
    /// How a pixel is estimated.
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
    /// Walks (or paths) per pixel.
    pub walks_per_pixel: u64,
    /// The share of the walks' flux that left an open scene.
    pub escaped: f64,
    /// The time it took.
    pub elapsed: Duration,
}

/// Passes that are made whatever the time or the observer says: two replicates are the least that give an error.
const FEWEST_PASSES: usize = 2;

/// Renders the luminance, cd/m2, of every pixel of a camera.
///
/// Only the window of the camera is computed; its pixels are, to the bit, those that the whole picture has there after as many walks. The pixel filter is
/// sampled in proportion to itself. Errors come from [`REPLICATES`] independent replicates and are checked
/// when the number of samples has doubled. Time limits and interruption abandon the pass under way; at least two passes are made.
///
/// # Errors
/// [`crate::Error::Parameter`] when the scene has no light or the image has too many pixels.
pub fn render(
    scene: &Scene,
    camera: &Camera,
    settings: &ImageSettings,
    observer: Observer,
) -> Result<Rendering> {
    let launcher = Launcher::new(scene)?;
    let mut film = Film::new(camera.window().size(), REPLICATES)?;
    let mut control = Control::new(settings.stop);
    let mut escaped = Rgb::BLACK;
    let per_pixel = |passes: usize| (passes * WALKS_PER_SAMPLE) as u64;
    let mut samples = vec![Light::default(); film.size().iter().product()];
    let ending = loop {
        let pass = Pass::new(scene, &launcher, settings, film.passes());
        let cancelled = pass.fill(camera, &mut samples, &|rows| {
            let share = rows as f64 / film.size()[1] as f64;
            let walks = per_pixel(film.passes()) + (share * WALKS_PER_SAMPLE as f64) as u64;
            let broken = control.report(walks, observer).is_break();
            film.passes() >= FEWEST_PASSES && (broken || control.is_late())
        });
        if cancelled {
            break if control.is_late() { Ending::Time } else { Ending::Interrupted };
        }
        escaped += pass.escaped;
        let totals: Vec<Rgb> = samples.iter().map(Light::total).collect();
        film.add_pass(&totals);
        let walks = per_pixel(film.passes());
        let rounds = film.passes() / REPLICATES;
        let doubled = film.passes().is_multiple_of(REPLICATES) && rounds.is_power_of_two();
        if doubled && control.meets_target(film.median_relative_error()) {
            break Ending::Error;
        }
        if doubled && control.is_open_ended() {
            break Ending::Walks;
        }
        if film.passes() >= FEWEST_PASSES {
            if control.report(walks, observer).is_break() {
                break Ending::Interrupted;
            }
            if let Some(ending) = control.is_over(walks) {
                break ending;
            }
        }
    };
    let emitted = launcher.power() * film.passes() as f64;
    Ok(Rendering {
        ending,
        walks_per_pixel: per_pixel(film.passes()),
        escaped: escaped.luminance() / emitted,
        elapsed: control.elapsed(),
        film,
    })
}
