//! The inner loops of the transform: sums over degrees at rings, and over rings for each degree,
//! eight mirrored pairs of rings side by side.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f64x8};

use crate::sh::legendre::{LANES, Lanes};
use crate::sh::two_step::{Quad, Step, advance, sum_steps};

/// Steps of the recurrence whose sums stay in the first-level cache while the rings pass by.
const TILE: usize = 64;

/// Amplitudes of one order on eight pairs of rings, four numbers a pair. Towards samples: cosine
/// and sine of the northern ring, then of the southern; towards coefficients: cosine and sine of
/// the even part, then of the odd part times z.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Amplitudes(pub(super) [Lanes; 4]);

impl Amplitudes {
    pub(super) const ZERO: Self = Self([[0.0; LANES]; 4]);
}

/// cos(theta) and sin(theta) of eight northern rings; lanes without a ring have 0.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Zones {
    pub(super) z: Lanes,
    pub(super) s: Lanes,
}

/// One order of the recurrence.
pub(super) struct Order<'a> {
    pub(super) m: usize,
    /// p_0.
    pub(super) start: f64,
    pub(super) steps: &'a [Step],
}

/// Raises eight numbers to the power `m`.
#[inline(always)]
fn power<S: Simd>(simd: S, base: f64x8<S>, m: usize) -> f64x8<S> {
    let (mut result, mut square, mut left) = (f64x8::splat(simd, 1.0), base, m);
    while left > 0 {
        if left % 2 == 1 {
            result *= square;
        }
        square = square * square;
        left /= 2;
    }
    result
}

/// Returns how many groups may pass through the recurrence together before the registers run out.
#[inline(always)]
fn widest<S: Simd>(_: S) -> usize {
    if S::f64s::LEN >= LANES { 4 } else { 1 }
}

/// Adds the eight lanes of each sum, in the order of `legendre::sum`.
#[inline(always)]
fn across<S: Simd>(simd: S, Amplitudes(sums): &Amplitudes) -> Quad {
    let mut halves = [[0.0; 4]; 2];
    for (half, pair) in halves.iter_mut().zip(sums.chunks_exact(2)) {
        let (u, v) = (f64x8::simd_from(simd, pair[0]), f64x8::simd_from(simd, pair[1]));
        let zipped = simd.zip_low_f64x8(u, v) + simd.zip_high_f64x8(u, v);
        let (low, high) = simd.split_f64x8(zipped);
        *half = (low + high).into();
    }
    let [[a, b, c, d], [e, f, g, h]] = halves;
    [a + c, b + d, e + g, f + h]
}

/// Sums over degrees: turns the folded coefficients of one order into amplitudes at the rings of
/// each zone.
pub(super) fn sum_degrees(
    level: Level,
    order: &Order,
    folded: &[Quad],
    mut zones: &[Zones],
    mut rows: &mut [Amplitudes],
) {
    dispatch!(level, simd => {
        while !zones.is_empty() {
            let done = match zones.len().min(widest(simd)) {
                1 => degrees_block::<_, 1>(simd, order, folded, zones, rows),
                2 | 3 => degrees_block::<_, 2>(simd, order, folded, zones, rows),
                _ => degrees_block::<_, 4>(simd, order, folded, zones, rows),
            };
            zones = &zones[done..];
            rows = &mut std::mem::take(&mut rows)[done..];
        }
    });
}

/// Sums over degrees in the first N zones; gives N.
#[inline(always)]
fn degrees_block<S: Simd, const N: usize>(
    simd: S,
    order: &Order,
    folded: &[Quad],
    zones: &[Zones],
    rows: &mut [Amplitudes],
) -> usize {
    let mut squares = [f64x8::splat(simd, 0.0); N];
    for i in 0..N {
        let z = f64x8::simd_from(simd, zones[i].z);
        squares[i] = z * z;
    }
    let terms = order.steps.iter().zip(folded.iter().copied());
    let sums = sum_steps(simd, order.start, squares, terms);
    for i in 0..N {
        let z = f64x8::simd_from(simd, zones[i].z);
        let s = power(simd, f64x8::simd_from(simd, zones[i].s), order.m);
        for q in 0..2 {
            let (even, odd) = (sums[i][q] * s, sums[i][q + 2] * z * s);
            rows[i].0[q] = (even + odd).into();
            rows[i].0[q + 2] = (even - odd).into();
        }
    }
    N
}

/// Sums over rings, and the memory they need.
#[derive(Debug, Default)]
pub(super) struct RingSums {
    lines: Vec<Line>,
    tiles: Vec<Amplitudes>,
    sums: Vec<Quad>,
}

impl RingSums {
    /// Sums the amplitudes of each zone, `held(i)`, times p_k over all rings: one quad a step.
    pub(super) fn of<'a>(
        &mut self,
        level: Level,
        order: &Order,
        zones: &[Zones],
        held: impl Fn(usize) -> &'a Amplitudes,
    ) -> &[Quad] {
        let Self { lines, tiles, sums } = self;
        lines.clear();
        sums.clear();
        dispatch!(level, simd => {
            for (i, zone) in zones.iter().enumerate() {
                lines.push(Line::new(simd, order, zone, held(i)));
            }
            for steps in order.steps.chunks(TILE) {
                tiles.clear();
                tiles.resize(steps.len(), Amplitudes::ZERO);
                let mut lines = lines.as_mut_slice();
                while !lines.is_empty() {
                    let done = match lines.len().min(widest(simd)) {
                        1 => rings_block::<_, 1>(simd, steps, lines, tiles),
                        2 | 3 => rings_block::<_, 2>(simd, steps, lines, tiles),
                        _ => rings_block::<_, 4>(simd, steps, lines, tiles),
                    };
                    lines = &mut lines[done..];
                }
                for tile in tiles.iter() {
                    sums.push(across(simd, tile));
                }
            }
        });
        sums
    }
}

/// The recurrence on its way up at eight pairs of rings, with what they hold.
#[derive(Debug)]
struct Line {
    amplitudes: Amplitudes,
    square: Lanes,
    before: Lanes,
    p: Lanes,
}

impl Line {
    #[inline(always)]
    fn new<S: Simd>(simd: S, order: &Order, zone: &Zones, amplitudes: &Amplitudes) -> Self {
        let z = f64x8::simd_from(simd, zone.z);
        let s = power(simd, f64x8::simd_from(simd, zone.s), order.m);
        let mut scaled = *amplitudes;
        for lanes in &mut scaled.0 {
            *lanes = (f64x8::simd_from(simd, *lanes) * s).into();
        }
        Self {
            square: (z * z).into(),
            before: [0.0; LANES],
            p: [order.start; LANES],
            amplitudes: scaled,
        }
    }
}

/// Adds the first N lines to the sums of some steps, and moves them on; gives N.
#[inline(always)]
fn rings_block<S: Simd, const N: usize>(
    simd: S,
    steps: &[Step],
    lines: &mut [Line],
    sums: &mut [Amplitudes],
) -> usize {
    let zero = f64x8::splat(simd, 0.0);
    let [mut square, mut before, mut p] = [[zero; N]; 3];
    let mut held = [[zero; 4]; N];
    for i in 0..N {
        square[i] = f64x8::simd_from(simd, lines[i].square);
        before[i] = f64x8::simd_from(simd, lines[i].before);
        p[i] = f64x8::simd_from(simd, lines[i].p);
        held[i] = lines[i].amplitudes.0.map(
            #[inline(always)]
            |v| f64x8::simd_from(simd, v),
        );
    }
    for (step, sums) in steps.iter().zip(sums) {
        for (q, sum) in sums.0.iter_mut().enumerate() {
            let mut total = f64x8::simd_from(simd, *sum);
            for i in 0..N {
                total = held[i][q].mul_add(p[i], total);
            }
            *sum = total.into();
        }
        advance(simd, step, square, &mut before, &mut p);
    }
    for i in 0..N {
        lines[i].before = before[i].into();
        lines[i].p = p[i].into();
    }
    N
}
