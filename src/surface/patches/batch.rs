//! Many rays side by side: all make the same kind of move at a time, so that no ray waits for
//! another's arithmetic.

use arrayvec::ArrayVec;
use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::lanes::LANES;
use super::line::{Line, facing};
use super::patch::{Step, Tangent};
use super::route::{Rays, Route, Stretch};
use super::walk::Walk;
use super::{Answer, Patches, Side};
use crate::math::Ray;
use crate::surface::Hit;

/// Rays that walk together: enough to hide the arithmetic of one behind the others, few enough for
/// the nearest cache.
pub(super) const TOGETHER: usize = 32;

/// A ray that walks in a group.
struct Fellow {
    /// Its place in the batch.
    place: usize,
    /// The start and length of its stretch.
    start: f64,
    length: f64,
    walk: Walk,
}

type Group = ArrayVec<Fellow, TOGETHER>;

/// Numbers of rays in a group.
type List = ArrayVec<u8, TOGETHER>;

/// What is asked of the rays of a batch.
pub(super) trait Answers {
    /// Whether any crossing will do.
    const ANY: bool;

    /// Whether the ray at a place is still to be answered.
    fn wants(&self, place: usize) -> bool;

    /// Takes the crossing of a ray from outside.
    fn meet(&mut self, patches: &Patches, place: usize, ray: &Ray, crossing: &Crossing);

    /// Answers a ray that starts inside, or that only the series can answer.
    fn other(&mut self, patches: &Patches, place: usize, ray: &Ray);
}

/// Where a ray from outside meets the surface.
pub(super) enum Crossing<'a> {
    /// Where the walk stands, on the stretch of this start and length.
    At { start: f64, length: f64, walk: &'a Walk, tangent: &'a Tangent },
    /// Somewhere before it enters the inner ball.
    Somewhere,
}

/// Asks for first hits.
pub(super) struct FirstHits<'a> {
    pub(super) hits: &'a mut [Option<Hit>],
    pub(super) unanswered: Vec<usize>,
}

impl Answers for FirstHits<'_> {
    const ANY: bool = false;

    #[inline(always)]
    fn wants(&self, _: usize) -> bool {
        true
    }

    #[inline(always)]
    fn meet(&mut self, patches: &Patches, place: usize, ray: &Ray, crossing: &Crossing) {
        if let Crossing::At { start, length, walk, tangent } = *crossing {
            self.hits[place] = Some(patches.describe(ray, start, length, walk, tangent));
        }
    }

    fn other(&mut self, patches: &Patches, place: usize, ray: &Ray) {
        match patches.hit(ray) {
            Answer::Known(hit) => self.hits[place] = hit,
            Answer::AskSeries => self.unanswered.push(place),
        }
    }
}

/// Asks whether there are hits, where none is marked yet.
pub(super) struct Marks<'a> {
    pub(super) blocked: &'a mut [bool],
    pub(super) unanswered: Vec<usize>,
}

impl Answers for Marks<'_> {
    const ANY: bool = true;

    #[inline(always)]
    fn wants(&self, place: usize) -> bool {
        !self.blocked[place]
    }

    #[inline(always)]
    fn meet(&mut self, _: &Patches, place: usize, _: &Ray, _: &Crossing) {
        self.blocked[place] = true;
    }

    fn other(&mut self, patches: &Patches, place: usize, ray: &Ray) {
        match patches.blocked(ray) {
            Answer::Known(blocked) => self.blocked[place] = blocked,
            Answer::AskSeries => self.unanswered.push(place),
        }
    }
}

impl Patches {
    /// Answers many rays: those from outside begin eight by eight and walk together.
    #[inline(always)]
    pub(super) fn answer<S: Simd, A: Answers>(&self, simd: S, rays: &[Ray], answers: &mut A) {
        let mut group = Group::new();
        for (eight, rays_of_eight) in rays.chunks(LANES).enumerate() {
            let side_by_side = Rays::side_by_side(simd, rays_of_eight);
            let passage = self.passage(&side_by_side);
            let passes = passage.passes();
            let outside = passage.comes_from_outside(self, &side_by_side);
            let (stretches, enters) = self.outside(&side_by_side, &passage);
            let (faces, p, d) = facing(stretches.at, stretches.direction);
            let lines = Line::new(p, d, stretches.length);
            let (passes, outside) = (passes.to_bitmask(), outside.to_bitmask());
            let enters = enters.to_bitmask();
            for (lane, ray) in rays_of_eight.iter().enumerate() {
                let place = eight * LANES + lane;
                if passes >> lane & 1 == 0 || !answers.wants(place) {
                    continue;
                }
                let (stretch, enters, walk) = if outside >> lane & 1 == 1 {
                    let stretch = stretches.lane(lane);
                    let (face, line) = (faces[lane] as usize, lines.lane(lane));
                    let walk = Walk::on(self, Side::Outside, face, line, &stretch);
                    (stretch, enters >> lane & 1 == 1, walk)
                } else if let Route::Outside { stretch, enters } = self.route(simd, ray) {
                    (stretch, enters, Walk::new(self, Side::Outside, &stretch))
                } else {
                    answers.other(self, place, ray);
                    continue;
                };
                if A::ANY && enters {
                    answers.meet(self, place, ray, &Crossing::Somewhere);
                } else {
                    let Stretch { start, length, .. } = stretch;
                    group.push(Fellow { place, start, length, walk });
                }
            }
            let last = (eight + 1) * LANES >= rays.len();
            if last || group.len() > TOGETHER - LANES {
                self.follow_together(simd, rays, &mut group, answers);
            }
        }
    }

    /// Follows the walks of a group to their first crossings, or to any where any will do, and
    /// empties the group.
    ///
    /// What a ray does next chooses the list it is put on, not a branch: which ray does what is not
    /// to be foreseen.
    #[inline(always)]
    fn follow_together<S: Simd, A: Answers>(
        &self,
        simd: S,
        rays: &[Ray],
        group: &mut Group,
        answers: &mut A,
    ) {
        let mut tangents = [Tangent::UNKNOWN; TOGETHER];
        let mut open: List = (0..group.len()).map(|ray| ray as u8).collect();
        let (mut search, mut turn) = (List::new(), List::new());
        while open.len() + search.len() + turn.len() > 0 {
            // Rays that go on to open a node, to approach a patch, to cross to the next face.
            let mut next = [List::new(), List::new(), List::new()];
            // Rays whose search goes on, has found a root, has found none.
            let mut searched = [List::new(), List::new(), List::new()];
            for &ray in &open {
                let certain = self.open(simd, &mut group[usize::from(ray)].walk);
                (if A::ANY && certain { &mut searched[1] } else { &mut turn }).push(ray);
            }
            for &ray in &turn {
                next[group[usize::from(ray)].walk.turn() as usize].push(ray);
            }
            let [mut opening, approaching, crossing] = next;
            for &ray in &approaching {
                let past = self.approach(&mut group[usize::from(ray)].walk) == Step::Past;
                searched[2 * usize::from(past)].push(ray);
            }
            for &ray in &search {
                let walk = &mut group[usize::from(ray)].walk;
                let tangent = &mut tangents[usize::from(ray) % TOGETHER];
                searched[self.search(simd, walk, tangent)].push(ray);
            }
            for &ray in &searched[1] {
                let Fellow { place, start, length, walk } = &group[usize::from(ray)];
                let tangent = &tangents[usize::from(ray) % TOGETHER];
                let crossing = Crossing::At { start: *start, length: *length, walk, tangent };
                answers.meet(self, *place, &rays[*place], &crossing);
            }
            for &ray in &crossing {
                if group[usize::from(ray)].walk.cross(self) {
                    opening.push(ray);
                }
            }
            [search, _, turn] = searched;
            open = opening;
        }
        group.clear();
    }

    /// Searches one step further, and returns 0 where the search goes on, 1 where it has found a
    /// root, 2 where it has found none.
    #[inline(always)]
    fn search<S: Simd>(&self, simd: S, walk: &mut Walk, found: &mut Tangent) -> usize {
        match self.step(simd, walk) {
            Step::On => 0,
            Step::Root(tangent) => {
                *found = tangent;
                1
            }
            Step::Past => 2,
        }
    }
}
