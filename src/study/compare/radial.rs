//! The radial difference of two shapes about one centre.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::Subject;
use crate::fit::Shape;
use crate::fit::{RadialMesh, fit_error, project_conforming, star};
use crate::math::Ray;
use crate::mesh::{Mesh, MeshReport};
use crate::sh::{Grid, difference, synthesis};
use crate::surface::{MeshSurface, Surface};
use crate::{Error, Result};

/// Holds the difference of two radii over all directions, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadialDifference {
    /// The centre of both.
    pub centre: DVec3,
    /// The root mean square over the solid angle.
    pub rms: f64,
    /// The largest one found; between the directions looked at it may be a little larger.
    pub max: f64,
    /// The mean radius of the first and the second.
    pub mean_radii: [f64; 2],
}

/// Rings of the grid for two meshes; twice as many azimuths.
const RINGS: usize = 256;
/// How much finer than its degree needs the grid is on which two series are compared.
const OVERSAMPLING: usize = 4;
/// Centres this near, relative to the mean radius, are one: what the digits of a file keep.
const ONE_CENTRE: f64 = 1e-9;

/// Compares radii; the inner error is the reason why that is not possible.
pub(super) fn radial(a: Subject, b: Subject, centre: DVec3) -> Result<Result<RadialDifference>> {
    match (a, b) {
        (Subject::Series(a), Subject::Series(b)) => of_series(a, b),
        (Subject::Series(a), Subject::Mesh(b)) => of_both(a, b),
        (Subject::Mesh(a), Subject::Series(b)) => Ok(of_both(b, a)?.map(swapped)),
        (Subject::Mesh(a), Subject::Mesh(b)) => of_meshes(a, b, centre),
    }
}

fn swapped(difference: RadialDifference) -> RadialDifference {
    let [a, b] = difference.mean_radii;
    RadialDifference { mean_radii: [b, a], ..difference }
}

/// RMS by Parseval's theorem, the largest on a grid.
fn of_series(a: &Shape, b: &Shape) -> Result<Result<RadialDifference>> {
    let [fa, fb] = [&a.coefficients, &b.coefficients];
    let apart = a.centre.distance(b.centre);
    if apart > ONE_CENTRE * fa.mean() {
        return Ok(Err(Error::Geometry(format!("their centres are {apart:.3e} m apart"))));
    }
    let lmax = fa.lmax().max(fb.lmax());
    let apart = difference(fa, fb);
    let grid = Grid::gauss_legendre(OVERSAMPLING * (lmax + 1), 2 * OVERSAMPLING * (lmax + 1));
    let largest = synthesis(&apart, &grid)?.into_iter().fold(0.0, |m: f64, d| m.max(d.abs()));
    Ok(Ok(RadialDifference {
        centre: a.centre,
        rms: (apart.energy() / (4.0 * PI)).sqrt(),
        max: largest,
        mean_radii: [fa.mean(), fb.mean()],
    }))
}

/// By quadrature on the faces.
fn of_both(shape: &Shape, mesh: &Mesh) -> Result<Result<RadialDifference>> {
    if let Err(reason) = usable(mesh, shape.centre) {
        return Ok(Err(reason));
    }
    let error = fit_error(&RadialMesh::star(mesh, shape.centre), &shape.coefficients)?;
    let mean = project_conforming(mesh, shape.centre, 0)?.mean();
    Ok(Ok(RadialDifference {
        centre: shape.centre,
        rms: error.rms,
        max: error.max,
        mean_radii: [shape.coefficients.mean(), mean],
    }))
}

/// By rays from the centre.
fn of_meshes(a: &Mesh, b: &Mesh, centre: DVec3) -> Result<Result<RadialDifference>> {
    for (name, mesh) in [("first", a), ("second", b)] {
        if let Err(reason) = usable(mesh, centre) {
            let named = |e| Error::Geometry(format!("the {name}: {e}"));
            return Ok(Err(reason.map(named)));
        }
    }
    let [a, b] = [MeshSurface::new(a.clone())?, MeshSurface::new(b.clone())?];
    let grid = Grid::gauss_legendre(RINGS, 2 * RINGS);
    let radius = |mesh: &MeshSurface, i: usize| {
        let ray = Ray::new(centre, grid.direction(i)).up_to(f64::INFINITY);
        mesh.hit(&ray).map_or(0.0, |hit| hit.distance)
    };
    let radii: Vec<[f64; 2]> =
        (0..grid.len()).into_par_iter().map(|i| [radius(&a, i), radius(&b, i)]).collect();
    let mean = |value: &dyn Fn(&[f64; 2]) -> f64| {
        let terms = radii.iter().enumerate().map(|(i, r)| grid.solid_angle(i) * value(r));
        terms.sum::<f64>() / (4.0 * PI)
    };
    Ok(Ok(RadialDifference {
        centre,
        rms: mean(&|[a, b]| (a - b).powi(2)).sqrt(),
        max: radii.iter().fold(0.0, |m: f64, [a, b]| m.max((a - b).abs())),
        mean_radii: [mean(&|r| r[0]), mean(&|r| r[1])],
    }))
}

/// Says why a mesh has no radius about a centre, if it has none.
fn usable(mesh: &Mesh, centre: DVec3) -> Result<()> {
    MeshReport::of(mesh).require_closed()?;
    star::require(mesh, centre).map(drop)
}
