//! From a figure to a scene of kuva, and from that to SVG, PNG and text.

use kuva::backend::terminal::TerminalBackend;
use kuva::plot::{
    LegendEntry, LegendPosition, LegendShape, LinePlot, LineStyle, MarkerShape, ScatterPlot,
};
use kuva::prelude::Theme;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::{Scene, render_multiple};

use crate::io::images::encode_png;
use crate::plots::paper::{PIXELS, pixels, plain, svg};
use crate::plots::ticks::{step_above, step_below};
use crate::plots::{Curve, Figure, Scale, Style};
use crate::{Error, Result};

/// The colours of Okabe and Ito but yellow, which is faint on white; the ones easiest to tell apart
/// come first.
const COLOURS: [&str; 7] =
    ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"];

const MARKERS: [MarkerShape; 5] = [
    MarkerShape::Circle,
    MarkerShape::Square,
    MarkerShape::Triangle,
    MarkerShape::Diamond,
    MarkerShape::Cross,
];

/// The size of an SVG, in its user units.
const SVG_SIZE: [f64; 2] = [860.0, 560.0];
/// The sizes of a terminal that can be drawn to, characters.
const COLUMNS: std::ops::RangeInclusive<usize> = 40..=400;
const ROWS: std::ops::RangeInclusive<usize> = 12..=200;
/// The height of a character cell of a terminal over its width, and the unit of length.
const CELL: [f64; 2] = [10.0, 20.0];
/// A colour that is legible on black and on white.
const ANY_GROUND: &str = "#888888";

impl Figure {
    /// Draws it as SVG (text that names a usual sans-serif font, white ground).
    ///
    /// # Errors
    /// [`Error::Parameter`] when no curve has a point that can be shown.
    pub fn to_svg(&self) -> Result<String> {
        Ok(svg(&self.scene(SVG_SIZE, Medium::Paper)?))
    }

    /// Draws it as PNG of so many pixels (white ground); twice as many pixels show the same plot
    /// finer.
    ///
    /// # Errors
    /// As [`Figure::to_svg`], and for a size outside 200 to 4096 pixels a side.
    pub fn to_png(&self, width: u32, height: u32) -> Result<Vec<u8>> {
        if !(PIXELS.contains(&width) && PIXELS.contains(&height)) {
            return Err(Error::Parameter(format!(
                "a plot of {width} x {height} pixels cannot be drawn; take {} to {} a side",
                PIXELS.start(),
                PIXELS.end()
            )));
        }
        let scale = f64::from(width) / SVG_SIZE[0];
        let scene = self.scene([width, height].map(|n| f64::from(n) / scale), Medium::Paper)?;
        let drawn = pixels(&scene, scale, [width, height])?;
        encode_png(width as usize, height as usize, drawn.as_raw())
    }

    /// Draws it with characters (Braille dots), so many columns and rows; without `coloured` no
    /// escape sequences are used.
    ///
    /// # Errors
    /// As [`Figure::to_svg`]; sizes outside 40 to 400 columns and 12 to 200 rows are brought into
    /// that range.
    pub fn to_terminal(&self, columns: usize, rows: usize, coloured: bool) -> Result<String> {
        let columns = columns.clamp(*COLUMNS.start(), *COLUMNS.end());
        let rows = rows.clamp(*ROWS.start(), *ROWS.end());
        let size = [columns as f64 * CELL[0], rows as f64 * CELL[1]];
        let scene = self.scene(size, Medium::Terminal(rows))?;
        let text = TerminalBackend::new(columns, rows).render_scene(&scene);
        let text = if coloured { text } else { without_escapes(&text) };
        Ok(text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n"))
    }

    fn scene(&self, [width, height]: [f64; 2], medium: Medium) -> Result<Scene> {
        let shown: Vec<Curve> = self.curves.iter().map(|c| self.showable(c)).collect();
        let plots: Vec<Plot> =
            shown.iter().enumerate().flat_map(|(i, c)| plots(c, i, medium)).collect();
        if plots.is_empty() {
            return Err(Error::Parameter(format!(
                "{}: there is nothing to plot: no point is finite{}",
                self.title,
                if self.has_logarithms() {
                    " and positive where an axis is logarithmic"
                } else {
                    ""
                }
            )));
        }
        let layout = Layout::auto_from_plots(&plots)
            .with_width(width)
            .with_height(height)
            .with_title(plain(&self.title))
            .with_x_label(plain(&self.axes[0].label))
            .with_y_label(plain(&self.axes[1].label));
        let layout = self.with_ranges(layout, &shown);
        let layout = with_legend(layout, &shown, medium);
        Ok(render_multiple(plots, medium.dress(layout)))
    }

    fn has_logarithms(&self) -> bool {
        self.axes.iter().any(|axis| axis.scale == Scale::Logarithmic)
    }

    /// Leaves out the points that the axes cannot show.
    fn showable(&self, curve: &Curve) -> Curve {
        let fits = |point: &[f64; 2]| {
            point
                .iter()
                .zip(&self.axes)
                .all(|(v, axis)| v.is_finite() && (axis.scale == Scale::Linear || *v > 0.0))
        };
        let keep: Vec<bool> = curve.points.iter().map(fits).collect();
        let errors = curve.errors.iter().zip(&curve.points).zip(&keep);
        let errors =
            errors.filter(|(_, keep)| **keep).map(|((e, p), _)| self.showable_error(*e, p[1]));
        Curve {
            points: curve.points.iter().zip(&keep).filter(|(_, k)| **k).map(|(p, _)| *p).collect(),
            errors: errors.collect(),
            ..curve.clone()
        }
    }

    /// Keeps an error bar finite and, on a logarithmic axis, above zero.
    fn showable_error(&self, [below, above]: [f64; 2], y: f64) -> [f64; 2] {
        let finite = |e: f64| if e.is_finite() { e.max(0.0) } else { 0.0 };
        match self.axes[1].scale {
            Scale::Linear => [finite(below), finite(above)],
            // A bar down to zero would be endless: it is drawn over one decade.
            Scale::Logarithmic => [finite(below).min(0.9 * y), finite(above)],
        }
    }

    /// Ends logarithmic axes a little outside what they show: whole decades would leave half of a
    /// plot empty.
    fn with_ranges(&self, mut layout: Layout, shown: &[Curve]) -> Layout {
        for (k, axis) in self.axes.iter().enumerate() {
            if axis.scale == Scale::Linear {
                continue;
            }
            let values = shown.iter().flat_map(|curve| extent(curve, k));
            let (low, high) =
                values.fold((f64::MAX, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
            let [low, high] = around(low, high);
            layout = if k == 0 {
                layout.with_log_x().with_x_axis_min(low).with_x_axis_max(high)
            } else {
                layout.with_log_y().with_y_axis_min(low).with_y_axis_max(high)
            };
        }
        layout
    }
}

/// Lists what an axis must reach: the points of a curve and, upwards, the ends of its error bars.
fn extent(curve: &Curve, axis: usize) -> impl Iterator<Item = f64> {
    let ends = curve.points.iter().zip(&curve.errors).filter(move |_| axis == 1);
    let ends = ends.flat_map(|(p, e)| [p[1] - e[0], p[1] + e[1]]);
    curve.points.iter().map(move |p| p[axis]).chain(ends)
}

/// Where a figure is drawn.
#[derive(Debug, Clone, Copy)]
enum Medium {
    Paper,
    /// With so many rows.
    Terminal(usize),
}

impl Medium {
    fn dress(self, layout: Layout) -> Layout {
        let Self::Terminal(rows) = self else {
            return layout.with_theme(Theme { grid_color: "#e3e3e3".into(), ..Theme::light() });
        };
        let colour = || ANY_GROUND.to_owned();
        layout
            .with_theme(Theme {
                axis_color: colour(),
                tick_color: colour(),
                text_color: colour(),
                grid_color: colour(),
                ..Theme::dark()
            })
            .with_show_grid(false)
            .with_legend_box(false)
            .with_term_rows(rows as u32)
    }

    /// Returns the colour of a curve; black and near-black vanish on dark terminals.
    fn colour(self, curve: usize) -> &'static str {
        let colour = COLOURS[curve % COLOURS.len()];
        match self {
            Self::Terminal(_) if colour == "#000000" => ANY_GROUND,
            _ => colour,
        }
    }
}

/// Makes what kuva draws for one curve: a line, markers, or both.
fn plots(curve: &Curve, number: usize, medium: Medium) -> Vec<Plot> {
    if curve.points.is_empty() {
        return Vec::new();
    }
    let colour = medium.colour(number);
    let data = || curve.points.iter().map(|p| (p[0], p[1]));
    let mut plots = Vec::new();
    if curve.style != Style::Points {
        let mut line = LinePlot::new().with_data(data()).with_color(colour).with_stroke_width(1.8);
        if is_broken(curve, number) {
            line = line.with_line_style(LineStyle::Dashed);
        }
        plots.push(line.into());
    }
    let with_markers = matches!(curve.style, Style::Both | Style::Points);
    // Braille dots are markers already; the terminal's own would hide the line.
    let line_only = matches!(medium, Medium::Terminal(_))
        && curve.style == Style::Both
        && curve.errors.is_empty();
    if with_markers && !line_only || !curve.errors.is_empty() {
        let size = if with_markers { 4.0 } else { 0.0 };
        let mut points = ScatterPlot::new()
            .with_data(data())
            .with_color(colour)
            .with_size(size)
            .with_marker(MARKERS[number % MARKERS.len()]);
        if !curve.errors.is_empty() {
            points = points.with_y_err_asymmetric(curve.errors.iter().map(|e| (e[0], e[1])));
        }
        plots.push(points.into());
    }
    plots
}

/// Whether a curve has a broken line: by its style, or because the colours have all been used.
fn is_broken(curve: &Curve, number: usize) -> bool {
    curve.style == Style::Dashed || number >= COLOURS.len()
}

fn with_legend(layout: Layout, shown: &[Curve], medium: Medium) -> Layout {
    let drawn =
        shown.iter().enumerate().filter(|(_, c)| !c.points.is_empty() && !c.name.is_empty());
    let entry = |(i, curve): (usize, &Curve)| LegendEntry {
        label: plain(&curve.name),
        color: medium.colour(i).to_owned(),
        shape: match (curve.style, medium) {
            (Style::Both | Style::Points, Medium::Paper) => {
                LegendShape::Marker(MARKERS[i % MARKERS.len()])
            }
            _ => LegendShape::Line,
        },
        dasharray: is_broken(curve, i).then(|| "6 4".to_owned()),
    };
    let entries: Vec<LegendEntry> = drawn.map(entry).collect();
    let Some(longest) = entries.iter().map(|e| e.label.chars().count()).max() else {
        return layout;
    };
    let layout = match medium {
        Medium::Paper => layout,
        Medium::Terminal(_) => layout.with_legend_width((longest + 5) as f64 * CELL[0]),
    };
    layout.with_legend_position(LegendPosition::OutsideRightTop).with_legend_entries(entries)
}

/// Returns the ends of a logarithmic axis: room for a marker around what it shows, or, where that
/// is so little that no tick might be in it, the steps around.
fn around(low: f64, high: f64) -> [f64; 2] {
    let ratio = high / low;
    if ratio > 10.0 && ratio.is_finite() {
        let room = ratio.powf(0.04);
        [low / room, high * room]
    } else {
        [step_below(low), step_above(high)]
    }
}

/// Removes the colour sequences, ESC [ ... m.
fn without_escapes(text: &str) -> String {
    let mut pieces = text.split('\x1b');
    let first = pieces.next().unwrap_or("").to_owned();
    pieces.fold(first, |plain, piece| plain + piece.split_once('m').map_or("", |(_, rest)| rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_are_removed() {
        assert_eq!(without_escapes("a\x1b[38;2;1;2;3mb\x1b[0m c"), "ab c");
    }
}
