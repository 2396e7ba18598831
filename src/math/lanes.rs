//! Vectors of which each component is eight numbers side by side, for the lanes of the processor.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};

/// How many numbers stand side by side.
pub(crate) const LANES: usize = 8;

/// Returns the same vector to every lane.
#[inline(always)]
pub(crate) fn splat<S: Simd>(simd: S, vector: impl Into<[f64; 3]>) -> [f64x8<S>; 3] {
    let [x, y, z] = vector.into();
    [f64x8::splat(simd, x), f64x8::splat(simd, y), f64x8::splat(simd, z)]
}

/// Loads a vector for each lane, component by component.
#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, rows: &[[f64; LANES]; 3]) -> [f64x8<S>; 3] {
    [
        f64x8::from_slice(simd, &rows[0]),
        f64x8::from_slice(simd, &rows[1]),
        f64x8::from_slice(simd, &rows[2]),
    ]
}
