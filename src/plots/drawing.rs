//! From a figure to a scene of kuva, and from that to SVG, PNG and text.

use kuva::TickFormat;
use kuva::backend::terminal::TerminalBackend;
use kuva::plot::{
    LegendEntry, LegendPosition, LegendShape, LinePlot, LineStyle, MarkerShape, ScatterPlot,
};
use kuva::prelude::Theme;
use kuva::render::layout::Layout;
use kuva::render::plots::Plot;
use kuva::render::render::{Primitive, Scene, TextAnchor, render_multiple};

use crate::plots::paper::{Align, INK, Paper, plain};
use crate::plots::ticks::{short, step_above, step_below};
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

/// The size of an SVG, in its user units, and the pixels of a PNG for one of them.
const SVG_SIZE: [f64; 2] = [860.0, 560.0];
const SCALE: f64 = 2.0;
/// The width and the height of a character cell of a terminal.
const CELL: [f64; 2] = [10.0, 20.0];
/// The rows of a terminal above the axes: the title is in the second, a label in the third.
const HEAD: f64 = 3.0;
/// A colour that is legible on black and on white.
const ANY_GROUND: &str = "#888888";

impl Figure {
    /// Draws it as SVG (text that names a usual sans-serif font, white ground).
    ///
    /// # Errors
    /// [`Error::Parameter`] when no curve has a point that can be shown.
    pub fn to_svg(&self) -> Result<String> {
        Ok(Paper(self.scene(SVG_SIZE, Medium::Paper)?).svg(""))
    }

    /// Draws it as PNG, two pixels for a unit of the SVG.
    ///
    /// # Errors
    /// As [`Figure::to_svg`]; [`Error::Numeric`] with the encoder's complaint.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        Paper(self.scene(SVG_SIZE, Medium::Paper)?).png(SCALE)
    }

    /// Draws it with characters (Braille dots), so many columns and rows; without `coloured` no
    /// escape sequences are used.
    ///
    /// # Errors
    /// As [`Figure::to_svg`]; sizes outside 40 to 400 columns and 12 to 200 rows are brought into
    /// that range.
    pub fn to_terminal(&self, columns: usize, rows: usize, coloured: bool) -> Result<String> {
        let (columns, rows) = (columns.clamp(40, 400), rows.clamp(12, 200));
        let size = [columns as f64 * CELL[0], rows as f64 * CELL[1]];
        // kuva leaves room for numbers of its own font, narrower than these: they are counted.
        let draft = self.scene(size, Medium::Terminal { rows, numbers: 0 })?;
        let numbers = draft.elements.iter().filter_map(|element| match element {
            Primitive::Text { anchor: TextAnchor::End, content, .. } => {
                Some(content.chars().count())
            }
            _ => None,
        });
        let numbers = numbers.max().unwrap_or(0);
        let mut paper = Paper(self.scene(size, Medium::Terminal { rows, numbers })?);
        let above = (HEAD - 0.5) * CELL[1];
        paper.text([0.0, above], Align::Left, CELL[0], INK, &self.axes[1].label);
        let text = TerminalBackend::new(columns, rows).render_scene(&paper.0);
        let text = if coloured { text } else { without_escapes(&text) };
        Ok(text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n"))
    }

    /// Whether no point can be shown: none is finite, and positive where an axis is logarithmic.
    pub fn is_empty(&self) -> bool {
        self.curves.iter().all(|curve| self.showable(curve).points.is_empty())
    }

    fn scene(&self, [width, height]: [f64; 2], medium: Medium) -> Result<Scene> {
        let shown: Vec<Curve> = self.curves.iter().map(|c| self.showable(c)).collect();
        let plots: Vec<Plot> =
            shown.iter().enumerate().flat_map(|(i, c)| plots(c, i, medium)).collect();
        if plots.is_empty() {
            let logarithmic = self.axes.iter().any(|axis| axis.scale == Scale::Logarithmic);
            let condition =
                if logarithmic { " and positive where an axis is logarithmic" } else { "" };
            return Err(Error::Parameter(format!(
                "{}: there is nothing to plot: no point is finite{condition}",
                self.title
            )));
        }
        let layout = Layout::auto_from_plots(&plots)
            .with_width(width)
            .with_height(height)
            .with_title(plain(&self.title))
            .with_x_label(plain(&self.axes[0].label));
        let layout = with_legend(self.with_ranges(layout, &shown), &shown, medium);
        let layout = match medium {
            Medium::Paper => layout
                .with_y_label(plain(&self.axes[1].label))
                .with_theme(Theme { grid_color: "#e3e3e3".into(), ..Theme::light() }),
            Medium::Terminal { rows, numbers } => for_terminal(layout, rows, numbers),
        };
        Ok(render_multiple(plots, layout))
    }

    /// Leaves out the points that the axes cannot show; error bars are finite and, on a logarithmic
    /// axis, above zero.
    fn showable(&self, curve: &Curve) -> Curve {
        let is_linear = self.axes.each_ref().map(|axis| axis.scale == Scale::Linear);
        let fits = |k: usize, v: f64| v.is_finite() && (is_linear[k] || v > 0.0);
        let shown = |i: &usize| fits(0, curve.points[*i][0]) && fits(1, curve.points[*i][1]);
        let kept: Vec<usize> = (0..curve.points.len()).filter(shown).collect();
        let error = |i: &usize| {
            let ends = curve.errors.get(*i)?;
            let [below, above] = ends.map(|e| if e.is_finite() { e.max(0.0) } else { 0.0 });
            // A bar down to zero would be endless: it is drawn over one decade.
            let most = if is_linear[1] { f64::INFINITY } else { 0.9 * curve.points[*i][1] };
            Some([below.min(most), above])
        };
        Curve {
            points: kept.iter().map(|i| curve.points[*i]).collect(),
            errors: kept.iter().filter_map(error).collect(),
            ..curve.clone()
        }
    }

    /// Ends logarithmic axes a little outside what they show: whole decades would leave half of a
    /// plot empty.
    fn with_ranges(&self, mut layout: Layout, shown: &[Curve]) -> Layout {
        for k in (0..2).filter(|k| self.axes[*k].scale == Scale::Logarithmic) {
            let values = shown.iter().flat_map(|curve| extent(curve, k));
            let ends = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
            let (low, high) = values.fold((f64::MAX, 0.0), ends);
            let [low, high] = around(low, high);
            let format = TickFormat::Custom(std::sync::Arc::new(power));
            if k == 0 {
                layout = layout.with_log_x().with_x_axis_min(low).with_x_axis_max(high);
                layout.x_tick_format = format;
            } else {
                layout = layout.with_log_y().with_y_axis_min(low).with_y_axis_max(high);
                layout.y_tick_format = format;
                // kuva leaves room for the numbers of this range.
                layout.y_range = (low, high);
            }
        }
        layout
    }
}

/// Writes a number of a logarithmic axis, never longer than kuva does.
fn power(value: f64) -> String {
    if value < 0.01 { format!("{value:.0e}") } else { short(value, 1) }
}

/// Lists what an axis must reach: the points of a curve and, upwards, the ends of its error bars.
fn extent(curve: &Curve, axis: usize) -> impl Iterator<Item = f64> {
    let ends = curve.points.iter().zip(&curve.errors).filter(move |_| axis == 1);
    let ends = ends.flat_map(|(p, e)| [p[1] - e[0], p[1] + e[1]]);
    curve.points.iter().map(move |p| p[axis]).chain(ends)
}

/// Where a figure is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Medium {
    Paper,
    /// Of so many rows, with room for numbers of so many characters.
    Terminal {
        rows: usize,
        numbers: usize,
    },
}

impl Medium {
    /// Returns the colour of a curve; black and near-black vanish on dark terminals.
    fn colour(self, curve: usize) -> &'static str {
        match COLOURS[curve % COLOURS.len()] {
            "#000000" if self != Self::Paper => ANY_GROUND,
            colour => colour,
        }
    }
}

fn for_terminal(mut layout: Layout, rows: usize, numbers: usize) -> Layout {
    // The numbers, then a tick and the axis.
    layout.force_margin_left = Some((numbers as f64 + 1.4) * CELL[0]);
    layout.force_margin_top = Some((HEAD + 0.25) * CELL[1]);
    let colour = || ANY_GROUND.to_owned();
    let theme = Theme {
        axis_color: colour(),
        tick_color: colour(),
        text_color: colour(),
        grid_color: colour(),
        ..Theme::dark()
    };
    let layout = layout.with_theme(theme).with_show_grid(false).with_legend_box(false);
    layout.with_term_rows(rows as u32)
}

/// Makes what kuva draws for one curve: a line, markers, or both.
fn plots(curve: &Curve, number: usize, medium: Medium) -> Vec<Plot> {
    let mut plots = Vec::new();
    if curve.points.is_empty() {
        return plots;
    }
    let colour = medium.colour(number);
    let data = || curve.points.iter().map(|p| (p[0], p[1]));
    if curve.style != Style::Points {
        // The colours have all been used.
        let again = number >= COLOURS.len();
        let style = if again { LineStyle::Dashed } else { LineStyle::Solid };
        let line = LinePlot::new().with_data(data()).with_color(colour).with_stroke_width(1.8);
        plots.push(line.with_line_style(style).into());
    }
    // Braille dots are markers already; the terminal's own would hide the line.
    let marked = match curve.style {
        Style::Both => medium == Medium::Paper || !curve.errors.is_empty(),
        Style::Line => false,
        Style::Points => true,
    };
    if marked || !curve.errors.is_empty() {
        let points = ScatterPlot::new().with_data(data()).with_color(colour);
        let points = points.with_size(if marked { 4.0 } else { 0.0 });
        let points = points.with_marker(MARKERS[number % MARKERS.len()]);
        let errors = curve.errors.iter().map(|e| (e[0], e[1]));
        plots.push(points.with_y_err_asymmetric(errors).into());
    }
    plots
}

fn with_legend(layout: Layout, shown: &[Curve], medium: Medium) -> Layout {
    let named = |(_, curve): &(usize, &Curve)| !curve.points.is_empty() && !curve.name.is_empty();
    let entry = |(i, curve): (usize, &Curve)| LegendEntry {
        label: plain(&curve.name),
        color: medium.colour(i).to_owned(),
        shape: if curve.style == Style::Line || medium != Medium::Paper {
            LegendShape::Line
        } else {
            LegendShape::Marker(MARKERS[i % MARKERS.len()])
        },
        dasharray: (i >= COLOURS.len()).then(|| "6 4".to_owned()),
    };
    let entries: Vec<LegendEntry> = shown.iter().enumerate().filter(named).map(entry).collect();
    let Some(longest) = entries.iter().map(|e| e.label.chars().count()).max() else {
        return layout;
    };
    let layout = layout.with_legend_position(LegendPosition::OutsideRightTop);
    let layout = layout.with_legend_entries(entries);
    match medium {
        Medium::Paper => layout,
        Medium::Terminal { .. } => layout.with_legend_width((longest + 5) as f64 * CELL[0]),
    }
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
    use crate::plots::Axis;

    #[test]
    fn escapes_are_removed() {
        assert_eq!(without_escapes("a\x1b[38;2;1;2;3mb\x1b[0m c"), "ab c");
    }

    #[test]
    fn numbers_and_labels_of_axes_stand_apart_and_are_whole() {
        let points = vec![[1.0, 2e-5], [20.0, 5e-3]];
        for (axis, numbers) in [
            (Axis::logarithmic("power, m2"), &["2e-5", "1e-4", "5e-3"][..]),
            (Axis::linear("power, m2"), &["1e-3", "3e-3"]),
        ] {
            let curve = Curve::new("", points.clone());
            let figure = Figure::new("F", [Axis::linear("x"), axis], vec![curve]);
            let text = figure.to_terminal(60, 30, false).expect("drawn");
            for number in numbers {
                let tick = format!("{number}\u{2576}");
                assert!(text.lines().any(|line| line.trim_start().starts_with(&tick)), "{text}");
            }
            assert!(text.lines().any(|line| line == "power, m2"), "{text}");
        }
    }
}
