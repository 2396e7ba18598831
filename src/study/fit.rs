//! A mesh becomes the coefficients of its radius: checks, centre, projection, error.

use std::time::{Duration, Instant};

use glam::DVec3;

use crate::Result;
use crate::sh::Coefficients;
use crate::surface::{
    Mesh, MeshReport, MeshSurface, RadialError, project_conforming, project_grid, radial_error,
    star,
};

/// Chooses how the mesh is projected onto the basis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Projection {
    /// Quadrature on the faces themselves: exact to about 1e-10.
    #[default]
    Conforming,
    /// Ray casting on a Gauss-Legendre grid this many times finer than the degree needs.
    Grid {
        /// At least 1; 4 aliases to about 1e-4.
        oversampling: usize,
    },
}

/// Sets a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitSettings {
    /// The truncation degree.
    pub lmax: usize,
    /// How the mesh is projected.
    pub projection: Projection,
    /// The expansion centre in the axes of the mesh; chosen when `None`.
    pub centre: Option<DVec3>,
}

/// Holds a fitted shape and how good it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The series of the radius, in the unit of the mesh.
    pub coefficients: Coefficients,
    /// The expansion centre.
    pub centre: DVec3,
    /// The least distance from the centre to the plane of a face.
    pub clearance: f64,
    /// How far the series is from the mesh.
    pub error: RadialError,
    /// The time the projection took, checks and error measurement apart.
    pub projection_time: Duration,
    /// Vertices and faces of the mesh.
    pub mesh_size: [usize; 2],
}

impl Fit {
    /// Gives the RMS error relative to the mean radius.
    pub fn relative_rms(&self) -> f64 {
        self.error.rms / self.coefficients.mean()
    }

    /// Gives the largest error relative to the mean radius.
    pub fn relative_max(&self) -> f64 {
        self.error.max / self.coefficients.mean()
    }
}

/// Gives the bytes of an indexed triangle mesh in f32 and u32.
pub const fn mesh_bytes([vertices, faces]: [usize; 2]) -> usize {
    12 * vertices + 12 * faces
}

/// Gives the bytes of the coefficients of degree `lmax` in f32.
pub const fn series_bytes(lmax: usize) -> usize {
    4 * (lmax + 1) * (lmax + 1)
}

/// Fits a mesh about the given centre; without one about its own origin if it is star-shaped about that, else about the
/// centre that [`star::preferred_centre`] proposes.
///
/// # Errors
/// [`crate::Error::Geometry`] when the mesh is not closed and oriented or not star-shaped about the centre; [`crate::Error::Parameter`] for a degree
/// too high to evaluate.
pub fn fit(mesh: &Mesh, settings: &FitSettings) -> Result<Fit> {
    MeshReport::of(mesh).require_closed()?;
    let report = star::require(mesh, choose_centre(mesh, settings.centre)?)?;
    let centre = report.about;
    let started = Instant::now();
    let coefficients = match settings.projection {
        Projection::Conforming => project_conforming(mesh, centre, settings.lmax)?,
        Projection::Grid { oversampling } => {
            project_grid(&MeshSurface::new(mesh.clone())?, centre, settings.lmax, oversampling)?
        }
    };
    let projection_time = started.elapsed();
    Ok(Fit {
        error: radial_error(mesh, centre, &coefficients)?,
        coefficients,
        centre,
        clearance: report.clearance,
        projection_time,
        mesh_size: [mesh.positions().len(), mesh.triangles().len()],
    })
}

fn choose_centre(mesh: &Mesh, wanted: Option<DVec3>) -> Result<DVec3> {
    if let Some(centre) = wanted {
        return Ok(centre);
    }
    if star::test(mesh, DVec3::ZERO)?.is_star_shaped() {
        return Ok(DVec3::ZERO);
    }
    let (centre, clearance) = star::preferred_centre(mesh)?;
    // Without any valid centre the message about the origin is the more useful one.
    Ok(if clearance > 0.0 { centre } else { DVec3::ZERO })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(centre: DVec3) -> Mesh {
        let corner = |i: usize| {
            centre + DVec3::from_array([i & 1, (i >> 1) & 1, i >> 2].map(|b| 2.0 * b as f64 - 1.0))
        };
        let faces = vec![
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
        Mesh::new((0..8).map(corner).collect(), faces).expect("valid")
    }

    const SETTINGS: FitSettings =
        FitSettings { lmax: 8, projection: Projection::Conforming, centre: None };

    #[test]
    fn origin_is_kept_when_it_will_do_and_left_when_not() {
        let about_origin = fit(&cube(DVec3::splat(0.2)), &SETTINGS).expect("star-shaped");
        assert_eq!(about_origin.centre, DVec3::ZERO);
        let far = DVec3::new(5.0, 0.0, 0.0);
        let moved = fit(&cube(far), &SETTINGS).expect("star-shaped");
        assert!((moved.centre - far).length() <= 1e-5 && (moved.clearance - 1.0).abs() <= 1e-5);
        // The cube's volume is 8; truncation at degree 8 takes some tenths of a percent.
        let volume = crate::sh::volume(&moved.coefficients).expect("degree 8");
        assert!((volume - 8.0).abs() <= 0.04, "{volume}");
    }

    #[test]
    fn a_centre_outside_is_refused_with_a_better_one() {
        let settings = FitSettings { centre: Some(DVec3::splat(3.0)), ..SETTINGS };
        let error = fit(&cube(DVec3::ZERO), &settings).expect_err("outside");
        assert!(error.to_string().contains("star-shaped about"), "{error}");
    }

    #[test]
    fn an_open_mesh_is_refused() {
        let cube = cube(DVec3::ZERO);
        let open =
            Mesh::new(cube.positions().to_vec(), cube.triangles()[1..].to_vec()).expect("valid");
        assert!(matches!(fit(&open, &SETTINGS), Err(crate::Error::Geometry(_))));
    }
}
