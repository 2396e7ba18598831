//! Judges pictures pixel by pixel, all pixels of a picture together with a false-alarm rate of 1e-3
//! (`Estimate::agrees_with`, `joint_test`).

use harmolux::math::stats::Estimate;
use harmolux::scene::Film;
use harmolux::study::{Picture, joint_test};

/// Returns the luminance of every pixel.
fn pixels(film: &Film) -> impl Iterator<Item = Estimate> {
    let replicates = film.replicates();
    film.image().into_iter().zip(film.standard_errors()).map(move |(colour, standard_error)| {
        Estimate { mean: colour.luminance(), standard_error, replicates }
    })
}

/// Judges every pixel against its own luminance.
pub fn assert_each(film: &Film, expected: impl Fn(usize) -> f64) {
    let n = film.size()[0] * film.size()[1];
    for (i, estimate) in pixels(film).enumerate() {
        let expected = expected(i);
        assert!(estimate.agrees_with(expected, 0.0, n), "pixel {i}: {estimate:?}, not {expected}");
    }
}

/// Judges every pixel against one luminance, and the image mean.
pub fn assert_flat(film: &Film, expected: f64) {
    let n = film.size()[0] * film.size()[1];
    for (i, estimate) in pixels(film).enumerate() {
        assert!(estimate.agrees_with(expected, 0.0, n + 1), "pixel {i}: {estimate:?}");
    }
    let (mean, standard_error) = film.mean();
    let mean = Estimate { mean, standard_error, replicates: film.replicates() };
    // Replicate sums are kept in f32: 1e-7 of the value.
    assert!(
        (mean.mean - expected).abs() <= 6.0 * standard_error + 1e-6 * expected,
        "mean {mean:?}"
    );
    assert!(standard_error <= 0.01 * expected, "too noisy to say anything: {mean:?}");
}

/// Judges two films pixel by pixel and block by block, as `harmolux compare` does, and their means.
pub fn assert_alike(one: &Film, other: &Film) {
    let test = joint_test(&Picture::from(one), &Picture::from(other)).expect("errors are known");
    assert!(!test.differ() && test.unknown == 0, "{test:?}");
    assert_same_mean(one, other);
}

/// Judges the means of two films.
pub fn assert_same_mean(one: &Film, other: &Film) {
    let (a, b) = (one.mean(), other.mean());
    assert!((a.0 - b.0).abs() <= 4.0 * a.1.hypot(b.1), "means {a:?} and {b:?}");
    assert!(a.1.hypot(b.1) <= 0.01 * a.0, "too noisy to say anything: {a:?} {b:?}");
}
