//! The walk of a ray: face after face, in each down the tree to the patches it may meet, in the
//! order in which it meets them.
//!
//! `Walk` is the state of one ray and `Move` what it does next. `trace` makes the moves of one ray
//! one after the other, `batch` those of many side by side: the same moves with the same
//! arithmetic.

use fearless_simd::Simd;
use glam::DVec3;

use super::board::FAN;
use super::line::{Line, facing, turned};
use super::node::{Node, Probe};
use super::patch::{Search, Step, TOLERANCE, Tangent};
use super::route::Stretch;
use super::{Patches, Side};

/// Faces that a line can cross: it meets each of the six planes between them once.
const FACES: u32 = 8;

/// One ray on its way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walk {
    /// The cube face, and the ray on it.
    face: usize,
    line: Line,
    probe: Probe,
    side: Side,
    /// Where the line starts, and what is left of the ray from there, in largest radii.
    at: DVec3,
    left: f64,
    direction: DVec3,
    faces: u32,
    /// The node where the walk is; its parents' numbers are those without the last two bits.
    level: u32,
    row: u32,
    column: u32,
    /// Sixteen bits for each level: the children of the nodes above that are still to be visited.
    waiting: u64,
    /// The patch under search, and how far it is searched.
    patch: u32,
    search: Search,
}

/// What a ray does next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Move {
    /// It looks into a node.
    Open,
    /// It looks for the stretch of a patch to search.
    Approach,
    /// It crosses to the next face.
    Cross,
}

impl Patches {
    /// Follows one walk to its first crossing: the walk there and the tangent. With `ANY` any
    /// crossing will do.
    #[inline(always)]
    pub(super) fn trace<S: Simd, const ANY: bool>(
        &self,
        simd: S,
        mut walk: Walk,
    ) -> Option<(Walk, Tangent)> {
        loop {
            if self.open(simd, &mut walk) && ANY {
                return Some((walk, Tangent::UNKNOWN));
            }
            let mut next = walk.turn();
            while next == Move::Approach {
                let mut step = self.approach(&mut walk);
                while step == Step::On {
                    step = self.step(simd, &mut walk);
                }
                if let Step::Root(tangent) = step {
                    return Some((walk, tangent));
                }
                next = walk.turn();
            }
            if next == Move::Cross && !walk.cross(self) {
                return None;
            }
        }
    }

    /// Makes the move [`Move::Open`]; tells whether the line certainly crosses the surface there.
    #[inline(always)]
    pub(super) fn open<S: Simd>(&self, simd: S, walk: &mut Walk) -> bool {
        let level = walk.level as usize;
        let across = self.board.span(level, walk.column as usize);
        let along = self.board.span(level, walk.row as usize);
        let meeting = walk.probe.meet(simd, self.node(walk), across, along);
        walk.waiting |= u64::from(meeting.children) << (16 * level);
        meeting.certain
    }

    /// Makes the move [`Move::Approach`]: from the walk's node down to the patch, up to the plane
    /// before it.
    #[inline(always)]
    pub(super) fn approach(&self, walk: &mut Walk) -> Step {
        let (row, column) = (walk.row as usize, walk.column as usize);
        // Back to the node, from where the next turn is made.
        (walk.row, walk.column) = (walk.row / FAN as u32, walk.column / FAN as u32);
        let lane = (row % FAN) * FAN + column % FAN;
        let mut local = walk.line.over(self.board.cell(column), self.board.cell(row));
        local.enter = self.node(walk).reach(lane, &walk.line, walk.side, local.enter);
        let patch = self.patch_index(walk.face, row, column);
        walk.patch = patch as u32;
        walk.search = self.leaves[patch].search(&walk.line, local);
        if local.enter <= local.leave { Step::On } else { Step::Past }
    }

    /// Searches the patch one step further.
    #[inline(always)]
    pub(super) fn step<S: Simd>(&self, simd: S, walk: &mut Walk) -> Step {
        self.leaves[walk.patch as usize].step(simd, &walk.line, walk.side, &mut walk.search)
    }

    /// Returns on which side of the surface a point is, in largest radii; `None` when it is too
    /// near to say.
    #[inline(always)]
    pub(super) fn side<S: Simd>(&self, simd: S, p: DVec3) -> Option<Side> {
        let (face, p, _) = facing(p.to_array(), [0.0; 3]);
        let line = Line::new(p, [0.0; 3], 0.0);
        let (row, column) = (self.board.place(line.v), self.board.place(line.u));
        let index = self.patch_index(face as usize, row, column);
        let node = &self.levels[0][index / (FAN * FAN)];
        if let Some(side) = node.side(index % (FAN * FAN), &line) {
            return Some(side);
        }
        let patch = &self.leaves[index];
        let [x, y] = line.over(self.board.cell(column), self.board.cell(row)).at(0.0);
        let gap = 1.0 - line.w * patch.tangent(simd, x, y).height;
        if gap > TOLERANCE {
            Some(Side::Outside)
        } else if gap + line.w * f64::from(patch.width) < -TOLERANCE {
            Some(Side::Inside)
        } else {
            None
        }
    }

    #[inline(always)]
    fn node(&self, walk: &Walk) -> &Node {
        let level = walk.level as usize;
        let nodes = self.board.nodes(level);
        &self.levels[level][(walk.face * nodes + walk.row as usize) * nodes + walk.column as usize]
    }

    #[inline(always)]
    fn patch_index(&self, face: usize, row: usize, column: usize) -> usize {
        let nodes = self.board.nodes(0);
        let node = (face * nodes + row / FAN) * nodes + column / FAN;
        node * FAN * FAN + (row % FAN) * FAN + column % FAN
    }
}

impl Walk {
    /// Starts where the stretch does.
    #[inline(always)]
    pub(super) fn new(patches: &Patches, side: Side, stretch: &Stretch) -> Self {
        let Stretch { at, direction, length, .. } = *stretch;
        let (face, p, d) = facing(at, direction);
        Self::on(patches, side, face as usize, Line::new(p, d, length), stretch)
    }

    /// Starts where the stretch does, by the line of it on the face where that is.
    #[inline(always)]
    pub(super) fn on(
        patches: &Patches,
        side: Side,
        face: usize,
        line: Line,
        stretch: &Stretch,
    ) -> Self {
        Self {
            face,
            line,
            probe: Probe::new(&line, side),
            side,
            at: DVec3::from_array(stretch.at),
            left: stretch.length,
            direction: DVec3::from_array(stretch.direction),
            faces: 1,
            level: patches.levels.len() as u32 - 1,
            row: 0,
            column: 0,
            waiting: 0,
            patch: 0,
            search: Search::NONE,
        }
    }

    /// Finds the next move after a node has been opened or a patch searched in vain, and goes
    /// there.
    #[inline(always)]
    pub(super) fn turn(&mut self) -> Move {
        let waiting = self.waiting >> (16 * self.level);
        if waiting == 0 {
            return Move::Cross;
        }
        // Nodes above are left behind when nothing waits below them.
        let next = waiting.trailing_zeros();
        let up = next / 16;
        self.waiting &= self.waiting - 1;
        let lane = (next % 16) as usize ^ self.probe.flip();
        self.level += up;
        let row = (self.row >> (2 * up)) as usize * FAN + lane / FAN;
        let column = (self.column >> (2 * up)) as usize * FAN + lane % FAN;
        (self.row, self.column) = (row as u32, column as u32);
        if self.level == 0 {
            return Move::Approach;
        }
        self.level -= 1;
        Move::Open
    }

    /// Makes the move [`Move::Cross`]; false where the ray ends before.
    #[inline(always)]
    pub(super) fn cross(&mut self, patches: &Patches) -> bool {
        let Some(face) = self.line.next_face(self.face) else { return false };
        if self.faces == FACES {
            return false;
        }
        let step = self.line.distance(self.line.end);
        self.at += step * self.direction;
        self.left -= step;
        self.faces += 1;
        self.face = face;
        let [p, d] = [self.at, self.direction].map(|vector| turned(vector, face / 2));
        self.line = Line::new(p, d, self.left);
        self.probe = Probe::new(&self.line, self.side);
        (self.level, self.row, self.column) = (patches.levels.len() as u32 - 1, 0, 0);
        true
    }

    /// Returns how far the search has come from the start of a stretch of this length, in largest
    /// radii.
    #[inline(always)]
    pub(super) fn progress(&self, length: f64) -> f64 {
        length - self.left + self.line.distance(self.search.tau)
    }

    /// Returns the outward normal of the patch under search.
    #[inline(always)]
    pub(super) fn normal(&self, tangent: &Tangent) -> DVec3 {
        self.line.normal(self.face, self.search.tau, &self.search.local, tangent)
    }
}
