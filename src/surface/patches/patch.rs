//! One patch: a polynomial of degree 7 in each direction that lies certainly above the surface, and
//! the first root of a line against it.
//!
//! With x, y in [-1, 1] the height is Z(x, y) = base + sum c_ij x^i y^j. A line (x, y, w)(tau) is
//! outside while F = 1 - w Z > 0. Between here and D = 2 F / (sqrt(F'^2 + 2 K F) - F') there is no
//! root when F'' >= -K, as in certified stepping, but K is that of this patch.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use super::Side;
use super::line::{Line, Local};

/// Degree of a patch in each direction, plus one.
pub(super) const ORDER: usize = 8;

/// Holds the polynomial and its bounds, in radii of the bounding ball.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(super) struct Patch {
    /// Row k: the coefficients of x^i y^(2k), then those of x^i y^(2k+1); the constant is kept
    /// apart.
    pub(super) rows: [[f32; 16]; ORDER / 2],
    /// The constant, raised so that the polynomial is nowhere below the surface.
    pub(super) base: f64,
    /// How far the polynomial is above the surface at most; lowered by this it is nowhere above.
    pub(super) width: f32,
    /// Bounds the length of the gradient in x and y.
    pub(super) slope: f32,
    /// Bounds the second derivative along any unit direction in x and y.
    pub(super) curvature: f32,
}

/// Where the search for a root on a patch stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Search {
    pub(super) tau: f64,
    pub(super) local: Local,
    /// Bounds |F''|.
    bend: f64,
    steps: u32,
}

impl Search {
    /// No search.
    pub(super) const NONE: Self = Self { tau: 0.0, local: Local::NONE, bend: 0.0, steps: 0 };
}

/// What a step of a search found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Step {
    /// Nothing yet.
    On,
    /// The root is where the search stands; the tangent is of there or of a small step before.
    Root(Tangent),
    /// There is no root on this patch.
    Past,
}

/// Height and gradient at a point of a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tangent {
    pub(super) height: f64,
    pub(super) dx: f64,
    pub(super) dy: f64,
}

impl Tangent {
    /// Stands where nobody asks for the tangent.
    pub(super) const UNKNOWN: Self = Self { height: f64::NAN, dx: f64::NAN, dy: f64::NAN };
}

/// Steps that a search may take; then it ends as if it had found a root, too early rather than
/// never. Away from a root a step is at least sqrt(2 TOLERANCE / K), so that only a K beyond all
/// measure gets here: the most of 4 million rays, one in a hundred grazing, are 184.
const STEPS: u32 = 100_000;

/// The largest F that counts as a root, in largest radii: F times the distance from the centre is
/// the radial distance.
pub(super) const TOLERANCE: f64 = 1e-7;

const fn pattern(bit: usize, set: f32, clear: f32) -> [f32; 16] {
    let mut lanes = [clear; 16];
    let mut i = 0;
    while i < 16 {
        if i >> bit & 1 == 1 {
            lanes[i] = set;
        }
        i += 1;
    }
    lanes
}

/// Lanes whose number has bit k, and those that have it not.
const SET: [[f32; 16]; 4] =
    [pattern(0, 1.0, 0.0), pattern(1, 1.0, 0.0), pattern(2, 1.0, 0.0), pattern(3, 1.0, 0.0)];
const CLEAR: [[f32; 16]; 4] =
    [pattern(0, 0.0, 1.0), pattern(1, 0.0, 1.0), pattern(2, 0.0, 1.0), pattern(3, 0.0, 1.0)];
/// The power of x in each lane.
const POWER: [f32; 16] = [0., 1., 2., 3., 4., 5., 6., 7., 0., 1., 2., 3., 4., 5., 6., 7.];

/// The sums over even powers of y, and their derivative by y^2, and the monomials they are
/// multiplied with.
struct Folded<S: Simd> {
    sums: f32x16<S>,
    slopes: f32x16<S>,
    /// x^i in the lower lanes, x^i y in the upper.
    monomials: f32x16<S>,
    by_x: f32x16<S>,
    by_y: f32x16<S>,
}

// Functions, not closures: a closure does not take the instruction set over from where it is
// written.

/// Returns `value` in the lanes whose number has a bit, 1 in the others.
#[inline(always)]
fn factor<S: Simd>(simd: S, bit: usize, value: f32) -> f32x16<S> {
    let set = f32x16::simd_from(simd, SET[bit]);
    set.mul_add(f32x16::splat(simd, value), f32x16::simd_from(simd, CLEAR[bit]))
}

#[inline(always)]
fn total<S: Simd>(lanes: f32x16<S>) -> f64 {
    f64::from(lanes.reduce_sum())
}

impl Patch {
    #[inline(always)]
    fn fold<S: Simd>(&self, simd: S, x: f32, y: f32) -> Folded<S> {
        let square = f32x16::splat(simd, y * y);
        let high = f32x16::simd_from(simd, self.rows[3]);
        let middle = high.mul_add(square, f32x16::simd_from(simd, self.rows[2]));
        let low = middle.mul_add(square, f32x16::simd_from(simd, self.rows[1]));
        let sums = low.mul_add(square, f32x16::simd_from(simd, self.rows[0]));
        let slopes = high.mul_add(square, middle).mul_add(square, low);
        let x2 = x * x;
        let powers = factor(simd, 0, x) * factor(simd, 1, x2) * factor(simd, 2, x2 * x2);
        let monomials = powers * factor(simd, 3, y);
        let by_x = f32x16::splat(simd, 0.0).slide::<15>(monomials) * f32x16::simd_from(simd, POWER);
        let by_y = powers * f32x16::simd_from(simd, SET[3]);
        Folded { sums, slopes, monomials, by_x, by_y }
    }

    /// Evaluates the height and its gradient.
    #[inline(always)]
    pub(super) fn tangent<S: Simd>(&self, simd: S, x: f64, y: f64) -> Tangent {
        let f = self.fold(simd, x as f32, y as f32);
        let dy =
            (f.slopes * f.monomials).mul_add(f32x16::splat(simd, 2.0 * y as f32), f.sums * f.by_y);
        let (height, dx) = (total(f.sums * f.monomials), total(f.sums * f.by_x));
        Tangent { height: self.base + height, dx, dy: total(dy) }
    }

    /// Prepares the search for the first root in the stretch of the line over this patch.
    #[inline(always)]
    pub(super) fn search(&self, line: &Line, local: Local) -> Search {
        Search { tau: local.enter, bend: self.bend(line, &local), local, steps: 0 }
    }

    /// Looks at F where the search stands, and moves on as far as there is certainly no root.
    #[inline(always)]
    pub(super) fn step<S: Simd>(
        &self,
        simd: S,
        line: &Line,
        side: Side,
        search: &mut Search,
    ) -> Step {
        let Search { tau, bend, local, .. } = *search;
        let sign = side.sign();
        let [x, y] = local.at(tau);
        let tangent = self.tangent(simd, x, y);
        let lower = if side == Side::Inside { f64::from(self.width) } else { 0.0 };
        let height = tangent.height - lower;
        let slope = tangent.dx.mul_add(local.by[0], tangent.dy * local.by[1]);
        let w = line.w_at(tau);
        let value = sign * (1.0 - w * height);
        let change = -sign * (line.dw * height + w * slope);
        let root = change.mul_add(change, 2.0 * bend * value.max(0.0)).sqrt();
        let falling = change < 0.0;
        // One division for both forms of the step.
        let (over, under) =
            if falling { (2.0 * value, root - change) } else { (change + root, bend) };
        let step = over / under;
        search.steps += 1;
        // F at the end of a step down is at most K step^2: no need to look where that is nothing.
        let near = falling && bend * step * step <= TOLERANCE || search.steps == STEPS;
        if value <= TOLERANCE {
            return Step::Root(tangent);
        }
        search.tau = tau + step;
        let within = search.tau <= local.leave;
        if !within {
            return Step::Past;
        }
        if near { Step::Root(tangent) } else { Step::On }
    }

    /// Bounds |F''| along the line in this patch.
    #[inline(always)]
    fn bend(&self, line: &Line, local: &Local) -> f64 {
        let speed2 = local.by[0] * local.by[0] + local.by[1] * local.by[1];
        let w = line.w_at(local.enter).max(line.w_at(local.leave));
        let turn = 2.0 * line.dw.abs() * f64::from(self.slope) * speed2.sqrt();
        (turn + w * f64::from(self.curvature) * speed2).max(f64::MIN_POSITIVE)
    }
}
