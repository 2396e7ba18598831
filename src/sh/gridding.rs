//! High degrees at scattered directions: a fine grid over theta and phi stands between the series
//! and the directions.
//!
//! Evaluated term by term a direction costs (lmax+1)^2 steps. Instead a series is synthesised on a
//! torus, theta from 0 to 2 pi (f(2 pi - theta, phi) = f(theta, phi + pi)), twice as fine as its
//! degree needs, and interpolated there by 13 x 13 points of the kernel exp(beta (sqrt(1 - x^2) -
//! 1)), whose Fourier transform the grid has been divided by (Barnett, Magland, af Klinteberg
//! 2019). Moments are the transpose, step by step. The error is about 1e-12 of the largest value; a
//! direction costs the same at any degree.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use super::{Coefficients, Grid, Jet, Series, Transform};
use crate::Result;
use crate::math::quadrature::Rule;

/// Points of the kernel along each axis.
const WIDTH: usize = 13;

/// The shape of the kernel for a grid twice as fine as needed: 2.3 a point.
const BETA: f64 = 2.3 * WIDTH as f64;

/// Rows beyond each pole that a kernel can reach.
const MARGIN: usize = WIDTH / 2 + 1;

/// Nearer to a pole than this, sin(theta), the gradient along phi is left to the series itself.
const POLAR: f64 = 1e-5;

/// Sizes, transforms and kernel of a grid.
#[derive(Clone)]
struct Plan {
    lmax: usize,
    /// Points of the torus along theta and along phi.
    around: usize,
    /// The Fourier transform of the kernel at each order 0..=lmax.
    kernel: Vec<f64>,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
}

impl Plan {
    fn new(lmax: usize) -> Self {
        // Four times the margin, so that the rows beyond the poles stay apart.
        let around = smooth_above((4 * lmax + 4).max(4 * MARGIN));
        let mut planner = FftPlanner::new();
        Self {
            lmax,
            around,
            kernel: transform_of_kernel(lmax, around),
            forward: planner.plan_fft_forward(around),
            inverse: planner.plan_fft_inverse(around),
        }
    }

    /// Counts the rows that are kept: from a margin before one pole to a margin behind the other.
    fn rows(&self) -> usize {
        self.around / 2 + 1 + 2 * MARGIN
    }

    /// Returns where a kept row stands on the torus.
    fn on_torus(&self, row: usize) -> usize {
        (row + self.around - MARGIN) % self.around
    }

    /// Makes the transform of the half of the torus that is the sphere.
    fn transform(&self) -> Result<Transform> {
        Transform::new(self.lmax, Grid::equispaced(self.around / 2, self.around))
    }

    /// Places a direction: first row and column of its kernel, and how far the direction is from
    /// them, in cells.
    fn place(&self, w: DVec3) -> ([usize; 2], [f64; 2]) {
        let cells = |angle: f64| angle / (2.0 * PI) * self.around as f64;
        let theta = cells(w.x.hypot(w.y).atan2(w.z)) + MARGIN as f64;
        let phi = cells(w.y.atan2(w.x)) + self.around as f64;
        let first = |x: f64| (x - REACH).ceil();
        let (row, column) = (first(theta), first(phi));
        ([row as usize, column as usize % self.around], [theta - row, phi - column])
    }

    /// Divides a torus by the kernel, up to order lmax both ways. For each order along phi `gather`
    /// lays the spectra of the given rows out along theta, and `scatter` takes the wanted rows from
    /// the result.
    fn divide(
        &self,
        rows: &[f64],
        gather: impl Fn(&[Vec<Complex<f64>>], usize) -> Vec<Complex<f64>> + Sync,
        scatter: impl Fn(Vec<Complex<f64>>, usize) -> Vec<Complex<f64>> + Sync,
    ) -> Vec<f64> {
        let n = self.around;
        let spectra: Vec<Vec<Complex<f64>>> =
            rows.par_chunks(n).map(|row| self.orders_of(row)).collect();
        let order = |m: usize| {
            let mut line = gather(&spectra, m);
            self.forward.process(&mut line);
            // A real function has each order above 0 twice.
            let weight = if m == 0 { 1.0 } else { 2.0 } / (n * n) as f64;
            for (k, x) in line.iter_mut().enumerate() {
                let along = self.kernel.get(k.min(n - k));
                *x *= along.map_or(0.0, |kernel| weight / (kernel * self.kernel[m]));
            }
            self.inverse.process(&mut line);
            scatter(line, m)
        };
        let orders: Vec<Vec<Complex<f64>>> = (0..=self.lmax).into_par_iter().map(order).collect();
        drop(spectra);
        let mut cells = vec![0.0; orders[0].len() * n];
        cells.par_chunks_mut(n).enumerate().for_each(|(row, cells)| {
            let mut line = vec![Complex::new(0.0, 0.0); n];
            line.iter_mut().zip(&orders).for_each(|(x, order)| *x = order[row]);
            self.inverse.process(&mut line);
            cells.iter_mut().zip(&line).for_each(|(cell, x)| *cell = x.re);
        });
        cells
    }

    fn orders_of(&self, row: &[f64]) -> Vec<Complex<f64>> {
        let mut line: Vec<_> = row.iter().map(|&x| Complex::new(x, 0.0)).collect();
        self.forward.process(&mut line);
        line.truncate(self.lmax + 1);
        line
    }
}

/// Returns (-1)^m, the sign of order m on the far side of the torus.
fn far_sign(m: usize) -> f64 {
    if m.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// Returns the smallest even product of 2, 3 and 5 from `n` on: sizes that transform fast.
fn smooth_above(n: usize) -> usize {
    let is_smooth = |n: usize| {
        let mut rest = n;
        for p in [2, 3, 5] {
            while rest.is_multiple_of(p) {
                rest /= p;
            }
        }
        rest == 1 && n.is_multiple_of(2)
    };
    // The next power of two is one.
    (n.max(2)..=n.max(2).next_power_of_two()).find(|&n| is_smooth(n)).unwrap_or(n)
}

/// Returns int K(x) cos(2 pi k x / n) dx over the width of the kernel, in cells, for k = 0..=lmax.
fn transform_of_kernel(lmax: usize, n: usize) -> Vec<f64> {
    let rule = Rule::gauss_legendre(64).on(0.0, REACH);
    let at = |k: usize| {
        let turn = 2.0 * PI * k as f64 / n as f64;
        2.0 * rule.integrate(|x| kernel(x / REACH).1 * (turn * x).cos())
    };
    (0..=lmax).map(at).collect()
}

/// Returns the root in the kernel and the kernel at x in -1..1.
fn kernel(x: f64) -> (f64, f64) {
    let root = (1.0 - x * x).max(0.0).sqrt();
    (root, (BETA * (root - 1.0)).exp())
}

/// Half the width of the kernel.
const REACH: f64 = 0.5 * WIDTH as f64;

/// Evaluates the kernel at the points around a direction that is `offset` cells behind the first.
fn kernels(offset: f64) -> [f64; WIDTH] {
    std::array::from_fn(|i| kernel((offset - i as f64) / REACH).1)
}

/// Does the same with the derivative, per cell.
fn kernels_with_slopes(offset: f64) -> [(f64, f64); WIDTH] {
    std::array::from_fn(|i| {
        let x = (offset - i as f64) / REACH;
        let (root, value) = kernel(x);
        (value, if root > 0.0 { -BETA * x / (root * REACH) * value } else { 0.0 })
    })
}

/// Adds up int f Q_l^m (cos m phi, sin m phi) d omega over scattered nodes, like
/// [`super::Moments`], at a cost per node that does not grow with the degree.
#[derive(Clone)]
pub struct GridMoments {
    plan: Arc<Plan>,
    /// Row by row.
    cells: Vec<f64>,
}

impl GridMoments {
    /// Starts with zero moments up to degree `lmax`; takes about 64 (lmax+1)^2 bytes.
    pub fn new(lmax: usize) -> Self {
        let plan = Plan::new(lmax);
        let cells = vec![0.0; plan.rows() * plan.around];
        Self { plan: Arc::new(plan), cells }
    }

    /// Adds a node: the unit vector `direction` with `weight` = f(direction) times its solid angle.
    pub fn add(&mut self, direction: DVec3, weight: f64) {
        let n = self.plan.around;
        let ([row, column], offset) = self.plan.place(direction);
        let [of_rows, of_columns] = offset.map(kernels);
        for (i, k) in of_rows.iter().enumerate() {
            let cells = &mut self.cells[(row + i) * n..(row + i + 1) * n];
            let k = k * weight;
            if let Some(cells) = cells.get_mut(column..column + WIDTH) {
                cells.iter_mut().zip(&of_columns).for_each(|(cell, c)| *cell += k * c);
            } else {
                of_columns.iter().enumerate().for_each(|(j, c)| cells[(column + j) % n] += k * c);
            }
        }
    }

    /// Adds the moments of another part of the sphere, of the same degree.
    pub fn merge(&mut self, other: &Self) {
        self.cells.iter_mut().zip(&other.cells).for_each(|(mine, theirs)| *mine += theirs);
    }

    /// Turns the moments into coefficients by the norm of the basis.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for a degree too high to evaluate.
    pub fn coefficients(&self) -> Result<Coefficients> {
        let (plan, n) = (&self.plan, self.plan.around);
        let gather = |spectra: &[Vec<Complex<f64>>], m: usize| {
            let mut line = vec![Complex::new(0.0, 0.0); n];
            for (row, orders) in spectra.iter().enumerate() {
                line[plan.on_torus(row)] += orders[m];
            }
            line
        };
        // The far side of the torus is the sphere once more.
        let fold = |line: Vec<Complex<f64>>, m: usize| {
            let far = |i: usize| if i == 0 || 2 * i == n { Complex::ZERO } else { line[n - i] };
            (0..=n / 2).map(|i| line[i] + far_sign(m) * far(i)).collect()
        };
        let mut samples = plan.divide(&self.cells, gather, fold);
        let transform = plan.transform()?;
        // Analysis weighs each sample by its solid angle; these are weighed already.
        for (ring, samples) in samples.chunks_mut(n).enumerate() {
            let weight = transform.grid().solid_angle(ring * n);
            for x in samples {
                *x /= weight;
            }
        }
        transform.analysis(&samples)
    }
}

/// Evaluates a series at scattered directions, like [`Series`], at a cost per direction that does
/// not grow with the degree.
pub struct GridSeries {
    plan: Plan,
    cells: Vec<f64>,
    series: Series,
}

impl GridSeries {
    /// Prepares the evaluation; takes about 64 (lmax+1)^2 bytes.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for a degree too high to evaluate.
    pub fn new(series: Series) -> Result<Self> {
        let plan = Plan::new(series.coefficients().lmax());
        let n = plan.around;
        let samples = plan.transform()?.synthesis(series.coefficients())?;
        let gather = |spectra: &[Vec<Complex<f64>>], m: usize| {
            let far = |i: usize| far_sign(m) * spectra[n - i][m];
            (0..n).map(|i| if 2 * i <= n { spectra[i][m] } else { far(i) }).collect()
        };
        let keep = |line: Vec<Complex<f64>>, _| {
            (0..plan.rows()).map(|row| line[plan.on_torus(row)]).collect()
        };
        let cells = plan.divide(&samples, gather, keep);
        Ok(Self { plan, cells, series })
    }

    /// Returns the coefficients of the series.
    pub fn coefficients(&self) -> &Coefficients {
        self.series.coefficients()
    }

    /// Evaluates f at the unit vector `direction`.
    pub fn value(&self, direction: DVec3) -> f64 {
        let n = self.plan.around;
        let ([row, column], offset) = self.plan.place(direction);
        let [of_rows, of_columns] = offset.map(kernels);
        let along = |i: usize| -> f64 {
            let cells = &self.cells[(row + i) * n..(row + i + 1) * n];
            match cells.get(column..column + WIDTH) {
                Some(cells) => cells.iter().zip(&of_columns).map(|(cell, c)| cell * c).sum(),
                None => (0..WIDTH).map(|j| cells[(column + j) % n] * of_columns[j]).sum(),
            }
        };
        of_rows.iter().enumerate().map(|(i, k)| k * along(i)).sum()
    }

    /// Evaluates f and its surface gradient at the unit vector `direction`.
    pub fn jet(&self, direction: DVec3) -> Jet {
        let s = direction.x.hypot(direction.y);
        if s < POLAR {
            return self.series.jet(direction);
        }
        let (value, along_theta, along_phi) = self.interpolate(direction);
        let scale = self.plan.around as f64 / (2.0 * PI);
        let (cos, sin) = (direction.x / s, direction.y / s);
        let to_south = DVec3::new(direction.z * cos, direction.z * sin, -s);
        let to_east = DVec3::new(-sin, cos, 0.0);
        let gradient = scale * (along_theta * to_south + along_phi / s * to_east);
        Jet { value, gradient }
    }

    /// Returns the value and its derivatives along theta and phi, per cell.
    fn interpolate(&self, direction: DVec3) -> (f64, f64, f64) {
        let n = self.plan.around;
        let ([row, column], offset) = self.plan.place(direction);
        let [of_rows, of_columns] = offset.map(kernels_with_slopes);
        let (mut f, mut f_theta, mut f_phi) = (0.0, 0.0, 0.0);
        for (i, (k, slope)) in of_rows.iter().enumerate() {
            let cells = &self.cells[(row + i) * n..(row + i + 1) * n];
            let (mut value, mut along) = (0.0, 0.0);
            let mut add = |cell: f64, (c, slope): (f64, f64)| {
                value += cell * c;
                along += cell * slope;
            };
            if let Some(cells) = cells.get(column..column + WIDTH) {
                cells.iter().zip(of_columns).for_each(|(cell, c)| add(*cell, c));
            } else {
                (0..WIDTH).for_each(|j| add(cells[(column + j) % n], of_columns[j]));
            }
            f += k * value;
            f_theta += slope * value;
            f_phi += k * along;
        }
        (f, f_theta, f_phi)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::math::sampling::uniform_sphere;
    use crate::sh::Moments;

    fn directions() -> Vec<DVec3> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let special = [
            DVec3::Z,
            DVec3::NEG_Z,
            DVec3::X,
            DVec3::NEG_X,
            DVec3::new(-1.0, -1e-17, 0.0),
            DVec3::new(1e-4, -1e-4, -1.0).normalize(),
            DVec3::new(1e-9, 0.0, 1.0).normalize(),
        ];
        special.into_iter().chain((0..300).map(|_| uniform_sphere(rng.random()))).collect()
    }

    fn random_series(lmax: usize) -> Series {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(lmax as u64);
        let mut c = Coefficients::zeros(lmax);
        for l in 0..=lmax {
            (0..=l).for_each(|m| c.set(l, m, rng.random::<f64>() - 0.5, rng.random::<f64>() - 0.5));
        }
        Series::new(&c).expect("not too high")
    }

    #[test]
    fn values_and_gradients_are_those_of_the_series() {
        for lmax in [0, 1, 2, 7, 40, 130] {
            let series = random_series(lmax);
            let grid = GridSeries::new(series.clone()).expect("not too high");
            let size = series.coefficients().energy().sqrt();
            for w in directions() {
                let (exact, found) = (series.jet(w), grid.jet(w));
                assert!((exact.value - grid.value(w)).abs() <= 1e-10 * size, "{lmax} {w}");
                assert!((exact.value - found.value).abs() <= 1e-10 * size, "{lmax} {w}");
                // A derivative loses the factor lmax, and 1/sin(theta) near the poles.
                let tolerance = 1e-9 * size * (1 + lmax) as f64 / w.x.hypot(w.y).max(1e-4);
                assert!((exact.gradient - found.gradient).length() <= tolerance, "{lmax} {w}");
            }
        }
    }

    #[test]
    fn moments_are_those_of_plain_sums() {
        for lmax in [0, 1, 2, 7, 40, 130] {
            let mut plain = Moments::new(lmax).expect("not too high");
            let mut halves = [GridMoments::new(lmax), GridMoments::new(lmax)];
            for (i, w) in directions().into_iter().enumerate() {
                let weight = 0.01 * ((i % 7) as f64 - 2.5);
                plain.add(w, weight);
                halves[i % 2].add(w, weight);
            }
            let [mut all, other] = halves;
            all.merge(&other);
            let (a, b) = (plain.coefficients(), all.coefficients().expect("not too high"));
            let pairs =
                a.cosines().iter().chain(a.sines()).zip(b.cosines().iter().chain(b.sines()));
            let worst = pairs.fold(0.0_f64, |w, (x, y)| w.max((x - y).abs()));
            // Coefficients of 307 nodes of weight about 0.02 are up to (2l+1)/(2 pi) times 6.
            assert!(worst <= 1e-11 * (1 + lmax) as f64, "{lmax}: {worst:e}");
        }
    }

    #[test]
    fn sizes_are_even_and_smooth() {
        assert_eq!([1, 3, 7, 11, 31, 4004].map(smooth_above), [2, 4, 8, 12, 32, 4050]);
    }
}
