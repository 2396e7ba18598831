//! A mesh becomes the coefficients of its radius: checks, centre, projection, error.

use std::time::{Duration, Instant};

use glam::DVec3;

use crate::error::Advice;
use crate::fit::{
    Envelope, FitError, Folds, RadialMesh, fit_error, least_folded, project_faces, project_rays,
    star,
};
use crate::mesh::{Mesh, MeshReport};
use crate::sh::{Coefficients, Filter, scattered_fit};
use crate::{Error, Result};

/// Chooses how the mesh is projected onto the basis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Projection {
    /// Quadrature on the faces themselves: exact to about 1e-10.
    #[default]
    Conforming,
    /// Ray casting on a Gauss-Legendre grid this many times finer than the degree needs.
    Grid {
        /// At least 1; 4 aliases to about 1e-4.
        oversampling: usize,
    },
    /// Least squares over the vertices, each weighted by the solid angle around it: errs by about
    /// the RMS error of the fit times the root of coefficients over vertices.
    LeastSquares {
        /// Tikhonov's factor, at least 0: see [`scattered_fit`].
        lambda: f64,
    },
}

/// Says what to do with a mesh that no centre sees as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoldPolicy {
    /// Which radius stands for a ray that meets the mesh more than once.
    pub envelope: Envelope,
    /// The largest share, 0 to 1, of such rays that is accepted.
    pub limit: f64,
}

/// Chooses the expansion centre, by the same rule for every shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Centre {
    /// A point in the axes of the mesh.
    At(DVec3),
    /// The centroid of the enclosed volume; of points their weighted mean.
    Centroid,
    /// The point of the largest clearance, see [`star::best_centre`].
    Best,
}

/// Sets a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitSettings {
    /// The truncation degree.
    pub lmax: usize,
    /// How the mesh is projected.
    pub projection: Projection,
    /// The expansion centre; chosen when `None`, as [`fit`] says.
    pub centre: Option<Centre>,
    /// How a mesh that is not star-shaped is fitted; refused when `None`.
    pub not_star: Option<FoldPolicy>,
    /// Damps the series against ringing.
    pub filter: Option<Filter>,
}

impl FitSettings {
    /// Sets a fit of degree `lmax` with everything else as usual: conforming projection, chosen
    /// centre, star-shaped meshes only, no filter.
    pub const fn of_degree(lmax: usize) -> Self {
        let projection = Projection::Conforming;
        Self { lmax, projection, centre: None, not_star: None, filter: None }
    }
}

/// Holds a fitted shape and how good it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The series of the radius, in the unit of the mesh.
    pub coefficients: Coefficients,
    /// The expansion centre.
    pub centre: DVec3,
    /// The least distance from the centre to the plane of a face; negative for a mesh that is not
    /// star-shaped about it.
    pub clearance: f64,
    /// How far the series is from the mesh, or from its envelope.
    pub error: FitError,
    /// The truncation error by Parseval; `None` where the series is not the exact projection.
    pub parseval: Option<f64>,
    /// What was done about folds; `None` for a star-shaped mesh.
    pub folds: Option<Folds>,
    /// The time the projection took, checks and error measurement apart.
    pub projection_time: Duration,
    /// The vertices that faces use, and the faces.
    pub mesh_size: [usize; 2],
}

impl Fit {
    /// Returns the RMS error relative to the mean radius.
    pub fn relative_rms(&self) -> f64 {
        self.error.rms / self.coefficients.mean()
    }

    /// Returns the largest error relative to the mean radius.
    pub fn relative_max(&self) -> f64 {
        self.error.max / self.coefficients.mean()
    }

    /// Returns by how much the area of the series exceeds that of the mesh, or of its envelope,
    /// relative to that; negative where it is less.
    pub fn excess_area(&self) -> f64 {
        let [mesh, series] = self.error.area;
        series / mesh - 1.0
    }

    /// Whether the series rings: its area exceeds that of the mesh, or of its envelope, by more
    /// than a tenth. Truncation alone takes area away; what adds it are waves about jumps of the
    /// radius, as at the borders of folds, and they turn normals too.
    pub fn rings(&self) -> bool {
        self.excess_area() > RINGING
    }
}

/// The excess of area above which a series counts as ringing.
const RINGING: f64 = 0.1;

/// Returns the bytes of an indexed triangle mesh in f32 and u32; see [`Mesh::used_size`].
pub const fn mesh_bytes([vertices, faces]: [usize; 2]) -> usize {
    12 * vertices + 12 * faces
}

/// Returns the bytes of the coefficients of degree `lmax` in f32.
pub const fn series_bytes(lmax: usize) -> usize {
    4 * (lmax + 1) * (lmax + 1)
}

/// Fits a mesh about the given centre; without one about its own origin if it is star-shaped about
/// that, else about the centre that [`star::preferred_centre`] proposes.
///
/// A mesh that is star-shaped about no centre is fitted only when [`FitSettings::not_star`] says
/// how: about the one of origin, best centre and centroid from which the fewest directions meet it
/// more than once.
///
/// # Errors
/// [`Error::Geometry`] when the mesh is not closed and oriented or not star-shaped about the
/// centre, or its folds fill more of the sphere than is accepted; [`Error::Parameter`] for a degree
/// too high to evaluate.
pub fn fit(mesh: &Mesh, settings: &FitSettings) -> Result<Fit> {
    MeshReport::of(mesh).require_closed()?;
    let centre = choose_centre(mesh, settings)?;
    let report = star::test(mesh, centre)?;
    let radius = match settings.not_star {
        Some(rule) if !report.is_star_shaped() => RadialMesh::folded(mesh, centre, rule.envelope)?,
        _ => {
            star::require(mesh, centre).map_err(mention_envelopes)?;
            RadialMesh::star(mesh, centre)
        }
    };
    check_reach(mesh, centre)?;
    let folds = radius.folds();
    check_limit(folds, settings, centre)?;
    let started = Instant::now();
    let projected = project(&radius, settings)?;
    let projection_time = started.elapsed();
    let coefficients = settings.filter.map_or_else(|| projected.clone(), |f| f.apply(&projected));
    let error = fit_error(&radius, &coefficients)?;
    // What a grid aliases, or borders of folds lose, goes into the energy at first order, into the
    // error at second: Parseval is for exact projections.
    let is_exact = settings.filter.is_none()
        && folds.is_none()
        && settings.projection == Projection::Conforming;
    Ok(Fit {
        parseval: is_exact.then(|| error.by_parseval(&coefficients)),
        error,
        coefficients,
        centre,
        clearance: report.clearance,
        folds,
        projection_time,
        mesh_size: mesh.used_size(),
    })
}

/// How many times farther than the nearest vertex the farthest may be: beyond it the faces between
/// them are nearly radial, and no series follows.
const REACH: f64 = 1e6;

/// Rejects a mesh with a vertex lost far off, or beyond what squares and cubes of lengths can hold.
fn check_reach(mesh: &Mesh, centre: DVec3) -> Result<()> {
    let distances = || {
        mesh.triangles()
            .iter()
            .flatten()
            .map(|&v| (v, mesh.positions()[v as usize].distance(centre)))
    };
    let far = distances().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
    let near = distances().map(|d| d.1).fold(f64::INFINITY, f64::min);
    // A distance that is not a number must fail, too.
    if far.1 <= REACH * near && (1e-50..=1e50).contains(&far.1) {
        return Ok(());
    }
    Err(Error::Geometry(format!(
        "vertex {} (from 0) lies {:.3e} m from the centre {centre:.6}, the nearest {near:.3e} m: \
         no radius spans that; mend or remove the vertex, or give another centre or unit",
        far.0, far.1
    )))
}

fn project(radius: &RadialMesh, settings: &FitSettings) -> Result<Coefficients> {
    match settings.projection {
        Projection::Conforming => project_faces(radius, settings.lmax),
        Projection::Grid { oversampling } => project_rays(radius, settings.lmax, oversampling),
        Projection::LeastSquares { lambda } => {
            let samples = radius.vertex_samples();
            let (at, radii, weights) = (&samples.directions, &samples.radii, &samples.weights);
            scattered_fit(at, radii, weights, settings.lmax, lambda)
        }
    }
}

fn choose_centre(mesh: &Mesh, settings: &FitSettings) -> Result<DVec3> {
    match settings.centre {
        Some(Centre::At(centre)) => return Ok(centre),
        Some(Centre::Centroid) => return Ok(mesh.centroid(mesh.bounds().centre())),
        Some(Centre::Best) => return Ok(star::best_centre(mesh)?.0),
        None => {}
    }
    if star::test(mesh, DVec3::ZERO)?.is_star_shaped() {
        return Ok(DVec3::ZERO);
    }
    let (centre, clearance) = star::preferred_centre(mesh)?;
    if clearance > 0.0 {
        return Ok(centre);
    }
    let Some(_) = settings.not_star else {
        // Without any valid centre the message about the origin is the more useful one.
        return Ok(DVec3::ZERO);
    };
    least_folded(mesh, &[DVec3::ZERO, centre, mesh.centroid(mesh.bounds().centre())])?.ok_or_else(
        || {
            Error::Geometry(
            "neither the origin nor the best centre nor the centroid lies inside the mesh: give a \
             centre inside it".to_owned(),
        )
        },
    )
}

/// Says how to fit a mesh all the same.
fn mention_envelopes(error: Error) -> Error {
    match error {
        Error::Geometry(_) | Error::Advised { .. } => error.advise(Advice::FitEnvelope),
        other => other,
    }
}

fn check_limit(folds: Option<Folds>, settings: &FitSettings, centre: DVec3) -> Result<()> {
    let Some((folds, rule)) = folds.zip(settings.not_star) else { return Ok(()) };
    // A share that is not a number must fail, too.
    if folds.share <= rule.limit {
        return Ok(());
    }
    Err(Error::Geometry(format!(
        "{:.2} % of the directions from {centre:.6} meet the mesh more than once, more than the \
         {} % that are accepted: such a shape is hardly a radius",
        100.0 * folds.share,
        100.0 * rule.limit
    ))
    .advise(Advice::AcceptFolds))
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

    const SETTINGS: FitSettings = FitSettings::of_degree(8);

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
    fn rule_of_the_centre_holds_though_the_origin_would_do() {
        let mesh = cube(DVec3::splat(0.2));
        for rule in [Centre::Centroid, Centre::Best, Centre::At(DVec3::splat(0.2))] {
            let settings = FitSettings { centre: Some(rule), ..SETTINGS };
            let found = fit(&mesh, &settings).expect("star-shaped").centre;
            // The linear program is good to 1e-6 of the size.
            assert!((found - DVec3::splat(0.2)).length() <= 4e-6, "{rule:?}: {found}");
        }
    }

    #[test]
    fn a_centre_outside_is_refused_with_a_better_one() {
        let settings = FitSettings { centre: Some(Centre::At(DVec3::splat(3.0))), ..SETTINGS };
        let error = fit(&cube(DVec3::ZERO), &settings).expect_err("outside");
        assert!(error.to_string().contains("star-shaped about"), "{error}");
    }

    #[test]
    fn a_vertex_lost_far_off_is_refused() {
        for far in [1e8, 1e20, 1e110, 1e308] {
            let mut positions = cube(DVec3::ZERO).positions().to_vec();
            positions[7] = DVec3::splat(far);
            let mesh = Mesh::new(positions, cube(DVec3::ZERO).triangles().to_vec()).expect("valid");
            assert!(matches!(fit(&mesh, &SETTINGS), Err(crate::Error::Geometry(_))), "{far:e}");
        }
    }

    #[test]
    fn an_open_mesh_is_refused() {
        let cube = cube(DVec3::ZERO);
        let open =
            Mesh::new(cube.positions().to_vec(), cube.triangles()[1..].to_vec()).expect("valid");
        let error = fit(&open, &SETTINGS).expect_err("a face is missing").to_string();
        assert!(error.starts_with("the mesh does not enclose a volume: "), "{error}");
    }
}
