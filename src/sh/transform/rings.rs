//! The sums along phi: two rings as real and imaginary part of one complex FFT.

use std::f64::consts::PI;
use std::fmt;
use std::sync::Arc;

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f64x8};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use super::kernels::Amplitudes;
use crate::sh::legendre::{LANES, Lanes};

/// Plans the FFTs of rings of equal length.
pub(super) struct Rings {
    azimuths: usize,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
}

/// The samples of a ring and of its mirror image.
pub(super) struct RowPair<'a> {
    pub(super) north: &'a mut [f64],
    pub(super) south: Option<&'a mut [f64]>,
}

impl fmt::Debug for Rings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Rings").field("azimuths", &self.azimuths).finish_non_exhaustive()
    }
}

impl Rings {
    /// Plans for rings of so many samples.
    pub(super) fn new(azimuths: usize) -> Self {
        let mut planner = FftPlanner::new();
        Self {
            azimuths,
            forward: planner.plan_fft_forward(azimuths),
            inverse: planner.plan_fft_inverse(azimuths),
        }
    }

    /// Fills up to eight pairs of rings from their amplitudes: sum_m A_m cos(m phi) + B_m sin(m
    /// phi) = Re sum_m (A_m - i B_m) e^(i m phi); orders past n alias onto m mod n, which is exact
    /// at the samples.
    pub(super) fn synthesise<'a>(
        &self,
        level: Level,
        lmax: usize,
        amplitudes: impl Fn(usize) -> &'a Amplitudes,
        spectra: &mut Spectra,
        pairs: &mut [RowPair],
    ) {
        let n = self.azimuths;
        spectra.reset(n, pairs.len());
        dispatch!(level, simd => {
            for m in 0..=lmax {
                spectra.add(simd, m, amplitudes(m));
            }
        });
        spectra.transform(self.inverse.as_ref());
        for (pair, values) in pairs.iter_mut().zip(spectra.values.chunks_exact(n)) {
            for (sample, value) in pair.north.iter_mut().zip(values) {
                *sample = value.re;
            }
            for (sample, value) in pair.south.iter_mut().flat_map(|s| s.iter_mut()).zip(values) {
                *sample = value.im;
            }
        }
    }

    /// Transforms up to eight pairs of rings into their spectra.
    pub(super) fn analyse(&self, pairs: &[(&[f64], Option<&[f64]>)], spectra: &mut Spectra) {
        let n = self.azimuths;
        spectra.reset(n, pairs.len());
        for ((north, south), values) in pairs.iter().zip(spectra.values.chunks_exact_mut(n)) {
            for (value, sample) in values.iter_mut().zip(*north) {
                value.re = *sample;
            }
            for (value, sample) in values.iter_mut().zip(south.iter().copied().flatten()) {
                value.im = *sample;
            }
        }
        spectra.transform(self.forward.as_ref());
    }
}

/// The spectra of up to eight pairs of rings, north + i south, one after the other.
#[derive(Debug, Default)]
pub(super) struct Spectra {
    n: usize,
    count: usize,
    values: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

impl Spectra {
    fn reset(&mut self, n: usize, count: usize) {
        (self.n, self.count) = (n, count);
        self.values.clear();
        self.values.resize(n * count, Complex::new(0.0, 0.0));
    }

    fn transform(&mut self, fft: &dyn Fft<f64>) {
        let scratch = fft.get_inplace_scratch_len();
        if self.scratch.len() < scratch {
            self.scratch.resize(scratch, Complex::new(0.0, 0.0));
        }
        fft.process_with_scratch(&mut self.values, &mut self.scratch);
    }

    /// Adds order `m`: half of north + i south at m, half of the conjugates at -m.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, m: usize, Amplitudes(amplitudes): &Amplitudes) {
        let half = f64x8::splat(simd, 0.5);
        let na = half * f64x8::simd_from(simd, amplitudes[0]);
        let nb = half * f64x8::simd_from(simd, amplitudes[1]);
        let sa = half * f64x8::simd_from(simd, amplitudes[2]);
        let sb = half * f64x8::simd_from(simd, amplitudes[3]);
        let [ur, ui] = [Lanes::from(na + sb), Lanes::from(sa - nb)];
        let [vr, vi] = [Lanes::from(na - sb), Lanes::from(sa + nb)];
        let above = m % self.n;
        let below = if above == 0 { 0 } else { self.n - above };
        let mut start = 0;
        for lane in 0..self.count.min(LANES) {
            self.values[start + above] += Complex::new(ur[lane], ui[lane]);
            self.values[start + below] += Complex::new(vr[lane], vi[lane]);
            start += self.n;
        }
    }

    /// Returns the integrals over phi of the samples times cos(m phi) and sin(m phi): of the
    /// northern rings, then of the southern (zero where there is none).
    #[inline(always)]
    pub(super) fn harmonics<S: Simd>(&self, simd: S, m: usize) -> [f64x8<S>; 4] {
        let below = if m == 0 { 0 } else { self.n - m };
        let [mut gr, mut gi, mut hr, mut hi] = [[0.0; LANES]; 4];
        let mut start = 0;
        for lane in 0..self.count.min(LANES) {
            let (g, h) = (self.values[start + m], self.values[start + below]);
            (gr[lane], gi[lane], hr[lane], hi[lane]) = (g.re, g.im, h.re, h.im);
            start += self.n;
        }
        let scale = f64x8::splat(simd, PI / self.n as f64);
        let gr = scale * f64x8::simd_from(simd, gr);
        let gi = scale * f64x8::simd_from(simd, gi);
        let hr = scale * f64x8::simd_from(simd, hr);
        let hi = scale * f64x8::simd_from(simd, hi);
        [gr + hr, hi - gi, gi + hi, gr - hr]
    }
}
