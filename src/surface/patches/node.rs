//! Nodes: sixteen children at once, patches or nodes, with the range of w in which the surface lies over each.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use super::board::Spans;
use super::line::Line;
use super::Side;

/// Planes w = low + by_u u + by_v v below the surface over each child, lane j * 4 + i for child i along u, j along v; raised by `thickness` they are above it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(super) struct Node {
    pub(super) low: [f32; 16],
    pub(super) thickness: [f32; 16],
    pub(super) by_u: [f32; 16],
    pub(super) by_v: [f32; 16],
}

/// A line as nodes see it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Probe<S: Simd> {
    u: f32x16<S>,
    v: f32x16<S>,
    du: f32x16<S>,
    dv: f32x16<S>,
    per_u: f32x16<S>,
    per_v: f32x16<S>,
    /// w and its slope, the signs turned for a line inside.
    w: f32x16<S>,
    dw: f32x16<S>,
    end: f32x16<S>,
    /// Which ends of the spans are met first.
    near: [usize; 2],
    /// What turns the number of a child into the order in which it is met.
    flip: usize,
    side: Side,
}

impl Node {
    /// A node without planes.
    pub(super) const EMPTY: Self =
        Self { low: [0.0; 16], thickness: [0.0; 16], by_u: [0.0; 16], by_v: [0.0; 16] };

    /// Gives the first tau from `enter` on at which the line meets the plane of a child on the line's side; there it is before the surface still.
    #[inline(always)]
    pub(super) fn reach(&self, lane: usize, line: &Line, side: Side, enter: f64) -> f64 {
        let [low, thickness, by_u, by_v] =
            [self.low, self.thickness, self.by_u, self.by_v].map(|lanes| f64::from(lanes[lane]));
        let (sign, plane) = match side {
            Side::Outside => (1.0, low),
            Side::Inside => (-1.0, low + thickness),
        };
        let above = sign * (line.w - plane - by_u * line.u - by_v * line.v);
        let rise = sign * (line.dw - by_u * line.du - by_v * line.dv);
        // Where the plane is not reached the line may touch it within the rounding of `Probe::meet`.
        if rise > 0.0 { enter.max(-above / rise) } else { enter }
    }
}

/// Children that a line may meet, in the order in which it meets them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Met(u32);

impl Met {
    /// Takes the next child's lane, turned by the probe's flip.
    #[inline(always)]
    pub(super) fn next(&mut self, flip: usize) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let lane = self.0.trailing_zeros() as usize ^ flip;
        self.0 &= self.0 - 1;
        Some(lane)
    }
}

impl<S: Simd> Probe<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, line: &Line, side: Side) -> Self {
        let splat = |x: f64| f32x16::splat(simd, x as f32);
        let near = [usize::from(line.du < 0.0), usize::from(line.dv < 0.0)];
        Self {
            u: splat(line.u),
            v: splat(line.v),
            du: splat(line.du),
            dv: splat(line.dv),
            per_u: splat(line.per_u),
            per_v: splat(line.per_v),
            w: splat(side.sign() * line.w),
            dw: splat(side.sign() * line.dw),
            end: splat(line.end * (1.0 + 1e-6) + 1e-6),
            near,
            flip: 3 * near[0] + 12 * near[1],
            side,
        }
    }

    #[inline(always)]
    pub(super) fn flip(&self) -> usize {
        self.flip
    }

    /// Finds the children of a node over which the line may meet the surface, and tells whether it certainly does so over one of them.
    #[inline(always)]
    pub(super) fn meet(&self, simd: S, node: &Node, across: &Spans, along: &Spans) -> (Met, bool) {
        let load = |lanes: &[f32; 16]| f32x16::simd_from(simd, *lanes);
        let [nu, nv] = self.near;
        let enter_u = (load(&across.across[nu]) - self.u) * self.per_u;
        let enter_v = (load(&along.along[nv]) - self.v) * self.per_v;
        let leave_u = (load(&across.across[1 - nu]) - self.u) * self.per_u;
        let leave_v = (load(&along.along[1 - nv]) - self.v) * self.per_v;
        let enter = enter_u.max(enter_v).max(f32x16::splat(simd, 0.0));
        let leave = leave_u.min(leave_v).min(self.end);
        let (by_u, by_v) = (load(&node.by_u), load(&node.by_v));
        let (low, thickness) = (load(&node.low), load(&node.thickness));
        let plane = by_u.mul_add(self.u, by_v.mul_add(self.v, low));
        let slope = by_u.mul_add(self.du, by_v * self.dv);
        let (above, rise) = match self.side {
            Side::Outside => (self.w - plane, self.dw - slope),
            Side::Inside => (self.w + plane + thickness, self.dw + slope),
        };
        let highest = enter.mul_add(rise, above).max(leave.mul_add(rise, above));
        let crossed = enter.simd_le(leave);
        let met = crossed & highest.simd_ge(0.0);
        let through = crossed & highest.simd_gt(thickness);
        (Met(in_order(met.to_bitmask() as u32, self.near)), through.any_true())
    }
}

/// Turns a mask of children so that the first that a line meets is its lowest bit: along a line they never go back.
#[inline(always)]
fn in_order(bits: u32, near: [usize; 2]) -> u32 {
    let within = (bits & 0x1111) << 3 | (bits & 0x2222) << 1 | bits >> 1 & 0x2222 | bits >> 3 & 0x1111;
    let bits = if near[0] == 1 { within } else { bits };
    let between = bits << 12 & 0xF000 | bits << 4 & 0x0F00 | bits >> 4 & 0x00F0 | bits >> 12;
    if near[1] == 1 { between } else { bits }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_come_in_the_order_of_the_line() {
        for near in [[0, 0], [1, 0], [0, 1], [1, 1]] {
            let flip = 3 * near[0] + 12 * near[1];
            for bits in [0x8421_u32, 0x1248, 0xFFFF, 0x00F3, 0] {
                let mut met = Met(in_order(bits, near));
                let mut seen = 0;
                let mut last = None;
                while let Some(lane) = met.next(flip) {
                    assert!(last.is_none_or(|l| l < lane ^ flip));
                    last = Some(lane ^ flip);
                    seen |= 1 << lane;
                }
                assert_eq!(seen, bits);
            }
        }
    }
}
