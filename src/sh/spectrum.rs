//! The power spectrum of a series: how much of it each degree carries.
//!
//! sigma_l^2 = A_l0^2 + 1/2 sum_(m>0) (A^2 + B^2) is the degree variance of `docs/how/conventions.md`;
//! the power P_l = sigma_l^2 / (2l+1) is the mean of f_l^2 over the sphere, which pyshtools calls
//! the power per degree of 4pi-normalised coefficients. The powers add up to the mean of f^2.

use super::Coefficients;

/// Holds one degree of a spectrum, in units of f and their squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DegreePower {
    /// The degree l.
    pub degree: usize,
    /// The degree variance sigma_l^2; |f_l| <= sigma_l everywhere.
    pub variance: f64,
    /// The mean of f_l^2 over the sphere, sigma_l^2 / (2l+1).
    pub power: f64,
    /// The root mean square of f_l, the square root of the power.
    pub amplitude: f64,
    /// The share of degrees 1 to l in the variance of f about its mean, 0 to 1; 1 throughout for a
    /// constant.
    pub cumulative: f64,
    /// The root mean square of all degrees above l: the error of truncation at l.
    pub remainder: f64,
}

/// Holds the power of every degree of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    degrees: Vec<DegreePower>,
    mean: f64,
}

impl Spectrum {
    /// Takes the spectrum of a series.
    pub fn of(f: &Coefficients) -> Self {
        let powers: Vec<f64> =
            (0..=f.lmax()).map(|l| f.degree_deviation(l).powi(2) / (2 * l + 1) as f64).collect();
        // From the top down, so that small remainders keep their digits.
        let mut above = vec![0.0; powers.len()];
        for l in (0..f.lmax()).rev() {
            above[l] = above[l + 1] + powers[l + 1];
        }
        let total = above[0];
        let row = |(l, (&power, &above)): (usize, (&f64, &f64))| DegreePower {
            degree: l,
            variance: power * (2 * l + 1) as f64,
            power,
            amplitude: power.sqrt(),
            cumulative: if total > 0.0 { 1.0 - above / total } else { 1.0 },
            remainder: above.sqrt(),
        };
        let degrees = powers.iter().zip(&above).enumerate().map(row).collect();
        Self { degrees, mean: f.mean() }
    }

    /// Returns the degrees 0 to lmax in ascending order.
    pub fn degrees(&self) -> &[DegreePower] {
        &self.degrees
    }

    /// Returns the root mean square of f about its mean.
    pub fn deviation(&self) -> f64 {
        self.degrees.first().map_or(0.0, |zero| zero.remainder)
    }

    /// Returns the root mean square of |grad_S f|, per radian: the square root of sum l(l+1) P_l.
    pub fn slope(&self) -> f64 {
        let slope = |d: &DegreePower| (d.degree * (d.degree + 1)) as f64 * d.power;
        self.degrees.iter().map(slope).sum::<f64>().sqrt()
    }

    /// Returns the RMS slope over the mean radius: the tangent of a typical tilt of the surface
    /// against the sphere. Infinite or NaN for a mean of 0.
    pub fn relative_slope(&self) -> f64 {
        self.slope() / self.mean.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sampling::uniform_sphere;
    use crate::sh::Series;

    fn shape() -> Coefficients {
        let mut c = Coefficients::zeros(5);
        for l in 0..=5 {
            for m in 0..=l {
                c.set(l, m, ((l * 7 + m * 3) as f64).cos(), ((l + m * 5) as f64).sin());
            }
        }
        c
    }

    #[test]
    fn constant_has_one_degree() {
        let mut c = Coefficients::zeros(0);
        c.set(0, 0, 2.0, 0.0);
        let spectrum = Spectrum::of(&c);
        let expected = DegreePower {
            degree: 0,
            variance: 4.0,
            power: 4.0,
            amplitude: 2.0,
            cumulative: 1.0,
            remainder: 0.0,
        };
        assert_eq!(spectrum.degrees(), [expected]);
        assert_eq!((spectrum.deviation(), spectrum.relative_slope()), (0.0, 0.0));
    }

    #[test]
    fn powers_are_means_over_the_sphere() {
        let c = shape();
        let spectrum = Spectrum::of(&c);
        let f = Series::new(&c).expect("degree 5");
        let n = 200;
        let (mut square, mut slope) = (0.0, 0.0);
        for i in 0..n * n {
            let mid = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
            let jet = f.jet(uniform_sphere([mid(i / n), mid(i % n)]));
            square += jet.value * jet.value / f64::from(n * n);
            slope += jet.gradient.length_squared() / f64::from(n * n);
        }
        // The midpoint rule in z on 200 rings is good to 1e-4 of these polynomials of degree 10.
        let powers: f64 = spectrum.degrees().iter().map(|d| d.power).sum();
        assert!((powers / square - 1.0).abs() <= 2e-4);
        assert!((spectrum.slope() / slope.sqrt() - 1.0).abs() <= 2e-4);
        assert!((spectrum.relative_slope() - spectrum.slope() / c.mean()).abs() <= 1e-15);
        assert!((c.energy() / (4.0 * std::f64::consts::PI) / powers - 1.0).abs() <= 1e-14);
    }

    #[test]
    fn remainder_is_the_error_of_truncation() {
        let c = shape();
        for row in Spectrum::of(&c).degrees() {
            let mut rest = c.clone();
            for l in 0..=row.degree {
                for m in 0..=l {
                    rest.set(l, m, 0.0, 0.0);
                }
            }
            let rms = (rest.energy() / (4.0 * std::f64::consts::PI)).sqrt();
            assert!((row.remainder - rms).abs() <= 1e-14);
        }
        let last = Spectrum::of(&c).degrees()[5];
        assert_eq!((last.cumulative, last.remainder), (1.0, 0.0));
    }
}
