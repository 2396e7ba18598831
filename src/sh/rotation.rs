//! Rotation of a series: f'(R omega) = f(omega), again a series of the same degree.
//!
//! Every rotation is Rz(alpha) Ry(beta) Rz(gamma), and Ry(beta) = Rz(-90) Ry(-90) Rz(beta) Ry(90)
//! Rz(90) (degrees): what is not a turn about z, where orders only change phase, is one fixed
//! matrix for each degree, Delta^l = d^l(pi/2) of Wigner. It comes from the recurrence of Trapani
//! and Navaza (Acta Crystallographica A62, 2006, 262-269) over the order m' downwards,
//!
//! Delta^l_(l m) = (-1)^(l-m) 2^-l sqrt((2l)! / ((l+m)! (l-m)!)),
//! sqrt((l+m')(l-m'+1)) Delta^l_(m'-1,m) = 2m Delta^l_(m',m) - sqrt((l-m')(l+m'+1))
//! Delta^l_(m'+1,m),
//!
//! which is stable for m <= m', where values grow or oscillate; symmetry gives the others. Turns
//! about y mix cosines with cosines and sines with sines only: they are even and odd under the
//! reflection y -> -y.

use std::f64::consts::FRAC_PI_2;

use rayon::prelude::*;

use super::Coefficients;
use super::coefficients::index;
use crate::math::{EulerAngles, Rotation};

/// Rotates a function: the result at R omega is f at omega. Degrees do not mix, and sigma_l stays.
///
/// The work is O(lmax^3), the memory 8 lmax^2 bytes a thread. Errors are roundings: about 1e-15
/// sigma_l at degree 32, 1e-13 at degree 1000.
///
/// ```
/// use glam::DVec3;
/// use harmolux::math::Rotation;
/// use harmolux::sh::{Coefficients, Series, rotate};
///
/// let mut egg = Coefficients::zeros(2);
/// egg.set(0, 0, 1.0, 0.0);
/// egg.set(2, 0, 0.2, 0.0); // long along z
/// let lying = rotate(&egg, &Rotation::about(DVec3::Y, std::f64::consts::FRAC_PI_2)?);
/// assert!((Series::new(&lying)?.value(DVec3::X) - 1.2).abs() <= 1e-14);
/// # Ok::<(), harmolux::Error>(())
/// ```
pub fn rotate(f: &Coefficients, rotation: &Rotation) -> Coefficients {
    let EulerAngles { alpha, beta, gamma } = rotation.euler();
    let rows: Vec<Row> = (0..=f.lmax())
        .into_par_iter()
        .map(|l| {
            let mut row = Row::of(f, l);
            if beta == 0.0 {
                row.turn_about_z(alpha + gamma);
                return row;
            }
            let quarter = QuarterTurn::of_degree(l);
            row.turn_about_z(gamma + FRAC_PI_2);
            row = quarter.forward(&row);
            row.turn_about_z(beta);
            row = quarter.backward(&row);
            row.turn_about_z(alpha - FRAC_PI_2);
            row
        })
        .collect();
    let mut rotated = Coefficients::zeros(f.lmax());
    for (l, row) in rows.iter().enumerate() {
        for (m, (a, b)) in row.a.iter().zip(&row.b).enumerate() {
            rotated.set(l, m, *a, *b);
        }
    }
    rotated
}

/// Holds A_lm and B_lm of one degree, m = 0..=l.
struct Row {
    a: Vec<f64>,
    b: Vec<f64>,
}

impl Row {
    fn of(f: &Coefficients, l: usize) -> Self {
        let range = index(l, 0)..index(l + 1, 0);
        Self { a: f.cosines()[range.clone()].to_vec(), b: f.sines()[range].to_vec() }
    }

    /// Turns by `angle` about z: order m by the angle m times as large.
    fn turn_about_z(&mut self, angle: f64) {
        for (m, (a, b)) in self.a.iter_mut().zip(&mut self.b).enumerate() {
            let (sin, cos) = (m as f64 * angle).sin_cos();
            (*a, *b) = (cos * *a - sin * *b, sin * *a + cos * *b);
        }
    }
}

/// Holds Delta^l_(m',m) for 0 <= m', m <= l, row by row: the turn by 90 degrees about y.
struct QuarterTurn {
    l: usize,
    delta: Vec<f64>,
}

impl QuarterTurn {
    fn of_degree(l: usize) -> Self {
        let n = l + 1;
        let mut delta = vec![0.0; n * n];
        delta[l * n..].copy_from_slice(&last_row(l));
        for below in (0..l).rev() {
            let m_above = below + 1;
            let down = (((l + m_above) * (l - m_above + 1)) as f64).sqrt();
            let up = (((l - m_above) * (l + m_above + 1)) as f64).sqrt();
            for m in 0..=below {
                let twice = if m_above < l { delta[(m_above + 1) * n + m] } else { 0.0 };
                let once = delta[m_above * n + m];
                delta[below * n + m] = ((2 * m) as f64 * once - up * twice) / down;
            }
        }
        for row in 0..n {
            for m in row + 1..n {
                delta[row * n + m] = sign(m - row) * delta[m * n + row];
            }
        }
        Self { l, delta }
    }

    /// Turns by +90 degrees about y.
    fn forward(&self, row: &Row) -> Row {
        self.apply(row, |_| 1.0)
    }

    /// Turns by -90 degrees about y: the transpose, Delta_(m,m') = (-1)^(m - m') Delta_(m',m).
    fn backward(&self, row: &Row) -> Row {
        self.apply(row, sign)
    }

    /// Multiplies by the real form of Delta: with Delta_(m',-m) = (-1)^(l+m') Delta_(m',m), cosines
    /// of order m reach order m' where l + m + m' is even, sines where it is odd. `factor` takes
    /// m + m'.
    fn apply(&self, row: &Row, factor: impl Fn(usize) -> f64) -> Row {
        let n = self.l + 1;
        let mut result = Row { a: vec![0.0; n], b: vec![0.0; n] };
        for (order, delta) in self.delta.chunks_exact(n).enumerate() {
            let double = if order == 0 { 1.0 } else { 2.0 };
            let even = (self.l + order) % 2;
            let cosine: f64 = (even..n).step_by(2).map(|m| delta[m] * row.a[m]).sum();
            let sine: f64 = (1 - even..n).step_by(2).map(|m| delta[m] * row.b[m]).sum();
            // The orders of one sum have one parity, so that the factor is common.
            result.a[order] = double * factor(order + even) * cosine;
            result.b[order] = double * factor(order + 1 - even) * sine;
        }
        result.b[0] = 0.0;
        result
    }
}

/// Returns Delta^l_(l,m), m = 0..=l, from m = 0 upwards: there it falls, so that what underflows
/// stays without effect.
fn last_row(l: usize) -> Vec<f64> {
    let central: f64 = (1..=l).map(|k| ((2 * k - 1) as f64 / (2 * k) as f64).sqrt()).product();
    let step = |value: &mut f64, m: usize| {
        let here = sign(l - m) * *value;
        *value *= ((l - m) as f64 / (l + m + 1) as f64).sqrt();
        Some(here)
    };
    (0..=l).scan(central, step).collect()
}

/// Returns (-1)^n.
const fn sign(n: usize) -> f64 {
    if n.is_multiple_of(2) { 1.0 } else { -1.0 }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::math::sampling::uniform_sphere;
    use crate::sh::Series;

    fn random(lmax: usize) -> Coefficients {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(lmax as u64);
        let mut c = Coefficients::zeros(lmax);
        for l in 0..=lmax {
            for m in 0..=l {
                c.set(l, m, rng.random::<f64>() - 0.5, rng.random::<f64>() - 0.5);
            }
        }
        c
    }

    fn euler(alpha: f64, beta: f64, gamma: f64) -> Rotation {
        Rotation::from_euler(EulerAngles { alpha, beta, gamma }).expect("finite")
    }

    fn largest_difference(a: &Coefficients, b: &Coefficients) -> f64 {
        let pairs = a.cosines().iter().zip(b.cosines()).chain(a.sines().iter().zip(b.sines()));
        pairs.fold(0.0, |worst, (x, y)| worst.max((x - y).abs()))
    }

    #[test]
    fn degree_zero_and_the_identity_change_nothing() {
        let c = random(0);
        assert_eq!(rotate(&c, &euler(1.0, 2.0, 3.0)), c);
        let c = random(9);
        assert_eq!(rotate(&c, &Rotation::IDENTITY), c);
    }

    #[test]
    fn degree_one_turns_as_a_vector() {
        // f = v . omega with A_10 = z, A_11 = -sqrt(2) x, B_11 = -sqrt(2) y, since Q_1^1 =
        // -sin(theta)/sqrt(2).
        let vector = |c: &Coefficients| {
            let (a, b) = c.get(1, 1);
            DVec3::new(-a / 2.0_f64.sqrt(), -b / 2.0_f64.sqrt(), c.get(1, 0).0)
        };
        let c = random(1);
        for rotation in [euler(0.3, 1.1, -2.0), euler(0.0, 3.1, 0.0), euler(1.0, 1e-9, 2.0)] {
            let error = vector(&rotate(&c, &rotation)) - rotation.matrix() * vector(&c);
            assert!(error.length() <= 4.0 * f64::EPSILON, "{error}");
        }
    }

    #[test]
    fn rotated_series_has_the_value_of_the_original_one() {
        for (lmax, tolerance) in [(2, 1e-15), (7, 1e-14), (33, 1e-13), (128, 2e-12)] {
            let c = random(lmax);
            let f = Series::new(&c).expect("small degree");
            let scale: f64 = (0..=lmax).map(|l| c.degree_deviation(l)).sum();
            for rotation in [euler(0.3, 1.1, -2.0), euler(-3.0, 2.9, 0.1), euler(0.0, 0.01, 1.0)] {
                let g = Series::new(&rotate(&c, &rotation)).expect("small degree");
                for i in 0..40 {
                    let w = uniform_sphere([(f64::from(i) + 0.5) / 40.0, f64::from(i) * 0.618]);
                    let error = (g.value((rotation.matrix() * w).normalize()) - f.value(w)).abs();
                    // The directions carry 1e-16 each, which the slope, up to lmax sigma_l, turns
                    // into errors of the values.
                    assert!(error <= tolerance * scale, "degree {lmax}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn degree_128_keeps_its_power_to_1e_12_and_turns_back_to_1e_11() {
        let c = random(128);
        for rotation in [euler(0.3, 1.1, -2.0), euler(-3.0, 2.9, 0.1), euler(2.0, 1e-5, 1.0)] {
            let there = rotate(&c, &rotation);
            for l in 0..=128 {
                let kept = there.degree_deviation(l).powi(2) / c.degree_deviation(l).powi(2);
                assert!((kept - 1.0).abs() <= 1e-12, "degree {l}: {:e}", kept - 1.0);
            }
            let back = rotate(&there, &rotation.inverse());
            let error = largest_difference(&back, &c);
            assert!(error <= 1e-11, "{error:e}");
        }
    }

    #[test]
    #[ignore = "half a minute: cargo test --lib sh::rotation -- --ignored"]
    fn highest_degrees_keep_their_power_and_turn_back() {
        for lmax in [1000, crate::sh::MAX_DEGREE] {
            let c = random(lmax);
            let rotation = euler(0.3, 1.1, -2.0);
            let there = rotate(&c, &rotation);
            let drift = (0..=lmax)
                .map(|l| (there.degree_deviation(l) / c.degree_deviation(l) - 1.0).abs())
                .fold(0.0, f64::max);
            let error = largest_difference(&rotate(&there, &rotation.inverse()), &c);
            println!("degree {lmax}: power {drift:e}, back {error:e}");
            // Measured: 8e-15 and 2.3e-13 at degree 1000, 1.2e-14 and 3.5e-13 at 1400.
            assert!(drift <= 1e-13 && error <= 2e-12, "{lmax}: {drift:e} {error:e}");
        }
    }

    #[test]
    fn rotations_compose() {
        let c = random(20);
        let (a, b) = (euler(0.3, 1.1, -2.0), euler(-1.0, 0.4, 2.2));
        let error = largest_difference(&rotate(&rotate(&c, &a), &b), &rotate(&c, &a.then(&b)));
        assert!(error <= 1e-13, "{error:e}");
    }

    #[test]
    fn half_turn_about_y_is_signs() {
        // theta -> pi - theta, phi -> pi - phi: A (-1)^l, B (-1)^(l+1).
        let c = random(6);
        let half = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, -1.0));
        let turned = rotate(&c, &Rotation::from_matrix(half).expect("a half turn"));
        for l in 0..=6 {
            for m in 0..=l {
                let ((a, b), (a2, b2)) = (c.get(l, m), turned.get(l, m));
                let error = (sign(l) * a - a2).abs().max((sign(l + 1) * b - b2).abs());
                assert!(error <= 1e-14, "({l}, {m}): {error:e}");
            }
        }
    }

    #[test]
    fn quarter_turns_match_values_of_400_digit_arithmetic() {
        // d^l_(m',m)(pi/2) by Wigner's sum in 400 digits (mpmath).
        let table = [
            (2, 1, 1, -0.5),
            (128, 5, 60, 0.048_922_106_419_276_605),
            (128, 100, 3, 0.039_918_222_091_144_51),
            (300, 200, 150, 0.055_348_700_590_315_18),
            (1000, 3, 2, 0.000_151_274_339_600_316_4),
            (1000, 700, 680, 0.053_228_189_695_686_01),
            (1000, 500, 400, -0.021_120_702_444_342_89),
        ];
        for (l, row, column, expected) in table {
            let found = QuarterTurn::of_degree(l).delta[row * (l + 1) + column];
            // The recurrence takes up to l steps of a few roundings of values below 1.
            let tolerance = l as f64 * f64::EPSILON;
            assert!((found - expected).abs() <= tolerance, "({l}, {row}, {column}): {found:e}");
        }
    }
}
