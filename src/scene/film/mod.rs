//! The film: per pixel the weighted sums of its samples, for every replicate by itself, from which
//! mean and standard error follow.
//!
//! A pixel takes 192 bytes with 32 replicates: 4096 x 4096 pixels are 3 GiB.

mod light;
mod plan;
mod stage;
#[cfg(test)]
mod tests;

use std::ops::Range;

use rayon::prelude::*;

pub use self::light::SplitLight;
pub(crate) use self::stage::MAX_STRIDE_LOG2;

use self::stage::Stage;
use crate::math::Rgb;
use crate::math::stats::median;
use crate::{Error, Result, memory};

/// The most pixels of one film: 8192 x 8192, which takes 12 GiB with 32 replicates.
pub const MAX_PIXELS: usize = 1 << 26;

/// Pixels darker than this part of the image's mean are asked for the error that one of this
/// luminance may have.
pub const MIN_RELATIVE_LUMINANCE: f64 = 0.1;

/// Accumulates one sample per pixel and pass; pass p belongs to replicate p mod R, all R replicates
/// being independent.
///
/// The replicates keep luminance only; the standard error is that of the luminance. [`Film::plan`]
/// lets pixels that are known well enough rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    pub(crate) width: usize,
    pub(crate) replicates: usize,
    pub(crate) passes: u64,
    /// Whether the present stage has strides and random numbers of its own.
    pub(crate) planned: bool,
    pub(crate) samples: u64,
    pub(crate) non_finite: u64,
    /// The sum over passes of the flux that left the scene.
    pub(crate) escaped: Rgb,
    pub(crate) pixels: Vec<Pixel>,
    /// Per pixel and replicate: the weighted sum of luminances.
    pub(crate) sums: Vec<f32>,
}

/// Holds the weighted sum of the samples of one pixel, and how it is sampled at present.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Pixel {
    pub(crate) light: SplitLight,
    /// The weight of samples that were not finite; counted, never added.
    pub(crate) non_finite: f32,
    /// The sum over complete stages of rounds times stride: the variance is that of a round times
    /// this over the square of all rounds.
    pub(crate) spread: f32,
    /// The logarithm of the stride.
    pub(crate) stride: u8,
}

impl Film {
    /// Starts an empty film of `width` x `height` pixels with `replicates` (at least 2) independent
    /// replicates.
    ///
    /// # Errors
    /// [`Error::Parameter`] without any pixel or above [`MAX_PIXELS`], [`Error::Memory`] when it
    /// does not fit.
    pub fn new([width, height]: [u32; 2], replicates: usize) -> Result<Self> {
        let n = width as usize * height as usize;
        if n == 0 {
            return Err(Error::Parameter(format!(
                "an image of {width} x {height} pixels is empty: it needs at least one pixel each \
                 way"
            )));
        }
        if n > MAX_PIXELS {
            return Err(Error::Parameter(format!(
                "an image of {width} x {height} pixels is beyond what a film holds; at most \
                 {MAX_PIXELS} pixels are possible"
            )));
        }
        // The samples of a pass lie beside the film.
        let each = size_of::<Pixel>() + size_of::<f32>() * replicates + size_of::<SplitLight>();
        let name = format_args!("a film of {width} x {height} pixels");
        memory::ask(n as f64 * each as f64, name, |share| {
            let [width, height] = [width, height].map(|side| f64::from(side) * share.sqrt());
            format!("about {width:.0} x {height:.0} would fit; choose fewer pixels")
        })?;
        Ok(Self {
            width: width as usize,
            replicates,
            passes: 0,
            planned: false,
            samples: 0,
            non_finite: 0,
            escaped: Rgb::BLACK,
            pixels: vec![Pixel::default(); n],
            sums: vec![0.0; n * replicates],
        })
    }

    /// Returns width and height.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.pixels.len() / self.width]
    }

    /// Returns the number of complete passes.
    pub fn passes(&self) -> usize {
        self.passes as usize
    }

    /// Returns the number of independent replicates that have at least one pass.
    pub fn replicates(&self) -> usize {
        self.replicates.min(self.passes())
    }

    /// Returns the replicate of the next pass.
    pub fn replicate(&self) -> usize {
        self.passes() % self.replicates
    }

    /// Returns the number of samples of all pixels together.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Returns the number of the present stage's own scramble of random numbers; 0 where the run
    /// goes on with those it began with.
    pub fn scramble(&self) -> u64 {
        if self.planned { self.stage().start } else { 0 }
    }

    /// Returns the index of the next pass in its scramble.
    pub fn round(&self) -> u64 {
        if self.planned { self.rounds() - self.stage().start } else { self.rounds() }
    }

    /// Returns the index, in the present scramble, of the sample that a pixel takes in the next
    /// pass; `None` when it rests.
    pub fn index(&self, pixel: usize) -> Option<u64> {
        let (stage, stride) = (self.stage(), self.pixels[pixel].stride);
        let within = self.rounds() - stage.start;
        let active = within & ((1 << stride) - 1) == stage.phase(pixel, stride);
        active.then_some(if self.planned { within >> stride } else { self.rounds() })
    }

    /// Adds a complete pass: a sample, cd/m2, for every pixel, top row first. What is there for a
    /// pixel that rests is left out, so light that walks send to any pixel may be added to the
    /// samples before.
    pub fn add_pass(&mut self, samples: &[SplitLight]) {
        let (replicate, stage) = (self.replicate(), self.stage());
        let within = self.rounds() - stage.start;
        let counts = (self.pixels.par_iter_mut())
            .zip(self.sums.par_chunks_exact_mut(self.replicates))
            .zip(samples)
            .enumerate()
            .map(|(i, ((pixel, sums), sample))| {
                if within & ((1 << pixel.stride) - 1) != stage.phase(i, pixel.stride) {
                    return [0, 0];
                }
                let weight = f64::from(1_u32 << pixel.stride);
                if !sample.is_finite() {
                    pixel.non_finite += weight as f32;
                    return [1, 1];
                }
                // Memory is not taken for what stays black: most of a first pass that was cut short.
                if *sample != SplitLight::default() {
                    pixel.light.direct += sample.direct * weight;
                    pixel.light.indirect += sample.indirect * weight;
                    sums[replicate] += (sample.total().luminance() * weight) as f32;
                }
                [1, 0]
            });
        let [taken, non_finite] = counts.reduce(|| [0, 0], |a, b| [a[0] + b[0], a[1] + b[1]]);
        self.samples += taken;
        self.non_finite += non_finite;
        self.passes += 1;
        if self.is_between_stages() {
            self.end_stage();
        }
    }

    /// Adds the flux that left the scene in a pass.
    pub fn add_escaped(&mut self, flux: Rgb) {
        self.escaped += flux;
    }

    /// Returns the flux that left the scene, summed over passes.
    pub fn escaped(&self) -> Rgb {
        self.escaped
    }

    /// Returns the number of samples that were not finite numbers.
    pub fn non_finite(&self) -> u64 {
        self.non_finite
    }

    /// Returns the mean colour of a pixel, cd/m2; black before its first sample.
    pub fn pixel(&self, pixel: usize) -> Rgb {
        self.light(pixel).total()
    }

    /// Returns the mean of a pixel, direct light by itself.
    pub fn light(&self, pixel: usize) -> SplitLight {
        let weight = self.weight(pixel);
        if weight > 0.0 { self.pixels[pixel].light / weight } else { SplitLight::default() }
    }

    /// Returns the mean colour of every pixel, cd/m2, top row first; black before the first pass.
    pub fn image(&self) -> Vec<Rgb> {
        self.each(|i| self.pixel(i))
    }

    /// Returns the part of [`Film::image`] that came straight from lights and emitting surfaces.
    pub fn direct(&self) -> Vec<Rgb> {
        self.each(|i| self.light(i).direct)
    }

    /// Returns the part of [`Film::image`] that was reflected before.
    pub fn indirect(&self) -> Vec<Rgb> {
        self.each(|i| self.light(i).indirect)
    }

    /// Returns the standard error of the luminance of a pixel, cd/m2; infinite before two
    /// replicates have samples.
    pub fn standard_error(&self, pixel: usize) -> f64 {
        if self.replicates() < 2 {
            return f64::INFINITY;
        }
        let (used, squares) =
            self.deviations(pixel).fold((0, 0.0), |(used, squares), d| (used + 1, squares + d * d));
        spread(used, squares)
    }

    /// Returns the standard error of the luminance of every pixel, cd/m2; infinite before two
    /// replicates have samples.
    pub fn standard_errors(&self) -> Vec<f64> {
        self.each(|i| self.standard_error(i))
    }

    /// Returns the mean luminance of the whole image and its standard error from the replicates'
    /// means: pixels share walks, so their errors do not average out independently.
    pub fn mean(&self) -> (f64, f64) {
        let n = self.pixels.len() as f64;
        let mean = self.sum_of_rows(|i| self.pixel(i).luminance());
        if self.replicates() < 2 {
            return (mean / n, f64::INFINITY);
        }
        let totals = self.rows(|row| {
            let mut totals = vec![0.0; self.replicates];
            for i in row {
                totals.iter_mut().zip(self.deviations(i)).for_each(|(total, d)| *total += d);
            }
            totals
        });
        let totals = (0..self.replicates).map(|r| totals.iter().map(|row| row[r]).sum::<f64>());
        let squares: f64 = totals.map(|total| (total / n).powi(2)).sum();
        (mean / n, spread(self.replicates(), squares))
    }

    /// Returns the median over pixels with light of the standard error relative to the mean; `None`
    /// before two replicates.
    pub fn median_relative_error(&self) -> Option<f64> {
        if self.replicates() < 2 {
            return None;
        }
        let lit = (0..self.pixels.len()).into_par_iter().map(|i| (self.pixel(i).luminance(), i));
        let lit = lit.filter(|(y, _)| *y > 0.0).map(|(y, i)| self.standard_error(i) / y);
        median(lit.collect::<Vec<_>>())
    }

    /// Returns something of each pixel.
    fn each<T: Send>(&self, of: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
        (0..self.pixels.len()).into_par_iter().map(of).collect()
    }

    /// Does something with the pixels of each row, many rows at once.
    fn rows<T: Send>(&self, of: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
        let of = |y: usize| of(y * self.width..(y + 1) * self.width);
        (0..self.size()[1]).into_par_iter().map(of).collect()
    }

    /// Sums over all pixels, row by row, so that the sum is the same on any number of threads.
    fn sum_of_rows(&self, of: impl Fn(usize) -> f64 + Sync) -> f64 {
        self.rows(|row| row.map(&of).sum::<f64>()).into_iter().sum()
    }

    /// Returns what a replicate's share in the mean of a pixel differs from what it would be if all
    /// agreed, replicates with samples only.
    fn deviations(&self, pixel: usize) -> impl Iterator<Item = f64> {
        let sums = &self.sums[pixel * self.replicates..][..self.replicates];
        let [more, fewer] = self.replicate_weights(pixel);
        let (split, total) = (self.replicate(), self.weight(pixel).max(f64::MIN_POSITIVE));
        let mean = sums.iter().map(|s| f64::from(*s)).sum::<f64>() / total;
        let all = sums.iter().enumerate();
        let weighed = all.map(move |(r, s)| (f64::from(*s), if r < split { more } else { fewer }));
        weighed.filter(|(_, w)| *w > 0.0).map(move |(s, w)| (s - w * mean) / total)
    }

    /// Returns the weight of all finite samples of a pixel.
    fn weight(&self, pixel: usize) -> f64 {
        let [more, fewer] = self.replicate_weights(pixel);
        let split = self.replicate() as f64;
        let non_finite = f64::from(self.pixels[pixel].non_finite);
        more * split + fewer * (self.replicates as f64 - split) - non_finite
    }

    /// Returns the weight of a pixel in the replicates that are in the present round already, and
    /// in the others.
    fn replicate_weights(&self, pixel: usize) -> [f64; 2] {
        let (stage, stride) = (self.stage(), self.pixels[pixel].stride);
        let within = self.rounds() - stage.start;
        [within + 1, within].map(|rounds| stage.weight(pixel, stride, rounds) as f64)
    }

    fn rounds(&self) -> u64 {
        self.passes / self.replicates as u64
    }

    fn stage(&self) -> Stage {
        Stage::of(self.rounds())
    }
}

/// Returns the standard error from the sum of squared deviations of so many replicates.
fn spread(used: usize, squares: f64) -> f64 {
    if used < 2 { f64::INFINITY } else { (squares * used as f64 / (used - 1) as f64).sqrt() }
}
