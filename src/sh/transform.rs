//! Grids on the sphere and the transform between samples and coefficients: rustfft along phi, Legendre sums along theta.

use std::f64::consts::PI;

use rayon::prelude::*;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use super::{Coefficients, Moments, Series};
use crate::math::quadrature::Rule;
use crate::{Error, Result};

/// Rings of equal zenith angle with equispaced azimuths phi_j = 2 pi j / n, starting at phi = 0; samples are stored ring by ring.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// cos(theta) and sin(theta) per ring.
    rings: Vec<(f64, f64)>,
    /// Quadrature weights in cos(theta), adding up to 2; empty for grids that are only synthesised on.
    weights: Vec<f64>,
    azimuths: usize,
}

impl Grid {
    /// Makes Gauss-Legendre rings: analysis is exact for series of degree `rings - 1` when `azimuths >= 2 rings - 1`.
    pub fn gauss_legendre(rings: usize, azimuths: usize) -> Self {
        let rule = Rule::gauss_legendre(rings);
        let ring = |z: f64| (z, ((1.0 - z) * (1.0 + z)).sqrt());
        Self {
            rings: rule.nodes.iter().map(|&z| ring(z)).collect(),
            weights: rule.weights,
            azimuths: azimuths.max(1),
        }
    }

    /// Makes the smallest Gauss-Legendre grid on which degree `lmax` is exact.
    pub fn minimal(lmax: usize) -> Self {
        Self::gauss_legendre(lmax + 1, 2 * lmax + 1)
    }

    /// Makes rings at theta = pi i / half, i = 0..=half, poles included, with 2 half azimuths; for synthesis only.
    pub(super) fn equispaced(half: usize) -> Self {
        let ring = |i: usize| {
            let (s, z) = (PI * i as f64 / half as f64).sin_cos();
            (z, s)
        };
        Self { rings: (0..=half).map(ring).collect(), weights: Vec::new(), azimuths: 2 * half }
    }

    /// Gives the number of samples.
    pub fn len(&self) -> usize {
        self.rings.len() * self.azimuths
    }

    /// Tells whether there are no samples; never true for a grid made here.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Gives the unit vector of sample `i`.
    pub fn direction(&self, i: usize) -> glam::DVec3 {
        let (z, s) = self.rings[i / self.azimuths];
        let phi = 2.0 * PI * (i % self.azimuths) as f64 / self.azimuths as f64;
        let (sin, cos) = phi.sin_cos();
        glam::DVec3::new(s * cos, s * sin, z)
    }

    /// Gives the solid angle of sample `i` as a quadrature node; they add up to 4 pi.
    pub fn solid_angle(&self, i: usize) -> f64 {
        self.weights.get(i / self.azimuths).map_or(0.0, |w| w * 2.0 * PI / self.azimuths as f64)
    }
}

/// Evaluates a series on all samples of a grid, ring by ring.
///
/// # Errors
/// [`Error::Parameter`] when the degree is too high to evaluate, see [`Series::new`].
pub fn synthesis(coefficients: &Coefficients, grid: &Grid) -> Result<Vec<f64>> {
    let series = Series::new(coefficients)?;
    let n = grid.azimuths;
    let fft = FftPlanner::new().plan_fft_inverse(n);
    let mut values = vec![0.0; grid.len()];
    values
        .par_chunks_mut(n)
        .zip(&grid.rings)
        .for_each(|(samples, &ring)| synthesise_ring(&series, ring, fft.as_ref(), samples));
    Ok(values)
}

/// Synthesises one ring: sum_m A_m cos(m phi) + B_m sin(m phi) = Re sum_m (A_m - i B_m) e^(i m phi); orders past n alias onto m mod n,
/// which is exact at the samples.
fn synthesise_ring(series: &Series, (z, s): (f64, f64), fft: &dyn Fft<f64>, samples: &mut [f64]) {
    let n = samples.len();
    let orders = series.coefficients().lmax() + 1;
    let (mut a, mut b) = (vec![0.0; orders], vec![0.0; orders]);
    series.ring(z, s, &mut a, &mut b);
    let mut spectrum = vec![Complex::new(0.0, 0.0); n];
    for (m, (a, b)) in a.iter().zip(&b).enumerate() {
        spectrum[m % n] += Complex::new(*a, -b);
    }
    fft.process(&mut spectrum);
    for (sample, value) in samples.iter_mut().zip(&spectrum) {
        *sample = value.re;
    }
}

/// Rings that are added up together; fixed, so that sums do not depend on the number of threads.
const RINGS_PER_TASK: usize = 16;

/// Projects samples on a Gauss-Legendre grid onto the basis up to degree `lmax`; `values` ring by ring as [`synthesis`] gives them.
///
/// Exact for band-limited functions when the grid has at least `lmax + 1` rings and `2 lmax + 1` azimuths; functions with higher degrees
/// alias, so oversample what is not band-limited.
///
/// # Errors
/// [`Error::Parameter`] when the number of values does not fit the grid or the grid is too coarse for `lmax`.
pub fn analysis(values: &[f64], grid: &Grid, lmax: usize) -> Result<Coefficients> {
    let (rings, n) = (grid.rings.len(), grid.azimuths);
    if values.len() != grid.len() || grid.weights.len() != rings {
        return Err(Error::Parameter(format!(
            "a quadrature grid of {rings} rings x {n} azimuths takes {} values, found {}",
            grid.len(),
            values.len()
        )));
    }
    if rings < lmax + 1 || n < 2 * lmax + 1 {
        return Err(Error::Parameter(format!(
            "degree {lmax} needs at least {} rings x {} azimuths, found {rings} x {n}",
            lmax + 1,
            2 * lmax + 1
        )));
    }
    let fft = FftPlanner::new().plan_fft_forward(n);
    let empty = Moments::new(lmax)?;
    let tasks: Vec<Moments> = (0..rings.div_ceil(RINGS_PER_TASK))
        .into_par_iter()
        .map(|task| {
            let mut moments = empty.clone();
            for ring in (task * RINGS_PER_TASK..rings).take(RINGS_PER_TASK) {
                let samples = &values[ring * n..(ring + 1) * n];
                analyse_ring(
                    samples,
                    grid.rings[ring],
                    grid.weights[ring],
                    fft.as_ref(),
                    lmax,
                    &mut moments,
                );
            }
            moments
        })
        .collect();
    let mut total = empty;
    for part in &tasks {
        total.merge(part);
    }
    Ok(total.coefficients())
}

fn analyse_ring(
    samples: &[f64],
    (z, s): (f64, f64),
    weight: f64,
    fft: &dyn Fft<f64>,
    lmax: usize,
    moments: &mut Moments,
) {
    let mut spectrum: Vec<Complex<f64>> = samples.iter().map(|&v| Complex::new(v, 0.0)).collect();
    fft.process(&mut spectrum);
    let scale = weight * 2.0 * PI / samples.len() as f64;
    let cosines: Vec<f64> = spectrum[..=lmax].iter().map(|c| scale * c.re).collect();
    let sines: Vec<f64> = spectrum[..=lmax].iter().map(|c| -scale * c.im).collect();
    moments.add_ring(z, s, &cosines, &sines);
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    fn random(lmax: usize) -> Coefficients {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let mut c = Coefficients::zeros(lmax);
        for l in 0..=lmax {
            for m in 0..=l {
                c.set(l, m, rng.random::<f64>() - 0.5, rng.random::<f64>() - 0.5);
            }
        }
        c
    }

    fn largest_difference(a: &Coefficients, b: &Coefficients) -> f64 {
        let pairs = a.cosines().iter().zip(b.cosines()).chain(a.sines().iter().zip(b.sines()));
        pairs.fold(0.0, |worst, (x, y)| worst.max((x - y).abs()))
    }

    #[test]
    fn analysis_of_synthesis_returns_the_coefficients() {
        for (lmax, tolerance) in [(0, 1e-15), (1, 1e-15), (32, 1e-12), (64, 1e-12), (200, 1e-11)] {
            let c = random(lmax);
            let grid = Grid::minimal(lmax);
            let values = synthesis(&c, &grid).expect("valid degree");
            let back = analysis(&values, &grid, lmax).expect("fitting grid");
            let error = largest_difference(&c, &back);
            assert!(error <= tolerance, "lmax {lmax}: {error}");
        }
    }

    #[test]
    fn synthesis_is_the_series_at_each_sample_even_when_orders_alias() {
        let c = random(9);
        let f = Series::new(&c).expect("degree 9");
        for grid in [Grid::gauss_legendre(4, 5), Grid::equispaced(12)] {
            let values = synthesis(&c, &grid).expect("degree 9");
            for (i, v) in values.iter().enumerate() {
                assert!((v - f.value(grid.direction(i))).abs() <= 1e-13);
            }
        }
    }

    #[test]
    fn too_coarse_grids_and_wrong_lengths_are_refused() {
        let grid = Grid::minimal(4);
        assert!(analysis(&vec![0.0; grid.len()], &grid, 5).is_err());
        assert!(analysis(&[0.0; 3], &grid, 4).is_err());
    }

    #[test]
    fn solid_angles_fill_the_sphere() {
        let grid = Grid::gauss_legendre(7, 5);
        let total: f64 = (0..grid.len()).map(|i| grid.solid_angle(i)).sum();
        assert!((total - 4.0 * PI).abs() <= 1e-13);
    }
}
