//! The best rotation of one function onto another: that of the least RMS distance, which is that of
//! the largest correlation C(R) = int g(omega) f(R^-1 omega) d omega.
//!
//! C is a trigonometric polynomial of each Euler angle. That of the low degrees is looked at every
//! ten degrees; its best places are climbed by Newton's method, with the derivatives of rotation
//! L = omega x grad: C(exp(w) R) = C - w.(g, L h) - 1/2 sum w_i w_j (L_i g, L_j h) + ..., h = f turned
//! by R. What wins goes on with all degrees.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use rayon::prelude::*;

use super::{Coefficients, rotate, rotation_derivatives};
use crate::math::{EulerAngles, Rotation};

/// The degree up to which all rotations are looked at, and in how many steps half a turn.
const COARSE: usize = 8;
const STEPS: usize = 18;
/// How many places are climbed at low degrees, how far they are apart, and how many at all.
const PLACES: usize = 8;
const APART: f64 = PI / 6.0;
const FINALISTS: usize = 4;
/// Steps of Newton's method at most; a start of ten degrees takes about six.
const CLIMB: usize = 50;
/// Correlations that differ by less, relative to the largest possible, count as equal, and rotations
/// that are less apart as one.
const EQUAL: f64 = 1e-9;
const SAME: f64 = 1e-6;

/// Finds the rotation after which [`rotate`]d `f` is nearest to `target`, RMS over the sphere. Of
/// those found that are equally good, as of a symmetric shape, it is the one with the smallest turn.
pub fn best_rotation(f: &Coefficients, target: &Coefficients) -> Rotation {
    let lmax = f.lmax().min(target.lmax());
    let (f, g) = (f.truncated(lmax), target.truncated(lmax));
    let low = [&f, &g].map(|c| c.truncated(lmax.min(COARSE)));
    let starts = starts(&low[0], &low[1]);
    let climb = Climb::towards(&low[1]);
    let climbed = starts.into_par_iter().map(|start| climb.from(&low[0], start).1);
    let places = climbed.map(|place| (correlation(&g, &rotate(&f, &place)), place)).collect();
    let climb = Climb::towards(&g);
    let places = best_first(places, scale(&f, &g)).into_iter().take(FINALISTS);
    let ends = places.map(|place| climb.from(&f, place)).collect();
    best_first(ends, scale(&f, &g)).first().copied().unwrap_or(Rotation::IDENTITY)
}

/// Sorts rotations by their correlation, of equal ones the smallest turn first.
fn best_first(mut places: Vec<(f64, Rotation)>, scale: f64) -> Vec<Rotation> {
    let best = places.iter().map(|(value, _)| *value).fold(f64::NEG_INFINITY, f64::max);
    let step = (EQUAL * scale).max(f64::MIN_POSITIVE);
    let loss = |value: f64| ((best - value) / step).floor();
    places.sort_by(|(u, a), (v, b)| {
        loss(*u).total_cmp(&loss(*v)).then(a.angle().total_cmp(&b.angle()))
    });
    let mut turns: Vec<Rotation> = places.into_iter().map(|(_, turn)| turn).collect();
    turns.dedup_by(|next, kept| kept.inverse().then(next).angle() <= SAME);
    turns
}

/// Averages the product of two functions without their means over the sphere.
fn correlation(f: &Coefficients, g: &Coefficients) -> f64 {
    let degree = |l: usize| {
        let product = |m| {
            let ((a, b), (c, d)) = (f.get(l, m), g.get(l, m));
            if m == 0 { a * c } else { 0.5 * (a * c + b * d) }
        };
        (0..=l).map(product).sum::<f64>() / (2 * l + 1) as f64
    };
    (1..=f.lmax().min(g.lmax())).map(degree).sum()
}

/// Returns the largest correlation that two functions may have.
fn scale(f: &Coefficients, g: &Coefficients) -> f64 {
    (correlation(f, f) * correlation(g, g)).sqrt()
}

/// Lists the best places on a grid of Euler angles, apart from each other, and where nothing turns.
fn starts(f: &Coefficients, g: &Coefficients) -> Vec<Rotation> {
    let step = PI / STEPS as f64;
    let pairs: Vec<_> = (0..=STEPS).flat_map(|b| (0..2 * STEPS).map(move |c| (b, c))).collect();
    let best = |(b, c): (usize, usize)| {
        let turn = |alpha| EulerAngles { alpha, beta: b as f64 * step, gamma: c as f64 * step };
        let turned = rotate(f, &Rotation::from_euler(turn(0.0)).ok()?);
        let terms = about_z(g, &turned);
        let value = |a: usize| {
            let angle = a as f64 * step;
            let term = |(m, (x, y)): (usize, &(f64, f64))| {
                let (sin, cos) = (m as f64 * angle).sin_cos();
                cos * x + sin * y
            };
            (terms.iter().enumerate().map(term).sum::<f64>(), a)
        };
        let (value, a) = (0..2 * STEPS).map(value).max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((value, Rotation::from_euler(turn(a as f64 * step)).ok()?))
    };
    let mut all: Vec<(f64, Rotation)> = pairs.into_par_iter().filter_map(best).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut starts = vec![Rotation::IDENTITY];
    for (_, turn) in all {
        let apart = |other: &Rotation| other.inverse().then(&turn).angle() > APART;
        if starts.len() <= PLACES && starts[1..].iter().all(apart) {
            starts.push(turn);
        }
    }
    starts
}

/// Returns x_m, y_m for the correlation of g with h turned by alpha about z: the sum of
/// x_m cos(m alpha) + y_m sin(m alpha).
fn about_z(g: &Coefficients, h: &Coefficients) -> Vec<(f64, f64)> {
    let order = |m: usize| {
        let half = if m == 0 { 1.0 } else { 0.5 };
        let term = |l: usize| {
            let ((a, b), (c, d)) = (g.get(l, m), h.get(l, m));
            let factor = half / (2 * l + 1) as f64;
            (factor * (a * c + b * d), factor * (b * c - a * d))
        };
        let terms = (m.max(1)..=g.lmax()).map(term);
        terms.fold((0.0, 0.0), |(x, y), (u, v)| (x + u, y + v))
    };
    (0..=g.lmax()).map(order).collect()
}

/// Climbs the correlation with a function.
struct Climb<'a> {
    g: &'a Coefficients,
    derivatives: [Coefficients; 3],
}

impl<'a> Climb<'a> {
    fn towards(g: &'a Coefficients) -> Self {
        Self { g, derivatives: rotation_derivatives(g) }
    }

    /// Climbs from a rotation of f to the top near it; returns its height, too.
    fn from(&self, f: &Coefficients, start: Rotation) -> (f64, Rotation) {
        let tiny = f64::EPSILON * scale(f, self.g);
        let mut turn = start;
        let mut turned = rotate(f, &turn);
        let mut value = correlation(self.g, &turned);
        for _ in 0..CLIMB {
            let step = self.step(&turned, tiny);
            // Uphill, but for rounding, in whichever part of the step.
            let next = (0..30).find_map(|halvings| {
                let step = step * 0.5_f64.powi(halvings);
                let turn = turn.then(&Rotation::about(step, step.length()).ok()?);
                let turned = rotate(f, &turn);
                let higher = correlation(self.g, &turned);
                (higher >= value - 4.0 * tiny).then_some((higher, turn, turned))
            });
            let Some(next) = next else { break };
            (value, turn, turned) = next;
            if step.length() <= 4.0 * f64::EPSILON {
                break;
            }
        }
        (value, turn)
    }

    /// Returns Newton's step, an axis times an angle: uphill where the correlation bends up, none
    /// where it is level.
    fn step(&self, h: &Coefficients, tiny: f64) -> DVec3 {
        let derivatives = rotation_derivatives(h);
        let gradient = Vector3::from_fn(|i, _| -correlation(self.g, &derivatives[i]));
        let products = Matrix3::from_fn(|i, j| correlation(&self.derivatives[i], &derivatives[j]));
        let bend = SymmetricEigen::new(0.5 * (products + products.transpose()));
        let along = bend.eigenvectors.transpose() * gradient;
        let level = 1e3 * tiny;
        let part = |i: usize| {
            let curvature = bend.eigenvalues[i].abs();
            if curvature > level { along[i] / curvature } else { 0.0 }
        };
        let step = bend.eigenvectors * Vector3::from_fn(|i, _| part(i));
        let step = DVec3::new(step.x, step.y, step.z);
        step.clamp_length_max(0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sh::{difference, gaussian};

    /// A body of degree 10 whose lowest degrees are not the largest.
    fn body(seed: u64) -> Coefficients {
        let powers: Vec<f64> = (0..=10).map(|l| 0.01 / f64::from(1 + (l - 4) * (l - 4))).collect();
        let mut body = gaussian(&powers, seed).expect("powers");
        body.set(0, 0, 1.0, 0.0);
        body
    }

    fn turn(k: usize) -> Rotation {
        let [alpha, beta, gamma] = [2.4, 1.1, 5.3].map(|step| step * k as f64);
        Rotation::from_euler(EulerAngles { alpha, beta: beta % PI, gamma }).expect("finite")
    }

    #[test]
    fn turned_body_is_turned_back() {
        for k in 0..12 {
            let body = body(k as u64);
            let found = best_rotation(&rotate(&body, &turn(k)), &body);
            // The top is flat, but its derivative is known to rounding.
            assert!(turn(k).then(&found).angle() <= 1e-12, "{k}");
        }
    }

    #[test]
    fn no_rotation_of_many_is_better() {
        for seed in 0..4 {
            let (f, g) = (body(seed), body(100 + seed));
            let found = correlation(&g, &rotate(&f, &best_rotation(&f, &g)));
            let best =
                (0..2000).map(|k| correlation(&g, &rotate(&f, &turn(k)))).fold(0.0, f64::max);
            assert!(found >= best && found <= scale(&f, &g), "{found} {best}");
        }
    }

    #[test]
    fn symmetric_bodies_take_the_smallest_turn() {
        let (mut ball, mut egg, mut box_like) =
            (Coefficients::zeros(2), Coefficients::zeros(2), Coefficients::zeros(2));
        for shape in [&mut ball, &mut egg, &mut box_like] {
            shape.set(0, 0, 1.0, 0.0);
        }
        egg.set(2, 0, 0.2, 0.0);
        box_like.set(2, 0, 0.2, 0.0);
        box_like.set(2, 2, 0.1, 0.0);
        assert_eq!(best_rotation(&ball, &ball), Rotation::IDENTITY);
        assert_eq!(best_rotation(&egg, &ball), Rotation::IDENTITY);
        for (shape, is_egg) in [(egg, true), (box_like, false)] {
            let same = best_rotation(&shape, &shape);
            assert!(same.angle() <= 1e-12, "{}", same.angle());
            for k in 1..6 {
                let turned = rotate(&shape, &turn(k));
                let found = best_rotation(&turned, &shape);
                let left = difference(&rotate(&turned, &found), &shape).energy().sqrt();
                assert!(left <= 1e-12, "{left:e}");
                // About its axis the egg may be turned by anything.
                assert!(is_egg || found.angle() <= turn(k).angle() + 1e-9);
            }
        }
    }
}
