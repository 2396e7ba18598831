//! Checks an intersector against certified stepping: very many rays, one in a hundred made to
//! graze, through every way of asking.
//!
//! `judge` holds the rules, `rays` makes the rays, `borders` those on borders of cube faces,
//! `shapes` the bodies that are hard for an intersector, `fault` says which ray broke what.

#![allow(dead_code, unreachable_pub, reason = "a test and an example use their own parts")]

mod borders;
mod fault;
mod judge;
mod rays;
mod shapes;

use rayon::prelude::*;

use fault::FAULTS_KEPT;
use harmolux::math::Ray;
use harmolux::surface::{Hit, ShSurface, Surface};
use judge::Judge;
use rays::{Rays, TestRay};

pub use fault::{RayFault, RayQuestion, RayRule};
pub use shapes::{CheckShape, check_shapes};

/// Rays that are asked together: what the batches of the surface get.
const BLOCK: u64 = 4096;

/// Every so many rays is marked already when the surface is asked to mark.
const MARKED_EVERY: usize = 7;

/// Says how many rays, and which.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayCheckSettings {
    /// The number of rays.
    pub rays: u64,
    /// The seed: the same seed makes the same rays, on any number of threads.
    pub seed: u64,
}

/// Holds what came of a check. The counts of rays, hits, differences and misses are of single first
/// hits; largest values and faults of all questions.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RayCheck {
    /// Rays asked.
    pub rays: u64,
    /// How many of them were made to graze.
    pub grazing: u64,
    /// Rays that certified stepping says hit.
    pub hits: u64,
    /// Rays whose two answers differ by more than rounding: one hits and the other does not, or the
    /// distances differ.
    pub differences: u64,
    /// Rays that certified stepping says hit and the surface did not report, explained by its error
    /// bound or not.
    pub misses: u64,
    /// The largest |G| / error over the reported hits; at most 1 unless a rule is broken.
    pub largest_gap: f64,
    /// The largest ratio of the depth to which a ray was let into the body (from inside: out of it)
    /// unreported, to the error bound there; at most 1 unless a rule is broken.
    pub deepest_passed: f64,
    /// How many answers broke a rule.
    pub broken: u64,
    /// The first of them, in the order of the rays.
    pub faults: Vec<RayFault>,
}

impl RayCheck {
    /// Whether every answer kept every rule.
    pub fn holds(&self) -> bool {
        self.broken == 0
    }

    fn and(mut self, other: Self) -> Self {
        self.rays += other.rays;
        self.grazing += other.grazing;
        self.hits += other.hits;
        self.differences += other.differences;
        self.misses += other.misses;
        self.largest_gap = self.largest_gap.max(other.largest_gap);
        self.deepest_passed = self.deepest_passed.max(other.deepest_passed);
        self.broken += other.broken;
        let room = FAULTS_KEPT.saturating_sub(self.faults.len());
        self.faults.extend(other.faults.into_iter().take(room));
        self
    }

    fn blame(&mut self, fault: RayFault) {
        self.broken += 1;
        if self.faults.len() < FAULTS_KEPT {
            self.faults.push(fault);
        }
    }
}

/// Asks `examined` every ray in every way (one by one and in batches, first hit and whether
/// blocked) and judges the answers by the body of `oracle`, the same shape with certified stepping.
/// On all threads; `done` is told, from any of them, how many rays more are through.
pub fn check_rays(
    examined: &dyn Surface,
    oracle: &ShSurface,
    settings: &RayCheckSettings,
    done: impl Fn(u64) + Sync,
) -> RayCheck {
    let rays = Rays { examined, oracle, seed: settings.seed };
    let blocks: Vec<RayCheck> = (0..settings.rays.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            let end = (block * BLOCK + BLOCK).min(settings.rays);
            let block: Vec<TestRay> = (block * BLOCK..end).map(|i| rays.make(i)).collect();
            let check = check_block(examined, oracle, &block);
            done(block.len() as u64);
            check
        })
        .collect();
    blocks.into_iter().fold(RayCheck::default(), RayCheck::and)
}

/// Asks one block.
fn check_block(examined: &dyn Surface, oracle: &ShSurface, block: &[TestRay]) -> RayCheck {
    let rays: Vec<Ray> = block.iter().map(|test| test.ray).collect();
    let mut batch = vec![None; rays.len()];
    examined.hits(&rays, &mut batch);
    let premarked = |i: usize| i.is_multiple_of(MARKED_EVERY);
    let mut marks: Vec<bool> = (0..rays.len()).map(premarked).collect();
    examined.mark_blocked(&rays, &mut marks);
    let mut check = RayCheck::default();
    for (i, test) in block.iter().enumerate() {
        let certified = oracle.hit(&test.ray);
        let judge = Judge::new(examined, oracle.body(), test, certified);
        let single = examined.hit(&test.ray);
        count(&mut check, &judge, single.as_ref());
        let mut blame = |question, found, broken| {
            let Err(rule) = broken else { return };
            let ray = test.ray;
            check.blame(RayFault { question, rule, ray, kind: test.kind.name(), found, certified });
        };
        blame(RayQuestion::Hit, single, judge.first_hit(single.as_ref()));
        blame(RayQuestion::Hits, batch[i], judge.first_hit(batch[i].as_ref()));
        blame(RayQuestion::Blocked, None, judge.blocked(examined.blocked(&test.ray)));
        let marked = if premarked(i) { kept(marks[i]) } else { judge.blocked(marks[i]) };
        blame(RayQuestion::MarkBlocked, None, marked);
        check.deepest_passed = check.deepest_passed.max(judge.deepest_passed());
        for hit in [single, batch[i]].iter().flatten() {
            check.largest_gap = check.largest_gap.max(judge.gap_ratio(hit));
        }
    }
    check
}

/// A mark that was set stays set.
fn kept(mark: bool) -> Result<(), RayRule> {
    if mark { Ok(()) } else { Err(RayRule::MarkLost) }
}

fn count(check: &mut RayCheck, judge: &Judge, found: Option<&Hit>) {
    let certified = judge.certified();
    check.rays += 1;
    check.grazing += u64::from(judge.is_grazing());
    check.hits += u64::from(certified.is_some());
    check.misses += u64::from(certified.is_some() && found.is_none());
    check.differences += u64::from(judge.differs(found));
}

#[cfg(test)]
mod tests;
