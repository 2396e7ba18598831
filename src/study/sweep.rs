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
#[derive(Debug, Clone, PartialEq)]
pub struct SweepRow {
    /// The fit; `None` for the mesh itself.
    pub fit: Option<Fit>,
    /// Bytes in f32: the coefficients, or vertices and indices of the mesh.
    pub bytes: usize,
    /// Time per first hit on one thread, nanoseconds: random chords of the bounding ball, median of
    /// several passes.
    pub nanoseconds_per_ray: f64,
}

/// Rays that are timed for an SH body and for the mesh.
const RAYS: usize = 20_000;
/// Passes over the rays; the median counts.
const PASSES: usize = 7;

/// Fits the mesh to each degree and measures it; the mesh itself comes last. `watch` is told the
/// number of finished lines.
///
/// # Errors
/// As [`fit`], and when a fitted radius is not positive everywhere.
pub fn sweep(mesh: &Mesh, degrees: &[usize], watch: &dyn Fn(usize)) -> Result<Vec<SweepRow>> {
    let mut rows = Vec::new();
    let mut ball = (DVec3::ZERO, 0.0);
    for &lmax in degrees {
        let settings = FitSettings::of_degree(lmax);
        let fit = fit(mesh, &settings)?;
        let surface = ShSurface::new(&fit.coefficients, Intersector::default())?;
        let radius = surface.body().bounds().max;
        ball = (fit.centre, radius);
        let rays = chords(DVec3::ZERO, radius, RAYS);
        rows.push(SweepRow {
            fit: Some(fit),
            bytes: series_bytes(lmax),
            nanoseconds_per_ray: time_per_ray(&surface, &rays),
        });
        watch(rows.len());
    }
    let surface = MeshSurface::new(mesh.clone())?;
    let radius = mesh.used_positions().iter().map(|p| p.distance(ball.0)).fold(0.0, f64::max);
    let rays = chords(ball.0, radius, RAYS);
    rows.push(SweepRow {
        fit: None,
        bytes: mesh_bytes(mesh.used_size()),
        nanoseconds_per_ray: time_per_ray(&surface, &rays),
    });
    watch(rows.len());
    Ok(rows)
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
