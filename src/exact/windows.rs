//! What is seen of a flat source past, or through, something flat: the part of a polygon within the
//! cone of a convex window.
//!
//! A convex body hides from a point the cones of those of its faces that look to the point; these
//! do not overlap, so that what it hides of a source is the sum of what is seen through them.
//! Independent of [`cie171::obstruction_at`](super::cie171::obstruction_at), which knows one room.

use glam::DVec3;

use super::form_factors::polygon;

/// Returns the configuration factor, as [`polygon`] does, of that part of a simple polygon that
/// lies within the cone of a convex `window` seen from `point`, near or far.
///
/// `window` in metres, in either sense of rotation; 0 where it is seen edge-on or has fewer than
/// three vertices.
///
/// ```
/// use glam::DVec3;
/// use harmolux::exact::form_factors::{polygon, polygon_through};
///
/// let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
/// let square = |side: f64, z: f64| corners.map(|(x, y)| DVec3::new(side * x, side * y, z));
/// // From the corner, a window half way shows of the ceiling what has twice its sides.
/// let seen = polygon_through(&square(4.0, 2.0), &square(1.0, 1.0), DVec3::ZERO, DVec3::Z);
/// assert!((seen - polygon(&square(2.0, 2.0), DVec3::ZERO, DVec3::Z)).abs() <= 1e-15);
/// ```
pub fn polygon_through(vertices: &[DVec3], window: &[DVec3], point: DVec3, normal: DVec3) -> f64 {
    if window.len() < 3 {
        return 0.0;
    }
    let middle = window.iter().map(|v| *v - point).sum::<DVec3>();
    let mut seen = vertices.to_vec();
    for (a, b) in window.iter().zip(window.iter().cycle().skip(1)) {
        let side = (*a - point).cross(*b - point);
        let inward = side.dot(middle);
        if inward == 0.0 {
            return 0.0;
        }
        seen = cut_polygon(&seen, point, side * inward.signum());
    }
    polygon(&seen, point, normal)
}

/// Cuts a simple polygon off at the plane through `point`: what remains is ahead of `normal` (of
/// any length).
///
/// A polygon that is not convex may keep edges along the plane that bound nothing; areas and
/// factors do not notice.
pub fn cut_polygon(vertices: &[DVec3], point: DVec3, normal: DVec3) -> Vec<DVec3> {
    let heights = || vertices.iter().map(|&v| (v, (v - point).dot(normal)));
    let mut kept = Vec::with_capacity(vertices.len() + 1);
    for ((a, ha), (b, hb)) in heights().zip(heights().cycle().skip(1)) {
        if ha >= 0.0 {
            kept.push(a);
        }
        if (ha < 0.0 && hb > 0.0) || (ha > 0.0 && hb < 0.0) {
            kept.push(a.lerp(b, ha / (ha - hb)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadrature::Rule;

    /// A rectangle in a plane of constant z.
    fn level([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64) -> [DVec3; 4] {
        [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| DVec3::new(x, y, z))
    }

    #[test]
    fn windows_that_show_nothing_give_nothing() {
        let lamp = level([-1.0, 1.0], [-1.0, 1.0], 3.0);
        let through = |window: &[DVec3]| polygon_through(&lamp, window, DVec3::ZERO, DVec3::Z);
        assert_eq!(through(&[]), 0.0);
        assert_eq!(through(&[DVec3::X, DVec3::Y]), 0.0);
        // Edge-on, and behind the point: the opposite cone does not count.
        assert_eq!(through(&[DVec3::X, DVec3::Y, DVec3::ONE - DVec3::Z]), 0.0);
        assert_eq!(through(&level([-1.0, 1.0], [-1.0, 1.0], -1.0)), 0.0);
        assert_eq!(through(&level([5.0, 6.0], [-1.0, 1.0], 1.0)), 0.0);
    }

    #[test]
    fn part_seen_through_a_window_is_that_of_quadrature() {
        let lamp = level([-1.0, 1.5], [-0.5, 1.0], 3.0);
        let window = level([-0.1, 0.4], [-0.3, 0.2], 1.2);
        let (point, normal) = (DVec3::new(0.1, -0.2, 0.1), DVec3::new(0.6, 0.0, 0.8));
        // The window's shadow on the lamp's plane, cut to the lamp, is a rectangle: integrate cos
        // cos'/(pi d^2) over it.
        let scale = (3.0 - point.z) / (1.2 - point.z);
        let shadow = |at: f64, p: f64| p + scale * (at - p);
        let x = [shadow(-0.1, 0.1).max(-1.0), shadow(0.4, 0.1).min(1.5)];
        let y = [shadow(-0.3, -0.2).max(-0.5), shadow(0.2, -0.2).min(1.0)];
        let rule = |[from, to]: [f64; 2]| Rule::gauss_legendre(30).on(from, to);
        let kernel = |x: f64, y: f64| {
            let to = DVec3::new(x, y, 3.0) - point;
            to.dot(normal).max(0.0) * to.z / (std::f64::consts::PI * to.length_squared().powi(2))
        };
        let exact = rule(x).integrate(|x| rule(y).integrate(|y| kernel(x, y)));
        let found = polygon_through(&lamp, &window, point, normal);
        assert!((found - exact).abs() <= 1e-12, "{found} {exact}");
        let mut turned = window;
        turned.reverse();
        assert!((polygon_through(&lamp, &turned, point, normal) - exact).abs() <= 1e-12);
    }

    #[test]
    fn box_of_case_5_7_hides_what_its_own_formula_says() {
        // The wall y = 4 past a box across the room; its faces that look to y = 0 and up.
        let wall =
            [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)].map(|(x, z)| DVec3::new(x, 4.0, z));
        let front =
            [(0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (0.0, 1.0)].map(|(x, z)| DVec3::new(x, 2.5, z));
        let top = level([0.0, 4.0], [2.5, 2.7], 1.0);
        for reading in super::super::cie171::obstruction() {
            let (at, normal) = (reading.point, reading.normal);
            let hidden = |face| polygon_through(&wall, face, at, normal);
            let above = if at.z > 1.0 { hidden(&top) } else { 0.0 };
            let seen = polygon(&wall, at, normal) - hidden(&front) - above;
            assert!((100.0 * seen - reading.value).abs() <= 1e-11, "{reading:?}: {seen}");
        }
    }
}
