//! The exposures at which HDR-FLIP looks at a picture, and how it brings light to a screen: the
//! curve of ACES as Narkowicz fitted it, without its exposure of 0.6.

use crate::math::Rgb;
use crate::math::stats::median;
use crate::scene::{ACES, Tone};

/// What the brightest pixel becomes at the first exposure, and the median at the last.
const TARGET: f64 = 0.85;

/// Lists the logarithms to base 2 of the factors that a picture is exposed by: from where its
/// largest luminance becomes 0.85 to where its median does, in steps of one or a little less, two
/// at least. Of a picture of which half is black the median of the rest counts. Empty for a black
/// picture.
pub(super) fn exposures(picture: &[Rgb]) -> Vec<f64> {
    let luminances = || picture.iter().map(|p| p.luminance());
    let lit = || median(luminances().filter(|y| *y > 0.0));
    let largest = luminances().fold(0.0, f64::max);
    let Some(middle) = median(luminances()).filter(|y| *y > 0.0).or_else(lit) else {
        return Vec::new();
    };
    let [start, stop] = [largest, middle].map(|y| (reaches_target() / y).log2());
    let count = (stop - start).ceil().max(2.0);
    let step = (stop - start) / (count - 1.0);
    (0..count as usize).map(|i| start + step * i as f64).collect()
}

/// Returns the colour that a screen shows, each component from 0 to 1.
pub(super) fn shown(colour: Rgb, exposure: f64) -> Rgb {
    let factor = exposure.exp2();
    Rgb(colour.0.map(|value| Tone::Filmic.shown(factor * value)))
}

/// Returns the light that the curve brings to the target.
fn reaches_target() -> f64 {
    let [a, b, c, d, e] = ACES;
    let [a, b, c] = [a - TARGET * c, b - TARGET * d, -TARGET * e];
    let middle = -0.5 * b / a;
    middle + (middle * middle - c / a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_pictures_have_no_exposure() {
        assert!(exposures(&[Rgb::BLACK; 4]).is_empty() && exposures(&[]).is_empty());
    }

    #[test]
    fn median_and_largest_are_brought_to_the_target() {
        let picture = [1.0, 3.0, 100.0].map(Rgb::grey);
        let found = exposures(&picture);
        // log2(100 / 3) is 5.06.
        assert_eq!(found.len(), 6);
        for (grey, exposure) in [(100.0, found[0]), (3.0, found[5])] {
            assert!((shown(Rgb::grey(grey), exposure).0[0] - TARGET).abs() <= 1e-12);
        }
    }

    #[test]
    fn half_a_black_picture_is_exposed_by_the_rest() {
        let found = exposures(&[0.0, 0.0, 0.0, 2.0].map(Rgb::grey));
        assert_eq!(found, exposures(&[2.0].map(Rgb::grey)));
        assert!(found.len() == 2 && found[0] == found[1]);
    }

    #[test]
    fn any_light_is_shown() {
        for light in [-1e30, -1.0, 0.0, 1e-300, 1e200, f64::MAX] {
            assert!((0.0..=1.0).contains(&shown(Rgb::grey(light), 1.0).0[0]), "{light}");
        }
    }
}
