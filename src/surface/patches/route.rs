//! The part of a ray that the patches have to look at.
//!
//! Between the box around the body and the ball that fills it the patches decide; a ray that enters the inner ball from
//! outside has crossed the surface before, and on its way out nothing is met in there.

use fearless_simd::Simd;
use glam::DVec3;

use super::{Patches, Side};
use crate::math::Ray;

/// From which part of the squared radius of the ball on a start is outside: nothing is beyond the ball, and 1e-9 radii are within every error bound.
const ON_BALL: f64 = 1.0 - 2e-9;

/// From how many largest radii off the rounding of a ray's own points is no longer small: there the series answers.
const FAR: f64 = 1e9;

/// A stretch of a ray that never comes into the inner ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    /// Where it starts, in largest radii.
    pub(super) at: DVec3,
    pub(super) direction: DVec3,
    /// The distance along the ray at which it starts, metres.
    pub(super) start: f64,
    /// Its length, in largest radii.
    pub(super) length: f64,
    pub(super) side: Side,
}

impl Stretch {
    /// A stretch of no length, to fill arrays with.
    pub(super) const NONE: Self =
        Self { at: DVec3::X, direction: DVec3::X, start: 0.0, length: 0.0, side: Side::Outside };
}

/// What patches have to look at to answer a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Route {
    /// Nothing: it passes by.
    Nowhere,
    /// It starts too near the surface for patches to tell on which side, or too far off: the series must.
    Series,
    /// It starts outside; perhaps it ends where it enters the inner ball.
    Outside { stretch: Stretch, enters: bool },
    /// It starts inside; the second stretch is behind the inner ball. Either may have no length.
    Inside([Stretch; 2]),
}

impl Patches {
    /// Finds the route of a ray.
    #[inline(always)]
    pub(super) fn route<S: Simd>(&self, simd: S, ray: &Ray) -> Route {
        let (o, d) = (ray.origin, ray.direction);
        let (enters_box, leaves_box) = self.through_box(ray);
        let (start, end) = (ray.t_min.max(enters_box), ray.t_max.min(leaves_box));
        // Not so for a ray that is not a number.
        let passes = start <= end;
        if !passes {
            return Route::Nowhere;
        }
        let nearest = -o.dot(d);
        if nearest > FAR * self.radius {
            return Route::Series;
        }
        let inner2 = self.inner * self.inner - (o + nearest * d).length_squared();
        if enters_box >= ray.t_min {
            let enter = if inner2 > 0.0 { nearest - inner2.sqrt() } else { f64::INFINITY };
            return self.outside(ray, start, end, enter);
        }
        self.within(simd, ray, start, end, nearest, inner2)
    }

    /// Gives the distances between which a ray is in the box around the body; a ray along a face of it counts as inside.
    #[inline(always)]
    fn through_box(&self, ray: &Ray) -> (f64, f64) {
        // A little more than the roundings of a quotient.
        const WIDEN: f64 = 1.0 + 4.0 * f64::EPSILON;
        let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
        let (min, max) = (self.around.min.to_array(), self.around.max.to_array());
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            let inverse = 1.0 / d[axis];
            let (a, b) = ((min[axis] - o[axis]) * inverse, (max[axis] - o[axis]) * inverse);
            // A ray in the plane of a face gives NaN, which max and min pass over.
            let (first, last) = if inverse < 0.0 { (b, a) } else { (a, b) };
            enter = enter.max(first);
            leave = leave.min(last * WIDEN);
        }
        (enter, leave)
    }

    #[inline(always)]
    fn outside(&self, ray: &Ray, start: f64, end: f64, enter: f64) -> Route {
        let enters = start <= enter && enter <= end;
        let end = if enters { enter } else { end };
        Route::Outside { stretch: self.stretch(ray, start, end, Side::Outside), enters }
    }

    /// Finds the route of a ray that starts in the box.
    #[inline(always)]
    fn within<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        start: f64,
        end: f64,
        nearest: f64,
        inner2: f64,
    ) -> Route {
        let at = ray.at(start);
        let radius2 = at.length_squared();
        let half = inner2.max(0.0).sqrt();
        let (enter, leave) = if half > 0.0 {
            (nearest - half, nearest + half)
        } else {
            (f64::INFINITY, f64::INFINITY)
        };
        let side = if radius2 < self.inner * self.inner {
            Some(Side::Inside)
        } else if radius2 >= self.radius * self.radius * ON_BALL {
            Some(Side::Outside)
        } else {
            self.side(simd, at / self.radius)
        };
        match side {
            None => Route::Series,
            Some(Side::Outside) => self.outside(ray, start, end, enter),
            Some(Side::Inside) => {
                let behind = if enter <= end { start.max(leave).min(end) } else { end };
                let before = start.max(end.min(enter));
                Route::Inside([
                    self.stretch(ray, start, before, Side::Inside),
                    self.stretch(ray, behind, end, Side::Inside),
                ])
            }
        }
    }

    #[inline(always)]
    fn stretch(&self, ray: &Ray, start: f64, end: f64, side: Side) -> Stretch {
        let per = 1.0 / self.radius;
        let (at, length) = (ray.at(start) * per, (end - start) * per);
        Stretch { at, direction: ray.direction, start, length, side }
    }
}
