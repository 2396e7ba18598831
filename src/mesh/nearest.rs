//! The point of a mesh that is nearest to another: a binary tree of boxes over the faces, halved at
//! their median, walked nearest box first.
//!
//! All in f64. The tree for rays (`bvh`) answers another question and rounds its boxes to f32.

use glam::DVec3;

use crate::math::Aabb;
use crate::mesh::Mesh;
use crate::mesh::triangle::nearest_on_triangle;
use crate::{Error, Result};

/// Answers for a mesh which of its points is nearest.
#[derive(Debug, Clone)]
pub struct NearestPoint {
    /// The corners of the faces in the order of the leaves.
    corners: Vec<[DVec3; 3]>,
    /// The mesh's number of each of them.
    faces: Vec<u32>,
    nodes: Vec<Node>,
}

/// A point of a mesh and how far it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// The face it is on.
    pub face: u32,
    /// The point, metres.
    pub point: DVec3,
    /// Its distance from the point asked about, metres.
    pub distance: f64,
}

/// A box and what is in it.
#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Aabb,
    /// The first face of a leaf; else the number of the second child, the first child being the
    /// next node.
    first: u32,
    /// How many faces a leaf holds; 0 for a node with children.
    count: u32,
}

/// Faces a leaf may hold.
const LEAF: usize = 4;
/// The deepest tree over 2^32 faces has 33 levels; one child waits at each.
const WAITING: usize = 64;

impl NearestPoint {
    /// Prepares a mesh.
    ///
    /// # Errors
    /// [`Error::Geometry`] without faces, or when a vertex of a face is not finite.
    pub fn new(mesh: &Mesh) -> Result<Self> {
        let corners: Vec<[DVec3; 3]> =
            (0..mesh.triangles().len()).map(|face| mesh.corners(face)).collect();
        if corners.is_empty() {
            return Err(Error::Geometry("a mesh without faces has no nearest point".into()));
        }
        if let Some(face) = corners.iter().position(|c| !c.iter().all(|p| p.is_finite())) {
            return Err(Error::Geometry(format!(
                "face {face} has a vertex that is not finite; mend the mesh or leave the face out"
            )));
        }
        let mut faces: Vec<u32> = (0..corners.len() as u32).collect();
        let mut tree =
            Self { nodes: Vec::with_capacity(corners.len()), corners, faces: Vec::new() };
        tree.build(&mut faces, 0);
        tree.corners = faces.iter().map(|f| tree.corners[*f as usize]).collect();
        tree.faces = faces;
        Ok(tree)
    }

    /// Builds the node over these faces, which stand at `start` in the order of the leaves.
    fn build(&mut self, faces: &mut [u32], start: usize) {
        let corners = &self.corners;
        let bounds = Aabb::of_points(faces.iter().flat_map(|f| corners[*f as usize]));
        let number = self.nodes.len();
        self.nodes.push(Node { bounds, first: start as u32, count: faces.len() as u32 });
        if faces.len() <= LEAF {
            return;
        }
        let middle = |face: &u32| corners[*face as usize].into_iter().sum::<DVec3>();
        let spread = Aabb::of_points(faces.iter().map(middle)).extent();
        let axis = (0..3).fold(0, |best, k| if spread[k] > spread[best] { k } else { best });
        let half = faces.len() / 2;
        let key = |face: &u32| middle(face)[axis];
        faces.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        let (left, right) = faces.split_at_mut(half);
        self.build(left, start);
        self.nodes[number].first = self.nodes.len() as u32;
        self.nodes[number].count = 0;
        self.build(right, start + half);
    }

    /// Returns the corners of the face with this place in the tree's own order.
    fn face_at(&self, place: usize) -> &[DVec3; 3] {
        &self.corners[place]
    }

    /// Finds the nearest point; `point` must be finite.
    pub fn nearest(&self, point: DVec3) -> Nearest {
        let mut best = (0, self.corners[0][0], f64::INFINITY);
        let mut waiting = [(0_u32, 0.0); WAITING];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (number, squared) = waiting[count];
            if squared >= best.2 {
                continue;
            }
            let node = &self.nodes[number as usize];
            if node.count > 0 {
                let places = node.first as usize..(node.first + node.count) as usize;
                for place in places {
                    let candidate = nearest_on_triangle(point, *self.face_at(place));
                    let squared = candidate.distance_squared(point);
                    if squared < best.2 {
                        best = (place, candidate, squared);
                    }
                }
                continue;
            }
            let child = |number: u32| {
                (number, distance_squared(&self.nodes[number as usize].bounds, point))
            };
            let (mut near, mut far) = (child(number + 1), child(node.first));
            if far.1 < near.1 {
                (near, far) = (far, near);
            }
            waiting[count] = far;
            waiting[count + 1] = near;
            count += 2;
        }
        let (place, found, squared) = best;
        Nearest { face: self.faces[place], point: found, distance: squared.sqrt() }
    }

    /// Lists the faces that are within a distance of a point.
    pub(crate) fn faces_within(&self, point: DVec3, distance: f64) -> Vec<u32> {
        let is_near = |place: &usize| {
            point.distance(nearest_on_triangle(point, *self.face_at(*place))) <= distance
        };
        let mut near = Vec::new();
        let mut waiting = vec![0];
        while let Some(number) = waiting.pop() {
            let node = &self.nodes[number as usize];
            if distance_squared(&node.bounds, point) > distance * distance {
                continue;
            }
            if node.count == 0 {
                waiting.extend([node.first, number + 1]);
                continue;
            }
            let places = node.first as usize..(node.first + node.count) as usize;
            near.extend(places.filter(is_near).map(|place| self.faces[place]));
        }
        near
    }
}

fn distance_squared(bounds: &Aabb, point: DVec3) -> f64 {
    point.distance_squared(point.clamp(bounds.min, bounds.max))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Randomness, Stream};
    use crate::mesh::shapes::{cube, l_shape};

    fn points(count: u64) -> impl Iterator<Item = DVec3> {
        (0..count).map(|i| {
            let mut stream = Stream::new(Randomness::Sobol, 11, i);
            let [x, y] = stream.next_2d();
            6.0 * DVec3::new(x, y, stream.next_2d()[0]) - DVec3::splat(2.0)
        })
    }

    #[test]
    fn nothing_and_nan_are_refused() {
        assert!(NearestPoint::new(&Mesh::default()).is_err());
        let nan = Mesh::new(vec![DVec3::ZERO, DVec3::NAN, DVec3::Y], vec![[0, 1, 2]]);
        assert!(NearestPoint::new(&nan.expect("indices in range")).is_err());
    }

    #[test]
    fn equal_faces_are_no_trouble() {
        let mesh = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]; 100]);
        let tree = NearestPoint::new(&mesh.expect("indices in range")).expect("finite");
        assert_eq!(tree.nearest(DVec3::new(0.1, 0.1, 2.0)).distance, 2.0);
    }

    #[test]
    fn distance_from_a_cube_is_that_of_its_formula() {
        let tree = NearestPoint::new(&cube()).expect("a cube");
        for p in points(500) {
            let outside = p.clamp(DVec3::ZERO, DVec3::ONE).distance(p);
            let inside = p.min(DVec3::ONE - p).min_element();
            let exact = if outside > 0.0 { outside } else { inside };
            assert!((tree.nearest(p).distance - exact).abs() <= 1e-14, "{p}");
        }
    }

    #[test]
    fn tree_equals_brute_force() {
        let mesh = l_shape();
        let tree = NearestPoint::new(&mesh).expect("an L");
        for p in points(500) {
            let found = tree.nearest(p);
            let least = (0..mesh.triangles().len())
                .map(|f| nearest_on_triangle(p, mesh.corners(f)).distance(p))
                .fold(f64::MAX, f64::min);
            assert!((found.distance - least).abs() <= 1e-14);
            let mut near = tree.faces_within(p, 1.5);
            near.sort_unstable();
            let is_near =
                |f: &u32| nearest_on_triangle(p, mesh.corners(*f as usize)).distance(p) <= 1.5;
            let all = 0..mesh.triangles().len() as u32;
            assert_eq!(near, all.filter(is_near).collect::<Vec<_>>());
            let there = nearest_on_triangle(found.point, mesh.corners(found.face as usize));
            assert!(there.distance(found.point) <= 1e-14);
        }
    }
}
