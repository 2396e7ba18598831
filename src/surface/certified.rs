//! Certified stepping: the first root of the gap along a ray, never missed.
//!
//! Between here and a distance D the gap G has no root if its second derivative stays above -K: G(t + s) >= G + G' s - K s^2 / 2. The step is the
//! positive root of that parabola, which becomes Newton's step near a root, so it converges quadratically from one side and never
//! passes a root. Along a ray at distance h from the origin, |f''| <= (M2 h^2 + 2 M1 h s) / rho^4 with rho^2 = h^2 + s^2, M1 and M2 the bounds of
//! slope and curvature along great circles, and |p|'' >= 0 (outside) or <= 1/rho (seen from inside).

use super::radial::{Chord, Gap, RadialBody};
use crate::math::Ray;

/// Finds the first distance at which the ray crosses the surface, with the gap there (within [`RadialBody::tolerance`] of zero).
pub(super) fn first_crossing(body: &RadialBody, ray: &Ray) -> Option<(f64, Gap)> {
    let chord = body.chord(ray)?;
    let core = body.core(&chord);
    let mut t = chord.start;
    let mut gap = body.gap(ray, t);
    let inside = gap.value < 0.0;
    loop {
        if gap.value.abs() <= body.tolerance() {
            return Some((t, gap));
        }
        if (gap.value < 0.0) != inside {
            // One rounding beyond the root: the tolerance covers what the last step could not resolve.
            return Some((t, gap));
        }
        t = match core {
            Some((enter, leave)) if inside && t >= enter && t < leave => leave,
            _ => advance(body, &chord, t, &gap, inside),
        };
        if t > chord.end {
            return None;
        }
        gap = body.gap(ray, t);
    }
}

/// Tells whether the ray crosses the surface at all: a chord that starts outside and meets the inner ball does without any stepping.
pub(super) fn crosses(body: &RadialBody, ray: &Ray) -> bool {
    let Some(chord) = body.chord(ray) else { return false };
    if let Some((enter, leave)) = body.core(&chord) {
        let reaches = enter <= chord.end && leave >= chord.start;
        if reaches && body.gap_value(ray.at(chord.start)) > body.tolerance() {
            return true;
        }
    }
    first_crossing(body, ray).is_some()
}

/// Gives the next distance: no root lies before it.
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
    let here = if t > chord.nearest { h.hypot(t - chord.nearest) } else { h };
    let rho = here.max(bounds.min);
    let across = (h / rho).min(1.0);
    let series =
        (bounds.curvature * across * across + bounds.slope * (2.0 * across).min(1.0)) / (rho * rho);
    let own = if inside { 1.0 / rho } else { 0.0 };
    // Never zero: a sphere about the origin has no curvature of its own, and then Newton's step is exact from outside.
    (series + own).max(f64::MIN_POSITIVE)
}
