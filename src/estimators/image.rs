//! Drives an image: pass after pass of one sample per pixel, each pass a part of one replicate.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use glam::DVec2;
use rayon::prelude::*;

use crate::Result;
use crate::math::{Randomness, Rgb, Stream, hash};
use crate::scene::{Film, Perspective, Scene};

use super::connect::{Batch, Connector, Weighting};
use super::direct;
use super::path::PathTracer;
use super::receiver::Receiver;
use super::replicates::{Control, Ending, Observer, REPLICATES, Stop, seed};
use super::walk::{Launcher, Node};

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

/// Walks (or paths) that share the eye ray of one sample: a block of Sobol points as large as this is stratified in itself.
const WALKS_PER_SAMPLE: usize = 8;
/// Blocks of walks made for each pass; pixels pick theirs at random.
const BLOCKS_PER_PASS: usize = 1024;

// What random numbers are for; each has streams of its own.
const WALKS: u64 = 1;
const EYE: u64 = 2;
const GATHER: u64 = 3;
const PICK: u64 = 4;

/// Renders the luminance, cd/m2, of every pixel of a camera.
///
/// The pixel filter is a tent two pixels wide, sampled in proportion to itself. Errors come from [`REPLICATES`] independent replicates and are checked
/// when the number of samples has doubled. Time limits and interruption abandon the pass under way; at least two passes are made.
///
/// # Errors
/// [`crate::Error::Parameter`] when the scene has no light or the image has too many pixels.
pub fn render(
    scene: &Scene,
    camera: &Perspective,
    settings: &ImageSettings,
    observer: Observer,
) -> Result<Rendering> {
    let launcher = Launcher::new(scene)?;
    let mut film = Film::new(camera.resolution(), REPLICATES)?;
    let mut control = Control::new(settings.stop);
    let mut escaped = Rgb::BLACK;
    let per_pixel = |passes: usize| (passes * WALKS_PER_SAMPLE) as u64;
    let mut samples = vec![Rgb::BLACK; film.size().iter().product()];
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
        film.add_pass(&samples);
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

/// One sample of every pixel, belonging to one replicate.
struct Pass<'a> {
    scene: &'a Scene,
    connector: Connector<'a>,
    settings: &'a ImageSettings,
    replicate: usize,
    /// How many samples this replicate has taken before.
    round: u64,
    walks: Vec<Vec<Node<'a>>>,
    /// The mean flux per walk that left the scene.
    escaped: Rgb,
}

impl<'a> Pass<'a> {
    fn new(
        scene: &'a Scene,
        launcher: &'a Launcher<'a>,
        settings: &'a ImageSettings,
        passes: usize,
    ) -> Self {
        let (replicate, round) = (passes % REPLICATES, (passes / REPLICATES) as u64);
        let (count, weighting) = match settings.estimator {
            Estimator::DoubleLocal(weighting) => (BLOCKS_PER_PASS * WALKS_PER_SAMPLE, weighting),
            Estimator::Path => (0, Weighting::Walk),
        };
        let launch = |i: usize| {
            let index = round * count as u64 + i as u64;
            let mut stream =
                Stream::new(settings.randomness, seed(settings.seed, replicate, WALKS), index);
            let mut nodes = Vec::new();
            let escaped = launcher.walk(&mut stream, &mut nodes);
            (nodes, escaped)
        };
        let (walks, lost): (Vec<_>, Vec<_>) = (0..count).into_par_iter().map(launch).unzip();
        Self {
            scene,
            connector: Connector::new(scene, launcher, weighting),
            settings,
            replicate,
            round,
            walks,
            escaped: lost.into_iter().sum::<Rgb>() / count.max(1) as f64,
        }
    }

    /// Takes a sample of every pixel. After each row `cancel` is told how many are done; when it says so, the pass is abandoned, which is returned.
    fn fill(
        &self,
        camera: &Perspective,
        samples: &mut [Rgb],
        cancel: &(dyn Fn(usize) -> bool + Sync),
    ) -> bool {
        let width = camera.resolution()[0] as usize;
        let tracer = PathTracer::new(self.scene);
        let (cancelled, rows) = (AtomicBool::new(false), AtomicUsize::new(0));
        samples.par_chunks_mut(width).enumerate().for_each(|(row, line)| {
            if cancelled.load(Ordering::Relaxed) {
                return;
            }
            let mut batch = Batch::default();
            for (column, sample) in line.iter_mut().enumerate() {
                let pixel = (row * width + column) as u64;
                let corner = DVec2::new(column as f64, row as f64);
                *sample = self.sample(camera, &tracer, &mut batch, pixel, corner);
            }
            if cancel(rows.fetch_add(1, Ordering::Relaxed) + 1) {
                cancelled.store(true, Ordering::Relaxed);
            }
        });
        // A pass whose last row was finished before anyone asked is complete.
        cancelled.into_inner() && rows.into_inner() < camera.resolution()[1] as usize
    }

    /// Takes one sample of one pixel: an eye ray, and what the point it meets emits and reflects.
    fn sample<'b>(
        &'b self,
        camera: &Perspective,
        tracer: &PathTracer,
        batch: &mut Batch<'b>,
        pixel: u64,
        corner: DVec2,
    ) -> Rgb {
        let stream = |purpose, index| {
            let seed = hash([seed(self.settings.seed, self.replicate, purpose), pixel]);
            Stream::new(self.settings.randomness, seed, index)
        };
        let [u, v] = stream(EYE, self.round).next_2d();
        let film = corner + DVec2::new(tent(u), tent(v));
        let Some(vertex) = self.scene.vertex(&camera.ray(film)) else { return Rgb::BLACK };
        let receiver = Receiver::reflecting(&vertex);
        let mut direct = direct::point_lights(self.scene, &receiver);
        let indices =
            (0..WALKS_PER_SAMPLE as u64).map(|k| self.round * WALKS_PER_SAMPLE as u64 + k);
        let rest: Rgb = match self.settings.estimator {
            Estimator::Path => {
                indices.map(|i| tracer.trace(&receiver, &mut stream(GATHER, i)).total()).sum()
            }
            Estimator::DoubleLocal(_) => {
                let picked =
                    hash([seed(self.settings.seed, self.replicate, PICK), pixel, self.round]);
                let block = picked as usize % BLOCKS_PER_PASS;
                let walks = &self.walks[block * WALKS_PER_SAMPLE..];
                let walks = walks.iter().map(Vec::as_slice);
                let walks = walks.zip(indices.map(|i| stream(GATHER, i)));
                let outlook = self.connector.outlook(&receiver);
                direct += outlook.light;
                let lights = self.connector.estimate(batch, &receiver, &outlook, walks);
                lights.map(|light| light.total()).sum()
            }
        };
        vertex.emitted() + direct + rest / WALKS_PER_SAMPLE as f64
    }
}

/// Maps a uniform number to a position under a tent of width 2 about the middle of a pixel.
fn tent(u: f64) -> f64 {
    let x = if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() };
    0.5 + x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tent_is_centred_and_two_pixels_wide() {
        assert!((tent(0.0) + 0.5).abs() <= 1e-15 && (tent(0.5) - 0.5).abs() <= 1e-15);
        assert!((tent(1.0) - 1.5).abs() <= 1e-15);
        let n = 1000;
        let mean: f64 =
            (0..n).map(|i| tent((f64::from(i) + 0.5) / f64::from(n))).sum::<f64>() / f64::from(n);
        assert!((mean - 0.5).abs() <= 1e-12);
    }
}
