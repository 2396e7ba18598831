//! One of two shapes that are compared: its mesh, its tree, its normals.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::Subject;
use super::smooth::{Foot, Smooth};
use crate::Result;
use crate::math::{Randomness, Stream};
use crate::mesh::{Mesh, MeshReport, NearestPoint};
use crate::sh::{area, volume};
use crate::surface::{MeshSurface, SampleArea};

/// A shape made ready.
pub(super) struct Side {
    surface: MeshSurface,
    /// The series that the mesh stands for.
    pub(super) smooth: Option<Smooth>,
    pub(super) tree: NearestPoint,
    pub(super) volume: Option<f64>,
    pub(super) area: f64,
}

/// The seed of the points at which normals are compared.
const SEED: u64 = 2012;

impl Side {
    /// Makes a shape ready; a series is looked for by a mesh.
    pub(super) fn new(subject: Subject) -> Result<Self> {
        match subject {
            Subject::Series(shape) => {
                let (smooth, mesh) = Smooth::new(shape)?;
                Ok(Self {
                    smooth: Some(smooth),
                    volume: Some(volume(&shape.coefficients)?),
                    area: area(&shape.coefficients)?.value,
                    ..Self::of_mesh(mesh)?
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
        Ok(Self { surface, smooth: None, tree, volume, area })
    }

    pub(super) fn mesh(&self) -> &Mesh {
        self.surface.mesh()
    }

    /// Finds the point of the shape that is nearest; on a series it may be another that is nearly
    /// as near.
    pub(super) fn foot(&self, point: DVec3) -> Foot {
        let near = self.tree.nearest(point);
        match &self.smooth {
            Some(smooth) => smooth.foot(point, smooth.direction(near.point), near.face),
            None => Foot {
                point: near.point,
                direction: DVec3::ZERO,
                face: near.face,
                distance: near.distance,
            },
        }
    }

    /// Returns the outward normal of the shape at a point of it.
    pub(super) fn normal(&self, at: &Foot) -> DVec3 {
        match &self.smooth {
            Some(smooth) => smooth.normal(at.direction),
            None => self.mesh().normal(at.face as usize).unwrap_or(DVec3::ZERO),
        }
    }

    /// Returns point `i` of a sequence that fills the surface evenly by area, and the outward
    /// normal there.
    pub(super) fn sample(&self, i: u64) -> (DVec3, DVec3) {
        let u = Stream::new(Randomness::Sobol, SEED, i).next_2d();
        let hit = self.surface.sample_area(DVec2::from_array(u)).hit;
        match &self.smooth {
            Some(smooth) => {
                let direction = smooth.direction(hit.point);
                (smooth.point(direction), smooth.normal(direction))
            }
            None => (hit.point, hit.normal),
        }
    }
}

/// Returns the absolute mean radius of a series; of a mesh the radius of the ball of equal area.
pub(super) fn size(subject: Subject) -> f64 {
    match subject {
        Subject::Series(shape) => shape.coefficients.mean().abs(),
        Subject::Mesh(mesh) => (mesh.area() / (4.0 * PI)).sqrt(),
    }
}
