//! Derivatives of a series along infinitesimal rotations: L = omega x grad_S, again series of the
//! same degree.
//!
//! With c_m the complex coefficients of Q_l^m e^(i m phi), the ladder J_+- Y_m = sqrt((l -+ m)(l +-
//! m + 1)) Y_(m+-1) gives L_x = i (J_+ + J_-)/2, L_y = (J_+ - J_-)/2, L_z = i J_z. The derivative
//! of f along the great circle about the axis u is (u . L) f.

use rustfft::num_complex::Complex;

use super::Coefficients;

/// Differentiates f by rotation about x, y and z: the three series (L_x f, L_y f, L_z f).
pub fn rotation_derivatives(f: &Coefficients) -> [Coefficients; 3] {
    let mut result = [(); 3].map(|()| Coefficients::zeros(f.lmax()));
    for l in 0..=f.lmax() {
        for m in 0..=l {
            let (l_f, m_f) = (l as f64, m as f64);
            let from_below =
                ((l_f - m_f + 1.0) * (l_f + m_f)).sqrt() * signed(f, l, m as isize - 1);
            let from_above =
                ((l_f + m_f + 1.0) * (l_f - m_f)).sqrt() * signed(f, l, m as isize + 1);
            let i = Complex::i();
            let derivatives = [
                0.5 * i * (from_below + from_above),
                0.5 * (from_below - from_above),
                i * m_f * signed(f, l, m as isize),
            ];
            // c_m = (A - iB)/2 for m > 0 and A for m = 0.
            let double = if m == 0 { 1.0 } else { 2.0 };
            for (series, c) in result.iter_mut().zip(derivatives) {
                series.set(l, m, double * c.re, -double * c.im);
            }
        }
    }
    result
}

/// Returns c_m, the complex coefficient of Q_l^m e^(i m phi), for m of either sign: c_(-m) = (-1)^m
/// conj(c_m).
fn signed(f: &Coefficients, l: usize, m: isize) -> Complex<f64> {
    let (a, b) = f.get(l, m.unsigned_abs());
    let half = if m == 0 { 1.0 } else { 0.5 };
    let sign = if m < 0 && m % 2 != 0 { -1.0 } else { 1.0 };
    if m < 0 { sign * half * Complex::new(a, b) } else { half * Complex::new(a, -b) }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::sh::Series;

    #[test]
    fn generators_are_omega_cross_gradient() {
        let mut c = Coefficients::zeros(6);
        for l in 0..=6 {
            for m in 0..=l {
                c.set(l, m, 1.0 / (1 + l + 2 * m) as f64, 0.5 / (2 + l * m) as f64);
            }
        }
        let f = Series::new(&c).expect("degree 6");
        let derivatives = rotation_derivatives(&c).map(|d| Series::new(&d).expect("degree 6"));
        for w in [
            DVec3::Z,
            DVec3::new(0.3, -0.5, 0.7).normalize(),
            DVec3::new(-0.9, 0.1, -0.2).normalize(),
        ] {
            let expected = w.cross(f.jet(w).gradient);
            let found = DVec3::from_array([0, 1, 2].map(|i: usize| derivatives[i].value(w)));
            assert!((expected - found).length() <= 1e-13, "{expected} against {found}");
        }
    }
}
