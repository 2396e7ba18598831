//! Grids on the sphere: rings of equal zenith angle with equispaced azimuths, and their quadrature
//! weights.

use std::f64::consts::PI;

use glam::DVec3;

use crate::math::quadrature::Rule;

/// Rings of equal zenith angle with equispaced azimuths phi_j = 2 pi j / n, starting at phi = 0;
/// samples are stored ring by ring.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// cos(theta) and sin(theta) per ring.
    rings: Vec<(f64, f64)>,
    /// Quadrature weights in cos(theta), adding up to 2.
    weights: Vec<f64>,
    azimuths: usize,
    /// The highest degree that the rings analyse exactly; the azimuths may ask for less.
    ring_limit: usize,
}

impl Grid {
    /// Makes Gauss-Legendre rings, from the south pole to the north: analysis is exact for series
    /// of degree `rings - 1` when `azimuths >= 2 rings - 1`.
    pub fn gauss_legendre(rings: usize, azimuths: usize) -> Self {
        let rule = Rule::gauss_legendre(rings);
        let ring = |z: f64| (z, ((1.0 - z) * (1.0 + z)).sqrt());
        Self {
            rings: rule.nodes.iter().map(|&z| ring(z)).collect(),
            ring_limit: rule.nodes.len() - 1,
            weights: rule.weights,
            azimuths: azimuths.max(1),
        }
    }

    /// Makes the smallest Gauss-Legendre grid on which degree `lmax` is exact.
    pub fn minimal(lmax: usize) -> Self {
        Self::gauss_legendre(lmax + 1, 2 * lmax + 1)
    }

    /// Makes the equispaced grid of Driscoll and Healy (1994): `rings` (even, at least 2) at theta
    /// = pi i / rings, i = 0 ..= rings - 1, from the north pole, and `azimuths`; exact for degree
    /// rings / 2 - 1. With `azimuths` = `rings` or 2 `rings` this is the grid "DH" or "DH2" of
    /// pyshtools. An odd number of rings is raised by one.
    pub fn driscoll_healy(rings: usize, azimuths: usize) -> Self {
        let half = (rings.max(1)).div_ceil(2);
        let rings = 2 * half;
        let sines: Vec<f64> =
            (0..2 * rings).map(|i| (PI * i as f64 / rings as f64).sin()).collect();
        let weight = |i: usize| {
            let term = |k: usize| sines[(2 * k + 1) * i % (2 * rings)] / (2 * k + 1) as f64;
            4.0 / rings as f64 * sines[i] * (0..half).map(term).sum::<f64>()
        };
        Self {
            rings: (0..rings).map(|i| ring_at(i, rings)).collect(),
            weights: (0..rings).map(weight).collect(),
            azimuths: azimuths.max(1),
            ring_limit: half - 1,
        }
    }

    /// Makes rings at theta = pi i / intervals, i = 0 ..= intervals, both poles included, and
    /// `azimuths`: the rule of Clenshaw and Curtis, exact for degree intervals / 2. A
    /// latitude-longitude table of half-degree steps has 360 intervals and 720 azimuths.
    pub fn equispaced(intervals: usize, azimuths: usize) -> Self {
        let intervals = intervals.max(1);
        Self {
            rings: (0..=intervals).map(|i| ring_at(i, intervals)).collect(),
            weights: clenshaw_curtis(intervals),
            azimuths: azimuths.max(1),
            ring_limit: intervals / 2,
        }
    }

    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        self.rings.len() * self.azimuths
    }

    /// Whether there are no samples; never true for a grid made here.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns cos(theta) and sin(theta) of each ring.
    pub fn rings(&self) -> &[(f64, f64)] {
        &self.rings
    }

    /// Returns the number of samples on each ring.
    pub fn azimuths(&self) -> usize {
        self.azimuths
    }

    /// Returns the weight of each ring in the integral over cos(theta); they add up to 2.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Returns the highest degree for which analysis on this grid is exact: rings and azimuths both
    /// suffice.
    pub fn band_limit(&self) -> usize {
        self.ring_limit.min((self.azimuths - 1) / 2)
    }

    /// Returns the unit vector of sample `i`.
    pub fn direction(&self, i: usize) -> DVec3 {
        let (z, s) = self.rings[i / self.azimuths];
        let phi = 2.0 * PI * (i % self.azimuths) as f64 / self.azimuths as f64;
        let (sin, cos) = phi.sin_cos();
        DVec3::new(s * cos, s * sin, z)
    }

    /// Returns the solid angle of sample `i` as a quadrature node; they add up to 4 pi.
    pub fn solid_angle(&self, i: usize) -> f64 {
        self.weights[i / self.azimuths] * 2.0 * PI / self.azimuths as f64
    }
}

/// Returns cos and sin of pi i / n, mirrored exactly about the equator.
fn ring_at(i: usize, n: usize) -> (f64, f64) {
    let (s, z) = (PI * i.min(n - i) as f64 / n as f64).sin_cos();
    match (2 * i).cmp(&n) {
        std::cmp::Ordering::Less => (z, s),
        std::cmp::Ordering::Equal => (0.0, 1.0),
        std::cmp::Ordering::Greater => (-z, s),
    }
}

/// Returns the weights of Clenshaw and Curtis at theta = pi i / n.
fn clenshaw_curtis(n: usize) -> Vec<f64> {
    let cosines: Vec<f64> = (0..n).map(|i| (2.0 * PI * i as f64 / n as f64).cos()).collect();
    let weight = |i: usize| {
        let ends = if i == 0 || i == n { 1.0 } else { 2.0 };
        let term = |k: usize| {
            let last = if 2 * k == n { 1.0 } else { 2.0 };
            last * cosines[k * i % n] / (4 * k * k - 1) as f64
        };
        ends / n as f64 * (1.0 - (1..=n / 2).map(term).sum::<f64>())
    };
    (0..=n).map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grids() -> [Grid; 6] {
        [
            Grid::gauss_legendre(7, 5),
            Grid::gauss_legendre(1, 1),
            Grid::driscoll_healy(12, 12),
            Grid::driscoll_healy(1, 0),
            Grid::equispaced(9, 20),
            Grid::equispaced(1, 3),
        ]
    }

    #[test]
    fn solid_angles_fill_the_sphere() {
        for grid in grids() {
            let total: f64 = (0..grid.len()).map(|i| grid.solid_angle(i)).sum();
            assert!((total - 4.0 * PI).abs() <= 1e-13, "{total}");
        }
    }

    #[test]
    fn weights_integrate_powers_of_z_up_to_twice_the_limit() {
        for grid in grids() {
            let limit = 2 * grid.ring_limit;
            for power in 0..=i32::try_from(limit).expect("small") {
                let sum: f64 =
                    grid.rings.iter().zip(&grid.weights).map(|((z, _), w)| w * z.powi(power)).sum();
                let exact = if power % 2 == 0 { 2.0 / f64::from(power + 1) } else { 0.0 };
                assert!((sum - exact).abs() <= 1e-14, "{grid:?} z^{power}: {sum}");
            }
        }
    }

    #[test]
    fn rings_are_mirrored_to_the_last_bit() {
        let grid = Grid::equispaced(10, 4);
        for (north, south) in grid.rings.iter().zip(grid.rings.iter().rev()) {
            assert_eq!((north.0, north.1), (-south.0, south.1));
        }
    }
}
