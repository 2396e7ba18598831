//! Where a mesh is not star-shaped about a point: the folds, and the share of the directions that
//! they touch.
//!
//! A direction is folded when its ray from the point meets the surface more than once, or first
//! from behind. The share is counted on a spiral of equal-area directions (a Fibonacci lattice);
//! its error is stated as that of as many directions drawn by chance, which the lattice undercuts.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rayon::prelude::*;

use crate::fit::star::{planes, seen_solid_angle};
use crate::math::Ray;
use crate::mesh::Mesh;
use crate::mesh::report::find;
use crate::surface::{MeshSurface, Surface};

/// Describes how far a mesh is from being star-shaped about a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Folds {
    /// The point, metres.
    pub about: DVec3,
    /// The share of all directions, 0 to 1, whose ray meets the surface more than once, or first
    /// from behind.
    pub share: f64,
    /// The share of all directions, 0 to 1, whose ray meets nothing: the mesh is open there, or the
    /// point outside.
    pub unmet: f64,
    /// The half width, at 95 %, of the interval about the larger of both shares.
    pub error: f64,
    /// The patches of faces that turn away, the one that fills the largest solid angle first.
    pub patches: Vec<Fold>,
}

/// Describes a patch of faces that turn away and hang together.
#[derive(Debug, Clone, PartialEq)]
pub struct Fold {
    /// Its faces, in ascending order.
    pub faces: Vec<u32>,
    /// Their area, m2.
    pub area: f64,
    /// The sum of their solid angles over 4 pi; faces behind each other count each.
    pub solid_angle: f64,
    /// The mean of its faces' middles, weighted by area, metres.
    pub middle: DVec3,
}

/// How many directions are tried unless another number is given.
pub const DIRECTIONS: usize = 1 << 18;

/// Finds the folds of a mesh about a point, metres, by as many directions.
///
/// ```
/// use glam::DVec3;
/// use harmolux::fit::star;
/// use harmolux::mesh::Mesh;
/// use harmolux::surface::MeshSurface;
/// let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// let mesh = Mesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
/// let folds = star::folds(&MeshSurface::new(mesh)?, DVec3::splat(0.1), star::DIRECTIONS);
/// assert_eq!((folds.share, folds.patches.len()), (0.0, 0));
/// # Ok::<(), harmolux::Error>(())
/// ```
pub fn folds(surface: &MeshSurface, about: DVec3, directions: usize) -> Folds {
    let count = directions.max(1);
    let (folded, unmet) = (0..count)
        .into_par_iter()
        .map(|i| met(surface, about, spiral(i, count)))
        .map(|meeting| (usize::from(meeting == Some(false)), usize::from(meeting.is_none())))
        .reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    let [share, unmet] = [folded, unmet].map(|n| n as f64 / count as f64);
    Folds {
        about,
        share,
        unmet,
        error: half_width(share.max(unmet), count),
        patches: patches(surface.mesh(), about),
    }
}

/// Returns direction `i` of a Fibonacci lattice of `count`.
fn spiral(i: usize, count: usize) -> DVec3 {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let z = 1.0 - (2 * i + 1) as f64 / count as f64;
    let (sine, cosine) = (TAU * (i as f64 * golden).fract()).sin_cos();
    let radius = (1.0 - z * z).sqrt();
    DVec3::new(radius * cosine, radius * sine, z)
}

/// Whether a direction meets the surface once, from inside; `None` when it meets nothing.
fn met(surface: &MeshSurface, about: DVec3, direction: DVec3) -> Option<bool> {
    let hit = surface.hit(&Ray::new(about, direction))?;
    Some(hit.normal.dot(direction) > 0.0 && !surface.blocked(&hit.leave(direction)))
}

/// Returns 1.96 standard errors of a share; of none among `count`, the 95 % bound 3 / count.
fn half_width(share: f64, count: usize) -> f64 {
    (1.96 * (share * (1.0 - share) / count as f64).sqrt()).max(3.0 / count as f64)
}

/// Groups the faces that turn away from a point by the vertices they share.
fn patches(mesh: &Mesh, about: DVec3) -> Vec<Fold> {
    let turned = || planes(mesh).filter(|p| p.clearance(about) <= 0.0);
    let mut parent: Vec<u32> = (0..mesh.positions().len() as u32).collect();
    for plane in turned() {
        let [a, b, c] = mesh.triangles()[plane.face];
        let root = find(&mut parent, a);
        for other in [b, c] {
            let other = find(&mut parent, other);
            parent[other as usize] = root;
        }
    }
    let mut place: Vec<Option<usize>> = vec![None; parent.len()];
    let mut patches: Vec<Fold> = Vec::new();
    for plane in turned() {
        let root = find(&mut parent, mesh.triangles()[plane.face][0]) as usize;
        let index = *place[root].get_or_insert(patches.len());
        if index == patches.len() {
            patches.push(Fold {
                faces: Vec::new(),
                area: 0.0,
                solid_angle: 0.0,
                middle: DVec3::ZERO,
            });
        }
        let patch = &mut patches[index];
        patch.faces.push(plane.face as u32);
        patch.area += plane.area;
        patch.solid_angle += seen_solid_angle(mesh.corners(plane.face), about).abs() / (4.0 * PI);
        patch.middle += plane.area * mesh.middle(plane.face);
    }
    for patch in &mut patches {
        patch.middle /= patch.area;
    }
    patches.sort_by(|a, b| b.solid_angle.total_cmp(&a.solid_angle));
    patches
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn about(mesh: Mesh, x: f64, y: f64, z: f64) -> Folds {
        folds(&MeshSurface::new(mesh).expect("a surface"), DVec3::new(x, y, z), DIRECTIONS)
    }

    #[test]
    fn star_shape_has_none() {
        let folds = about(shapes::sphere(3), 0.1, 0.2, 0.3);
        assert_eq!((folds.share, folds.unmet, folds.patches), (0.0, 0.0, vec![]));
        assert!(folds.error <= 2e-5);
    }

    #[test]
    fn open_mesh_lets_directions_out() {
        let cube = shapes::cube();
        let open =
            Mesh::new(cube.positions().to_vec(), cube.triangles()[2..].to_vec()).expect("in range");
        // One of six sides is missing.
        let folds = about(open, 0.5, 0.5, 0.5);
        assert!((folds.unmet - 1.0 / 6.0).abs() <= folds.error && folds.share == 0.0);
    }

    #[test]
    fn wall_of_the_other_arm_of_an_l_is_folded() {
        // The wall x = 1 (y from 1 to 3, z from 0 to 1) of the other arm turns away. It is 1.5 off;
        // a rectangle from the foot of the perpendicular to (y, z) fills atan(y z / (d sqrt(d^2 +
        // y^2 + z^2))).
        let folds = about(shapes::l_shape(), 2.5, 0.5, 0.5);
        let corner = |y: f64| (y * 0.5 / (1.5 * (2.25 + y * y + 0.25_f64).sqrt())).atan();
        let wall = 2.0 * (corner(2.5) - corner(0.5)) / (4.0 * PI);
        assert_eq!((folds.patches.len(), folds.patches[0].faces.len()), (1, 2));
        let patch = &folds.patches[0];
        assert!((patch.solid_angle - wall).abs() <= 1e-15 && (patch.area - 2.0).abs() <= 1e-15);
        assert!((patch.middle - DVec3::new(1.0, 2.0, 0.5)).length() <= 1e-15);
        // Every ray that meets the wall met the top before it and meets the far side behind it.
        assert!((folds.share - wall).abs() <= folds.error, "{} {wall}", folds.share);
        assert_eq!(folds.unmet, 0.0);
    }
}
