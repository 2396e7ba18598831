//! The joint test held to noise of known size. Seeds are fixed; the false-alarm rates are stated.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::math::Rgb;
use crate::math::stats::Estimate;

const SIZE: [usize; 2] = [40, 30];
const REPLICATES: usize = 32;

/// Makes a picture of replicates: what `mean` says, with noise of a tenth of it in each.
fn noisy(seed: u64, mean: impl Fn(usize, usize) -> f64) -> Picture {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let (mut pixels, mut errors) = (Vec::new(), Vec::new());
    for i in 0..SIZE[0] * SIZE[1] {
        let mean = mean(i % SIZE[0], i / SIZE[0]);
        let replicates: Vec<f64> = (0..REPLICATES)
            .map(|_| {
                // The sum of twelve is nearly normal, of variance one.
                let sum: f64 = (0..12).map(|_| random.random::<f64>()).sum();
                mean * (1.0 + 0.1 * (sum - 6.0))
            })
            .collect();
        let estimate = Estimate::of_replicates(&replicates);
        pixels.push(Rgb::grey(estimate.mean));
        errors.push(estimate.standard_error);
    }
    Picture { size: SIZE, part: None, pixels, errors, replicates: Some(REPLICATES) }
}

fn found(a: &Picture, b: &Picture) -> JointTest {
    joint_test(a, b).expect("both have errors")
}

/// 200 pairs with a rate of 1e-3: more than three alarms come by chance once in a million times.
#[test]
fn noise_alone_is_no_difference() {
    let ramp = |x: usize, y: usize| 1.0 + x as f64 + 0.5 * y as f64;
    let alarms = (0..200).filter(|k| {
        let test = found(&noisy(2 * k, ramp), &noisy(2 * k + 1, ramp));
        // 60 of 1200 pixels in the mean, 7.5 by chance.
        assert!((test.beyond_95 - 0.05).abs() <= 0.03, "{}", test.beyond_95);
        test.differ()
    });
    assert!(alarms.count() <= 3);
}

#[test]
fn one_wrong_pixel_is_found_and_so_is_a_small_wide_difference() {
    let even = noisy(1, |_, _| 2.0);
    let spot = found(&noisy(2, |x, y| if (x, y) == (7, 5) { 4.0 } else { 2.0 }), &even);
    assert!(spot.differ() && spot.levels[0].at == [7, 5] && spot.levels[0].beyond == 1);
    assert!(spot.levels[0].z > spot.levels[0].limit);
    // Half of a standard error at each pixel: the whole picture alone can tell.
    let wide = found(&noisy(3, |_, _| 1.98), &even);
    assert!(wide.differ() && wide.levels[0].beyond == 0);
    assert_eq!(wide.levels.iter().map(|level| level.side).collect::<Vec<_>>(), [1, 4, 16, 40]);
    let whole = wide.levels.last().expect("a level");
    assert!(whole.z < -whole.limit && whole.blocks == 1 && whole.at == [0, 0]);
}

#[test]
fn limits_are_those_of_student() {
    let [a, b] = [1, 2].map(|seed| noisy(seed, |_, _| 1.0));
    for level in found(&a, &b).levels {
        let expected = student_t(FALSE_ALARMS / 4.0 / level.blocks as f64, REPLICATES - 1);
        assert_eq!(level.limit, expected);
    }
    let unsaid = |picture: &Picture| Picture { replicates: None, ..picture.clone() };
    // That of the normal distribution, scipy.stats.norm.isf(1e-3 / 8).
    let limit = found(&unsaid(&a), &unsaid(&b)).levels[3].limit;
    assert!((limit - 3.662_26).abs() <= 3e-3, "{limit}");
}

#[test]
fn pixels_without_an_error_are_told_apart() {
    let mut a = noisy(1, |_, _| 1.0);
    let mut b = noisy(2, |_, _| 1.0);
    (a.errors[0], b.errors[1], b.errors[2]) = (f64::NAN, f64::INFINITY, -1.0);
    a.pixels[..3].copy_from_slice(&[100.0; 3].map(Rgb::grey));
    for i in 3..5 {
        (a.errors[i], b.errors[i]) = (0.0, 0.0);
        (a.pixels[i], b.pixels[i]) = (Rgb::grey(7.0), Rgb::grey(7.0 * (1.0 + 1e-7)));
    }
    let test = found(&a, &b);
    assert_eq!((test.unknown, test.exact, test.tested, test.differ()), (3, 2, 1197, false));
    assert!(deviations(&a, &b)[0].is_nan() && deviations(&a, &b)[3] == 0.0);
    b.pixels[4] = Rgb::grey(7.001);
    let test = found(&a, &b);
    assert!(test.differ() && test.levels[0].z.is_infinite() && test.levels[0].at == [4, 0]);
}

#[test]
fn nothing_is_tested_without_errors() {
    let a = noisy(1, |_, _| 1.0);
    let none = Picture { errors: Vec::new(), ..a.clone() };
    let unknown = Picture { errors: vec![f64::INFINITY; a.pixels.len()], ..a.clone() };
    for b in [none, unknown] {
        assert!(joint_test(&a, &b).is_none() && joint_test(&b, &a).is_none());
    }
}

/// Which comes first only turns signs.
#[test]
fn order_does_not_count() {
    let (a, b) = (noisy(1, |x, _| 1.0 + x as f64), noisy(2, |x, _| 1.0 + x as f64));
    let (one, other) = (found(&a, &b), found(&b, &a));
    let turned = other.levels.iter().map(|level| JointLevel { z: -level.z, ..*level });
    assert!(turned.eq(one.levels));
    assert!(!found(&a, &a).differ());
}
