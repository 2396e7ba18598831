//! Moments of a function against the basis: what every projection adds up, whatever its nodes.
//!
//! A_lm = (2l+1)/(2 pi eps_m) int f Q_l^m cos(m phi) d omega, B_lm the same with the sine (eq. 16
//! of the paper with the norm of (17)).

use std::f64::consts::PI;

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f64x8};
use glam::DVec3;

use super::Coefficients;
use super::legendre::{Block, LANES, Lanes, MAX_DEGREE, Powers, Recurrence, blocks};
use crate::{Error, Result};

/// Adds up int f Q_l^m (cos m phi, sin m phi) d omega node by node, for all degrees up to lmax at
/// once.
#[derive(Debug, Clone)]
pub struct Moments {
    recurrence: Recurrence,
    sums: Vec<[Lanes; 2]>,
    level: Level,
}

impl Moments {
    /// Starts with zero moments up to degree `lmax`.
    ///
    /// # Errors
    /// [`Error::Parameter`] above degree [`MAX_DEGREE`].
    pub fn new(lmax: usize) -> Result<Self> {
        if lmax > MAX_DEGREE {
            return Err(Error::Parameter(format!(
                "degree {lmax} is above {MAX_DEGREE}, the highest that f64 can evaluate"
            )));
        }
        let rows = blocks(lmax).map(|b| lmax + 1 - b.first).sum();
        Ok(Self {
            recurrence: Recurrence::new(lmax),
            sums: vec![[[0.0; LANES]; 2]; rows],
            level: Level::new(),
        })
    }

    /// Adds a node: the unit vector `direction` with `weight` = f(direction) times its solid angle.
    pub fn add(&mut self, direction: DVec3, weight: f64) {
        dispatch!(self.level, simd => self.add_simd(simd, direction, weight));
    }

    #[inline(always)]
    fn add_simd<S: Simd>(&mut self, simd: S, w: DVec3, weight: f64) {
        let mut powers = Powers::new(simd, w.x, w.y);
        for block in blocks(self.recurrence.lmax()) {
            self.add_block(simd, block, w.z, [powers.re * weight, powers.im * weight]);
            powers.advance();
        }
    }

    #[inline(always)]
    fn add_block<S: Simd>(&mut self, simd: S, block: Block, z: f64, [a, b]: [f64x8<S>; 2]) {
        let mut rows = self.sums[block.row..].iter_mut();
        self.recurrence.sweep(
            simd,
            block,
            z,
            #[inline(always)]
            |_, r| {
                if let Some([sum_a, sum_b]) = rows.next() {
                    *sum_a = a.mul_add(r, f64x8::simd_from(simd, *sum_a)).into();
                    *sum_b = b.mul_add(r, f64x8::simd_from(simd, *sum_b)).into();
                }
            },
        );
    }

    /// Adds the moments of another part of the sphere, of the same degree.
    pub fn merge(&mut self, other: &Self) {
        for (mine, theirs) in
            self.sums.iter_mut().flatten().flatten().zip(other.sums.iter().flatten().flatten())
        {
            *mine += theirs;
        }
    }

    /// Turns the moments into coefficients by the norm of the basis.
    pub fn coefficients(&self) -> Coefficients {
        let lmax = self.recurrence.lmax();
        let mut c = Coefficients::zeros(lmax);
        for block in blocks(lmax) {
            for l in block.first..=lmax {
                let [a, b] = &self.sums[block.row + l - block.first];
                for (lane, m) in (block.first..=l).take(LANES).enumerate() {
                    let norm = (2 * l + 1) as f64 / (if m == 0 { 4.0 * PI } else { 2.0 * PI });
                    c.set(l, m, norm * a[lane], norm * b[lane]);
                }
            }
        }
        c
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadrature::Rule;

    #[test]
    fn degree_zero_is_the_mean() {
        let mut moments = Moments::new(0).expect("degree 0");
        moments.add(DVec3::X, 2.0 * PI);
        moments.add(DVec3::NEG_Z, 2.0 * PI);
        assert!((moments.coefficients().mean() - 1.0).abs() <= 1e-15);
    }

    /// The basis is orthogonal with squared norm 2 pi eps_m/(2l+1): projecting each basis function
    /// by an exact rule gives back its unit coefficient and nothing else.
    #[test]
    fn basis_is_orthonormal_to_degree_64() {
        let lmax = 64;
        let rule = Rule::gauss_legendre(lmax + 1);
        let n = 2 * lmax + 1;
        let mut worst: f64 = 0.0;
        for (l0, m0) in [(0, 0), (1, 1), (7, 3), (32, 0), (40, 40), (63, 17), (64, 1), (64, 64)] {
            let mut unit = Coefficients::zeros(lmax);
            unit.set(l0, m0, 1.0, if m0 > 0 { -1.0 } else { 0.0 });
            let f = crate::sh::Series::new(&unit).expect("degree 64");
            let mut moments = Moments::new(lmax).expect("degree 64");
            for (z, w) in rule.iter() {
                let s = (1.0 - z * z).sqrt();
                for j in 0..n {
                    let phi = 2.0 * PI * j as f64 / n as f64;
                    let d = DVec3::new(s * phi.cos(), s * phi.sin(), z);
                    moments.add(d, f.value(d) * w * 2.0 * PI / n as f64);
                }
            }
            let c = moments.coefficients();
            for (x, y) in
                c.cosines().iter().chain(c.sines()).zip(unit.cosines().iter().chain(unit.sines()))
            {
                worst = worst.max((x - y).abs());
            }
        }
        assert!(worst <= 1e-12, "{worst}");
    }
}
