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
    pub(super) notes: Vec<(Swatch, String)>,
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
        let numbers = self.scale.numbers();
        let numbers =
            numbers.iter().map(|(_, t)| self.bar_width() + 0.9 * self.font + self.wide(t));
        let notes =
            self.notes.iter().map(|(_, t)| self.bar_width() + 0.6 * self.font + self.wide(t));
        let widest = numbers.chain(notes).fold(self.wide(self.unit), f64::max);
        widest.ceil()
    }

    fn wide(&self, text: &str) -> f64 {
        text_width(text, self.font)
    }

    /// Returns the height below which it cannot be read.
    pub(super) fn least_height(&self) -> f64 {
        let steps = self.scale.levels().len().clamp(2, 20) as f64;
        self.font * (1.5 * steps + 2.0 + 2.0 + 1.8 * self.notes.len() as f64)
    }

    /// Draws it with its upper left corner at a place, so high.
    pub(super) fn draw(&self, paper: &mut Paper, [x, top]: [f64; 2], height: f64) {
        let font = self.font;
        paper.text([x, top + 0.5 * font], Align::Left, font, INK, self.unit);
        let arrow = |there: bool| if there { (0.9 * font).round() } else { 0.0 };
        let notes = 1.8 * font * self.notes.len() as f64;
        let bar_top = (top + 1.8 * font + arrow(self.outside[1])).round();
        // Half a number stands out below the bar.
        let foot = if self.notes.is_empty() { 0.0 } else { notes + 0.4 * font };
        let bar_bottom = (top + height - foot - arrow(self.outside[0])).round();
        let bar = Area {
            x,
            y: bar_top,
            width: self.bar_width(),
            height: (bar_bottom - bar_top).max(font),
        };
        self.draw_bar(paper, bar, arrow(true));
        self.draw_numbers(paper, bar);
        for (i, (swatch, text)) in self.notes.iter().enumerate() {
            let y = top + height - notes + 1.8 * font * (i as f64 + 0.5) + 0.3 * font;
            let area = Area::about([x + 0.5 * bar.width, y], [bar.width, font]);
            draw_swatch(paper, area, *swatch);
            paper.frame(area, FRAME, 1.0);
            paper.text([bar.right() + 0.6 * font, y], Align::Left, font, INK, text);
        }
    }

    fn draw_bar(&self, paper: &mut Paper, bar: Area, arrow: f64) {
        // Each slice reaches down to the end, so that no seam shows between two.
        for slice in 0..SLICES {
            let y = bar.y + bar.height * slice as f64 / SLICES as f64;
            let place = 1.0 - (slice as f64 + 0.5) / SLICES as f64;
            let area = Area { y, height: bar.bottom() - y, ..bar };
            paper.fill(area, self.scale.colour_at(place), None);
        }
        let middle = bar.x + 0.5 * bar.width;
        let mut outline = vec![[bar.x, bar.y]];
        if self.outside[1] {
            let tip = [middle, bar.y - arrow];
            paper.polygon(&[[bar.x, bar.y], tip, [bar.right(), bar.y]], self.scale.colour_at(1.0));
            outline.push(tip);
        }
        outline.extend([[bar.right(), bar.y], [bar.right(), bar.bottom()]]);
        if self.outside[0] {
            let tip = [middle, bar.bottom() + arrow];
            let corners = [[bar.x, bar.bottom()], tip, [bar.right(), bar.bottom()]];
            paper.polygon(&corners, self.scale.colour_at(0.0));
            outline.push(tip);
        }
        outline.extend([[bar.x, bar.bottom()], [bar.x, bar.y]]);
        paper.polyline(outline, FRAME, 1.0);
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
            let tick = vec![[bar.right(), y], [bar.right() + 0.4 * font, y]];
            paper.polyline(tick, FRAME, 1.0);
            paper.text([bar.right() + 0.7 * font, y], Align::Left, font, INK, &text);
            taken.push(y);
        }
    }
}

/// Fills an area without a value.
pub(super) fn draw_swatch(paper: &mut Paper, area: Area, swatch: Swatch) {
    match swatch {
        Swatch::Colour(colour) => paper.fill(area, colour, None),
        Swatch::Hatched => {
            paper.fill(area, BLANK, None);
            hatch(paper, area);
        }
    }
}

/// Draws rising lines over an area, at places that fit those of its neighbours.
fn hatch(paper: &mut Paper, area: Area) {
    const GAP: f64 = 7.0;
    // A line has x + y constant.
    let first = ((area.x + area.y) / GAP).ceil() as i64;
    let last = ((area.right() + area.bottom()) / GAP).floor() as i64;
    for k in first..=last {
        let sum = k as f64 * GAP;
        let [left, right] = [(sum - area.bottom()).max(area.x), (sum - area.y).min(area.right())];
        if right > left {
            paper.polyline(vec![[left, sum - left], [right, sum - right]], HATCHING, 0.8);
        }
    }
}

/// Draws a line that is seen on every colour: dark with a light border.
pub(super) fn draw_isoline(paper: &mut Paper, points: &[[f64; 2]], width: f64) {
    paper.polyline(points.to_vec(), WHITE, 2.2 * width);
    paper.polyline(points.to_vec(), INK, width);
}
