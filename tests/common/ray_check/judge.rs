//! The rules an answer is judged by, given the exact series.
//!
//! Let G = |p| - f(p/|p|) along the ray, and h = -G for a ray that starts outside the body, h = G
//! for one that starts inside: the depth across the surface; certified stepping reports the first
//! root t_c of h. An answer t_p of error bound e may differ from it only as far as e explains:
//!
//! 1. |G(t_p)| <= e, whether there is a certified root or not.
//! 2. For all t from the start of the ray to t_p (without a hit: to its end) h(t) <= e(t), the
//!    error bound of the surface there: what was passed
//!    over is not deeper than the error. Certified stepping says that h < 0 before t_c, so [t_c,
//!    t_p] is left. There the rule is decided by
//!    halving: |G''| <= K by the certified bounds of the body, so that h <= max(h(a), h(b)) + K
//!    (b - a)^2 / 8 between a and b.
//! 3. A ray that is blocked has a t with h(t) >= -e(t), decided the same way.
//!
//! e(t) is the error of the hit of a radial ray from afar through the point at t, or that of the
//! reported hit if it is larger; rounding of the point itself is added. Where the ray starts within
//! e of the surface, either side may be taken for its start; but not for a ray that left a hit by
//! `Hit::leave`, which is certainly on its side: it must not be reported to hit where its gap is
//! more than half of that at its start.

use std::cell::Cell;

use glam::DVec3;

use super::fault::RayRule;
use super::rays::{RayKind, TestRay};
use harmolux::math::Ray;
use harmolux::surface::{Chord, Hit, RadialBody, Surface};

/// Judges the answers to one ray.
pub(super) struct Judge<'a> {
    examined: &'a dyn Surface,
    body: &'a RadialBody,
    test: &'a TestRay,
    certified: Option<Hit>,
    chord: Option<Chord>,
    /// The gap where the ray comes into the bounding ball or starts inside it; at its origin if it
    /// leaves the surface.
    start_gap: f64,
    deepest: Cell<f64>,
}

/// The side a ray starts on.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Outside,
    Inside,
}

/// What stands at a place of the ray: the depth across the surface.
#[derive(Clone, Copy)]
struct Place {
    t: f64,
    depth: f64,
}

/// Halvings of one ray before it counts as broken: a hundred times more than the hardest takes.
const MOST_PIECES: usize = 100_000;

impl<'a> Judge<'a> {
    pub(super) fn new(
        examined: &'a dyn Surface,
        body: &'a RadialBody,
        test: &'a TestRay,
        certified: Option<Hit>,
    ) -> Self {
        let chord = body.chord(&test.ray);
        let start = if test.left { Some(0.0) } else { chord.map(|c| c.start) };
        let start_gap = start.map_or(0.0, |t| body.gap_value(test.ray.at(t)));
        Self { examined, body, test, certified, chord, start_gap, deepest: Cell::new(0.0) }
    }

    pub(super) fn certified(&self) -> Option<&Hit> {
        self.certified.as_ref()
    }

    pub(super) fn is_grazing(&self) -> bool {
        self.test.kind == RayKind::Grazing
    }

    /// Returns the largest ratio of a depth passed over to the bound there, over the answers judged
    /// so far.
    pub(super) fn deepest_passed(&self) -> f64 {
        self.deepest.get()
    }

    /// Returns |G| / error of a hit.
    pub(super) fn gap_ratio(&self, hit: &Hit) -> f64 {
        self.body.gap_value(hit.point).abs() / hit.error
    }

    /// Whether an answer differs from the certified one by more than rounding.
    pub(super) fn differs(&self, found: Option<&Hit>) -> bool {
        match (self.certified, found) {
            (Some(a), Some(b)) => {
                let rounding = self.body.tolerance() + self.place_rounding(a.distance);
                (a.distance - b.distance).abs() > 8.0 * rounding
            }
            (a, b) => a.is_some() != b.is_some(),
        }
    }

    /// Judges a first hit.
    pub(super) fn first_hit(&self, found: Option<&Hit>) -> Result<(), RayRule> {
        let Some(hit) = found else { return self.passes_nothing(f64::INFINITY, 0.0) };
        self.sound(hit)?;
        self.on_ray(hit)?;
        // The comparison that a gap that is no number fails.
        let within_error = self.gap_ratio(hit) <= 1.0;
        if !within_error {
            return Err(RayRule::WithinError);
        }
        let depth = self.depth(self.own_side(), hit.distance);
        if self.test.left && depth < -0.5 * self.start_gap.abs() {
            return Err(RayRule::LeavesSurface);
        }
        self.passes_nothing(hit.distance, hit.error)
    }

    /// Judges whether a ray is blocked.
    pub(super) fn blocked(&self, blocked: bool) -> Result<(), RayRule> {
        if !blocked {
            return self.passes_nothing(f64::INFINITY, 0.0);
        }
        let touches = |side| self.touches(side);
        if self.certified.is_some() || self.sides().any(touches) {
            return Ok(());
        }
        Err(RayRule::BlockedBySomething)
    }

    fn sound(&self, hit: &Hit) -> Result<(), RayRule> {
        let finite = hit.point.is_finite() && hit.distance.is_finite();
        let unit = |n: DVec3| (n.length_squared() - 1.0).abs() <= 1e-9;
        let normals = unit(hit.normal) && unit(hit.shading_normal);
        let error = hit.error > 0.0 && hit.error <= self.body.bounds().max;
        if finite && normals && error { Ok(()) } else { Err(RayRule::Sound) }
    }

    fn on_ray(&self, hit: &Hit) -> Result<(), RayRule> {
        let ray = &self.test.ray;
        let aside = hit.point.distance(ray.at(hit.distance));
        let near = aside <= hit.error + self.place_rounding(hit.distance);
        if near && ray.contains(hit.distance) { Ok(()) } else { Err(RayRule::OnRay) }
    }

    /// Judges what lies before `end` on the ray; `error` is the bound of the hit there.
    fn passes_nothing(&self, end: f64, error: f64) -> Result<(), RayRule> {
        let passed = |side: Side| {
            // Only on the side it takes the ray to start on does certified stepping vouch for what
            // lies before its root.
            let first = match (side == self.own_side(), &self.certified, &self.chord) {
                (_, _, None) | (true, None, _) => return true,
                (true, Some(root), _) => root.distance,
                (false, _, Some(chord)) => chord.start,
            };
            self.shallow(side, first, end, error)
        };
        if self.sides().any(passed) { Ok(()) } else { Err(RayRule::PassesNothing) }
    }

    fn own_side(&self) -> Side {
        if self.starts_in_ball() && self.start_gap < 0.0 { Side::Inside } else { Side::Outside }
    }

    /// Whether the ray starts in the bounding ball; one that enters it comes from outside, however
    /// its entry is rounded.
    fn starts_in_ball(&self) -> bool {
        self.chord.is_some_and(|chord| chord.start <= self.test.ray.t_min)
    }

    /// Returns the side the ray starts on, and the other one too if the error explains it.
    fn sides(&self) -> impl Iterator<Item = Side> {
        let own = self.own_side();
        let other = if own == Side::Inside { Side::Outside } else { Side::Inside };
        let near = self.chord.is_some_and(|chord| {
            self.starts_in_ball()
                && !self.test.left
                && self.start_gap.abs() <= self.bound(chord.start)
        });
        std::iter::once(own).chain(near.then_some(other))
    }

    fn depth(&self, side: Side, t: f64) -> f64 {
        let gap = self.body.gap_value(self.test.ray.at(t));
        if side == Side::Outside { -gap } else { gap }
    }

    fn place(&self, side: Side, t: f64) -> Place {
        Place { t, depth: self.depth(side, t) }
    }

    /// Returns the error bound of the surface at a place of the ray: that of the hit of a radial
    /// ray from afar.
    fn bound(&self, t: f64) -> f64 {
        let rounding = self.body.tolerance() + self.gap_rounding(t);
        let Some(out) = self.test.ray.at(t).try_normalize() else { return rounding };
        let radial = Ray::new(2.0 * self.body.bounds().max * out, -out);
        rounding + self.examined.hit(&radial).map_or(0.0, |hit| hit.error)
    }

    /// Bounds the rounding of the point at a distance, metres.
    fn place_rounding(&self, t: f64) -> f64 {
        4.0 * f64::EPSILON * (self.test.ray.origin.length() + t.abs())
    }

    /// Bounds what that rounding does to the gap.
    fn gap_rounding(&self, t: f64) -> f64 {
        let bounds = self.body.bounds();
        self.place_rounding(t) * (1.0 + bounds.slope / bounds.min)
    }

    /// Bounds |G''| between two distances, outside the ball that fills the body.
    fn curvature(&self, chord: &Chord, from: f64, to: f64) -> f64 {
        let bounds = self.body.bounds();
        let rho = chord.lowest(from, to).max(bounds.min);
        (bounds.curvature + bounds.slope) / (rho * rho) + 1.0 / rho
    }

    /// Whether the ray is nowhere between two distances deeper across the surface than the error
    /// bound.
    fn shallow(&self, side: Side, from: f64, to: f64, error: f64) -> bool {
        let Some(chord) = &self.chord else { return true };
        let (from, to) = (from.max(chord.start), to.min(chord.end));
        if let Some(middle) = core_middle(self.body, chord, from, to)
            && side == Side::Outside
            && self.too_deep(self.place(side, middle), error)
        {
            return false;
        }
        self.each_piece(side, chord, from, to, |a, b, highest| {
            let top = a.depth.max(b.depth);
            if highest <= error || highest <= 0.0 {
                self.note_depth(top, error);
                return Piece::Done;
            }
            if self.too_deep(a, error) || self.too_deep(b, error) {
                return Piece::Found;
            }
            let bound = self.bound(a.t).min(self.bound(b.t)).max(error);
            if highest <= bound { Piece::Done } else { Piece::Halve }
        }) == Piece::Done
    }

    fn too_deep(&self, place: Place, error: f64) -> bool {
        if place.depth <= error {
            return false;
        }
        let bound = self.bound(place.t).max(error);
        self.note_depth(place.depth, bound);
        place.depth > bound
    }

    fn note_depth(&self, depth: f64, bound: f64) {
        if bound > 0.0 {
            self.deepest.set(self.deepest.get().max(depth / bound));
        }
    }

    /// Whether the ray comes within the error bound of the surface, or across it.
    fn touches(&self, side: Side) -> bool {
        let ray = &self.test.ray;
        let cap = if self.test.left { 0.5 * self.start_gap.abs() } else { f64::INFINITY };
        let near = |place: Place| place.depth >= -self.bound(place.t).min(cap);
        let Some(chord) = &self.chord else {
            let nearest =
                (-ray.origin.dot(ray.direction)).clamp(ray.t_min, ray.t_max.max(ray.t_min));
            return near(self.place(side, nearest));
        };
        self.each_piece(side, chord, chord.start, chord.end, |a, b, highest| {
            if near(a) || near(b) {
                Piece::Found
            } else if highest < -self.bound(a.t).max(self.bound(b.t)).min(cap) {
                Piece::Done
            } else {
                Piece::Halve
            }
        }) == Piece::Found
    }

    /// Shows a stretch of the ray to `judge`, halving the pieces it asks to: `judge` gets both ends
    /// of a piece and an upper bound of the depth between. What lies in the ball that fills the
    /// body is left out.
    fn each_piece(
        &self,
        side: Side,
        chord: &Chord,
        from: f64,
        to: f64,
        judge: impl Fn(Place, Place, f64) -> Piece,
    ) -> Piece {
        let mut pieces: Vec<(Place, Place)> = outside_core(self.body, chord, from, to)
            .into_iter()
            .filter(|(a, b)| a <= b)
            .map(|(a, b)| (self.place(side, a), self.place(side, b)))
            .collect();
        let mut seen = 0;
        while let Some((a, b)) = pieces.pop() {
            seen += 1;
            let width = b.t - a.t;
            let bulge = self.curvature(chord, a.t, b.t) * width * width / 8.0;
            match judge(a, b, a.depth.max(b.depth) + bulge) {
                Piece::Done => {}
                Piece::Found => return Piece::Found,
                Piece::Halve if seen > MOST_PIECES => return Piece::Halve,
                Piece::Halve => {
                    let middle = a.t + 0.5 * width;
                    if a.t < middle && middle < b.t {
                        let middle = self.place(side, middle);
                        pieces.extend([(middle, b), (a, middle)]);
                    }
                }
            }
        }
        Piece::Done
    }
}

/// What is to be done with a piece of a ray; of a stretch: whether all of it was done with, or
/// something found, or it stayed open.
#[derive(Clone, Copy, PartialEq)]
enum Piece {
    Done,
    Found,
    Halve,
}

/// Returns the parts of a stretch outside the ball that fills the body.
fn outside_core(body: &RadialBody, chord: &Chord, from: f64, to: f64) -> [(f64, f64); 2] {
    match body.core(chord) {
        Some((enter, leave)) if enter < to && leave > from => {
            [(from, to.min(enter)), (from.max(leave), to)]
        }
        _ => [(from, to), (f64::INFINITY, f64::NEG_INFINITY)],
    }
}

/// Returns the middle of the part of a stretch that is inside the ball that fills the body.
fn core_middle(body: &RadialBody, chord: &Chord, from: f64, to: f64) -> Option<f64> {
    let (enter, leave) = body.core(chord)?;
    let (enter, leave) = (enter.max(from), leave.min(to));
    (enter < leave).then_some(0.5 * (enter + leave))
}
