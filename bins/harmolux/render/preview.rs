//! The picture so far, drawn on the terminal in half blocks: a character shows two pixels, one
//! above the other, by its own colour and that of its ground.

use std::env;
use std::fmt::Write;
use std::io::{self, IsTerminal};

use harmolux::estimators::Rendering;
use harmolux::io::images::shown;
use harmolux::math::Rgb;
use harmolux::scene::Display;

use crate::common::progress::Meter;
use crate::common::say;

/// Draws pictures of one size on the terminal.
pub(crate) struct Preview {
    display: Display,
    /// Columns and rows of characters.
    size: [usize; 2],
    true_colour: bool,
}

/// What stays free below the picture: the bar, and a line for the next command.
const FREE_ROWS: usize = 3;

impl Preview {
    /// Returns what draws a picture of so many pixels, as large as the terminal lets it; `None`,
    /// which is said, where stderr is none.
    pub(crate) fn new([width, height]: [usize; 2], display: Display) -> Option<Self> {
        let terminal = terminal_size::terminal_size_of(io::stderr());
        let Some((columns, rows)) = terminal.filter(|_| io::stderr().is_terminal()) else {
            say::warning("--preview: no preview, since stderr is not a terminal");
            return None;
        };
        let size = fitted([width, height], [columns.0.into(), rows.0.into()]);
        let true_colour = env::var("COLORTERM").is_ok_and(|v| v == "truecolor" || v == "24bit");
        Some(Self { display, size, true_colour })
    }

    /// Draws what there is above the bar.
    pub(crate) fn show(&self, rendering: &Rendering, meter: &Meter) {
        if let Some(text) = self.drawn(rendering) {
            meter.above(text);
        }
    }

    /// Draws the picture where it stays.
    pub(crate) fn leave(&self, rendering: &Rendering) {
        if let Some(text) = self.drawn(rendering) {
            eprint!("{text}");
        }
    }

    fn drawn(&self, rendering: &Rendering) -> Option<String> {
        let pixels = rendering.film.image();
        let factor = self.display.exposure.factor(&pixels).ok()?;
        let [columns, rows] = self.size;
        let small = averaged(&pixels, rendering.film.size(), [columns, 2 * rows]);
        Some(blocks(&shown(&small, factor, self.display.tone), columns, self.true_colour))
    }
}

/// Returns how many columns and rows of characters a picture takes, whose pixels are square: a
/// character is as high as two of them.
fn fitted([width, height]: [usize; 2], [columns, rows]: [usize; 2]) -> [usize; 2] {
    let room = [columns.max(1) as f64, 2.0 * rows.saturating_sub(FREE_ROWS).max(1) as f64];
    let scale = (room[0] / width as f64).min(room[1] / height as f64).min(1.0);
    [(scale * width as f64) as usize, (0.5 * scale * height as f64) as usize].map(|n| n.max(1))
}

/// Returns a picture of fewer pixels, each the mean of those it covers that are finite.
fn averaged(pixels: &[Rgb], [width, height]: [usize; 2], [columns, rows]: [usize; 2]) -> Vec<Rgb> {
    let range = |i: usize, count: usize, of: usize| {
        let first = i * of / count;
        first..((i + 1) * of / count).max(first + 1)
    };
    let mean = |row: usize, column: usize| {
        let lines = range(row, rows, height).flat_map(|y| {
            let line = range(column, columns, width);
            line.map(move |x| pixels[y.min(height - 1) * width + x])
        });
        let finite = lines.filter(|p| p.is_finite());
        let (count, sum) = finite.fold((0_u32, Rgb::BLACK), |(count, sum), p| (count + 1, sum + p));
        if count == 0 { Rgb::BLACK } else { sum * (1.0 / f64::from(count)) }
    };
    (0..rows).flat_map(|row| (0..columns).map(move |column| mean(row, column))).collect()
}

/// Draws pixels, an even number of rows, as lines of half blocks.
fn blocks(pixels: &[[u8; 3]], columns: usize, true_colour: bool) -> String {
    let colour = |[r, g, b]: [u8; 3]| {
        // Else the cube of 6 x 6 x 6 colours of terminals that have 256.
        let level = |v: u8| (u16::from(v) * 5 + 127) / 255;
        if true_colour {
            format!("2;{r};{g};{b}")
        } else {
            format!("5;{}", 16 + 36 * level(r) + 6 * level(g) + level(b))
        }
    };
    let mut text = String::new();
    for pair in pixels.chunks_exact(2 * columns) {
        let (above, below) = pair.split_at(columns);
        let mut last = None;
        for (above, below) in above.iter().zip(below) {
            let now = [*above, *below].map(colour);
            if last.as_ref() != Some(&now) {
                let _ = write!(text, "\x1b[38;{};48;{}m", now[0], now[1]);
            }
            text.push('\u{2580}');
            last = Some(now);
        }
        text.push_str("\x1b[0m\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_fit_and_keep_their_shape() {
        assert_eq!(fitted([640, 320], [80, 24]), [80, 20]);
        assert_eq!(fitted([640, 320], [200, 24]), [84, 21]);
        assert_eq!(fitted([8, 4], [80, 24]), [8, 2]);
        assert_eq!(fitted([10_000, 1], [80, 2]), [80, 1]);
        assert_eq!(fitted([1, 1], [0, 0]), [1, 1]);
    }

    #[test]
    fn small_pictures_are_means() {
        let pixels = [1.0, 3.0, f64::NAN, 5.0, 2.0, 2.0, 7.0, 9.0].map(Rgb::grey);
        let small = averaged(&pixels, [4, 2], [2, 1]);
        assert_eq!(small, [2.0, 7.0].map(Rgb::grey));
        assert_eq!(averaged(&[Rgb::WHITE], [1, 1], [1, 2]), [Rgb::WHITE; 2]);
    }

    #[test]
    fn a_character_has_two_pixels() {
        let pixels = [[255, 0, 0], [0, 0, 0]];
        assert_eq!(blocks(&pixels, 1, true), "\x1b[38;2;255;0;0;48;2;0;0;0m\u{2580}\x1b[0m\n");
        assert_eq!(blocks(&pixels, 1, false), "\x1b[38;5;196;48;5;16m\u{2580}\x1b[0m\n");
    }
}
