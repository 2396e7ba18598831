//! Builds the patches of a body: as few as keep the error at a millionth of the largest radius.

use glam::DVec3;
use rayon::prelude::*;

use super::Patches;
use super::board::{Board, Cell, FAN, SIDES, Spans};
use super::certificate::{interpolation_error, lebesgue};
use super::fit::{Fitted, Fitter, POINTS, Planes, chebyshev_point};
use super::node::Node;
use super::patch::Patch;
use crate::math::Aabb;
use crate::sh::{Bounds, Coefficients, GridSeries, Series, rounding};
use crate::{Result, memory};

/// The largest error that is accepted while finer boards are possible, in largest radii.
const TARGET: f64 = 1e-6;

/// From this degree on the heights are taken from a grid, which costs the same for every degree.
const GRID_DEGREE: usize = 48;

/// The relative error of a value from the grid.
const GRID_ERROR: f64 = 1e-11;

/// Patches that one task fits.
const PER_TASK: usize = 16;

/// Returns the radius at many directions.
enum Radii<'a> {
    Series(&'a Series),
    Grid(Box<GridSeries>),
}

impl Radii<'_> {
    fn at(&self, directions: &[DVec3]) -> Vec<f64> {
        match self {
            Self::Series(series) => series.values(directions),
            Self::Grid(grid) => directions.iter().map(|w| grid.value(*w)).collect(),
        }
    }
}

/// Fits finer and finer boards until the error is small enough, or the board as fine as it gets.
pub(super) fn build(series: &Series, bounds: &Bounds) -> Result<Patches> {
    let lmax = series.coefficients().lmax();
    let radii = if lmax >= GRID_DEGREE {
        Radii::Grid(Box::new(GridSeries::new(series.clone())?))
    } else {
        Radii::Series(series)
    };
    let mut choice = SIDES.iter().position(|&side| 4 * side >= lmax).unwrap_or(SIDES.len() - 1);
    loop {
        let side = SIDES[choice];
        let count = 6 * side * side;
        let bytes = 2 * count * size_of::<Fitted>();
        memory::ask(bytes as f64, format_args!("tracing a shape of degree {lmax}"), |share| {
            format!("about degree {:.0} would fit; choose a lower one", lmax as f64 * share.sqrt())
        })?;
        let patches = on_board(series.coefficients(), bounds, &radii, Board::new(side));
        let error = 0.5 * f64::from(patches.width);
        if error <= TARGET || choice + 1 == SIDES.len() {
            return Ok(patches);
        }
        // On a board that is too coarse it is the bound of the interpolation that is large; it
        // falls with the twelfth power of the side.
        let wanted = side as f64 * (error / TARGET).powf(1.0 / POINTS as f64);
        let next = SIDES.iter().position(|&s| s as f64 >= wanted).unwrap_or(SIDES.len() - 1);
        choice = next.max(choice + 1);
    }
}

fn on_board(f: &Coefficients, bounds: &Bounds, radii: &Radii, board: Board) -> Patches {
    let scale = 1.0 / bounds.max;
    let (side, fitter) = (board.side(), Fitter::new());
    let own =
        rounding(f) + if matches!(radii, Radii::Grid(_)) { GRID_ERROR * bounds.max } else { 0.0 };
    let beyond: Vec<f64> =
        (0..side).map(|i| interpolation_error(f, board.cell(i), POINTS)).collect();
    let count = 6 * side * side;
    let fitted: Vec<Fitted> = (0..count.div_ceil(PER_TASK))
        .into_par_iter()
        .flat_map_iter(|task| {
            let places =
                (task * PER_TASK..count.min((task + 1) * PER_TASK)).map(|i| place(i, side));
            let places: Vec<[usize; 3]> = places.collect();
            let directions: Vec<(DVec3, f64)> =
                places.iter().flat_map(|p| points(&board, *p)).collect();
            let unit: Vec<DVec3> = directions.iter().map(|d| d.0).collect();
            let values = radii.at(&unit);
            let heights: Vec<f64> =
                values.iter().zip(&directions).map(|(f, (_, per_s))| scale * f * per_s).collect();
            let (beyond, fitter, board) = (&beyond, &fitter, &board);
            let fits = places.iter().zip(heights.chunks(POINTS * POINTS)).map(|(p, heights)| {
                let table =
                    std::array::from_fn(|j| std::array::from_fn(|i| heights[j * POINTS + i]));
                let away =
                    beyond[p[2]] + lebesgue(POINTS) * (beyond[p[1]] + lebesgue(POINTS) * own);
                fitter.fit(&table, scale * away, [board.cell(p[2]), board.cell(p[1])])
            });
            fits.collect::<Vec<_>>()
        })
        .collect();
    assemble(board, &fitted, bounds)
}

/// Returns face, row and column of patch `i`: sixteen patches of a node stand together.
fn place(i: usize, side: usize) -> [usize; 3] {
    let (nodes, lane) = (i / (FAN * FAN), i % (FAN * FAN));
    let across = side / FAN;
    let (face, node) = (nodes / (across * across), nodes % (across * across));
    let (row, column) = (node / across, node % across);
    [face, row * FAN + lane / FAN, column * FAN + lane % FAN]
}

/// Returns the directions of the Chebyshev points of a patch, row by row, each with 1/s.
fn points(board: &Board, [face, row, column]: [usize; 3]) -> Vec<(DVec3, f64)> {
    let at = |cell: &Cell, k: usize| cell.middle + cell.half * chebyshev_point(k, POINTS);
    let (across, along) = (board.cell(column), board.cell(row));
    (0..POINTS * POINTS)
        .map(|k| direction(face, at(across, k % POINTS), at(along, k / POINTS)))
        .collect()
}

/// Returns the unit vector through (u, v) of a face, and 1/s = 1/sqrt(1 + u^2 + v^2).
fn direction(face: usize, u: f64, v: f64) -> (DVec3, f64) {
    let sign = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    let per_s = (1.0 + u * u + v * v).sqrt().recip();
    let mut d = DVec3::ZERO;
    let axis = face / 2;
    d[axis] = sign * per_s;
    d[(axis + 1) % 3] = sign * u * per_s;
    d[(axis + 2) % 3] = sign * v * per_s;
    (d, per_s)
}

/// Puts the patches and their planes into the tree.
fn assemble(board: Board, fitted: &[Fitted], bounds: &Bounds) -> Patches {
    // The largest w on a stretch that is traced: outside the ball that fills the body.
    let top = 3.0_f64.sqrt() * bounds.max / bounds.min;
    let mut below: Vec<Planes> = fitted.iter().map(|f| f.planes).collect();
    let mut levels = Vec::new();
    let mut across = None;
    for level in 0..board.levels() {
        let nodes = board.nodes(level);
        let groups: Vec<[Option<Planes>; 16]> =
            (0..6 * nodes * nodes).map(|index| group(&below, index, nodes, across)).collect();
        levels.push(groups.iter().map(|group| node(group, top)).collect());
        let around = |(index, group): (usize, &[Option<Planes>; 16])| {
            let (row, column) = (index / nodes % nodes, index % nodes);
            enclose(group, board.span(level, column), board.span(level, row))
        };
        below = groups.iter().enumerate().map(around).collect();
        across = Some(nodes);
    }
    let bounds_of = |(i, f): (usize, &Fitted)| box_around(&board, place(i, board.side()), f.range);
    let around = fitted.iter().enumerate().map(bounds_of).fold(Aabb::EMPTY, Aabb::union);
    let leaves: Vec<Patch> = fitted.iter().map(|f| f.patch).collect();
    let width = leaves.iter().map(|p| p.width).fold(0.0, f32::max);
    let around = Aabb { min: bounds.max * around.min, max: bounds.max * around.max };
    Patches {
        board,
        levels,
        leaves,
        around,
        radius: bounds.max,
        inner: bounds.min,
        width,
        level: fearless_simd::Level::new(),
    }
}

/// Bounds the surface over a patch, heights times (1, u, v) along the three axes.
fn box_around(board: &Board, [face, row, column]: [usize; 3], [low, high]: [f64; 2]) -> Aabb {
    let sign = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    let (across, along) = (board.cell(column), board.cell(row));
    let corner = |u: f64, v: f64, height: f64| {
        let mut p = DVec3::ZERO;
        let axis = face / 2;
        p[axis] = sign * height;
        p[(axis + 1) % 3] = sign * (across.middle + u * across.half) * height;
        p[(axis + 2) % 3] = sign * (along.middle + v * along.half) * height;
        p
    };
    let ends = [-1.0, 1.0];
    Aabb::of_points(ends.into_iter().flat_map(|u| {
        ends.into_iter().flat_map(move |v| [low, high].map(|height| corner(u, v, height)))
    }))
}

/// Gathers the planes of the children of a node; `across` counts the children along one side of a
/// face, `None` where they stand node by node.
fn group(
    below: &[Planes],
    index: usize,
    nodes: usize,
    across: Option<usize>,
) -> [Option<Planes>; 16] {
    let (face, row, column) = (index / (nodes * nodes), index / nodes % nodes, index % nodes);
    std::array::from_fn(|lane| {
        let (j, i) = (row * FAN + lane / FAN, column * FAN + lane % FAN);
        match across {
            None => Some(below[index * FAN * FAN + lane]),
            Some(n) if i < n && j < n => Some(below[(face * n + j) * n + i]),
            Some(_) => None,
        }
    })
}

/// Rounds planes to f32, farther apart by more than what the roundings of a probe come to: 16 of
/// the largest terms, and 3e-6 of a line's end.
fn node(group: &[Option<Planes>; 16], top: f64) -> Node {
    let mut node = Node::EMPTY;
    for (lane, planes) in group.iter().enumerate() {
        let Some(p) = planes else { continue };
        let size = p.low.abs() + 2.0 * (p.by_u.abs() + p.by_v.abs()) + 4.0 * top;
        let low = ((p.low - 1e-6 * size) as f32).next_down();
        let end = 3e-6 * (top * top + top * (p.by_u.abs() + p.by_v.abs()));
        node.low[lane] = low;
        node.thickness[lane] = ((p.high - f64::from(low) + 1e-6 * size + end) as f32).next_up();
        (node.by_u[lane], node.by_v[lane]) = (p.by_u as f32, p.by_v as f32);
    }
    node
}

/// Puts planes around those of all children: of their mean slope, as far apart as the corners of
/// the children ask for.
fn enclose(group: &[Option<Planes>; 16], across: &Spans, along: &Spans) -> Planes {
    let there = || group.iter().flatten();
    let count = there().count() as f64;
    let mean = |of: fn(&Planes) -> f64| f64::from((there().map(of).sum::<f64>() / count) as f32);
    let (by_u, by_v) = (mean(|p| p.by_u), mean(|p| p.by_v));
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (lane, planes) in group.iter().enumerate() {
        let Some(p) = planes else { continue };
        for corner in 0..4 {
            let u = f64::from(across.across[corner % 2][lane]);
            let v = f64::from(along.along[corner / 2][lane]);
            let tilt = (p.by_u - by_u) * u + (p.by_v - by_v) * v;
            (low, high) = (low.min(p.low + tilt), high.max(p.high + tilt));
        }
    }
    Planes { low, high, by_u, by_v }
}
