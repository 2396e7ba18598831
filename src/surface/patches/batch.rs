//! Many rays side by side: all make the same kind of move at a time, so that no ray waits for another's arithmetic.

use fearless_simd::Simd;

use super::Patches;
use super::patch::{Step, Tangent};
use super::route::Stretch;
use super::walk::Walk;

/// Rays that walk together: enough to hide the arithmetic of one behind the others, few enough for the nearest cache.
pub(super) const TOGETHER: usize = 32;

/// Up to [`TOGETHER`] rays.
#[derive(Clone, Copy)]
struct List {
    rays: [u8; TOGETHER],
    count: usize,
}

impl List {
    const EMPTY: Self = Self { rays: [0; TOGETHER], count: 0 };

    #[inline(always)]
    fn add(&mut self, ray: u8) {
        self.rays[self.count % TOGETHER] = ray;
        self.count += 1;
    }

    #[inline(always)]
    fn iter(&self) -> impl Iterator<Item = u8> {
        self.rays[..self.count.min(TOGETHER)].iter().copied()
    }
}

impl Patches {
    /// Follows up to [`TOGETHER`] stretches to their first crossings, with `ANY` to any, and shows each to `found` with its place.
    ///
    /// What a ray does next chooses the list it is put on, not a branch: which ray does what is not to be foreseen.
    #[inline(always)]
    pub(super) fn trace_together<S: Simd, const ANY: bool>(
        &self,
        simd: S,
        stretches: &[Stretch],
        mut found: impl FnMut(usize, &Walk, &Tangent),
    ) {
        let Some(first) = stretches.first() else { return };
        let mut walks = [Walk::new(self, first); TOGETHER];
        let mut tangents = [Tangent::UNKNOWN; TOGETHER];
        let mut open = List::EMPTY;
        for (ray, stretch) in stretches.iter().enumerate().take(TOGETHER) {
            walks[ray] = Walk::new(self, stretch);
            open.add(ray as u8);
        }
        let (mut search, mut turn) = (List::EMPTY, List::EMPTY);
        while open.count + search.count + turn.count > 0 {
            // Rays that go on to open a node, to approach a patch, to cross to the next face.
            let mut next = [List::EMPTY; 3];
            // Rays whose search goes on, has found a root, has found none.
            let mut searched = [List::EMPTY; 3];
            for ray in open.iter() {
                let certain = self.open(simd, walk_of(&mut walks, ray));
                if ANY && certain {
                    searched[1].add(ray);
                } else {
                    turn.add(ray);
                }
            }
            for ray in turn.iter() {
                next[walk_of(&mut walks, ray).turn() as usize].add(ray);
            }
            let [mut opening, approaching, crossing] = next;
            for ray in approaching.iter() {
                let past = self.approach(walk_of(&mut walks, ray)) == Step::Past;
                searched[2 * usize::from(past)].add(ray);
            }
            for ray in search.iter() {
                let end = match self.step(simd, walk_of(&mut walks, ray)) {
                    Step::On => 0,
                    Step::Root(tangent) => {
                        tangents[usize::from(ray) % TOGETHER] = tangent;
                        1
                    }
                    Step::Past => 2,
                };
                searched[end].add(ray);
            }
            for ray in searched[1].iter() {
                found(
                    usize::from(ray),
                    walk_of(&mut walks, ray),
                    &tangents[usize::from(ray) % TOGETHER],
                );
            }
            for ray in crossing.iter() {
                if walk_of(&mut walks, ray).cross(self) {
                    opening.add(ray);
                }
            }
            [search, _, turn] = searched;
            open = opening;
        }
    }
}

#[inline(always)]
fn walk_of(walks: &mut [Walk; TOGETHER], ray: u8) -> &mut Walk {
    &mut walks[usize::from(ray) % TOGETHER]
}
