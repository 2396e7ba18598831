//! The film: per pixel the sum of its samples and the sums of the replicates, from which mean and standard error follow.

use crate::math::Rgb;
use crate::math::stats::median;
use crate::{Error, Result};

/// The most pixels of one film: 8192 x 8192, which takes 12 GB with 32 replicates.
pub const MAX_PIXELS: usize = 1 << 26;

/// Accumulates one sample per pixel and pass; pass p belongs to replicate p mod R, all R replicates being independent.
///
/// The replicates keep luminance only; the standard error is that of the luminance.
#[derive(Debug, Clone)]
pub struct Film {
    width: usize,
    replicates: usize,
    passes: usize,
    pixels: Vec<Pixel>,
    /// Per pixel and replicate: the sum of luminances.
    sums: Vec<f32>,
}

/// Holds the sum of the samples of one pixel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pixel {
    sum: Rgb,
    /// Samples that were not finite; counted, never added.
    spoilt: u32,
}

impl Film {
    /// Starts an empty film of `width` x `height` pixels with `replicates` (at least 2) independent replicates.
    ///
    /// # Errors
    /// [`Error::Parameter`] above [`MAX_PIXELS`].
    pub fn new([width, height]: [u32; 2], replicates: usize) -> Result<Self> {
        let n = width as usize * height as usize;
        if n > MAX_PIXELS {
            return Err(Error::Parameter(format!(
                "an image of {width} x {height} pixels is beyond memory (about {} GB); at most {MAX_PIXELS} pixels are possible",
                (n as u64 * 184).div_ceil(1 << 30)
            )));
        }
        Ok(Self {
            width: width as usize,
            replicates,
            passes: 0,
            pixels: vec![Pixel::default(); n],
            sums: vec![0.0; n * replicates],
        })
    }

    /// Gives width and height.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.pixels.len() / self.width]
    }

    /// Gives the number of complete passes.
    pub fn passes(&self) -> usize {
        self.passes
    }

    /// Gives the number of independent replicates that have at least one pass.
    pub fn replicates(&self) -> usize {
        self.replicates.min(self.passes)
    }

    /// Adds a complete pass: one luminance sample, cd/m2, for every pixel, top row first.
    pub fn add_pass(&mut self, samples: &[Rgb]) {
        let replicate = self.passes % self.replicates;
        for (i, (pixel, sample)) in self.pixels.iter_mut().zip(samples).enumerate() {
            if sample.is_finite() {
                pixel.sum += *sample;
                self.sums[i * self.replicates + replicate] += sample.luminance() as f32;
            } else {
                pixel.spoilt += 1;
            }
        }
        self.passes += 1;
    }

    /// Gives the number of samples that were not finite numbers.
    pub fn spoilt(&self) -> u64 {
        self.pixels.iter().map(|p| u64::from(p.spoilt)).sum()
    }

    /// Gives the mean colour of every pixel, cd/m2, top row first; black before the first pass.
    pub fn image(&self) -> Vec<Rgb> {
        self.pixels
            .iter()
            .map(|p| p.sum / (self.passes - p.spoilt as usize).max(1) as f64)
            .collect()
    }

    /// Gives the standard error of the luminance of every pixel, cd/m2; infinite before two replicates have samples.
    pub fn standard_errors(&self) -> Vec<f64> {
        self.sums
            .chunks_exact(self.replicates)
            .map(|sums| self.standard_error(|r| f64::from(sums[r])))
            .collect()
    }

    /// Gives the mean luminance of the whole image and its standard error from the replicates' means: pixels share walks, so their errors
    /// do not average out independently.
    pub fn mean(&self) -> (f64, f64) {
        let mut totals = vec![0.0; self.replicates];
        for sums in self.sums.chunks_exact(self.replicates) {
            totals.iter_mut().zip(sums).for_each(|(total, s)| *total += f64::from(*s));
        }
        let n = self.pixels.len() as f64;
        let mean = totals.iter().sum::<f64>() / (n * self.passes.max(1) as f64);
        (mean, self.standard_error(|r| totals[r] / n))
    }

    /// Gives the median over pixels with light of the standard error relative to the mean; `None` before two replicates.
    pub fn median_relative_error(&self) -> Option<f64> {
        let errors = self.standard_errors().into_iter();
        let relative = self.image().into_iter().zip(errors).filter(|(c, _)| c.luminance() > 0.0);
        median(relative.map(|(c, e)| e / c.luminance()))
    }

    /// Weighs replicates by their passes: se^2 = R/(R-1) sum w_r^2 (m_r - m)^2, which is the usual formula when all have the same number.
    fn standard_error(&self, sum: impl Fn(usize) -> f64) -> f64 {
        let used = self.replicates();
        if used < 2 {
            return f64::INFINITY;
        }
        let passes = |r: usize| ((self.passes + self.replicates - 1 - r) / self.replicates) as f64;
        let total = self.passes as f64;
        let mean = (0..used).map(&sum).sum::<f64>() / total;
        let squares: f64 =
            (0..used).map(|r| (passes(r) / total * (sum(r) / passes(r) - mean)).powi(2)).sum();
        (squares * used as f64 / (used - 1) as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(passes: &[f64]) -> Film {
        let mut film = Film::new([1, 1], 4).expect("small");
        for &v in passes {
            film.add_pass(&[Rgb::grey(v)]);
        }
        film
    }

    #[test]
    fn empty_film_is_black_with_unknown_error() {
        let film = film(&[]);
        assert_eq!(film.image(), vec![Rgb::BLACK]);
        assert!(film.standard_errors()[0].is_infinite());
        assert_eq!(film.median_relative_error(), None);
    }

    #[test]
    fn films_beyond_memory_are_refused() {
        let error = Film::new([60_000, 60_000], 32).expect_err("too large").to_string();
        assert!(error.contains("60000 x 60000") && error.contains("GB"), "{error}");
    }

    #[test]
    fn error_is_that_of_the_replicate_means() {
        // Replicates 1, 2, 3, 4 twice: means 1..4, s.e. sqrt(5/3 / 4).
        let film = film(&[1.0, 2.0, 3.0, 4.0, 1.0, 2.0, 3.0, 4.0]);
        assert!((film.image()[0].luminance() - 2.5).abs() <= 1e-15);
        assert!((film.standard_errors()[0] - (5.0_f64 / 12.0).sqrt()).abs() <= 1e-7);
        let (mean, error) = film.mean();
        assert!((mean - 2.5).abs() <= 1e-7 && (error - (5.0_f64 / 12.0).sqrt()).abs() <= 1e-7);
    }

    #[test]
    fn spoilt_samples_are_counted_not_averaged() {
        let film = film(&[1.0, f64::NAN, 1.0, f64::INFINITY]);
        assert_eq!((film.spoilt(), film.image()[0].luminance()), (2, 1.0));
    }
}
