//! The star-shape test: does a point see every face of a mesh from inside, and which point sees
//! them best?
//!
//! The clearance of a point c is the least signed distance to the planes of the faces, min
//! n_i.(v_i - c); it is positive where c sees all faces, and is then the radius of the largest ball
//! about c that does. The planes are computed from the mesh whenever they are asked for: a table of
//! them would be several times as large as the mesh.

mod centre;
mod folds;

use std::f64::consts::PI;

use glam::DVec3;

use crate::error::Advice;
use crate::mesh::{Mesh, MeshReport};
use crate::{Error, Result};

pub use centre::{best_centre, centres, preferred_centre};
pub use folds::{DIRECTIONS, Fold, Folds, folds};

/// Describes how the faces of a mesh look from a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StarReport {
    /// The point, metres.
    pub about: DVec3,
    /// The least signed distance, metres, from the point to the plane of a face: positive if and
    /// only if the point sees every face from inside.
    pub clearance: f64,
    /// The face whose plane that is.
    pub worst_face: usize,
    /// The middle of that face, metres.
    pub worst_position: DVec3,
    /// How many faces turn away (or are seen edge-on).
    pub turned_faces: usize,
    /// Their share of the area, 0 to 1.
    pub turned_area: f64,
    /// The solid angle they fill over 4 pi; an upper bound, 0 to 1, of the share of directions that
    /// meet one of them.
    pub turned_solid_angle: f64,
    /// How many times the surface goes around the point: its signed solid angle over 4 pi. 1 for a
    /// closed surface around the point, less for an open one, 2 for two of them, one within the
    /// other.
    pub covering: f64,
}

impl StarReport {
    /// Whether no more than one surface goes around the point.
    fn covers_once(&self) -> bool {
        self.covering < 1.5
    }

    /// Whether the mesh is star-shaped about the point: the point sees every face from inside, and
    /// no face behind another.
    pub fn is_star_shaped(&self) -> bool {
        self.clearance > 0.0 && self.covers_once()
    }
}

/// Examines how the faces of a mesh look from `about`, metres. Faces without area are passed over.
///
/// # Errors
/// [`Error::Geometry`] when no face has an area or a vertex of one is not finite.
///
/// ```
/// use glam::DVec3;
/// use harmolux::fit::star;
/// use harmolux::mesh::Mesh;
/// let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// let mesh = Mesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
/// assert!(star::test(&mesh, DVec3::splat(0.1))?.is_star_shaped());
/// let (centre, clearance) = star::best_centre(&mesh)?;
/// // The inscribed ball of the corner of a cube: radius 1/(3 + sqrt 3).
/// assert!((clearance - 1.0 / (3.0 + 3.0_f64.sqrt())).abs() < 1e-6);
/// # Ok::<(), harmolux::Error>(())
/// ```
pub fn test(mesh: &Mesh, about: DVec3) -> Result<StarReport> {
    check_faces(mesh)?;
    let (mut area, mut turned_area, mut turned_faces) = (0.0, 0.0, 0);
    let (mut solid_angle, mut turned_solid_angle) = (0.0, 0.0);
    for plane in planes(mesh) {
        area += plane.area;
        let seen = seen_solid_angle(mesh.corners(plane.face), about);
        solid_angle += seen;
        if plane.clearance(about) <= 0.0 {
            turned_faces += 1;
            turned_area += plane.area;
            turned_solid_angle += seen.abs();
        }
    }
    let (worst, clearance) = least_clearance(mesh, about);
    Ok(StarReport {
        about,
        clearance,
        worst_face: worst,
        worst_position: mesh.middle(worst),
        turned_faces,
        turned_area: turned_area / area,
        turned_solid_angle: (turned_solid_angle / (4.0 * PI)).min(1.0),
        covering: solid_angle / (4.0 * PI),
    })
}

/// Asks for a mesh that is star-shaped about `about`.
///
/// # Errors
/// [`Error::Geometry`] when it is not, saying how much of it turns away, where most, and which
/// centre would do better, or that it is in pieces; and as [`test()`].
pub fn require(mesh: &Mesh, about: DVec3) -> Result<StarReport> {
    let report = test(mesh, about)?;
    if report.is_star_shaped() {
        return Ok(report);
    }
    if report.clearance > 0.0 {
        return Err(Error::Geometry(format!(
            "the mesh goes {:.0} times around {about:.6}, with pieces within one another",
            report.covering
        ))
        .advise(Advice::KeepLargestPiece));
    }
    let pieces = MeshReport::of(mesh).components;
    if pieces > 1 {
        let message = format!("{}; it is in {pieces} pieces", sentence(&report));
        return Err(Error::Geometry(message).advise(Advice::KeepLargestPiece));
    }
    let advice = match best_centre(mesh)? {
        (centre, clearance) if clearance > 0.0 => format!(
            "it is star-shaped about {centre:.6}, which every face clears by {clearance:.3e} m: \
             expand about that centre"
        ),
        (centre, clearance) => format!(
            "no centre sees all of it; the best, {centre:.6}, lies {:.3e} m behind a face: fit the \
             outer envelope about it, or remove the folds",
            -clearance
        ),
    };
    Err(Error::Geometry(format!("{}; {advice}", sentence(&report))))
}

/// Says what is wrong about a point.
fn sentence(report: &StarReport) -> String {
    format!(
        "the mesh is not star-shaped about {:.6}: {} faces with {:.3} % of the area and at most \
         {:.3} % of the directions turn away from it, the worst is face {} (from 0) at {:.6}, \
         whose plane has the point {:.3e} m on its outer side",
        report.about,
        report.turned_faces,
        100.0 * report.turned_area,
        100.0 * report.turned_solid_angle,
        report.worst_face,
        report.worst_position,
        -report.clearance
    )
}

/// The plane of a face: points x with normal.x = offset.
struct Plane {
    face: usize,
    normal: DVec3,
    corner: DVec3,
    area: f64,
}

impl Plane {
    /// Returns the signed distance from a point, positive on the inner side.
    fn clearance(&self, from: DVec3) -> f64 {
        self.normal.dot(self.corner - from)
    }
}

/// Returns the planes of all faces that have an area.
fn planes(mesh: &Mesh) -> impl Iterator<Item = Plane> {
    (0..mesh.triangles().len()).filter_map(|face| {
        let vector = mesh.area_vector(face);
        let normal = vector.try_normalize()?;
        Some(Plane { face, normal, corner: mesh.corners(face)[0], area: vector.length() })
    })
}

/// Asks for faces that can be judged: all vertices finite, and an area at all.
fn check_faces(mesh: &Mesh) -> Result<()> {
    let mut faces = 0..mesh.triangles().len();
    if let Some(face) = faces.find(|&f| mesh.corners(f).iter().any(|p| !p.is_finite())) {
        return Err(Error::Geometry(format!(
            "face {face} (from 0) has a vertex that is not finite; mend its coordinates or remove \
             the face"
        )));
    }
    mesh.require_measurable()?;
    if planes(mesh).next().is_none() {
        return Err(Error::Geometry(
            "no face of the mesh has an area, so no point can be said to see it; check the file"
                .to_owned(),
        ));
    }
    Ok(())
}

/// Finds the face whose plane a point clears least, and by how much.
fn least_clearance(mesh: &Mesh, from: DVec3) -> (usize, f64) {
    let all = planes(mesh).map(|p| (p.face, p.clearance(from)));
    all.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::NEG_INFINITY))
}

/// Returns the signed solid angle of a triangle (Van Oosterom and Strackee 1983), positive where
/// its inner side is seen.
pub(super) fn seen_solid_angle(corners: [DVec3; 3], from: DVec3) -> f64 {
    let [a, b, c] = corners.map(|p| p - from);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * a.dot(b.cross(c)).atan2(below)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn mesh_without_faces_or_with_nan_is_refused() {
        assert!(test(&Mesh::default(), DVec3::ZERO).is_err());
        assert!(best_centre(&Mesh::default()).is_err());
        let nan = Mesh::new(vec![DVec3::NAN, DVec3::X, DVec3::Y], vec![[0, 1, 2]]);
        assert!(best_centre(&nan.expect("indices in range")).is_err());
    }

    #[test]
    fn surface_within_another_is_no_star_shape() {
        let (outer, inner) = (shapes::sphere(2), shapes::sphere(2).scaled(0.5).expect("positive"));
        let shift = outer.positions().len() as u32;
        let positions = [outer.positions(), inner.positions()].concat();
        let moved = inner.triangles().iter().map(|t| t.map(|v| v + shift));
        let triangles = outer.triangles().iter().copied().chain(moved).collect();
        let both = Mesh::new(positions, triangles).expect("indices in range");
        let report = test(&both, DVec3::ZERO).expect("faces");
        assert!((report.covering - 2.0).abs() <= 1e-13 && report.clearance > 0.0);
        assert!(
            !report.is_star_shaped() && test(&outer, DVec3::ZERO).expect("faces").is_star_shaped()
        );
        let error = require(&both, DVec3::ZERO).unwrap_err().to_string();
        assert!(error.contains("goes 2 times around [0.000000"), "{error}");
    }

    #[test]
    fn flat_and_open_meshes_have_an_answer() {
        let flat = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]]);
        let (_, clearance) = best_centre(&flat.expect("indices in range")).expect("an answer");
        assert!(clearance.abs() <= 1e-12);
    }

    #[test]
    fn cube_is_star_shaped_about_inner_points_only() {
        let cube = shapes::cube();
        let inner = test(&cube, DVec3::new(0.2, 0.5, 0.6)).expect("faces");
        assert!(inner.is_star_shaped() && (inner.clearance - 0.2).abs() <= 1e-15);
        assert_eq!(
            (inner.turned_faces, inner.turned_area, inner.turned_solid_angle),
            (0, 0.0, 0.0)
        );
        // On a face: seen edge-on. Half a unit above: its solid angle is that of a cube's face, one
        // sixth.
        assert!(!test(&cube, DVec3::new(0.5, 0.5, 1.0)).expect("faces").is_star_shaped());
        let outer = test(&cube, DVec3::new(0.5, 0.5, 1.5)).expect("faces");
        assert_eq!((outer.clearance, outer.turned_faces), (-0.5, 2));
        assert!((outer.turned_area - 1.0 / 6.0).abs() <= 1e-15);
        assert!((outer.turned_solid_angle - 1.0 / 6.0).abs() <= 1e-15);
        assert_eq!(cube.normal(outer.worst_face), Some(DVec3::Z));
        assert_eq!(outer.worst_position.z, 1.0);
    }

    #[test]
    fn best_centre_of_a_cube_is_its_middle() {
        // Far away and small: the program works in the units of the mesh.
        let mesh = shapes::cube().scaled(1e-3).expect("positive").translated(DVec3::splat(100.0));
        let (centre, clearance) = best_centre(&mesh).expect("faces");
        assert!((centre - DVec3::splat(100.0 + 5e-4)).length() <= 1e-9);
        assert!((clearance - 5e-4).abs() <= 1e-9);
    }

    #[test]
    fn l_shape_is_star_shaped_about_its_inner_corner() {
        let l_shape = shapes::l_shape();
        let (centre, clearance) = best_centre(&l_shape).expect("faces");
        // The kernel is the unit cube.
        assert!((clearance - 0.5).abs() <= 1e-6 && (centre - DVec3::splat(0.5)).length() <= 1e-6);
        assert!(require(&l_shape, DVec3::splat(0.5)).is_ok());
        let error = require(&l_shape, DVec3::new(2.5, 0.5, 0.5)).unwrap_err().to_string();
        assert!(error.contains("2 faces with 9.091 % of the area"), "{error}");
        assert!(error.contains("it is star-shaped about [0.5"), "{error}");
    }

    #[test]
    fn u_shape_is_star_shaped_about_no_point() {
        let u_shape = shapes::u_shape();
        let (centre, clearance) = best_centre(&u_shape).expect("faces");
        // Its inner walls look at each other: x <= 1 and x >= 2 both, best half-way.
        assert!((clearance + 0.5).abs() <= 1e-6 && (centre.x - 1.5).abs() <= 1e-6);
        let error = require(&u_shape, DVec3::new(1.5, 0.5, 0.5)).unwrap_err().to_string();
        assert!(error.contains("no centre sees all of it"), "{error}");
        assert!(error.contains("fit the outer envelope"), "{error}");
    }
}
