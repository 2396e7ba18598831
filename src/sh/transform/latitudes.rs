//! The rings of a grid in mirrored pairs, and the sums along theta over them; the inner loops are
//! in `kernels`.

use std::f64::consts::PI;

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f64x8};

use super::kernels::{self, Amplitudes, Order, RingSums, Zones};
use super::rings::{Rings, RowPair, Spectra};
use crate::sh::legendre::LANES;
use crate::sh::two_step::{Quad, TwoStep};
use crate::sh::{Coefficients, Grid};

/// Memory that the tasks of one thread use again and again.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    folded: Vec<Quad>,
    sums: RingSums,
}

/// What contributes less than this share of the largest possible value to a ring is left out: Q_l^m
/// is that small on rings near the poles.
const NEGLIGIBLE: f64 = 1e-22;

/// The rings of a grid in mirrored pairs, the poles first, in groups of eight.
#[derive(Debug)]
pub(super) struct Latitudes {
    zones: Vec<Zones>,
    /// Per group: its rings, lane after lane.
    pairs: Vec<Vec<Pair>>,
    /// Per order: the first group whose Legendre functions are not negligible.
    first: Vec<usize>,
    level: Level,
}

/// Numbers of two rings at theta and pi - theta; a ring without a mirror image stands alone.
#[derive(Debug, Clone, Copy)]
struct Pair {
    north: usize,
    south: Option<usize>,
}

impl Latitudes {
    /// Pairs the rings of a grid for sums up to degree `lmax`.
    pub(super) fn new(grid: &Grid, lmax: usize) -> Self {
        let rings = grid.rings();
        let mut pairs = mirrored_pairs(rings);
        pairs.sort_by(|a, b| rings[a.north].1.total_cmp(&rings[b.north].1));
        let lanes = |pairs: &[Pair], entry: fn((f64, f64)) -> f64| {
            std::array::from_fn(|i| pairs.get(i).map_or(0.0, |p| entry(rings[p.north])))
        };
        let groups = || pairs.chunks(LANES);
        let zones: Vec<Zones> =
            groups().map(|g| Zones { z: lanes(g, |r| r.0), s: lanes(g, |r| r.1) }).collect();
        let widest: Vec<f64> =
            zones.iter().map(|zone| zone.s.iter().copied().fold(0.0, f64::max)).collect();
        let first = largest_logarithms(lmax).enumerate().map(|(m, largest)| {
            let counts = |s: &f64| largest + m as f64 * s.ln() >= NEGLIGIBLE.ln() || m == 0;
            widest.iter().position(counts).unwrap_or(zones.len())
        });
        Self {
            first: first.collect(),
            pairs: groups().map(<[Pair]>::to_vec).collect(),
            zones,
            level: Level::new(),
        }
    }

    /// Returns the number of groups.
    pub(super) fn groups(&self) -> usize {
        self.zones.len()
    }

    /// Hands the rows of a grid to the groups they belong to.
    pub(super) fn deal<'a>(
        &self,
        rows: impl Iterator<Item = &'a mut [f64]>,
    ) -> Vec<(usize, Vec<RowPair<'a>>)> {
        let mut rows: Vec<Option<&mut [f64]>> = rows.map(Some).collect();
        let mut row = |i: usize| rows[i].take().unwrap_or_default();
        let mut deal = |pairs: &Vec<Pair>| -> Vec<RowPair<'a>> {
            pairs
                .iter()
                .map(|p| RowPair { north: row(p.north), south: p.south.map(&mut row) })
                .collect()
        };
        self.pairs.iter().map(&mut deal).enumerate().collect()
    }

    /// Sums over degrees: fills the amplitudes of order `m` on all rings, one entry a group;
    /// entries of negligible groups stay as they are.
    pub(super) fn sum_degrees(
        &self,
        recurrence: &TwoStep,
        coefficients: &Coefficients,
        m: usize,
        Scratch { folded, .. }: &mut Scratch,
        row: &mut [Amplitudes],
    ) {
        recurrence.fold(m, coefficients.column(m), folded);
        let order = Order { m, start: recurrence.start(m), steps: recurrence.steps(m) };
        let first = self.first[m];
        kernels::sum_degrees(self.level, &order, folded, &self.zones[first..], &mut row[first..]);
    }

    /// Turns samples into amplitudes of even and odd parts, one entry an order; `ring` gives the
    /// samples and the weight of a ring.
    pub(super) fn fold_rings<'a>(
        &self,
        group: usize,
        ring: impl Fn(usize) -> (&'a [f64], f64),
        rings: &Rings,
        spectra: &mut Spectra,
        amplitudes: &mut [Amplitudes],
    ) {
        let pairs = &self.pairs[group];
        let rows: Vec<_> =
            pairs.iter().map(|p| (ring(p.north).0, p.south.map(|i| ring(i).0))).collect();
        let mut weights = [0.0; LANES];
        for (weight, pair) in weights.iter_mut().zip(pairs) {
            *weight = ring(pair.north).1;
        }
        rings.analyse(&rows, spectra);
        dispatch!(self.level, simd => {
            let even = f64x8::simd_from(simd, weights);
            let odd = even * f64x8::simd_from(simd, self.zones[group].z);
            for (m, entry) in amplitudes.iter_mut().enumerate() {
                let [na, nb, sa, sb] = spectra.harmonics(simd, m);
                entry.0 = [
                    (even * (na + sa)).into(),
                    (even * (nb + sb)).into(),
                    (odd * (na - sa)).into(),
                    (odd * (nb - sb)).into(),
                ];
            }
        });
    }

    /// Sums over rings: `amplitudes` holds an entry for each group and order, group after group;
    /// `moments` receives A_lm and B_lm for l = m, m + 1, ...
    pub(super) fn sum_rings(
        &self,
        recurrence: &TwoStep,
        amplitudes: &[Amplitudes],
        m: usize,
        Scratch { sums, .. }: &mut Scratch,
        moments: &mut [(f64, f64)],
    ) {
        let order = Order { m, start: recurrence.start(m), steps: recurrence.steps(m) };
        let (first, orders) = (self.first[m], recurrence.lmax() + 1);
        let held = |i: usize| &amplitudes[(first + i) * orders + m];
        let sums = sums.of(self.level, &order, &self.zones[first..], held);
        let sphere = if m == 0 { 4.0 * PI } else { 2.0 * PI };
        recurrence.unfold(m, sums, |l, a, b| {
            let norm = (2 * l + 1) as f64 / sphere;
            moments[l - m] = (norm * a, norm * b);
        });
    }
}

/// Finds for each ring its mirror image.
fn mirrored_pairs(rings: &[(f64, f64)]) -> Vec<Pair> {
    let mut order: Vec<usize> = (0..rings.len()).collect();
    order.sort_by(|&a, &b| rings[b].0.total_cmp(&rings[a].0));
    let mut pairs = Vec::new();
    let mut left = order.as_slice();
    while let [north, rest @ ..] = left {
        match rest {
            [middle @ .., south] if rings[*south].0 == -rings[*north].0 => {
                pairs.push(Pair { north: *north, south: Some(*south) });
                left = middle;
            }
            // The one nearer to its pole has no mirror image.
            [middle @ .., south] if -rings[*south].0 > rings[*north].0 => {
                pairs.push(Pair { north: *south, south: None });
                left = &left[..=middle.len()];
            }
            _ => {
                pairs.push(Pair { north: *north, south: None });
                left = rest;
            }
        }
    }
    pairs
}

/// Returns for each order m the logarithm of the largest |Q_l^m / sin^m|: that of l = lmax at the
/// pole, sqrt((l+m)!/(l-m)!) / (2^m m!).
fn largest_logarithms(lmax: usize) -> impl Iterator<Item = f64> {
    let step = move |logarithm: &mut f64, m: usize| {
        if m > 0 {
            let product = ((lmax + m) * (lmax + 1 - m)) as f64;
            *logarithm += 0.5 * product.ln() - (2.0 * m as f64).ln();
        }
        Some(*logarithm)
    };
    (0..=lmax).scan(0.0, step)
}
