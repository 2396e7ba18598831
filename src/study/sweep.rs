//! What a truncation degree costs and buys: bytes, error, time to fit and time to trace, beside the
//! mesh itself.

use std::hint::black_box;
use std::time::Instant;

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::Result;
use crate::fit::{Fit, FitSettings, fit, mesh_bytes, series_bytes};
use crate::math::{Ray, sampling};
use crate::mesh::Mesh;
use crate::surface::{Intersector, MeshSurface, ShSurface, Surface};

/// Holds one line of a sweep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweepRow {
    /// What the fit has; `None` for the mesh itself.
    pub series: Option<SweptSeries>,
    /// Bytes in f32: the coefficients, or vertices and indices of the mesh.
    pub bytes: usize,
    /// Time per first hit on one thread, nanoseconds: random chords of the bounding ball, median of
    /// several passes.
    pub nanoseconds_per_ray: f64,
}

/// Describes the fit of one degree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweptSeries {
    /// The degree.
    pub degree: usize,
    /// The root mean square of the radial error, relative to the mean radius.
    pub relative_rms: f64,
    /// The largest radial error, relative to the mean radius.
    pub relative_max: f64,
    /// The time of the projection, milliseconds.
    pub fit_ms: f64,
}

/// Rays that are timed for an SH body and for the mesh.
const RAYS: usize = 20_000;
/// Passes over the rays; the median counts.
const PASSES: usize = 7;

/// Fits a mesh to one degree and measures the fit.
///
/// # Errors
/// As [`fit`], and when the fitted radius is not positive everywhere.
pub fn sweep_degree(mesh: &Mesh, degree: usize) -> Result<(Fit, SweepRow)> {
    let fit = fit(mesh, &FitSettings::of_degree(degree))?;
    let surface = ShSurface::new(&fit.coefficients, Intersector::default())?;
    let rays = chords(DVec3::ZERO, surface.body().bounds().max, RAYS);
    let series = SweptSeries {
        degree,
        relative_rms: fit.relative_rms(),
        relative_max: fit.relative_max(),
        fit_ms: 1e3 * fit.projection_time.as_secs_f64(),
    };
    let row = SweepRow {
        series: Some(series),
        bytes: series_bytes(degree),
        nanoseconds_per_ray: time_per_ray(&surface, &rays),
    };
    Ok((fit, row))
}

/// Measures the mesh itself, by chords of the ball about the middle of its box.
///
/// # Errors
/// As [`MeshSurface::new`].
pub fn sweep_mesh(mesh: &Mesh) -> Result<SweepRow> {
    let surface = MeshSurface::new(mesh.clone())?;
    let centre = surface.bounds().centre();
    let radius = mesh.used_positions().iter().map(|p| p.distance(centre)).fold(0.0, f64::max);
    let rays = chords(centre, radius, RAYS);
    Ok(SweepRow {
        series: None,
        bytes: mesh_bytes(mesh.used_size()),
        nanoseconds_per_ray: time_per_ray(&surface, &rays),
    })
}

/// Makes random chords of a ball: lines through two points uniform on it.
fn chords(centre: DVec3, radius: f64, count: usize) -> Vec<Ray> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut point = || centre + radius * sampling::uniform_sphere(rng.random());
    (0..count)
        .filter_map(|_| Ray::between(point(), point()))
        .map(|ray| ray.up_to(f64::INFINITY))
        .collect()
}

fn time_per_ray(surface: &dyn Surface, rays: &[Ray]) -> f64 {
    let mut passes: Vec<f64> = (0..PASSES)
        .map(|_| {
            let started = Instant::now();
            for ray in rays {
                black_box(surface.hit(black_box(ray)));
            }
            started.elapsed().as_secs_f64() * 1e9 / rays.len() as f64
        })
        .collect();
    passes.sort_by(f64::total_cmp);
    passes[PASSES / 2]
}
