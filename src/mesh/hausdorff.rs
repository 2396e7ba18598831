//! The largest distance of the points of one mesh from another, enclosed by branch and bound.
//!
//! The distance from a face is a convex function, so over a triangle it is largest at a corner:
//! with F a face of the other mesh, no point of the triangle is farther from that mesh than the
//! corner that is farthest from F. F is tried for the faces nearest to the corners and to the
//! middle. The distance is also 1-Lipschitz. Triangles whose bound is above the largest distance
//! found so far by more than the width asked for are split in four; the others are settled. What is
//! found is a lower bound, the largest bound of the settled an upper one.

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::{Mesh, NearestPoint};

/// Encloses the largest distance of a mesh from another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FarthestPoint {
    /// The largest distance found, metres: the true one is not less.
    pub lower: f64,
    /// What the true one does not exceed, metres.
    pub upper: f64,
    /// Where the largest one was found.
    pub at: DVec3,
}

/// A point of the mesh, the distance of the other from it, and the place of the nearest face.
#[derive(Debug, Clone, Copy)]
struct Sample {
    point: DVec3,
    distance: f64,
    place: usize,
}

type Piece = [Sample; 3];

/// Pieces that may wait to be split: more are not worth the memory; the enclosure is then wider
/// than asked for.
const MOST: usize = 1 << 21;
/// How often a face may be split.
const ROUNDS: usize = 32;

/// Encloses max over the points of `mesh` of their distance from the mesh of `other`, within
/// `width`, metres, if memory allows.
///
/// Faces count, vertices without a face do not; a mesh without faces gives zero.
pub fn farthest_point(mesh: &Mesh, other: &NearestPoint, width: f64) -> FarthestPoint {
    let search = Search { other, width };
    let vertices: Vec<Sample> = mesh.positions().par_iter().map(|p| search.sample(*p)).collect();
    let mut pieces: Vec<Piece> =
        mesh.triangles().iter().map(|t| t.map(|v| vertices[v as usize])).collect();
    let mut found = FarthestPoint { lower: 0.0, upper: 0.0, at: DVec3::ZERO };
    for sample in pieces.iter().flatten() {
        raise(&mut found, sample);
    }
    for _ in 0..ROUNDS {
        let judged: Vec<(f64, Sample)> =
            pieces.par_iter().map(|piece| search.judge(piece, found.lower)).collect();
        for (_, middle) in &judged {
            raise(&mut found, middle);
        }
        let mut open = Vec::new();
        let mut open_upper = 0.0_f64;
        for (piece, (upper, _)) in pieces.iter().zip(&judged) {
            if *upper > found.lower + width {
                open.push(*piece);
                open_upper = open_upper.max(*upper);
            } else {
                found.upper = found.upper.max(*upper);
            }
        }
        if open.is_empty() {
            break;
        }
        if open.len() > MOST / 4 {
            found.upper = found.upper.max(open_upper);
            break;
        }
        pieces = open.par_iter().flat_map_iter(|piece| search.split(piece)).collect();
        for sample in pieces.iter().flatten() {
            raise(&mut found, sample);
        }
    }
    found.upper = found.upper.max(found.lower);
    found
}

fn raise(found: &mut FarthestPoint, sample: &Sample) {
    if sample.distance > found.lower {
        found.lower = sample.distance;
        found.at = sample.point;
    }
}

struct Search<'a> {
    other: &'a NearestPoint,
    width: f64,
}

impl Search<'_> {
    fn sample(&self, point: DVec3) -> Sample {
        let (place, _, squared) = self.other.search(point);
        Sample { point, distance: squared.sqrt(), place }
    }

    /// Bounds the distance over a piece, given a lower bound of the largest; gives the sample at
    /// its middle too, or a corner where none was needed.
    fn judge(&self, piece: &Piece, lower: f64) -> (f64, Sample) {
        let good = lower + self.width;
        let reach = |from: DVec3| piece.iter().map(|c| c.point.distance(from)).fold(0.0, f64::max);
        let lipschitz = piece.iter().map(|c| c.distance + reach(c.point)).fold(f64::MAX, f64::min);
        if lipschitz <= good {
            return (lipschitz, piece[0]);
        }
        let middle = self.sample(piece.iter().map(|c| c.point).sum::<DVec3>() / 3.0);
        let good = good.max(middle.distance + self.width);
        let mut upper = lipschitz.min(middle.distance + reach(middle.point));
        for place in [middle.place, piece[0].place, piece[1].place, piece[2].place] {
            if upper <= good {
                break;
            }
            let convex = piece.iter().map(|c| self.other.distance_from(place, c.point));
            upper = upper.min(convex.fold(0.0, f64::max));
        }
        (upper, middle)
    }

    fn split(&self, piece: &Piece) -> [Piece; 4] {
        let [a, b, c] = *piece;
        let [ab, bc, ca] =
            [[a, b], [b, c], [c, a]].map(|[p, q]| self.sample(0.5 * (p.point + q.point)));
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{cube, l_shape};

    fn enclosed(mesh: &Mesh, other: &Mesh, width: f64) -> FarthestPoint {
        let found = farthest_point(mesh, &NearestPoint::new(other).expect("faces"), width);
        assert!(found.lower <= found.upper && found.upper <= found.lower + width, "{found:?}");
        found
    }

    #[test]
    fn a_mesh_is_at_no_distance_from_itself() {
        assert_eq!(
            farthest_point(&Mesh::default(), &NearestPoint::new(&cube()).expect("faces"), 1.0)
                .upper,
            0.0
        );
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
}
