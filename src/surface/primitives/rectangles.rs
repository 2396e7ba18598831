//! Rectangles side by side: a ray is put to eight of them at a time.

use super::Rectangle;
use crate::math::Ray;
use crate::math::lanes::{LANES, load, splat};
use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f64x8};

/// Describes which of some rectangles a ray meets, by the same arithmetic, to the bit, as
/// [`Rectangle`] itself.
#[derive(Debug, Clone)]
pub(crate) struct Rectangles {
    blocks: Vec<Block>,
    level: Level,
}

/// Eight rectangles; a lane without one is NaN, and never met.
#[derive(Debug, Clone)]
struct Block {
    corner: [[f64; LANES]; 3],
    normal: [[f64; LANES]; 3],
    edges: [[[f64; LANES]; 3]; 2],
    squared_lengths: [[f64; LANES]; 2],
}

impl Rectangles {
    /// The most that are taken.
    pub(crate) const MOST: usize = u64::BITS as usize;

    /// Takes rectangles up, [`Rectangles::MOST`] at most.
    pub(crate) fn new(rectangles: &[&Rectangle]) -> Self {
        debug_assert!(rectangles.len() <= Self::MOST);
        Self { blocks: rectangles.chunks(LANES).map(Block::new).collect(), level: Level::new() }
    }

    /// Returns the numbers, as bits, of those that each ray meets.
    pub(crate) fn met(&self, rays: &[Ray], met: &mut [u64]) {
        met.fill(0);
        if !self.blocks.is_empty() {
            dispatch!(self.level, simd => self.met_simd(simd, rays, met));
        }
    }

    #[inline(always)]
    fn met_simd<S: Simd>(&self, simd: S, rays: &[Ray], met: &mut [u64]) {
        for (number, block) in self.blocks.iter().enumerate() {
            for (ray, met) in rays.iter().zip(&mut *met) {
                *met |= block.met(simd, ray) << (number * LANES);
            }
        }
    }
}

impl Block {
    fn new(rectangles: &[&Rectangle]) -> Self {
        let none = [f64::NAN; LANES];
        let mut block = Self {
            corner: [none; 3],
            normal: [none; 3],
            edges: [[none; 3]; 2],
            squared_lengths: [none; 2],
        };
        for (lane, rectangle) in rectangles.iter().enumerate() {
            let lengths = rectangle.lengths * rectangle.lengths;
            for axis in 0..3 {
                block.corner[axis][lane] = rectangle.corner[axis];
                block.normal[axis][lane] = rectangle.normal[axis];
                block.edges[0][axis][lane] = rectangle.edge_u[axis];
                block.edges[1][axis][lane] = rectangle.edge_v[axis];
            }
            (block.squared_lengths[0][lane], block.squared_lengths[1][lane]) = lengths.into();
        }
        block
    }

    /// Returns the lanes whose rectangle the ray meets: [`Rectangle::hit`], step by step.
    #[inline(always)]
    fn met<S: Simd>(&self, simd: S, ray: &Ray) -> u64 {
        let [origin, direction] = [splat(simd, ray.origin), splat(simd, ray.direction)];
        let (corner, normal) = (load(simd, &self.corner), load(simd, &self.normal));
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        let [mut to_corner, mut offset] = [[zero; 3]; 2];
        for axis in 0..3 {
            to_corner[axis] = corner[axis] - origin[axis];
        }
        let distance = dot(normal, to_corner) / dot(normal, direction);
        for axis in 0..3 {
            offset[axis] = (origin[axis] - corner[axis]) + distance * direction[axis];
        }
        let u = dot(offset, load(simd, &self.edges[0]))
            / f64x8::from_slice(simd, &self.squared_lengths[0]);
        let v = dot(offset, load(simd, &self.edges[1]))
            / f64x8::from_slice(simd, &self.squared_lengths[1]);
        let counts = distance.simd_ge(f64x8::splat(simd, ray.t_min))
            & distance.simd_le(f64x8::splat(simd, ray.t_max))
            & distance.abs().simd_lt(f64x8::splat(simd, f64::INFINITY));
        let inside = u.simd_ge(zero) & u.simd_le(one) & v.simd_ge(zero) & v.simd_le(one);
        (counts & inside).to_bitmask()
    }
}

/// The sum that [`glam::DVec3::dot`] makes, in its order and with its roundings.
#[inline(always)]
fn dot<S: Simd>(a: [f64x8<S>; 3], b: [f64x8<S>; 3]) -> f64x8<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::math::{Randomness, Stream, sampling};
    use crate::surface::Surface;

    fn random_rectangle(stream: &mut Stream) -> Rectangle {
        let [x, y, z, size] = stream.next_4d();
        let along = sampling::uniform_sphere(stream.next_2d());
        let across = along.any_orthonormal_vector();
        let size = 10_f64.powf(-2.0 * size);
        Rectangle::new(DVec3::new(x, y, z), size * along, 0.7 * size * across).expect("valid")
    }

    #[test]
    fn those_met_are_those_that_answer_to_the_bit() {
        let mut stream = Stream::new(Randomness::Pseudorandom, 8, 0);
        let mut met_in_all = 0;
        for count in [0, 1, 7, 8, 9, 64] {
            let all: Vec<Rectangle> = (0..count).map(|_| random_rectangle(&mut stream)).collect();
            let together = Rectangles::new(&all.iter().collect::<Vec<_>>());
            let mut ray = |i: usize| {
                let from = DVec3::from_slice(&stream.next_4d()[..3]);
                let [a, b, c, _] = stream.next_4d();
                let rectangle = all.get(i % count.max(1));
                match (i % 5, rectangle) {
                    // Towards its edge and its corner, along its plane, from its plane, and ended
                    // at its plane.
                    (0, Some(r)) => Ray::new(from, (r.corner + a * r.edge_u - from).normalize()),
                    (1, Some(r)) => Ray::new(from, (r.corner + r.edge_v - from).normalize()),
                    (2, Some(r)) => Ray::new(r.corner - r.edge_u, r.edge_u.normalize()),
                    (3, Some(r)) => Ray::new(r.corner + a * r.edge_u + b * r.edge_v, r.normal),
                    (4, Some(r)) => {
                        Ray::between(from, r.corner + a * r.edge_u + b * r.edge_v).expect("apart")
                    }
                    _ => Ray { t_min: c, ..Ray::new(from, sampling::uniform_sphere([a, b])) },
                }
            };
            let mut rays: Vec<Ray> = (0..500).map(&mut ray).collect();
            rays.push(Ray::new(DVec3::splat(f64::NAN), DVec3::X));
            rays.push(Ray::new(DVec3::splat(1e300), DVec3::NEG_X));
            rays.push(Ray::new(DVec3::ZERO, DVec3::ZERO));
            let mut met = vec![u64::MAX; rays.len()];
            together.met(&rays, &mut met);
            for (ray, met) in rays.iter().zip(met) {
                let truth = all.iter().enumerate().map(|(k, r)| u64::from(r.blocked(ray)) << k);
                assert_eq!(met, truth.sum::<u64>(), "{ray:?}");
                met_in_all += met.count_ones();
            }
        }
        assert!(met_in_all > 1000, "{met_in_all}");
    }
}
