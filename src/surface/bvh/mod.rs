//! A bounding volume hierarchy over boxes: the triangles of a mesh or the objects of a scene.
//!
//! The tree (`build`) has nodes of eight children (`node`), whose boxes are tested side by side in
//! f32, the nearest opened first. The walk may visit too much and never too little; the exact
//! answer is the visitor's, in f64.
//!
//! Crate obvhs builds the binary tree only. First hits of random chords of the head took 2.1 times
//! as long with its compressed eight-wide walk (medium preset; it also drops what lies within 1e-4
//! of the origin), 2.8 times with its binary one and 7 to 10 times with the walks of crate bvh 0.13
//! (f64, its SIMD on); obvhs's slow presets built 2 to 6 times as long for the same walk.
//!
//! Why no hit is lost. Boxes are stored relative to the centre of the whole and in units of `size`,
//! the larger of half its longest edge and 2^-26 of its largest coordinate. A ray starts where it
//! begins to count, if that is within 8 units, and else where it enters the whole (computed in
//! f64), so the planes are within about 1, the start within 8, and every rounding amounts to moving
//! a plane of a box. The distance to a plane is plane * inverse - start * inverse, its last product
//! fused or not. With u = 2^-24 the moves are at most
//!     u        rounding a plane of a box to f32,
//!     8 u      rounding the start of the ray,
//!     u + 8 u  the two products, each relative to a coordinate,
//!     2 u x 9  the reciprocal and the difference, relative to a distance of 9 to the plane,
//!     u        everything in f64 (start, visitor) while the ray's origin is within 2^27 sizes,
//! together 37 u; direction components below 1e-12 are raised to it, which moves the ray by less
//! than 1e-11. Boxes are widened by 64 u. A ray from farther away than 2^27 sizes visits
//! everything.

mod build;
mod node;

use std::ops::Range;

use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;

use crate::math::{Aabb, Ray};
use build::Leaves;
use node::{Child, Node, SmallBox, TreeRay, WIDTH};

/// Finds, among boxes, the few that a ray may meet.
#[derive(Debug, Clone)]
pub struct Bvh {
    nodes: Vec<Node>,
    /// The caller's number of each box in the order of the leaves; empty when the caller uses that
    /// order itself.
    order: Vec<u32>,
    /// How many places the leaves have.
    places: usize,
    /// Bounds all boxes, widened like them.
    whole: Aabb,
    centre: DVec3,
    /// Units of the tree per metre.
    scale: f64,
    /// The most children that can wait at once.
    waiting: usize,
    level: Level,
}

/// Waits on the stack: a child and the distance, in units of the tree, at which the ray enters it.
#[derive(Debug, Clone, Copy, Default)]
struct Waiting {
    child: Child,
    enters: f32,
}

/// How far boxes are widened, in units of the tree: 64 roundings of f32.
const WIDEN: f64 = 64.0 / (1_u64 << 24) as f64;
/// The smallest unit of the tree, relative to the largest coordinate: below it f64 itself becomes
/// coarse.
const FINEST: f64 = 1.0 / (1_u64 << 26) as f64;
/// How far from the centre, in units of the tree, a ray may start.
const NEAR: f64 = 8.0;
/// From how far, in units of the tree, the roundings of f64 stay below one of f32.
const FAR: f64 = (1_u64 << 27) as f64;
/// How many waiting children need no memory from the heap.
const SHALLOW: usize = 64;
/// Leaves for visitors that take one box after the other.
const SINGLE: Leaves = Leaves { most: 4, cost: 0.0, cost_each: 1.0, padded: false };
/// Leaves for visitors that take eight boxes at once.
const PADDED: Leaves = Leaves { most: Bvh::PLACES as u32, cost: 1.5, cost_each: 0.0, padded: true };

impl Bvh {
    /// Places in a leaf of [`Bvh::build_padded`].
    pub(super) const PLACES: usize = 8;

    /// Builds the tree of these boxes. None, one, flat, equal and huge boxes (up to about 1e150)
    /// are all fine; a box that is empty or not finite is left out and never visited: its owner
    /// keeps it apart.
    pub fn build(boxes: &[Aabb]) -> Self {
        let (mut tree, order) = Self::build_sorted(boxes);
        tree.order = order;
        tree
    }

    /// Builds a tree that numbers the boxes in its own order, and gives that order: box i of the
    /// tree is box `order[i]` of the caller, who can lay out its things alike and spare the walk a
    /// look-up.
    pub fn build_sorted(boxes: &[Aabb]) -> (Self, Vec<u32>) {
        Self::build_with(boxes, SINGLE)
    }

    /// Does the same with leaves of [`Bvh::PLACES`] places each, the last box of a leaf repeated in
    /// the places it does not need: for a visitor of [`Bvh::walk`] that takes all of a leaf at
    /// once.
    pub(super) fn build_padded(boxes: &[Aabb]) -> (Self, Vec<u32>) {
        Self::build_with(boxes, PADDED)
    }

    fn build_with(boxes: &[Aabb], leaves: Leaves) -> (Self, Vec<u32>) {
        let usable = |b: &Aabb| b.is_finite() && !b.is_empty();
        let kept: Vec<u32> =
            (0..boxes.len() as u32).filter(|&i| usable(&boxes[i as usize])).collect();
        let bounds = kept.iter().fold(Aabb::EMPTY, |all, &i| all.union(boxes[i as usize]));
        let mut tree = Self::over(bounds, kept.is_empty());
        let small: Vec<_> = kept
            .iter()
            .map(|&i| tree.rounded(boxes[i as usize]))
            .map(|[min, max]| obvhs::aabb::Aabb::new(min.into(), max.into()))
            .collect();
        let built = build::build(&small, leaves);
        tree.nodes = built.nodes;
        tree.waiting = built.waiting;
        tree.places = built.order.len();
        (tree, built.order.into_iter().map(|i| kept[i as usize]).collect())
    }

    /// Starts a tree: its units, and no node yet.
    fn over(bounds: Aabb, empty: bool) -> Self {
        // Halves before differences: the edge of a huge box may overflow.
        let centre = 0.5 * bounds.min + 0.5 * bounds.max;
        let half = (0.5 * bounds.max - 0.5 * bounds.min).max_element();
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
        let size = half.max(largest * FINEST).max(1e-290);
        let margin = DVec3::splat(size * WIDEN);
        let widened = Aabb { min: bounds.min - margin, max: bounds.max + margin };
        Self {
            nodes: Vec::new(),
            order: Vec::new(),
            places: 0,
            whole: if empty { Aabb::EMPTY } else { widened },
            centre,
            scale: 1.0 / size,
            waiting: 1,
            level: Level::new(),
        }
    }

    /// Bounds all boxes, with a small margin; empty without boxes.
    pub fn bounds(&self) -> Aabb {
        self.whole
    }

    /// Returns the bytes of the tree.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.order[..])
    }

    /// Finds the closest hit: calls `visit(index, t_max)` for every box that may hold one, and
    /// lowers `t_max` to the distance the visitor gives. The visitor answers for distances from
    /// `ray.t_min` to `t_max` only.
    pub fn closest(
        &self,
        ray: &Ray,
        mut visit: impl FnMut(usize, f64) -> Option<f64>,
    ) -> Option<(usize, f64)> {
        let mut best = None;
        self.walk_one_by_one(ray, |index, t_max| match visit(index, t_max) {
            Some(t) if t <= t_max => {
                best = Some((index, t));
                Some(t)
            }
            _ => Some(t_max),
        });
        best
    }

    /// Whether `visit(index)` is true for any box the ray may meet; asks in no particular order and
    /// stops at the first.
    pub fn any(&self, ray: &Ray, mut visit: impl FnMut(usize) -> bool) -> bool {
        let mut found = false;
        self.walk_one_by_one(ray, |index, t_max| {
            found = visit(index);
            (!found).then_some(t_max)
        });
        found
    }

    /// Shows the visitor every box that may overlap `with`, in no particular order; too many
    /// perhaps, never too few.
    pub fn overlapping(&self, with: Aabb, mut visit: impl FnMut(usize)) {
        // Every box is within the whole, in which all coordinates of the walk are small.
        let within = Aabb { min: with.min.max(self.whole.min), max: with.max.min(self.whole.max) };
        if !within.is_empty() {
            let within = self.rounded(within);
            dispatch!(self.level, simd => self.show_overlapping(simd, &within, &mut visit));
        }
    }

    #[inline(always)]
    fn show_overlapping<S: Simd>(&self, simd: S, with: &SmallBox, visit: &mut impl FnMut(usize)) {
        let mut waiting = vec![0_u32];
        while let Some(next) = waiting.pop() {
            let node = &self.nodes[next as usize];
            let mut met = node.overlapped_by(simd, with);
            while met != 0 {
                let child = node.child(take_lane(&mut met));
                if child.boxes == 0 {
                    waiting.push(child.first);
                }
                (child.first..child.first + child.boxes)
                    .for_each(|place| visit(self.index(place as usize)));
            }
        }
    }

    /// Shows the visitor every box the ray may meet before the distance it last answered; `None`
    /// ends the walk.
    fn walk_one_by_one(&self, ray: &Ray, mut visit: impl FnMut(usize, f64) -> Option<f64>) {
        let mut each = |places: Range<usize>, t_max: f64| {
            places.into_iter().try_fold(t_max, |t_max, place| visit(self.index(place), t_max))
        };
        dispatch!(self.level, simd => self.walk(simd, ray, &mut each));
    }

    /// Shows the visitor every leaf, by its places, that the ray may meet before the distance it
    /// last answered; `None` ends the walk.
    #[inline(always)]
    pub(super) fn walk<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        visit: impl FnMut(Range<usize>, f64) -> Option<f64>,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let inverse = inverse_of(ray.direction);
        let from = self.in_units(ray.at(ray.t_min));
        let (distance, start) = if from.abs().max_element() <= NEAR {
            (ray.t_min, from)
        } else {
            let Some(distance) = self.enter(ray, inverse) else { return };
            (distance, self.in_units(ray.at(distance)))
        };
        if distance.abs() * self.scale > FAR {
            self.visit_all(ray.t_max, visit);
            return;
        }
        let mut shallow = [Waiting::default(); SHALLOW];
        let mut deep = Vec::new();
        let stack = if self.waiting <= SHALLOW {
            &mut shallow[..]
        } else {
            deep.resize(self.waiting, Waiting::default());
            &mut deep[..]
        };
        let thin = TreeRay::new(simd, start, inverse);
        self.walk_with(simd, &thin, ray.t_max, distance, stack, visit);
    }

    #[inline(always)]
    fn visit_all(&self, mut t_max: f64, mut visit: impl FnMut(Range<usize>, f64) -> Option<f64>) {
        for first in (0..self.places).step_by(Self::PLACES) {
            let Some(t) = visit(first..self.places.min(first + Self::PLACES), t_max) else {
                return;
            };
            t_max = t;
        }
    }

    #[inline(always)]
    fn walk_with<S: Simd>(
        &self,
        simd: S,
        thin: &TreeRay<S>,
        mut t_max: f64,
        enter: f64,
        stack: &mut [Waiting],
        mut visit: impl FnMut(Range<usize>, f64) -> Option<f64>,
    ) {
        // A little more than t_max: rounding must not end the walk early.
        let limit_at = |t: f64| ((t - enter) * self.scale * (1.0 + WIDEN) + WIDEN) as f32;
        let mut limit = limit_at(t_max);
        let mut height = 0;
        // The root.
        let mut next = Some(Child::default());
        while let Some(child) = next {
            let first = child.first as usize;
            if child.boxes == 0 {
                let node = &self.nodes[first];
                let (met, enters) = node.met_by(simd, thin, limit);
                if met != 0 {
                    next = Some(descend(node, met, &enters, stack, &mut height));
                    continue;
                }
            } else {
                let Some(t) = visit(first..first + child.boxes as usize, t_max) else { return };
                if t != t_max {
                    t_max = t;
                    limit = limit_at(t_max);
                }
            }
            next = take_waiting(stack, &mut height, limit);
        }
    }

    /// Returns the distance at which the ray enters the whole: [`Aabb::intersect`] with a
    /// reciprocal that is needed again, and no branch.
    #[inline(always)]
    fn enter(&self, ray: &Ray, inverse: DVec3) -> Option<f64> {
        // Three roundings on either side: pbrt, section 6.8.2.
        const WIDEN: f64 = 1.0 + 4.0 * f64::EPSILON;
        let low = (self.whole.min - ray.origin) * inverse;
        let high = (self.whole.max - ray.origin) * inverse;
        let near = low.min(high).max_element().max(ray.t_min);
        let far = (low.max(high).min_element() * WIDEN).min(ray.t_max);
        (near <= far).then_some(near)
    }

    /// Returns a point in the units of the tree.
    #[inline(always)]
    fn in_units(&self, point: DVec3) -> DVec3 {
        (point - self.centre) * self.scale
    }

    /// Returns the caller's number of a box.
    #[inline]
    fn index(&self, place: usize) -> usize {
        self.order.get(place).map_or(place, |&i| i as usize)
    }

    /// Turns a box into the tree's units and widens it.
    fn rounded(&self, b: Aabb) -> SmallBox {
        let (min, max) = (self.in_units(b.min) - WIDEN, self.in_units(b.max) + WIDEN);
        [min, max].map(|p| p.as_vec3().to_array())
    }
}

/// Returns the reciprocals of a direction, all finite.
#[inline(always)]
fn inverse_of(direction: DVec3) -> DVec3 {
    let most = DVec3::splat(1e300);
    direction.recip().clamp(-most, most)
}

/// Takes the first marked lane.
#[inline(always)]
fn take_lane(met: &mut u32) -> usize {
    let lane = met.trailing_zeros() as usize % WIDTH;
    *met &= *met - 1;
    lane
}

/// Returns the nearest of the children met, and lets the others wait, the nearest on top.
#[inline(always)]
fn descend(
    node: &Node,
    mut met: u32,
    enters: &[f32; WIDTH],
    stack: &mut [Waiting],
    height: &mut usize,
) -> Child {
    let base = *height;
    let lane = take_lane(&mut met);
    let mut nearest = Waiting { child: node.child(lane), enters: enters[lane] };
    while met != 0 {
        let lane = take_lane(&mut met);
        let new = Waiting { child: node.child(lane), enters: enters[lane] };
        let is_nearer = new.enters < nearest.enters;
        let (near, far) = if is_nearer { (new, nearest) } else { (nearest, new) };
        nearest = near;
        let mut place = *height;
        while place > base && stack[place - 1].enters < far.enters {
            stack[place] = stack[place - 1];
            place -= 1;
        }
        stack[place] = far;
        *height += 1;
    }
    nearest.child
}

/// Takes the topmost child that the ray enters before `limit`.
#[inline(always)]
fn take_waiting(stack: &[Waiting], height: &mut usize, limit: f32) -> Option<Child> {
    while *height > 0 {
        *height -= 1;
        let top = stack[*height];
        if top.enters <= limit {
            return Some(top.child);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Randomness, Stream, sampling};

    fn all_met(tree: &Bvh, ray: &Ray) -> Vec<usize> {
        let mut met = Vec::new();
        tree.any(ray, |i| {
            met.push(i);
            false
        });
        met.sort_unstable();
        met
    }

    fn point(stream: &mut Stream) -> DVec3 {
        let [x, y, z, _] = stream.next_4d();
        DVec3::new(x, y, z)
    }

    #[test]
    fn no_boxes_no_visits() {
        let tree = Bvh::build(&[]);
        assert!(all_met(&tree, &Ray::new(DVec3::ZERO, DVec3::X)).is_empty());
        assert_eq!(tree.bounds(), Aabb::EMPTY);
        let left_out = Bvh::build(&[Aabb::EMPTY, Aabb::ALL]);
        assert!(all_met(&left_out, &Ray::new(DVec3::ZERO, DVec3::X)).is_empty());
    }

    #[test]
    fn padded_leaves_repeat_their_last_box() {
        let mut stream = Stream::new(Randomness::Pseudorandom, 5, 0);
        let boxes: Vec<_> = (0..1000).map(|_| Aabb::of_ball(point(&mut stream), 0.01)).collect();
        let (tree, order) = Bvh::build_padded(&boxes);
        let (leaves, rest) = order.as_chunks::<{ Bvh::PLACES }>();
        assert!(rest.is_empty() && tree.places == order.len());
        let mut held = vec![0; boxes.len()];
        for leaf in leaves {
            let own = 1 + leaf.iter().position(|b| *b == leaf[7]).expect("the last itself");
            assert!(leaf[own..].iter().all(|b| *b == leaf[7]));
            leaf[..own].iter().for_each(|b| held[*b as usize] += 1);
        }
        assert!(held.iter().all(|n| *n == 1));
    }

    #[test]
    fn rays_that_count_from_afar_lose_nothing() {
        // The origin is so far off that f64 knows the start to a few units only.
        let tree = Bvh::build(&[Aabb::of_ball(DVec3::ZERO, 1e-3), Aabb::of_ball(DVec3::ONE, 1e-3)]);
        let direction = DVec3::new(0.3, -0.4, 0.2).normalize();
        let ray = Ray { t_min: 1e16, ..Ray::new(-1e16 * direction, direction) };
        assert_eq!(all_met(&tree, &ray).len(), 2);
    }

    #[test]
    fn boxes_that_overlap_are_all_shown() {
        Bvh::build(&[]).overlapping(Aabb::ALL, |_| panic!("a box of nothing"));
        let mut stream = Stream::new(Randomness::Pseudorandom, 3, 0);
        let mut random = |size| {
            let corner = point(&mut stream);
            Aabb::new(corner, corner + size * point(&mut stream))
        };
        let boxes: Vec<Aabb> = (0..300).map(|_| random(0.1)).collect();
        let tree = Bvh::build(&boxes);
        for _ in 0..100 {
            let with = random(0.3);
            let mut shown = vec![false; boxes.len()];
            tree.overlapping(with, |i| shown[i] = true);
            for (found, b) in shown.iter().zip(&boxes) {
                let meets = b.min.cmple(with.max).all() && with.min.cmple(b.max).all();
                assert!(*found || !meets);
            }
            // Leaves hold four boxes: not many too many are shown.
            assert!(shown.iter().filter(|s| **s).count() <= 100);
        }
    }

    #[test]
    fn one_box_is_met_from_everywhere() {
        for b in [
            Aabb::new(DVec3::ZERO, DVec3::ONE),
            Aabb::new(DVec3::ZERO, DVec3::ZERO),
            Aabb::new(DVec3::splat(1e140), DVec3::splat(2e140)),
            Aabb::new(DVec3::splat(-1e140), DVec3::splat(1e140)),
            Aabb::new(DVec3::splat(1e-200), DVec3::splat(1e-200)),
            Aabb::new(DVec3::new(5.0, -1e9, 0.0), DVec3::new(5.0, 1e9, 0.0)),
        ] {
            let tree = Bvh::build(&[b]);
            for direction in [DVec3::X, DVec3::NEG_Y, DVec3::new(-0.0, 0.6, -0.8)] {
                let from = b.centre() - direction * 3.0 * b.extent().length().max(1.0);
                assert_eq!(all_met(&tree, &Ray::new(from, direction)), [0], "{b:?} {direction}");
                assert!(all_met(&tree, &Ray::new(from, -direction)).is_empty());
            }
        }
    }

    #[test]
    fn left_out_boxes_keep_the_numbers_of_the_others() {
        let ones = Aabb::new(DVec3::ZERO, DVec3::ONE);
        let tree = Bvh::build(&[Aabb::ALL, ones, Aabb::EMPTY, ones]);
        assert_eq!(all_met(&tree, &Ray::new(DVec3::NEG_X, DVec3::X)), [1, 3]);
    }

    #[test]
    fn equal_and_nested_boxes_are_all_met() {
        // Five hundred boxes one in the other make a tree far deeper than the stack that needs no
        // heap.
        let nested: Vec<_> =
            (0..500).map(|i| Aabb::of_ball(DVec3::ZERO, 1.0 + f64::from(i))).collect();
        let equal = vec![Aabb::of_ball(DVec3::ZERO, 1.0); 500];
        for boxes in [nested, equal] {
            let met = all_met(
                &Bvh::build(&boxes),
                &Ray::new(DVec3::splat(-900.0), DVec3::ONE.normalize()),
            );
            assert_eq!(met.len(), 500);
        }
    }

    /// Every box whose own slab test is passed must be visited, whatever the ray.
    fn visits_all_that_brute_force_meets(boxes: &[Aabb], ray: &Ray) {
        let tree = Bvh::build(boxes);
        let met = all_met(&tree, ray);
        for (i, b) in boxes.iter().enumerate() {
            assert!(b.intersect(ray).is_none() || met.contains(&i), "lost box {i} of {ray:?}");
        }
    }

    #[test]
    fn no_box_is_lost() {
        let mut stream = Stream::new(Randomness::Pseudorandom, 7, 0);
        let boxes: Vec<_> = (0..300)
            .map(|i| {
                let a = point(&mut stream);
                // Every third box is a point, every other third is flat: their rays graze.
                let edge = [DVec3::ZERO, DVec3::new(0.05, 0.05, 0.0), DVec3::splat(0.02)][i % 3];
                Aabb::new(a, a + edge)
            })
            .collect();
        for distance in [0.0, 1.0, 1e3, 1e6, 1e8, 1e12] {
            for _ in 0..100 {
                let target = boxes[(stream.next_2d()[0] * 300.0) as usize];
                let mut direction = sampling::uniform_sphere(stream.next_2d());
                if stream.next_2d()[0] < 0.3 {
                    direction = [DVec3::X, DVec3::NEG_Y, DVec3::new(0.6, 0.0, -0.8)]
                        [(stream.next_2d()[0] * 3.0) as usize];
                }
                let corner = if stream.next_2d()[0] < 0.5 { target.min } else { target.max };
                visits_all_that_brute_force_meets(
                    &boxes,
                    &Ray::new(corner - distance * direction, direction),
                );
            }
        }
    }

    #[test]
    fn closest_respects_both_ends_of_the_ray() {
        // Walls at x = 0, 1, ... 99; the visitor knows their distance.
        let boxes: Vec<_> = (0..100)
            .map(|i| {
                let x = f64::from(i);
                Aabb::new(DVec3::new(x, -1.0, -1.0), DVec3::new(x, 1.0, 1.0))
            })
            .collect();
        let tree = Bvh::build(&boxes);
        let first_between = |t_min: f64, t_max: f64| {
            let ray = Ray { t_min, t_max, ..Ray::new(DVec3::NEG_X, DVec3::X) };
            tree.closest(&ray, |i, t_max| {
                let t = i as f64 + 1.0;
                (t >= ray.t_min && t <= t_max).then_some(t)
            })
        };
        assert_eq!(first_between(0.0, f64::INFINITY), Some((0, 1.0)));
        assert_eq!(first_between(1.0, 1.0), Some((0, 1.0)));
        assert_eq!(first_between(40.5, f64::INFINITY), Some((40, 41.0)));
        assert_eq!(first_between(40.5, 41.0), Some((40, 41.0)));
        assert_eq!(first_between(40.5, 40.9), None);
        assert_eq!(first_between(0.0, 0.9), None);
        assert_eq!(first_between(100.5, f64::INFINITY), None);
    }

    #[test]
    fn sorted_tree_numbers_boxes_in_its_own_order() {
        let boxes: Vec<_> = (0..50)
            .map(|i| Aabb::of_ball(DVec3::new(f64::from((i * 17) % 50), 0.0, 0.0), 0.4))
            .collect();
        let (tree, order) = Bvh::build_sorted(&boxes);
        let met = all_met(&tree, &Ray::new(DVec3::new(20.0, -9.0, 0.0), DVec3::Y));
        // A leaf is visited as a whole.
        assert!(met.len() <= 4);
        assert!(met.iter().any(|&i| boxes[order[i] as usize].centre().x == 20.0));
    }
}
