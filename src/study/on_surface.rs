//! Sensors on the surfaces of objects: evenly by area, or at vertices, each as exact as its
//! surface.
//!
//! Even points are a lattice of the unit square under the area-preserving map of the surface
//! ([`crate::surface::SampleArea::uniform`]). Of n points, number i is in the i-th of n strips of
//! equal area, at frac(1/2 + i sqrt 2) of its width, and at frac(1/2 + i / golden ratio) along it:
//! a Fibonacci lattice that no symmetry of a mesh is in step with. It is the same on every machine
//! and for every number of threads.

use std::f64::consts::SQRT_2;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::grids;
use crate::Result;
use crate::fit::{Resolution, tessellate};
use crate::io::scene_file::{
    BoxFace, BoxSpec, ObjectSpec, SceneFile, SphereSpec, SurfaceLayout, SurfacePlace, SurfaceSpec,
};
use crate::math::Ray;
use crate::mesh::Mesh;
use crate::scene::{Measure, Object, Sensor};
use crate::sh::Coefficients;
use crate::surface::{Hit, Instance, MeshSurface, ShSurface};

/// The kinds of surface whose vertices can be asked for.
#[derive(Clone)]
pub(super) enum Form {
    /// A placed mesh.
    Mesh(Arc<Instance<MeshSurface>>),
    /// A placed SH body.
    Sh(Arc<Instance<ShSurface>>),
    /// Any other.
    Plain,
}

/// Sensors, and the faces that join them where they are vertices.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Laid {
    pub(super) sensors: Vec<Sensor>,
    pub(super) faces: Vec<[u32; 3]>,
}

/// Lays the sensors of a surface out; none where the surface cannot be sampled.
///
/// # Errors
/// As [`tessellate`], for more vertices than it makes.
pub(super) fn lay_out(
    spec: &SurfaceSpec,
    file: &SceneFile,
    object: &Object,
    form: &Form,
) -> Result<Laid> {
    match (spec.layout, &spec.place) {
        (SurfaceLayout::Even(count), SurfacePlace::Object(_)) => {
            let Some(area) = &object.area else { return Ok(Laid::default()) };
            Ok(even(count, |u| Sensor::on(&area.uniform(u), spec.measure)))
        }
        (SurfaceLayout::Even(count), SurfacePlace::Face { object, face }) => {
            let Some(ObjectSpec::Box(solid)) = file.objects.get(object) else {
                return Ok(Laid::default());
            };
            Ok(on_face(count, solid, *face, spec.measure))
        }
        (SurfaceLayout::Vertices, _) => match form {
            Form::Mesh(mesh) => Ok(vertices(mesh, spec.measure)),
            _ => Ok(Laid::default()),
        },
        (SurfaceLayout::Geodesic(least), place) => {
            let sphere = geodesic(least)?;
            let hit: Box<dyn Fn(DVec3) -> Option<Hit> + Sync> =
                match (form, file.objects.get(place.object())) {
                    (Form::Sh(body), _) => {
                        Box::new(|w| Some(body.world_hit(&body.inner().at(w.normalize()))))
                    }
                    (_, Some(ObjectSpec::Sphere(SphereSpec { centre, .. }))) => {
                        Box::new(|w| object.surface.hit(&Ray::new(*centre, w.normalize())))
                    }
                    _ => return Ok(Laid::default()),
                };
            let hits: Vec<Option<Hit>> = sphere.positions().par_iter().map(|w| hit(*w)).collect();
            let mut laid = joined(&hits, sphere.triangles(), spec.measure);
            // The faces of an inward sphere look inward too.
            if let Some(ObjectSpec::Sphere(SphereSpec { inward: true, .. })) =
                file.objects.get(place.object())
            {
                laid.faces.iter_mut().for_each(|face| face.swap(1, 2));
            }
            Ok(laid)
        }
    }
}

/// Puts a sensor at each point of the lattice.
fn even(count: u32, sensor: impl Fn(DVec2) -> Sensor + Sync) -> Laid {
    let sensors = (0..count).into_par_iter().map(|i| sensor(lattice(i, count)));
    Laid { sensors: sensors.collect(), faces: Vec::new() }
}

/// Returns point `i` of `count` of the unit square.
fn lattice(i: u32, count: u32) -> DVec2 {
    let (i, golden_ratio) = (f64::from(i), 0.5 * (1.0 + 5.0_f64.sqrt()));
    let along = (i + (0.5 + i * SQRT_2).fract()) / f64::from(count);
    DVec2::new(along, (0.5 + i / golden_ratio).fract())
}

fn on_face(count: u32, solid: &BoxSpec, face: BoxFace, measure: Measure) -> Laid {
    let field = grids::face_of(solid, face);
    even(count, |u| Sensor {
        measure,
        ..Sensor::plane(field.corner + u.x * field.edges[0] + u.y * field.edges[1], field.normal)
    })
}

/// Puts a sensor at each vertex that belongs to a face with an area.
fn vertices(mesh: &Instance<MeshSurface>, measure: Measure) -> Laid {
    let local = mesh.inner().vertices();
    let hits: Vec<Option<Hit>> =
        local.iter().map(|hit| hit.as_ref().map(|hit| mesh.world_hit(hit))).collect();
    joined(&hits, mesh.inner().mesh().triangles(), measure)
}

/// Makes sensors of the hits there are, and keeps the faces that have three of them.
fn joined(hits: &[Option<Hit>], faces: &[[u32; 3]], measure: Measure) -> Laid {
    let mut number = 0;
    let numbers: Vec<Option<u32>> = hits
        .iter()
        .map(|hit| {
            hit.as_ref()?;
            number += 1;
            Some(number - 1)
        })
        .collect();
    let renumbered = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|v| numbers[v as usize]);
        Some([a?, b?, c?])
    };
    Laid {
        sensors: hits.iter().flatten().map(|hit| Sensor::on(hit, measure)).collect(),
        faces: faces.iter().filter_map(renumbered).collect(),
    }
}

/// Makes the smallest geodesic sphere of `least` vertices at least: 10 n^2 + 2 for the frequency n.
fn geodesic(least: u32) -> Result<Mesh> {
    let frequency = (f64::from(least.saturating_sub(2)) / 10.0).sqrt().ceil().max(1.0) as usize;
    let mut ball = Coefficients::zeros(0);
    ball.set(0, 0, 1.0, 0.0);
    Ok(tessellate(&ball, DVec3::ZERO, Resolution::Icosphere { frequency })?.mesh)
}
