//! The walk of a ray: face after face, in each down the tree to the patches it may meet, in the order in which it meets them.

use fearless_simd::Simd;
use glam::DVec3;

use super::board::FAN;
use super::line::{Line, Local, face_of};
use super::node::{Met, Node, Probe};
use super::patch::{Patch, Tangent};
use super::{Crossing, Patches, Side, Stretch};

/// The largest F that counts as a root, in largest radii: F times the radius is the radial distance.
pub(super) const TOLERANCE: f64 = 1e-7;

/// Levels that a tree can have: 4^4 is the largest side.
const LEVELS: usize = 4;

/// Faces that a line can cross: a straight line meets each of the six planes between them once.
const FACES: usize = 8;

/// A walk down the tree of one face.
struct Descent {
    level: usize,
    top: usize,
    met: [Met; LEVELS],
    row: [usize; LEVELS],
    column: [usize; LEVELS],
}

/// A patch that a line may meet, and where.
pub(super) struct Candidate<'a> {
    pub(super) patch: &'a Patch,
    pub(super) local: Local,
    across: usize,
    along: usize,
}

/// What the visitor of candidates wants.
enum Verdict<T> {
    On,
    Found(T),
}

impl Patches {
    #[inline(always)]
    pub(super) fn first_crossing_simd<S: Simd>(
        &self,
        simd: S,
        stretch: &Stretch,
        side: Side,
    ) -> Option<Crossing> {
        let per = 1.0 / self.radius;
        let (mut p, mut left) = (stretch.from * per, stretch.length * per);
        let mut face = face_of(p);
        for _ in 0..FACES {
            let line = Line::new(face, p, stretch.direction, left);
            let found = self.each_candidate(
                simd,
                &line,
                side,
                #[inline(always)]
                |c| match c.patch.first_root(simd, &line, &c.local, side, TOLERANCE) {
                    None => Verdict::On,
                    Some((tau, tangent)) => Verdict::Found(self.describe(&line, &c, tau, &tangent)),
                },
            );
            if let Verdict::Found(crossing) = found {
                let before = stretch.start + (stretch.length - left * self.radius);
                return Some(Crossing { distance: crossing.distance + before, ..crossing });
            }
            face = line.next_face()?;
            let step = line.distance(line.end);
            p += step * stretch.direction;
            left -= step;
        }
        None
    }

    #[inline(always)]
    pub(super) fn crosses_simd<S: Simd>(&self, simd: S, stretch: &Stretch, side: Side) -> bool {
        self.first_crossing_simd(simd, stretch, side).is_some()
    }

    #[inline(always)]
    pub(super) fn side_simd<S: Simd>(&self, simd: S, p: DVec3) -> Option<Side> {
        let line = Line::new(face_of(p), p, DVec3::ZERO, 0.0);
        let column = self.board.place(line.u);
        let row = self.board.place(line.v);
        let patch = self.patch(line.face, row, column);
        let local = line.over(self.board.cell(column), self.board.cell(row));
        let [x, y] = local.at(0.0);
        let height = patch.tangent(simd, x, y).height;
        let gap = 1.0 - line.w * height;
        if gap > TOLERANCE {
            Some(Side::Outside)
        } else if gap + line.w * f64::from(patch.width) < -TOLERANCE {
            Some(Side::Inside)
        } else {
            None
        }
    }

    #[inline(always)]
    fn patch(&self, face: usize, row: usize, column: usize) -> &Patch {
        let nodes = self.board.nodes(0);
        let node = (face * nodes + row / FAN) * nodes + column / FAN;
        &self.patches[node * FAN * FAN + (row % FAN) * FAN + column % FAN]
    }

    /// Shows the visitor the patches that the line may meet, in order.
    #[inline(always)]
    fn each_candidate<'a, S: Simd, T>(
        &'a self,
        simd: S,
        line: &Line,
        side: Side,
        mut visit: impl FnMut(Candidate<'a>) -> Verdict<T>,
    ) -> Verdict<T> {
        let probe = Probe::new(simd, line, side);
        let top = self.levels.len() - 1;
        let mut walk = Descent {
            level: top,
            top,
            met: [Met::default(); LEVELS],
            row: [0; LEVELS],
            column: [0; LEVELS],
        };
        walk.met[top] = self.open(simd, &probe, line.face, &walk);
        loop {
            let level = walk.level;
            let Some(lane) = walk.met[level].next(probe.flip()) else {
                if level == walk.top {
                    return Verdict::On;
                }
                walk.level += 1;
                continue;
            };
            let row = walk.row[level] * FAN + lane / FAN;
            let column = walk.column[level] * FAN + lane % FAN;
            if level > 0 {
                walk.level -= 1;
                (walk.row[level - 1], walk.column[level - 1]) = (row, column);
                walk.met[level - 1] = self.open(simd, &probe, line.face, &walk);
                continue;
            }
            let mut local = line.over(self.board.cell(column), self.board.cell(row));
            let node = self.node(line.face, &walk);
            local.enter = node.reach(lane, line, side, local.enter);
            let patch = self.patch(line.face, row, column);
            if let Verdict::Found(found) = visit(Candidate { patch, local, across: column, along: row })
            {
                return Verdict::Found(found);
            }
        }
    }

    #[inline(always)]
    fn open<S: Simd>(&self, simd: S, probe: &Probe<S>, face: usize, walk: &Descent) -> Met {
        let level = walk.level;
        let across = self.board.span(level, walk.column[level]);
        let along = self.board.span(level, walk.row[level]);
        let (met, _) = probe.meet(simd, self.node(face, walk), across, along);
        met
    }

    #[inline(always)]
    fn node(&self, face: usize, walk: &Descent) -> &Node {
        let level = walk.level;
        let nodes = self.board.nodes(level);
        &self.levels[level][(face * nodes + walk.row[level]) * nodes + walk.column[level]]
    }

    /// Describes the root of a candidate.
    #[inline(always)]
    fn describe(&self, line: &Line, c: &Candidate, tau: f64, t: &Tangent) -> Crossing {
        let (across, along) = (self.board.cell(c.across), self.board.cell(c.along));
        let (u, v) = (tau.mul_add(line.du, line.u), tau.mul_add(line.dv, line.v));
        let normal = line.normal(u, v, t.height, t.dx * across.scale, t.dy * along.scale);
        Crossing { distance: line.distance(tau) * self.radius, normal, error: self.error() }
    }
}
