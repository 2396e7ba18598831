//! The scene as rays see it: the nearest object, what blocks a segment, and what stands at a hit.

use std::f64::consts::PI;

use glam::DVec3;

use crate::math::{Aabb, Ray, Rgb};
use crate::surface::{END_ROUNDING, Hit};
use crate::{Error, Result};

use super::index::Index;
use super::{Brdf, Emitter, Material, Object, PointLight, Sensor};

/// Holds everything that light can meet or come from.
#[derive(Clone)]
pub struct Scene {
    objects: Vec<Object>,
    index: Index,
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

    /// Puts a sensor on the surface that it is meant to lie on: the uppermost that is within a
    /// millionth of its object's size above or below it. A sensor that was placed on a surface
    /// ([`Sensor::on`]) is on it. Of other surfaces that pass through the sensor, as the walls where
    /// it lies in a corner, it is put on the front, as far as it stays on its own.
    pub fn settled(&self, sensor: &Sensor) -> Sensor {
        let support = self.support(sensor);
        let up = sensor.normal;
        let on = match &support {
            Some((_, hit)) if sensor.error <= 0.0 => {
                let height = (hit.point - sensor.at).dot(up);
                let at = if height > 0.0 { hit.point } else { sensor.at };
                // Rays leave along the sensor's own normal, which may be tilted against the
                // surface.
                let error = hit.error / hit.normal.dot(up).abs();
                Sensor { at, error: error.max(f64::MIN_POSITIVE), ..*sensor }
            }
            _ => *sensor,
        };
        let at = self.before_others(on.at, up, support.as_ref());
        Sensor { at, ..on }
    }

    /// Finds the object that a sensor lies on, and where.
    fn support(&self, sensor: &Sensor) -> Option<(usize, Hit)> {
        let reach = ON_SURFACE * self.index.largest_size();
        let up = sensor.normal;
        let mut ray = Ray::new(sensor.at + reach * up, -up).up_to(2.0 * reach);
        // Surfaces one below the other: those that the sensor is too far from for their size are
        // passed.
        for _ in 0..MOST_LAYERS {
            let (object, hit) = self.hit(&ray)?;
            let height = (hit.point - sensor.at).dot(up);
            // What shines at the sensor is before it, however near.
            let lights_it = hit.normal.dot(up) < 0.0 && self.objects[object].emits();
            let lies_on_it = hit.normal.dot(up).abs() > LEAST_SLOPE;
            if height.abs() <= self.nearness(object, &hit) && lies_on_it && !lights_it {
                return Some((object, hit));
            }
            let next = hit.departure(-up);
            let rest = (next - sensor.at).dot(up) + reach;
            if rest <= 0.0 {
                return None;
            }
            ray = Ray::new(next, -up).up_to(rest);
        }
        None
    }

    /// Moves a sensor to the front of the surfaces that pass through it beside its support, where
    /// it stays on that: seen from a point in a wall, the light of the wall is undefined.
    fn before_others(&self, mut at: DVec3, up: DVec3, support: Option<&(usize, Hit)>) -> DVec3 {
        let reach = ON_SURFACE * self.index.largest_size();
        let (e1, e2) = up.any_orthonormal_pair();
        // Two lines that lie in none of the planes that scenes are made of.
        let (e1, e2) = (0.8 * e1 + 0.6 * e2, 0.8 * e2 - 0.6 * e1);
        // A sensor that is tilted against its support leaves its own plane.
        let upright = support.is_none_or(|(_, hit)| hit.normal.dot(up).abs() > UPRIGHT);
        for _ in 0..MOST_LAYERS {
            let moved = [e1, -e1, e2, -e2].into_iter().find_map(|aside| {
                let ray = Ray::new(at + reach * aside, -aside).up_to(2.0 * reach);
                let (object, hit) = self.hit(&ray)?;
                let within = hit.normal.reject_from_normalized(up);
                let normal = if upright { within } else { hit.normal };
                let near = self.nearness(object, &hit);
                let off = (at - hit.point).dot(hit.normal);
                let before = (BEFORE_SURFACE * near).max(BEFORE_ERROR * hit.error);
                let passes = within.length() > LEAST_SLOPE && off >= -near && off < 0.5 * before;
                let moved = at + normal * ((before - off) / normal.length_squared());
                (passes && self.keeps(moved, up, upright, support)).then_some(moved)
            });
            let Some(moved) = moved else { break };
            at = moved;
        }
        at
    }

    /// Whether a sensor that is moved still lies on its support, or before it if it is tilted.
    fn keeps(
        &self,
        moved: DVec3,
        up: DVec3,
        upright: bool,
        support: Option<&(usize, Hit)>,
    ) -> bool {
        let Some((object, hit)) = support else { return true };
        if !upright {
            return (moved - hit.point).dot(hit.normal) >= -4.0 * hit.error;
        }
        let reach = self.nearness(*object, hit);
        let ray = Ray::new(moved + reach * up, -up).up_to(2.0 * reach);
        self.hit(&ray).is_some_and(|(found, _)| found == *object)
    }

    /// Returns how far from a hit, metres, a sensor may be that is meant to lie there.
    fn nearness(&self, object: usize, hit: &Hit) -> f64 {
        (ON_SURFACE * self.index.size(object)).max(self.index.coincidence(object, hit))
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

/// A sensor this close to a surface, relative to the size of its object, lies on it: files hold
/// coordinates in single precision.
const ON_SURFACE: f64 = 1e-6;
/// How far before a surface that passes through it a sensor is put, relative to the distance within
/// which it lies on it: enough for the surface to be seen exactly.
const BEFORE_SURFACE: f64 = 1e-3;
/// The same relative to the error of the place where the surface is.
const BEFORE_ERROR: f64 = 64.0;
/// The cosine to its support from which a sensor counts as upright on it.
const UPRIGHT: f64 = 0.999;
/// The least sine of the angle between a sensor's plane and a surface that passes through it, and
/// cosine to one that it lies on.
const LEAST_SLOPE: f64 = 0.05;
/// How many surfaces are passed in search of the one a sensor lies on.
const MOST_LAYERS: usize = 8;

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
    use crate::surface::primitives::{AxisBox, Rectangle};

    fn grey() -> Material {
        Material::lambert(Rgb::grey(0.5)).expect("valid")
    }

    /// A room at UTM coordinates with a desk whose top is a hair above 0.75 m.
    fn desk_room(top: f64) -> (Scene, DVec3) {
        let corner = DVec3::new(408_201.0, 5_600_123.0, 0.0);
        let room = AxisBox::new(corner, corner + DVec3::new(4.0, 4.0, 3.0)).expect("valid");
        let desk =
            AxisBox::new(corner + DVec3::new(1.0, 1.0, 0.7), corner + DVec3::new(3.0, 3.0, top));
        let objects = vec![
            Object::new("room", room.turned_inward(true), grey()),
            Object::new("desk", desk.expect("valid"), grey()),
        ];
        (Scene::new(objects, vec![]).expect("valid"), corner)
    }

    #[test]
    fn sensors_a_hair_under_a_surface_lie_on_it() {
        for off in [1e-13, 1e-8, 1e-6, 2e-6] {
            let (scene, corner) = desk_room(0.75 + off);
            let sensor = |x: f64| Sensor::plane(corner + DVec3::new(x, 2.0, 0.75), DVec3::Z);
            let on = scene.settled(&sensor(2.0));
            assert_eq!(on.at.z, 0.75 + off, "{off}");
            assert!(!scene.blocked(&on.as_hit().leave(DVec3::Z).up_to(2.0)));
            // Beside the desk it stays in the air.
            assert_eq!(scene.settled(&sensor(0.5)), sensor(0.5));
        }
        let (scene, corner) = desk_room(0.7501);
        let deep = Sensor::plane(corner + DVec3::new(2.0, 2.0, 0.75), DVec3::Z);
        assert_eq!(scene.settled(&deep), deep);
    }

    #[test]
    fn sensors_in_walls_are_before_all_of_them() {
        let far = DVec3::new(408_201.0, 5_600_123.0, 0.0);
        for (corner, most) in [(DVec3::ZERO, 1e-8), (far, 1e-6)] {
            let size = DVec3::new(4.0, 4.0, 3.0);
            let room = AxisBox::new(corner, corner + size).expect("valid").turned_inward(true);
            let screen = Rectangle::new(corner + DVec3::new(2.0, 1.0, 0.0), DVec3::Y, DVec3::Z);
            let objects = vec![
                Object::new("room", room, grey()),
                Object::new("screen", screen.expect("valid"), grey()),
            ];
            let scene = Scene::new(objects, vec![]).expect("valid");
            let front = |at: [f64; 3], before: [f64; 3]| {
                let at = corner + DVec3::from(at);
                let off = scene.settled(&Sensor::plane(at, DVec3::Z)).at - at;
                let sides = off.to_array().into_iter().zip(before);
                for (off, side) in sides {
                    let right = if side == 0.0 { off == 0.0 } else { off * side > 0.0 };
                    assert!(right && off.abs() <= most, "{at}: {off} for {side}");
                }
            };
            front([0.0, 0.0, 0.0], [1.0, 1.0, 0.0]);
            front([4.0, 4.0, 0.0], [-1.0, -1.0, 0.0]);
            front([4.0, 2.5, 1.0], [-1.0, 0.0, 0.0]);
            front([2.0, 1.5, 0.5], [1.0, 0.0, 0.0]);
            front([2.0, 1.5, 0.0], [1.0, 0.0, 0.0]);
            front([2.1, 1.5, 0.0], [0.0, 0.0, 0.0]);
        }
    }

    #[test]
    fn sensors_stay_on_what_they_lie_on() {
        // Two rooms that share the wall x = 0; a shelf in one of them, its end in that wall.
        let solid = |name: &str, min: [f64; 3], max: [f64; 3], inward: bool| {
            let surface = AxisBox::new(min.into(), max.into()).expect("valid");
            Object::new(name, surface.turned_inward(inward), grey())
        };
        let objects = vec![
            solid("own", [0.0, 0.0, 0.0], [4.0, 5.0, 3.0], true),
            solid("next", [-4.0, 0.0, 0.0], [0.0, 5.0, 3.0], true),
            solid("shelf", [0.0, 4.0, 1.0], [4.0, 5.0, 1.02], false),
        ];
        let scene = Scene::new(objects, vec![]).expect("valid");
        let settled = |at: [f64; 3], normal: [f64; 3]| {
            scene.settled(&Sensor::plane(at.into(), DVec3::from(normal).normalize())).at
        };
        assert!(settled([0.0, 4.5, 1.02], [0.0, 0.0, 1.0]).x > 0.0);
        for tilt in [[1.0, 0.0, 1.0], [1.0, 0.0, 0.2]] {
            assert!(settled([0.0, 2.0, 1.0], tilt).x >= 0.0, "{tilt:?}");
        }
        // In an edge, between both walls.
        let between = settled([2.0, 0.0, 0.0], [0.0, 1.0, 1.0]);
        assert!(between.y > 0.0 && between.z > 0.0, "{between}");
        let corner = settled([4.0, 0.0, 0.0], [-1.0, 1.0, 1.0]);
        assert!(corner.x < 4.0 && corner.y > 0.0 && corner.z > 0.0, "{corner}");
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
