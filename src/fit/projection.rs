//! From a mesh to the coefficients of its radius about a centre.
//!
//! Conforming to the mesh: with d omega = d_T dA / |x|^3, d_T the distance of the face's plane from
//! the centre, the projection integral (eq. 16) becomes a sum over faces of smooth integrals, A_lm
//! = (2l+1)/(2 pi eps_m) sum_T d_T int_T Q_lm cos(m phi) / |x|^2 dA: no sampling error but that of
//! the quadrature. By a grid: rays cast on a Gauss-Legendre x equispaced grid; a mesh is not
//! band-limited, so the grid must be oversampled.

use glam::DVec3;
use rayon::prelude::*;

use crate::fit::RadialMesh;
use crate::fit::face_nodes::{fold_faces, points_per_side};
use crate::math::Ray;
use crate::mesh::Mesh;
use crate::sh::{Coefficients, GRIDDED_FROM, Grid, GridMoments, MAX_DEGREE, Moments, analysis};
use crate::surface::Surface;
use crate::{Error, Result};

/// Grids that are filled side by side; fixed, so that sums do not depend on the number of threads.
/// At degree 1000 each takes 66 MB.
const GRIDS: usize = 4;

/// Projects the radius of a mesh about `centre` onto the basis, face by face.
///
/// The mesh must be star-shaped about the centre, see [`super::star`]; faces seen from behind count
/// negatively. The number of points per face follows from its angular size times `lmax`, large
/// faces being split; the error is about 1e-10 of the mean radius.
///
/// # Errors
/// [`Error::Parameter`] for a degree too high to evaluate.
pub fn project_conforming(mesh: &Mesh, centre: DVec3, lmax: usize) -> Result<Coefficients> {
    project_faces(&RadialMesh::star(mesh, centre), lmax)
}

/// Projects the radius of a mesh, or of its envelope, onto the basis, face by face.
///
/// Faces that belong to an envelope as a whole are as exact as those of a star-shaped mesh; what is
/// left is the error at the borders of folds, which [`RadialMesh::folds`] bounds in the mean.
///
/// # Errors
/// [`Error::Parameter`] for a degree too high to evaluate.
pub fn project_faces(radius: &RadialMesh, lmax: usize) -> Result<Coefficients> {
    if lmax >= GRIDDED_FROM {
        return project_gridded(radius, lmax);
    }
    let points = |corners: &[DVec3; 3]| points_per_side(corners, lmax);
    let empty = Moments::new(lmax)?;
    let task = |range: std::ops::Range<usize>| {
        let mut moments = empty.clone();
        for face in range {
            radius.visit(face, &points, &mut |node| {
                moments.add(node.direction, node.solid_angle * node.radius);
            });
        }
        moments
    };
    let mut total = empty.clone();
    fold_faces(radius.mesh().triangles().len(), task, |part| total.merge(&part));
    Ok(total.coefficients())
}

/// Does the same for high degrees, where nodes are many and adding each to all coefficients would
/// take hours.
fn project_gridded(radius: &RadialMesh, lmax: usize) -> Result<Coefficients> {
    if lmax > MAX_DEGREE {
        // Says that the degree is too high before any memory is taken.
        Moments::new(lmax)?;
    }
    let points = |corners: &[DVec3; 3]| points_per_side(corners, lmax);
    let empty = GridMoments::new(lmax);
    let faces = radius.mesh().triangles().len();
    let parts: Vec<GridMoments> = (0..GRIDS)
        .into_par_iter()
        .map(|part| {
            let mut moments = empty.clone();
            // Neighbours go to different parts, so that all have as much to do.
            for face in (part..faces).step_by(GRIDS) {
                radius.visit(face, &points, &mut |node| {
                    moments.add(node.direction, node.solid_angle * node.radius);
                });
            }
            moments
        })
        .collect();
    let mut total = empty;
    for part in &parts {
        total.merge(part);
    }
    drop(parts);
    total.coefficients()
}

/// Projects the outermost radius of a surface about `centre` by ray casting on a Gauss-Legendre
/// grid of `oversampling * (lmax + 1)` rings and twice as many azimuths. Oversampling 1 aliases to
/// about 1e-3 on a head, 4 to 3e-5.
///
/// # Errors
/// [`Error::Geometry`] when a ray meets nothing: the surface has a hole or does not surround the
/// centre.
pub fn project_grid(
    surface: &dyn Surface,
    centre: DVec3,
    lmax: usize,
    oversampling: usize,
) -> Result<Coefficients> {
    let bounds = surface.bounds();
    let reach = (bounds.max - centre).abs().max((bounds.min - centre).abs()).length() * 1.01;
    let outermost = |direction: DVec3| {
        // From outside inwards: the first hit is the outermost.
        let ray = Ray::new(centre + reach * direction, -direction).up_to(reach);
        surface.hit(&ray).map(|hit| (hit.point - centre).dot(direction))
    };
    project_radii(outermost, centre, lmax, oversampling)
}

/// Does the same for the envelope of a mesh; for one that was called star-shaped the outermost.
///
/// # Errors
/// As [`project_grid`], and as [`crate::surface::MeshSurface::new`].
pub fn project_rays(radius: &RadialMesh, lmax: usize, oversampling: usize) -> Result<Coefficients> {
    let Some(layers) = radius.layers() else {
        let surface = crate::surface::MeshSurface::new(radius.mesh().clone())?;
        return project_grid(&surface, radius.centre(), lmax, oversampling);
    };
    let envelope = |direction| layers.radius(direction).map(|found| found.0);
    project_radii(envelope, radius.centre(), lmax, oversampling)
}

fn project_radii(
    radius: impl Fn(DVec3) -> Option<f64> + Sync,
    centre: DVec3,
    lmax: usize,
    oversampling: usize,
) -> Result<Coefficients> {
    let rings = oversampling.max(1) * (lmax + 1);
    let grid = Grid::gauss_legendre(rings, 2 * rings);
    let cast = |i: usize| {
        let direction = grid.direction(i);
        radius(direction).ok_or(direction)
    };
    let radii: Result<Vec<f64>, DVec3> = (0..grid.len()).into_par_iter().map(cast).collect();
    let radii = radii.map_err(|direction| {
        Error::Geometry(format!(
            "no surface is met from the centre {centre} towards {direction:.3}; close the mesh or \
             choose a centre inside it"
        ))
    })?;
    analysis(&radii, &grid, lmax)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::fit::Envelope;
    use crate::math::quadrature::Rule;
    use crate::mesh::shapes;

    fn octahedron(radius: f64) -> Mesh {
        let p = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z]
            .map(|v| radius * v);
        let faces = vec![
            [0, 1, 4],
            [1, 2, 4],
            [2, 3, 4],
            [3, 0, 4],
            [1, 0, 5],
            [2, 1, 5],
            [3, 2, 5],
            [0, 3, 5],
        ];
        Mesh::new(p.to_vec(), faces).expect("valid")
    }

    #[test]
    fn mean_radius_of_the_octahedron_is_known() {
        // r = 1/(|x|+|y|+|z|) on the unit sphere; its mean by an independent fine product rule over
        // one octant.
        let c = project_conforming(&octahedron(1.0), DVec3::ZERO, 4).expect("degree 4");
        let rule = Rule::gauss_legendre(60);
        let (mu, phi) = (rule.clone().on(0.0, 1.0), rule.on(0.0, 0.5 * PI));
        let mut mean = 0.0;
        for (z, wz) in mu.iter() {
            let s = (1.0_f64 - z * z).sqrt();
            for (p, wp) in phi.iter() {
                mean += wz * wp / (s * (p.cos() + p.sin()) + z);
            }
        }
        // The square root at z = 1 limits the product rule to about 1e-7.
        assert!((c.mean() - mean / (0.5 * PI)).abs() <= 1e-6);
        assert!(c.get(1, 0).0.abs() <= 1e-14 && c.get(4, 4).1.abs() <= 1e-14);
    }

    #[test]
    fn faces_of_large_angular_size_are_integrated_as_well() {
        // A cube seen from off its centre: splitting its twelve faces beforehand must change
        // nothing.
        let corner = |i: usize| DVec3::new((i & 1) as f64, ((i >> 1) & 1) as f64, (i >> 2) as f64);
        let faces: Vec<[u32; 3]> = vec![
            [0, 2, 3],
            [0, 3, 1],
            [4, 5, 7],
            [4, 7, 6],
            [0, 1, 5],
            [0, 5, 4],
            [2, 6, 7],
            [2, 7, 3],
            [0, 4, 6],
            [0, 6, 2],
            [1, 3, 7],
            [1, 7, 5],
        ];
        let mut split = (Vec::new(), Vec::new());
        for face in &faces {
            let [a, b, c] = face.map(|i| corner(i as usize));
            let first = u32::try_from(split.0.len()).expect("small");
            split.0.extend([a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)]);
            let quarters: [[u32; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];
            split.1.extend(quarters.map(|q| q.map(|i| i + first)));
        }
        let whole = Mesh::new((0..8).map(corner).collect(), faces).expect("valid");
        let split = Mesh::new(split.0, split.1).expect("valid");
        let centre = DVec3::new(0.4, 0.5, 0.6);
        let [a, b] = [&whole, &split].map(|m| project_conforming(m, centre, 16).expect("fits"));
        let pairs = a.cosines().iter().chain(a.sines()).zip(b.cosines().iter().chain(b.sines()));
        let worst = pairs.fold(0.0_f64, |w, (x, y)| w.max((x - y).abs()));
        assert!(worst <= 1e-9, "{worst:e}");
    }

    #[test]
    fn envelope_of_a_star_shaped_mesh_is_the_mesh() {
        let mesh = octahedron(1.0);
        let centre = DVec3::new(0.1, 0.05, -0.1);
        let plain = project_conforming(&mesh, centre, 8).expect("fits");
        for envelope in [Envelope::Outermost, Envelope::First, Envelope::Mean] {
            let radius = RadialMesh::folded(&mesh, centre, envelope).expect("inside");
            let same = project_faces(&radius, 8).expect("fits");
            let pairs = same.cosines().iter().zip(plain.cosines());
            // Rays find the radius again to the last digit or two.
            assert!(pairs.fold(0.0_f64, |w, (x, y)| w.max((x - y).abs())) <= 1e-14, "{envelope}");
        }
    }

    #[test]
    fn envelopes_of_a_u_agree_with_those_of_many_rays() {
        let u = shapes::u_shape();
        // Mean radii by the U as a difference of boxes on a grid of 3000 x 6000 directions (NumPy),
        // good to about 1e-5.
        let envelopes = [Envelope::Outermost, Envelope::First, Envelope::Mean];
        for (envelope, mean) in envelopes.into_iter().zip([0.933_111, 0.819_465, 0.870_532]) {
            let centre = DVec3::new(1.5, 0.5, 0.5);
            let radius = RadialMesh::folded(&u, centre, envelope).expect("inside");
            let [faces, rays] = [
                project_faces(&radius, 6).expect("fits"),
                project_rays(&radius, 6, 64).expect("closed"),
            ];
            assert!((faces.mean() - mean).abs() <= 3e-4, "{envelope}: {}", faces.mean());
            let pairs = faces.cosines().iter().chain(faces.sines());
            let worst = pairs
                .zip(rays.cosines().iter().chain(rays.sines()))
                .fold(0.0_f64, |w, (x, y)| w.max((x - y).abs()));
            // The radius jumps at the folds: rays 0.4 degrees apart, not the faces, err by some
            // 6e-3 of it, twice that at 32.
            assert!(worst <= 1e-2 * faces.mean(), "{envelope}: {worst:e}");
        }
    }

    #[test]
    fn gridded_projection_is_the_plain_one() {
        let mesh = octahedron(1.0);
        let centre = DVec3::new(0.1, 0.05, -0.1);
        let (plain, gridded) = (GRIDDED_FROM - 1, GRIDDED_FROM);
        let [a, b] = [plain, gridded].map(|l| project_conforming(&mesh, centre, l).expect("fits"));
        let b = b.truncated(plain);
        let pairs = a.cosines().iter().chain(a.sines()).zip(b.cosines().iter().chain(b.sines()));
        let worst = pairs.fold(0.0_f64, |w, (x, y)| w.max((x - y).abs()));
        // Both err by 1e-10, the rules being those of two degrees.
        assert!(worst <= 1e-9, "{worst:e}");
        assert!(project_conforming(&mesh, centre, MAX_DEGREE + 1).is_err());
    }
}
