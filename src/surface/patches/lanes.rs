//! The numbers of one ray or of eight: the beginning of a ray is written once for both, so that
//! both get the same bits.

use std::ops::{Add, BitAnd, Div, Mul, Neg, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8, mask64x8};

/// Rays that begin at once.
pub(super) const LANES: usize = 8;

/// An f64, or one for each of eight rays.
pub(super) trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Whether something holds, or for which rays.
    type Mask: Copy + BitAnd<Output = Self::Mask>;

    /// Returns the same number for every ray.
    fn all(self, x: f64) -> Self;
    fn abs(self) -> Self;
    fn sqrt(self) -> Self;
    /// Returns this number with the sign of another.
    fn signed_as(self, of: Self) -> Self;
    fn less(self, than: Self) -> Self::Mask;
    fn at_most(self, other: Self) -> Self::Mask;
    /// Returns `yes` where the mask holds and `no` elsewhere.
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Returns the smaller number; `self` when the other is not a number.
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        Self::choose(other.less(self), other, self)
    }

    /// Returns the larger number; `self` when the other is not a number.
    #[inline(always)]
    fn most(self, other: Self) -> Self {
        Self::choose(self.less(other), other, self)
    }
}

impl Real for f64 {
    type Mask = bool;

    #[inline(always)]
    fn all(self, x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn signed_as(self, of: Self) -> Self {
        self.copysign(of)
    }

    #[inline(always)]
    fn less(self, than: Self) -> bool {
        self < than
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn choose(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

impl<S: Simd> Real for f64x8<S> {
    type Mask = mask64x8<S>;

    #[inline(always)]
    fn all(self, x: f64) -> Self {
        Self::splat(self.simd, x)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        SimdBase::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        SimdFloat::sqrt(self)
    }

    #[inline(always)]
    fn signed_as(self, of: Self) -> Self {
        self.copysign(of)
    }

    #[inline(always)]
    fn less(self, than: Self) -> Self::Mask {
        self.simd_lt(than)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> Self::Mask {
        self.simd_le(other)
    }

    #[inline(always)]
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self {
        mask.select(yes, no)
    }
}
