//! The largest distance of the points of one surface from another, enclosed by branch and bound.
//!
//! A surface is cut into pieces: the faces of a mesh, or of an icosphere whose vertices are on the
//! series. For each vertex a point of the other surface near it is known, its foot. No point of a
//! piece is farther from the other surface than
//!
//! * the largest distance of a vertex from its foot, and what either series bends away from the
//!   triangles of vertices and of feet (`smooth`); when the other is a mesh, the largest distance
//!   of a vertex from one of its faces, a convex function, and what the series bends away, the
//!   faces tried being those nearest to the vertices and to the middle;
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
use super::smooth::{Certain, Foot, Smooth, spread};
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
    /// No point of the other surface is nearer than the foot by more than this.
    slack: f64,
}

#[derive(Debug, Clone, Copy)]
struct Piece {
    corners: [u32; 3],
    upper: f64,
}

/// Says when a search ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aim {
    /// How wide the interval may be, metres.
    pub(super) width: f64,
    /// How many points are looked at, at most, beyond those of the mesh.
    pub(super) points: usize,
}

/// The bytes that splitting a piece takes.
const BYTES: f64 = 1024.0;
/// Vertices that are certified at once.
const AT_ONCE: usize = 16;
/// The part of what is open above which a vertex is certified, and the part to which it is.
const FAR: f64 = 0.25;
const SLACK: f64 = 0.125;

/// Encloses max over the points of `from` of their distance from `onto`, as narrowly as is aimed at
/// if work and memory allow.
///
/// # Errors
/// [`crate::Error::Memory`] when there is not the memory to begin.
pub(super) fn farthest_point(
    [from, onto]: [&Side; 2],
    apart: Option<&Apart>,
    aim: Aim,
) -> Result<FarthestPoint> {
    Ok(Search::new([from, onto], apart)?.run(aim))
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
            left: 0,
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

    fn run(mut self, aim: Aim) -> FarthestPoint {
        self.left = aim.points;
        loop {
            self.raise();
            self.pieces.retain(|piece| piece.upper > self.lower);
            let (lower, upper, at) = (self.lower, self.upper(), self.at);
            let is_met = upper - lower <= aim.width;
            let limit = if is_met { None } else { self.split(aim.points).err() };
            if is_met || limit.is_some() {
                return FarthestPoint { lower, upper, at, limit };
            }
        }
    }

    fn vertex(&self, point: DVec3, direction: DVec3) -> Vertex {
        let apart = self.apart.map_or(f64::INFINITY, |apart| apart.series.value(direction).abs());
        Vertex { point, direction, foot: self.onto.foot(point), apart, slack: f64::INFINITY }
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
            None => self.bound_by_faces(corners),
        };
        let bulge = self.from.smooth.as_ref().map_or(0.0, |smooth| smooth.bulge(directions));
        let upper = least(&reach).min(over) + bulge + self.rounding;
        self.apart.map_or(upper, |apart| {
            upper.min(most(&|v| v.apart) + apart.curvature * spread(directions) + apart.rest)
        })
    }

    /// Bounds the distance of a flat triangle from a mesh by the faces nearest to its corners and
    /// its middle.
    fn bound_by_faces(&self, corners: [&Vertex; 3]) -> f64 {
        let from = |face: u32| {
            let face = self.onto.mesh().corners(face as usize);
            let distances = corners.map(|v| v.point.distance(nearest_on_triangle(v.point, face)));
            distances.into_iter().fold(0.0, f64::max)
        };
        let upper = corners.map(|v| from(v.foot.face)).into_iter().fold(f64::INFINITY, f64::min);
        if upper <= self.lower {
            return upper;
        }
        let middle = corners.map(|v| v.point).into_iter().sum::<DVec3>() / 3.0;
        upper.min(from(self.onto.tree.nearest(middle).face))
    }

    /// Raises the lower bound by the vertices that are farthest.
    fn raise(&mut self) {
        if let Some(smooth) = &self.onto.smooth {
            return self.certify(smooth);
        }
        for v in self.pieces.iter().flat_map(|piece| piece.corners) {
            let v = &self.vertices[v as usize];
            if v.foot.distance - self.rounding > self.lower {
                (self.lower, self.at) = (v.foot.distance - self.rounding, v.point);
            }
        }
    }

    /// Does so where distances are certain only when they were asked for.
    fn certify(&mut self, onto: &Smooth) {
        let upper = self.upper();
        for group in self.farthest(upper).chunks(AT_ONCE) {
            let open = upper - self.lower;
            let first = self.vertices[group[0] as usize].foot.distance;
            if self.left == 0 || first <= self.lower + FAR * open {
                break;
            }
            let certain = |v: &u32| {
                let v = &self.vertices[*v as usize];
                onto.certain(v.point, v.foot, SLACK * open, &self.onto.tree)
            };
            let found: Vec<Certain> = group.par_iter().map(certain).collect();
            for (v, found) in group.iter().zip(found) {
                let v = &mut self.vertices[*v as usize];
                (v.foot, v.slack) = (found.foot, SLACK * open);
                if found.lower - self.rounding > self.lower {
                    (self.lower, self.at) = (found.lower - self.rounding, v.point);
                }
                self.left = self.left.saturating_sub(found.looked_at);
            }
        }
    }

    /// Lists the vertices whose distance may raise the lower bound, the farthest first.
    fn farthest(&self, upper: f64) -> Vec<u32> {
        let open = upper - self.lower;
        // No distance is certain to more digits than the points have.
        if open <= 4.0 * self.rounding {
            return Vec::new();
        }
        let distance = |v: u32| self.vertices[v as usize].foot.distance;
        let is_far = |v: &u32| {
            let is_known = self.vertices[*v as usize].slack <= 2.0 * SLACK * open;
            !is_known && distance(*v) > self.lower + FAR * open
        };
        let mut far: Vec<u32> =
            self.pieces.iter().flat_map(|piece| piece.corners).filter(is_far).collect();
        far.sort_unstable();
        far.dedup();
        far.sort_by(|a, b| distance(*b).total_cmp(&distance(*a)));
        far
    }

    /// Splits the pieces that may reach into the upper half of what is open.
    fn split(&mut self, most: usize) -> Result<(), Limit> {
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
        self.left = self.left.checked_sub(edges.len()).ok_or(Limit::Points(most))?;
        memory::ask(BYTES * split.len() as f64, "", |_| String::new())
            .map_err(|_| Limit::Memory)?;
        let first = self.vertices.len() as u32;
        let middles: Vec<Vertex> = edges.par_iter().map(|edge| self.middle(*edge)).collect();
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

    fn middle(&self, edge: [u32; 2]) -> Vertex {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::mesh::shapes::{cube, l_shape};
    use crate::study::Subject;

    fn enclosed(mesh: &Mesh, other: &Mesh, width: f64) -> FarthestPoint {
        let [from, onto] = [mesh, other].map(|m| Side::new(Subject::Mesh(m)).expect("faces"));
        let found = farthest_point([&from, &onto], None, Aim { width, points: 1 << 20 })
            .expect("little memory");
        assert!(found.lower <= found.upper && found.upper <= found.lower + width, "{found:?}");
        found
    }

    #[test]
    fn a_mesh_is_at_no_distance_from_itself() {
        for mesh in [cube(), l_shape()] {
            assert!(enclosed(&mesh, &mesh, 1e-12).upper <= 1e-15);
        }
    }

    #[test]
    fn nested_cubes_have_their_two_distances() {
        let outer = cube().translated(DVec3::splat(-0.5)).scaled(3.0).expect("positive");
        let inner = cube().translated(DVec3::splat(-0.5));
        // From a corner of the outer cube, (1.5, 1.5, 1.5), to that of the inner one; from the
        // inner faces straight out.
        let from_outer = enclosed(&outer, &inner, 1e-6);
        assert!(from_outer.lower <= 3_f64.sqrt() && from_outer.upper >= 3_f64.sqrt());
        assert!((from_outer.at.abs() - DVec3::splat(1.5)).length() <= 1e-6);
        let from_inner = enclosed(&inner, &outer, 1e-6);
        assert!(from_inner.lower <= 1.0 && from_inner.upper >= 1.0);
    }

    #[test]
    fn the_farthest_point_may_be_inside_a_face() {
        // A plate above two others that leave a gap of width 2 between them: its middle is
        // farthest.
        let plate = |x0: f64, x1: f64, z: f64| {
            let p = |x, y| DVec3::new(x, y, z);
            let corners = vec![p(x0, -9.0), p(x1, -9.0), p(x1, 9.0), p(x0, 9.0)];
            Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).expect("indices in range")
        };
        let two = {
            let (left, right) = (plate(-3.0, -1.0, 0.0), plate(1.0, 3.0, 0.0));
            let positions = [left.positions(), right.positions()].concat();
            let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
            Mesh::new(positions, triangles).expect("indices in range")
        };
        let found = enclosed(&plate(-3.0, 3.0, 1.0), &two, 1e-4);
        let exact = 2_f64.sqrt();
        assert!(found.lower <= exact && found.upper >= exact, "{found:?}");
        assert!(found.at.x.abs() <= 1e-3);
    }

    #[test]
    fn a_search_that_ends_early_says_why_and_what_is_certain() {
        let outer = cube().translated(DVec3::splat(-0.5)).scaled(3.0).expect("positive");
        let inner = cube().translated(DVec3::splat(-0.5));
        let [from, onto] = [&inner, &outer].map(|m| Side::new(Subject::Mesh(m)).expect("faces"));
        let mut search = Search::new([&from, &onto], None).expect("little memory");
        search.pieces.iter_mut().for_each(|piece| piece.upper += 1.0);
        let found = search.run(Aim { width: 1e-6, points: 0 });
        assert_eq!(found.limit, Some(Limit::Points(0)));
        assert!(found.lower <= 1.0 && found.upper >= 1.0 && found.upper <= 3.0, "{found:?}");
    }
}
