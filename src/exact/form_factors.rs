//! Form factors between simple surfaces and configuration factors at a point.
//!
//! A form factor is the share of the flux from a uniform Lambert surface that arrives at another; a
//! configuration factor C is its limit at a point, so that E = pi L C. Closed forms after Howell's
//! "Catalog of Radiation Heat Transfer Configuration Factors" (C-11, C-14, C-41, B-3, B-4) and
//! Lambert's contour integral for polygons.

use std::f64::consts::PI;

use glam::DVec3;

use super::ranges::positive;
use crate::Result;

pub use super::windows::{cut_polygon, polygon_through};

/// Describes two equal rectangles that face each other squarely. Lengths in metres, above 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpposedRectangles {
    /// One side of both.
    pub width: f64,
    /// The other side of both.
    pub depth: f64,
    /// The distance of their planes.
    pub distance: f64,
}

impl OpposedRectangles {
    /// Returns the form factor from either rectangle to the other (Howell C-11).
    ///
    /// The absolute error is below 1e-15 (1 + 1/(X Y)), X and Y being the sides over the distance.
    ///
    /// # Errors
    /// [`Error::Parameter`](crate::Error::Parameter) for a length that is not above 0.
    pub fn form_factor(&self) -> Result<f64> {
        lengths([("width", self.width), ("depth", self.depth), ("distance", self.distance)])?;
        let (x, y) = (self.width / self.distance, self.depth / self.distance);
        let (sx, sy) = (1.0_f64.hypot(x), 1.0_f64.hypot(y));
        // (1 + x^2)(1 + y^2)/(1 + x^2 + y^2) is 1 plus this, without the cancellation.
        let logarithm = 0.5 * (x * x * y * y / (1.0 + x * x + y * y)).ln_1p();
        let angles =
            x * sy * (x / sy).atan() - x * x.atan() + y * sx * (y / sx).atan() - y * y.atan();
        Ok(2.0 / (PI * x * y) * (logarithm + angles))
    }
}

/// Describes two rectangles at a right angle with one whole edge in common. Lengths in metres,
/// above 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PerpendicularRectangles {
    /// The common edge.
    pub common: f64,
    /// How far the sending rectangle reaches from the edge.
    pub from: f64,
    /// How far the receiving rectangle reaches from the edge.
    pub to: f64,
}

impl PerpendicularRectangles {
    /// Returns the form factor from the sending to the receiving rectangle (Howell C-14).
    ///
    /// # Errors
    /// [`Error::Parameter`](crate::Error::Parameter) for a length that is not above 0.
    pub fn form_factor(&self) -> Result<f64> {
        lengths([("common edge", self.common), ("from", self.from), ("to", self.to)])?;
        let (w, h) = (self.from / self.common, self.to / self.common);
        let (w2, h2) = (w * w, h * h);
        let (diagonal, all) = (w.hypot(h), 1.0 + w2 + h2);
        let angles =
            w * w.recip().atan() + h * h.recip().atan() - diagonal * diagonal.recip().atan();
        let logarithms = ((1.0 + w2) * (1.0 + h2) / all).ln()
            + w2 * (w2 * all / ((1.0 + w2) * (w2 + h2))).ln()
            + h2 * (h2 * all / ((1.0 + h2) * (h2 + w2))).ln();
        Ok((angles + 0.25 * logarithms) / (PI * w))
    }
}

/// Describes two discs on one axis, face to face. Lengths in metres, above 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoaxialDiscs {
    /// The radius of the sending disc.
    pub from: f64,
    /// The radius of the receiving disc.
    pub to: f64,
    /// The distance of their planes.
    pub distance: f64,
}

impl CoaxialDiscs {
    /// Returns the form factor from the sending to the receiving disc (Howell C-41).
    ///
    /// # Errors
    /// [`Error::Parameter`](crate::Error::Parameter) for a length that is not above 0.
    pub fn form_factor(&self) -> Result<f64> {
        lengths([("radius from", self.from), ("radius to", self.to), ("distance", self.distance)])?;
        let (r1, r2) = (self.from / self.distance, self.to / self.distance);
        let q = (r2 / r1).powi(2);
        let x = 1.0 + (1.0 + r2 * r2) / (r1 * r1);
        // The conjugate of [x - sqrt(x^2 - 4q)]/2: no cancellation for small receivers.
        Ok(2.0 * q / (x + (x * x - 4.0 * q).sqrt()))
    }
}

/// Describes a rectangle seen from a point; where the point stands, the methods say. Lengths in
/// metres, above 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RectangleFromPoint {
    /// One side.
    pub width: f64,
    /// The other side.
    pub height: f64,
    /// The distance from the point to the rectangle's plane, measured along the normal through one
    /// corner.
    pub distance: f64,
}

impl RectangleFromPoint {
    /// Returns the configuration factor of a receiver parallel to the rectangle, opposite one
    /// corner (Howell B-3).
    ///
    /// # Errors
    /// [`Error::Parameter`](crate::Error::Parameter) for a length that is not above 0.
    pub fn parallel(&self) -> Result<f64> {
        self.check()?;
        let (x, y) = (self.width / self.distance, self.height / self.distance);
        let (sx, sy) = (1.0_f64.hypot(x), 1.0_f64.hypot(y));
        Ok((x / sx * (y / sx).atan() + y / sy * (x / sy).atan()) / (2.0 * PI))
    }

    /// Returns the configuration factor of a receiver at a right angle to the rectangle, opposite
    /// one corner, its normal along the height: the `width` side lies in the receiver's plane
    /// (Howell B-4).
    ///
    /// # Errors
    /// [`Error::Parameter`](crate::Error::Parameter) for a length that is not above 0.
    pub fn perpendicular(&self) -> Result<f64> {
        self.check()?;
        let (a, c) = (self.width, self.distance);
        let slant = c.hypot(self.height);
        Ok(((a / c).atan() - c / slant * (a / slant).atan()) / (2.0 * PI))
    }

    fn check(&self) -> Result<()> {
        lengths([("width", self.width), ("height", self.height), ("distance", self.distance)])
    }
}

/// Returns the configuration factor C of a simple polygon at `point` for a receiver with the unit
/// `normal`: its projected solid angle over pi, so that the illuminance from luminance L is pi L C.
///
/// `vertices` in metres, in either sense of rotation, convex or not; what lies below the receiver's
/// horizon is cut off. Lambert's formula: C = |sum Theta_i Gamma_i . n|/(2 pi) over the edges. A
/// polygon in the receiver's own plane or of fewer than three vertices gives 0; a point *on* an
/// edge has no limit of its own, there that edge counts for nothing.
///
/// ```
/// use glam::DVec3;
/// use harmolux::exact::form_factors::polygon;
///
/// let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
/// let ceiling = corners.map(|(x, y)| DVec3::new(x, y, 1.0));
/// let c = polygon(&ceiling, DVec3::ZERO, DVec3::Z);
/// assert!((c - 0.13853160599489).abs() <= 1e-14);
/// ```
pub fn polygon(vertices: &[DVec3], point: DVec3, normal: DVec3) -> f64 {
    let clipped = above_horizon(vertices, point, normal);
    let edges = clipped.iter().zip(clipped.iter().cycle().skip(1));
    let sum: f64 = edges.map(|(&a, &b)| edge(a, b, normal)).sum();
    sum.abs() / (2.0 * PI)
}

/// Returns Theta (Gamma . n) of the edge from `a` to `b`, both relative to the receiver.
fn edge(a: DVec3, b: DVec3, normal: DVec3) -> f64 {
    let cross = a.cross(b);
    let length = cross.length();
    if length == 0.0 {
        return 0.0;
    }
    length.atan2(a.dot(b)) * cross.dot(normal) / length
}

/// Clips a polygon to r . n >= 0 (Sutherland and Hodgman 1974) and gives its vertices relative to
/// `point`; empty when nothing rises above the horizon.
fn above_horizon(vertices: &[DVec3], point: DVec3, normal: DVec3) -> Vec<DVec3> {
    let relative: Vec<DVec3> = vertices.iter().map(|&v| v - point).collect();
    if vertices.len() < 3 || relative.iter().all(|v| v.dot(normal) <= 0.0) {
        return Vec::new();
    }
    cut_polygon(&relative, DVec3::ZERO, normal)
}

/// Rejects lengths that are not above 0.
fn lengths(named: [(&str, f64); 3]) -> Result<()> {
    named.into_iter().try_for_each(|(name, value)| positive(name, value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadrature::Rule;

    fn opposed(width: f64, depth: f64, distance: f64) -> f64 {
        OpposedRectangles { width, depth, distance }.form_factor().unwrap()
    }

    fn perpendicular(common: f64, from: f64, to: f64) -> f64 {
        PerpendicularRectangles { common, from, to }.form_factor().unwrap()
    }

    /// A rectangle a x b in the plane z = c with one corner over the origin.
    fn corner(a: f64, b: f64, c: f64) -> [DVec3; 4] {
        [(0.0, 0.0), (a, 0.0), (a, b), (0.0, b)].map(|(x, y)| DVec3::new(x, y, c))
    }

    #[test]
    fn lengths_that_are_none_are_refused() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(
                OpposedRectangles { width: bad, depth: 1.0, distance: 1.0 }.form_factor().is_err()
            );
            assert!(
                PerpendicularRectangles { common: 1.0, from: bad, to: 1.0 }.form_factor().is_err()
            );
            assert!(CoaxialDiscs { from: 1.0, to: bad, distance: 1.0 }.form_factor().is_err());
            let rectangle = RectangleFromPoint { width: 1.0, height: 1.0, distance: bad };
            assert!(rectangle.parallel().is_err() && rectangle.perpendicular().is_err());
        }
    }

    #[test]
    fn degenerate_polygons_give_nothing() {
        let (o, z) = (DVec3::ZERO, DVec3::Z);
        assert_eq!(polygon(&[], o, z), 0.0);
        assert_eq!(polygon(&[DVec3::Z, DVec3::X], o, z), 0.0);
        assert_eq!(polygon(&[DVec3::Z; 4], o, z), 0.0);
        assert_eq!(polygon(&corner(1.0, 1.0, 0.0), DVec3::new(0.5, 0.5, 0.0), z), 0.0);
        assert_eq!(polygon(&corner(1.0, 1.0, 1.0), o, -z), 0.0);
        // Seen edge-on.
        assert!(polygon(&corner(1.0, 1.0, 1.0), DVec3::new(-1.0, 0.0, 1.0), z) <= 1e-16);
        assert!(polygon(&corner(1.0, 1.0, 1.0), DVec3::new(0.0, 0.0, 1.0), z).is_finite());
    }

    #[test]
    fn rectangles_have_the_printed_values() {
        // Printed to ten decimals.
        for (found, printed) in [
            (opposed(1.0, 1.0, 1.0), 0.199_824_895_7),
            (opposed(2.0, 1.0, 1.0), 0.285_875_384_9),
            (opposed(4.0, 4.0, 3.0), 0.282_732_787_4),
            (perpendicular(1.0, 1.0, 1.0), 0.200_043_776_1),
            (perpendicular(4.0, 4.0, 3.0), 0.179_316_803_2),
            (perpendicular(4.0, 3.0, 4.0), 0.239_089_070_9),
        ] {
            assert!((found - printed).abs() <= 5.1e-11, "{found} for {printed}");
        }
    }

    #[test]
    fn rooms_are_closed_and_factors_reciprocal() {
        for [a, b, c] in [[1.0, 1.0, 1.0], [4.0, 4.0, 3.0], [2.0, 7.0, 0.5], [0.3, 5.0, 9.0]] {
            let sides = 2.0 * perpendicular(a, b, c) + 2.0 * perpendicular(b, a, c);
            let sum = opposed(a, b, c) + sides;
            // Cancellation grows with the square of the side ratio, which is below 400 here.
            assert!((sum - 1.0).abs() <= 1e-13, "{a} {b} {c}: {sum}");
            let difference = b * perpendicular(a, b, c) - c * perpendicular(a, c, b);
            assert!(difference.abs() <= 1e-13);
        }
    }

    #[test]
    fn discs_have_the_printed_values_and_limits() {
        let disc = |from, to, distance| CoaxialDiscs { from, to, distance }.form_factor().unwrap();
        assert!((disc(1.0, 1.0, 1.0) - 0.381_966_011_3).abs() <= 5.1e-11);
        assert!((disc(0.5, 1.0, 0.7) - 0.632_123_598_2).abs() <= 5.1e-11);
        // From a point on the axis the share of a disc is r^2/(r^2 + d^2).
        assert!((disc(1e-6, 2.0, 1.0) - 0.8).abs() <= 1e-11);
        // Reciprocity down to receivers where the textbook form has lost every digit.
        assert!((disc(1.0, 1e-9, 1.0) * 1e18 / disc(1e-9, 1.0, 1.0) - 1.0).abs() <= 1e-15);
    }

    #[test]
    fn opposed_rectangles_keep_their_digits_when_small() {
        // F -> X Y/pi.
        let small = opposed(1e-3, 1e-3, 1.0);
        assert!((small - 1e-6 / PI).abs() <= 1e-9, "{small:e}");
    }

    #[test]
    fn polygon_agrees_with_the_corner_formulas() {
        for (a, b, c) in [(1.0, 1.0, 1.0), (4.0, 0.5, 2.0), (0.1, 30.0, 0.7)] {
            let rectangle = RectangleFromPoint { width: a, height: b, distance: c };
            let mut vertices = corner(a, b, c);
            let found = polygon(&vertices, DVec3::ZERO, DVec3::Z);
            assert!((found - rectangle.parallel().unwrap()).abs() <= 1e-15);
            let found = polygon(&vertices, DVec3::ZERO, DVec3::Y);
            assert!((found - rectangle.perpendicular().unwrap()).abs() <= 1e-15);
            vertices.reverse();
            let turned = polygon(&vertices, DVec3::ZERO, DVec3::Y);
            assert!((found - turned).abs() <= 1e-16);
        }
    }

    #[test]
    fn polygon_is_cut_at_the_horizon() {
        // A wall that reaches below the floor gives what its upper part gives.
        let wall = |z: f64| {
            [(-1.0, z), (1.0, z), (1.0, 2.0), (-1.0, 2.0)].map(|(x, z)| DVec3::new(x, 1.0, z))
        };
        let found = polygon(&wall(-5.0), DVec3::ZERO, DVec3::Z);
        assert!((found - polygon(&wall(0.0), DVec3::ZERO, DVec3::Z)).abs() <= 1e-15);
        // An endless ceiling fills the hemisphere, an endless wall half of it.
        let far = [(-1e8, -1e8), (1e8, -1e8), (1e8, 1e8), (-1e8, 1e8)];
        let ceiling = far.map(|(x, y)| DVec3::new(x, y, 1.0));
        assert!((polygon(&ceiling, DVec3::ZERO, DVec3::Z) - 1.0).abs() <= 1e-7);
        let wall = far.map(|(x, z)| DVec3::new(x, 1.0, z));
        assert!((polygon(&wall, DVec3::ZERO, DVec3::Z) - 0.5).abs() <= 1e-7);
    }

    #[test]
    fn concave_polygon_is_the_difference_of_two() {
        // A U whose two arms rise above the horizon of a receiver that looks along +y.
        let at = |(x, y): (f64, f64)| DVec3::new(x, y, 1.0);
        let u = [
            (-2.0, -1.0),
            (2.0, -1.0),
            (2.0, 2.0),
            (1.0, 2.0),
            (1.0, -0.5),
            (-1.0, -0.5),
            (-1.0, 2.0),
            (-2.0, 2.0),
        ];
        let rectangle = |x0, x1| [(x0, 0.0), (x1, 0.0), (x1, 2.0), (x0, 2.0)].map(at);
        let found = polygon(&u.map(at), DVec3::ZERO, DVec3::Y);
        let arms = polygon(&rectangle(-2.0, -1.0), DVec3::ZERO, DVec3::Y)
            + polygon(&rectangle(1.0, 2.0), DVec3::ZERO, DVec3::Y);
        assert!((found - arms).abs() <= 1e-15);
    }

    #[test]
    fn mean_of_the_polygon_is_the_form_factor() {
        // The integrand is smooth on the scale of the distance: 20 Gauss nodes a side give 1e-12.
        let (rule, square) = (Rule::gauss_legendre(20).on(0.0, 1.0), corner(1.0, 1.0, 1.0));
        let at = |x, y| polygon(&square, DVec3::new(x, y, 0.0), DVec3::Z);
        let mean = rule.integrate(|x| rule.integrate(|y| at(x, y)));
        assert!((mean - opposed(1.0, 1.0, 1.0)).abs() <= 1e-11);
    }
}
