//! Reflection of a series at a coordinate plane: signs of coefficients.

use super::Coefficients;
use crate::math::choice::choice;

/// Names a coordinate axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// x: left becomes right where y is forward.
    X,
    /// y.
    Y,
    /// z: upside down.
    Z,
}

choice!(Axis, "axis":
    X = "x" "",
    Y = "y" "",
    Z = "z" "",
);

/// Reflects a function at the plane through the centre that is normal to `axis`: what was at (x, y,
/// z) is at (-x, y, z) for x.
///
/// Exact: x gives A (-1)^m and B (-1)^(m+1), y changes the sign of B, z gives (-1)^(l+m).
pub fn mirrored(f: &Coefficients, axis: Axis) -> Coefficients {
    let sign = |n: usize| if n.is_multiple_of(2) { 1.0 } else { -1.0 };
    let mut result = Coefficients::zeros(f.lmax());
    for l in 0..=f.lmax() {
        for m in 0..=l {
            let (a, b) = f.get(l, m);
            let (a, b) = match axis {
                Axis::X => (sign(m) * a, sign(m + 1) * b),
                Axis::Y => (a, -b),
                Axis::Z => (sign(l + m) * a, sign(l + m) * b),
            };
            result.set(l, m, a, b);
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::sh::Series;

    #[test]
    fn mirrored_series_has_the_values_of_the_other_side() {
        let mut c = Coefficients::zeros(7);
        for l in 0..=7 {
            for m in 0..=l {
                c.set(l, m, ((l * 7 + m * 3) as f64).sin(), ((l + m * 5) as f64).cos());
            }
        }
        let f = Series::new(&c).expect("degree 7");
        for (axis, flip) in [
            (Axis::X, DVec3::new(-1.0, 1.0, 1.0)),
            (Axis::Y, DVec3::new(1.0, -1.0, 1.0)),
            (Axis::Z, DVec3::new(1.0, 1.0, -1.0)),
        ] {
            let twin = mirrored(&c, axis);
            assert_eq!(mirrored(&twin, axis), c);
            let g = Series::new(&twin).expect("degree 7");
            for w in [DVec3::Z, DVec3::new(0.6, 0.0, -0.8), DVec3::new(0.3, -0.5, 0.7).normalize()]
            {
                assert!((g.value(flip * w) - f.value(w)).abs() <= 1e-14, "{axis:?} {w}");
            }
        }
    }
}
