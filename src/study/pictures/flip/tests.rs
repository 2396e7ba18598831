//! FLIP held to the program of its authors, and to what must be.

use super::*;

/// The size of the pictures, and how LDR pictures are exposed.
const SIZE: [usize; 2] = [16, 12];
const EXPOSURE: f64 = 0.1;

/// Makes a reference with a bright corner, and a test of another texture and, to the left, of other
/// colours; as single precision has them.
fn pictures(exposure: f64) -> [Vec<Rgb>; 2] {
    let single = |colour: [f64; 3]| Rgb(colour.map(|v| f64::from(v as f32 * exposure as f32)));
    let both = (0..SIZE[0] * SIZE[1]).map(|i| {
        let [x, y] = [i % SIZE[0], i / SIZE[0]].map(|n| n as f64);
        let (r, g) = (2.0 + (0.7 * x + 0.3 * y).sin(), 1.5 + (0.4 * x - 0.9 * y).cos());
        let bright = if x > 10.0 && y < 4.0 { 8.0 } else { 1.0 };
        let colour = [r, g, 1.0 + 0.5 * (0.2 * x * y).sin()].map(|v| v * bright);
        let [r, g, b] = colour.map(|v| v * (1.0 + 0.2 * (1.3 * x + 2.1 * y).sin()));
        (single(colour), single(if x < 5.0 { [g, r, b] } else { [r, g, b] }))
    });
    let (reference, test) = both.unzip();
    [reference, test]
}

/// The values are those of flip-evaluator 1.7 (PyPI, NVIDIA, BSD-3-Clause), `evaluate(reference,
/// test, "HDR" or "LDR", False, False)`, whose arithmetic is in single precision: its pixels are
/// within 2e-5 of ours, its means within 1e-7.
#[test]
fn values_are_those_of_the_authors() {
    for (ldr, pixels_per_degree, mean, max, corner, inner, bright) in [
        (false, PIXELS_PER_DEGREE, 0.221_723_0, 0.962_585_7, 0.252_818, 0.067_029, 0.028_766),
        (true, PIXELS_PER_DEGREE, 0.169_326_6, 0.802_556_6, 0.201_810, 0.036_192, 0.060_570),
        (false, 20.0, 0.334_597_3, 0.972_302_1, 0.405_671, 0.208_137, 0.185_287),
        (true, 20.0, 0.272_299_6, 0.956_882_1, 0.348_865, 0.159_658, 0.228_064),
    ] {
        let [reference, test] = pictures(if ldr { EXPOSURE } else { 1.0 });
        let of = if ldr { flip_ldr } else { flip };
        let found = of(&reference, &test, SIZE, pixels_per_degree).expect("pictures");
        assert!((found.mean - mean).abs() <= 5e-7, "{} is not {mean}", found.mean);
        let pixels = [found.max, found.map[0], found.map[5 * 16 + 7], found.map[2 * 16 + 12]];
        for (pixel, expected) in pixels.into_iter().zip([max, corner, inner, bright]) {
            assert!((pixel - expected).abs() <= 2e-5, "{pixel} is not {expected}");
        }
    }
}

#[test]
fn equal_and_black_pictures_look_the_same() {
    let [reference, _] = pictures(1.0);
    for picture in [reference, vec![Rgb::BLACK; 192]] {
        let found = flip(&picture, &picture, SIZE, PIXELS_PER_DEGREE).expect("a picture");
        assert_eq!((found.mean, found.percentile_95, found.max), (0.0, 0.0, 0.0));
    }
}

#[test]
fn the_largest_difference_is_black_from_white_or_more() {
    let (black, white) = ([Rgb::BLACK; 192], [Rgb::WHITE; 192]);
    for of in [flip, flip_ldr] {
        let found = of(&black, &white, SIZE, PIXELS_PER_DEGREE).expect("pictures");
        assert!(found.mean > 0.9 && found.max <= 1.0, "{}", found.mean);
    }
}

/// All but the exposures of a picture is the same in any unit.
#[test]
fn unit_of_the_light_does_not_count() {
    let [[a, b], [c, d]] = [1.0, 1024.0].map(pictures);
    let [one, other] =
        [(a, b), (c, d)].map(|(r, t)| flip(&r, &t, SIZE, PIXELS_PER_DEGREE).expect("pictures"));
    assert!((one.mean - other.mean).abs() <= 1e-9, "{} {}", one.mean, other.mean);
}

/// Pictures that are laid on their side, and looked at in a mirror, look as different as before.
#[test]
fn turned_and_mirrored_pictures_have_the_same_errors() {
    let [width, height] = SIZE;
    let [reference, test] = pictures(1.0);
    let turned = |x: usize, y: usize| x * height + (height - 1 - y);
    let turn = |picture: &[Rgb]| {
        let mut all = vec![Rgb::BLACK; picture.len()];
        (0..picture.len()).for_each(|i| all[turned(i % width, i / width)] = picture[i]);
        all
    };
    let upright = flip(&reference, &test, SIZE, PIXELS_PER_DEGREE).expect("pictures");
    let side = flip(&turn(&reference), &turn(&test), [height, width], PIXELS_PER_DEGREE);
    let side = side.expect("pictures").map;
    for (i, error) in upright.map.iter().enumerate() {
        assert!((side[turned(i % width, i / width)] - error).abs() <= 1e-9, "{i}");
    }
}

#[test]
fn misshapen_and_non_finite_pictures_are_refused() {
    let [reference, test] = pictures(1.0);
    let refused = |test: &[Rgb], size, pixels_per_degree| {
        flip(&reference, test, size, pixels_per_degree).expect_err("refused").to_string()
    };
    assert!(refused(&test, [12, 12], 67.0).contains("no picture of 12 x 12"));
    assert!(refused(&test[1..], SIZE, 67.0).contains("no picture of 16 x 12"));
    assert!(flip(&[], &[], [0, 0], 67.0).is_err());
    let mut holed = test.clone();
    holed[17].0[1] = f64::NAN;
    assert!(refused(&holed, SIZE, 67.0).contains("pixel (1, 1) is not finite"));
    for wrong in [0.0, -67.0, f64::NAN, f64::INFINITY] {
        assert!(refused(&test, SIZE, wrong).contains("pixels per degree"), "{wrong}");
    }
}
