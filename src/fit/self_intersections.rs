//! Finds the faces of a mesh that cross each other.
//!
//! Two faces that share no vertex cross when each has corners on both sides of the other's plane
//! and the pieces of the line of both planes that are within them overlap (Moeller 1997). Less than
//! a billionth of the larger face, beside the rounding of the coordinates, counts as touching:
//! faces that touch or lie in one plane do not cross.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Advice;
use crate::math::Aabb;
use crate::mesh::Mesh;
use crate::mesh::report::duplicate_faces;
use crate::surface::Bvh;
use crate::{Error, Result};

/// Lists the faces of a mesh that cross each other.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SelfIntersections {
    /// How many pairs of faces cross.
    pub pairs: usize,
    /// The faces that cross any other, in ascending order.
    pub faces: Vec<u32>,
    /// The first few pairs.
    pub examples: Vec<Crossing>,
}

/// Describes which two faces cross, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// The two faces, the lower number first.
    pub faces: [u32; 2],
    /// A point where they meet, metres.
    pub point: DVec3,
}

/// How many pairs are shown.
const SHOWN: usize = 3;

impl SelfIntersections {
    /// Examines a mesh: about 3 us a face on one core. A face with the vertices of an earlier one
    /// counts as that one.
    ///
    /// # Errors
    /// [`Error::Geometry`] when a vertex of a face is not finite; [`Error::Parameter`] when the
    /// faces are so much in each other's way that the search would take very long.
    pub fn of(mesh: &Mesh) -> Result<Self> {
        Self::within(mesh, PAIRS + PAIRS_EACH * mesh.triangles().len())
    }

    /// Examines a mesh, unless more pairs of faces than `most` have to be looked at.
    fn within(mesh: &Mesh, most: usize) -> Result<Self> {
        let mut boxes: Vec<Aabb> =
            (0..mesh.triangles().len()).map(|f| Aabb::of_points(mesh.corners(f))).collect();
        if let Some(face) =
            (0..boxes.len()).find(|&f| mesh.corners(f).iter().any(|p| !p.is_finite()))
        {
            return Err(Error::Geometry(format!(
                "face {face} (from 0) has a vertex that is not finite; mend its coordinates or \
                 remove the face"
            )));
        }
        for face in duplicate_faces(mesh) {
            boxes[face as usize] = Aabb::EMPTY;
        }
        let tree = Bvh::build(&boxes);
        let seen = AtomicUsize::new(0);
        let partners = |face| {
            let all = Partners::of(mesh, &tree, &boxes, face);
            let seen = all.seen + seen.fetch_add(all.seen, Ordering::Relaxed);
            if seen > most { Err(crowded(most)) } else { Ok(all) }
        };
        let found: Vec<Partners> = (0..boxes.len() as u32)
            .into_par_iter()
            .map(partners)
            .filter(|p| !p.as_ref().is_ok_and(|p| p.count == 0))
            .collect::<Result<_>>()?;
        Ok(Self {
            // Each pair is found by both of its faces.
            pairs: found.iter().map(|p| p.count).sum::<usize>() / 2,
            faces: found.iter().map(|p| p.face).collect(),
            examples: found
                .iter()
                .flat_map(|p| p.above.iter().flatten())
                .take(SHOWN)
                .copied()
                .collect(),
        })
    }
}

/// The pairs of faces whose boxes overlap, for each face and besides, up to which crossings are
/// looked for: ordinary meshes have about twenty for each.
const PAIRS_EACH: usize = 1000;
const PAIRS: usize = 100_000_000;

/// Says that the search would take too long.
fn crowded(most: usize) -> Error {
    Error::Parameter(format!(
        "the faces lie in layers upon each other: more than {most} pairs would have to be looked \
         at to find those that cross"
    ))
    .advise(Advice::SkipCrossings)
}

/// The faces that cross one.
struct Partners {
    face: u32,
    /// How many faces were looked at.
    seen: usize,
    count: usize,
    /// The first few with a higher number.
    above: [Option<Crossing>; SHOWN],
}

impl Partners {
    fn of(mesh: &Mesh, tree: &Bvh, boxes: &[Aabb], face: u32) -> Self {
        let mut all = Self { face, seen: 0, count: 0, above: [None; SHOWN] };
        tree.overlapping(boxes[face as usize], |other| {
            all.seen += 1;
            let other = other as u32;
            let Some(point) = meeting(mesh, face.min(other), face.max(other)) else { return };
            all.count += 1;
            if other > face {
                all.keep(Crossing { faces: [face, other], point });
            }
        });
        all
    }

    /// Keeps the lowest numbers.
    fn keep(&mut self, new: Crossing) {
        let mut moved = Some(new);
        for place in &mut self.above {
            let is_lower = match (&moved, &*place) {
                (Some(new), Some(old)) => new.faces < old.faces,
                (Some(_), None) => true,
                (None, _) => return,
            };
            if is_lower {
                std::mem::swap(place, &mut moved);
            }
        }
    }
}

/// Returns a point where two faces cross that share no vertex.
fn meeting(mesh: &Mesh, one: u32, other: u32) -> Option<DVec3> {
    let [a, b] = [one, other].map(|f| mesh.triangles()[f as usize]);
    if a.iter().any(|v| b.contains(v)) {
        return None;
    }
    crossing(mesh.corners(one as usize), mesh.corners(other as usize))
}

/// The depth, in units of the larger face, up to which faces only touch.
const TOUCHING: f64 = 1e-9;

/// Returns the middle of the segment that two triangles have in common.
fn crossing(p: [DVec3; 3], q: [DVec3; 3]) -> Option<DVec3> {
    let (m, n) = (normal(p)?, normal(q)?);
    let all = Aabb::of_points(p.into_iter().chain(q));
    let size = Aabb::of_points(p).extent().max(Aabb::of_points(q).extent()).max_element();
    let largest = all.min.abs().max(all.max.abs()).max_element();
    let tolerance = TOUCHING * size + 8.0 * f64::EPSILON * largest;
    let along = m.cross(n).try_normalize()?;
    let [a, b] = within(p, q[0], n, along, tolerance)?;
    let [c, d] = within(q, p[0], m, along, tolerance)?;
    let start = if a.dot(along) > c.dot(along) { a } else { c };
    let end = if b.dot(along) < d.dot(along) { b } else { d };
    ((end - start).dot(along) > tolerance).then(|| 0.5 * (start + end))
}

fn normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    (b - a).cross(c - a).try_normalize()
}

/// Returns the ends, in the direction `along`, of the piece of a plane within a triangle that has
/// corners on both its sides.
fn within(
    corners: [DVec3; 3],
    on: DVec3,
    normal: DVec3,
    along: DVec3,
    tolerance: f64,
) -> Option<[DVec3; 2]> {
    let heights = corners.map(|p| {
        let height = normal.dot(p - on);
        if height.abs() <= tolerance { 0.0 } else { height }
    });
    if !(heights.iter().any(|&h| h < 0.0) && heights.iter().any(|&h| h > 0.0)) {
        return None;
    }
    let met = [(0, 1), (1, 2), (2, 0)].into_iter().filter_map(|(i, j)| {
        let (from, to) = (heights[i], heights[j]);
        let is_across = from < 0.0 && to > 0.0 || from > 0.0 && to < 0.0;
        let point = || corners[i] + from / (from - to) * (corners[j] - corners[i]);
        if from == 0.0 { Some(corners[i]) } else { is_across.then(point) }
    });
    let by_place = |a: &DVec3, b: &DVec3| a.dot(along).total_cmp(&b.dot(along));
    Some([met.clone().min_by(by_place)?, met.max_by(by_place)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn joined(one: &Mesh, other: &Mesh) -> Mesh {
        let shift = one.positions().len() as u32;
        let positions = one.positions().iter().chain(other.positions()).copied().collect();
        let moved = other.triangles().iter().map(|t| t.map(|v| v + shift));
        Mesh::new(positions, one.triangles().iter().copied().chain(moved).collect())
            .expect("in range")
    }

    fn found_in(mesh: &Mesh) -> SelfIntersections {
        SelfIntersections::of(mesh).expect("finite")
    }

    #[test]
    fn nothing_crosses_in_empty_and_clean_meshes() {
        for mesh in [
            Mesh::default(),
            shapes::cube(),
            shapes::sphere(4),
            shapes::u_shape(),
            shapes::torus(12, 9),
        ] {
            assert_eq!(found_in(&mesh), SelfIntersections::default());
        }
        let nan =
            Mesh::new(vec![DVec3::NAN, DVec3::X, DVec3::Y], vec![[0, 1, 2]]).expect("in range");
        assert!(SelfIntersections::of(&nan).is_err());
    }

    #[test]
    fn faces_that_touch_do_not_cross() {
        // Side by side on one plane; the same place without shared vertices; a tip on a face.
        let cube = shapes::cube();
        assert_eq!(found_in(&joined(&cube, &cube.translated(DVec3::X))).pairs, 0);
        assert_eq!(found_in(&joined(&cube, &cube.translated(DVec3::new(1.0, 0.3, 0.2)))).pairs, 0);
        assert_eq!(found_in(&joined(&cube, &cube)).pairs, 0);
        let tip = Mesh::new(
            vec![DVec3::new(0.3, 0.3, 1.0), DVec3::new(0.0, 0.0, 2.0), DVec3::new(1.0, 0.0, 2.0)],
            vec![[0, 1, 2]],
        );
        assert_eq!(found_in(&joined(&cube, &tip.expect("in range"))).pairs, 0);
    }

    /// Big triangles through one line, as many as are asked for.
    fn fan(count: usize) -> Mesh {
        let corners = |i: usize| {
            let (sine, cosine) = (i as f64).sin_cos();
            let side = DVec3::new(cosine, sine, 0.0);
            [side - DVec3::Z, side + DVec3::Z, -2.0 * side]
        };
        let positions = (0..count).flat_map(corners).collect();
        let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Mesh::new(positions, triangles).expect("in range")
    }

    #[test]
    fn layers_that_share_their_vertices_are_one() {
        // 10^10 pairs, were each looked at.
        let layers = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]; 100_000]);
        assert_eq!(found_in(&layers.expect("in range")), SelfIntersections::default());
        let mut two = joined(&fan(1), &fan(2)).triangles().to_vec();
        two.resize(50_003, two[2]);
        let two = Mesh::new(joined(&fan(1), &fan(2)).positions().to_vec(), two);
        assert_eq!(found_in(&two.expect("in range")).faces, [0, 1, 2]);
    }

    #[test]
    fn too_many_layers_are_told() {
        let mesh = fan(100);
        let found = SelfIntersections::within(&mesh, 10_000).expect("few enough");
        assert_eq!(found.pairs, 4950);
        let error = SelfIntersections::within(&mesh, 9_000).expect_err("too many").to_string();
        assert!(error.contains("more than 9000 pairs") && error.contains("crossings"), "{error}");
    }

    #[test]
    fn crossing_bodies_are_found_where_they_cross() {
        let one = shapes::sphere(3);
        let both = joined(&one, &one.translated(DVec3::new(0.9, 0.1, 0.05)));
        let found = found_in(&both);
        assert!(found.pairs > 0 && found.faces.is_sorted() && found.examples.len() == 3);
        assert_eq!(found.pairs, brute_force(&both));
        for Crossing { faces, point } in found.examples {
            assert!(faces[0] < 512 && faces[1] >= 512, "{faces:?}");
            // Both spheres have the point, but for the 1 - cos of half a face's width.
            assert!((point.length() - 1.0).abs() <= 0.02, "{point}");
        }
    }

    #[test]
    fn face_through_its_own_surface_is_found() {
        // A vertex of a cube drawn through the opposite side.
        let cube = shapes::cube();
        let mut positions = cube.positions().to_vec();
        positions[7] = DVec3::new(-0.5, 0.5, 0.4);
        let mesh = Mesh::new(positions, cube.triangles().to_vec()).expect("in range");
        let found = found_in(&mesh);
        assert_eq!(found.pairs, brute_force(&mesh));
        assert!(found.pairs > 0);
    }

    fn brute_force(mesh: &Mesh) -> usize {
        let faces = mesh.triangles().len() as u32;
        let pairs = (0..faces).flat_map(|a| (a + 1..faces).map(move |b| (a, b)));
        pairs.filter(|&(a, b)| meeting(mesh, a, b).is_some()).count()
    }
}
