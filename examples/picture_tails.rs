//! Whether the standard errors of pixels mean what they say: how z = (pixel - truth) / standard error is distributed over seeds, against Student's t with 31
//! degrees of freedom.
//!
//! ```text
//! cargo run --release --example picture_tails [SEEDS [FILE.svg]]
//! ```
//!
//! Small pictures of two scenes, box filter, SEEDS (128) seeds for each estimator. The truth is the mean of all other seeds; that has an error too, so z is
//! divided by sqrt(S / (S - 1)), which makes it t exactly where the replicates of a pixel are normal. Pixels of one seed share walks: the error of a share,
//! behind it, is that of the mean over the seeds' own shares. Pixels without noise (a lamp, nothing at all) are left out.
//!
//! A row says how much of |z| lies beyond the quantile at the head of each column, which should be what stands under it; what part of those beyond the 99.9 %
//! lies below the truth (half where nothing is skewed) and in that twentieth of the pixels that has most of them; and how many seeds hold the mean of the
//! picture in its 95 % interval. FILE.svg shows the histogram.

use std::ops::ControlFlow;
use std::path::Path;

use harmolux::Result;
use harmolux::estimators::{Estimator, ImageSettings, REPLICATES, Stop, Weighting, render_on};
use harmolux::io::plots::{Axis, Curve, Figure, Style};
use harmolux::io::scene_file::SceneFile;
use harmolux::math::Randomness;
use harmolux::math::stats::{Estimate, student_t};
use harmolux::scene::{Camera, Film, Filter, Scene};
use harmolux::study::{camera, load};
use statrs::distribution::{Continuous, StudentsT};

const SCENES: [(&str, [u32; 2]); 2] = [("head_room", [32, 24]), ("cornell_head", [24, 24])];
const WALKS: [u64; 2] = [256, 1024];
/// What should lie beyond the quantiles.
const SHARES: [f64; 6] = [0.5, 0.1, 0.05, 0.01, 1e-3, 1e-4];
/// The share whose quantile begins what is looked at closely, 99.9 %.
const FAR: f64 = SHARES[4];
/// A relative error below this is that of single precision.
const NOISE: f64 = 1e-6;
/// The histogram: the width of its bars and the last of them.
const BAR: f64 = 0.5;
const LAST: f64 = 7.0;

/// What one seed gives: every pixel, and their mean.
struct Picture {
    pixels: Vec<Estimate>,
    mean: Estimate,
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let seeds = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(128);
    let plot = arguments.next();
    let mut curves = vec![student()];
    for (name, size) in SCENES {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("data/scenes/{name}.toml"));
        let file = SceneFile::read(&file, &[])?;
        let scene = load(&file)?.scene;
        let camera = camera(&file)?.with_resolution(size);
        print_head(name, size, seeds);
        for (estimator, how) in estimators(&scene) {
            for (walks, pictures) in WALKS.into_iter().zip(pictures(&scene, &camera, how, seeds)?) {
                let z = deviations(&pictures);
                print_row(estimator, walks, &pictures, &z);
                if walks == WALKS[1] {
                    curves.push(histogram(format!("{estimator}, {name}"), &z));
                }
            }
        }
    }
    if let Some(path) = plot {
        let axes = [Axis::linear("z, standard errors"), Axis::logarithmic("density")];
        let title = format!("Deviations of pixels, {} walks, {seeds} seeds", WALKS[1]);
        std::fs::write(&path, Figure::new(title, axes, curves).to_svg()?)
            .map_err(|e| harmolux::Error::Parameter(format!("{path}: {e}")))?;
    }
    Ok(())
}

fn estimators(scene: &Scene) -> [(&'static str, Estimator); 4] {
    [
        ("double-local", Estimator::DoubleLocal(Weighting::of(scene))),
        ("double-local-a", Estimator::DoubleLocal(Weighting::Walk)),
        ("double-local-b", Estimator::DoubleLocal(Weighting::Gather)),
        ("path", Estimator::Path),
    ]
}

/// Renders with every seed, and keeps the picture at each number of walks.
fn pictures(
    scene: &Scene,
    camera: &Camera,
    estimator: Estimator,
    seeds: u64,
) -> Result<[Vec<Picture>; 2]> {
    let mut pictures = WALKS.map(|_| Vec::new());
    for seed in 0..seeds {
        let mut film = Film::new(camera.resolution(), REPLICATES)?;
        for (walks, pictures) in WALKS.into_iter().zip(&mut pictures) {
            let stop = Stop { walks: Some(walks), ..Stop::default() };
            let randomness = Randomness::Sobol;
            let settings = ImageSettings { estimator, randomness, seed, stop, filter: Filter::Box };
            let go_on = |_: &_| ControlFlow::Continue(());
            film = render_on(scene, camera, &settings, film, &go_on, None)?.film;
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

/// Gives z of every pixel that has noise, for each seed.
fn deviations(pictures: &[Picture]) -> Vec<Vec<f64>> {
    let noisy = |i: &usize| {
        let mut seeds = pictures.iter().map(|picture| picture.pixels[*i]);
        seeds.any(|pixel| pixel.standard_error > NOISE * pixel.mean)
    };
    let noisy: Vec<usize> = (0..pictures[0].pixels.len()).filter(noisy).collect();
    let columns: Vec<Vec<f64>> = noisy
        .into_iter()
        .map(|i| of_others(&pictures.iter().map(|picture| picture.pixels[i]).collect::<Vec<_>>()))
        .collect();
    (0..pictures.len()).map(|seed| columns.iter().map(|z| z[seed]).collect()).collect()
}

/// Gives how far each estimate lies above the mean of the others, in standard errors of the difference if all have the same variance.
fn of_others(estimates: &[Estimate]) -> Vec<f64> {
    let n = estimates.len() as f64;
    let sum: f64 = estimates.iter().map(|e| e.mean).sum();
    let z = |e: &Estimate| {
        let others = (sum - e.mean) / (n - 1.0);
        e.deviation(others) / (n / (n - 1.0)).sqrt()
    };
    estimates.iter().map(z).collect()
}

fn print_head(name: &str, [width, height]: [u32; 2], seeds: u64) {
    println!("\n{name}, {width} x {height} pixels, {seeds} seeds: % of |z| beyond the quantile");
    print!("{:20}", "");
    SHARES.iter().for_each(|share| print!("{:>15}", format!("{} %", tidy(100.0 - 100.0 * share))));
    println!("   beyond 99.9 %:     largest   means held");
    print!("estimator      walks");
    SHARES.iter().for_each(|share| print!("{:>15}", tidy(100.0 * share)));
    println!("   below   twentieth  |z|     of pictures");
}

/// Takes the rounding out of a percentage.
fn tidy(percentage: f64) -> f64 {
    (1e6 * percentage).round() / 1e6
}

fn print_row(estimator: &str, walks: u64, pictures: &[Picture], z: &[Vec<f64>]) {
    print!("{estimator:14} {walks:5}");
    for share in SHARES {
        let limit = student_t(share, REPLICATES - 1);
        let beyond = |z: &Vec<f64>| z.iter().filter(|z| z.abs() > limit).count() as f64;
        let shares: Vec<f64> = z.iter().map(|z| 100.0 * beyond(z) / z.len() as f64).collect();
        let Estimate { mean, standard_error, .. } = Estimate::of_replicates(&shares);
        print!("{:>15}", format!("{mean:.3} ± {standard_error:.3}"));
    }
    let [below, twentieth] = far(z);
    let largest = z.iter().flatten().fold(0.0_f64, |largest, z| largest.max(z.abs()));
    let means = of_others(&pictures.iter().map(|picture| picture.mean).collect::<Vec<_>>());
    let limit = student_t(0.05, REPLICATES - 1);
    let held = means.iter().filter(|z| z.abs() <= limit).count();
    println!("{below:6.0} % {twentieth:7.0} % {largest:8.1} {held:8} of {}", means.len());
}

/// Gives what part, per cent, of all that lies far out is below the truth, and is in the twentieth of the pixels that has most of it.
fn far(z: &[Vec<f64>]) -> [f64; 2] {
    let limit = student_t(FAR, REPLICATES - 1);
    let of_pixel = |i: usize| z.iter().filter(|z| z[i].abs() > limit).count();
    let mut pixels: Vec<usize> = (0..z[0].len()).map(of_pixel).collect();
    pixels.sort_unstable_by(|a, b| b.cmp(a));
    let all = pixels.iter().sum::<usize>().max(1) as f64;
    let below = z.iter().flatten().filter(|z| **z < -limit).count();
    let most: usize = pixels[..pixels.len().div_ceil(20)].iter().sum();
    [below, most].map(|part| 100.0 * part as f64 / all)
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

/// Gives the density that z should have.
fn student() -> Curve {
    let freedom = REPLICATES - 1;
    let density = StudentsT::new(0.0, 1.0, freedom as f64).map(|t| move |z| t.pdf(z));
    let places = (0..=140).map(|i| f64::from(i) * LAST / 70.0 - LAST);
    let points = density.map_or_else(|_| Vec::new(), |f| places.map(|z| [z, f(z)]).collect());
    Curve::new(format!("Student's t, {freedom} degrees of freedom"), points).drawn(Style::Line)
}
