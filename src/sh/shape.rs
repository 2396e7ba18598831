//! Integrals over the body r <= f(omega), exact from its coefficients.

use super::{Coefficients, Grid, synthesis};
use crate::Result;

/// Gives the volume of the body, V = 1/3 int f^3 d omega, by a Gauss-Legendre grid that is exact for degree 3 lmax.
///
/// # Errors
/// As [`synthesis`]: a degree too high to evaluate.
pub fn volume(f: &Coefficients) -> Result<f64> {
    let degree = 3 * f.lmax();
    let grid = Grid::gauss_legendre(degree / 2 + 1, degree + 1);
    let values = synthesis(f, &grid)?;
    Ok(values.iter().enumerate().map(|(i, r)| grid.solid_angle(i) * r.powi(3)).sum::<f64>() / 3.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use approx::assert_relative_eq;

    use super::*;

    #[test]
    fn sphere_and_dipole_have_their_volumes() {
        let mut c = Coefficients::zeros(1);
        c.set(0, 0, 2.0, 0.0);
        assert_relative_eq!(volume(&c).expect("degree 1"), 32.0 * PI / 3.0, max_relative = 1e-14);
        c.set(1, 0, 0.5, 0.0); // int (2 + mu/2)^3 = 2 pi (2 * 8 + 3 * 2 * 1/4 * 2/3)
        assert_relative_eq!(
            volume(&c).expect("degree 1"),
            2.0 * PI * 17.0 / 3.0,
            max_relative = 1e-14
        );
    }
}
