//! How long rays take: a surface and the original in turns, one thread, the same rays for all.

use std::hint::black_box;
use std::time::Instant;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::row::{Column, SweepRow};
use crate::math::stats::quartiles;
use crate::math::{Ray, sampling};
use crate::surface::{Hit, Surface};

/// Rays that are timed, and how many make a batch and a turn: few, so that whatever else the
/// machine does falls into few turns.
const RAYS: usize = 8192;
const BATCH: usize = 1024;
/// Turns of each surface.
const TURNS: usize = 49;

/// The rays of a sweep: random chords of a ball, and the same between its points.
pub(super) struct Timer {
    chords: Vec<Ray>,
    segments: Vec<Ray>,
}

/// Names what is timed.
#[derive(Clone, Copy)]
enum Task {
    Hit,
    HitBatch,
    Blocked,
    BlockedBatch,
}

impl Task {
    const ALL: [(Self, [Column; 4]); 4] = [
        (Self::Hit, [Column::Hit, Column::HitLow, Column::HitHigh, Column::HitRatio]),
        (
            Self::HitBatch,
            [Column::HitBatch, Column::HitBatchLow, Column::HitBatchHigh, Column::HitBatchRatio],
        ),
        (
            Self::Blocked,
            [Column::Blocked, Column::BlockedLow, Column::BlockedHigh, Column::BlockedRatio],
        ),
        (
            Self::BlockedBatch,
            [
                Column::BlockedBatch,
                Column::BlockedBatchLow,
                Column::BlockedBatchHigh,
                Column::BlockedBatchRatio,
            ],
        ),
    ];
}

impl Timer {
    /// Draws the rays: lines through two points uniform on the ball about the origin.
    pub(super) fn new(radius: f64) -> Self {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut point = || radius * sampling::uniform_sphere(rng.random());
        let segments: Vec<Ray> = (0..RAYS).filter_map(|_| Ray::between(point(), point())).collect();
        let chords = segments.iter().map(|ray| ray.up_to(f64::INFINITY)).collect();
        Self { chords, segments }
    }

    /// Times a surface in turns with the original.
    pub(super) fn measure(
        &self,
        surface: &dyn Surface,
        original: &dyn Surface,
        row: &mut SweepRow,
    ) {
        for (task, [median, low, high, ratio]) in Task::ALL {
            // What goes second may find something in the cache: each does as often.
            let turn = |k| {
                let own_first = k % 2 == 0;
                let order = if own_first { [surface, original] } else { [original, surface] };
                let [first, second] = order.map(|surface| self.turn(task, surface, k));
                if own_first { [first, second] } else { [second, first] }
            };
            let turns: Vec<[f64; 2]> = (0..TURNS).map(turn).collect();
            let own = quartiles(turns.iter().map(|[own, _]| *own));
            [row[low], row[median], row[high]] = own;
            row[ratio] = quartiles(turns.iter().map(|[own, other]| own / other))[1];
        }
        let hits: Vec<Hit> = self.chords.iter().filter_map(|ray| surface.hit(ray)).collect();
        let refine = |hits: &[Hit]| {
            per_item(hits.len(), || {
                for hit in hits {
                    black_box(surface.refine(black_box(hit)));
                }
            })
        };
        let refined = quartiles(hits.chunks(BATCH / 8).map(refine));
        [row[Column::RefineLow], row[Column::Refine], row[Column::RefineHigh]] = refined;
    }

    /// Does a task over the batch of a turn, after the batch before has brought the surface into
    /// the cache; returns nanoseconds a ray.
    fn turn(&self, task: Task, surface: &dyn Surface, turn: usize) -> f64 {
        let rays = match task {
            Task::Hit | Task::HitBatch => &self.chords,
            Task::Blocked | Task::BlockedBatch => &self.segments,
        };
        let batch = |k: usize| rays.chunks(BATCH).nth(k % rays.len().div_ceil(BATCH));
        let (Some(before), Some(now)) = (batch(turn), batch(turn + 1)) else { return f64::NAN };
        let (mut hits, mut blocked) = (vec![None; BATCH], vec![false; BATCH]);
        task.work(surface, before, &mut hits, &mut blocked);
        blocked.fill(false);
        per_item(now.len(), || task.work(surface, now, &mut hits, &mut blocked))
    }
}

impl Task {
    /// Puts rays to a surface.
    fn work(
        self,
        surface: &dyn Surface,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        blocked: &mut [bool],
    ) {
        match self {
            Self::Hit => rays.iter().for_each(|ray| {
                black_box(surface.hit(black_box(ray)));
            }),
            Self::Blocked => rays.iter().for_each(|ray| {
                black_box(surface.blocked(black_box(ray)));
            }),
            Self::HitBatch => surface.hits(black_box(rays), black_box(&mut hits[..rays.len()])),
            Self::BlockedBatch => {
                surface.mark_blocked(black_box(rays), black_box(&mut blocked[..rays.len()]));
            }
        }
    }
}

/// Times what is done to so many things; nanoseconds each.
fn per_item(count: usize, work: impl FnOnce()) -> f64 {
    let started = Instant::now();
    work();
    started.elapsed().as_secs_f64() * 1e9 / count.max(1) as f64
}
