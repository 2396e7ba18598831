//! Units of length.

use super::choice::choice;

/// The unit of a file's lengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unit {
    /// Kilometres.
    Kilometre,
    /// Metres.
    #[default]
    Metre,
    /// Centimetres.
    Centimetre,
    /// Millimetres.
    Millimetre,
    /// Micrometres.
    Micrometre,
    /// Inches.
    Inch,
}

choice!(Unit, "unit":
    Kilometre = "km" "",
    Metre = "m" "",
    Centimetre = "cm" "",
    Millimetre = "mm" "",
    Micrometre = "um" "",
    Inch = "in" "",
);

impl Unit {
    /// Returns the length of the unit, metres.
    pub const fn metres(self) -> f64 {
        match self {
            Self::Kilometre => 1000.0,
            Self::Metre => 1.0,
            Self::Centimetre => 0.01,
            Self::Millimetre => 0.001,
            Self::Micrometre => 1e-6,
            Self::Inch => 0.0254,
        }
    }
}
