//! The legend of a false-colour picture: the scale as an upright bar, and what the other colours
//! mean.

use crate::plots::ColourScale;
use crate::plots::paper::{Align, Area, FRAME, INK, Paper, Rgb8, WHITE, text_width};

/// The bar is drawn in so many slices: more than a palette has colours.
const SLICES: usize = 256;
/// The ground of what is not there, and its hatching.
const BLANK: Rgb8 = [0xe6; 3];
const HATCHING: Rgb8 = [0x90; 3];

/// What a legend says besides the scale.
pub(super) struct Legend<'a> {
    pub(super) scale: &'a ColourScale,
    /// The unit, as it is written.
    pub(super) unit: &'a str,
    /// Whether there are values below and above the scale.
    pub(super) outside: [bool; 2],
    /// What further colours mean.
    pub(super) notes: Vec<(Swatch, &'static str)>,
    /// The size of its text.
    pub(super) font: f64,
}

/// How an area without a value looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Swatch {
    Colour(Rgb8),
    Hatched,
}

impl Legend<'_> {
    fn bar_width(&self) -> f64 {
        (1.4 * self.font).round()
    }

    /// Returns the width it takes.
    pub(super) fn width(&self) -> f64 {
        let beside =
            |gap: f64, text: &str| self.bar_width() + gap * self.font + text_width(text, self.font);
        let numbers = self.scale.numbers().into_iter().map(|(_, text)| beside(0.9, &text));
        let widths = numbers.chain(self.notes.iter().map(|(_, text)| beside(0.6, text)));
        widths.fold(text_width(self.unit, self.font), f64::max).ceil()
    }

    /// Returns the height below which it cannot be read.
    pub(super) fn least_height(&self) -> f64 {
        let steps = self.scale.levels().len().clamp(2, 20) as f64;
        self.font * (1.5 * steps + 4.0 + 1.8 * self.notes.len() as f64)
    }

    /// Draws it with its upper left corner at a place, so high.
    pub(super) fn draw(&self, paper: &mut Paper, [x, top]: [f64; 2], height: f64) {
        let (font, width) = (self.font, self.bar_width());
        paper.text([x, top + 0.5 * font], Align::Left, font, INK, self.unit);
        let arrow = (0.9 * font).round();
        let [below, above] = self.outside.map(|there| if there { arrow } else { 0.0 });
        let notes = 1.8 * font * self.notes.len() as f64;
        // Half a number stands out below the bar.
        let foot = if self.notes.is_empty() { 0.0 } else { notes + 0.4 * font };
        let y = (top + 1.8 * font + above).round();
        let bottom = (top + height - foot - below).round();
        let bar = Area { x, y, width, height: (bottom - y).max(font) };
        self.draw_bar(paper, bar, arrow);
        self.draw_numbers(paper, bar);
        for (i, (swatch, text)) in self.notes.iter().enumerate() {
            let y = top + height - notes + 1.8 * font * (i as f64 + 0.5) + 0.3 * font;
            let area = Area::about([x + 0.5 * width, y], [width, font]);
            draw_swatch(paper, area, *swatch);
            paper.frame(area, FRAME, 1.0);
            paper.text([bar.right() + 0.6 * font, y], Align::Left, font, INK, text);
        }
    }

    fn draw_bar(&self, paper: &mut Paper, bar: Area, arrow: f64) {
        let (left, right) = (bar.x, bar.right());
        // Each slice reaches down to the end, so that no seam shows between two.
        for slice in 0..SLICES {
            let y = bar.y + bar.height * slice as f64 / SLICES as f64;
            let place = 1.0 - (slice as f64 + 0.5) / SLICES as f64;
            let area = Area { y, height: bar.bottom() - y, ..bar };
            paper.fill(area, self.scale.colour_at(place), None);
        }
        // An end with values beyond it has a tip.
        let mut end = |there: bool, y: f64, tip: f64, place: f64| {
            let mut corners = vec![[left, y], [left + 0.5 * bar.width, tip], [right, y]];
            if there {
                paper.polygon(&corners, self.scale.colour_at(place));
            } else {
                corners.remove(1);
            }
            corners
        };
        let mut outline = end(self.outside[1], bar.y, bar.y - arrow, 1.0);
        let bottom = end(self.outside[0], bar.bottom(), bar.bottom() + arrow, 0.0);
        outline.extend(bottom.into_iter().rev());
        outline.push([left, bar.y]);
        paper.polyline(&outline, FRAME, 1.0);
    }

    fn draw_numbers(&self, paper: &mut Paper, bar: Area) {
        let font = self.font;
        let mut taken: Vec<f64> = Vec::new();
        for (level, text) in self.scale.numbers() {
            let y = bar.bottom() - bar.height * self.scale.place(level).unwrap_or(0.0);
            // Numbers that would stand on others are left out.
            if taken.iter().any(|other| (other - y).abs() < 1.1 * font) {
                continue;
            }
            paper.polyline(&[[bar.right(), y], [bar.right() + 0.4 * font, y]], FRAME, 1.0);
            paper.text([bar.right() + 0.7 * font, y], Align::Left, font, INK, &text);
            taken.push(y);
        }
    }
}

/// Fills an area; rising lines hatch it at places that fit those of its neighbours.
pub(super) fn draw_swatch(paper: &mut Paper, area: Area, swatch: Swatch) {
    const GAP: f64 = 7.0;
    if let Swatch::Colour(colour) = swatch {
        return paper.fill(area, colour, None);
    }
    paper.fill(area, BLANK, None);
    // A line has x + y constant.
    let first = ((area.x + area.y) / GAP).ceil() as i64;
    let last = ((area.right() + area.bottom()) / GAP).floor() as i64;
    for sum in (first..=last).map(|k| k as f64 * GAP) {
        let [left, right] = [(sum - area.bottom()).max(area.x), (sum - area.y).min(area.right())];
        if right > left {
            paper.polyline(&[[left, sum - left], [right, sum - right]], HATCHING, 0.8);
        }
    }
}

/// Draws a line that is seen on every colour: dark with a light border.
pub(super) fn draw_isoline(paper: &mut Paper, points: &[[f64; 2]], width: f64) {
    paper.polyline(points, WHITE, 2.2 * width);
    paper.polyline(points, INK, width);
}
