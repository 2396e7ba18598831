//! A ray on one cube face: in u, v and w = 1/|p0| it is a straight line.
//!
//! With p the point where the ray enters the face and k = d0 / p0, the line is (u, v, w)(tau) = (u, v, w) + tau (du, dv, dw) for
//! tau = s / (1 + k s), s the distance from p; back, s = tau / (1 - k tau). All lengths are in radii of the bounding ball.

use glam::DVec3;

use super::board::Cell;
use super::patch::Tangent;

/// The smallest slope that is told from none, so that no reciprocal is infinite.
const SMALLEST_SLOPE: f64 = 1e-12;

/// A ray from the point where it enters a face to where it leaves it or ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    /// 2 axis + (0 for the positive side, 1 for the negative).
    pub(super) face: usize,
    pub(super) u: f64,
    pub(super) v: f64,
    pub(super) w: f64,
    pub(super) du: f64,
    pub(super) dv: f64,
    pub(super) dw: f64,
    /// 1 / du and 1 / dv.
    pub(super) per_u: f64,
    pub(super) per_v: f64,
    /// The last tau.
    pub(super) end: f64,
    bend: f64,
    /// The plane through which the face is left: 0 for none, 1 and 2 for the next and the second next axis.
    through: usize,
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

/// Tells on which face a point is.
#[inline(always)]
pub(super) fn face_of(p: DVec3) -> usize {
    let a = p.abs();
    let axis = if a.x >= a.y && a.x >= a.z {
        0
    } else if a.y >= a.z {
        1
    } else {
        2
    };
    2 * axis + usize::from(p[axis] < 0.0)
}

impl Line {
    /// Starts at `p` on `face` along `d`, for a length of at most `length`.
    #[inline(always)]
    pub(super) fn new(face: usize, p: DVec3, d: DVec3, length: f64) -> Self {
        let axis = face / 2;
        let [p0, p1, p2] = turned(p, axis);
        let [d0, d1, d2] = turned(d, axis);
        let inverse = 1.0 / p0;
        let (u, v, w) = (p1 * inverse, p2 * inverse, inverse.abs());
        let (du, dv) = ((d1 - u * d0) * inverse, (d2 - v * d0) * inverse);
        let bend = d0 * inverse;
        let per = |slope: f64| 1.0 / slope.abs().max(SMALLEST_SLOPE).copysign(slope);
        let (per_u, per_v) = (per(du), per(dv));
        // Where the line meets the border of the face: always in finite tau, and before w = 0 or p0 = 0.
        let leave_u = (1.0_f64.copysign(du) - u) * per_u;
        let leave_v = (1.0_f64.copysign(dv) - v) * per_v;
        let first = leave_u.min(leave_v).max(0.0);
        let denominator = 1.0 + bend * length;
        let stop = if denominator > 0.0 { length / denominator } else { f64::INFINITY };
        let through = if stop <= first { 0 } else { 1 + usize::from(leave_v < leave_u) };
        let end = first.min(stop);
        Self { face, u, v, w, du, dv, dw: -w * bend, per_u, per_v, end, bend, through }
    }

    /// Gives the face on the other side of the border; `None` where the ray ends on this one.
    #[inline(always)]
    pub(super) fn next_face(&self) -> Option<usize> {
        if self.through == 0 {
            return None;
        }
        let slope = if self.through == 1 { self.per_u } else { self.per_v };
        let axis = (self.face / 2 + self.through) % 3;
        // The crossed coordinate is +-p0.
        Some(2 * axis + usize::from((slope < 0.0) != (self.face % 2 == 1)))
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
    pub(super) fn normal(&self, tau: f64, local: &Local, tangent: &Tangent) -> DVec3 {
        let (u, v) = (tau.mul_add(self.du, self.u), tau.mul_add(self.dv, self.v));
        let (by_u, by_v) = (tangent.dx * local.scale[0], tangent.dy * local.scale[1]);
        // The gradient of |p0| - Z(p1/p0, p2/p0) with |p0| = Z, times Z and turned outward.
        let sign = if self.face.is_multiple_of(2) { 1.0 } else { -1.0 };
        let along = sign * (tangent.height + u * by_u + v * by_v);
        let (a, b) = (-sign * by_u, -sign * by_v);
        match self.face / 2 {
            0 => DVec3::new(along, a, b),
            1 => DVec3::new(b, along, a),
            _ => DVec3::new(a, b, along),
        }
    }
}

/// Gives the coordinates along `axis` and the two after it.
#[inline(always)]
fn turned(p: DVec3, axis: usize) -> [f64; 3] {
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
