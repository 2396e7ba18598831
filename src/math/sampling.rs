//! Maps from the unit square to directions and points, each with its density.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

/// Samples the unit sphere uniformly; the density is 1/(4 pi) per steradian.
pub fn uniform_sphere([u, v]: [f64; 2]) -> DVec3 {
    let z = 1.0 - 2.0 * u;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (TAU * v).sin_cos();
    DVec3::new(r * cos, r * sin, z)
}

/// Maps the unit square to the unit vectors within a cone about z whose half angle has this cosine,
/// uniformly.
pub fn uniform_cone(cos: f64, [u, v]: [f64; 2]) -> DVec3 {
    let z = 1.0 - u * (1.0 - cos);
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (2.0 * PI * v).sin_cos();
    DVec3::new(r * cos, r * sin, z)
}

/// Samples the unit sphere in proportion to the sine of the angle to z; the density is sin / pi^2
/// per steradian.
pub fn sine_sphere([u, v]: [f64; 2]) -> DVec3 {
    // The angle t of (t - sin t cos t) / pi = u by bisected Newton steps; the derivative 2 sin^2
    // vanishes at the ends.
    let (mut low, mut high, mut t) = (0.0, PI, 0.5 * PI);
    for _ in 0..60 {
        let (sin, cos) = t.sin_cos();
        let excess = t - sin * cos - PI * u;
        if excess > 0.0 {
            high = t;
        } else {
            low = t;
        }
        let newton = t - excess / (2.0 * sin * sin);
        let next = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
        if (next - t).abs() <= 1e-15 * PI {
            break;
        }
        t = next;
    }
    let (sin, cos) = t.sin_cos();
    let (sin_v, cos_v) = (TAU * v).sin_cos();
    DVec3::new(sin * cos_v, sin * sin_v, cos)
}

/// Samples the hemisphere about local z in proportion to the cosine (Malley's method); see
/// [`cosine_pdf`].
pub fn cosine_hemisphere(u: [f64; 2]) -> DVec3 {
    let d = concentric_disc(u);
    DVec3::new(d.x, d.y, (1.0 - d.length_squared()).max(0.0).sqrt())
}

/// Returns the density, per steradian, of [`cosine_hemisphere`] at a direction with this cosine to
/// the normal.
pub fn cosine_pdf(cos: f64) -> f64 {
    cos.max(0.0) / PI
}

/// Maps the unit square to the unit disc, area-preserving (Shirley and Chiu 1997); the density is
/// 1/pi.
pub fn concentric_disc([u, v]: [f64; 2]) -> DVec2 {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a == 0.0 && b == 0.0 {
        return DVec2::ZERO;
    }
    let (r, angle) =
        if a.abs() > b.abs() { (a, 0.25 * PI * b / a) } else { (b, 0.5 * PI - 0.25 * PI * a / b) };
    r * DVec2::from_angle(angle)
}

/// Samples barycentric coordinates of a triangle uniformly over its area (Heitz 2019).
pub fn uniform_triangle([u, v]: [f64; 2]) -> DVec3 {
    let (a, b) = if v > u { (0.5 * u, v - 0.5 * u) } else { (u - 0.5 * v, 0.5 * v) };
    DVec3::new(a, b, 1.0 - a - b)
}

/// Picks an index in proportion to `cumulative` (ascending sums, last > 0) and hands back the rest
/// of `u`, uniform again in [0, 1).
pub fn discrete(cumulative: &[f64], u: f64) -> (usize, f64) {
    let total = cumulative.last().copied().unwrap_or(0.0);
    let x = u * total;
    let i = cumulative.partition_point(|&c| c <= x).min(cumulative.len().saturating_sub(1));
    let low = if i == 0 { 0.0 } else { cumulative[i - 1] };
    let width = cumulative.get(i).map_or(0.0, |c| c - low);
    let rest = if width > 0.0 { ((x - low) / width).clamp(0.0, 1.0 - f64::EPSILON) } else { 0.0 };
    (i, rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Averages a moment over a 256 x 256 midpoint grid of the unit square.
    fn mean(f: impl Fn([f64; 2]) -> f64) -> f64 {
        let n = 256;
        let mid = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
        let sum: f64 = (0..n * n).map(|k| f([mid(k / n), mid(k % n)])).sum();
        sum / f64::from(n * n)
    }

    // The midpoint rule on these smooth or piecewise smooth maps is good to about 1/n^2 = 2e-5.
    const TOLERANCE: f64 = 1e-4;

    #[test]
    fn sphere_has_uniform_moments() {
        assert!(mean(|u| uniform_sphere(u).z).abs() <= TOLERANCE);
        assert!((mean(|u| uniform_sphere(u).x.powi(2)) - 1.0 / 3.0).abs() <= TOLERANCE);
    }

    #[test]
    fn cosine_hemisphere_has_the_cosine_law() {
        assert!((mean(|u| cosine_hemisphere(u).z.powi(2)) - 0.5).abs() <= TOLERANCE);
        assert!(mean(|u| cosine_hemisphere(u).x).abs() <= TOLERANCE);
        // E[1/pdf] is the solid angle of the hemisphere only as an improper integral; E[cos/pdf] =
        // pi exactly.
        assert!(
            (mean(|u| {
                let c = cosine_hemisphere(u).z;
                if c > 0.0 { c / cosine_pdf(c) } else { PI }
            }) - PI)
                .abs()
                <= TOLERANCE
        );
    }

    #[test]
    fn triangle_is_uniform() {
        let m = uniform_triangle([0.5, 0.25]);
        assert!((m.element_sum() - 1.0).abs() <= 1e-15 && m.min_element() >= 0.0);
        assert!((mean(|u| uniform_triangle(u).x) - 1.0 / 3.0).abs() <= TOLERANCE);
        assert!((mean(|u| uniform_triangle(u).y.powi(2)) - 1.0 / 6.0).abs() <= TOLERANCE);
    }

    #[test]
    fn discrete_follows_weights_and_reuses_the_number() {
        let cumulative = [1.0, 1.0, 4.0];
        assert_eq!(discrete(&cumulative, 0.0).0, 0);
        assert_eq!(discrete(&cumulative, 0.249).0, 0);
        let (i, rest) = discrete(&cumulative, 0.625);
        assert_eq!(i, 2);
        assert!((rest - 0.5).abs() <= 1e-15);
        assert_eq!(discrete(&cumulative, 1.0).0, 2);
    }
}
