//! Random shapes: Gaussian coefficients of a given spectrum, and the Gaussian random sphere.
//!
//! An isotropic Gaussian function whose degree l has the expected power P_l (the mean of f_l^2 over
//! the sphere) has independent coefficients of variance P_l for A_l0 and 2 P_l for A_lm, B_lm. The
//! Gaussian random sphere (Muinonen, Earth, Moon and Planets 72, 1996, 339-342; Muinonen et al.,
//! JQSRT 55, 1996, 577-601) has the log-normal radius r = a exp(s) / sqrt(1 + sigma^2), s such a
//! function of variance beta^2 = ln(1 + sigma^2) and covariance beta^2 sum_l c_l P_l(cos gamma),
//! c_l ~ l^-nu: its mean is a, its standard deviation sigma a, in every direction.

use std::f64::consts::TAU;

use super::{Coefficients, MAX_DEGREE};
use super::{Grid, analysis, synthesis};
use crate::math::{Randomness, Stream};
use crate::{Error, Result};

/// Draws a function whose coefficients are Gaussian: `powers[l]` is the expected mean of f_l^2 over
/// the sphere, for l = 0..=lmax. The mean of every coefficient is 0; add the mean radius to make it
/// a shape.
///
/// The same seed gives the same numbers, degree by degree: a longer list adds degrees and leaves
/// the lower ones as they are.
///
/// # Errors
/// [`Error::Parameter`] without powers, with more than [`MAX_DEGREE`] + 1, or when one is negative
/// or not finite.
pub fn gaussian(powers: &[f64], seed: u64) -> Result<Coefficients> {
    if powers.is_empty() || powers.len() > MAX_DEGREE + 1 {
        return Err(Error::Parameter(format!(
            "a spectrum needs 1 to {} degrees, found {}",
            MAX_DEGREE + 1,
            powers.len()
        )));
    }
    if let Some((l, power)) =
        powers.iter().enumerate().find(|(_, p)| !(p.is_finite() && **p >= 0.0))
    {
        return Err(Error::Parameter(format!(
            "the power of a degree must be finite and not negative; that of degree {l} is {power}"
        )));
    }
    let mut f = Coefficients::zeros(powers.len() - 1);
    for (l, power) in powers.iter().enumerate() {
        let mut stream = Stream::new(Randomness::Pseudorandom, seed, l as u64);
        f.set(l, 0, power.sqrt() * normal_pair(&mut stream)[0], 0.0);
        let deviation = (2.0 * power).sqrt();
        for m in 1..=l {
            let [a, b] = normal_pair(&mut stream);
            f.set(l, m, deviation * a, deviation * b);
        }
    }
    Ok(f)
}

/// Returns two independent standard normal numbers (Box and Muller 1958).
fn normal_pair(stream: &mut Stream) -> [f64; 2] {
    let [u, v] = stream.next_2d();
    let radius = (-2.0 * (1.0 - u).ln()).sqrt();
    let (sin, cos) = (TAU * v).sin_cos();
    [radius * cos, radius * sin]
}

/// Returns powers c_l ~ l^-exponent for l in `first..=last` that add up to `total`; zero below
/// `first`.
///
/// # Errors
/// [`Error::Parameter`] unless 1 <= first <= last <= [`MAX_DEGREE`], the exponent is within -10 to
/// 50, and the total finite and not negative.
pub fn power_law(total: f64, exponent: f64, first: usize, last: usize) -> Result<Vec<f64>> {
    if !(1 <= first && first <= last && last <= MAX_DEGREE) {
        return Err(Error::Parameter(format!(
            "the degrees of a power law must be 1 <= first <= last <= {MAX_DEGREE}, found {first} \
             and {last}"
        )));
    }
    if !((-10.0..=50.0).contains(&exponent) && total.is_finite() && total >= 0.0) {
        return Err(Error::Parameter(format!(
            "a power law needs an exponent within -10 to 50 and a variance that is not negative, \
             found {exponent} and {total}"
        )));
    }
    // Relative to the first, so that no power leaves the range of f64.
    let law = |l: usize| {
        if l < first { 0.0 } else { (l as f64 / first as f64).powf(-exponent) }
    };
    let sum: f64 = (first..=last).map(law).sum();
    Ok((0..=last).map(|l| total * law(l) / sum).collect())
}

/// Describes the statistics of a Gaussian random sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussianSphere {
    /// The mean radius a, m.
    pub mean_radius: f64,
    /// The standard deviation of the radius over its mean; 0 is a sphere, rocks and asteroids have
    /// 0.1 to 0.3.
    pub sigma: f64,
    /// The exponent of the covariance of the log-radius, c_l ~ l^-nu; large is smooth.
    pub nu: f64,
    /// The lowest degree of the log-radius, usually 2: degree 1 mostly shifts the centre.
    pub first: usize,
    /// The highest degree of the log-radius.
    pub last: usize,
}

/// Holds one random shape and how well its series follows the log-normal radius.
#[derive(Debug, Clone, PartialEq)]
pub struct RandomShape {
    /// The series of the radius, m.
    pub coefficients: Coefficients,
    /// The root mean square over the sphere of what truncation leaves, m.
    pub rms: f64,
    /// The largest of it at the sampled directions, m.
    pub max: f64,
}

/// How many times finer than the degree the grid is that the radius is sampled on; exp(s) has
/// harmonics of all degrees.
const OVERSAMPLING: usize = 3;

impl GaussianSphere {
    /// Draws one shape and projects its radius onto degree `lmax`; the same seed gives the same
    /// shape, whatever `lmax`.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the mean radius is not positive, sigma not within 0 to 10, or as
    /// [`power_law`].
    pub fn draw(&self, lmax: usize, seed: u64) -> Result<RandomShape> {
        let (log_radius, scale) = self.log_radius(seed)?;
        let degree = lmax.max(self.last) + 8;
        let grid = Grid::gauss_legendre(OVERSAMPLING * degree, 2 * OVERSAMPLING * degree);
        let mut radii = synthesis(&log_radius, &grid)?;
        for s in &mut radii {
            *s = scale * s.exp();
        }
        let coefficients = analysis(&radii, &grid, lmax)?;
        let series = synthesis(&coefficients, &grid)?;
        let (mut square, mut max) = (0.0, 0.0_f64);
        for (i, (exact, found)) in radii.iter().zip(&series).enumerate() {
            let error = (exact - found).abs();
            square += grid.solid_angle(i) * error * error;
            max = max.max(error);
        }
        let rms = (square / (2.0 * TAU)).sqrt();
        Ok(RandomShape { coefficients, rms, max })
    }

    /// Draws s, and gives the factor of exp(s).
    fn log_radius(&self, seed: u64) -> Result<(Coefficients, f64)> {
        if !(self.mean_radius.is_finite() && self.mean_radius > 0.0) {
            return Err(Error::Parameter(format!(
                "the mean radius of a random sphere must be positive and finite, found {}",
                self.mean_radius
            )));
        }
        if !(0.0..=10.0).contains(&self.sigma) {
            return Err(Error::Parameter(format!(
                "the relative standard deviation of a random sphere must be within 0 to 10, found \
                 {}",
                self.sigma
            )));
        }
        let variance = self.sigma.powi(2).ln_1p();
        let powers = power_law(variance, self.nu, self.first, self.last)?;
        Ok((gaussian(&powers, seed)?, self.mean_radius / (0.5 * variance).exp()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stats::Estimate;
    use crate::sh::{Spectrum, difference};

    const ROCK: GaussianSphere =
        GaussianSphere { mean_radius: 2.0, sigma: 0.2, nu: 3.3, first: 2, last: 16 };

    #[test]
    fn unusable_parameters_are_refused() {
        assert!(gaussian(&[], 1).is_err() && gaussian(&[1.0, -1.0], 1).is_err());
        assert!(gaussian(&[f64::NAN], 1).is_err());
        assert!(gaussian(&vec![0.0; MAX_DEGREE + 2], 1).is_err());
        for (first, last) in [(0, 4), (5, 4), (1, MAX_DEGREE + 1)] {
            assert!(power_law(1.0, 3.0, first, last).is_err(), "{first} {last}");
        }
        assert!(power_law(-1.0, 3.0, 1, 4).is_err() && power_law(1.0, f64::NAN, 1, 4).is_err());
        for bad in [
            GaussianSphere { mean_radius: 0.0, ..ROCK },
            GaussianSphere { mean_radius: f64::INFINITY, ..ROCK },
            GaussianSphere { sigma: -0.1, ..ROCK },
            GaussianSphere { sigma: f64::NAN, ..ROCK },
        ] {
            assert!(bad.draw(8, 1).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn sigma_zero_is_a_sphere() {
        let ball = GaussianSphere { sigma: 0.0, ..ROCK }.draw(4, 1).expect("valid");
        assert!((ball.coefficients.mean() - 2.0).abs() <= 1e-14 && ball.max <= 1e-14);
    }

    #[test]
    fn seeds_make_shapes_and_degrees_extend_them() {
        let low = gaussian(&[0.0, 1.0, 1.0], 7).expect("valid");
        let high = gaussian(&[0.0, 1.0, 1.0, 1.0], 7).expect("valid");
        assert_eq!(high.truncated(2), low);
        assert_ne!(gaussian(&[0.0, 1.0, 1.0], 8).expect("valid"), low);
        let (a, b) = (ROCK.draw(8, 3).expect("valid"), ROCK.draw(24, 3).expect("valid"));
        let d = difference(&a.coefficients, &b.coefficients.truncated(8));
        // Aliasing of the coarser grid, three times oversampled.
        assert!(d.energy().sqrt() <= 1e-9, "{}", d.energy().sqrt());
        assert!(b.rms < a.rms && a.rms <= a.max);
    }

    #[test]
    fn power_law_has_its_sum_and_slope() {
        let powers = power_law(0.04, 3.0, 2, 6).expect("valid");
        assert!((powers.iter().sum::<f64>() - 0.04).abs() <= 1e-17);
        assert_eq!((powers[0], powers[1], powers.len()), (0.0, 0.0, 7));
        assert!((powers[2] / powers[4] - 8.0).abs() <= 1e-14);
    }

    /// 400 seeds; the means of all ten powers are judged together at a false-alarm rate of 1e-3
    /// (the seeds are fixed).
    #[test]
    fn powers_have_their_expectation() {
        let powers = power_law(0.09, 2.0, 1, 10).expect("valid");
        let spectra: Vec<Spectrum> =
            (0..400).map(|seed| Spectrum::of(&gaussian(&powers, seed).expect("valid"))).collect();
        for (l, &power) in powers.iter().enumerate().skip(1) {
            let found: Vec<f64> = spectra.iter().map(|s| s.degrees()[l].power).collect();
            let estimate = Estimate::of_replicates(&found);
            assert!(estimate.agrees_with(power, 0.0, 10), "degree {l}: {estimate:?}");
            // The power of degree l is chi-square of 2l + 1 degrees of freedom: relative variance 2
            // / (2l+1).
            let variance = estimate.standard_error.powi(2) * 400.0;
            let expected = power.powi(2) * 2.0 / (2 * l + 1) as f64;
            // Its sample over 400 has a relative deviation below 0.25 (kurtosis of l = 1 included):
            // 4 of them are past 1e-4.
            assert!((variance / expected - 1.0).abs() <= 1.0, "degree {l}");
        }
    }

    /// 200 seeds; mean and mean square of the radius over the sphere at a false-alarm rate of 1e-3
    /// together (the seeds are fixed).
    #[test]
    fn gaussian_spheres_have_their_mean_and_variance() {
        let shapes: Vec<Coefficients> =
            (0..200).map(|seed| ROCK.draw(20, seed).expect("valid").coefficients).collect();
        let means: Vec<f64> = shapes.iter().map(Coefficients::mean).collect();
        let squares: Vec<f64> = shapes.iter().map(|c| c.energy() / (2.0 * TAU)).collect();
        let (mean, square) = (Estimate::of_replicates(&means), Estimate::of_replicates(&squares));
        assert!(mean.agrees_with(2.0, 0.0, 2), "{mean:?}");
        // Truncation at degree 20 takes some 1e-5 of the square, far below its standard error.
        assert!(square.agrees_with(4.0 * 1.04, 1e-4, 2), "{square:?}");
        assert!(square.standard_error <= 0.05);
    }
}
