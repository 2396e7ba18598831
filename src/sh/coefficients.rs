//! The coefficients of a real spherical-harmonic series in the Schmidt semi-normalised basis.
//!
//! f(theta, phi) = sum_l sum_{m<=l} (A_lm cos m phi + B_lm sin m phi) Q_l^m(cos theta), Q_l^m =
//! sqrt((l-m)!/(l+m)!) P_l^m with the Condon-Shortley phase and no sqrt(2); the squared norm of a
//! basis function is 2 pi eps_m/(2l+1), eps_0 = 2, else 1.

use std::f64::consts::PI;

use crate::{Error, Result};

/// Holds A_lm and B_lm for 0 <= m <= l <= lmax, degree by degree, so that truncation is a shorter
/// prefix.
///
/// Entry (l, m) stands at index l(l+1)/2 + m of both arrays; B_l0 is 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Coefficients {
    lmax: usize,
    a: Vec<f64>,
    b: Vec<f64>,
}

/// Returns the place of (l, m) in a degree-major triangle.
#[inline]
pub(super) const fn index(l: usize, m: usize) -> usize {
    l * (l + 1) / 2 + m
}

impl Coefficients {
    /// Makes the zero series of degree `lmax`.
    pub fn zeros(lmax: usize) -> Self {
        let n = index(lmax + 1, 0);
        Self { lmax, a: vec![0.0; n], b: vec![0.0; n] }
    }

    /// Wraps two degree-major triangles of (lmax+1)(lmax+2)/2 entries each.
    ///
    /// # Errors
    /// [`Error::Parameter`] when a length does not fit `lmax`, an entry is not finite, or a B_l0 is
    /// not 0.
    pub fn from_parts(lmax: usize, a: Vec<f64>, b: Vec<f64>) -> Result<Self> {
        let n = index(lmax + 1, 0);
        if a.len() != n || b.len() != n {
            return Err(Error::Parameter(format!(
                "degree {lmax} takes {n} cosine and {n} sine coefficients, found {} and {}",
                a.len(),
                b.len()
            )));
        }
        if let Some(i) = a.iter().zip(&b).position(|(a, b)| !(a.is_finite() && b.is_finite())) {
            return Err(Error::Parameter(format!("coefficient number {i} is not a finite number")));
        }
        if let Some(l) = (0..=lmax).find(|&l| b[index(l, 0)] != 0.0) {
            return Err(Error::Parameter(format!(
                "the sine coefficient of (l, m) = ({l}, 0) must be 0"
            )));
        }
        Ok(Self { lmax, a, b })
    }

    /// Returns the truncation degree.
    pub const fn lmax(&self) -> usize {
        self.lmax
    }

    /// Returns the number of real coefficients, (lmax+1)^2.
    pub const fn count(&self) -> usize {
        (self.lmax + 1) * (self.lmax + 1)
    }

    /// Returns A_lm and B_lm; zero past lmax.
    pub fn get(&self, l: usize, m: usize) -> (f64, f64) {
        if l > self.lmax || m > l {
            return (0.0, 0.0);
        }
        (self.a[index(l, m)], self.b[index(l, m)])
    }

    /// Sets A_lm and B_lm (B is ignored at m = 0).
    ///
    /// # Panics
    /// When (l, m) is outside the triangle: a programmer's error.
    pub fn set(&mut self, l: usize, m: usize, a: f64, b: f64) {
        assert!(m <= l && l <= self.lmax, "(l, m) = ({l}, {m}) is outside degree {}", self.lmax);
        self.a[index(l, m)] = a;
        self.b[index(l, m)] = if m == 0 { 0.0 } else { b };
    }

    /// Returns the cosine coefficients A_lm, degree-major.
    pub fn cosines(&self) -> &[f64] {
        &self.a
    }

    /// Returns the sine coefficients B_lm, degree-major.
    pub fn sines(&self) -> &[f64] {
        &self.b
    }

    /// Joins columns: A_lm and B_lm of order m, degree after degree from l = m.
    pub(super) fn of_columns(columns: &[Vec<(f64, f64)>]) -> Self {
        let mut c = Self::zeros(columns.len().saturating_sub(1));
        for l in 0..=c.lmax {
            let row = index(l, 0)..index(l + 1, 0);
            let entries = c.a[row.clone()].iter_mut().zip(&mut c.b[row]).enumerate();
            for (m, (a, b)) in entries {
                (*a, *b) = columns[m][l - m];
            }
            c.b[index(l, 0)] = 0.0;
        }
        c
    }

    /// Returns A_lm and B_lm of one order, degree after degree from l = m.
    pub(super) fn column(&self, m: usize) -> impl Iterator<Item = (f64, f64)> + '_ {
        (m..=self.lmax).scan(index(m, m), |place, l| {
            let i = *place;
            *place += l + 1;
            Some((self.a[i], self.b[i]))
        })
    }

    /// Returns the mean value over the sphere, A_00.
    pub fn mean(&self) -> f64 {
        self.a[0]
    }

    /// Cuts the series at `lmax`, or pads it with zeros up to there.
    pub fn truncated(&self, lmax: usize) -> Self {
        let n = index(lmax + 1, 0);
        let (mut a, mut b) = (self.a.clone(), self.b.clone());
        a.resize(n, 0.0);
        b.resize(n, 0.0);
        Self { lmax, a, b }
    }

    /// Returns the highest degree with a coefficient that is not 0; 0 where there is none.
    pub fn degree_in_use(&self) -> usize {
        let last = (0..self.a.len()).rev().find(|&i| self.a[i] != 0.0 || self.b[i] != 0.0);
        (0..=self.lmax).find(|&l| last < Some(index(l + 1, 0))).unwrap_or(0)
    }

    /// Multiplies the function by `k`.
    pub fn scaled(mut self, k: f64) -> Self {
        self.a.iter_mut().chain(&mut self.b).for_each(|c| *c *= k);
        self
    }

    /// Returns sigma_l, the square root of the degree variance A_l0^2 + 1/2 sum_{m>0} (A^2 + B^2);
    /// |f_l| <= sigma_l everywhere.
    pub fn degree_deviation(&self, l: usize) -> f64 {
        if l > self.lmax {
            return 0.0;
        }
        let row = index(l, 0)..index(l + 1, 0);
        let squares = self.a[row.clone()].iter().zip(&self.b[row]).map(|(a, b)| a * a + b * b);
        let mut terms = squares;
        let zonal = terms.next().unwrap_or(0.0);
        (zonal + 0.5 * terms.sum::<f64>()).sqrt()
    }

    /// Returns the integral of f^2 over the unit sphere (Parseval): sum of squares times 2 pi
    /// eps_m/(2l+1).
    pub fn energy(&self) -> f64 {
        (0..=self.lmax)
            .map(|l| 4.0 * PI / (2 * l + 1) as f64 * self.degree_deviation(l).powi(2))
            .sum()
    }
}

/// Lists degree, order and whether it is a sine of all coefficients, degree by degree and cosine
/// before sine, without sines of order 0.
pub(crate) fn places(lmax: usize) -> impl Iterator<Item = (usize, usize, bool)> {
    let orders = (0..=lmax).flat_map(|l| (0..=l).map(move |m| (l, m)));
    let pairs = orders.flat_map(|(l, m)| [(l, m, false), (l, m, true)]);
    pairs.filter(|(_, m, sine)| !(*sine && *m == 0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degree_zero_is_a_constant() {
        let mut c = Coefficients::zeros(0);
        c.set(0, 0, 2.0, 7.0);
        assert_eq!(
            (c.count(), c.mean(), c.get(0, 0), c.get(1, 1)),
            (1, 2.0, (2.0, 0.0), (0.0, 0.0))
        );
        assert!((c.energy() - 16.0 * PI).abs() <= 1e-13);
    }

    #[test]
    fn truncation_is_a_prefix_and_padding_is_zero() {
        let mut c = Coefficients::zeros(3);
        c.set(1, 1, 0.5, -0.5);
        c.set(3, 2, 0.1, 0.2);
        assert_eq!(c.truncated(5).truncated(3), c);
        assert_eq!((c.degree_in_use(), c.truncated(900).degree_in_use()), (3, 3));
        assert_eq!(Coefficients::zeros(7).degree_in_use(), 0);
        assert_eq!(c.truncated(2).cosines(), &c.cosines()[..6]);
    }

    #[test]
    fn wrong_parts_are_refused() {
        assert!(Coefficients::from_parts(1, vec![0.0; 3], vec![0.0; 2]).is_err());
        assert!(Coefficients::from_parts(0, vec![f64::NAN], vec![0.0]).is_err());
        assert!(Coefficients::from_parts(0, vec![1.0], vec![1.0]).is_err());
    }
}
