//! A picture in false colour: each pixel by its value, with a legend, and on demand isolines and
//! the extremes.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::RgbImage;

use crate::io::images::{NOT_FINITE, encode_png};
use crate::plots::labels::Placing;
use crate::plots::legend::{Legend, Swatch, draw_isoline};
use crate::plots::paper::{Area, BLACK, Paper, Rgb8, WHITE, plate_size};
use crate::plots::{ColourScale, Tally, ticks};
use crate::{Error, Result};

/// Small pictures are enlarged until their longer side has this many pixels.
const LONG_SIDE: usize = 640;
/// The largest side of a picture, pixels.
const LARGEST: usize = 8192;
/// Colours are looked up in a table of this many places: finer than the 256 levels of a channel.
const PLACES: usize = 4096;
/// Rings of noise shorter than this, pixels of the picture, are not drawn.
const SHORTEST: f64 = 10.0;
/// The colour of pixels that show nothing.
const NOTHING: Rgb8 = [128; 3];

/// Holds the values of a picture and how they are shown.
///
/// ```
/// use harmolux::plots::{FalseColour, ScaleOptions};
///
/// let values = vec![1.0, 20.0, 300.0, f64::NAN];
/// let wish = ScaleOptions { high: Some(1000.0), decades: Some(3.0), ..Default::default() };
/// let picture = FalseColour {
///     width: 2,
///     height: 2,
///     scale: wish.fitted(&values, 1.0)?,
///     values,
///     unit: "cd/m\u{b2}".to_owned(),
///     lines: true,
///     extremes: false,
///     endless: false,
/// };
/// assert_eq!(picture.tally().not_finite, 1);
/// assert!(picture.to_svg()?.contains("cd/m\u{b2}"));
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct FalseColour {
    /// The pixels of a row.
    pub width: usize,
    /// The rows.
    pub height: usize,
    /// The values, row by row from the top left; those that are not finite are shown magenta.
    pub values: Vec<f64>,
    /// The colours, and the values of the isolines.
    pub scale: ColourScale,
    /// The unit of the values.
    pub unit: String,
    /// Whether isolines are drawn, labelled; they are those of the picture smoothed over five
    /// pixels, since noise has none.
    pub lines: bool,
    /// Whether the largest and the least value are marked and written.
    pub extremes: bool,
    /// Whether infinity means that there is nothing, as in a picture of depths: such pixels are
    /// grey and not counted as non-finite.
    pub endless: bool,
}

impl FalseColour {
    /// Returns what the values come to.
    pub fn tally(&self) -> Tally {
        let tally = Tally::of(&self.values.iter().copied().enumerate());
        Tally { not_finite: tally.not_finite - self.nothing(), ..tally }
    }

    /// Counts the pixels that show nothing.
    pub fn nothing(&self) -> usize {
        self.values.iter().filter(|value| self.is_nothing(**value)).count()
    }

    fn is_nothing(&self, value: f64) -> bool {
        self.endless && value == f64::INFINITY
    }

    /// Draws it as PNG.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the size does not fit the values, or a side has none or more than
    /// 8192 pixels; [`Error::Numeric`] with the encoder's complaint.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        let layout = self.layout()?;
        let mut paper = self.drawn(&layout);
        // What is drawn over the picture is drawn on white and on black: their difference is what
        // shows through.
        let mut picture = paper.pixels(1.0, WHITE)?;
        let on_black = paper.pixels(1.0, BLACK)?;
        self.show_through(&mut picture, &on_black, &layout);
        let (width, height) = picture.dimensions();
        encode_png(width as usize, height as usize, picture.as_raw())
    }

    /// Draws it as SVG, the pixels as an embedded PNG.
    ///
    /// # Errors
    /// As [`FalseColour::to_png`].
    pub fn to_svg(&self) -> Result<String> {
        let layout = self.layout()?;
        let samples: Vec<u8> = self.colours().into_iter().flatten().collect();
        let png = STANDARD.encode(encode_png(self.width, self.height, &samples)?);
        let Area { x, y, width, height } = layout.picture;
        let element = format!(
            "<g id=\"picture\"><image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
             preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
             href=\"data:image/png;base64,{png}\"/></g>"
        );
        Ok(self.drawn(&layout).svg(&element))
    }

    fn layout(&self) -> Result<Layout> {
        let sides = [self.width, self.height];
        let fits = sides.iter().all(|n| (1..=LARGEST).contains(n));
        if !fits || self.width * self.height != self.values.len() {
            return Err(Error::Parameter(format!(
                "{} values are no picture of {} x {} pixels, each side from 1 to {LARGEST}",
                self.values.len(),
                self.width,
                self.height
            )));
        }
        let zoom = LONG_SIDE.div_ceil(self.width.max(self.height)).max(1);
        let [width, height] = sides.map(|n| (n * zoom) as f64);
        let font = (height.min(1.5 * width) / 34.0).round().clamp(13.0, 44.0);
        Ok(Layout { zoom, font, picture: Area { x: font, y: font, width, height } })
    }

    /// Returns the colour of each pixel.
    fn colours(&self) -> Vec<Rgb8> {
        let table: Vec<Rgb8> =
            (0..=PLACES).map(|k| self.scale.colour_at(k as f64 / PLACES as f64)).collect();
        let colour = |value: &f64| {
            let place = self.scale.place(*value).map(|p| (p * PLACES as f64).round() as usize);
            let otherwise = if self.is_nothing(*value) { NOTHING } else { NOT_FINITE };
            place.and_then(|p| table.get(p)).copied().unwrap_or(otherwise)
        };
        self.values.iter().map(colour).collect()
    }

    fn show_through(&self, on_white: &mut RgbImage, on_black: &RgbImage, layout: &Layout) {
        let colours = self.colours();
        let (left, top) = (layout.picture.x as usize, layout.picture.y as usize);
        for y in 0..self.height * layout.zoom {
            for x in 0..self.width * layout.zoom {
                let under = colours[y / layout.zoom * self.width + x / layout.zoom];
                let at = ((left + x) as u32, (top + y) as u32);
                let (white, black) = (&mut on_white[at].0, on_black[at].0);
                for ((white, black), under) in white.iter_mut().zip(black).zip(under) {
                    let through = u32::from(white.saturating_sub(black));
                    let seen = u32::from(black) + (through * u32::from(under) + 127) / 255;
                    *white = seen.min(255) as u8;
                }
            }
        }
    }

    /// Draws all but the pixels.
    fn drawn(&self, layout: &Layout) -> Paper {
        let Layout { font, picture, .. } = *layout;
        let tally = self.tally();
        let legend = self.legend(font, &tally);
        let gap = (1.2 * font).round();
        let height = picture.height.max(legend.least_height()).ceil();
        let width = (picture.right() + gap + legend.width() + font).ceil();
        let mut paper = Paper::new(width, height + 2.0 * font);
        let mut placing = Placing {
            frame: picture,
            soft: Vec::new(),
            taken: Vec::new(),
            reach: 0.8 * picture.width.max(picture.height),
            shortest: SHORTEST * layout.zoom as f64,
            font: (0.8 * font).round(),
        };
        let extremes = self.extremes(&mut placing, layout, &tally);
        if self.lines {
            self.draw_lines(&mut paper, &mut placing, layout);
        }
        for (at, middle, text) in extremes {
            // A ring that is seen on every colour.
            let width = (font / 9.0).max(1.5);
            paper.ring(at, 0.4 * font + 0.5 * width, WHITE, width);
            paper.ring(at, 0.4 * font - 0.5 * width, BLACK, width);
            paper.plate(middle, font, &text);
        }
        legend.draw(&mut paper, [picture.right() + gap, picture.y], height);
        paper
    }

    fn legend(&self, font: f64, tally: &Tally) -> Legend<'_> {
        let note = |count: usize, colour: Rgb8, text: &'static str| {
            (count > 0).then_some((Swatch::Colour(colour), text))
        };
        let nothing = note(self.nothing(), NOTHING, "nothing");
        let non_finite = note(tally.not_finite, NOT_FINITE, "not finite");
        Legend {
            scale: &self.scale,
            unit: &self.unit,
            outside: self.scale.outside(&self.values).map(|n| n > 0),
            notes: nothing.into_iter().chain(non_finite).collect(),
            font,
        }
    }

    fn draw_lines(&self, paper: &mut Paper, placing: &mut Placing, layout: &Layout) {
        let evened: Vec<f64> = self.values.iter().map(|v| self.scale.evened(*v)).collect();
        let field = smoothed(self.width, &evened);
        let thick = (layout.font / 14.0).max(1.0);
        let (levels, place) = (self.scale.numbered_levels(), |p| layout.place(p));
        let (lines, labels) = placing.isolines(&self.scale, levels, (self.width, &field), place);
        for line in &lines {
            draw_isoline(paper, line, thick);
        }
        for (middle, text) in labels {
            paper.plate(middle, placing.font, &text);
        }
    }

    /// Lists the extremes, if they are shown: where each is, the middle of its plate, its text.
    /// Labels of lines are kept off them.
    fn extremes(
        &self,
        placing: &mut Placing,
        layout: &Layout,
        tally: &Tally,
    ) -> Vec<([f64; 2], [f64; 2], String)> {
        let Layout { font, picture, .. } = *layout;
        let found = [tally.largest, tally.least].into_iter().flatten().filter(|_| self.extremes);
        let mut extremes = Vec::new();
        for (place, value) in found {
            let at = layout.place([place % self.width, place / self.width].map(|n| n as f64));
            let text = ticks::short(value, 3);
            let size = plate_size(&text, font);
            let aside = 0.5 * size[0] + 0.8 * font;
            let right = at[0] + aside + 0.5 * size[0] <= picture.right();
            let x = if right { at[0] + aside } else { at[0] - aside };
            let [top, bottom] = [picture.y + 0.5 * size[1], picture.bottom() - 0.5 * size[1]];
            let middle = [x, at[1].clamp(top, bottom.max(top))];
            placing.taken.extend([Area::about(at, [font, font]), Area::about(middle, size)]);
            extremes.push((at, middle, text));
        }
        extremes
    }
}

/// Where things are on the paper.
#[derive(Debug, Clone, Copy)]
struct Layout {
    /// The pixels of the paper for one of the picture.
    zoom: usize,
    font: f64,
    picture: Area,
}

impl Layout {
    /// Returns where the middle of a pixel is.
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let zoom = self.zoom as f64;
        [self.picture.x + (x + 0.5) * zoom, self.picture.y + (y + 0.5) * zoom]
    }
}

/// Smooths over five pixels each way with binomial weights; what is not finite stays so and does
/// not count.
fn smoothed(width: usize, values: &[f64]) -> Vec<f64> {
    let height = values.len().checked_div(width).unwrap_or(0);
    let along = |values: &[f64], step: usize, place: &dyn Fn(usize) -> (usize, usize)| {
        let smooth = |i: usize| {
            let (at, count) = place(i);
            let mut sums = [0.0; 2];
            for (k, weight) in [1.0, 4.0, 6.0, 4.0, 1.0].into_iter().enumerate() {
                // The neighbour k - 2 steps on, where there is one.
                let neighbour = (at + k).checked_sub(2).filter(|n| *n < count);
                let value = neighbour.map_or(f64::NAN, |n| values[i + n * step - at * step]);
                if value.is_finite() {
                    sums = [sums[0] + weight * value, sums[1] + weight];
                }
            }
            if values[i].is_finite() { sums[0] / sums[1] } else { f64::NAN }
        };
        (0..values.len()).map(smooth).collect::<Vec<f64>>()
    };
    let across = along(values, 1, &|i| (i % width, width));
    along(&across, width, &|i| (i / width, height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::ScaleOptions;

    fn picture(width: usize, height: usize, values: Vec<f64>, wish: ScaleOptions) -> FalseColour {
        let scale = wish.fitted(&values, 1.0).expect("a scale");
        let unit = "cd/m\u{b2}".to_owned();
        let (lines, extremes, endless) = (false, false, false);
        FalseColour { width, height, values, scale, unit, lines, extremes, endless }
    }

    fn decoded(picture: &FalseColour) -> RgbImage {
        image::load_from_memory(&picture.to_png().expect("drawn")).expect("a PNG").into_rgb8()
    }

    /// Sixteen by twelve pixels that rise to the right.
    fn ramp() -> Vec<f64> {
        (0..192).map(|i| f64::from(i % 16)).collect()
    }

    #[test]
    fn misshapen_pictures_are_refused() {
        for (width, height, n) in [(0, 0, 0), (2, 2, 3), (9000, 1, 9000), (usize::MAX, 2, 2)] {
            let misshapen = picture(width, height, vec![0.0; n], ScaleOptions::default());
            assert!(misshapen.to_svg().is_err() && misshapen.to_png().is_err());
        }
    }

    #[test]
    fn dark_constant_and_non_finite_pictures_are_drawn() {
        for values in [vec![0.0; 6], vec![7.0; 6], vec![f64::NAN; 6], vec![1e300; 6], vec![-1.0; 6]]
        {
            for decades in [None, Some(3.0)] {
                let wish =
                    ScaleOptions { decades, high: decades.map(|_| 1.0), ..Default::default() };
                let picture = picture(3, 2, values.clone(), wish);
                let picture = FalseColour { lines: true, extremes: true, ..picture };
                assert!(decoded(&picture).width() >= 640);
                assert!(picture.to_svg().expect("drawn").starts_with("<svg"));
            }
        }
    }

    #[test]
    fn pixels_have_the_colours_of_their_values_and_non_finite_ones_are_magenta() {
        let mut values = ramp();
        values[0] = f64::NAN;
        values[1] = f64::INFINITY;
        let picture = picture(16, 12, values, ScaleOptions::default());
        let Layout { zoom, picture: area, .. } = picture.layout().expect("fits");
        let image = decoded(&picture);
        let at = |x: usize, y: usize| {
            let [x, y] =
                [area.x as usize + x * zoom + zoom / 2, area.y as usize + y * zoom + zoom / 2];
            image[(x as u32, y as u32)].0
        };
        assert_eq!([at(0, 0), at(1, 0)], [NOT_FINITE; 2]);
        for x in [2, 7, 15] {
            let expected = picture.scale.colour(x as f64).expect("finite");
            assert!(at(x, 5).iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 1), "{x}");
        }
        assert_eq!(picture.tally().not_finite, 2);
        assert!(picture.to_svg().expect("drawn").contains("not finite"));
    }

    #[test]
    fn infinity_may_mean_that_there_is_nothing() {
        let values = vec![1.0, f64::INFINITY, f64::NAN, f64::NEG_INFINITY];
        let picture = picture(2, 2, values, ScaleOptions::default());
        assert_eq!((picture.nothing(), picture.tally().not_finite), (0, 3));
        let picture = FalseColour { endless: true, ..picture };
        assert_eq!((picture.nothing(), picture.tally().not_finite), (1, 2));
        assert_eq!(picture.colours()[1..], [NOTHING, NOT_FINITE, NOT_FINITE]);
        let svg = picture.to_svg().expect("drawn");
        assert!(svg.contains(">nothing<") && svg.contains(">not finite<"));
    }

    #[test]
    fn lines_and_extremes_are_drawn_over_the_picture() {
        let plain = picture(16, 12, ramp(), ScaleOptions::default());
        let image = decoded(&plain);
        assert_ne!(decoded(&FalseColour { lines: true, ..plain.clone() }), image);
        let marked = FalseColour { extremes: true, ..plain.clone() };
        let svg = marked.to_svg().expect("drawn");
        assert!(svg.contains("<circle") && svg.contains(">15<"), "extremes");
        assert!(!plain.to_svg().expect("drawn").contains("<circle"));
    }

    #[test]
    fn smoothing_keeps_constants_and_what_is_missing() {
        let mut values = vec![3.0; 35];
        values[16] = f64::NAN;
        let smooth = smoothed(7, &values);
        assert!(smooth.iter().enumerate().all(|(i, v)| v.is_nan() == (i == 16)));
        assert!(smooth.iter().all(|v| v.is_nan() || (v - 3.0).abs() <= 1e-12));
        assert!(smoothed(0, &[]).is_empty());
    }
}
