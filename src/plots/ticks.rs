//! Round numbers along an axis or a scale, and how they are written.

/// The steps that are easy to count in, as multiples of a power of ten.
const STEPS: [f64; 4] = [1.0, 2.0, 2.5, 5.0];
/// The numbers that are round enough for the end of a scale.
const ROUND: [f64; 10] = [1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0];

/// Returns the power of ten at or below a positive number.
fn decade(value: f64) -> f64 {
    10_f64.powf(value.log10().floor())
}

/// Returns the multiples of a round step from `low` to `high`, about as many steps as asked for or
/// fewer; none where that makes no sense.
pub(super) fn linear(low: f64, high: f64, steps: usize) -> Vec<f64> {
    let least = (high - low) / steps.max(1) as f64;
    if !(least > 0.0 && least.is_finite()) {
        return Vec::new();
    }
    let unit = decade(least);
    let step = STEPS.into_iter().map(|s| s * unit).find(|s| *s >= least * (1.0 - 1e-9));
    let step = step.unwrap_or(10.0 * unit);
    let [first, last] = [(low / step - 1e-9).ceil(), (high / step + 1e-9).floor()];
    // Where the step is lost in the size of the numbers there is nothing to tell apart.
    let few = last - first <= 2.0 * steps as f64 + 2.0;
    if !few {
        return Vec::new();
    }
    (0..=(last - first) as usize).map(|k| tidy((first + k as f64) * step)).collect()
}

/// Returns round numbers from `low` to `high`, both positive: 1, 2, 5 in each decade, or fewer
/// where there are many decades.
pub(super) fn logarithmic(low: f64, high: f64) -> Vec<f64> {
    let decades = (high / low).log10();
    if !(low > 0.0 && decades > 0.0 && decades.is_finite()) {
        return Vec::new();
    }
    let parts: &[f64] = match decades {
        d if d <= 0.6 => return linear(low, high, 8),
        d if d <= 2.6 => &[1.0, 2.0, 5.0],
        d if d <= 4.1 => &[1.0, 3.0],
        _ => &[1.0],
    };
    let every = (decades / 12.0).ceil().max(1.0) as i32;
    let [first, last] = [low, high].map(|v| v.log10().floor() as i32);
    let all = (first..=last).filter(|k| k % every == 0);
    let all = all.flat_map(|k| parts.iter().map(move |p| tidy(p * 10_f64.powi(k))));
    all.filter(|v| *v >= low * (1.0 - 1e-9) && *v <= high * (1.0 + 1e-9)).collect()
}

/// Returns the smallest round number that is not below a positive one.
pub(super) fn round_above(value: f64) -> f64 {
    let unit = decade(value);
    let fits = ROUND.into_iter().map(|r| tidy(r * unit)).find(|r| *r >= value * (1.0 - 1e-9));
    fits.unwrap_or_else(|| tidy(10.0 * unit))
}

/// Returns the largest 1, 2 or 5 times a power of ten that is not above a positive number.
pub(super) fn step_below(value: f64) -> f64 {
    let unit = decade(value);
    let fits = |k: &f64| k * unit <= value * (1.0 + 1e-9);
    tidy([5.0, 2.0, 1.0].into_iter().find(fits).map_or(unit, |k| k * unit))
}

/// Returns the smallest 1, 2 or 5 times a power of ten that is not below a positive number.
pub(super) fn step_above(value: f64) -> f64 {
    let unit = decade(value);
    let fits = |k: &f64| k * unit >= value * (1.0 - 1e-9);
    tidy([1.0, 2.0, 5.0].into_iter().find(fits).map_or(10.0 * unit, |k| k * unit))
}

/// Returns the largest round number that is not above a positive one.
pub(super) fn round_below(value: f64) -> f64 {
    let unit = decade(value);
    let fits = ROUND.into_iter().rev().map(|r| tidy(r * unit));
    fits.into_iter().find(|r| *r <= value * (1.0 + 1e-9)).unwrap_or(unit)
}

/// Takes the rounding errors out of a number that has few digits.
fn tidy(value: f64) -> f64 {
    format!("{value:.9e}").parse().unwrap_or(value)
}

/// Writes numbers of a scale alike: so many decimals that each keeps `digits` significant ones at
/// most and none is a mere zero.
pub(super) fn texts(values: &[f64], digits: usize) -> Vec<String> {
    let largest = values.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
    let least = values.iter().filter(|v| **v != 0.0).fold(f64::MAX, |a, v| a.min(v.abs()));
    if largest >= 1e6 || least < 1e-4 {
        return values.iter().map(|v| short(*v, digits)).collect();
    }
    // A wide range, of a logarithmic scale, would fill up with zeros: there each number has its
    // own.
    if largest >= 100.0 * least && values.iter().all(|v| *v > 0.0) {
        return values.iter().map(|v| short(*v, digits)).collect();
    }
    let needed = |v: &f64| {
        let text = short(*v, digits);
        text.split_once('.').map_or(0, |(_, decimals)| decimals.len())
    };
    let decimals = values.iter().map(needed).max().unwrap_or(0);
    values.iter().map(|v| minus(format!("{v:.decimals$}"))).collect()
}

/// Writes a number with at most so many significant digits, without zeros at its end.
pub(super) fn short(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{}", value + 0.0);
    }
    let places = digits.saturating_sub(1);
    let rounded: f64 = format!("{value:.places$e}").parse().unwrap_or(value);
    let text = if (1e-4..1e6).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    };
    minus(text)
}

/// Writes a value for its place in a picture: with the decimals of three significant digits of
/// `largest`.
pub(super) fn beside(value: f64, largest: f64) -> String {
    let magnitude = largest.abs().log10().floor();
    if !(-3.0..6.0).contains(&magnitude) {
        return short(value, 3);
    }
    let decimals = (2 - magnitude as i32).max(0) as usize;
    minus(format!("{value:.decimals$}"))
}

/// Writes minus signs as such, and none before zero.
fn minus(text: String) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        Some(rest) => format!("\u{2212}{rest}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn senseless_ranges_have_no_ticks() {
        for (low, high) in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
            assert!(linear(low, high, 5).is_empty() && logarithmic(low, high).is_empty());
        }
        assert!(linear(1e16, 1e16 + 2.0, 1000).len() < 2000);
        assert!(logarithmic(0.0, 1.0).is_empty() && logarithmic(-1.0, 1.0).is_empty());
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(linear(0.0, 600.0, 8), [0.0, 100.0, 200.0, 300.0, 400.0, 500.0, 600.0]);
        assert_eq!(linear(0.0, 0.3, 8), [0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3]);
        assert_eq!(linear(-1.2, 1.0, 4), [-1.0, 0.0, 1.0]);
        assert_eq!(logarithmic(1.0, 100.0), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]);
        assert_eq!(logarithmic(0.5, 500.0), [1.0, 3.0, 10.0, 30.0, 100.0, 300.0]);
        assert_eq!(logarithmic(1e-3, 1e3).len(), 7);
        assert!(logarithmic(1e-30, 1e30).len() <= 13);
        assert_eq!([round_above(520.0), round_above(0.9), round_above(100.0)], [600.0, 1.0, 100.0]);
        assert_eq!([step_above(1.0), step_above(80.0), step_above(0.03)], [1.0, 100.0, 0.05]);
        assert_eq!([round_below(520.0), round_below(0.9), round_below(99.0)], [500.0, 0.8, 80.0]);
    }

    #[test]
    fn steps_are_one_two_five() {
        for (value, low, high) in
            [(1.0, 1.0, 1.0), (3.2, 2.0, 5.0), (0.07, 0.05, 0.1), (90.0, 50.0, 100.0)]
        {
            assert!((step_below(value) / low - 1.0).abs() <= 1e-12, "{value}");
            assert!((step_above(value) / high - 1.0).abs() <= 1e-12, "{value}");
        }
    }

    #[test]
    fn numbers_of_one_scale_are_written_alike() {
        assert_eq!(texts(&[0.0, 2.5, 5.0], 4), ["0.0", "2.5", "5.0"]);
        assert_eq!(texts(&[0.0, 100.0, 200.0], 4), ["0", "100", "200"]);
        assert_eq!(texts(&[0.1, 1.0, 10.0, 100.0], 4), ["0.1", "1", "10", "100"]);
        assert_eq!(texts(&[0.0, 1e7], 4), ["0", "1e7"]);
        assert_eq!(texts(&[-0.5, 0.0], 4), ["\u{2212}0.5", "0.0"]);
        assert_eq!(texts(&[], 4), [""; 0]);
        assert_eq!([short(1234.6, 3), short(0.1 + 0.2, 3), short(0.0, 3)], ["1230", "0.3", "0"]);
        assert_eq!([beside(12.34, 523.0), beside(0.123, 4.5)], ["12", "0.12"]);
        assert_eq!([beside(-1e-9, 4.5), beside(1.5e-7, 2e-7)], ["0.00", "1.5e-7"]);
    }
}
