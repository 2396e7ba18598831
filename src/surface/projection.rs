//! From a mesh to the coefficients of its radius about a centre.
//!
//! Conforming to the mesh: with d omega = d_T dA / |x|^3, d_T the distance of the face's plane from the centre, the projection integral (eq. 16) becomes
//! a sum over faces of smooth integrals, A_lm = (2l+1)/(2 pi eps_m) sum_T d_T int_T Q_lm cos(m phi) / |x|^2 dA: no sampling error but that of the
//! quadrature. By a grid: rays cast on a Gauss-Legendre x equispaced grid; a mesh is not band-limited, so the grid must be oversampled.

use glam::DVec3;
use rayon::prelude::*;

use super::{Mesh, Surface};
use crate::math::Ray;
use crate::math::quadrature::Rule;
use crate::sh::{Coefficients, Grid, Moments, Series, analysis};
use crate::{Error, Result};

/// Faces that are added up together; fixed, so that sums do not depend on the number of threads.
const FACES_PER_TASK: usize = 512;

/// The largest number of points along each side of a face; one that wants more is split in four.
const FINEST: usize = 24;

/// How often a face may be split: enough for one that fills half the sphere at degree 1000.
const DEEPEST: usize = 8;

/// The most points along each side of a face at which an error is measured: enough for its mean square, whatever the degree.
const MEASURED: usize = 6;

/// A point of a face as a quadrature node on the sphere about the centre.
struct Node {
    /// From the centre to the point, a unit vector.
    direction: DVec3,
    radius: f64,
    solid_angle: f64,
}

/// Projects the radius of a mesh about `centre` onto the basis, face by face.
///
/// The mesh must be star-shaped about the centre, see [`super::star`]; faces seen from behind count negatively. The number of points per face follows
/// from its angular size times `lmax`, large faces being split; the error is about 1e-10 of the mean radius.
///
/// # Errors
/// [`Error::Parameter`] for a degree too high to evaluate.
pub fn project_conforming(mesh: &Mesh, centre: DVec3, lmax: usize) -> Result<Coefficients> {
    project_with(mesh, centre, lmax, |corners| points_per_side(corners, lmax))
}

fn project_with(
    mesh: &Mesh,
    centre: DVec3,
    lmax: usize,
    points: impl Fn(&[DVec3; 3]) -> usize + Sync,
) -> Result<Coefficients> {
    let rules = rules();
    let empty = Moments::new(lmax)?;
    let faces = mesh.triangles().len();
    let parts: Vec<Moments> = tasks(faces)
        .map(|range| {
            let mut moments = empty.clone();
            for face in range {
                let corners = mesh.corners(face).map(|x| x - centre);
                visit_face(corners, &points, &rules, DEEPEST, &mut |node| {
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
    Ok(total.coefficients())
}

/// Projects the outermost radius of a surface about `centre` by ray casting on a Gauss-Legendre grid of `oversampling * (lmax + 1)` rings and twice as
/// many azimuths. Oversampling 1 aliases to about 1e-3 on a head, 4 to 3e-5.
///
/// # Errors
/// [`Error::Geometry`] when a ray meets nothing: the surface has a hole or does not surround the centre.
pub fn project_grid(
    surface: &dyn Surface,
    centre: DVec3,
    lmax: usize,
    oversampling: usize,
) -> Result<Coefficients> {
    let rings = oversampling.max(1) * (lmax + 1);
    let grid = Grid::gauss_legendre(rings, 2 * rings);
    let bounds = surface.bounds();
    let reach = (bounds.max - centre).abs().max((bounds.min - centre).abs()).length() * 1.01;
    let cast = |i: usize| {
        let direction = grid.direction(i);
        // From outside inwards: the first hit is the outermost.
        let ray = Ray::new(centre + reach * direction, -direction).up_to(reach);
        surface.hit(&ray).map(|hit| (hit.point - centre).dot(direction)).ok_or(direction)
    };
    let radii: Result<Vec<f64>, DVec3> = (0..grid.len()).into_par_iter().map(cast).collect();
    let radii = radii.map_err(|direction| {
        Error::Geometry(format!(
            "no surface is met from the centre {centre} towards {direction:.3}; close the mesh or choose a centre inside it"
        ))
    })?;
    analysis(&radii, &grid, lmax)
}

/// Holds how far a series is from the mesh it stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadialError {
    /// The root mean square of the radial difference over the solid angle, metres.
    pub rms: f64,
    /// The largest radial difference found at the vertices and quadrature points of the mesh, metres.
    pub max: f64,
}

/// Measures the radial difference between a series and a mesh, both about `centre`.
///
/// # Errors
/// [`Error::Parameter`] for a degree too high to evaluate.
pub fn radial_error(
    mesh: &Mesh,
    centre: DVec3,
    coefficients: &Coefficients,
) -> Result<RadialError> {
    let series = Series::new(coefficients)?;
    let rules = rules();
    let lmax = coefficients.lmax();
    // What is measured is not needed to more than some digits, whatever the degree.
    let points = |corners: &[DVec3; 3]| match points_per_side(corners, lmax) {
        few @ ..=FINEST => few.min(MEASURED),
        many => many,
    };
    let parts: Vec<(f64, f64, f64)> = tasks(mesh.triangles().len())
        .map(|range| {
            let (mut squares, mut sphere, mut max) = (0.0, 0.0, 0.0_f64);
            for face in range {
                let corners = mesh.corners(face).map(|x| x - centre);
                visit_face(corners, &points, &rules, DEEPEST, &mut |node| {
                    let difference = node.radius - series.value(node.direction);
                    squares += node.solid_angle * difference * difference;
                    sphere += node.solid_angle;
                    max = max.max(difference.abs());
                });
            }
            (squares, sphere, max)
        })
        .collect();
    let (squares, sphere, inside) =
        parts.into_iter().fold((0.0, 0.0, 0.0_f64), |a, b| (a.0 + b.0, a.1 + b.1, a.2.max(b.2)));
    let at_vertices = mesh.positions().iter().filter_map(|x| {
        let (direction, radius) =
            (*x - centre).try_normalize().zip(Some((*x - centre).length()))?;
        Some((radius - series.value(direction)).abs())
    });
    Ok(RadialError { rms: (squares / sphere).sqrt(), max: at_vertices.fold(inside, f64::max) })
}

/// Splits the faces into tasks of fixed size.
fn tasks(faces: usize) -> impl IndexedParallelIterator<Item = std::ops::Range<usize>> {
    (0..faces.div_ceil(FACES_PER_TASK)).into_par_iter().map(move |task| {
        let first = task * FACES_PER_TASK;
        first..(first + FACES_PER_TASK).min(faces)
    })
}

/// Gives the Gauss-Legendre rules on [0, 1] with 0..=FINEST points (index 0 repeats 1).
fn rules() -> Vec<Rule> {
    (0..=FINEST).map(|n| Rule::gauss_legendre(n).on(0.0, 1.0)).collect()
}

/// Chooses the points along each side of a face: Gauss-Legendre converges once it has about one point per radian of the basis functions' phase, which
/// is lmax times the angle the face spans; a face seen edge-on adds the swing of 1/|x|^2.
fn points_per_side(corners: &[DVec3; 3], lmax: usize) -> usize {
    let [a, b, c] = corners;
    let span = a.angle_between(*b).max(b.angle_between(*c)).max(c.angle_between(*a));
    let radii = corners.map(DVec3::length);
    let swing = (radii[0].max(radii[1]).max(radii[2]) / radii[0].min(radii[1]).min(radii[2])).ln();
    // The last ten radians of phase stand for the turn of 1/|x|^2 itself.
    let points = 4.0 + (lmax as f64 + 10.0) * span + 8.0 * swing;
    if points.is_finite() { points as usize } else { FINEST }
}

/// Visits the quadrature nodes of a face, after splitting it at the middles of its edges as often as its size asks for.
fn visit_face(
    corners: [DVec3; 3],
    points: &impl Fn(&[DVec3; 3]) -> usize,
    rules: &[Rule],
    splits: usize,
    visit: &mut impl FnMut(Node),
) {
    let wanted = points(&corners);
    if wanted <= FINEST || splits == 0 {
        for_each_node(&corners, &rules[wanted.min(FINEST)], visit);
        return;
    }
    let [a, b, c] = corners;
    let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
    for quarter in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
        visit_face(quarter, points, rules, splits - 1, visit);
    }
}

/// Walks over the Duffy points of a face: the square collapsed onto the triangle, u towards the side opposite to the first corner.
fn for_each_node([a, b, c]: &[DVec3; 3], rule: &Rule, mut visit: impl FnMut(Node)) {
    // Twice the area times the distance of the plane from the centre.
    let volume = a.dot(b.cross(*c));
    for (u, weight_u) in rule.iter() {
        for (v, weight_v) in rule.iter() {
            let x = *a + u * ((*b - *a) + v * (*c - *b));
            let radius = x.length();
            if radius > 0.0 {
                visit(Node {
                    direction: x / radius,
                    radius,
                    solid_angle: volume * u * weight_u * weight_v / radius.powi(3),
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

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
    fn solid_angles_of_a_closed_mesh_fill_the_sphere() {
        let mesh = octahedron(2.0);
        let centre = DVec3::new(0.1, -0.2, 0.3);
        let rules = rules();
        let mut total = 0.0;
        for face in 0..8 {
            let corners = mesh.corners(face).map(|x| x - centre);
            for_each_node(&corners, &rules[FINEST], |node| total += node.solid_angle);
        }
        assert!((total - 4.0 * PI).abs() <= 1e-12);
    }

    #[test]
    fn mean_radius_of_the_octahedron_is_known() {
        // r = 1/(|x|+|y|+|z|) on the unit sphere; its mean by an independent fine product rule over one octant.
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
        // A cube seen from off its centre: splitting its twelve faces beforehand must change nothing.
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
    fn points_follow_the_angular_size() {
        let wide = [DVec3::X, DVec3::Y, DVec3::Z];
        let narrow = [DVec3::X, DVec3::new(1.0, 0.01, 0.0), DVec3::new(1.0, 0.0, 0.01)];
        assert!(points_per_side(&wide, 64) > FINEST);
        assert_eq!(points_per_side(&narrow, 32), 4);
    }
}
