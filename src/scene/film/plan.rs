//! Which pixels rest: strides from the errors of the stages before.

use rayon::prelude::*;

use super::stage::Stage;
use super::{Film, MIN_RELATIVE_LUMINANCE};

/// What part of the target a stage aims at: an error from 32 replicates is itself known to 13 %,
/// and 19 of 20 pixels must show less than the target.
const AIM: f64 = 0.8;

impl Film {
    /// Whether a stage is complete and none has begun, so that the error may be judged and the next
    /// stage planned.
    pub fn is_between_stages(&self) -> bool {
        self.passes > 0
            && self.passes.is_multiple_of(self.replicates as u64)
            && self.rounds().is_power_of_two()
    }

    /// Returns the number of passes at the end of the stage that is under way or begins.
    pub fn stage_end(&self) -> u64 {
        let stage = self.stage();
        (stage.start + stage.length) * self.replicates as u64
    }

    /// Accounts for the stage that is complete.
    pub(super) fn end_stage(&mut self) {
        let ended = Stage::of(self.rounds() - 1).length;
        for pixel in &mut self.pixels {
            pixel.spread += (ended << pixel.stride) as f32;
        }
    }

    /// Plans the stage that begins: with a `target` for the relative error, pixels take part in as
    /// few of its rounds as will meet the target after it, from what the stages before showed in
    /// the pixel and its eight neighbours; without, in all. To be called where
    /// [`Film::is_between_stages`], as often as one likes: a run that was ended in the first pass
    /// of a stage plans it anew.
    pub fn plan(&mut self, target: Option<f64>) {
        let strides = target.map(|target| self.strides(&self.stage(), target));
        self.planned = strides.is_some();
        for (i, pixel) in self.pixels.iter_mut().enumerate() {
            pixel.stride = strides.as_ref().map_or(0, |strides| strides[i]);
        }
    }

    /// Returns the standard error relative to the pixel's luminance, or to
    /// [`MIN_RELATIVE_LUMINANCE`] of the image's mean where that is more, which a `share` of the
    /// pixels do not exceed; `None` before two replicates.
    pub fn relative_error_of(&self, share: f64) -> Option<f64> {
        if self.replicates() < 2 {
            return None;
        }
        let mut errors = self.relative_errors();
        let last = ((errors.len() as f64 * share).ceil() as usize).clamp(1, errors.len()) - 1;
        let (_, error, _) = errors.select_nth_unstable_by(last, f32::total_cmp);
        Some(f64::from(*error))
    }

    /// Returns the share of the pixels whose relative error, as of [`Film::relative_error_of`], is
    /// at most `target`.
    pub fn share_within(&self, target: f64) -> f64 {
        let errors = self.relative_errors();
        errors.iter().filter(|e| f64::from(**e) <= target).count() as f64 / errors.len() as f64
    }

    fn relative_errors(&self) -> Vec<f32> {
        let mean = self.sum_of_rows(|i| self.pixel(i).luminance()) / self.pixels.len() as f64;
        let relative = |i| {
            let error = self.standard_error(i);
            // In a black image nothing is left to know.
            if error > 0.0 {
                (error / self.pixel(i).luminance().max(MIN_RELATIVE_LUMINANCE * mean)) as f32
            } else {
                0.0
            }
        };
        (0..self.pixels.len()).into_par_iter().map(relative).collect()
    }

    fn strides(&self, stage: &Stage, target: f64) -> Vec<u8> {
        let rounds = stage.start as f64;
        let mut variances = self.relative_errors();
        for (variance, pixel) in variances.iter_mut().zip(&self.pixels) {
            *variance = variance.powi(2) * (rounds * rounds) as f32 / pixel.spread;
        }
        let stride = |i: usize| {
            let of_round = f64::from(variances[i]).max(self.mean_around(&variances, i));
            // After the stage the variance is that of a round times (spread + rounds x stride) / (2
            // rounds)^2.
            let allowed = (2.0 * rounds * AIM * target).powi(2) / of_round;
            let stride = (allowed - f64::from(self.pixels[i].spread)) / rounds;
            (0..=stage.longest()).rev().find(|s| f64::from(1_u32 << s) <= stride).unwrap_or(0)
        };
        (0..self.pixels.len()).into_par_iter().map(stride).collect()
    }

    /// Returns the mean over a pixel and its neighbours.
    fn mean_around(&self, values: &[f32], i: usize) -> f64 {
        let [width, height] = self.size();
        let (x, y) = (i % width, i / width);
        let (columns, rows) = (
            x.saturating_sub(1)..=(x + 1).min(width - 1),
            y.saturating_sub(1)..=(y + 1).min(height - 1),
        );
        let count = (columns.clone().count() * rows.clone().count()) as f64;
        let of_row =
            |y: usize| columns.clone().map(|x| f64::from(values[y * width + x])).sum::<f64>();
        rows.map(of_row).sum::<f64>() / count
    }
}
