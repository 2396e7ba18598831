//! A ray on one cube face: in u, v and w = 1/|p0| it is a straight line.
//!
//! With p the point where the ray enters the face and k = d0 / p0, the line is (u, v, w)(tau) = (u, v, w) + tau (du, dv, dw) for
//! tau = s / (1 + k s), s the distance from p; back, s = tau / (1 - k tau). All lengths are in radii of the bounding ball.

use fearless_simd::{Simd, f64x8};
use glam::DVec3;

use super::board::Cell;
use super::lanes::Real;
use super::patch::Tangent;

/// The smallest slope that is told from none, so that no reciprocal is infinite.
const SMALLEST_SLOPE: f64 = 1e-12;

/// A ray from the point where it enters a face to where it leaves it or ends, or eight of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line<R = f64> {
    pub(super) u: R,
    pub(super) v: R,
    pub(super) w: R,
    pub(super) du: R,
    pub(super) dv: R,
    pub(super) dw: R,
    /// 1 / du and 1 / dv.
    pub(super) per_u: R,
    pub(super) per_v: R,
    /// The last tau.
    pub(super) end: R,
    bend: R,
}

/// The stretch of a line over one patch, in the coordinates of the patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Local {
    origin: [f64; 2],
    /// x and y per u and v.
    scale: [f64; 2],
    /// The velocity (dx, dy).
    pub(super) by: [f64; 2],
    pub(super) enter: f64,
    pub(super) leave: f64,
}

impl Local {
    /// Nowhere.
    pub(super) const NONE: Self =
        Self { origin: [0.0; 2], scale: [0.0; 2], by: [0.0; 2], enter: 0.0, leave: 0.0 };

    /// Gives (x, y) at tau.
    #[inline(always)]
    pub(super) fn at(&self, tau: f64) -> [f64; 2] {
        [tau.mul_add(self.by[0], self.origin[0]), tau.mul_add(self.by[1], self.origin[1])]
    }
}

/// Which of its coordinates is the largest of a point: the first, or else the second.
#[derive(Clone, Copy)]
struct Axis<R: Real> {
    is_x: R::Mask,
    is_y: R::Mask,
}

impl<R: Real> Axis<R> {
    #[inline(always)]
    fn pick(&self, x: R, y: R, z: R) -> R {
        R::choose(self.is_x, x, R::choose(self.is_y, y, z))
    }

    /// Turns a vector so that this axis is its first.
    #[inline(always)]
    fn turned(&self, [x, y, z]: [R; 3]) -> [R; 3] {
        [self.pick(x, y, z), self.pick(y, z, x), self.pick(z, x, y)]
    }
}

/// Tells on which face a point is, 2 axis + (0 for the positive side, 1 for the negative), and gives point and direction with that axis first.
#[inline(always)]
pub(super) fn facing<R: Real>([x, y, z]: [R; 3], direction: [R; 3]) -> (R, [R; 3], [R; 3]) {
    let (a, b, c) = (x.abs(), y.abs(), z.abs());
    let axis = Axis { is_x: b.at_most(a) & c.at_most(a), is_y: c.at_most(b) };
    let point = axis.turned([x, y, z]);
    let (zero, one) = (x.all(0.0), x.all(1.0));
    let face = axis.pick(zero, x.all(2.0), x.all(4.0)) + R::choose(point[0].less(zero), one, zero);
    (face, point, axis.turned(direction))
}

impl<R: Real> Line<R> {
    /// Starts at `p` along `d`, both with the axis of the face first, for a length of at most `length`.
    #[inline(always)]
    pub(super) fn new([p0, p1, p2]: [R; 3], [d0, d1, d2]: [R; 3], length: R) -> Self {
        let (zero, one) = (p0.all(0.0), p0.all(1.0));
        let inverse = one / p0;
        let (u, v, w) = (p1 * inverse, p2 * inverse, inverse.abs());
        let (du, dv) = ((d1 - u * d0) * inverse, (d2 - v * d0) * inverse);
        let bend = d0 * inverse;
        let (per_u, per_v) = (reciprocal(du), reciprocal(dv));
        let first = leaves(u, per_u).least(leaves(v, per_v)).most(zero);
        let denominator = one + bend * length;
        let stop = R::choose(zero.less(denominator), length / denominator, p0.all(f64::INFINITY));
        Self { u, v, w, du, dv, dw: -w * bend, per_u, per_v, end: first.least(stop), bend }
    }
}

#[inline(always)]
fn reciprocal<R: Real>(slope: R) -> R {
    slope.all(1.0) / slope.abs().most(slope.all(SMALLEST_SLOPE)).signed_as(slope)
}

/// Gives the tau at which a line meets the border of its face along u or v: always finite, and before w = 0 or p0 = 0.
#[inline(always)]
fn leaves<R: Real>(at: R, per: R) -> R {
    (at.all(1.0).signed_as(per) - at) * per
}

impl<S: Simd> Line<f64x8<S>> {
    /// Takes out one line.
    #[inline(always)]
    pub(super) fn lane(&self, i: usize) -> Line {
        Line {
            u: self.u[i],
            v: self.v[i],
            w: self.w[i],
            du: self.du[i],
            dv: self.dv[i],
            dw: self.dw[i],
            per_u: self.per_u[i],
            per_v: self.per_v[i],
            end: self.end[i],
            bend: self.bend[i],
        }
    }
}

impl Line {
    /// Gives the face on the other side of the border; `None` where the ray ends on this one.
    #[inline(always)]
    pub(super) fn next_face(&self, face: usize) -> Option<usize> {
        let (leave_u, leave_v) = (leaves(self.u, self.per_u), leaves(self.v, self.per_v));
        if self.end < leave_u.least(leave_v).most(0.0) {
            return None;
        }
        let (through, slope) = if leave_v < leave_u { (2, self.per_v) } else { (1, self.per_u) };
        // The crossed coordinate is +-p0.
        Some(2 * ((face / 2 + through) % 3) + usize::from((slope < 0.0) != (face % 2 == 1)))
    }

    /// Turns tau into the distance from where the line started.
    #[inline(always)]
    pub(super) fn distance(&self, tau: f64) -> f64 {
        tau / (1.0 - self.bend * tau)
    }

    #[inline(always)]
    pub(super) fn w_at(&self, tau: f64) -> f64 {
        tau.mul_add(self.dw, self.w)
    }

    /// Restricts the line to one patch.
    #[inline(always)]
    pub(super) fn over(&self, across: &Cell, along: &Cell) -> Local {
        let [u0, u1] = ends(across, self.u, self.per_u);
        let [v0, v1] = ends(along, self.v, self.per_v);
        Local {
            origin: [
                (self.u - across.middle) * across.scale,
                (self.v - along.middle) * along.scale,
            ],
            scale: [across.scale, along.scale],
            by: [self.du * across.scale, self.dv * along.scale],
            enter: u0.max(v0).max(0.0),
            leave: u1.min(v1).min(self.end),
        }
    }

    /// Turns a tangent of a patch at tau into the outward normal in space, not of unit length.
    #[inline(always)]
    pub(super) fn normal(&self, face: usize, tau: f64, local: &Local, tangent: &Tangent) -> DVec3 {
        let (u, v) = (tau.mul_add(self.du, self.u), tau.mul_add(self.dv, self.v));
        let (by_u, by_v) = (tangent.dx * local.scale[0], tangent.dy * local.scale[1]);
        // The gradient of |p0| - Z(p1/p0, p2/p0) with |p0| = Z, times Z and turned outward.
        let sign = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
        let along = sign * (tangent.height + u * by_u + v * by_v);
        let (a, b) = (-sign * by_u, -sign * by_v);
        match face / 2 {
            0 => DVec3::new(along, a, b),
            1 => DVec3::new(b, along, a),
            _ => DVec3::new(a, b, along),
        }
    }
}

/// Gives the coordinates along `axis` and the two after it.
#[inline(always)]
pub(super) fn turned(p: DVec3, axis: usize) -> [f64; 3] {
    match axis {
        0 => [p.x, p.y, p.z],
        1 => [p.y, p.z, p.x],
        _ => [p.z, p.x, p.y],
    }
}

/// Gives the taus at which a coordinate enters and leaves a cell.
#[inline(always)]
fn ends(cell: &Cell, at: f64, per: f64) -> [f64; 2] {
    let (middle, half) = ((cell.middle - at) * per, cell.half * per.abs());
    [middle - half, middle + half]
}
