//! The scene as rays see it: the nearest object, what blocks a segment, and what stands at a hit.

use std::f64::consts::PI;

use glam::DVec3;

use crate::math::{Aabb, Ray, Rgb};
use crate::surface::{END_ROUNDING, Hit};
use crate::{Error, Result};

use super::index::Index;
use super::{Brdf, Emitter, Material, Object, PointLight};

/// Holds everything that light can meet or come from.
#[derive(Clone)]
pub struct Scene {
    pub(super) objects: Vec<Object>,
    pub(super) index: Index,
    lights: Vec<PointLight>,
    emitters: Vec<Emitter>,
    /// For each emitter those whose bounds touch its own; empty when none do.
    beside: Vec<Vec<usize>>,
    area: f64,
    diffuse: bool,
    mirrors: bool,
}

/// Describes a point of the scene where a path turns: the refined hit, whose it is, and the side it
/// is seen from.
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
    /// Returns the luminance, cd/m2, that the surface itself emits towards `outgoing`.
    pub fn emitted(&self) -> Rgb {
        if self.hit.normal.dot(self.outgoing) > 0.0 {
            self.material.exitance / PI
        } else {
            Rgb::BLACK
        }
    }

    /// Whether its place and its normal are numbers; light has no meaning at another.
    pub fn is_sound(&self) -> bool {
        self.hit.point.is_finite() && self.normal.is_finite()
    }

    /// Returns the reflection there.
    pub fn brdf(&self) -> &Brdf {
        &self.material.brdf
    }

    /// Returns the unit direction that a mirror here shows to `outgoing`, and how much of its
    /// light: `None` where nothing is mirrored, or from below the true surface.
    pub fn mirrored(&self) -> Option<(DVec3, Rgb)> {
        let reflectance = self.material.brdf.mirror();
        if reflectance.is_black() {
            return None;
        }
        let direction = 2.0 * self.outgoing.dot(self.normal) * self.normal - self.outgoing;
        let side = 1.0_f64.copysign(self.hit.normal.dot(self.outgoing));
        (side * self.hit.normal.dot(direction) > 0.0).then_some((direction, reflectance))
    }

    /// Returns the unit normal of the true surface on the side of `outgoing`.
    pub fn true_normal(&self) -> DVec3 {
        1.0_f64.copysign(self.hit.normal.dot(self.outgoing)) * self.hit.normal
    }

    /// Returns by how much the light that arrives from `outgoing` is stronger per area of the
    /// shading surface than of the true one; 1 where they are the same. What walks bring has to
    /// count it, as what is seen backwards is lit by the shading cosine (Veach 1997, section 5.3).
    pub fn arriving(&self) -> f64 {
        if self.is_flat() {
            return 1.0;
        }
        self.normal.dot(self.outgoing).max(0.0) / self.hit.normal.dot(self.outgoing).abs()
    }

    /// Returns by how much more light a walk carries on to `direction` than a sample by the shading
    /// normal says; `None` below the true surface.
    pub fn adjoint(&self, direction: DVec3) -> Option<f64> {
        if self.is_flat() {
            return Some(1.0);
        }
        let leaving = self.true_normal().dot(direction);
        let factor = self.arriving() * leaving / self.normal.dot(direction);
        (leaving > 0.0 && factor.is_finite()).then_some(factor)
    }

    /// Whether the shading normal is that of the surface.
    pub fn is_flat(&self) -> bool {
        self.hit.shading_normal == self.hit.normal
    }

    /// Returns the part of the luminance of white light, 0 to 1, that is reflected there towards
    /// `outgoing`, but for what is mirrored.
    pub fn albedo(&self) -> f64 {
        self.material.brdf.albedo(self.normal, self.outgoing)
    }
}

impl Scene {
    /// Puts a scene together.
    ///
    /// # Errors
    /// [`Error::Parameter`] when an object has no material or one that emits cannot be sampled by
    /// area (an infinite plane).
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
        let beside = beside(&objects, &emitters);
        Ok(Self { objects, index, lights, emitters, beside, area, diffuse, mirrors })
    }

    /// Returns the objects in the order of the scene file.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Returns the point lights.
    pub fn lights(&self) -> &[PointLight] {
        &self.lights
    }

    /// Returns the objects that emit.
    pub fn emitters(&self) -> &[Emitter] {
        &self.emitters
    }

    /// Whether all surfaces reflect diffusely.
    pub fn is_diffuse(&self) -> bool {
        self.diffuse
    }

    /// Whether any surface is a mirror, or in part one.
    pub fn has_mirrors(&self) -> bool {
        self.mirrors
    }

    /// Returns the total area of the bounded surfaces, m2.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Bounds the bounded objects.
    pub fn bounds(&self) -> Aabb {
        let finite = self.objects.iter().map(|o| o.surface.bounds()).filter(Aabb::is_finite);
        finite.fold(Aabb::EMPTY, Aabb::union)
    }

    /// Finds the first object along a ray, unrefined.
    ///
    /// Of surfaces that lie in one place, as far as rounding can tell, one that shines at the ray
    /// comes first, then one whose face is turned to the ray, then the one with the smaller area,
    /// then the one that reflects more, then the one with the lowest index.
    pub fn hit(&self, ray: &Ray) -> Option<(usize, Hit)> {
        self.index.hit(&self.objects, ray)
    }

    /// Answers a batch as [`Scene::hit`] answers one ray: `hits[i]` for `rays[i]`, both of the same
    /// length.
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

    /// Returns the emitter that a vertex lies on and all others that lie in the same place and
    /// shine at the same side: what is seen there is the sum of their light.
    pub fn shining<'a>(
        &'a self,
        vertex: &Vertex<'a>,
    ) -> impl Iterator<Item = Vertex<'a>> + use<'a> {
        let own = Some(*vertex).filter(|v| !v.emitted().is_black());
        let others: &[usize] = match own {
            Some(_) if !self.beside.is_empty() => {
                let number = self.emitters.iter().position(|e| e.object == vertex.object);
                number.map_or(&[], |number| &self.beside[number])
            }
            _ => &[],
        };
        let Vertex { hit, outgoing, .. } = *vertex;
        let of = move |object: &usize| self.coincident(*object, &hit, outgoing);
        own.into_iter().chain(others.iter().filter_map(of))
    }

    /// Returns the luminance, cd/m2, that all surfaces at the place of a vertex emit towards
    /// `outgoing`.
    pub fn emitted(&self, vertex: &Vertex) -> Rgb {
        self.shining(vertex).map(|v| v.emitted()).sum()
    }

    /// Describes the place of a hit on another object that shines there, too.
    fn coincident(&self, object: usize, hit: &Hit, outgoing: DVec3) -> Option<Vertex<'_>> {
        let side = 1.0_f64.copysign(hit.normal.dot(outgoing)) * hit.normal;
        let other = self.objects[object].surface.hit(&self.through(object, hit, side))?;
        Some(self.refined_vertex(object, &other, outgoing)).filter(|v| !v.emitted().is_black())
    }

    /// Makes the ray from the side of a unit vector through a hit, as long as another object may be
    /// off that lies in its place.
    fn through(&self, object: usize, hit: &Hit, side: DVec3) -> Ray {
        let reach = 2.0 * self.index.coincidence(object, hit);
        Ray::new(hit.point + reach * side, -side).up_to(2.0 * reach)
    }

    /// Returns the normal of another object where it lies in the place of a hit, and which of all
    /// objects counts there for rays from the outer side of the hit.
    pub fn in_place_of(&self, hit: &Hit, object: usize) -> Option<(DVec3, usize)> {
        let ray = self.through(object, hit, hit.normal);
        let other = self.objects[object].surface.hit(&ray)?;
        let (first, _) = self.hit(&ray)?;
        Some((other.normal, first))
    }

    /// Whether another object lies in the place of a hit and counts there instead, for rays from
    /// the side of the normal (`sign` 1) or from the other (-1).
    pub fn counts_before(&self, object: usize, hit: &Hit, sign: f64) -> bool {
        let ray = self.through(object, hit, sign * hit.normal);
        self.hit(&ray).is_some_and(|(first, _)| first != object)
    }

    /// Whether anything stands on the ray.
    pub fn blocked(&self, ray: &Ray) -> bool {
        self.index.blocked(&self.objects, ray)
    }

    /// Marks in `blocked`, which has the length of `rays`, the rays on which anything stands; a ray
    /// that is marked already is passed over.
    pub fn mark_blocked(&self, rays: &[Ray], blocked: &mut [bool]) {
        self.index.mark_blocked(&self.objects, rays, blocked);
    }

    /// Whether two surface points see each other; both ends leave their surfaces by the one
    /// self-intersection policy.
    pub fn sees(&self, a: &Hit, b: &Hit, direction: DVec3) -> bool {
        a.segment(b, direction).is_some_and(|ray| !self.blocked(&ray))
    }
}

/// Lists for each emitter the other emitting objects whose bounds touch its own; nothing when there
/// are none at all.
fn beside(objects: &[Object], emitters: &[Emitter]) -> Vec<Vec<usize>> {
    let bounds = |emitter: &Emitter| {
        let Aabb { min, max } = objects[emitter.object].surface.bounds();
        let rounding = END_ROUNDING * min.abs().max(max.abs()).max_element();
        Aabb { min: min - rounding, max: max + rounding }
    };
    let bounds: Vec<Aabb> = emitters.iter().map(bounds).collect();
    let beside = |i: usize| -> Vec<usize> {
        let others = (0..emitters.len()).filter(|j| *j != i);
        let touching = others.filter(|j| !bounds[i].intersection(bounds[*j]).is_empty());
        touching.map(|j| emitters[j].object).collect()
    };
    let all: Vec<Vec<usize>> = (0..emitters.len()).map(beside).collect();
    if all.iter().all(Vec::is_empty) { Vec::new() } else { all }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::primitives::Rectangle;

    fn grey() -> Material {
        Material::lambert(Rgb::grey(0.5)).expect("valid")
    }

    #[test]
    fn light_of_lamps_in_one_place_adds_up() {
        let lamp = |x: f64, size: f64, exitance: f64| {
            let (u, v) = (size * DVec3::Y, size * DVec3::X);
            let surface = Rectangle::new(DVec3::new(x, 0.0, 3.0), u, v).expect("valid");
            Object::new("lamp", surface, grey().emitting(Rgb::grey(PI * exitance)))
        };
        let objects = vec![lamp(0.0, 1.0, 1.0), lamp(0.5, 1.0, 20.0), lamp(0.7, 0.1, 300.0)];
        let scene = Scene::new(objects, vec![]).expect("valid");
        for (x, expected) in [(0.3, 1.0), (0.6, 21.0), (0.75, 321.0), (1.2, 20.0)] {
            let vertex = scene.vertex(&Ray::new(DVec3::new(x, 0.05, 0.0), DVec3::Z)).expect("met");
            let found = scene.emitted(&vertex).luminance();
            assert!((found - expected).abs() <= 1e-12 * expected, "{x}: {found}");
        }
        let above = scene.vertex(&Ray::new(DVec3::new(0.75, 0.05, 9.0), DVec3::NEG_Z));
        assert!(scene.emitted(&above.expect("met")).is_black());
    }
}
