//! The transform between samples on a grid and coefficients: Legendre sums along theta, rustfft
//! along phi.
//!
//! Rings at theta and pi - theta share their Legendre functions but for the sign of those of odd
//! l - m; eight such pairs fill a vector. All sums over degrees run on the two-step recurrence (see
//! `two_step`), order by order; the two rings of a pair go through one complex FFT as its real and
//! imaginary parts.

mod kernels;
mod latitudes;
mod rings;

use fearless_simd::Level;
use rayon::prelude::*;

use super::two_step::TwoStep;
use super::{Coefficients, Grid, MAX_DEGREE};
use crate::{Error, Result, memory};

use kernels::Amplitudes;
use latitudes::{Latitudes, Scratch};
use rings::{Rings, Spectra};

/// Transforms between the coefficients of degree `lmax` and the samples of one grid; built once,
/// used for any number of functions.
///
/// Memory: 40 bytes per pair (l, m) with even l - m, 20 MB at degree 1400; a transform takes 32
/// bytes more per ring and order while it runs. Results do not depend on the number of threads.
///
/// ```
/// use harmolux::sh::{Coefficients, Grid, Transform};
///
/// let transform = Transform::new(8, Grid::minimal(8))?;
/// let mut c = Coefficients::zeros(8);
/// c.set(5, 3, 0.25, -1.0);
/// let samples = transform.synthesis(&c)?;
/// let back = transform.analysis(&samples)?;
/// assert!((back.get(5, 3).1 + 1.0).abs() < 1e-14);
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug)]
pub struct Transform {
    grid: Grid,
    recurrence: TwoStep,
    latitudes: Latitudes,
    rings: Rings,
    level: Level,
    parallel: bool,
}

impl Transform {
    /// Prepares the transform of degree `lmax` on a grid; it runs on all threads of the pool it is
    /// called in.
    ///
    /// # Errors
    /// [`Error::Parameter`] above degree [`MAX_DEGREE`].
    pub fn new(lmax: usize, grid: Grid) -> Result<Self> {
        if lmax > MAX_DEGREE {
            return Err(Error::Parameter(format!(
                "degree {lmax} is above {MAX_DEGREE}, the highest that f64 can evaluate; truncate \
                 the series"
            )));
        }
        // Samples there and back, amplitudes, and the steps of the recurrence.
        let bytes = 16 * grid.len() + 16 * lmax * grid.rings().len() + 12 * lmax * lmax;
        let name = format_args!("a transform of degree {lmax} on {} directions", grid.len());
        memory::ask(bytes as f64, name, |share| {
            format!("about degree {:.0} would fit; choose a lower one", lmax as f64 * share.sqrt())
        })?;
        Ok(Self {
            recurrence: TwoStep::new(lmax),
            latitudes: Latitudes::new(&grid, lmax),
            rings: Rings::new(grid.azimuths()),
            grid,
            level: Level::new(),
            parallel: true,
        })
    }

    /// Keeps all work on the calling thread; the results are the same.
    pub fn single_threaded(mut self) -> Self {
        self.parallel = false;
        self
    }

    /// Returns the grid.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Returns the truncation degree.
    pub fn lmax(&self) -> usize {
        self.recurrence.lmax()
    }

    /// Evaluates a series of degree up to `lmax` on all samples, ring by ring in the order of the
    /// grid. Orders that the azimuths cannot tell apart alias, exactly as sampling makes them.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the series has a higher degree than the transform.
    pub fn synthesis(&self, coefficients: &Coefficients) -> Result<Vec<f64>> {
        let (lmax, degree) = (self.lmax(), coefficients.lmax());
        if degree > lmax {
            return Err(Error::Parameter(format!(
                "a transform of degree {lmax} cannot take a series of degree {degree}: truncate \
                 the series, or prepare a transform of its degree"
            )));
        }
        let (groups, amplitudes) = (self.latitudes.groups(), self.sum_degrees(coefficients));
        let mut samples = vec![0.0; self.grid.len()];
        let tasks = self.latitudes.deal(samples.chunks_mut(self.grid.azimuths()));
        self.each(tasks, |spectra: &mut Spectra, (group, mut pairs)| {
            let column = |m: usize| &amplitudes[m * groups + group];
            self.rings.synthesise(self.level, lmax, column, spectra, &mut pairs);
        });
        Ok(samples)
    }

    /// Projects samples onto the basis: A_lm = (2l+1)/(2 pi eps_m) int f Q_l^m cos(m phi) d omega,
    /// B_lm with the sine, by the quadrature of the grid. `samples` ring by ring as
    /// [`Transform::synthesis`] gives them. Exact for band-limited functions; those with higher
    /// degrees alias, so oversample what is not.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the number of samples does not fit the grid or the grid is too
    /// coarse for `lmax`.
    pub fn analysis(&self, samples: &[f64]) -> Result<Coefficients> {
        self.check_analysis(samples.len())?;
        let (lmax, n) = (self.lmax(), self.grid.azimuths());
        let mut amplitudes = vec![Amplitudes::ZERO; (lmax + 1) * self.latitudes.groups()];
        let tasks = amplitudes.chunks_mut(lmax + 1).enumerate().collect();
        self.each(tasks, |spectra: &mut Spectra, (group, column): (usize, &mut [_])| {
            let ring = |i: usize| (&samples[i * n..(i + 1) * n], self.grid.weights()[i]);
            self.latitudes.fold_rings(group, ring, &self.rings, spectra, column);
        });
        Ok(self.sum_rings(&amplitudes))
    }

    /// Returns the amplitudes of all orders and groups, order after order.
    fn sum_degrees(&self, coefficients: &Coefficients) -> Vec<Amplitudes> {
        let groups = self.latitudes.groups();
        let mut amplitudes = vec![Amplitudes::ZERO; (self.lmax() + 1) * groups];
        let orders = amplitudes.chunks_mut(groups).enumerate().collect();
        self.each(orders, |scratch: &mut Scratch, (m, row): (usize, &mut [_])| {
            self.latitudes.sum_degrees(&self.recurrence, coefficients, m, scratch, row);
        });
        amplitudes
    }

    /// Turns the amplitudes of all groups and orders, group after group, into coefficients.
    fn sum_rings(&self, amplitudes: &[Amplitudes]) -> Coefficients {
        let lmax = self.lmax();
        let mut moments: Vec<Vec<(f64, f64)>> =
            (0..=lmax).map(|m| vec![(0.0, 0.0); lmax + 1 - m]).collect();
        let orders = moments.iter_mut().enumerate().collect();
        self.each(orders, |scratch: &mut Scratch, (m, moments): (usize, &mut Vec<_>)| {
            self.latitudes.sum_rings(&self.recurrence, amplitudes, m, scratch, moments);
        });
        Coefficients::of_columns(&moments)
    }

    fn check_analysis(&self, found: usize) -> Result<()> {
        let (lmax, rings, n) = (self.lmax(), self.grid.rings().len(), self.grid.azimuths());
        if found != self.grid.len() {
            return Err(Error::Parameter(format!(
                "a quadrature grid of {rings} rings x {n} azimuths takes {} values, found {found}",
                self.grid.len()
            )));
        }
        if lmax > self.grid.band_limit() {
            return Err(Error::Parameter(format!(
                "a grid of {rings} rings x {n} azimuths resolves degree {} at most, asked for was \
                 {lmax}: take a finer grid or a lower degree",
                self.grid.band_limit()
            )));
        }
        Ok(())
    }

    /// Runs a task on each item, on all threads or on this one; the memory that a task is given
    /// goes from item to item.
    fn each<T: Send, M: Default>(&self, items: Vec<T>, task: impl Fn(&mut M, T) + Sync + Send) {
        if self.parallel {
            items.into_par_iter().for_each_init(M::default, task);
        } else {
            let mut memory = M::default();
            for item in items {
                task(&mut memory, item);
            }
        }
    }
}

/// Evaluates a series on all samples of a grid, ring by ring; see [`Transform`] for many series on
/// one grid.
///
/// # Errors
/// [`Error::Parameter`] when the degree is too high to evaluate.
pub fn synthesis(coefficients: &Coefficients, grid: &Grid) -> Result<Vec<f64>> {
    Transform::new(coefficients.lmax(), grid.clone())?.synthesis(coefficients)
}

/// Projects samples on a grid onto the basis up to degree `lmax`; see [`Transform::analysis`].
///
/// # Errors
/// [`Error::Parameter`] when the number of values does not fit the grid, the grid is too coarse for
/// `lmax`, or the degree too high to evaluate.
pub fn analysis(values: &[f64], grid: &Grid, lmax: usize) -> Result<Coefficients> {
    Transform::new(lmax, grid.clone())?.analysis(values)
}
#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::sh::Series;

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
        for (lmax, tolerance) in [
            (0, 1e-15),
            (1, 1e-15),
            (32, 1e-12),
            (64, 1e-12),
            (200, 1e-11),
            (512, 1e-11),
            (1023, 1e-10),
        ] {
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
        for lmax in [0, 1, 9, 40] {
            let c = random(lmax);
            let f = Series::new(&c).expect("small degree");
            for grid in [
                Grid::gauss_legendre(4, 5),
                Grid::gauss_legendre(1, 1),
                Grid::gauss_legendre(37, 20),
                Grid::driscoll_healy(12, 24),
                Grid::equispaced(12, 24),
            ] {
                let values = synthesis(&c, &grid).expect("small degree");
                for (i, v) in values.iter().enumerate() {
                    let tolerance = 1e-14 * (1 + lmax * lmax) as f64;
                    assert!((v - f.value(grid.direction(i))).abs() <= tolerance, "{lmax} {grid:?}");
                }
            }
        }
    }

    #[test]
    fn equispaced_grids_analyse_up_to_their_limit() {
        for grid in
            [Grid::driscoll_healy(42, 42), Grid::equispaced(40, 41), Grid::equispaced(41, 50)]
        {
            let lmax = grid.band_limit();
            assert_eq!(lmax, 20);
            let c = random(lmax);
            let back = analysis(&synthesis(&c, &grid).expect("fits"), &grid, lmax).expect("fits");
            assert!(largest_difference(&c, &back) <= 1e-13);
            assert!(analysis(&vec![0.0; grid.len()], &grid, lmax + 1).is_err());
        }
    }

    #[test]
    fn low_degrees_of_a_richer_function_are_those_of_the_full_analysis() {
        let (c, grid) = (random(12), Grid::minimal(12));
        let values = synthesis(&c, &grid).expect("fits");
        let low = analysis(&values, &grid, 5).expect("fits");
        assert!(largest_difference(&low, &c.truncated(5)) <= 1e-14);
        let padded = Transform::new(20, grid).expect("fits").synthesis(&c).expect("lower degree");
        assert!(padded.iter().zip(&values).all(|(a, b)| (a - b).abs() <= 1e-13));
    }

    #[test]
    fn one_thread_gives_the_same_bits() {
        let c = random(70);
        let many = Transform::new(70, Grid::minimal(70)).expect("fits");
        let one = Transform::new(70, Grid::minimal(70)).expect("fits").single_threaded();
        let samples = many.synthesis(&c).expect("fits");
        assert_eq!(samples, one.synthesis(&c).expect("fits"));
        assert_eq!(many.analysis(&samples).expect("fits"), one.analysis(&samples).expect("fits"));
    }

    #[test]
    fn highest_degree_neither_overflows_nor_loses_its_digits() {
        let lmax = MAX_DEGREE;
        let transform = Transform::new(lmax, Grid::minimal(lmax)).expect("the highest");
        let c = random(lmax).scaled(1e6);
        let back = transform.analysis(&transform.synthesis(&c).expect("fits")).expect("fits");
        let error = largest_difference(&c, &back);
        assert!(error <= 1e-4, "{error}");
    }

    #[test]
    fn too_coarse_grids_and_wrong_lengths_are_refused() {
        let grid = Grid::minimal(4);
        assert!(analysis(&vec![0.0; grid.len()], &grid, 5).is_err());
        assert!(analysis(&[0.0; 3], &grid, 4).is_err());
        assert!(Transform::new(MAX_DEGREE + 1, grid.clone()).is_err());
        assert!(Transform::new(4, grid).expect("fits").synthesis(&random(5)).is_err());
    }
}
