//! How far a polynomial through Chebyshev points can be from the height of the surface, from the
//! degree deviations alone.
//!
//! Interpolation of a function g at Q + 1 Chebyshev points of an interval errs by at most 4 M
//! rho^-Q / (rho - 1) when |g| <= M in the Bernstein ellipse E_rho of the interval (Trefethen,
//! Approximation Theory and Approximation Practice, theorem 8.2). Here g is the height Z = f/s
//! along u with v fixed, continued to complex u. A harmonic of degree l continues as the solid
//! harmonic S_l(X) / (X.X)^(l/2), X = (u, v, 1); by the addition theorem |S_l(X)|^2 <= sigma_l^2
//! |X.X|^l P_l(c) with c = |X|^2 / |X.X|, and P_l(c) <= (c + sqrt(c^2 - 1))^l. For u = a + ib and
//! A = 1 + a^2 + v^2
//!     c <= (A + b^2) / (A - b^2),   so
//!     |f_l| <= sigma_l exp(l atanh(b / sqrt A)),   |1/s| <= (A - b^2)^(-1/2):
//! a harmonic grows with the imaginary part of the angle, as it must. Interpolating along u and
//! then along v errs by at most e_u + Lambda e_v.

use std::f64::consts::PI;

use super::board::Cell;
use crate::sh::Coefficients;

/// The ellipses that are tried.
const RHO: [f64; 14] = [1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.5, 8.0, 10.0, 13.0, 17.0, 22.0, 30.0, 60.0];

/// Bounds the interpolation of Z at `points` Chebyshev points along one direction of the cell, in
/// the unit of the coefficients.
pub(super) fn interpolation_error(f: &Coefficients, cell: &Cell, points: usize) -> f64 {
    let of = |rho: &f64| error_in_ellipse(f, cell, points, *rho);
    RHO.iter().map(of).fold(f64::INFINITY, f64::min)
}

fn error_in_ellipse(f: &Coefficients, cell: &Cell, points: usize, rho: f64) -> f64 {
    let (wide, high) = (0.5 * (rho + 1.0 / rho), 0.5 * (rho - 1.0 / rho));
    let (reach, b) = (cell.half * wide, cell.half * high);
    let a = (cell.middle.abs() - reach).max(0.0);
    let big = 1.0 + a * a;
    let t = b / big.sqrt();
    if t >= 1.0 {
        return f64::INFINITY;
    }
    let growth = t.atanh();
    let terms = (0..=f.lmax()).map(|l| f.degree_deviation(l) * (l as f64 * growth).exp());
    let largest = terms.sum::<f64>() / (big - b * b).sqrt();
    4.0 * largest * rho.powi(1 - points as i32) / (rho - 1.0)
}

/// Bounds the Lebesgue constant of interpolation at `points` Chebyshev points (Rivlin 1974).
pub(super) fn lebesgue(points: usize) -> f64 {
    2.0 / PI * (points as f64).ln() + 1.0
}

#[cfg(test)]
mod tests {
    use super::super::board::Board;
    use super::super::fit::chebyshev_point;
    use super::*;
    use crate::sh::Series;
    use glam::DVec3;

    /// Interpolates g at Chebyshev points by the barycentric formula.
    fn interpolate(g: &[f64], x: f64) -> f64 {
        let n = g.len();
        let (mut over, mut under) = (0.0, 0.0);
        for (k, value) in g.iter().enumerate() {
            let angle = PI * (k as f64 + 0.5) / n as f64;
            let weight = if k % 2 == 0 { angle.sin() } else { -angle.sin() };
            let share = weight / (x - chebyshev_point(k, n));
            (over, under) = (over + share * value, under + share);
        }
        over / under
    }

    #[test]
    fn bound_holds_for_single_degrees_and_falls_with_the_points() {
        let board = Board::new(8);
        for l in [2, 8, 20] {
            let mut f = Coefficients::zeros(l);
            for m in 0..=l {
                f.set(l, m, ((m * 7 + 1) as f64).sin(), ((m * 5) as f64).cos());
            }
            let series = Series::new(&f).expect("small");
            for place in [0, 3, 7] {
                let cell = board.cell(place);
                for v in [-1.0, 0.1, 0.7] {
                    let z = |x: f64| {
                        let p = DVec3::new(cell.middle + cell.half * x, v, 1.0);
                        series.value(p.normalize()) / p.length()
                    };
                    let mut last = f64::INFINITY;
                    for points in [4, 6, 8, 12] {
                        let g: Vec<f64> =
                            (0..points).map(|k| z(chebyshev_point(k, points))).collect();
                        let off = |i: i32| {
                            let x = f64::from(i) / 50.5;
                            (interpolate(&g, x) - z(x)).abs()
                        };
                        let worst = (-50..=50).map(off).fold(0.0, f64::max);
                        let bound = interpolation_error(&f, cell, points);
                        assert!(worst <= bound + 1e-13, "{l} {points}: {worst:e} {bound:e}");
                        assert!(bound <= last);
                        last = bound;
                    }
                }
            }
        }
    }
}
