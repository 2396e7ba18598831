//! What resting pixels save: time and samples to a target error, against the same run in which
//! every pixel takes every round.
//!
//! ```text
//! cargo run --release --features experiments --example resting
//! ```
//!
//! Both runs are judged after the same stages, by the error that 95 % of the pixels keep. Stages
//! double, so a target may be overshot: four targets a factor 2^(1/4) apart, which is a factor sqrt
//! 2 in samples, are taken in turns. Prints how many times as long, and as many samples, the run
//! without rest takes.

use std::ops::ControlFlow;
use std::path::Path;

use harmolux::Result;
use harmolux::estimators::{
    Estimator, ImageSettings, REPLICATES, SHARE_WITHIN, Stop, Weighting, resume,
};
use harmolux::io::scene_file::SceneFile;
use harmolux::math::Randomness;
use harmolux::scene::{Camera, Film, Filter, Scene};
use harmolux::study::{camera, load};

/// Scenes, the size of their pictures and the first target.
const SCENES: [(&str, [u32; 2], f64); 2] =
    [("paper_figure_3", [48, 36], 0.05), ("cornell_head", [40, 40], 0.05)];
const TARGETS: i32 = 4;
/// The walks per pixel after the first stage, and where a run is given up.
const FIRST: u64 = 1024;
const MOST: u64 = 1 << 18;

/// What a run took to meet its target.
struct Cost {
    seconds: f64,
    samples: u64,
    rounds: u64,
    within: f64,
}

fn main() -> Result<()> {
    println!("scene            target     with rest               without                ratio of");
    println!(
        "                            s  rounds  within        s  rounds  within     time  samples"
    );
    for (name, size, first) in SCENES {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("data/scenes/{name}.toml"));
        let file = SceneFile::read(&file, &[])?;
        let scene = load(&file)?.scene;
        let camera = camera(&file)?.with_resolution(size);
        let mut ratios = [0.0; 2];
        for k in 0..TARGETS {
            let target = first * 2.0_f64.powf(-0.25 * f64::from(k));
            let [rest, all] =
                [cost(&scene, &camera, target, true)?, cost(&scene, &camera, target, false)?];
            let ratio = [all.seconds / rest.seconds, all.samples as f64 / rest.samples as f64];
            print!("{name:14} {:6.2} %", 100.0 * target);
            for Cost { seconds, rounds, within, .. } in [rest, all] {
                print!(" {seconds:8.2} {rounds:7} {:5.1} %", 100.0 * within);
            }
            println!(" {:8.2} {:8.2}", ratio[0], ratio[1]);
            ratios.iter_mut().zip(ratio).for_each(|(sum, ratio)| *sum += ratio.ln());
        }
        let [time, samples] = ratios.map(|sum| (sum / f64::from(TARGETS)).exp());
        println!("{name:14} geometric mean {:47} {time:8.2} {samples:8.2}", "");
    }
    Ok(())
}

/// Renders to a target, with pixels that rest or with none.
fn cost(scene: &Scene, camera: &Camera, target: f64, resting: bool) -> Result<Cost> {
    let mut film = Film::new(camera.resolution(), REPLICATES)?;
    let (mut walks, mut seconds) = (if resting { MOST } else { FIRST }, 0.0);
    loop {
        let stop =
            Stop { relative_error: resting.then_some(target), walks: Some(walks), time: None };
        let settings = ImageSettings {
            estimator: Estimator::Local(Weighting::of(scene)),
            randomness: Randomness::Sobol,
            seed: 1,
            stop,
            filter: Filter::default(),
        };
        let go_on = |_: &_| ControlFlow::Continue(());
        let run = resume(scene, camera, &settings, film, &go_on, None)?;
        film = run.film;
        seconds += run.elapsed.as_secs_f64();
        if walks >= MOST || film.relative_error_of(SHARE_WITHIN).is_some_and(|e| e <= target) {
            let rounds = (film.passes() / REPLICATES) as u64;
            return Ok(Cost {
                seconds,
                samples: film.samples(),
                rounds,
                within: film.share_within(target),
            });
        }
        walks *= 2;
    }
}
