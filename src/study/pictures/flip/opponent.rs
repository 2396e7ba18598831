//! Colours as FLIP takes them: the linear opponent space YCxCz for filters, and L*a*b* with chroma
//! that fades with the light (Hunt) for differences. White is D65.

use crate::math::Rgb;

/// From linear Rec. 709 to XYZ; white comes to [`WHITE`].
const TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];
const FROM_XYZ: [[f64; 3]; 3] = [
    [3.241_003_275, -1.537_398_934, -0.498_615_861],
    [-0.969_224_334, 1.875_930_071, 0.041_554_224],
    [0.055_639_423, -0.204_011_202, 1.057_148_933],
];
const WHITE: [f64; 3] = [0.950_428_545, 1.0, 1.088_900_371];

/// Returns Y, Cx and Cz of a colour: linear, so that filters may add them up.
pub(super) fn ycxcz(colour: Rgb) -> [f64; 3] {
    let [x, y, z] = relative(colour);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Returns the luminance from 0 to 1 of a Y.
pub(super) fn grey(y: f64) -> f64 {
    (y + 16.0) / 116.0
}

/// Returns L*, a* and b* of a colour in YCxCz that is clamped to what a screen shows, a* and b*
/// adjusted by Hunt's effect: dark colours are less colourful.
pub(super) fn seen([y, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = grey(y);
    let xyz = [(y + cx / 500.0) * WHITE[0], y * WHITE[1], (y - cz / 200.0) * WHITE[2]];
    hunt(Rgb(product(&FROM_XYZ, xyz).map(|c| c.clamp(0.0, 1.0))))
}

/// Returns the HyAB distance of two such colours.
pub(super) fn hyab(one: [f64; 3], other: [f64; 3]) -> f64 {
    let [l, a, b] = std::array::from_fn(|i| one[i] - other[i]);
    l.abs() + f64::hypot(a, b)
}

/// Returns the largest distance that matters, that of green from blue.
pub(super) fn green_from_blue() -> f64 {
    hyab(hunt(Rgb([0.0, 1.0, 0.0])), hunt(Rgb([0.0, 0.0, 1.0])))
}

fn hunt(colour: Rgb) -> [f64; 3] {
    /// Below it the cube root of L*a*b* goes on as a straight line.
    const DELTA: f64 = 6.0 / 29.0;
    let root = |t: f64| {
        if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let [x, y, z] = relative(colour).map(root);
    let l = 116.0 * y - 16.0;
    [l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)]
}

/// Returns XYZ relative to white.
fn relative(colour: Rgb) -> [f64; 3] {
    let xyz = product(&TO_XYZ, colour.0);
    std::array::from_fn(|i| xyz[i] / WHITE[i])
}

fn product(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_has_no_chroma_and_black_no_light() {
        for (grey, lightness) in [(0.0, 0.0), (1.0, 100.0)] {
            let [l, a, b] = seen(ycxcz(Rgb::grey(grey)));
            assert!((l - lightness).abs() <= 1e-4 && a.abs() <= 1e-3 && b.abs() <= 1e-3, "{l}");
        }
    }

    #[test]
    fn what_no_screen_shows_is_clamped() {
        assert_eq!(seen(ycxcz(Rgb::grey(7.0))), seen(ycxcz(Rgb::grey(1.0 + 1e-6))));
    }

    #[test]
    fn green_is_farther_from_blue_than_black_from_white() {
        assert!(green_from_blue() > hyab(hunt(Rgb::BLACK), hunt(Rgb::WHITE)));
    }
}
