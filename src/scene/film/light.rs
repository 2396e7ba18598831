//! Light that is told apart by its way: straight from a source, or reflected before.

use std::ops::{Add, Div, Mul, Sub};

use crate::math::Rgb;

/// Separates what came straight from a source from what was reflected before.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SplitLight {
    /// Straight from lights and emitting surfaces.
    pub direct: Rgb,
    /// After at least one reflection.
    pub indirect: Rgb,
}

impl SplitLight {
    /// What a walk or a path brings whose light is not finite, by a place, a normal or a flux that
    /// is no number: it is counted, and nothing of it is added.
    pub const NON_FINITE: Self = Self { direct: Rgb::BLACK, indirect: Rgb::grey(f64::NAN) };

    /// What roundings leave at most of a sum whose terms are all taken off again, relative to the
    /// sum.
    pub(crate) const ROUNDING: f64 = 1e-12;

    /// Returns both together.
    pub fn total(&self) -> Rgb {
        self.direct + self.indirect
    }

    /// Returns it without what is no more than the roundings of a sum of this size.
    pub(crate) fn above_rounding(self, of: &Self) -> Self {
        let above = |light: Rgb, of: Rgb| {
            let components = [0, 1, 2].map(|i| {
                let (c, rounding) = (light.0[i], Self::ROUNDING * of.0[i]);
                if c.abs() <= rounding { 0.0 } else { c }
            });
            Rgb(components)
        };
        Self { direct: above(self.direct, of.direct), indirect: above(self.indirect, of.indirect) }
    }

    /// Whether all components are finite numbers.
    pub fn is_finite(&self) -> bool {
        self.direct.is_finite() && self.indirect.is_finite()
    }
}

impl Add for SplitLight {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { direct: self.direct + other.direct, indirect: self.indirect + other.indirect }
    }
}

impl Sub for SplitLight {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { direct: self.direct - other.direct, indirect: self.indirect - other.indirect }
    }
}

impl Mul<f64> for SplitLight {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { direct: self.direct * factor, indirect: self.indirect * factor }
    }
}

impl Div<f64> for SplitLight {
    type Output = Self;

    fn div(self, divisor: f64) -> Self {
        Self { direct: self.direct / divisor, indirect: self.indirect / divisor }
    }
}

impl std::iter::Sum for SplitLight {
    fn sum<I: Iterator<Item = Self>>(lights: I) -> Self {
        lights.fold(Self::default(), Self::add)
    }
}
