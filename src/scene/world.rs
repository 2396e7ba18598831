//! The scene as rays see it: the nearest object, what blocks a segment, and what stands at a hit.

use std::f64::consts::PI;

use glam::DVec3;

use crate::math::{Aabb, Ray, Rgb};
use crate::surface::Hit;
use crate::{Error, Result};

use super::index::Index;
use super::{Brdf, Emitter, Material, Object, PointLight};

/// Holds everything that light can meet or come from.
#[derive(Clone)]
pub struct Scene {
    objects: Vec<Object>,
    index: Index,
    lights: Vec<PointLight>,
    emitters: Vec<Emitter>,
    area: f64,
    diffuse: bool,
    mirrors: bool,
}

/// Describes a point of the scene where a path turns: the refined hit, whose it is, and the side it is seen from.
#[derive(Debug, Clone, Copy)]
pub struct Vertex<'a> {
    /// The refined hit.
    pub hit: Hit,
    /// The index of the object.
    pub object: usize,
    /// The material there.
    pub material: &'a Material,
    /// The unit direction back to where the ray came from.
    pub outgoing: DVec3,
    /// The shading normal, turned to the side of `outgoing`.
    pub normal: DVec3,
}

impl Vertex<'_> {
    /// Gives the luminance, cd/m2, that the surface itself emits towards `outgoing`.
    pub fn emitted(&self) -> Rgb {
        if self.hit.normal.dot(self.outgoing) > 0.0 {
            self.material.exitance / PI
        } else {
            Rgb::BLACK
        }
    }

    /// Gives the reflection there.
    pub fn brdf(&self) -> &Brdf {
        &self.material.brdf
    }

    /// Gives the unit direction that a mirror here shows to `outgoing`, and how much of its light: `None` where nothing is mirrored, or from below the
    /// true surface.
    pub fn mirrored(&self) -> Option<(DVec3, Rgb)> {
        let reflectance = self.material.brdf.mirror();
        if reflectance.is_black() {
            return None;
        }
        let direction = 2.0 * self.outgoing.dot(self.normal) * self.normal - self.outgoing;
        let side = 1.0_f64.copysign(self.hit.normal.dot(self.outgoing));
        (side * self.hit.normal.dot(direction) > 0.0).then_some((direction, reflectance))
    }

    /// Gives the part of the luminance of white light, 0 to 1, that is reflected there towards `outgoing`, but for what is mirrored.
    pub fn albedo(&self) -> f64 {
        self.material.brdf.albedo(self.normal, self.outgoing)
    }
}

impl Scene {
    /// Puts a scene together.
    ///
    /// # Errors
    /// [`Error::Parameter`] when an object has no material or one that emits cannot be sampled by area (an infinite plane).
    pub fn new(objects: Vec<Object>, lights: Vec<PointLight>) -> Result<Self> {
        let mut emitters = Vec::new();
        for (index, object) in objects.iter().enumerate() {
            if object.materials.is_empty() {
                return Err(Error::Parameter(format!("object `{}` has no material", object.name)));
            }
            if object.emits() {
                emitters.push(emitter(index, object)?);
            }
        }
        let area = objects.iter().filter_map(|o| o.area.as_ref()).map(|a| a.area()).sum();
        let mut materials = objects.iter().flat_map(|o| &o.materials);
        let diffuse = materials.all(|m| matches!(m.brdf, Brdf::Lambert { .. }));
        let mut materials = objects.iter().flat_map(|o| &o.materials);
        let mirrors = materials.any(|m| !m.brdf.mirror().is_black());
        let index = Index::new(&objects);
        Ok(Self { objects, index, lights, emitters, area, diffuse, mirrors })
    }

    /// Gives the objects in the order of the scene file.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Gives the point lights.
    pub fn lights(&self) -> &[PointLight] {
        &self.lights
    }

    /// Gives the objects that emit.
    pub fn emitters(&self) -> &[Emitter] {
        &self.emitters
    }

    /// Tells whether all surfaces reflect diffusely.
    pub fn is_diffuse(&self) -> bool {
        self.diffuse
    }

    /// Tells whether any surface is a mirror, or in part one.
    pub fn has_mirrors(&self) -> bool {
        self.mirrors
    }

    /// Gives the total area of the bounded surfaces, m2.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Bounds the bounded objects.
    pub fn bounds(&self) -> Aabb {
        let finite = self.objects.iter().map(|o| o.surface.bounds()).filter(Aabb::is_finite);
        finite.fold(Aabb::EMPTY, Aabb::union)
    }

    /// Finds the first object along a ray, unrefined; of several at exactly the same distance the one with the lowest index.
    pub fn hit(&self, ray: &Ray) -> Option<(usize, Hit)> {
        self.index.hit(&self.objects, ray)
    }

    /// Answers a batch as [`Scene::hit`] answers one ray: `hits[i]` for `rays[i]`, both of the same length.
    pub fn hits(&self, rays: &[Ray], hits: &mut [Option<(usize, Hit)>]) {
        self.index.hits(&self.objects, rays, hits);
    }

    /// Finds the first vertex along a ray, refined and ready to be shaded.
    pub fn vertex(&self, ray: &Ray) -> Option<Vertex<'_>> {
        let (object, hit) = self.hit(ray)?;
        Some(self.refined_vertex(object, &hit, -ray.direction))
    }

    /// Refines a hit of an object and describes it as seen from the direction `outgoing`.
    pub fn refined_vertex(&self, object: usize, hit: &Hit, outgoing: DVec3) -> Vertex<'_> {
        let hit = self.objects[object].surface.refine(hit);
        self.vertex_at(object, hit, outgoing)
    }

    /// Describes a refined hit of an object seen from the direction `outgoing`.
    pub fn vertex_at(&self, object: usize, hit: Hit, outgoing: DVec3) -> Vertex<'_> {
        let side = 1.0_f64.copysign(hit.normal.dot(outgoing));
        Vertex {
            hit,
            object,
            material: self.objects[object].material(&hit),
            outgoing,
            normal: side * hit.shading_normal,
        }
    }

    /// Tells whether anything stands on the ray.
    pub fn blocked(&self, ray: &Ray) -> bool {
        self.index.blocked(&self.objects, ray)
    }

    /// Marks in `blocked`, which has the length of `rays`, the rays on which anything stands; a ray that is marked already is passed
    /// over.
    pub fn mark_blocked(&self, rays: &[Ray], blocked: &mut [bool]) {
        self.index.mark_blocked(&self.objects, rays, blocked);
    }

    /// Tells whether two surface points see each other; both ends leave their surfaces by the one self-intersection policy.
    pub fn sees(&self, a: &Hit, b: &Hit, direction: DVec3) -> bool {
        a.segment(b, direction).is_some_and(|ray| !self.blocked(&ray))
    }
}

fn emitter(index: usize, object: &Object) -> Result<Emitter> {
    let Some(area) = &object.area else {
        return Err(Error::Parameter(format!(
            "object `{}` emits but is infinite; give the light to a bounded surface",
            object.name
        )));
    };
    let exitances = object.materials.iter().map(|m| m.exitance.luminance());
    let exitance = exitances.fold(0.0, f64::max);
    Ok(Emitter { object: index, power: exitance * area.area() })
}
