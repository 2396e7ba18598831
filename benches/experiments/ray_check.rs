//! Holds the default intersector of SH surfaces to certified stepping, ray by ray, in every way of
//! asking; `tests/common/ray_check` states the rules. One ray in a hundred is made to graze. Ends
//! with 1, and prints the rays with all bits, if an answer breaks a rule.
//!
//!     # 10^7 rays on the head, 10^5 on each other shape:
//!     cargo run --release --features experiments --example ray_check
//!     # so many on the head; the others get at most 10^5:
//!     cargo run --release --features experiments --example ray_check -- --rays 100000 --seed 2

#[path = "../../tests/common/ray_check/mod.rs"]
mod ray_check;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use clap::Parser;
use glam::DVec3;
use harmolux::fit::project_conforming;
use harmolux::io::meshes;
use harmolux::surface::{Intersector, ShSurface};
use ray_check::{CheckShape, RayCheck, RayCheckSettings, check_rays, check_shapes};

/// Rays on each shape but the head.
const OTHERS: u64 = 100_000;

#[derive(Parser)]
struct Arguments {
    /// Rays on the head; every other shape gets as many, but at most 100000.
    #[arg(long, default_value_t = 10_000_000)]
    rays: u64,
    /// Another seed, other rays.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let arguments = Arguments::parse();
    println!(
        "| shape | degree | rays | hits | differences | misses | largest G/error | deepest \
         passed/error | broken | seconds |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let mut holds = true;
    for (i, shape) in shapes()?.iter().enumerate() {
        let rays = if i == 0 { arguments.rays } else { arguments.rays.min(OTHERS) };
        holds &= check(shape, &RayCheckSettings { rays, seed: arguments.seed })?;
    }
    Ok(if holds { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Returns the head, then the others.
fn shapes() -> Result<Vec<CheckShape>, Box<dyn Error>> {
    let mesh = meshes::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("data/head.obj"))?;
    let coefficients = project_conforming(&mesh, DVec3::ZERO, 32)?;
    let mut shapes = vec![CheckShape { name: "head", coefficients }];
    shapes.extend(check_shapes()?);
    Ok(shapes)
}

fn check(shape: &CheckShape, settings: &RayCheckSettings) -> Result<bool, Box<dyn Error>> {
    let examined = ShSurface::new(&shape.coefficients, Intersector::default())?;
    let oracle = ShSurface::new(&shape.coefficients, Intersector::Certified)?;
    let meter = Meter::start(shape.name, settings.rays);
    let report = check_rays(&examined, &oracle, settings, |rays| meter.add(rays));
    print_row(shape, &report, meter.started.elapsed().as_secs_f64());
    for fault in &report.faults {
        println!("\n{} of degree {}, {fault}", shape.name, shape.coefficients.lmax());
    }
    Ok(report.holds())
}

fn print_row(shape: &CheckShape, report: &RayCheck, seconds: f64) {
    println!(
        "| {} | {} | {} | {} | {} | {} | {:.3} | {:.3} | {} | {seconds:.1} |",
        shape.name,
        shape.coefficients.lmax(),
        report.rays,
        report.hits,
        report.differences,
        report.misses,
        report.largest_gap,
        report.deepest_passed,
        report.broken
    );
}

/// Says on stderr every few seconds how far it is.
struct Meter {
    name: &'static str,
    rays: u64,
    done: AtomicU64,
    started: Instant,
    spoken: Mutex<f64>,
}

impl Meter {
    fn start(name: &'static str, rays: u64) -> Self {
        let (done, spoken) = (AtomicU64::new(0), Mutex::new(0.0));
        Self { name, rays, done, started: Instant::now(), spoken }
    }

    fn add(&self, rays: u64) {
        let done = self.done.fetch_add(rays, Ordering::Relaxed) + rays;
        let seconds = self.started.elapsed().as_secs_f64();
        let Ok(mut spoken) = self.spoken.lock() else { return };
        if seconds >= *spoken + 5.0 {
            *spoken = seconds;
            let left = seconds * (self.rays - done) as f64 / done as f64;
            eprintln!("{}: {done} of {} rays, about {left:.0} s left", self.name, self.rays);
        }
    }
}
