//! The largest distance of the points of one surface from another, enclosed by branch and bound.
//!
//! A surface is cut into pieces: the faces of a mesh, or of an icosphere whose vertices are on the
//! series. For each vertex a point of the other surface near it is known, its foot. No point of a
//! piece is farther from the other surface than
//!
//! * the largest distance of a vertex from its foot, and what either series bends away from the
//!   triangles of vertices and of feet (`smooth`); when the other is a mesh, the largest distance
//!   of a vertex from one of its faces, a convex function, and what the series bends away;
//! * the distance of a vertex from its foot and the way to it: distance is 1-Lipschitz;
//! * of two series about one centre, the difference of their radii.
//!
//! The vertices that are farthest have their distance certified, which is the lower bound. Then the
//! pieces that may reach into the upper half of what is open are split in four. What is done does
//! not depend on the width asked for, only when it ends: a narrower one never gives a wider
//! interval.

use glam::DVec3;
use rayon::prelude::*;

use super::side::Side;
use super::smooth::{Foot, spread};
use crate::mesh::triangle::nearest_on_triangle;
use crate::sh::{Bounds, Coefficients, Evaluator};
use crate::{Result, memory};

/// Encloses the largest distance of a surface from another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FarthestPoint {
    /// The true one is not less, metres.
    pub lower: f64,
    /// What the true one does not exceed, metres.
    pub upper: f64,
    /// A point as far as the lower bound, or farther.
    pub at: DVec3,
    /// Why the interval is wider than asked for; `None` when it is not.
    pub limit: Option<Limit>,
}

/// Says what ended a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limit {
    /// So many points were looked at, and no more are.
    Points(usize),
    /// There is not the memory for more points.
    Memory,
    /// Numbers have no more digits.
    Rounding,
}

/// The radial difference of two series about one centre.
pub(super) struct Apart {
    series: Evaluator,
    /// Bounds its second derivative along great circles.
    curvature: f64,
    /// How far the centres are apart, and rounding.
    rest: f64,
}

impl Apart {
    /// Prepares the difference of two series whose centres are so far apart.
    ///
    /// # Errors
    /// As [`Bounds::of`].
    pub(super) fn new(difference: &Coefficients, centres: f64) -> Result<Self> {
        let series = Evaluator::new(difference)?;
        let Bounds { min, max, curvature, .. } = Bounds::of(difference)?;
        let rest = centres + 4.0 * series.error(max.max(-min));
        Ok(Self { series, curvature, rest })
    }
}

/// A point of the surface.
#[derive(Debug, Clone, Copy)]
struct Vertex {
    point: DVec3,
    /// From the centre of a series.
    direction: DVec3,
    foot: Foot,
    /// The radial difference there, where there is one; else infinite.
    apart: f64,
    /// Whether no point of the other surface is nearer, as far as that was asked.
    certain: bool,
}

#[derive(Debug, Clone, Copy)]
struct Piece {
    corners: [u32; 3],
    upper: f64,
}

/// The points that are looked at beyond those of the mesh.
const MOST_POINTS: usize = 1 << 22;
/// The bytes that splitting a piece takes.
const BYTES: f64 = 1024.0;
/// Vertices that are certified at once, and how often in a round.
const AT_ONCE: usize = 16;
const TIMES: usize = 64;

/// Encloses max over the points of `from` of their distance from `onto`, within `width`, metres, if
/// work and memory allow.
///
/// # Errors
/// [`crate::Error::Memory`] when there is not the memory to begin.
pub(super) fn farthest_point(
    [from, onto]: [&Side; 2],
    apart: Option<&Apart>,
    width: f64,
) -> Result<FarthestPoint> {
    let mut search = Search::new([from, onto], apart)?;
    loop {
        search.raise();
        search.pieces.retain(|piece| piece.upper > search.lower);
        let upper = search.upper();
        let limit = if upper - search.lower <= width { None } else { search.split().err() };
        if upper - search.lower <= width || limit.is_some() {
            return Ok(FarthestPoint { lower: search.lower, upper, at: search.at, limit });
        }
    }
}

struct Search<'a> {
    from: &'a Side,
    onto: &'a Side,
    apart: Option<&'a Apart>,
    vertices: Vec<Vertex>,
    /// Those that may reach above the lower bound.
    pieces: Vec<Piece>,
    lower: f64,
    at: DVec3,
    rounding: f64,
    /// How many points are left to look at.
    left: usize,
}

impl<'a> Search<'a> {
    fn new([from, onto]: [&'a Side; 2], apart: Option<&'a Apart>) -> Result<Self> {
        let mesh = from.mesh();
        let faces = mesh.triangles();
        memory::ask_each(faces.len(), 200.0, "comparing the shapes", "give a coarser mesh")?;
        let rounding = |side: &Side| side.smooth.as_ref().map_or(0.0, |smooth| smooth.rounding);
        let mut search = Self {
            rounding: rounding(from) + rounding(onto),
            vertices: Vec::new(),
            pieces: Vec::new(),
            lower: 0.0,
            at: mesh.corners(0)[0],
            left: MOST_POINTS,
            from,
            onto,
            apart,
        };
        search.vertices = match &from.smooth {
            Some(smooth) => {
                let at = |d: &DVec3| search.vertex(smooth.point(*d), *d);
                smooth.directions.par_iter().map(at).collect()
            }
            None => mesh.positions().par_iter().map(|p| search.vertex(*p, DVec3::ZERO)).collect(),
        };
        search.pieces =
            search.bounded(faces.par_iter().map(|t| Piece { corners: *t, upper: f64::INFINITY }));
        Ok(search)
    }

    fn vertex(&self, point: DVec3, direction: DVec3) -> Vertex {
        let apart = self.apart.map_or(f64::INFINITY, |apart| apart.series.value(direction).abs());
        Vertex { point, direction, foot: self.onto.foot(point), apart, certain: false }
    }

    fn upper(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.upper).fold(self.lower, f64::max)
    }

    fn bounded(&self, pieces: impl ParallelIterator<Item = Piece>) -> Vec<Piece> {
        pieces.map(|piece| Piece { upper: piece.upper.min(self.bound(&piece)), ..piece }).collect()
    }

    /// Bounds the distance of a piece.
    fn bound(&self, piece: &Piece) -> f64 {
        let corners = piece.corners.map(|v| &self.vertices[v as usize]);
        let most =
            |value: &dyn Fn(&Vertex) -> f64| corners.map(value).into_iter().fold(0.0, f64::max);
        let least = |value: &dyn Fn(&Vertex) -> f64| {
            corners.map(value).into_iter().fold(f64::INFINITY, f64::min)
        };
        let directions = corners.map(|v| v.direction);
        let reach = |from: &Vertex| from.foot.distance + most(&|v| v.point.distance(from.point));
        let over = match &self.onto.smooth {
            Some(smooth) => {
                most(&|v| v.foot.distance) + smooth.bulge(corners.map(|v| v.foot.direction))
            }
            None => least(&|of| {
                let face = self.onto.mesh().corners(of.foot.face as usize);
                most(&|v| v.point.distance(nearest_on_triangle(v.point, face)))
            }),
        };
        let bulge = self.from.smooth.as_ref().map_or(0.0, |smooth| smooth.bulge(directions));
        let upper = least(&reach).min(over) + bulge + self.rounding;
        self.apart.map_or(upper, |apart| {
            upper.min(most(&|v| v.apart) + apart.curvature * spread(directions) + apart.rest)
        })
    }

    /// Raises the lower bound by the vertices that are farthest.
    fn raise(&mut self) {
        let upper = self.upper();
        let Some(smooth) = &self.onto.smooth else {
            for v in self.pieces.iter().flat_map(|piece| piece.corners) {
                let v = &self.vertices[v as usize];
                if v.foot.distance - self.rounding > self.lower {
                    (self.lower, self.at) = (v.foot.distance - self.rounding, v.point);
                }
            }
            return;
        };
        let goal = |lower: f64| lower + 0.25 * (upper - lower);
        let is_far = |v: &u32| {
            let v = &self.vertices[*v as usize];
            !v.certain && v.foot.distance > goal(self.lower)
        };
        let mut far: Vec<u32> =
            self.pieces.iter().flat_map(|piece| piece.corners).filter(is_far).collect();
        far.sort_unstable();
        far.dedup();
        let distance = |v: &u32| self.vertices[*v as usize].foot.distance;
        far.sort_by(|a, b| distance(b).total_cmp(&distance(a)));
        for group in far.chunks(AT_ONCE).take(TIMES) {
            let lower = self.lower;
            if self.vertices[group[0] as usize].foot.distance <= goal(lower) {
                break;
            }
            let slack = 0.125 * (upper - lower);
            let certain = |v: &u32| {
                let v = &self.vertices[*v as usize];
                smooth.certain(v.point, v.foot, slack, &self.onto.tree)
            };
            let found: Vec<(f64, Foot)> = group.par_iter().map(certain).collect();
            for (v, (below, foot)) in group.iter().zip(found) {
                let v = &mut self.vertices[*v as usize];
                (v.foot, v.certain) = (foot, true);
                if below - self.rounding > self.lower {
                    (self.lower, self.at) = (below - self.rounding, v.point);
                }
            }
        }
    }

    /// Splits the pieces that may reach into the upper half of what is open.
    fn split(&mut self) -> Result<(), Limit> {
        let upper = self.upper();
        if upper - self.lower <= 4.0 * self.rounding {
            return Err(Limit::Rounding);
        }
        let half = 0.5 * (self.lower + upper);
        let (split, kept): (Vec<Piece>, Vec<Piece>) =
            self.pieces.iter().partition(|piece| piece.upper > half);
        let sides =
            |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]].map(|[p, q]| [p.min(q), p.max(q)]);
        let mut edges: Vec<[u32; 2]> =
            split.par_iter().flat_map_iter(|piece| sides(piece.corners)).collect();
        edges.par_sort_unstable();
        edges.dedup();
        self.left = self.left.checked_sub(edges.len()).ok_or(Limit::Points(MOST_POINTS))?;
        memory::ask(BYTES * split.len() as f64, "", |_| String::new())
            .map_err(|_| Limit::Memory)?;
        let first = self.vertices.len() as u32;
        let middles: Vec<Vertex> = edges.par_iter().map(|edge| self.middle(edge)).collect();
        self.vertices.extend(middles);
        let middle = |edge: [u32; 2]| first + edges.partition_point(|e| *e < edge) as u32;
        let quarters = |piece: &Piece| {
            let [a, b, c] = piece.corners;
            let [ab, bc, ca] = sides(piece.corners).map(middle);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                .map(|corners| Piece { corners, upper: piece.upper })
        };
        let parts = self.bounded(split.par_iter().flat_map_iter(quarters));
        self.pieces = kept;
        self.pieces.extend(parts);
        Ok(())
    }

    fn middle(&self, edge: &[u32; 2]) -> Vertex {
        let [a, b] = edge.map(|v| &self.vertices[v as usize]);
        match &self.from.smooth {
            Some(smooth) => {
                let direction = (a.direction + b.direction).normalize();
                self.vertex(smooth.point(direction), direction)
            }
            None => self.vertex(0.5 * (a.point + b.point), DVec3::ZERO),
        }
    }
}
