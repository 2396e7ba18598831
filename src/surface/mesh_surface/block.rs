//! A ray against eight triangles at once: the watertight test of Woop, Benthin and Wald
//! ("Watertight Ray/Triangle Intersection", JCGT 2(1), 2013) in f64.
//!
//! Why no ray slips between two faces. Vertices are sheared so that the ray becomes the axis; each
//! vertex is sheared in the same way for every face and lane (by the same instructions, fused or
//! not). The sign of an edge, c.x b.y - c.y b.x, is that of a comparison of two products, each
//! rounded by itself and never fused; rounding keeps order, so a sign is right or zero, and where
//! it is zero the exact one is computed from the products' own rounding errors. Borders belong to
//! both neighbours. The sheared faces thus cover the plane as the exact ones do.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};
use glam::DVec3;

use super::super::Bvh;
use crate::math::Ray;
use crate::math::lanes::splat;
use crate::mesh::Mesh;

/// Triangles in a block.
pub(super) const LANES: usize = Bvh::PLACES;

/// Holds the triangles of a leaf.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Block {
    /// Coordinates by corner, axis and lane.
    corners: [[[f64; LANES]; 3]; 3],
    faces: [u32; LANES],
}

/// A ray turned into the axis z, its largest component.
pub(super) struct Shear<S: Simd> {
    /// The axes that become x, y and z.
    axes: [usize; 3],
    /// The origin, by those axes.
    origin: [f64x8<S>; 3],
    /// dx/dz, dy/dz, 1/dz.
    slopes: [f64x8<S>; 3],
}

/// Where a ray meets a triangle: its lane, its distance and the weights of the second and third
/// corner.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Meeting {
    pub(super) lane: usize,
    pub(super) distance: f64,
    pub(super) v: f64,
    pub(super) w: f64,
}

impl<S: Simd> Shear<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let z = largest_axis(ray.direction);
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][z];
        let inverse = 1.0 / d[z];
        let origin = ray.origin.to_array();
        Self {
            axes,
            origin: splat(simd, axes.map(|axis| origin[axis])),
            slopes: splat(simd, [d[axes[0]] * inverse, d[axes[1]] * inverse, inverse]),
        }
    }
}

impl Block {
    /// Lays out faces of a mesh.
    pub(super) fn new(mesh: &Mesh, faces: [u32; LANES]) -> Self {
        let mut corners = [[[0.0; LANES]; 3]; 3];
        for (lane, &face) in faces.iter().enumerate() {
            for (corner, point) in corners.iter_mut().zip(mesh.corners(face as usize)) {
                for axis in 0..3 {
                    corner[axis][lane] = point[axis];
                }
            }
        }
        Self { corners, faces }
    }

    /// Returns the number and the corners of one triangle.
    #[inline(always)]
    pub(super) fn face(&self, lane: usize) -> (u32, [DVec3; 3]) {
        let [a, b, c] = &self.corners;
        let point = |p: &[[f64; LANES]; 3]| DVec3::new(p[0][lane], p[1][lane], p[2][lane]);
        (self.faces[lane], [point(a), point(b), point(c)])
    }

    /// Shears one corner of every triangle.
    #[inline(always)]
    fn map<S: Simd>(&self, simd: S, shear: &Shear<S>, corner: usize) -> [f64x8<S>; 3] {
        let [x, y, z] = [
            self.offset(simd, shear, corner, 0),
            self.offset(simd, shear, corner, 1),
            self.offset(simd, shear, corner, 2),
        ];
        [(-shear.slopes[0]).mul_add(z, x), (-shear.slopes[1]).mul_add(z, y), z]
    }

    /// Returns how far one corner of every triangle is from the origin along one of the sheared
    /// axes.
    #[inline(always)]
    fn offset<S: Simd>(&self, simd: S, shear: &Shear<S>, corner: usize, i: usize) -> f64x8<S> {
        f64x8::from_slice(simd, &self.corners[corner][shear.axes[i]]) - shear.origin[i]
    }

    /// Returns the nearest meeting with any of the triangles, from either side, between two
    /// distances.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(
        &self,
        simd: S,
        shear: &Shear<S>,
        t_min: f64,
        t_max: f64,
    ) -> Option<Meeting> {
        let [a, b, c] =
            [self.map(simd, shear, 0), self.map(simd, shear, 1), self.map(simd, shear, 2)];
        let (mut u, mut v, mut w) = (side(c, b), side(a, c), side(b, a));
        let mut inside = around(u, v, w);
        if inside == 0 {
            return None;
        }
        let zero = inside & (u * v * w).simd_eq(0.0).to_bitmask() as u32;
        if zero != 0 {
            let mut sides: [[f64; LANES]; 3] = [u.into(), v.into(), w.into()];
            let corners = [
                [a[0].into(), a[1].into()],
                [b[0].into(), b[1].into()],
                [c[0].into(), c[1].into()],
            ];
            sides_exactly(&mut sides, &corners, zero);
            u = f64x8::simd_from(simd, sides[0]);
            v = f64x8::simd_from(simd, sides[1]);
            w = f64x8::simd_from(simd, sides[2]);
            inside &= around(u, v, w);
        }
        let sum = u + v + w;
        let depth = u.mul_add(a[2], v.mul_add(b[2], w * c[2]));
        // Where all sides are zero the distance is no number and within nothing.
        let distance = depth / sum * shear.slopes[2];
        let within = distance.simd_ge(t_min).to_bitmask() & distance.simd_le(t_max).to_bitmask();
        let met = inside & within as u32;
        if met == 0 {
            return None;
        }
        let (lane, nearest) = nearest(met, &distance.into());
        let (v, w, sum): ([f64; LANES], [f64; LANES], [f64; LANES]) =
            (v.into(), w.into(), sum.into());
        Some(Meeting { lane, distance: nearest, v: v[lane] / sum[lane], w: w[lane] / sum[lane] })
    }
}

/// Returns the lane of the least distance of those that are marked, and the distance.
#[inline(always)]
fn nearest(mut marked: u32, distances: &[f64; LANES]) -> (usize, f64) {
    let (mut lane, mut nearest) = (0, f64::INFINITY);
    while marked != 0 {
        let next = marked.trailing_zeros() as usize % LANES;
        marked &= marked - 1;
        if distances[next] <= nearest {
            (lane, nearest) = (next, distances[next]);
        }
    }
    (lane, nearest)
}

/// Marks the triangles the axis passes through: all sides of one sign, or zero.
#[inline(always)]
fn around<S: Simd>(u: f64x8<S>, v: f64x8<S>, w: f64x8<S>) -> u32 {
    let (low, high) = (u.min(v).min(w), u.max(v).max(w));
    (low.simd_ge(0.0).to_bitmask() | high.simd_le(0.0).to_bitmask()) as u32
}

/// Returns the axis along which a vector is longest.
#[inline(always)]
fn largest_axis(d: DVec3) -> usize {
    let d = d.abs();
    if d.x > d.y && d.x > d.z {
        0
    } else if d.y > d.z {
        1
    } else {
        2
    }
}

/// Returns on which side of the edge from q to p the axis passes: twice a signed area, its sign
/// right or zero.
#[inline(always)]
fn side<S: Simd>(p: [f64x8<S>; 3], q: [f64x8<S>; 3]) -> f64x8<S> {
    p[0] * q[1] - p[1] * q[0]
}

/// Computes the sides of the marked triangles again, exactly; `corners` holds x and y of each.
#[cold]
#[inline(never)]
fn sides_exactly(sides: &mut [[f64; LANES]; 3], corners: &[[[f64; LANES]; 2]; 3], mut marked: u32) {
    while marked != 0 {
        let lane = marked.trailing_zeros() as usize % LANES;
        marked &= marked - 1;
        let [a, b, c] = corners.map(|[x, y]| [x[lane], y[lane]]);
        sides[0][lane] = exact_side(c, b);
        sides[1][lane] = exact_side(a, c);
        sides[2][lane] = exact_side(b, a);
    }
}

/// Returns a side with the rounding errors of both products taken back: zero only where the axis
/// passes through the edge to within the rounding of those errors themselves.
fn exact_side(p: [f64; 2], q: [f64; 2]) -> f64 {
    let (left, right) = (p[0] * q[1], p[1] * q[0]);
    let (left_error, right_error) = (p[0].mul_add(q[1], -left), p[1].mul_add(q[0], -right));
    (left - right) + (left_error - right_error)
}
