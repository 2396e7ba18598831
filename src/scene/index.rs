//! Which objects a ray is put to: all of them while they are few, those whose boxes it meets when
//! they are many.
//!
//! The answer is the same either way: the object whose hit is nearest. Surfaces that lie in one
//! place, as far as rounding can tell, are ordered by what is meant: one that shines at the ray
//! comes before others, then one whose face is turned to the ray, then the one with the smaller
//! area (a carpet lies on a floor), then the one that reflects more, then the first among the
//! objects.

use glam::DVec3;

use crate::math::{Aabb, Ray};
use crate::surface::primitives::Rectangles;
use crate::surface::{Bvh, END_ROUNDING, Hit};

use super::Object;

/// The most objects that are asked one by one. Walking the tree costs what it costs to miss about a
/// dozen spheres, or three bodies that are dearer to miss; below this number the difference is some
/// ten nanoseconds a ray either way, and batches go by the list.
const FEW: usize = 8;
/// The largest coordinate, metres, that the tree takes.
const LARGEST: f64 = 1e150;
/// How many rays of a batch are put to an object at a time: enough to feed a batched surface,
/// little enough for the stack.
const BATCH: usize = 64;

/// Finds the objects that a ray may meet.
#[derive(Debug, Clone)]
pub(super) struct Index {
    /// The objects that every ray is put to, ascending: all while they are few, else the infinite
    /// ones and those around all others. Rectangles are apart.
    everywhere: Vec<usize>,
    /// Those of them that are rectangles, and what tells which of these a ray meets.
    flat: Vec<usize>,
    rectangles: Rectangles,
    /// The boxes of the rest.
    tree: Option<Bvh>,
    order: Order,
}

/// Orders hits along a ray.
#[derive(Debug, Clone)]
struct Order {
    /// The area of each object, m2; infinite for a plane.
    areas: Vec<f64>,
    /// The diagonal of the bounds of each, m; of an infinite one that of all finite ones.
    sizes: Vec<f64>,
    /// How far, in metres along its normal, rounding moves the surface of each object at most.
    roundings: Vec<f64>,
    /// The largest of them.
    largest: f64,
}

impl Index {
    /// Sorts the objects of a scene.
    pub(super) fn new(objects: &[Object]) -> Self {
        let boxes: Vec<Aabb> = objects.iter().map(|o| o.surface.bounds()).collect();
        let whole = boxes.iter().filter(|b| is_local(b)).fold(Aabb::EMPTY, |all, b| all.union(*b));
        let is_everywhere = |i: &usize| !is_local(&boxes[*i]) || boxes[*i] == whole;
        let everywhere: Vec<usize> = (0..boxes.len()).filter(is_everywhere).collect();
        if boxes.len() - everywhere.len() <= FEW {
            return Self::asking_all(objects);
        }
        let mut rest = boxes.clone();
        for &i in &everywhere {
            // The tree leaves out what is empty.
            rest[i] = Aabb::EMPTY;
        }
        Self::asking(objects, everywhere, Some(Bvh::build(&rest)))
    }

    /// Returns the diagonal of an object's bounds, metres; of an infinite one that of all finite
    /// ones.
    pub(super) fn size(&self, object: usize) -> f64 {
        self.order.sizes[object]
    }

    /// Returns the largest of them.
    pub(super) fn largest_size(&self) -> f64 {
        self.order.sizes.iter().copied().fold(0.0, f64::max)
    }

    /// Returns how far from a hit of another object, metres, a surface may be that lies in the same
    /// place.
    pub(super) fn coincidence(&self, object: usize, hit: &Hit) -> f64 {
        self.order.roundings[object] + 4.0 * hit.error.max(1e-300)
    }

    /// Puts every ray to every object.
    fn asking_all(objects: &[Object]) -> Self {
        Self::asking(objects, (0..objects.len()).collect(), None)
    }

    /// Puts every ray to some objects, and the rest into a tree.
    fn asking(objects: &[Object], mut everywhere: Vec<usize>, tree: Option<Bvh>) -> Self {
        let rectangle = |i: &usize| objects[*i].surface.as_rectangle();
        let flat = everywhere.iter().copied().filter(|i| rectangle(i).is_some());
        let flat: Vec<usize> = flat.take(Rectangles::MOST).collect();
        everywhere.retain(|i| !flat.contains(i));
        let rectangles = Rectangles::new(&flat.iter().filter_map(rectangle).collect::<Vec<_>>());
        Self { everywhere, flat, rectangles, tree, order: Order::new(objects) }
    }

    /// Finds the first object along a ray.
    pub(super) fn hit(&self, objects: &[Object], ray: &Ray) -> Option<(usize, Hit)> {
        let (mut first, mut rest) = (None, *ray);
        let mut met = [0];
        self.rectangles.met(std::slice::from_ref(ray), &mut met);
        self.keep_rectangles(objects, ray, met[0], &mut first, &mut rest);
        for &index in &self.everywhere {
            let hit = objects[index].surface.hit(&rest).map(|hit| (index, hit));
            self.order.keep_first(objects, ray, &mut first, &mut rest, hit);
        }
        self.search(objects, ray, first)
    }

    /// Finds the first object along every ray of a batch. What is everywhere is asked by batches;
    /// the tree gives each ray objects of its own.
    pub(super) fn hits(
        &self,
        objects: &[Object],
        rays: &[Ray],
        answers: &mut [Option<(usize, Hit)>],
    ) {
        // One ray is not worth the arrays.
        if let ([ray], [answer]) = (rays, &mut *answers) {
            *answer = self.hit(objects, ray);
            return;
        }
        let mut rest = [Ray::new(DVec3::ZERO, DVec3::Z); BATCH];
        let mut hits = [None; BATCH];
        let mut met = [0; BATCH];
        for (rays, answers) in rays.chunks(BATCH).zip(answers.chunks_mut(BATCH)) {
            let (rest, hits) = (&mut rest[..rays.len()], &mut hits[..rays.len()]);
            rest.copy_from_slice(rays);
            let met = &mut met[..rays.len()];
            answers.fill(None);
            self.rectangles.met(rays, met);
            for (i, first) in answers.iter_mut().enumerate() {
                self.keep_rectangles(objects, &rays[i], met[i], first, &mut rest[i]);
            }
            for &index in &self.everywhere {
                objects[index].surface.hits(rest, hits);
                for (i, first) in answers.iter_mut().enumerate() {
                    let hit = hits[i].map(|hit| (index, hit));
                    self.order.keep_first(objects, &rays[i], first, &mut rest[i], hit);
                }
            }
            for (first, ray) in answers.iter_mut().zip(rays) {
                *first = self.search(objects, ray, *first);
            }
        }
    }

    /// Whether a ray meets anything.
    pub(super) fn blocked(&self, objects: &[Object], ray: &Ray) -> bool {
        let mut met = [0];
        self.rectangles.met(std::slice::from_ref(ray), &mut met);
        met[0] != 0
            || self.everywhere.iter().any(|&index| objects[index].surface.blocked(ray))
            || self.blocked_in_tree(objects, ray)
    }

    /// Marks the rays of a batch that meet anything; those marked already are passed over.
    pub(super) fn mark_blocked(&self, objects: &[Object], rays: &[Ray], blocked: &mut [bool]) {
        if let ([ray], [blocked]) = (rays, &mut *blocked) {
            *blocked = *blocked || self.blocked(objects, ray);
            return;
        }
        let mut met = [0; BATCH];
        for (rays, blocked) in rays.chunks(BATCH).zip(blocked.chunks_mut(BATCH)) {
            let met = &mut met[..rays.len()];
            self.rectangles.met(rays, met);
            for (blocked, met) in blocked.iter_mut().zip(met) {
                *blocked |= *met != 0;
            }
        }
        for &index in &self.everywhere {
            objects[index].surface.mark_blocked(rays, blocked);
        }
        for (ray, blocked) in rays.iter().zip(blocked) {
            *blocked = *blocked || self.blocked_in_tree(objects, ray);
        }
    }

    /// Keeps the first of the rectangles that a ray meets, and ends it there.
    fn keep_rectangles(
        &self,
        objects: &[Object],
        ray: &Ray,
        mut met: u64,
        first: &mut Option<(usize, Hit)>,
        rest: &mut Ray,
    ) {
        while met != 0 {
            let index = self.flat[met.trailing_zeros() as usize];
            met &= met - 1;
            let hit = objects[index].surface.hit(rest);
            self.order.keep_first(objects, ray, first, rest, hit.map(|hit| (index, hit)));
        }
    }

    /// Finds the first object along a ray when `first` is the first of those that are everywhere.
    fn search(
        &self,
        objects: &[Object],
        ray: &Ray,
        mut first: Option<(usize, Hit)>,
    ) -> Option<(usize, Hit)> {
        let Some(tree) = &self.tree else { return first };
        let rest = ray.up_to(first.map_or(ray.t_max, |first| self.order.just_beyond(ray, &first)));
        tree.closest(&rest, |index, t_max| {
            let hit = objects[index].surface.hit(&ray.up_to(t_max))?;
            let best = self.order.first_of_two(objects, ray, first, (index, hit));
            first = Some(best);
            (best.0 == index).then(|| self.order.just_beyond(ray, &best))
        });
        first
    }

    fn blocked_in_tree(&self, objects: &[Object], ray: &Ray) -> bool {
        let blocked = |index: usize| objects[index].surface.blocked(ray);
        self.tree.as_ref().is_some_and(|tree| tree.any(ray, blocked))
    }
}

/// Whether a box is one of those the tree can hold.
fn is_local(bounds: &Aabb) -> bool {
    let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
    !bounds.is_empty() && largest <= LARGEST
}

impl Order {
    fn new(objects: &[Object]) -> Self {
        let area = |object: &Object| object.area.as_ref().map_or(f64::INFINITY, |a| a.area());
        let rounding = |object: &Object| {
            let bounds = object.surface.bounds();
            let coordinates = bounds.min.to_array().into_iter().chain(bounds.max.to_array());
            let largest = coordinates.map(f64::abs).filter(|x| x.is_finite()).fold(0.0, f64::max);
            8.0 * f64::EPSILON * largest
        };
        let roundings: Vec<f64> = objects.iter().map(rounding).collect();
        let largest = roundings.iter().copied().fold(0.0, f64::max);
        let boxes = || objects.iter().map(|o| o.surface.bounds());
        let all = boxes().filter(Aabb::is_finite).fold(Aabb::EMPTY, Aabb::union);
        let whole = if all.is_empty() { 0.0 } else { all.extent().length() };
        let size = |b: Aabb| if b.is_finite() { b.extent().length() } else { whole };
        let sizes = boxes().map(size).collect();
        Self { areas: objects.iter().map(area).collect(), sizes, roundings, largest }
    }

    /// Keeps the hit of an object on what is left of a ray when it comes before the first so far,
    /// and ends the rest there.
    fn keep_first(
        &self,
        objects: &[Object],
        ray: &Ray,
        first: &mut Option<(usize, Hit)>,
        rest: &mut Ray,
        hit: Option<(usize, Hit)>,
    ) {
        if let Some(hit) = hit {
            let best = self.first_of_two(objects, ray, *first, hit);
            rest.t_max = self.just_beyond(ray, &best);
            *first = Some(best);
        }
    }

    /// Returns up to where another hit may turn out to be the first: as far as it may lie in the
    /// same place.
    fn just_beyond(&self, ray: &Ray, (index, hit): &(usize, Hit)) -> f64 {
        let apart = self.roundings[*index] + self.largest + END_ROUNDING * hit.distance;
        let cos = hit.normal.dot(ray.direction).abs();
        ray.t_max.min(hit.distance + hit.error + 2.0 * apart / cos)
    }

    /// Whether two hits of a ray lie in one place, as far as rounding can tell.
    fn coincide(&self, ray: &Ray, (i, a): &(usize, Hit), (j, b): &(usize, Hit)) -> bool {
        let cos = [a, b].map(|hit| hit.normal.dot(ray.direction).abs());
        let apart = self.roundings[*i] + self.roundings[*j] + END_ROUNDING * a.distance;
        (a.distance - b.distance).abs() * cos[0].max(cos[1]) <= apart
    }

    /// Returns the first of two hits.
    ///
    /// The end of a ray may move a hit by a rounding: only the answers to the whole ray decide
    /// between near equals.
    fn first_of_two(
        &self,
        objects: &[Object],
        ray: &Ray,
        best: Option<(usize, Hit)>,
        new: (usize, Hit),
    ) -> (usize, Hit) {
        let Some(best) = best else { return new };
        let error = best.1.error.max(new.1.error);
        let near = (best.1.distance - new.1.distance).abs() <= error;
        let (a, b) = if near || self.coincide(ray, &best, &new) {
            let whole = |(index, hit): (usize, Hit)| {
                (index, objects[index].surface.hit(ray).unwrap_or(hit))
            };
            (whole(best), whole(new))
        } else {
            (best, new)
        };
        let b_is_first = if self.coincide(ray, &a, &b) {
            self.rank(objects, ray, &b) < self.rank(objects, ray, &a)
        } else {
            b.1.distance < a.1.distance
        };
        if b_is_first { b } else { a }
    }

    /// Returns by what hits in one place are ordered, the first being the least.
    fn rank(
        &self,
        objects: &[Object],
        ray: &Ray,
        (index, hit): &(usize, Hit),
    ) -> (bool, bool, f64, f64, usize) {
        let faces_away = hit.normal.dot(ray.direction) >= 0.0;
        let material = objects[*index].material(hit);
        let is_dark = faces_away || material.exitance.is_black();
        let albedo = material.brdf.albedo(hit.normal, hit.normal);
        (is_dark, faces_away, self.areas[*index], -albedo, *index)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DQuat;

    use super::*;
    use crate::math::{Placement, Randomness, Rgb, Stream, sampling};
    use crate::scene::Material;
    use crate::sh::Coefficients;
    use crate::surface::primitives::{AxisBox, Plane, Rectangle, Sphere};
    use crate::surface::{Instance, Intersector, SampleArea, ShSurface};

    fn grey() -> Material {
        Material::lambert(Rgb::grey(0.5)).expect("valid")
    }

    fn object<S: SampleArea + 'static>(surface: S) -> Object {
        Object::new("o", surface, grey())
    }

    fn ball(at: DVec3, radius: f64) -> Object {
        object(Sphere::new(at, radius).expect("valid"))
    }

    fn cube(low: DVec3, high: DVec3) -> AxisBox {
        AxisBox::new(low, high).expect("valid")
    }

    fn plane(point: DVec3, normal: DVec3) -> Object {
        let surface = Arc::new(Plane::new(point, normal).expect("valid"));
        Object { name: "p".to_owned(), surface, area: None, materials: vec![grey()] }
    }

    fn body() -> Arc<ShSurface> {
        let mut c = Coefficients::zeros(2);
        c.set(0, 0, 1.0, 0.0);
        c.set(2, 1, 0.2, -0.1);
        Arc::new(ShSurface::new(&c, Intersector::Certified).expect("positive"))
    }

    fn point(stream: &mut Stream, reach: f64) -> DVec3 {
        let [x, y, z, _] = stream.next_4d();
        reach * (2.0 * DVec3::new(x, y, z) - 1.0)
    }

    /// Balls, boxes and bodies of all sizes in a room, with two planes; some twice, so that there
    /// are equals.
    fn crowd(stream: &mut Stream, count: usize) -> Vec<Object> {
        let body = body();
        let mut objects = vec![
            plane(DVec3::new(0.0, 0.0, -9.0), DVec3::Z),
            object(cube(DVec3::splat(-10.0), DVec3::splat(10.0)).turned_inward(true)),
        ];
        for i in 0..count {
            let at = point(stream, 8.0);
            let [size, x, y, z] = stream.next_4d();
            let size = 10_f64.powf(-2.0 * size);
            let new = match i % 5 {
                0 => ball(at, size),
                3 => {
                    let along = DVec3::new(0.1 + x, y, z).normalize();
                    let across = (0.1 + z) * along.any_orthonormal_vector();
                    object(Rectangle::new(at, size * along, size * across).expect("valid"))
                }
                1 => object(cube(at, at + size * DVec3::new(0.1 + x, 0.1 + y, 0.1 + z))),
                2 => {
                    let turn = DQuat::from_xyzw(x - 0.5, y, z, size);
                    let placement = Placement::new(turn, size, at).expect("valid");
                    object(Instance::new(body.clone(), placement))
                }
                _ => objects[objects.len() - 2].clone(),
            };
            objects.push(new);
        }
        objects.push(plane(DVec3::new(9.5, 0.0, 0.0), DVec3::X));
        objects
    }

    fn rays(stream: &mut Stream, count: usize) -> Vec<Ray> {
        let ray = |i: usize| {
            let from = point(stream, if i.is_multiple_of(3) { 30.0 } else { 9.0 });
            let ray = match i % 4 {
                0 => Ray::between(from, point(stream, 9.0)).expect("distinct"),
                _ => Ray::new(from, sampling::uniform_sphere(stream.next_2d())),
            };
            if i.is_multiple_of(5) { Ray { t_min: 1.0, ..ray } } else { ray }
        };
        (0..count).map(ray).collect()
    }

    /// Holds an index to the answers of asking all, one by one and by batches.
    fn check(objects: &[Object], index: &Index, rays: &[Ray]) -> [usize; 2] {
        // One object after the other, rectangles too.
        let all = Index {
            everywhere: (0..objects.len()).collect(),
            flat: vec![],
            rectangles: Rectangles::new(&[]),
            tree: None,
            order: Order::new(objects),
        };
        let mut hits = vec![None; rays.len()];
        index.hits(objects, rays, &mut hits);
        let mut blocked: Vec<bool> = (0..rays.len()).map(|i| i.is_multiple_of(7)).collect();
        index.mark_blocked(objects, rays, &mut blocked);
        for (i, ray) in rays.iter().enumerate() {
            let truth = all.hit(objects, ray);
            assert_eq!(index.hit(objects, ray), truth, "{ray:?}");
            assert_eq!(hits[i], truth, "{ray:?} in a batch");
            assert_eq!(index.blocked(objects, ray), truth.is_some(), "{ray:?}");
            assert_eq!(blocked[i], i.is_multiple_of(7) || truth.is_some(), "{ray:?} in a batch");
        }
        [hits.iter().flatten().count(), hits.len()]
    }

    #[test]
    fn nothing_is_met_in_an_empty_scene() {
        let index = Index::new(&[]);
        let ray = Ray::new(DVec3::ZERO, DVec3::X);
        assert!(index.hit(&[], &ray).is_none() && !index.blocked(&[], &ray));
        index.hits(&[], &[], &mut []);
        index.mark_blocked(&[], &[], &mut []);
    }

    #[test]
    fn tree_answers_as_asking_all_does() {
        let mut stream = Stream::new(Randomness::Pseudorandom, 5, 0);
        for count in [0, 3, FEW, FEW + 1, 20, 150] {
            let objects = crowd(&mut stream, count);
            let index = Index::new(&objects);
            assert_eq!(index.tree.is_some(), count > FEW);
            check(&objects, &index, &rays(&mut stream, 1500));
            // Without the room, from outside as well.
            let open = &objects[2..objects.len() - 1];
            let [met, of] = check(open, &Index::new(open), &rays(&mut stream, 2000));
            assert!(met < of && (count < 20 || met > 0), "{met} of {of}");
        }
    }

    #[test]
    fn first_of_equals_is_the_first_in_the_list() {
        // Faces of boxes in one plane, a plane there too, and one ball many times over: met at
        // exactly equal distances.
        let mut objects: Vec<Object> = (0..12)
            .map(|i| {
                object(cube(DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, f64::from(i + 1))))
            })
            .collect();
        objects.push(plane(DVec3::ZERO, DVec3::Z));
        let corner = DVec3::new(-2.0, -2.0, 0.0);
        let table = Rectangle::new(corner, 4.0 * DVec3::X, 4.0 * DVec3::Y).expect("valid");
        objects.extend((0..3).map(|_| object(table)));
        objects.extend((0..12).map(|_| ball(DVec3::new(5.0, 0.0, 1.0), 1.0)));
        for turn in 0..objects.len() {
            objects.rotate_left(turn);
            let index = Index::new(&objects);
            assert!(index.tree.is_some());
            let up = |x: f64| Ray::new(DVec3::new(x, 0.1, -2.0), DVec3::Z);
            check(&objects, &index, &[up(0.0), up(0.5), up(5.0), up(5.5), up(3.0)]);
        }
    }

    #[test]
    fn what_is_around_all_or_endless_stays_out_of_the_tree() {
        let mut stream = Stream::new(Randomness::Pseudorandom, 6, 0);
        let mut objects = crowd(&mut stream, 40);
        let huge = Placement::new(DQuat::IDENTITY, 1e100, DVec3::ZERO).expect("valid");
        objects.push(object(Instance::new(
            Arc::new(Sphere::new(DVec3::ZERO, 1e60).expect("valid")),
            huge,
        )));
        let index = Index::new(&objects);
        assert_eq!(index.everywhere, [0, 1, 42, 43]);
    }

    fn flat(normal_z: f64, size: f64, material: Material) -> Object {
        let corner = DVec3::new(-0.5 * size, -0.5 * size, 3.0);
        let (u, v) = (size * DVec3::X, normal_z * size * DVec3::Y);
        let corner = if normal_z < 0.0 { corner + size * DVec3::Y } else { corner };
        Object::new("flat", Rectangle::new(corner, u, v).expect("valid"), material)
    }

    /// A ceiling at 3 m, and what lies in it: whatever the order, a lamp comes first, then what
    /// faces the ray, then the smaller.
    #[test]
    fn of_surfaces_in_one_place_the_one_that_is_meant_comes_first() {
        let lamp = || grey().emitting(Rgb::WHITE);
        let in_order = [
            flat(-1.0, 2.0, lamp()),
            flat(-1.0, 0.5, grey()),
            object(cube(DVec3::splat(-3.0), DVec3::splat(3.0)).turned_inward(true)),
            flat(1.0, 0.1, lamp()),
            flat(1.0, 0.2, grey()),
        ];
        let ray = Ray::new(DVec3::new(0.01, 0.02, -1.0), DVec3::new(0.01, 0.0, 1.0).normalize());
        for count in 2..=in_order.len() {
            let from = in_order.len() - count;
            for turn in 0..count {
                let mut numbers: Vec<usize> = (from..in_order.len()).collect();
                numbers.rotate_left(turn);
                for numbers in [numbers.clone(), numbers.into_iter().rev().collect()] {
                    let objects: Vec<Object> =
                        numbers.iter().map(|i| in_order[*i].clone()).collect();
                    let index = Index::new(&objects);
                    let first = index.hit(&objects, &ray).map(|(i, _)| numbers[i]);
                    assert_eq!(first, Some(from), "{numbers:?}");
                    check(&objects, &index, &[ray]);
                }
            }
        }
    }
}
