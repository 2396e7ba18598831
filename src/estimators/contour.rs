//! How much of its view a point has of a polygon: Lambert's contour formula.

use std::f64::consts::{PI, TAU};

use arrayvec::ArrayVec;
use glam::DVec3;

use super::receiver::Receiver;

/// Gives the configuration factor of a quadrilateral at `point` for the unit `normal`, its projected solid angle over pi: E = B times it. Positive where the
/// contour runs counter-clockwise as seen from the point, negative from behind; what is below the horizon is cut off.
///
/// The contour need not be flat. A triangle has a corner twice.
pub(super) fn factor(corners: &[DVec3; 4], point: DVec3, normal: DVec3) -> f64 {
    let relative = corners.map(|corner| corner - point);
    let heights = relative.map(|r| r.dot(normal));
    if heights.iter().all(|h| *h <= 0.0) {
        return 0.0;
    }
    let sum = if heights.iter().all(|h| *h >= 0.0) {
        around(&relative, normal)
    } else {
        around(&above_horizon(&relative, &heights), normal)
    };
    // Lambert's sum counts turns about the normal; who looks along it sees them the other way round.
    -sum / TAU
}

/// Adds up angle times normal component over the edges of a polygon relative to the point that sees it.
fn around(corners: &[DVec3], normal: DVec3) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&a, &b)| edge(a, b, normal)).sum()
}

fn edge(a: DVec3, b: DVec3, normal: DVec3) -> f64 {
    let cross = a.cross(b);
    let length = cross.length();
    if length == 0.0 { 0.0 } else { length.atan2(a.dot(b)) * cross.dot(normal) / length }
}

/// Clips a quadrilateral to heights of at least 0 (Sutherland and Hodgman 1974): each edge adds at most its crossing and its end.
fn above_horizon(relative: &[DVec3; 4], heights: &[f64; 4]) -> ArrayVec<DVec3, 8> {
    let mut kept = ArrayVec::new();
    for i in 0..4 {
        let j = (i + 1) % 4;
        if (heights[i] < 0.0) != (heights[j] < 0.0) {
            let t = heights[i] / (heights[i] - heights[j]);
            kept.push(relative[i].lerp(relative[j], t));
        }
        if heights[j] >= 0.0 {
            kept.push(relative[j]);
        }
    }
    kept
}

/// How often a quadrilateral is halved at most, both ways, until it is small for its distance.
const HALVINGS: u32 = 6;
/// A quadrilateral of this share of its squared distance is small: the midpoint rule is then good to half a per cent.
const SMALL: f64 = 0.02;

/// Gives what a receiver of any kind gets from a quadrilateral of radiosity 1 that faces it counter-clockwise, by the midpoint rule on parts that are small
/// for their distance.
pub(super) fn response(corners: &[DVec3; 4], receiver: &Receiver) -> f64 {
    part(corners, receiver, HALVINGS)
}

fn part(corners: &[DVec3; 4], receiver: &Receiver, halvings: u32) -> f64 {
    let [a, b, c, d] = *corners;
    let middle = 0.25 * (a + b + c + d);
    let to_middle = middle - receiver.hit.point;
    let distance2 = to_middle.length_squared();
    let reach = (a - c).length_squared().max((b - d).length_squared());
    if reach > SMALL * distance2 && halvings > 0 {
        let [ab, bc, cd, da] = [[a, b], [b, c], [c, d], [d, a]].map(|[p, q]| p.midpoint(q));
        let quarters =
            [[a, ab, middle, da], [ab, b, bc, middle], [middle, bc, c, cd], [da, middle, cd, d]];
        return quarters.iter().map(|quarter| part(quarter, receiver, halvings - 1)).sum();
    }
    if distance2 == 0.0 {
        return 0.0;
    }
    let direction = to_middle / distance2.sqrt();
    let projected = -0.5 * (c - a).cross(d - b).dot(direction);
    projected.max(0.0) * receiver.response(direction).luminance() / (PI * distance2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Sensor;

    /// The ceiling [0, 1]^2 at z = 1, seen from below.
    fn ceiling() -> [DVec3; 4] {
        [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]].map(|[x, y]| DVec3::new(x, y, 1.0))
    }

    #[test]
    fn factor_is_that_of_the_catalogue_on_its_own_side_only() {
        // Point under a corner, parallel: Howell's formula, X = Y = 1.
        let corner = 0.138_531_605_994_89;
        assert!((factor(&ceiling(), DVec3::ZERO, DVec3::Z) - corner).abs() <= 1e-14);
        assert_eq!(factor(&ceiling(), DVec3::ZERO, DVec3::NEG_Z), 0.0);
        let above = factor(&ceiling(), DVec3::new(0.0, 0.0, 2.0), DVec3::NEG_Z);
        assert!((above + corner).abs() <= 1e-14);
        // In its own plane a polygon shows nothing.
        assert!(factor(&ceiling(), DVec3::new(2.0, 0.3, 1.0), DVec3::NEG_Z).abs() <= 1e-15);
    }

    #[test]
    fn horizon_cuts_a_polygon() {
        // A wall from 1 m below the floor to 1 m above it, at 1 m: the upper half counts.
        let wall = |low: f64| {
            [[-1.0, low], [-1.0, 1.0], [1.0, 1.0], [1.0, low]].map(|[x, z]| DVec3::new(x, 1.0, z))
        };
        let whole = factor(&wall(-1.0), DVec3::ZERO, DVec3::Z);
        let half = factor(&wall(0.0), DVec3::ZERO, DVec3::Z);
        assert!(half.abs() > 0.05 && (whole - half).abs() <= 1e-15, "{whole} {half}");
    }

    #[test]
    fn triangles_have_a_corner_twice() {
        let [a, b, c, d] = ceiling();
        let at = DVec3::new(0.3, 0.7, 0.0);
        let parts = factor(&[a, b, c, c], at, DVec3::Z) + factor(&[a, c, d, d], at, DVec3::Z);
        assert!((parts - factor(&ceiling(), at, DVec3::Z)).abs() <= 1e-15);
    }

    #[test]
    fn response_of_a_plane_is_its_factor() {
        for at in [DVec3::ZERO, DVec3::new(0.4, 0.6, 0.8), DVec3::new(3.0, -1.0, 0.5)] {
            let sensor = Sensor::plane(at, DVec3::Z);
            let expected = factor(&ceiling(), at, DVec3::Z);
            let found = response(&ceiling(), &Receiver::sensor(&sensor));
            assert!((found - expected).abs() <= 5e-3 * expected, "{found} {expected}");
        }
    }
}
