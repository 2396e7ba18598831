//! The point of a triangle nearest to another point.

use glam::DVec3;

/// Returns the point of the triangle (its border and corners included) nearest to `point`;
/// triangles without area are fine.
pub(crate) fn nearest_on_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let normal = (b - a).cross(c - a);
    let inside = |from: DVec3, to: DVec3| (to - from).cross(point - from).dot(normal) >= 0.0;
    let area_squared = normal.length_squared();
    if area_squared > 0.0 && inside(a, b) && inside(b, c) && inside(c, a) {
        return point - normal * (normal.dot(point - a) / area_squared);
    }
    let borders = [[a, b], [b, c], [c, a]].map(|segment| nearest_on_segment(point, segment));
    let mut best = borders[0];
    for border in &borders[1..] {
        if point.distance_squared(*border) < point.distance_squared(best) {
            best = *border;
        }
    }
    best
}

fn nearest_on_segment(point: DVec3, [a, b]: [DVec3; 2]) -> DVec3 {
    let along = b - a;
    let length_squared = along.length_squared();
    if length_squared > 0.0 {
        a + along * ((point - a).dot(along) / length_squared).clamp(0.0, 1.0)
    } else {
        a
    }
}

/// Whether two corners of a face are the same vertex.
pub(super) fn is_collapsed(&[a, b, c]: &[u32; 3]) -> bool {
    a == b || b == c || c == a
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Randomness, Stream};

    const TRIANGLE: [DVec3; 3] =
        [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 3.0, 0.0)];

    #[test]
    fn points_and_needles_have_a_nearest_point() {
        let p = DVec3::new(1.0, 2.0, 3.0);
        assert_eq!(nearest_on_triangle(p, [DVec3::X; 3]), DVec3::X);
        let needle = [DVec3::ZERO, DVec3::X * 2.0, DVec3::X];
        assert_eq!(nearest_on_triangle(p, needle), DVec3::X);
    }

    #[test]
    fn interior_edges_and_corners_answer_for_their_regions() {
        let near = |x, y, z| nearest_on_triangle(DVec3::new(x, y, z), TRIANGLE);
        assert_eq!(near(1.0, 1.0, -5.0), DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(near(2.0, -1.0, 1.0), DVec3::new(2.0, 0.0, 0.0));
        assert_eq!(near(-1.0, -2.0, 0.5), DVec3::ZERO);
        assert_eq!(near(9.0, 0.0, 0.0), TRIANGLE[1]);
        // The foot on the hypotenuse of the 3-4-5 triangle: its distance from the origin is 12/5
        // along (3, 4)/5.
        assert!((near(3.0, 4.0, 0.0) - DVec3::new(1.44, 1.92, 0.0)).length() <= 1e-15);
    }

    #[test]
    fn no_sampled_point_is_nearer() {
        for i in 0..200 {
            let mut stream = Stream::new(Randomness::Sobol, 7, i);
            let mut corner = || {
                let [x, y] = stream.next_2d();
                DVec3::new(x, y, stream.next_2d()[0])
            };
            let triangle = [corner(), corner(), corner()];
            let point = 3.0 * corner() - DVec3::ONE;
            let nearest = point.distance(nearest_on_triangle(point, triangle));
            for j in 0..=20 {
                for k in 0..=20 - j {
                    let [v, w] = [j, k].map(|n| f64::from(n) / 20.0);
                    let [a, b, c] = triangle;
                    let other = a + v * (b - a) + w * (c - a);
                    assert!(nearest <= point.distance(other) + 1e-14);
                }
            }
        }
    }
}
