//! Light that is told apart by its way: straight from a source, or reflected before.

use crate::math::Rgb;

/// Separates what came straight from a source from what was reflected before.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Light {
    /// Straight from lights and emitting surfaces.
    pub direct: Rgb,
    /// After at least one reflection.
    pub indirect: Rgb,
}

impl Light {
    /// What a walk or a path brings that is spoilt by a place, a normal or a flux that is no number: it is counted, and nothing of it is added.
    pub const SPOILT: Self = Self { direct: Rgb::BLACK, indirect: Rgb::grey(f64::NAN) };

    /// Gives both together.
    pub fn total(&self) -> Rgb {
        self.direct + self.indirect
    }

    /// Tells whether all components are finite numbers.
    pub fn is_finite(&self) -> bool {
        self.direct.is_finite() && self.indirect.is_finite()
    }
}

impl std::iter::Sum for Light {
    fn sum<I: Iterator<Item = Self>>(lights: I) -> Self {
        lights.fold(Self::default(), |sum, light| Self {
            direct: sum.direct + light.direct,
            indirect: sum.indirect + light.indirect,
        })
    }
}

impl std::ops::Div<f64> for Light {
    type Output = Self;

    fn div(self, divisor: f64) -> Self {
        Self { direct: self.direct / divisor, indirect: self.indirect / divisor }
    }
}
