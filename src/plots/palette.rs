//! Colours that stand for values.

use colorous::Gradient;

use crate::math::choice::choice;

/// Names a row of colours from low to high; all but turbo, grey and balance get lighter in even
/// steps and are read by people of all kinds of colour vision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Palette {
    /// Violet, green, yellow.
    #[default]
    Viridis,
    /// Black, red, yellow.
    Inferno,
    /// Black, violet, cream.
    Magma,
    /// Blue, pink, yellow.
    Plasma,
    /// Blue, grey, yellow: the same to the colour-blind.
    Cividis,
    /// The rainbow without its false edges: what lighting engineers are used to, but its middle is
    /// the lightest.
    Turbo,
    /// Black to white.
    Grey,
    /// Blue, white, red: for differences, on a scale whose middle is 0.
    Balance,
}

choice!(Palette, "palette":
    Viridis = "viridis" "",
    Inferno = "inferno" "",
    Magma = "magma" "",
    Plasma = "plasma" "",
    Cividis = "cividis" "",
    Turbo = "turbo" "",
    Grey = "grey" "",
    Balance = "balance" "",
);

impl Palette {
    /// Returns the sRGB colour at a place from 0, low, to 1, high; places outside take that of the
    /// end.
    pub fn colour(self, place: f64) -> [u8; 3] {
        let place = if place.is_nan() { 0.0 } else { place.clamp(0.0, 1.0) };
        // That of colorous begins with red.
        let place = if self == Self::Balance { 1.0 - place } else { place };
        self.gradient().map_or([(255.0 * place).round() as u8; 3], |gradient| {
            let colour = gradient.eval_continuous(place);
            [colour.r, colour.g, colour.b]
        })
    }

    const fn gradient(self) -> Option<Gradient> {
        match self {
            Self::Viridis => Some(colorous::VIRIDIS),
            Self::Inferno => Some(colorous::INFERNO),
            Self::Magma => Some(colorous::MAGMA),
            Self::Plasma => Some(colorous::PLASMA),
            Self::Cividis => Some(colorous::CIVIDIS),
            Self::Turbo => Some(colorous::TURBO),
            Self::Balance => Some(colorous::RED_BLUE),
            Self::Grey => None,
        }
    }
}

/// Whether black is easier to read on a colour than white: its relative luminance, by the sRGB
/// transfer function taken as a square, is above that of middle grey.
pub(super) fn is_light(colour: [u8; 3]) -> bool {
    let [r, g, b] = colour.map(|c| (f64::from(c) / 255.0).powi(2));
    0.2126 * r + 0.7152 * g + 0.0722 * b > 0.2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back_and_others_are_refused() {
        for palette in Palette::ALL {
            assert_eq!(palette.name().parse::<Palette>().expect("its name"), palette);
        }
        let message = "jet".parse::<Palette>().expect_err("refused").to_string();
        assert!(message.contains("viridis, inferno"), "{message}");
    }

    #[test]
    fn places_outside_take_the_colour_of_the_end() {
        for palette in Palette::ALL {
            assert_eq!(palette.colour(-1.0), palette.colour(0.0));
            assert_eq!(palette.colour(9.0), palette.colour(1.0));
            assert_eq!(palette.colour(f64::NAN), palette.colour(0.0));
        }
        assert_eq!(Palette::Viridis.colour(0.0), [0x44, 0x01, 0x54]);
        assert!(is_light([255, 255, 0]) && !is_light([0x44, 0x01, 0x54]));
    }

    #[test]
    fn differences_are_blue_below_and_red_above_white() {
        let [low, middle, high] = [0.0, 0.5, 1.0].map(|place| Palette::Balance.colour(place));
        assert!(low[2] > low[0] && high[0] > high[2] && middle.iter().all(|c| *c >= 235));
    }

    #[test]
    fn even_palettes_get_lighter() {
        let lightness = |p: Palette, k: usize| {
            let [r, g, b] = p.colour(k as f64 / 32.0).map(|c| (f64::from(c) / 255.0).powf(2.2));
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let uneven = [Palette::Turbo, Palette::Balance];
        for palette in Palette::ALL.into_iter().filter(|p| !uneven.contains(p)) {
            let rises = (0..32).all(|k| lightness(palette, k) < lightness(palette, k + 1));
            assert!(rises, "{palette}");
        }
    }
}
