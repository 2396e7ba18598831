//! One of two shapes that are compared: its mesh, its tree, its normals.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::Subject;
use crate::Result;
use crate::fit::{ChordError, Resolution, tessellate};
use crate::math::{Randomness, Stream};
use crate::mesh::{Mesh, MeshReport, NearestPoint};
use crate::sh::{Series, area, volume};
use crate::surface::{MeshSurface, SampleArea};

/// A shape made ready.
pub(super) struct Side {
    surface: MeshSurface,
    /// The series that the mesh stands for, and its centre.
    series: Option<(Series, DVec3)>,
    pub(super) tree: NearestPoint,
    pub(super) chord_error: Option<ChordError>,
    pub(super) volume: Option<f64>,
    pub(super) area: f64,
}

/// The seed of the points at which normals are compared.
const SEED: u64 = 2012;

impl Side {
    /// Makes a shape ready; a series through a mesh of this chord error.
    pub(super) fn new(subject: Subject, tolerance: f64) -> Result<Self> {
        match subject {
            Subject::Series(shape) => {
                let f = &shape.coefficients;
                let made = tessellate(f, shape.centre, Resolution::Adaptive { tolerance })?;
                Ok(Self {
                    chord_error: Some(made.chord_error),
                    series: Some((Series::new(f)?, shape.centre)),
                    volume: Some(volume(f)?),
                    area: area(f)?.value,
                    ..Self::of_mesh(made.mesh)?
                })
            }
            Subject::Mesh(mesh) => Self::of_mesh(mesh.clone()),
        }
    }

    fn of_mesh(mesh: Mesh) -> Result<Self> {
        let tree = NearestPoint::new(&mesh)?;
        let volume = MeshReport::of(&mesh).is_closed().then(|| mesh.volume());
        let surface = MeshSurface::new(mesh)?;
        let area = surface.area();
        Ok(Self { surface, series: None, tree, chord_error: None, volume, area })
    }

    pub(super) fn mesh(&self) -> &Mesh {
        self.surface.mesh()
    }

    /// Returns the outward normal of the shape at a point of its mesh.
    pub(super) fn normal(&self, point: DVec3, face: u32) -> DVec3 {
        match &self.series {
            Some((series, centre)) => series_point(series, *centre, point).1,
            None => self.mesh().normal(face as usize).unwrap_or(DVec3::ZERO),
        }
    }

    /// Returns point `i` of a sequence that fills the surface evenly by area, and the outward
    /// normal there.
    pub(super) fn sample(&self, i: u64) -> (DVec3, DVec3) {
        let u = Stream::new(Randomness::Sobol, SEED, i).next_2d();
        let hit = self.surface.sample_area(DVec2::from_array(u)).hit;
        match &self.series {
            Some((series, centre)) => series_point(series, *centre, hit.point),
            None => (hit.point, hit.normal),
        }
    }
}

/// Returns the point of a series in the direction of `point` and its outward normal, along f
/// omega - grad_S f.
fn series_point(series: &Series, centre: DVec3, point: DVec3) -> (DVec3, DVec3) {
    let direction = (point - centre).normalize();
    let jet = series.jet(direction);
    let normal = (jet.value * direction - jet.gradient).normalize();
    (centre + jet.value * direction, normal)
}

/// Returns the absolute mean radius of a series; of a mesh the radius of the ball of equal area.
pub(super) fn size(subject: Subject) -> f64 {
    match subject {
        Subject::Series(shape) => shape.coefficients.mean().abs(),
        Subject::Mesh(mesh) => (mesh.area() / (4.0 * PI)).sqrt(),
    }
}
