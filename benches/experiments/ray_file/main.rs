//! Times one way to intersect rays on the rays of a file, so that this library and others answer
//! the very same ones; makes such files.
//!
//!     cargo run --release --features experiments --example ray_file -- data/head.obj 32 rays.f32 --make chords 100000 1
//!     cargo run --release --features experiments --example ray_file -- \
//!         data/head.obj 32 rays.f32 hits.f32 --method patches
//!
//! Here are the arguments and the report; `rays` reads and writes the files, `kinds` makes rays,
//! `timing` runs the clock.

mod kinds;
mod rays;
mod timing;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::{Parser, ValueEnum};
use glam::DVec3;
use harmolux::fit::project_conforming;
use harmolux::io::meshes;
use harmolux::math::Ray;
use harmolux::mesh::Mesh;
use harmolux::surface::{Intersector, MeshSurface, ShSurface, StepBisection, Surface};
use serde_json::json;

use kinds::{Body, Kind};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Reads rays from a file, answers them and prints one line of JSON: method, rays, hits,
/// nanoseconds per ray for the first hit, for the first hit with its refinement and for occlusion
/// (medians of seven passes on one thread), the milliseconds it took to build what answers rays,
/// and its bytes (0 where the library does not tell). Or makes such a file: see --make.
///
/// A file of rays holds six little-endian f32 a ray: the origin x y z, the unit direction x y z.
#[derive(Parser)]
#[command(name = "ray_file")]
struct Arguments {
    /// The mesh, with its origin inside
    mesh: PathBuf,
    /// The degree to which it is expanded about its origin; --method mesh passes over it
    lmax: usize,
    /// The rays: read, or written with --make
    rays: PathBuf,
    /// Where to write one little-endian f32 a ray: the distance of the first hit, inf for a miss
    #[arg(conflicts_with = "make")]
    hits: Option<PathBuf>,
    /// What answers the rays
    #[arg(long, value_enum, default_value = "patches", conflicts_with = "make")]
    method: Method,
    /// Ask for this many rays at once instead of one by one
    #[arg(long, conflicts_with = "make")]
    batch: Option<usize>,
    /// Write N rays of a kind instead: chords (random chords of the bounding sphere about the
    /// origin), camera (a pinhole camera that frames the body from a place the seed picks, in
    /// scan-line order), shadow (from random points just outside the surface towards random points
    /// above the horizon there, on a sphere twice the size) or grazing (tangents, passing 1e-3 to
    /// 1e-9 radii above or below a random point)
    #[arg(long, num_args = 3, value_names = ["KIND", "N", "SEED"])]
    make: Option<Vec<String>>,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Method {
    /// The expansion, by patches with certified bounds
    Patches,
    /// The expansion, by certified stepping
    Certified,
    /// The expansion, by steps and bisection with their defaults
    Step,
    /// The mesh itself
    Mesh,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("ray_file: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Outcome<()> {
    let mesh = meshes::read(&arguments.mesh)?;
    if let Some(order) = &arguments.make {
        return make(order, &mesh, arguments.lmax, &arguments.rays);
    }
    if arguments.batch == Some(0) {
        return Err(
            "--batch 0 asks for nothing; give the rays to ask for at once, such as 1024".into()
        );
    }
    let rays = rays::read(&arguments.rays)?;
    match arguments.method {
        Method::Mesh => {
            let (build, surface) = built(|| MeshSurface::new(mesh))?;
            report(arguments, &rays, &surface, build, surface.bytes())
        }
        method => {
            let coefficients = project_conforming(&mesh, DVec3::ZERO, arguments.lmax)?;
            let (build, surface) = built(|| ShSurface::new(&coefficients, intersector(method)))?;
            report(arguments, &rays, &surface, build, surface.patch_bytes())
        }
    }
}

fn make(order: &[String], mesh: &Mesh, lmax: usize, path: &Path) -> Outcome<()> {
    let [kind, count, seed] = order else { return Err("--make takes KIND N SEED".into()) };
    let kind = Kind::from_str(kind, true).map_err(|_| {
        format!("--make {kind}: no such kind of rays; take chords, camera, shadow or grazing")
    })?;
    let number = |name: &str, text: &str| {
        let whole = text.parse::<u64>();
        whole.map_err(|error| format!("--make: {name} is {text}: {error}; give a whole number"))
    };
    let (count, seed) = (number("N", count)?, number("SEED", seed)?);
    if count == 0 {
        return Err("--make: N is 0; give the number of rays, such as 100000".into());
    }
    rays::write(path, &Body::new(mesh, lmax)?.rays(kind, usize::try_from(count)?, seed))
}

/// Builds what answers rays, and takes the time, milliseconds.
fn built<T>(build: impl FnOnce() -> harmolux::Result<T>) -> Outcome<(f64, T)> {
    let started = Instant::now();
    let surface = build()?;
    Ok((started.elapsed().as_secs_f64() * 1e3, surface))
}

fn intersector(method: Method) -> Intersector {
    match method {
        Method::Certified => Intersector::Certified,
        Method::Step => Intersector::StepBisection(StepBisection::default()),
        Method::Patches | Method::Mesh => Intersector::Patches,
    }
}

fn report(
    arguments: &Arguments,
    rays: &[Ray],
    surface: &dyn Surface,
    build: f64,
    bytes: usize,
) -> Outcome<()> {
    let timing = timing::run(surface, rays, arguments.batch.map(|n| n.min(rays.len().max(1))));
    let method =
        arguments.method.to_possible_value().map_or(String::new(), |v| v.get_name().into());
    println!(
        "{}",
        json!({
            "method": method,
            "rays": rays.len(),
            "hits": timing.distances.iter().filter(|t| t.is_finite()).count(),
            "ns_per_ray": rounded(timing.hit),
            "refined_ns_per_ray": rounded(timing.refined),
            "occluded_ns_per_ray": rounded(timing.occluded),
            "build_ms": rounded(build),
            "bytes": bytes,
        })
    );
    match &arguments.hits {
        Some(path) => rays::write_distances(path, &timing.distances),
        None => Ok(()),
    }
}

fn rounded(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}
