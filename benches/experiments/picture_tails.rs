//! Whether the standard errors of pixels mean what they say: how z = (pixel - truth) / standard
//! error is distributed over seeds, against Student's t with 31 degrees of freedom.
//!
//! ```text
//! cargo run --release --features experiments --example picture_tails [SEEDS [FILE.svg]]
//! ```
//!
//! Small pictures of two scenes, box filter: SEEDS (64) seeds for the combined estimator, a quarter
//! of that for the others. The truth is the mean of all other seeds; that has an error too, so z is
//! divided by sqrt(S / (S - 1)), which makes it t exactly where the replicates of a pixel are
//! normal. Pixels of one seed share walks: the error of a share, behind it, is that of the mean
//! over the seeds' own shares. Pixels without noise (a lamp, nothing at all) are left out.
//!
//! A row says how much of |z| lies beyond the quantile at the head of each column, which should be
//! what stands under it. Of what is beyond the 99.9 %: how much lies below the truth (half where
//! nothing is skewed), and how much in loose pixels, whose standard error differs between seeds by
//! more than half as much again as that of normal replicates, sqrt(1 / 62), next to the share of
//! pixels that are so. Last, how many seeds hold the mean of the picture in its 95 % interval.
//! FILE.svg shows histograms.

use std::ops::ControlFlow;
use std::path::Path;

use harmolux::Result;
use harmolux::estimators::{
    Estimator, ImageSettings, REPLICATES, Stop, Weighting, resume, walks_per_sample,
};
use harmolux::io::scene_file::SceneFile;
use harmolux::math::Randomness;
use harmolux::math::stats::{Estimate, student_t};
use harmolux::plots::{Axis, Curve, Figure, Style};
use harmolux::scene::{Camera, Film, Filter, Scene};
use harmolux::study::{camera, load};
use statrs::distribution::{Continuous, StudentsT};

const SCENES: [(&str, [u32; 2]); 2] = [("paper_figure_3", [32, 24]), ("cornell_head", [24, 24])];
const COMBINED: &str = "double-local";
/// Eye rays to a pixel: one and four in each replicate.
const SAMPLES: [u64; 2] = [32, 128];
/// What should lie beyond the quantiles.
const SHARES: [f64; 6] = [0.5, 0.1, 0.05, 0.01, 1e-3, 1e-4];
/// The share whose quantile begins what is looked at closely, 99.9 %.
const FAR: f64 = SHARES[4];
/// A relative error below this is that of single precision.
const NOISE: f64 = 1e-6;
/// The histogram: the width of its bars and the last of them.
const BAR: f64 = 0.5;
const LAST: f64 = 6.0;

/// By how much the standard error of a loose pixel differs between seeds, relative to what that of
/// normal replicates does.
const LOOSE: f64 = 1.5;

/// What one seed gives: every pixel, and their mean.
struct Picture {
    pixels: Vec<Estimate>,
    mean: Estimate,
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let seeds: u64 = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(64);
    let plot = arguments.next();
    let mut curves = vec![student()];
    for (name, size) in SCENES {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("data/scenes/{name}.toml"));
        let file = SceneFile::read(&file, &[])?;
        let scene = load(&file)?.scene;
        let camera = camera(&file)?.with_resolution(size);
        print_head(name, size);
        for (estimator, how) in estimators(&scene) {
            let seeds = if estimator == COMBINED { seeds } else { seeds.div_ceil(4) };
            for (samples, pictures) in
                SAMPLES.into_iter().zip(pictures(&scene, &camera, how, seeds)?)
            {
                let deviations = Deviations::of(&pictures);
                print_row(estimator, samples, &pictures, &deviations);
                if samples == SAMPLES[1] && (estimator == COMBINED || name == SCENES[0].0) {
                    let name = format!("{estimator}, {}", name.replace('_', " "));
                    curves.push(histogram(name, &deviations.z));
                }
            }
        }
    }
    if let Some(path) = plot {
        let axes = [Axis::linear("z, standard errors"), Axis::logarithmic("density")];
        let title = format!("Deviations of pixels from the truth, {} eye rays a pixel", SAMPLES[1]);
        std::fs::write(&path, Figure::new(title, axes, curves).to_svg()?)
            .map_err(|e| harmolux::Error::Parameter(format!("{path}: {e}")))?;
    }
    Ok(())
}

fn estimators(scene: &Scene) -> [(&'static str, Estimator); 4] {
    [
        (COMBINED, Estimator::Local(Weighting::of(scene))),
        ("double-local-a", Estimator::Local(Weighting::Walk)),
        ("double-local-b", Estimator::Local(Weighting::Gather)),
        ("path", Estimator::Path),
    ]
}

/// Renders with every seed, and keeps the picture at each number of eye rays.
fn pictures(
    scene: &Scene,
    camera: &Camera,
    estimator: Estimator,
    seeds: u64,
) -> Result<[Vec<Picture>; 2]> {
    let mut pictures = SAMPLES.map(|_| Vec::new());
    for seed in 0..seeds {
        let mut film = Film::new(camera.resolution(), REPLICATES)?;
        for (samples, pictures) in SAMPLES.into_iter().zip(&mut pictures) {
            let walks = samples * walks_per_sample(&estimator) as u64;
            let stop = Stop { walks: Some(walks), ..Stop::default() };
            let randomness = Randomness::Sobol;
            let settings = ImageSettings { estimator, randomness, seed, stop, filter: Filter::Box };
            let go_on = |_: &_| ControlFlow::Continue(());
            film = resume(scene, camera, &settings, film, &go_on, None)?.film;
            pictures.push(Picture::of(&film));
        }
    }
    Ok(pictures)
}

impl Picture {
    fn of(film: &Film) -> Self {
        let estimate =
            |mean, standard_error| Estimate { mean, standard_error, replicates: REPLICATES };
        let pixels = film.image().into_iter().zip(film.standard_errors());
        let (mean, standard_error) = film.mean();
        Self {
            pixels: pixels.map(|(colour, error)| estimate(colour.luminance(), error)).collect(),
            mean: estimate(mean, standard_error),
        }
    }
}

/// How the pixels that have noise deviate.
struct Deviations {
    /// For each seed, z of every pixel.
    z: Vec<Vec<f64>>,
    /// Which pixels are loose.
    loose: Vec<bool>,
}

impl Deviations {
    fn of(pictures: &[Picture]) -> Self {
        let of_pixel = |i: usize| pictures.iter().map(move |picture| picture.pixels[i]);
        let is_noisy = |pixel: Estimate| pixel.standard_error > NOISE * pixel.mean;
        let noisy = (0..pictures[0].pixels.len()).filter(|i| of_pixel(*i).any(is_noisy));
        let noisy: Vec<Vec<Estimate>> = noisy.map(|i| of_pixel(i).collect()).collect();
        let columns: Vec<Vec<f64>> = noisy.iter().map(|seeds| of_others(seeds)).collect();
        Self {
            z: (0..pictures.len()).map(|s| columns.iter().map(|z| z[s]).collect()).collect(),
            loose: noisy.iter().map(|seeds| is_loose(seeds)).collect(),
        }
    }

    /// Returns the share of |z| beyond a limit, per cent, and its standard error.
    fn beyond(&self, limit: f64) -> Estimate {
        let share = |z: &Vec<f64>| {
            100.0 * z.iter().filter(|z| z.abs() > limit).count() as f64 / z.len() as f64
        };
        Estimate::of_replicates(&self.z.iter().map(share).collect::<Vec<_>>())
    }

    /// Returns what part of all that is beyond a limit, per cent, lies below the truth, and what
    /// part in loose pixels.
    fn of_beyond(&self, limit: f64) -> [f64; 2] {
        let all = self.z.iter().flat_map(|z| z.iter().zip(&self.loose));
        let beyond: Vec<_> = all.filter(|(z, _)| z.abs() > limit).collect();
        let part = |count: usize| 100.0 * count as f64 / beyond.len().max(1) as f64;
        let below = beyond.iter().filter(|(z, _)| **z < 0.0).count();
        let loose = beyond.iter().filter(|(_, loose)| **loose).count();
        [part(below), part(loose)]
    }
}

/// Whether the standard error of a pixel is known less well than that of normal replicates.
fn is_loose(seeds: &[Estimate]) -> bool {
    let errors: Vec<f64> = seeds.iter().map(|pixel| pixel.standard_error).collect();
    let Estimate { mean, standard_error, .. } = Estimate::of_replicates(&errors);
    let spread = standard_error * (errors.len() as f64).sqrt();
    spread > LOOSE * mean / (2.0 * (REPLICATES - 1) as f64).sqrt()
}

/// Returns how far each estimate lies above the mean of the others, in standard errors of the
/// difference if all have the same variance.
fn of_others(estimates: &[Estimate]) -> Vec<f64> {
    let n = estimates.len() as f64;
    let sum: f64 = estimates.iter().map(|e| e.mean).sum();
    let z = |e: &Estimate| {
        let others = (sum - e.mean) / (n - 1.0);
        e.deviation(others) / (n / (n - 1.0)).sqrt()
    };
    estimates.iter().map(z).collect()
}

fn print_head(name: &str, [width, height]: [u32; 2]) {
    println!("\n{name}, {width} x {height} pixels: % of |z| beyond the quantile");
    print!("{:27}", "");
    for share in SHARES {
        print!("{:>15}", format!("{} %", tidy(100.0 - 100.0 * share)));
    }
    println!("   beyond 99.9 %, %:  loose     means");
    print!("estimator       rays  seeds");
    for share in SHARES {
        print!("{:>15}", tidy(100.0 * share));
    }
    println!("   below  in loose  pixels, %   held");
}

/// Takes the rounding out of a percentage.
fn tidy(percentage: f64) -> f64 {
    (1e6 * percentage).round() / 1e6
}

fn print_row(estimator: &str, samples: u64, pictures: &[Picture], deviations: &Deviations) {
    print!("{estimator:14} {samples:5} {:6}", pictures.len());
    let quantile = |share| student_t(share, REPLICATES - 1);
    for share in SHARES {
        let Estimate { mean, standard_error, .. } = deviations.beyond(quantile(share));
        print!("{:>15}", format!("{mean:.3} ± {standard_error:.3}"));
    }
    let [below, in_loose] = deviations.of_beyond(quantile(FAR));
    let loose = deviations.loose.iter().filter(|loose| **loose).count();
    let loose = 100.0 * loose as f64 / deviations.loose.len() as f64;
    let means = of_others(&pictures.iter().map(|picture| picture.mean).collect::<Vec<_>>());
    let held = means.iter().filter(|z| z.abs() <= quantile(0.05)).count();
    println!("{below:8.0} {in_loose:9.0} {loose:10.1} {held:6}");
}

fn histogram(name: String, z: &[Vec<f64>]) -> Curve {
    let all: usize = z.iter().map(Vec::len).sum();
    let bars = (2.0 * LAST / BAR) as usize;
    let mut counts = vec![0_usize; bars];
    for z in z.iter().flatten() {
        let bar = ((z + LAST) / BAR).floor();
        if (0.0..bars as f64).contains(&bar) {
            counts[bar as usize] += 1;
        }
    }
    let middle = |bar: usize| (bar as f64 + 0.5) * BAR - LAST;
    let density = |count: usize| count as f64 / (all as f64 * BAR);
    let points = counts.into_iter().enumerate().map(|(bar, n)| [middle(bar), density(n)]).collect();
    Curve::new(name, points).drawn(Style::Points)
}

/// Returns the density that z should have.
fn student() -> Curve {
    let freedom = REPLICATES - 1;
    let density = StudentsT::new(0.0, 1.0, freedom as f64).map(|t| move |z| t.pdf(z));
    let places = (0..=120).map(|i| f64::from(i) * LAST / 60.0 - LAST);
    let points = density.map_or_else(|_| Vec::new(), |f| places.map(|z| [z, f(z)]).collect());
    Curve::new(format!("Student's t, {freedom} degrees of freedom"), points).drawn(Style::Line)
}
