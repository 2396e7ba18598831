//! A ray on one cube face: in u, v and w = 1/|p0| it is a straight line.
//!
//! With p the point where the ray enters the face and k = d0 / p0, the line is (u, v, w)(tau) = (u,
//! v, w) + tau (du, dv, dw) for tau = s / (1 + k s), s the distance from p; back, s = tau / (1 - k
//! tau). All lengths are in radii of the bounding ball.

use fearless_simd::{Simd, f64x8};
use glam::DVec3;

use super::board::Cell;
use super::lanes::Real;
use super::patch::Tangent;

/// The smallest slope that is told from none, so that no reciprocal is infinite in f32 either.
const SMALLEST_SLOPE: f64 = 1e-30;

/// The tau of an exit that never comes: no line is longer.
const NEVER: f64 = 2.0 / SMALLEST_SLOPE;

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
    /// Which coordinate it leaves the face along at the last tau: 1 for u, 2 for v, 0 where the ray
    /// ends there.
    through: R,
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

    /// Returns (x, y) at tau.
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

/// Returns on which face a point is, 2 axis + (0 for the positive side, 1 for the negative), and
/// gives point and direction with that axis first.
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
    /// Starts at `p` along `d`, both with the axis of the face first, for a length of at most
    /// `length`.
    #[inline(always)]
    pub(super) fn new([p0, p1, p2]: [R; 3], [d0, d1, d2]: [R; 3], length: R) -> Self {
        let (zero, one) = (p0.all(0.0), p0.all(1.0));
        let inverse = one / p0;
        let (u, v, w) = (p1 * inverse, p2 * inverse, inverse.abs());
        let (du, dv) = ((d1 - u * d0) * inverse, (d2 - v * d0) * inverse);
        let bend = d0 * inverse;
        let (per_u, per_v) = (reciprocal(du), reciprocal(dv));
        let sign = one.signed_as(inverse);
        let outward = sign * d0;
        let leave_u = leaves(u, per_u, sign * d1, outward);
        let leave_v = leaves(v, per_v, sign * d2, outward);
        let first = leave_u.least(leave_v).most(zero);
        let denominator = one + bend * length;
        let stop = R::choose(zero.less(denominator), length / denominator, p0.all(f64::INFINITY));
        let through = R::choose(leave_v.less(leave_u), one + one, one);
        let through = R::choose(stop.less(first), zero, through);
        let (dw, end) = (-w * bend, first.least(stop));
        Self { u, v, w, du, dv, dw, per_u, per_v, end, bend, through }
    }
}

#[inline(always)]
fn reciprocal<R: Real>(slope: R) -> R {
    slope.all(1.0) / slope.abs().most(slope.all(SMALLEST_SLOPE)).signed_as(slope)
}

/// Returns the tau at which a line leaves its face along u or v: always finite, and before w = 0 or
/// p0 = 0. `along` and `outward` are the direction along that coordinate and p0, signed as p0.
///
/// A border is the plane p1 = +-p0 through the centre. Whether a direction crosses it, and to which
/// side, is one comparison of two of its components, exact and the same on both faces. So no line
/// crosses back and none goes around a corner, and a line in the plane stays on the face it is on.
#[inline(always)]
fn leaves<R: Real>(at: R, per: R, along: R, outward: R) -> R {
    let border = at.all(1.0).signed_as(per);
    R::choose(outward.less(border * along), (border - at) * per, at.all(NEVER))
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
            through: self.through[i],
        }
    }
}

impl Line {
    /// Returns the face on the other side of the border; `None` where the ray ends on this one.
    #[inline(always)]
    pub(super) fn next_face(&self, face: usize) -> Option<usize> {
        if self.through == 0.0 {
            return None;
        }
        let slope = if self.through == 2.0 { self.per_v } else { self.per_u };
        // The crossed coordinate is +-p0.
        let axis = (face / 2 + self.through as usize) % 3;
        Some(2 * axis + usize::from((slope < 0.0) != (face % 2 == 1)))
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

/// Returns the coordinates along `axis` and the two after it.
#[inline(always)]
pub(super) fn turned(p: DVec3, axis: usize) -> [f64; 3] {
    match axis {
        0 => [p.x, p.y, p.z],
        1 => [p.y, p.z, p.x],
        _ => [p.z, p.x, p.y],
    }
}

/// Returns the taus at which a coordinate enters and leaves a cell.
#[inline(always)]
fn ends(cell: &Cell, at: f64, per: f64) -> [f64; 2] {
    let (middle, half) = ((cell.middle - at) * per, cell.half * per.abs());
    [middle - half, middle + half]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the faces a line meets, after checking that it is on each while it counts there and
    /// that nothing of it is left over.
    fn faces(from: DVec3, direction: DVec3, length: f64) -> Vec<usize> {
        let (face, p, d) = facing(from.to_array(), direction.to_array());
        let mut faces = vec![face as usize];
        let (mut at, mut left, mut line) = (from, length, Line::new(p, d, length));
        loop {
            for tau in [0.0, line.end] {
                let [u, v] = [(line.u, line.du), (line.v, line.dv)].map(|(c, d)| c + tau * d);
                assert!(u.abs() <= 1.0 + 1e-12 && v.abs() <= 1.0 + 1e-12, "{from} {direction}");
            }
            let step = line.distance(line.end);
            let Some(face) = line.next_face(faces[faces.len() - 1]) else {
                assert!((left - step).abs() <= 1e-12, "{from} {direction}: {faces:?}");
                return faces;
            };
            faces.push(face);
            assert!(faces.len() <= 7, "{from} {direction}: {faces:?}");
            (at, left) = (at + step * direction, left - step);
            line = Line::new(turned(at, face / 2), turned(direction, face / 2), left);
        }
    }

    #[test]
    fn lines_in_and_next_to_borders_stay_on_faces_to_their_end() {
        let numbers = [-1.0, -0.5, -0.0, 0.0, 0.5, 1.0, 1.0_f64.next_down(), 0.5_f64.next_up()];
        let point = |i: usize| DVec3::new(numbers[i % 8], numbers[i / 8 % 8], numbers[i / 64]);
        let mut several = 0;
        for i in 0..512 * 512 {
            let (from, along) = (point(i / 512), point(i % 512));
            let Some(direction) = along.try_normalize() else { continue };
            // Up to a ball of a tenth about the centre, in which nothing is looked for.
            let nearest = -from.dot(direction);
            let offset2 = (from + nearest * direction).length_squared();
            let half = (0.01 - offset2).max(0.0).sqrt();
            if from.length() < 0.1 {
                continue;
            }
            let length = if half > 0.0 && nearest > 0.0 { nearest - half } else { 4.0 };
            several += usize::from(faces(from, direction, length).len() > 1);
        }
        assert!(several > 50_000, "{several}");
    }
}
