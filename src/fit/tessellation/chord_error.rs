//! How far a mesh with its vertices on a surface r = f(omega) is from that surface.
//!
//! Measured: at 13 points of each face, the surface above is looked up and its distance from the
//! face taken.
//!
//! Bounded: with n the unit normal of a face and d the distance of its plane from the centre,
//! h(omega) = f(omega) n.omega - d is the height of the surface above the plane. Along any great
//! circle |h''| <= K = sqrt((M2 + R)^2 + 4 M1^2), R, M1 and M2 the bounds of f, of its slope and of
//! its curvature (`sh::Bounds`). On a spherical triangle whose sides are at most s and whose
//! corners have |h| <= m, |h| <= m + K s^2 / 8 on the sides (linear interpolation along an arc),
//! and K s^2 / 8 more inside (along the arc from a corner through the point to the opposite side).
//! The face is split until that is near the samples. The surface and the mesh are |h| / (n.omega)
//! apart along the direction, which bounds the distance of each point of either from the other: the
//! two-sided Hausdorff distance.

use glam::DVec3;
use rayon::prelude::*;

use crate::Result;
use crate::mesh::triangle::nearest_on_triangle;
use crate::sh::{Bounds, Evaluator};

/// Says how far a tessellation is from its surface, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChordError {
    /// The largest distance found between the surface and the face below it, at 13 points of each
    /// face (among them its middle and the middles of its edges): between them the distance may be
    /// a little larger.
    pub measured: f64,
    /// What the two-sided Hausdorff distance certainly does not exceed; `None` above degree 256,
    /// where it would take too long.
    pub bound: Option<f64>,
}

/// Weights of the samples add up to this.
const PARTS: usize = 12;
/// The highest degree whose bound is computed.
const BOUNDED_DEGREE: usize = 256;
/// The bound may exceed the samples by this factor before a face is split.
const SLACK: f64 = 1.1;
/// How often a face may be split.
const DEEPEST: u32 = 7;

/// Lists the samples of a face as weights of its corners: quarters of its sides, the lattice they
/// span inside, and its middle.
pub(super) fn samples() -> impl Iterator<Item = [usize; 3]> {
    (0..=4)
        .flat_map(|k| (0..=4 - k).map(move |j| [4 - j - k, j, k].map(|w| w * PARTS / 4)))
        .filter(|weights| !weights.contains(&PARTS))
        .chain([[PARTS / 3; 3]])
}

/// Returns the point of a flat face with these weights.
pub(super) fn point(corners: &[DVec3; 3], weights: [usize; 3]) -> DVec3 {
    let sum: DVec3 = corners.iter().zip(weights).map(|(c, w)| *c * w as f64).sum();
    sum / PARTS as f64
}

/// Returns the point of the surface above a point of a face, both from the centre.
pub(super) fn lifted(series: &Evaluator, on_face: DVec3) -> DVec3 {
    let direction = on_face.normalize();
    series.value(direction) * direction
}

/// Measures and bounds the error of faces given by their corners from the centre.
///
/// # Errors
/// As [`Bounds::of`].
pub(super) fn chord_error(series: &Evaluator, faces: &[[DVec3; 3]]) -> Result<ChordError> {
    let largest = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].max(b[1])];
    let [measured, radial] =
        faces.par_iter().map(|corners| measure(series, corners)).reduce(|| [0.0; 2], largest);
    let coefficients = series.coefficients();
    let bound = if coefficients.lmax() <= BOUNDED_DEGREE {
        let Bounds { max, slope, curvature, .. } = Bounds::of(coefficients)?;
        // Bounds the second derivative of the height above any plane along any great circle.
        let curvature = (curvature + max).hypot(2.0 * slope);
        let rounding = 4.0 * series.error(max);
        let goal = SLACK * radial + rounding;
        let over = |corners: &[DVec3; 3]| Face::new(series, curvature, corners).bound(goal);
        Some(faces.par_iter().map(over).reduce(|| 0.0, f64::max) + rounding)
    } else {
        None
    };
    Ok(ChordError { measured, bound })
}

/// Returns the largest distance between the samples and their face, and the largest along the
/// direction.
fn measure(series: &Evaluator, corners: &[DVec3; 3]) -> [f64; 2] {
    samples().fold([0.0; 2], |[distance, radial], weights| {
        let below = point(corners, weights);
        let above = lifted(series, below);
        let nearest = nearest_on_triangle(above, *corners);
        [distance.max(above.distance(nearest)), radial.max(above.distance(below))]
    })
}

/// A face as the bound sees it.
struct Face<'a> {
    series: &'a Evaluator,
    curvature: f64,
    corners: [Corner; 3],
    normal: DVec3,
    /// The distance of the plane from the centre.
    distance: f64,
}

/// A corner of a part of a face.
#[derive(Clone, Copy)]
struct Corner {
    /// On the face.
    point: DVec3,
    direction: DVec3,
    /// The height of the surface above the plane, unsigned.
    height: f64,
}

impl<'a> Face<'a> {
    fn new(series: &'a Evaluator, curvature: f64, corners: &[DVec3; 3]) -> Self {
        let [a, b, c] = *corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        // The corners are on the surface: their height is only rounding, which the caller adds.
        let corner = |p: DVec3| Corner { point: p, direction: p.normalize(), height: 0.0 };
        let distance = normal.dot(a);
        Self { series, curvature, corners: corners.map(corner), normal, distance }
    }

    fn bound(&self, goal: f64) -> f64 {
        // A face so steep that its plane passes through the centre cannot be bounded from there.
        if self.distance <= 0.0 { f64::INFINITY } else { self.part(self.corners, goal, DEEPEST) }
    }

    /// Bounds the distance along the direction over a part of the face.
    fn part(&self, corners: [Corner; 3], goal: f64, splits: u32) -> f64 {
        let [a, b, c] = corners;
        let side_squared = [(a, b), (b, c), (c, a)]
            .map(|(p, q)| p.direction.distance(q.direction))
            .map(|chord| (2.0 * (0.5 * chord).min(1.0).asin()).powi(2));
        let spread = 0.25 * self.curvature * side_squared.into_iter().fold(0.0, f64::max);
        let height = corners.iter().map(|c| c.height).fold(0.0, f64::max);
        // n.omega = d / |point of the face|, and that length is largest at a corner.
        let reach = corners.iter().map(|c| c.point.length()).fold(0.0, f64::max);
        let bound = (height + spread) * reach / self.distance;
        if bound <= goal || splits == 0 {
            return bound;
        }
        let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[p, q]| self.middle(p, q));
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            .into_iter()
            .map(|quarter| self.part(quarter, goal, splits - 1))
            .fold(0.0, f64::max)
    }

    fn middle(&self, p: Corner, q: Corner) -> Corner {
        let point = 0.5 * (p.point + q.point);
        let direction = point.normalize();
        let height = self.series.value(direction) * self.normal.dot(direction) - self.distance;
        Corner { point, direction, height: height.abs() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sh::Coefficients;

    #[test]
    fn sphere_of_radius_two_has_the_error_of_its_octahedron() {
        let mut c = Coefficients::zeros(0);
        c.set(0, 0, 2.0, 0.0);
        let series = Evaluator::new(&c).expect("degree 0");
        let face = [DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * 2.0];
        let error = chord_error(&series, &[face]).expect("bounded");
        // The plane is 2/sqrt 3 from the centre; the farthest point above it is 2 - 2/sqrt 3 away,
        // at the face's middle.
        let exact = 2.0 - 2.0 / 3_f64.sqrt();
        assert!(error.measured <= exact && error.measured >= 0.95 * exact, "{error:?}");
        let bound = error.bound.expect("low degree");
        assert!(bound >= exact && bound <= 1.2 * exact, "{error:?}");
    }
}
