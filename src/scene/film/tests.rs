//! The film: means, errors, strides.

use super::*;
use crate::math::hash;

fn grey(v: f64) -> SplitLight {
    SplitLight { direct: Rgb::grey(0.25 * v), indirect: Rgb::grey(0.75 * v) }
}

fn film(passes: &[f64]) -> Film {
    let mut film = Film::new([1, 1], 4).expect("small");
    for &v in passes {
        film.add_pass(&[grey(v)]);
    }
    film
}

#[test]
fn empty_film_is_black_with_unknown_error() {
    let film = film(&[]);
    assert_eq!(film.image(), vec![Rgb::BLACK]);
    assert!(film.standard_errors()[0].is_infinite());
    assert_eq!(film.median_relative_error(), None);
}

#[test]
fn films_beyond_memory_are_refused() {
    let error = Film::new([60_000, 60_000], 32).expect_err("too large").to_string();
    assert!(error.contains("60000 x 60000 pixels is beyond what a film holds"), "{error}");
    let error = Film::new([8000, 8000], 1 << 20).expect_err("too large").to_string();
    assert!(error.contains("8000 x 8000") && error.contains("TB"), "{error}");
}

#[test]
fn error_is_that_of_the_replicate_means() {
    // Replicates 1, 2, 3, 4 twice: means 1..4, s.e. sqrt(5/3 / 4).
    let film = film(&[1.0, 2.0, 3.0, 4.0, 1.0, 2.0, 3.0, 4.0]);
    assert!((film.image()[0].luminance() - 2.5).abs() <= 1e-15);
    assert!((film.standard_errors()[0] - (5.0_f64 / 12.0).sqrt()).abs() <= 1e-7);
    let (mean, error) = film.mean();
    assert!((mean - 2.5).abs() <= 1e-7 && (error - (5.0_f64 / 12.0).sqrt()).abs() <= 1e-7);
}

#[test]
fn non_finite_samples_are_counted_not_averaged() {
    let film = film(&[1.0, f64::NAN, 1.0, f64::INFINITY]);
    assert_eq!((film.non_finite(), film.image()[0].luminance()), (2, 1.0));
}

/// Pixels in the middle of the four kinds.
const KINDS: [usize; 4] = [1, 5, 9, 13];

/// Fills a film of 16 pixels by stages with samples of mean 1, four pixels of each kind: steady,
/// noisy, very noisy, and rarely more than nothing.
fn adaptive(seed: u64, rounds: usize, target: Option<f64>) -> Film {
    let mut film = Film::new([16, 1], 32).expect("small");
    for pass in 0..32 * rounds {
        if film.is_between_stages() {
            film.plan(target);
        }
        let samples: [SplitLight; 16] = std::array::from_fn(|pixel| {
            let u = (hash([seed, pixel as u64, pass as u64]) >> 11) as f64 / (1_u64 << 53) as f64;
            grey(match pixel / 4 {
                0 => 1.0 + 0.02 * (u - 0.5),
                1 => 2.0 * u,
                2 => 16.0 * (1.0 - u).powi(15),
                _ if u < 1.0 / 64.0 => 64.0,
                _ => 0.0,
            })
        });
        film.add_pass(&samples);
    }
    film
}

#[test]
fn pixels_that_rest_stay_unbiased_and_their_errors_right() {
    // 600 seeds; each of 4 means is judged at 4 standard errors: false alarms in 3e-4 of all
    // choices of seeds.
    let (runs, rounds) = (600, 16);
    let films: Vec<Film> = (0..runs).map(|seed| adaptive(seed, rounds, Some(0.1))).collect();
    for pixel in KINDS {
        let values: Vec<f64> = films.iter().map(|f| f.pixel(pixel).luminance()).collect();
        let mean = values.iter().sum::<f64>() / runs as f64;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (runs - 1) as f64;
        let error = (variance / runs as f64).sqrt();
        assert!((mean - 1.0).abs() <= 4.0 * error, "{pixel}: {mean} +- {error}");
        let claimed = films.iter().map(|f| f.standard_error(pixel).powi(2)).sum::<f64>();
        let ratio = claimed / runs as f64 / variance;
        assert!(
            (0.7..=1.4).contains(&ratio),
            "{pixel}: claimed variance is {ratio} times the true"
        );
    }
    let taken: u64 = films.iter().map(Film::samples).sum();
    let all = runs * 32 * rounds as u64 * 16;
    assert!(taken * 10 < all * 9, "{taken} samples of {all}: nothing rests");
}

#[test]
fn samples_in_proportion_to_what_was_seen_would_be_biased_and_stages_are_not() {
    // The rare pixel after two rounds and as many more only where something was seen: the mean by
    // counting samples is low there.
    let (runs, mut counted, mut staged) = (4000, 0.0, 0.0);
    for seed in 0..runs {
        let of = |rounds: std::ops::Range<u64>| {
            let hit = |pass| (hash([seed, pass]) >> 11) as f64 / (1_u64 << 53) as f64 <= 1.0 / 64.0;
            rounds.map(|pass| if hit(pass) { 64.0 } else { 0.0 }).sum::<f64>()
        };
        let first = of(0..32);
        let more = if first > 0.0 { 1024 } else { 8 };
        let second = of(32..32 + more);
        counted += (first + second) / (32 + more) as f64 / runs as f64;
        staged += 0.5 * (first / 32.0 + second / more as f64) / runs as f64;
    }
    assert!(counted < 0.8, "counting: {counted}");
    assert!((staged - 1.0).abs() <= 0.15, "stages: {staged}");
}

#[test]
fn film_without_target_takes_every_sample() {
    let film = adaptive(1, 8, None);
    assert_eq!((film.samples(), film.scramble()), (16 * 32 * 8, 0));
    assert!((0..16).all(|pixel| film.index(pixel) == Some(8)));
}

#[test]
fn sample_indices_of_a_pixel_follow_each_other() {
    let mut film = adaptive(3, 16, Some(0.1));
    film.plan(Some(0.1));
    let mut next = [0; 16];
    for _ in 0..16 * 32 {
        for (pixel, next) in next.iter_mut().enumerate() {
            if let Some(index) = film.index(pixel) {
                assert_eq!(index, *next);
                // The replicates of a round share the index.
                *next += u64::from(film.replicate() == 31);
            }
        }
        film.add_pass(&[grey(1.0); 16]);
    }
    assert!(next[1] < 16 && next[13] == 16, "{next:?}");
}

#[test]
fn planning_a_stage_again_changes_nothing() {
    for target in [None, Some(0.1)] {
        let mut film = adaptive(3, 16, target);
        film.plan(target);
        let once = film.clone();
        film.plan(target);
        assert_eq!(film, once);
        assert_eq!(film.pixels.iter().any(|p| p.stride > 0), target.is_some());
    }
}

#[test]
fn resting_pixels_ignore_what_is_sent_to_them() {
    let mut film = adaptive(3, 16, Some(0.1));
    film.plan(Some(0.1));
    let before = film.clone();
    film.add_pass(&[grey(5.0); 16]);
    for pixel in 0..16 {
        let changed = film.pixels[pixel] != before.pixels[pixel];
        assert_eq!(changed, before.index(pixel).is_some());
    }
}

#[test]
fn share_of_pixels_within_a_target_is_counted_with_a_floor() {
    let film = adaptive(1, 4, None);
    let all = film.relative_error_of(1.0).expect("known");
    assert!((film.share_within(all) - 1.0).abs() <= 1e-12);
    let half = film.relative_error_of(0.5).expect("known");
    assert!(half < all && (film.share_within(half) - 0.5).abs() <= 1e-12);
    assert_eq!(Film::new([1, 1], 4).expect("small").relative_error_of(0.95), None);
    // A black image has nothing to learn.
    let mut black = Film::new([2, 1], 2).expect("small");
    (0..2).for_each(|_| black.add_pass(&[SplitLight::default(); 2]));
    assert_eq!(black.relative_error_of(0.95), Some(0.0));
}

#[test]
fn films_without_pixels_are_refused() {
    let error = Film::new([0, 5], 4).expect_err("empty").to_string();
    assert!(error.contains("0 x 5 pixels is empty"), "{error}");
}

#[test]
fn direct_and_indirect_make_the_image() {
    let film = adaptive(1, 2, None);
    let (image, direct, indirect) = (film.image(), film.direct(), film.indirect());
    for i in 0..16 {
        assert_eq!(image[i], direct[i] + indirect[i]);
        assert!((3.0 * direct[i].luminance() - indirect[i].luminance()).abs() <= 1e-12);
    }
}
