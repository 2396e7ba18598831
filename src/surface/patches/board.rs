//! The board: how the six cube faces are cut into patches, and patches are gathered four by four.
//!
//! A face is the projective square u = p1/p0, v = p2/p0 of the axis p0; its planes are placed at
//! tan(pi/4 s) for equispaced s, so that all patches have nearly the same angle. Nodes of the
//! lowest level hold 4 x 4 patches, nodes of the next 4 x 4 of those, and one node on top the r x
//! r, r <= 4, that are left: a side has r 4^k patches.

use std::f64::consts::FRAC_PI_4;

/// Children along one side of a node.
pub(super) const FAN: usize = 4;

/// By how much every cell is wider than its planes say, in u and v: far more than the roundings of
/// f32 that decide whether a ray meets it.
pub(super) const MARGIN: f64 = 1e-6;

/// Where a child begins and ends that is not there: no line gets so far.
const NOWHERE: f32 = f32::MAX;

/// The patches along one side of a face that are possible.
pub(super) const SIDES: [usize; 10] = [4, 8, 12, 16, 32, 48, 64, 128, 192, 256];

/// Planes and levels of a board; the same for every face and both directions.
#[derive(Debug, Clone)]
pub(super) struct Board {
    side: usize,
    planes: Vec<f64>,
    cells: Vec<Cell>,
    /// Spans of the nodes of each level, the lowest first.
    levels: Vec<Vec<Spans>>,
}

/// Where a patch lies along u or v: its middle and half width, margin included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cell {
    pub(super) middle: f64,
    pub(super) half: f64,
    /// 1 / half.
    pub(super) scale: f64,
}

/// Where the children of a node begin and end, margin included, lane j * 4 + i for child i along u
/// and j along v.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(super) struct Spans {
    /// As a node's columns: beginnings and ends along u.
    pub(super) across: [[f32; 16]; 2],
    /// As its rows: beginnings and ends along v.
    pub(super) along: [[f32; 16]; 2],
}

impl Board {
    /// Cuts faces into `side` x `side` patches, one of [`SIDES`].
    pub(super) fn new(side: usize) -> Self {
        let plane = |k: usize| (FRAC_PI_4 * (2.0 * k as f64 / side as f64 - 1.0)).tan();
        let mut planes: Vec<f64> = (0..=side).map(plane).collect();
        // The borders of the face, to the last bit.
        (planes[0], planes[side]) = (-1.0, 1.0);
        let cells = planes.windows(2).map(Cell::between).collect();
        let mut board = Self { side, planes, cells, levels: Vec::new() };
        let mut width = 1;
        while side > width {
            board.levels.push(board.spans(width));
            width *= FAN;
        }
        board
    }

    /// Returns the patches along one side of a face.
    pub(super) fn side(&self) -> usize {
        self.side
    }

    /// Returns row or column `i` of the patches.
    #[inline(always)]
    pub(super) fn cell(&self, i: usize) -> &Cell {
        &self.cells[i]
    }

    /// Finds the row or column of patches at u or v.
    #[inline(always)]
    pub(super) fn place(&self, at: f64) -> usize {
        // atan(x) 4/pi to 2e-3, then the planes themselves.
        let x = at.clamp(-1.0, 1.0);
        let angle = x - x * (x.abs() - 1.0) * (0.3116 + 0.0844 * x.abs());
        let guess = (0.5 * (angle + 1.0) * self.side as f64) as usize;
        let mut place = guess.min(self.side - 1);
        while place > 0 && x < self.planes[place] {
            place -= 1;
        }
        while place + 1 < self.side && x >= self.planes[place + 1] {
            place += 1;
        }
        place
    }

    /// Returns the number of levels of nodes.
    pub(super) fn levels(&self) -> usize {
        self.levels.len()
    }

    /// Returns the nodes along one side of a face at a level.
    #[inline(always)]
    pub(super) fn nodes(&self, level: usize) -> usize {
        self.levels[level].len()
    }

    /// Returns the spans of node `i` along one side at a level.
    #[inline(always)]
    pub(super) fn span(&self, level: usize, i: usize) -> &Spans {
        &self.levels[level][i]
    }

    /// Lays out the nodes whose children are `width` patches wide.
    fn spans(&self, width: usize) -> Vec<Spans> {
        let count = self.side.div_ceil(FAN * width);
        let plane = |k: usize| self.planes[k * width];
        let edges = |node: usize, child: usize| {
            let first = node * FAN + child;
            if first * width >= self.side {
                return [NOWHERE; 2];
            }
            [(plane(first) - MARGIN) as f32, (plane(first + 1) + MARGIN) as f32]
        };
        let lay = |node: usize, child: fn(usize) -> usize| {
            let ends = std::array::from_fn::<_, 16, _>(|lane| edges(node, child(lane)));
            [ends.map(|e| e[0]), ends.map(|e| e[1])]
        };
        (0..count)
            .map(|node| Spans {
                across: lay(node, |lane| lane % FAN),
                along: lay(node, |lane| lane / FAN),
            })
            .collect()
    }

    /// Returns the bytes that the planes and spans take.
    pub(super) fn bytes(&self) -> usize {
        let spans: usize = self.levels.iter().map(|l| size_of_val(&l[..])).sum();
        spans + size_of_val(&self.planes[..]) + size_of_val(&self.cells[..])
    }
}

impl Cell {
    fn between(planes: &[f64]) -> Self {
        let half = 0.5 * (planes[1] - planes[0]) + 2.0 * MARGIN;
        Self { middle: 0.5 * (planes[0] + planes[1]), half, scale: 1.0 / half }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_side_is_covered_by_its_nodes() {
        for side in SIDES {
            let board = Board::new(side);
            assert_eq!((board.planes[0], board.planes[side]), (-1.0, 1.0));
            assert_eq!(board.nodes(board.levels() - 1), 1);
            for level in 0..board.levels() {
                let nodes = board.nodes(level);
                let edge = |i: usize, k: usize, end: usize| board.span(level, i).across[end][k];
                let there: Vec<[f32; 2]> = (0..nodes * FAN)
                    .map(|k| [edge(k / FAN, k % FAN, 0), edge(k / FAN, k % FAN, 1)])
                    .filter(|e| e[0] < NOWHERE)
                    .collect();
                assert!(there[0][0] <= -1.0 && there[there.len() - 1][1] >= 1.0);
                assert!(there.windows(2).all(|e| e[1][0] < e[0][1]), "no gap");
            }
            for i in 0..=1000 {
                let at = -1.0 + 0.002 * f64::from(i);
                let place = board.place(at);
                assert!(board.planes[place] <= at && at <= board.planes[place + 1]);
            }
        }
    }
}
