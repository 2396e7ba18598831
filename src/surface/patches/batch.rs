//! Many rays side by side: all make the same kind of move at a time, so that no ray waits for another's arithmetic.

use fearless_simd::Simd;

use super::Patches;
use super::patch::{Step, Tangent};
use super::route::Stretch;
use super::walk::{Move, Walk};

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

    /// Takes all rays.
    #[inline(always)]
    fn take(&mut self) -> Self {
        std::mem::replace(self, Self::EMPTY)
    }

    #[inline(always)]
    fn iter(&self) -> impl Iterator<Item = u8> {
        self.rays[..self.count.min(TOGETHER)].iter().copied()
    }
}

/// Which rays make which move next.
struct Agenda {
    open: List,
    search: List,
    face: List,
}

impl Agenda {
    #[inline(always)]
    fn add(&mut self, ray: u8, next: Move) {
        match next {
            Move::Open => self.open.add(ray),
            Move::Search => self.search.add(ray),
            Move::Face => self.face.add(ray),
        }
    }

    fn is_empty(&self) -> bool {
        self.open.count + self.search.count + self.face.count == 0
    }
}

impl Patches {
    /// Follows up to [`TOGETHER`] stretches to their first crossings, with `ANY` to any, and shows each to `found` with its place.
    #[inline(always)]
    pub(super) fn trace_together<S: Simd, const ANY: bool>(
        &self,
        simd: S,
        stretches: &[Stretch],
        mut found: impl FnMut(usize, &Walk, &Tangent),
    ) {
        let Some(first) = stretches.first() else { return };
        let mut walks = [Walk::new(self, first); TOGETHER];
        let mut agenda = Agenda { open: List::EMPTY, search: List::EMPTY, face: List::EMPTY };
        for (ray, stretch) in stretches.iter().enumerate().take(TOGETHER) {
            walks[ray] = Walk::new(self, stretch);
            agenda.open.add(ray as u8);
        }
        while !agenda.is_empty() {
            let mut opened = agenda.open.take();
            if ANY {
                let mut unsure = List::EMPTY;
                for ray in opened.iter() {
                    let walk = &mut walks[usize::from(ray) % TOGETHER];
                    if self.open(simd, walk) {
                        found(usize::from(ray), walk, &Tangent::UNKNOWN);
                    } else {
                        unsure.add(ray);
                    }
                }
                opened = unsure;
            } else {
                for ray in opened.iter() {
                    self.open(simd, &mut walks[usize::from(ray) % TOGETHER]);
                }
            }
            for ray in opened.iter() {
                let next = self.turn(&mut walks[usize::from(ray) % TOGETHER]);
                agenda.add(ray, next);
            }
            for ray in agenda.search.take().iter() {
                let walk = &mut walks[usize::from(ray) % TOGETHER];
                match self.step(simd, walk) {
                    Step::On => agenda.search.add(ray),
                    Step::Past => {
                        let next = self.turn(walk);
                        agenda.add(ray, next);
                    }
                    Step::Root(tangent) => found(usize::from(ray), walk, &tangent),
                }
            }
            for ray in agenda.face.take().iter() {
                if walks[usize::from(ray) % TOGETHER].next_face(self) {
                    agenda.open.add(ray);
                }
            }
        }
    }
}
