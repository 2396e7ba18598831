//! The clock: first hits, refined hits and occlusion over all rays, on one thread.

use std::time::Instant;

use harmolux::math::Ray;
use harmolux::surface::{Hit, Surface};

/// Passes over the rays of which the median is taken.
const PASSES: usize = 7;

/// Nanoseconds per ray, and what the rays hit.
pub(super) struct Timing {
    /// Of the first hit.
    pub(super) hit: f64,
    /// Of the first hit and its refinement.
    pub(super) refined: f64,
    /// Of occlusion.
    pub(super) occluded: f64,
    /// The distance of every first hit, infinite for a miss.
    pub(super) distances: Vec<f64>,
}

/// Times a surface, asked one ray at a time or `batch` rays at a time.
pub(super) fn run(surface: &dyn Surface, rays: &[Ray], batch: Option<usize>) -> Timing {
    let mut distances = vec![f64::INFINITY; rays.len()];
    let mut refined = distances.clone();
    let mut blocked = vec![false; rays.len()];
    let mut times: [Vec<f64>; 3] = Default::default();
    for _ in 0..PASSES {
        times[0]
            .push(clock(|| first_hits(surface, rays, batch, &mut distances, |hit| hit.distance)));
        let refine = |hit: &Hit| surface.refine(hit).point.length();
        times[1].push(clock(|| first_hits(surface, rays, batch, &mut refined, refine)));
        blocked.fill(false);
        times[2].push(clock(|| occlusion(surface, rays, batch, &mut blocked)));
    }
    std::hint::black_box((&refined, &blocked));
    let [hit, refined, occluded] = times.map(|t| median(t) * 1e9 / rays.len() as f64);
    Timing { hit, refined, occluded, distances }
}

fn first_hits(
    surface: &dyn Surface,
    rays: &[Ray],
    batch: Option<usize>,
    results: &mut [f64],
    result: impl Fn(&Hit) -> f64,
) {
    let result = |hit: &Option<Hit>| hit.as_ref().map_or(f64::INFINITY, &result);
    let Some(batch) = batch else {
        for (ray, to) in rays.iter().zip(results) {
            *to = result(&surface.hit(ray));
        }
        return;
    };
    let mut hits = vec![None; batch];
    for (rays, results) in rays.chunks(batch).zip(results.chunks_mut(batch)) {
        let hits = &mut hits[..rays.len()];
        surface.hits(rays, hits);
        for (hit, to) in hits.iter().zip(results) {
            *to = result(hit);
        }
    }
}

fn occlusion(surface: &dyn Surface, rays: &[Ray], batch: Option<usize>, blocked: &mut [bool]) {
    let Some(batch) = batch else {
        for (ray, to) in rays.iter().zip(blocked) {
            *to = surface.blocked(ray);
        }
        return;
    };
    for (rays, blocked) in rays.chunks(batch).zip(blocked.chunks_mut(batch)) {
        surface.mark_blocked(rays, blocked);
    }
}

/// Returns the seconds something takes.
fn clock(work: impl FnOnce()) -> f64 {
    let started = Instant::now();
    work();
    started.elapsed().as_secs_f64()
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
