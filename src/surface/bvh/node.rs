//! A node of eight children and the test of its boxes, all at once.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};
use glam::DVec3;

/// Children of a node.
pub(super) const WIDTH: usize = 8;
/// The smallest direction component, so that no reciprocal is infinite.
const SMALLEST_SLOPE: f64 = 1e-12;

/// A box in the units of the tree: smallest and largest x, y, z.
pub(super) type SmallBox = [[f32; 3]; 2];

/// Holds eight children: their planes, lane by lane, and where they are. A lane without a child has
/// a box nothing meets.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Node {
    /// Smallest and largest x, y, z.
    planes: [[[f32; WIDTH]; 3]; 2],
    /// The number of the child node, or of the first box of a leaf.
    first: [u32; WIDTH],
    /// How many boxes a leaf holds; 0 for a child node.
    boxes: [u32; WIDTH],
}

/// Names a child node or a leaf.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Child {
    /// The number of the node, or of the first box of the leaf.
    pub(super) first: u32,
    /// How many boxes the leaf holds; 0 for a node.
    pub(super) boxes: u32,
}

/// A ray as the tree sees it.
pub(super) struct TreeRay<S: Simd> {
    inverse: [f32x8<S>; 3],
    /// The start times `inverse`.
    shift: [f32x8<S>; 3],
    /// For each axis which of the two planes is met first.
    near: [usize; 3],
}

impl<S: Simd> TreeRay<S> {
    /// Starts a ray at a point given in the units of the tree.
    #[inline(always)]
    pub(super) fn new(simd: S, start: DVec3, inverse: DVec3) -> Self {
        let most = DVec3::splat(1.0 / SMALLEST_SLOPE);
        let inverse = inverse.clamp(-most, most).as_vec3().to_array();
        let start = start.as_vec3().to_array();
        Self {
            inverse: [
                f32x8::splat(simd, inverse[0]),
                f32x8::splat(simd, inverse[1]),
                f32x8::splat(simd, inverse[2]),
            ],
            shift: [
                f32x8::splat(simd, start[0] * inverse[0]),
                f32x8::splat(simd, start[1] * inverse[1]),
                f32x8::splat(simd, start[2] * inverse[2]),
            ],
            near: inverse.map(|d| usize::from(d < 0.0)),
        }
    }
}

impl Node {
    pub(super) const EMPTY: Self = Self {
        planes: [[[f32::INFINITY; WIDTH]; 3], [[f32::NEG_INFINITY; WIDTH]; 3]],
        first: [0; WIDTH],
        boxes: [0; WIDTH],
    };

    pub(super) fn fill(&mut self, lane: usize, bounds: SmallBox, child: Child) {
        for (planes, corner) in self.planes.iter_mut().zip(bounds) {
            for (plane, x) in planes.iter_mut().zip(corner) {
                plane[lane] = x;
            }
        }
        self.first[lane] = child.first;
        self.boxes[lane] = child.boxes;
    }

    #[inline(always)]
    pub(super) fn child(&self, lane: usize) -> Child {
        Child { first: self.first[lane], boxes: self.boxes[lane] }
    }

    /// Returns half the area of a child's box; 0 without a child.
    #[cfg(test)]
    pub(super) fn half_area(&self, lane: usize) -> f32 {
        let [x, y, z] =
            [0, 1, 2].map(|axis| self.planes[1][axis][lane] - self.planes[0][axis][lane]);
        if x < 0.0 { 0.0 } else { x * y + y * z + z * x }
    }

    /// Marks the children whose boxes the ray enters before `limit`, and gives the distances at
    /// which it enters.
    #[inline(always)]
    pub(super) fn met_by<S: Simd>(
        &self,
        simd: S,
        ray: &TreeRay<S>,
        limit: f32,
    ) -> (u32, [f32; WIDTH]) {
        let [x, y, z] = ray.near;
        let [near_x, near_y, near_z] = [
            self.distance(simd, ray, x, 0),
            self.distance(simd, ray, y, 1),
            self.distance(simd, ray, z, 2),
        ];
        let [far_x, far_y, far_z] = [
            self.distance(simd, ray, 1 - x, 0),
            self.distance(simd, ray, 1 - y, 1),
            self.distance(simd, ray, 1 - z, 2),
        ];
        let enters = near_x.max(near_y).max(near_z.max(0.0));
        let leaves = far_x.min(far_y).min(far_z.min(limit));
        (enters.simd_le(leaves).to_bitmask() as u32, enters.into())
    }

    /// Returns the distances at which the ray passes the planes of one side.
    #[inline(always)]
    fn distance<S: Simd>(&self, simd: S, ray: &TreeRay<S>, side: usize, axis: usize) -> f32x8<S> {
        let plane = f32x8::from_slice(simd, &self.planes[side & 1][axis]);
        plane.mul_sub(ray.inverse[axis], ray.shift[axis])
    }

    /// Marks the children whose boxes overlap one.
    #[inline(always)]
    pub(super) fn overlapped_by<S: Simd>(&self, simd: S, with: &SmallBox) -> u32 {
        let mut met = 0xff;
        for (low, &end) in self.planes[0].iter().zip(&with[1]) {
            met &= f32x8::from_slice(simd, low).simd_le(end).to_bitmask();
        }
        for (high, &start) in self.planes[1].iter().zip(&with[0]) {
            met &= f32x8::from_slice(simd, high).simd_ge(start).to_bitmask();
        }
        met as u32
    }
}
