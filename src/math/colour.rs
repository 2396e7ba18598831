//! Linear Rec. 709 triples that carry photometric units.

use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Sub};

/// Holds red, green and blue of linear Rec. 709; its [luminance](Rgb::luminance) carries the
/// photometric unit (lm, lx, cd/m2) and a grey value has three equal components.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rgb(pub [f64; 3]);

impl Rgb {
    /// Nothing: black.
    pub const BLACK: Self = Self([0.0; 3]);
    /// One in every component.
    pub const WHITE: Self = Self([1.0; 3]);

    /// How red and blue weigh in the luminance; green has the rest.
    pub(crate) const RED_AND_BLUE: [f64; 2] = [0.2126, 0.0722];

    /// Makes a grey value.
    pub const fn grey(value: f64) -> Self {
        Self([value; 3])
    }

    /// Weighs the components to the photometric value (Rec. 709: 0.2126, 0.7152, 0.0722).
    ///
    /// Written as a correction of green, so that a grey triple gives back its own value to the last
    /// bit.
    pub fn luminance(self) -> f64 {
        let [r, g, b] = self.0;
        let [red, blue] = Self::RED_AND_BLUE;
        g + red * (r - g) + blue * (b - g)
    }

    /// Returns the largest component.
    pub fn max_component(self) -> f64 {
        self.0.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the smallest component.
    pub fn min_component(self) -> f64 {
        self.0.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Whether all components are zero.
    pub fn is_black(self) -> bool {
        self.0 == [0.0; 3]
    }

    /// Whether all components are finite numbers.
    pub fn is_finite(self) -> bool {
        self.0.into_iter().all(f64::is_finite)
    }

    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

impl Add for Rgb {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Rgb {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl AddAssign for Rgb {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Mul for Rgb {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl MulAssign for Rgb {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl Mul<f64> for Rgb {
    type Output = Self;
    fn mul(self, k: f64) -> Self {
        Self(self.0.map(|c| c * k))
    }
}

impl Div<f64> for Rgb {
    type Output = Self;
    fn div(self, k: f64) -> Self {
        Self(self.0.map(|c| c / k))
    }
}

impl std::iter::Sum for Rgb {
    fn sum<I: Iterator<Item = Self>>(values: I) -> Self {
        values.fold(Self::BLACK, Self::add)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_keeps_its_value_to_the_bit() {
        for v in [0.1, 1.0 / 3.0, 1234.567] {
            assert_eq!(Rgb::grey(v).luminance().to_bits(), v.to_bits());
        }
    }
}
