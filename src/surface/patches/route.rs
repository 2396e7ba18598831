//! The part of a ray that the patches have to look at.
//!
//! Between the box around the body and the ball that fills it the patches decide; a ray that enters
//! the inner ball from outside has crossed the surface before, and on its way out nothing is met in
//! there.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};
use glam::DVec3;

use super::lanes::{LANES, Real};
use super::{Patches, Side};
use crate::math::Ray;

/// From which part of the squared radius of the ball on a start is outside: nothing is beyond the
/// ball, and 1e-9 radii are within every error bound.
const ON_BALL: f64 = 1.0 - 2e-9;

/// From how many largest radii off the rounding of a ray's own points is no longer small: there the
/// series answers.
const FAR: f64 = 1e9;

/// A ray, or eight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rays<R> {
    pub(super) origin: [R; 3],
    pub(super) direction: [R; 3],
    pub(super) t_min: R,
    pub(super) t_max: R,
}

/// Where rays pass the box around the body and the ball that fills it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Passage<R> {
    /// The distance at which a ray enters the box.
    enters_box: R,
    /// The part of it in the box.
    pub(super) start: R,
    pub(super) end: R,
    /// The distance at which it is nearest to the centre.
    nearest: R,
    /// The square of half its way in the ball, where positive.
    inner2: R,
}

/// A stretch of a ray that never comes into the inner ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch<R = f64> {
    /// Where it starts, in largest radii.
    pub(super) at: [R; 3],
    pub(super) direction: [R; 3],
    /// The distance along the ray at which it starts, metres.
    pub(super) start: R,
    /// Its length, in largest radii.
    pub(super) length: R,
}

/// What patches have to look at to answer a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Route {
    /// Nothing: it passes by.
    Nowhere,
    /// It starts too near the surface for patches to tell on which side, or too far off: the series
    /// must.
    Series,
    /// It starts outside; perhaps it ends where it enters the inner ball.
    Outside { stretch: Stretch, enters: bool },
    /// It starts inside; the second stretch is behind the inner ball. Either may have no length.
    Inside([Stretch; 2]),
}

impl<R: Real> Rays<R> {
    /// Returns the points at distances `t`.
    #[inline(always)]
    fn at(&self, t: R) -> [R; 3] {
        let ([ox, oy, oz], [dx, dy, dz]) = (self.origin, self.direction);
        [ox + t * dx, oy + t * dy, oz + t * dz]
    }
}

impl Rays<f64> {
    #[inline(always)]
    fn of(ray: &Ray) -> Self {
        Self {
            origin: ray.origin.to_array(),
            direction: ray.direction.to_array(),
            t_min: ray.t_min,
            t_max: ray.t_max,
        }
    }
}

impl<S: Simd> Rays<f64x8<S>> {
    /// Lays up to eight rays side by side; what is missing counts nowhere.
    #[inline(always)]
    pub(super) fn side_by_side(simd: S, rays: &[Ray]) -> Self {
        let mut lanes = [[f64::NAN; LANES]; 8];
        for (i, ray) in rays.iter().enumerate().take(LANES) {
            for axis in 0..3 {
                lanes[axis][i] = ray.origin[axis];
                lanes[3 + axis][i] = ray.direction[axis];
            }
            (lanes[6][i], lanes[7][i]) = (ray.t_min, ray.t_max);
        }
        let [ox, oy, oz, dx, dy, dz, t_min, t_max] = lanes;
        Self {
            origin: side_by_side(simd, ox, oy, oz),
            direction: side_by_side(simd, dx, dy, dz),
            t_min: f64x8::simd_from(simd, t_min),
            t_max: f64x8::simd_from(simd, t_max),
        }
    }
}

#[inline(always)]
fn side_by_side<S: Simd>(simd: S, x: [f64; 8], y: [f64; 8], z: [f64; 8]) -> [f64x8<S>; 3] {
    [f64x8::simd_from(simd, x), f64x8::simd_from(simd, y), f64x8::simd_from(simd, z)]
}

impl<S: Simd> Stretch<f64x8<S>> {
    /// Takes out one stretch.
    #[inline(always)]
    pub(super) fn lane(&self, i: usize) -> Stretch {
        Stretch {
            at: [self.at[0][i], self.at[1][i], self.at[2][i]],
            direction: [self.direction[0][i], self.direction[1][i], self.direction[2][i]],
            start: self.start[i],
            length: self.length[i],
        }
    }
}

impl<R: Real> Passage<R> {
    /// Returns which rays come into the box: none that are not numbers.
    #[inline(always)]
    pub(super) fn passes(&self) -> R::Mask {
        self.start.at_most(self.end)
    }

    /// Returns which rays start outside the box, and not too far away.
    #[inline(always)]
    pub(super) fn comes_from_outside(&self, patches: &Patches, rays: &Rays<R>) -> R::Mask {
        let far = self.nearest.all(FAR * patches.radius);
        rays.t_min.at_most(self.enters_box) & self.nearest.at_most(far)
    }
}

impl Patches {
    /// Finds the route of a ray.
    #[inline(always)]
    pub(super) fn route<S: Simd>(&self, simd: S, ray: &Ray) -> Route {
        let rays = Rays::of(ray);
        let passage = self.passage(&rays);
        if !passage.passes() {
            Route::Nowhere
        } else if passage.comes_from_outside(self, &rays) {
            let (stretch, enters) = self.outside(&rays, &passage);
            Route::Outside { stretch, enters }
        } else if passage.nearest > FAR * self.radius {
            Route::Series
        } else {
            self.within(simd, &rays, &passage)
        }
    }

    /// Finds where rays pass box and ball.
    #[inline(always)]
    pub(super) fn passage<R: Real>(&self, rays: &Rays<R>) -> Passage<R> {
        let ([ox, oy, oz], [dx, dy, dz]) = (rays.origin, rays.direction);
        let (enters_box, leaves_box) = self.through_box(rays);
        let nearest = -(ox * dx + oy * dy + oz * dz);
        let [x, y, z] = [ox + nearest * dx, oy + nearest * dy, oz + nearest * dz];
        Passage {
            enters_box,
            start: rays.t_min.most(enters_box),
            end: rays.t_max.least(leaves_box),
            nearest,
            inner2: ox.all(self.inner * self.inner) - (x * x + y * y + z * z),
        }
    }

    /// Returns the distances between which rays are in the box around the body; a ray along a face
    /// of it counts as inside.
    #[inline(always)]
    fn through_box<R: Real>(&self, rays: &Rays<R>) -> (R, R) {
        // A little more than the roundings of a quotient.
        const WIDEN: f64 = 1.0 + 4.0 * f64::EPSILON;
        let like = rays.t_min;
        let (mut enter, mut leave) = (like.all(f64::NEG_INFINITY), like.all(f64::INFINITY));
        for axis in 0..3 {
            let (o, d) = (rays.origin[axis], rays.direction[axis]);
            let inverse = like.all(1.0) / d;
            let a = (like.all(self.around.min[axis]) - o) * inverse;
            let b = (like.all(self.around.max[axis]) - o) * inverse;
            let back = inverse.less(like.all(0.0));
            // A ray in the plane of a face gives NaN, which `most` and `least` pass over.
            enter = enter.most(R::choose(back, b, a));
            leave = leave.least(R::choose(back, a, b) * like.all(WIDEN));
        }
        (enter, leave)
    }

    /// Returns the stretch of rays that start outside, and tells which enter the inner ball at its
    /// end.
    #[inline(always)]
    pub(super) fn outside<R: Real>(
        &self,
        rays: &Rays<R>,
        passage: &Passage<R>,
    ) -> (Stretch<R>, R::Mask) {
        let Passage { start, end, nearest, inner2, .. } = *passage;
        let enter = nearest - inner2.sqrt();
        let enters = start.all(0.0).less(inner2) & start.at_most(enter) & enter.at_most(end);
        (self.stretch(rays, start, R::choose(enters, enter, end)), enters)
    }

    /// Finds the route of a ray that starts in the box.
    #[inline(always)]
    fn within<S: Simd>(&self, simd: S, ray: &Rays<f64>, passage: &Passage<f64>) -> Route {
        let Passage { start, end, nearest, inner2, .. } = *passage;
        let at = DVec3::from_array(ray.at(start));
        let radius2 = at.length_squared();
        let side = if radius2 < self.inner * self.inner {
            Some(Side::Inside)
        } else if radius2 >= self.radius * self.radius * ON_BALL {
            Some(Side::Outside)
        } else {
            self.side(simd, at / self.radius)
        };
        match side {
            None => Route::Series,
            Some(Side::Outside) => {
                let (stretch, enters) = self.outside(ray, passage);
                Route::Outside { stretch, enters }
            }
            Some(Side::Inside) => {
                let half = inner2.max(0.0).sqrt();
                let (enter, leave) = (nearest - half, nearest + half);
                let crosses = half > 0.0 && enter <= end;
                let behind = if crosses { start.max(leave).min(end) } else { end };
                let before = if crosses { start.max(enter) } else { end };
                Route::Inside([self.stretch(ray, start, before), self.stretch(ray, behind, end)])
            }
        }
    }

    #[inline(always)]
    fn stretch<R: Real>(&self, rays: &Rays<R>, start: R, end: R) -> Stretch<R> {
        let per = start.all(1.0 / self.radius);
        let [x, y, z] = rays.at(start);
        Stretch {
            at: [x * per, y * per, z * per],
            direction: rays.direction,
            start,
            length: (end - start) * per,
        }
    }
}
