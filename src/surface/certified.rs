//! Certified stepping: the first root of the gap along a ray, never missed.
//!
//! Between here and a distance D the gap G has no root if its second derivative stays above -K:
//! G(t + s) >= G + G' s - K s^2 / 2. The step is the positive root of that parabola, which becomes
//! Newton's step near a root, so it converges quadratically from one side and never passes a root.
//! Along a ray at distance h from the origin, |f''| <= (M2 h^2 + 2 M1 h s) / rho^4 with rho^2 =
//! h^2 + s^2, M1 and M2 the bounds of slope and curvature along great circles, and |p|'' >= 0
//! (outside) or <= 1/rho (seen from inside). Where the shell of the body shows that the ray passes
//! above the surface, or that it is inside, the series is not evaluated at all.
//!
//! A ray is looked at from where it is nearest to the centre: from however far it comes, its points
//! are rounded as those near the body are, and it is not kept in a cell of the shell that it left.

use glam::DVec3;

use super::radial::{Chord, Gap, RadialBody};
use super::shell::Stay;
use crate::math::Ray;

/// Where a ray crosses the surface.
pub(super) struct Crossing {
    pub(super) distance: f64,
    pub(super) point: DVec3,
    pub(super) gap: Gap,
}

/// Finds the first point at which the ray crosses the surface, with the gap there (within
/// [`RadialBody::tolerance`] of zero, or one rounding of the distance past it).
pub(super) fn first_crossing(body: &RadialBody, ray: &Ray) -> Option<Crossing> {
    let (nearest, near) = from_nearest(ray)?;
    let chord = body.chord(&near)?;
    let (t, gap) = match start(body, &near, &chord) {
        Start::Inside => from_inside(body, &near, &chord)?,
        Start::Outside(gap) => from_outside(body, &near, &chord, gap)?,
    };
    let distance = (nearest + t).max(ray.t_min).min(ray.t_max);
    Some(Crossing { distance, point: near.at(t), gap })
}

/// Returns the distance at which a ray is nearest to the centre, and the ray with its origin there;
/// `None` when no distance counts, which is not to be seen after the rounding of the ends.
fn from_nearest(ray: &Ray) -> Option<(f64, Ray)> {
    if ray.t_min > ray.t_max {
        return None;
    }
    let nearest = -ray.origin.dot(ray.direction);
    let (t_min, t_max) = (ray.t_min - nearest, ray.t_max - nearest);
    Some((nearest, Ray { origin: ray.at(nearest), t_min, t_max, ..*ray }))
}

/// Whether the ray crosses the surface at all.
pub(super) fn crosses(body: &RadialBody, ray: &Ray) -> bool {
    let Some((_, near)) = from_nearest(ray) else { return false };
    let ray = &near;
    let Some(chord) = body.chord(ray) else { return false };
    let mut known = match start(body, ray, &chord) {
        Start::Inside => return from_inside(body, ray, &chord).is_some(),
        Start::Outside(gap) => gap,
    };
    let mut t = chord.start;
    while t <= chord.end {
        match pass(body, ray, &chord, t) {
            Passage::Above(until) => t = until.max(t.next_up()),
            Passage::Below => return true,
            Passage::Near => {
                let gap = known.unwrap_or_else(|| body.gap(ray, t));
                if gap.value <= body.tolerance() {
                    return true;
                }
                t = advance(body, &chord, t, &gap, false);
            }
        }
        known = None;
    }
    false
}

/// Where a chord starts; outside, with the gap there if it was needed to tell.
enum Start {
    Inside,
    Outside(Option<Gap>),
}

fn start(body: &RadialBody, ray: &Ray, chord: &Chord) -> Start {
    let radius = chord.lowest(chord.start, chord.start);
    // Where a ray comes into the bounding ball it is outside, whatever the rounding of a point far
    // from its origin says.
    if chord.start > ray.t_min || radius >= body.bounds().max {
        return Start::Outside(None);
    }
    if radius < body.bounds().min {
        return Start::Inside;
    }
    let range = body.shell().fine(ray, chord.start).range;
    if radius > f64::from(range.max) {
        return Start::Outside(None);
    }
    let gap = body.gap(ray, chord.start);
    if gap.value < 0.0 { Start::Inside } else { Start::Outside(Some(gap)) }
}

/// How a stretch of a ray runs relative to the body.
enum Passage {
    /// Above everything until the given distance, which far off is no more than where the ray is,
    /// to rounding.
    Above(f64),
    /// Certainly inside somewhere before the cell ends.
    Below,
    /// Too near for the shell to tell.
    Near,
}

/// Compares the ray from `t` on with the shell, the coarse level first.
fn pass(body: &RadialBody, ray: &Ray, chord: &Chord, t: f64) -> Passage {
    let judge = |stay: Stay| {
        let lowest = chord.lowest(t, stay.until.min(chord.end));
        if lowest > f64::from(stay.range.max) {
            Passage::Above(stay.until)
        } else if lowest < f64::from(stay.range.min) {
            Passage::Below
        } else {
            Passage::Near
        }
    };
    match judge(body.shell().coarse(ray, t)) {
        Passage::Near => judge(body.shell().fine(ray, t)),
        clear => clear,
    }
}

/// Steps from outside: over what the shell clears without looking at the series. `known` is the gap
/// at the start, if it was evaluated already.
fn from_outside(
    body: &RadialBody,
    ray: &Ray,
    chord: &Chord,
    mut known: Option<Gap>,
) -> Option<(f64, Gap)> {
    let mut t = chord.start;
    while t <= chord.end {
        if let Passage::Above(until) = pass(body, ray, chord, t) {
            t = until.max(t.next_up());
        } else {
            let gap = known.unwrap_or_else(|| body.gap(ray, t));
            if gap.value <= body.tolerance() {
                return Some((t, gap));
            }
            t = advance(body, chord, t, &gap, false);
        }
        known = None;
    }
    None
}

/// Steps from inside: over the ball that fills the body in one.
fn from_inside(body: &RadialBody, ray: &Ray, chord: &Chord) -> Option<(f64, Gap)> {
    let core = body.core(chord);
    let mut t = chord.start;
    while t <= chord.end {
        match core {
            Some((enter, leave)) if t >= enter && t < leave => t = leave,
            _ => {
                let gap = body.gap(ray, t);
                if gap.value >= -body.tolerance() {
                    return Some((t, gap));
                }
                t = advance(body, chord, t, &gap, true);
            }
        }
    }
    None
}

/// Returns the next distance: no root lies before it.
fn advance(body: &RadialBody, chord: &Chord, t: f64, gap: &Gap, inside: bool) -> f64 {
    let (value, slope) = if inside { (-gap.value, -gap.slope) } else { (gap.value, gap.slope) };
    let k = curvature(body, chord, t, inside);
    let root = (slope * slope + 2.0 * k * value).sqrt();
    let step = if slope < 0.0 { 2.0 * value / (root - slope) } else { (slope + root) / k };
    // A step below the resolution of t would stand still.
    (t + step).max(t.next_up())
}

/// Bounds -G'' from distance `t` on (with the sign turned inside).
fn curvature(body: &RadialBody, chord: &Chord, t: f64, inside: bool) -> f64 {
    let bounds = body.bounds();
    let h = chord.offset;
    // Past its nearest point the ray only goes away from the origin.
    let here = if t > chord.nearest { chord.lowest(t, t) } else { h };
    let rho = here.max(bounds.min);
    let across = (h / rho).min(1.0);
    let series =
        (bounds.curvature * across * across + bounds.slope * (2.0 * across).min(1.0)) / (rho * rho);
    let own = if inside { 1.0 / rho } else { 0.0 };
    // Never zero: a sphere about the origin has no curvature of its own, and then Newton's step is
    // exact from outside.
    (series + own).max(f64::MIN_POSITIVE)
}
