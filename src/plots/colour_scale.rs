//! Which colour stands for which value: the scale of a false-colour picture.

use crate::plots::{Palette, Scale, ticks};
use crate::{Error, Result};

/// The most decades of a logarithmic scale: far more than light and eyes have.
pub const MOST_DECADES: f64 = 30.0;
/// As many steps as a scale has at most unless a number is asked for.
const STEPS: usize = 8;
/// The digits by which values of a scale are told apart.
const DIGITS: usize = 4;

/// Says what is asked of a scale; what is left open is fitted to the values.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ScaleOptions {
    /// The value of the last colour.
    pub high: Option<f64>,
    /// The value of the first colour, of a linear scale.
    pub low: Option<f64>,
    /// The decades of a logarithmic scale, in place of `low`.
    pub decades: Option<f64>,
    /// The number of divisions, of equal length; else they are at round values.
    pub divisions: Option<u16>,
    /// The colours.
    pub palette: Palette,
    /// Whether each division has one colour.
    pub bands: bool,
    /// Whether an open low end of a linear scale may be above 0, where the values are all far from
    /// it.
    pub tight: bool,
}

/// Assigns colours to values.
///
/// ```
/// use harmolux::plots::ScaleOptions;
///
/// let scale = ScaleOptions::default().fitted(&[120.0, 430.0, 560.0], 1.0)?;
/// assert_eq!(scale.range(), [0.0, 600.0]);
/// assert_eq!(scale.levels(), [0.0, 100.0, 200.0, 300.0, 400.0, 500.0, 600.0]);
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ColourScale {
    low: f64,
    high: f64,
    kind: Scale,
    levels: Vec<f64>,
    palette: Palette,
    bands: bool,
}

impl ScaleOptions {
    /// Fits a scale to values. What is left open runs from 0 (or, of a `tight` scale of values
    /// whose least is above half of the largest, from below that) to a round number that is not
    /// below a share `cover`, from 0 to 1, of them; values that are not finite do not count, and
    /// without any the scale ends at 1.
    ///
    /// # Errors
    /// [`Error::Parameter`] when an end is not a finite number, the high one is not above the low
    /// one, or a logarithmic scale would not be positive or has not above 0 and at most
    /// [`MOST_DECADES`] decades.
    pub fn fitted(&self, values: &[f64], cover: f64) -> Result<ColourScale> {
        if let Some(decades) = self.decades.filter(|d| !(*d > 0.0 && *d <= MOST_DECADES)) {
            return Err(Error::Parameter(format!(
                "a logarithmic scale has above 0 and at most {MOST_DECADES} decades, not {decades}"
            )));
        }
        let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let place = (cover.clamp(0.0, 1.0) * sorted.len().saturating_sub(1) as f64).ceil();
        let reached = sorted.get(place as usize).copied().unwrap_or(0.0);
        let least = sorted.first().copied().unwrap_or(0.0);
        let mut high = self.high.unwrap_or_else(|| match self.decades {
            Some(_) => ticks::step_above(end_above(reached)),
            None => end_above(reached),
        });
        let (low, kind) = match self.decades {
            Some(decades) => (high / 10_f64.powf(decades), Scale::Logarithmic),
            None => (self.low.unwrap_or_else(|| self.start_below(least, reached)), Scale::Linear),
        };
        // A low end that was asked for lifts a high end that was not.
        if self.high.is_none() && self.low.is_some_and(|low| low >= high && low.is_finite()) {
            high = low + low.abs().max(1.0);
        }
        self.checked(low, high, kind)
    }

    /// Lets an open low end be above 0.
    pub fn tight(self) -> Self {
        Self { tight: true, ..self }
    }

    fn start_below(&self, least: f64, reached: f64) -> f64 {
        if least < 0.0 {
            return -ticks::round_above(-least);
        }
        let far = self.tight && least > 0.5 * reached;
        let start = if far { ticks::round_below(least) } else { 0.0 };
        if start < end_above(reached) { start } else { 0.0 }
    }

    fn checked(&self, low: f64, high: f64, kind: Scale) -> Result<ColourScale> {
        if !(low < high && (high - low).is_finite()) {
            return Err(Error::Parameter(format!(
                "a scale from {low} to {high} shows nothing: its end must be above its start"
            )));
        }
        if kind == Scale::Logarithmic && (low <= 0.0 || low.is_nan()) {
            return Err(Error::Parameter(format!(
                "a logarithmic scale from {low} to {high} does not exist: both must be positive"
            )));
        }
        let levels = match (self.divisions, kind) {
            (Some(n), _) => divided(low, high, kind, n.max(1)),
            (None, Scale::Linear) => ticks::linear(low, high, STEPS),
            (None, Scale::Logarithmic) => ticks::logarithmic(low, high),
        };
        Ok(ColourScale { low, high, kind, levels, palette: self.palette, bands: self.bands })
    }
}

/// Divides a scale into equal parts.
fn divided(low: f64, high: f64, kind: Scale, parts: u16) -> Vec<f64> {
    let share = |k: u16| f64::from(k) / f64::from(parts);
    let level = |k: u16| match kind {
        _ if k == parts => high,
        Scale::Linear => low + share(k) * (high - low),
        Scale::Logarithmic => low * (high / low).powf(share(k)),
    };
    (0..=parts).map(level).collect()
}

fn end_above(reached: f64) -> f64 {
    match reached {
        r if r > 0.0 => ticks::round_above(r),
        // All is dark, or there is nothing.
        r if r >= 0.0 => 1.0,
        _ => 0.0,
    }
}

impl ColourScale {
    /// Returns the values of the first and the last colour.
    pub const fn range(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// Returns how it runs.
    pub const fn kind(&self) -> Scale {
        self.kind
    }

    /// Returns its colours.
    pub const fn palette(&self) -> Palette {
        self.palette
    }

    /// Returns the values at which it is divided, ascending: the numbers of its legend, and the
    /// isolines.
    pub fn levels(&self) -> &[f64] {
        &self.levels
    }

    /// Lists the numbers of a legend, the ends of the scale first, then the levels between them.
    pub(super) fn numbers(&self) -> Vec<(f64, String)> {
        let is_level = |end: &f64| self.levels.iter().any(|v| self.place(*v) == self.place(*end));
        let ends = self.range().into_iter().filter(|end| !is_level(end));
        let ends = ends.map(|end| (end, ticks::short(end, DIGITS)));
        ends.chain(self.numbered_levels()).collect()
    }

    /// Lists the levels and how they are written.
    pub(super) fn numbered_levels(&self) -> impl Iterator<Item = (f64, String)> {
        self.levels.iter().copied().zip(ticks::texts(&self.levels, DIGITS))
    }

    /// Returns the place of a value from 0, low, to 1, high, those outside at the ends; `None` when
    /// it is not finite.
    pub fn place(&self, value: f64) -> Option<f64> {
        if !value.is_finite() {
            return None;
        }
        let place = match self.kind {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Logarithmic if value <= self.low => 0.0,
            Scale::Logarithmic => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        Some(place.clamp(0.0, 1.0))
    }

    /// Returns the sRGB colour of a value; `None` when it is not finite.
    pub fn colour(&self, value: f64) -> Option<[u8; 3]> {
        self.place(value).map(|place| self.colour_at(place))
    }

    /// Returns the colour at a place from 0 to 1.
    pub(super) fn colour_at(&self, place: f64) -> [u8; 3] {
        if !self.bands {
            return self.palette.colour(place);
        }
        let bounds: Vec<f64> = self.inner_levels().filter_map(|level| self.place(level)).collect();
        let band = bounds.iter().filter(|bound| **bound <= place + 1e-12).count();
        self.palette.colour((band as f64 + 0.5) / (bounds.len() + 1) as f64)
    }

    /// Lists the levels between the ends.
    pub(super) fn inner_levels(&self) -> impl Iterator<Item = f64> {
        let [low, high] = self.range();
        let margin = 1e-9 * (high - low);
        self.levels.iter().copied().filter(move |v| *v > low + margin && *v < high - margin)
    }

    /// Brings a value to where the scale is even, for interpolation: its logarithm on a logarithmic
    /// scale, that of a value at or below zero far below.
    pub(super) fn evened(&self, value: f64) -> f64 {
        match self.kind {
            Scale::Linear => value,
            Scale::Logarithmic if value.is_finite() => value.max(1e-3 * self.low).ln(),
            Scale::Logarithmic => f64::NAN,
        }
    }

    /// Counts the values below and above the scale.
    pub fn outside(&self, values: &[f64]) -> [usize; 2] {
        let count =
            |is: &dyn Fn(f64) -> bool| values.iter().filter(|v| v.is_finite() && is(**v)).count();
        let slack = 1e-9 * (self.high - self.low);
        [
            count(&|v| v < self.low - slack.min(1e-9 * self.low.abs())),
            count(&|v| v > self.high + slack),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fitted(wish: &ScaleOptions, values: &[f64]) -> ColourScale {
        wish.fitted(values, 1.0).expect("a scale")
    }

    #[test]
    fn nothing_and_darkness_have_a_scale_to_one() {
        for values in [&[][..], &[0.0; 5], &[f64::NAN, f64::INFINITY]] {
            let scale = fitted(&ScaleOptions::default(), values);
            assert_eq!(scale.range(), [0.0, 1.0]);
            let log = fitted(&ScaleOptions { decades: Some(2.0), ..Default::default() }, values);
            assert_eq!(log.range(), [0.01, 1.0]);
        }
    }

    #[test]
    fn open_ends_are_fitted_and_stated_ones_kept() {
        let open = ScaleOptions::default();
        assert_eq!(fitted(&open, &[20.0, 523.0]).range(), [0.0, 600.0]);
        assert_eq!(fitted(&open.tight(), &[480.0, 523.0]).range(), [400.0, 600.0]);
        assert_eq!(fitted(&open.tight(), &[7.0, 7.0]).range(), [6.0, 8.0]);
        assert_eq!(fitted(&open, &[480.0, 523.0]).range(), [0.0, 600.0]);
        assert_eq!(fitted(&open, &[-3.0, 5.0]).range(), [-3.0, 5.0]);
        assert_eq!(fitted(&open, &[-3.0, -1.0]).range(), [-3.0, 0.0]);
        let low = ScaleOptions { low: Some(700.0), ..open };
        assert_eq!(fitted(&low, &[20.0, 523.0]).range(), [700.0, 1400.0]);
        let both = ScaleOptions { high: Some(37.0), low: Some(5.0), ..open };
        assert_eq!(fitted(&both, &[20.0]).range(), [5.0, 37.0]);
        // One highlight of a thousand does not darken all the rest.
        let mut bright: Vec<f64> = vec![10.0; 1000];
        bright[0] = 1e6;
        assert_eq!(open.fitted(&bright, 0.995).expect("a scale").range()[1], 10.0);
        assert_eq!(open.fitted(&bright, 0.995).expect("a scale").outside(&bright), [0, 1]);
    }

    #[test]
    fn senseless_scales_are_refused() {
        let open = ScaleOptions::default();
        for wish in [
            ScaleOptions { high: Some(-1.0), low: Some(0.0), ..open },
            ScaleOptions { high: Some(f64::NAN), ..open },
            ScaleOptions { high: Some(f64::INFINITY), ..open },
            ScaleOptions { low: Some(f64::NAN), ..open },
            ScaleOptions { high: Some(0.0), decades: Some(2.0), ..open },
        ] {
            assert!(wish.fitted(&[1.0, 2.0], 1.0).is_err(), "{wish:?}");
        }
        for decades in [0.0, -1.0, f64::NAN, 30.1, 1e9] {
            let wish = ScaleOptions { decades: Some(decades), ..open };
            let message = wish.fitted(&[1.0, 2.0], 1.0).expect_err("out of range").to_string();
            assert!(message.contains("above 0 and at most 30 decades, not"), "{message}");
        }
    }

    #[test]
    fn divisions_are_equal_parts() {
        let four = ScaleOptions {
            high: Some(10.0),
            low: Some(0.0),
            divisions: Some(4),
            ..Default::default()
        };
        assert_eq!(fitted(&four, &[]).levels(), [0.0, 2.5, 5.0, 7.5, 10.0]);
        let log = ScaleOptions { low: None, decades: Some(2.0), divisions: Some(2), ..four };
        assert!(fitted(&log, &[]).numbered_levels().map(|(_, t)| t).eq(["0.1", "1", "10"]));
    }

    #[test]
    fn legend_has_the_ends_of_the_scale() {
        let odd = ScaleOptions { high: Some(37.0), low: Some(5.0), ..Default::default() };
        let texts: Vec<String> = fitted(&odd, &[]).numbers().into_iter().map(|(_, t)| t).collect();
        assert_eq!(texts, ["5", "37", "5", "10", "15", "20", "25", "30", "35"][1..]);
        let log = ScaleOptions { decades: Some(2.0), ..Default::default() };
        assert_eq!(fitted(&log, &[56.0]).range(), [1.0, 100.0]);
    }

    #[test]
    fn values_find_their_places() {
        let scale = fitted(
            &ScaleOptions { high: Some(100.0), decades: Some(2.0), ..Default::default() },
            &[],
        );
        for (value, place) in [(10.0, 0.5), (0.0, 0.0), (-5.0, 0.0), (1e9, 1.0)] {
            let found = scale.place(value).expect("finite");
            assert!((found - place).abs() <= 1e-12, "{value}: {found}");
        }
        assert_eq!((scale.place(f64::NAN), scale.colour(f64::INFINITY)), (None, None));
        assert_eq!(scale.outside(&[0.5, 1.0, 100.0, 101.0, f64::NAN]), [1, 1]);
    }

    #[test]
    fn bands_have_one_colour_each_the_middle_of_their_part_of_the_palette() {
        let wish = ScaleOptions {
            high: Some(4.0),
            low: Some(0.0),
            divisions: Some(4),
            bands: true,
            ..Default::default()
        };
        let scale = fitted(&wish, &[]);
        assert_eq!(scale.colour(0.1), scale.colour(0.9));
        assert_ne!(scale.colour(0.9), scale.colour(1.1));
        assert_eq!(scale.colour(0.0), Some(Palette::Viridis.colour(0.125)));
        assert_eq!(scale.colour(3.5), Some(Palette::Viridis.colour(0.875)));
    }
}
