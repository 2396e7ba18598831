//! Nodes: sixteen children at once, patches or nodes, with the range of w in which the surface lies
//! over each.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use super::Side;
use super::board::Spans;
use super::line::Line;

/// Planes w = low + by_u u + by_v v below the surface over each child, lane j * 4 + i for child i
/// along u, j along v; raised by `thickness` they are above it.
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
pub(super) struct Probe {
    u: f32,
    v: f32,
    du: f32,
    dv: f32,
    per_u: f32,
    per_v: f32,
    /// w and its slope, the signs turned for a line inside.
    w: f32,
    dw: f32,
    end: f32,
    side: Side,
    /// Which ends of the spans are met first.
    near: [u8; 2],
}

/// What a node says of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Meeting {
    /// The children over which the line may meet the surface, a bit for each; bit k is child k ^
    /// [`Probe::flip`], and the lowest is met first.
    pub(super) children: u16,
    /// Whether it certainly does so over one of them.
    pub(super) certain: bool,
}

impl Node {
    /// A node without planes.
    pub(super) const EMPTY: Self =
        Self { low: [0.0; 16], thickness: [0.0; 16], by_u: [0.0; 16], by_v: [0.0; 16] };

    /// Returns on which side of the surface a line starts, over a child, if the planes can.
    #[inline(always)]
    pub(super) fn side(&self, lane: usize, line: &Line) -> Option<Side> {
        let (low, thickness) = (f64::from(self.low[lane]), f64::from(self.thickness[lane]));
        let (by_u, by_v) = (f64::from(self.by_u[lane]), f64::from(self.by_v[lane]));
        let above = line.w - low - by_u * line.u - by_v * line.v;
        if above < 0.0 {
            Some(Side::Outside)
        } else if above > thickness {
            Some(Side::Inside)
        } else {
            None
        }
    }

    /// Returns the first tau from `enter` on at which the line meets the plane of a child on the
    /// line's side; there it is before the surface still.
    #[inline(always)]
    pub(super) fn reach(&self, lane: usize, line: &Line, side: Side, enter: f64) -> f64 {
        let (low, thickness) = (f64::from(self.low[lane]), f64::from(self.thickness[lane]));
        let (by_u, by_v) = (f64::from(self.by_u[lane]), f64::from(self.by_v[lane]));
        let (sign, plane) = match side {
            Side::Outside => (1.0, low),
            Side::Inside => (-1.0, low + thickness),
        };
        let above = sign * (line.w - plane - by_u * line.u - by_v * line.v);
        let rise = sign * (line.dw - by_u * line.du - by_v * line.dv);
        // Where the plane is not reached the line may touch it within the rounding of
        // `Probe::meet`.
        if rise > 0.0 { enter.max(-above / rise) } else { enter }
    }
}

impl Probe {
    #[inline(always)]
    pub(super) fn new(line: &Line, side: Side) -> Self {
        let sign = side.sign();
        Self {
            u: line.u as f32,
            v: line.v as f32,
            du: line.du as f32,
            dv: line.dv as f32,
            per_u: line.per_u as f32,
            per_v: line.per_v as f32,
            w: (sign * line.w) as f32,
            dw: (sign * line.dw) as f32,
            end: (line.end * (1.0 + 1e-6) + 1e-6) as f32,
            side,
            // By the reciprocals, which tell -0 from 0 too.
            near: [u8::from(line.per_u < 0.0), u8::from(line.per_v < 0.0)],
        }
    }

    /// Returns what turns the number of a child into the order in which it is met.
    #[inline(always)]
    pub(super) fn flip(&self) -> usize {
        usize::from(3 * self.near[0] + 12 * self.near[1])
    }

    /// Compares the line with all children of a node.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(
        &self,
        simd: S,
        node: &Node,
        across: &Spans,
        along: &Spans,
    ) -> Meeting {
        let [nu, nv] = self.near.map(usize::from);
        let enter_u = (load(simd, &across.across[nu]) - self.u) * self.per_u;
        let enter_v = (load(simd, &along.along[nv]) - self.v) * self.per_v;
        let leave_u = (load(simd, &across.across[1 - nu]) - self.u) * self.per_u;
        let leave_v = (load(simd, &along.along[1 - nv]) - self.v) * self.per_v;
        let enter = enter_u.max(enter_v).max(f32x16::splat(simd, 0.0));
        let leave = leave_u.min(leave_v).min(self.end);
        let (by_u, by_v) = (load(simd, &node.by_u), load(simd, &node.by_v));
        let (low, thickness) = (load(simd, &node.low), load(simd, &node.thickness));
        let plane = by_u
            .mul_add(f32x16::splat(simd, self.u), by_v.mul_add(f32x16::splat(simd, self.v), low));
        let slope = by_u.mul_add(f32x16::splat(simd, self.du), by_v * self.dv);
        let (above, rise) = match self.side {
            Side::Outside => {
                (f32x16::splat(simd, self.w) - plane, f32x16::splat(simd, self.dw) - slope)
            }
            Side::Inside => (
                f32x16::splat(simd, self.w) + plane + thickness,
                f32x16::splat(simd, self.dw) + slope,
            ),
        };
        let highest = enter.mul_add(rise, above).max(leave.mul_add(rise, above));
        let crossed = enter.simd_le(leave);
        let met = crossed & highest.simd_ge(0.0);
        let through = crossed & highest.simd_gt(thickness);
        let children = in_order(met.to_bitmask() as u32, self.near) as u16;
        Meeting { children, certain: through.any_true() }
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, lanes: &[f32; 16]) -> f32x16<S> {
    f32x16::simd_from(simd, *lanes)
}

/// Turns a mask of children so that the first that a line meets is its lowest bit: along a line
/// they never go back.
#[inline(always)]
fn in_order(bits: u32, near: [u8; 2]) -> u32 {
    let within =
        (bits & 0x1111) << 3 | (bits & 0x2222) << 1 | bits >> 1 & 0x2222 | bits >> 3 & 0x1111;
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
            let flip = u32::from(3 * near[0] + 12 * near[1]);
            for bits in [0x8421_u32, 0x1248, 0xFFFF, 0x00F3, 0] {
                let ordered = in_order(bits, near);
                assert!((0..16).all(|k| ordered >> k & 1 == bits >> (k ^ flip) & 1));
            }
        }
    }
}
