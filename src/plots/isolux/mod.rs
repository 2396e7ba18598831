//! An isolux picture: a grid of sensors on a plane, each a cell in false colour with its value, and
//! the lines of equal illuminance.

mod layout;

use self::layout::{Axis, Layout, NAMES, along_axis, direction, draw_axes};
use crate::io::images::NOT_FINITE;
use crate::plots::isolines::Line;
use crate::plots::labels::{Label, Placing};
use crate::plots::legend::{Legend, Swatch, draw_isoline, draw_swatch};
use crate::plots::palette::is_light;
use crate::plots::paper::{
    Align, Area, BLACK, FRAME, INK, Paper, Rgb8, WHITE, plate_size, text_width,
};
use crate::plots::refinement::refined;
use crate::plots::{ColourScale, Lattice, Tally, ticks};
use crate::{Error, Result};

/// The pixels of a PNG for one unit.
const SCALE: f64 = 2.0;
/// The sizes of text: of the title, of what explains, and of labels on lines.
const TITLE: f64 = 18.0;
const FONT: f64 = 14.0;
const LABEL: f64 = 12.0;
/// Lines shorter than this are not drawn.
const SHORTEST: f64 = 8.0;
/// Isolines are drawn on a grid refined to about this many nodes.
const FINE: usize = 60_000;
/// Where copies of a text make its rim.
const RIM: [[f64; 2]; 8] = [
    [-1.5, 0.0],
    [1.5, 0.0],
    [0.0, -1.5],
    [0.0, 1.5],
    [-1.0, -1.0],
    [1.0, -1.0],
    [-1.0, 1.0],
    [1.0, 1.0],
];

/// Holds the sensors of a grid, what they measured, and how that is shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Isolux {
    /// The name above the picture.
    pub title: String,
    /// The unit of the values.
    pub unit: String,
    /// Where the sensors stand.
    pub lattice: Lattice,
    /// The value of each sensor, in the order of the lattice's `nodes`; `None` where it does not
    /// count: its cell is hatched.
    pub values: Vec<Option<f64>>,
    /// The colours, and the values of the isolines.
    pub scale: ColourScale,
    /// Whether the cells of the largest and the least value are marked.
    pub extremes: bool,
}

impl Isolux {
    /// Draws it as SVG.
    ///
    /// # Errors
    /// [`Error::Parameter`] when there is not one value for each sensor of the lattice.
    pub fn to_svg(&self) -> Result<String> {
        Ok(self.drawn()?.svg(""))
    }

    /// Draws it as PNG, two pixels for a unit of the SVG.
    ///
    /// # Errors
    /// As [`Isolux::to_svg`]; [`Error::Numeric`] with the encoder's complaint.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        self.drawn()?.png(SCALE)
    }

    /// Returns what the values that count come to; places are those of sensors.
    pub fn tally(&self) -> Tally {
        Tally::of(&self.counting())
    }

    fn counting(&self) -> impl Iterator<Item = (usize, f64)> + Clone {
        self.values.iter().enumerate().filter_map(|(i, v)| v.map(|v| (i, v)))
    }

    fn drawn(&self) -> Result<Paper> {
        let [columns, rows] = self.lattice.size;
        let nodes = &self.lattice.nodes;
        if nodes.len() != self.values.len() || nodes.iter().any(|n| *n >= columns * rows) {
            return Err(Error::Parameter(format!(
                "{} values do not fit the {} sensors of a grid",
                self.values.len(),
                nodes.len()
            )));
        }
        let tally = self.tally();
        let legend = self.legend(&tally);
        let axes = [0, 1].map(|k| Axis::of(&self.lattice, k));
        let layout = Layout::of(&self.lattice, &axes);
        let gap = 1.8 * FONT;
        let plot = layout.plot;
        let tall = plot.height.max(legend.least_height());
        let heading = [
            (TITLE, 20.0, INK, self.title.clone()),
            (FONT, 43.0, INK, self.summary(&tally)),
            (LABEL, 63.0, FRAME, self.situation()),
        ];
        // What explains is measured as if it were as large as the summary.
        let widths = heading.iter().map(|(size, _, _, text)| text_width(text, size.max(FONT)));
        let wide = widths.fold(0.0, f64::max) + 6.0 * FONT;
        let width = (plot.right() + gap + legend.width()).max(wide) + FONT;
        let height = plot.y + tall.max(plot.height + 4.0 * FONT) + FONT;
        let mut paper = Paper::new(width.ceil(), height.ceil());
        for (size, y, ink, text) in &heading {
            paper.text([plot.x, *y], Align::Left, *size, *ink, text);
        }
        for (node, value) in nodes.iter().zip(&self.values) {
            let swatch = value.map_or(Swatch::Hatched, |v| {
                Swatch::Colour(self.scale.colour(v).unwrap_or(NOT_FINITE))
            });
            draw_swatch(&mut paper, layout.cell(*node), swatch);
        }
        draw_axes(&mut paper, &layout, &axes);
        self.draw_lines_and_values(&mut paper, &layout, &tally);
        legend.draw(&mut paper, [plot.right() + gap, plot.y], tall);
        Ok(paper)
    }

    fn legend(&self, tally: &Tally) -> Legend<'_> {
        let values: Vec<f64> = self.counting().map(|(_, v)| v).collect();
        let hatched = self.values.iter().any(Option::is_none);
        let hatched = hatched.then_some((Swatch::Hatched, "behind"));
        let non_finite =
            (tally.not_finite > 0).then_some((Swatch::Colour(NOT_FINITE), "not finite"));
        Legend {
            scale: &self.scale,
            unit: &self.unit,
            outside: self.scale.outside(&values).map(|n| n > 0),
            notes: hatched.into_iter().chain(non_finite).collect(),
            font: FONT,
        }
    }

    /// Writes what the values come to, as lighting engineers ask for it.
    fn summary(&self, tally: &Tally) -> String {
        let (Some((_, least)), Some((_, largest))) = (tally.least, tally.largest) else {
            return "no value counts".to_owned();
        };
        let [mean, low, high] = [tally.mean, least, largest].map(|v| ticks::short(v, 3));
        let unit = &self.unit;
        let text = format!("mean {mean} {unit},  least {low} {unit},  largest {high} {unit}");
        if tally.mean > 0.0 { format!("{text},  U0 {:.2}", least / tally.mean) } else { text }
    }

    /// Says where the grid is and from where it is seen.
    fn situation(&self) -> String {
        let Lattice { size: [columns, rows], origin, right, up, .. } = self.lattice;
        let normal = right.cross(up);
        let place = match along_axis(normal) {
            Some((axis, sign)) => {
                let height = ticks::short(origin[axis], 6);
                let from = match (axis, sign > 0.0) {
                    (2, true) => "above".to_owned(),
                    (2, false) => "below".to_owned(),
                    (_, forward) => {
                        format!("{}{}", if forward { '+' } else { '\u{2212}' }, NAMES[axis])
                    }
                };
                format!("at {} = {height} m, seen from {from}", NAMES[axis])
            }
            None => format!("facing {}", direction(normal)),
        };
        let slanting = [right, up].iter().any(|d| along_axis(*d).is_none());
        let zero =
            if slanting { format!("; 0 is at {} m", direction(origin)) } else { String::new() };
        format!("{columns} \u{d7} {rows} sensors {place}{zero}")
    }

    fn draw_lines_and_values(&self, paper: &mut Paper, layout: &Layout, tally: &Tally) {
        let values = self.written(layout, tally);
        let mut placing = Placing {
            frame: layout.plot,
            soft: values.iter().map(|value| value.area).collect(),
            taken: Vec::new(),
            reach: 0.9 * layout.plot.width.max(layout.plot.height),
            shortest: SHORTEST,
            font: LABEL,
        };
        let found = [tally.largest, tally.least].into_iter().flatten().filter(|_| self.extremes);
        let mut extremes = Vec::new();
        for (sensor, value) in found {
            let cell = layout.cell(self.lattice.nodes[sensor]);
            // Its number stays in sight: in the middle of the cell, or on a plate.
            if values.is_empty() {
                let text = text(value, tally);
                let size = plate_size(&text, LABEL);
                let middle = layout.beside(cell, size);
                placing.taken.extend([cell, Area::about(middle, size)]);
                extremes.push((cell, Some((middle, text))));
            } else {
                placing.taken.push(inset(cell, 0.25 * cell.width.min(cell.height)));
                extremes.push((cell, None));
            }
        }
        let (lines, labels) = self.lines(&mut placing, layout);
        for line in &lines {
            draw_isoline(paper, line, 1.3);
        }
        for (cell, _) in &extremes {
            paper.frame(inset(*cell, 1.0), BLACK, 2.0);
            paper.frame(inset(*cell, 2.8), WHITE, 1.6);
        }
        for value in values {
            // A value under the label of a line would be read as neither.
            let under = |(at, text): &Label| {
                Area::about(*at, plate_size(text, LABEL)).overlap(&value.area) > 0.0
            };
            if !labels.iter().any(under) {
                let within = |p: &[f64; 2]| value.area.holds(&Area::about(*p, [0.0; 2]));
                value.draw(paper, lines.iter().flatten().any(within));
            }
        }
        for (middle, text) in labels.into_iter().chain(extremes.into_iter().filter_map(|e| e.1)) {
            paper.plate(middle, LABEL, &text);
        }
    }

    /// Lists the values that are written in their cells; none where cells are too small.
    fn written(&self, layout: &Layout, tally: &Tally) -> Vec<Written> {
        let finite = self.counting().filter(|(_, v)| v.is_finite());
        let texts: Vec<_> = finite.map(|(i, v)| (i, v, text(v, tally))).collect();
        let Some(font) = layout.value_font(texts.iter().map(|(_, _, text)| text.as_str())) else {
            return Vec::new();
        };
        let written = |(sensor, value, text): (usize, f64, String)| {
            let ground = self.scale.colour(value)?;
            let at = layout.middle(self.lattice.nodes[sensor]);
            let area = Area::about(at, [text_width(&text, font), font]);
            Some(Written { area, at, font, text, ground })
        };
        texts.into_iter().filter_map(written).collect()
    }

    /// Returns the isolines, and where their labels go.
    fn lines(&self, placing: &mut Placing, layout: &Layout) -> (Vec<Line>, Vec<Label>) {
        let mut field = vec![f64::NAN; layout.columns * layout.rows];
        for (node, value) in self.lattice.nodes.iter().zip(&self.values) {
            field[*node] = self.scale.evened(value.unwrap_or(f64::NAN));
        }
        let times = ((FINE / field.len().max(1)) as f64).sqrt().clamp(1.0, 12.0) as usize;
        let (columns, fine) = refined(layout.columns, &field, times);
        let place = |p: [f64; 2]| layout.place(p.map(|x| x / times as f64));
        let levels = self.reached_levels().into_iter();
        placing.isolines(&self.scale, levels, (columns, &fine), place)
    }

    /// Lists the levels that sensors reach: what is interpolated between them may exceed them all,
    /// and no line claims more than was measured.
    fn reached_levels(&self) -> Vec<(f64, String)> {
        let Tally { least: Some((_, least)), largest: Some((_, largest)), .. } = self.tally()
        else {
            return Vec::new();
        };
        let levels = self.scale.numbered_levels();
        levels.filter(|(level, _)| (least..=largest).contains(level)).collect()
    }
}

/// Writes a value for its cell.
fn text(value: f64, tally: &Tally) -> String {
    ticks::beside(value, tally.largest.map_or(1.0, |(_, v)| v))
}

/// A value in its cell.
struct Written {
    area: Area,
    at: [f64; 2],
    font: f64,
    text: String,
    /// The colour of the cell.
    ground: Rgb8,
}

impl Written {
    /// Writes it; with a rim of the colour of its cell where a line would cross it.
    fn draw(&self, paper: &mut Paper, rim: bool) {
        let [x, y] = self.at;
        for [right, down] in RIM.into_iter().filter(|_| rim) {
            let at = [x + right, y + down];
            paper.text(at, Align::Middle, self.font, self.ground, &self.text);
        }
        let ink = if is_light(self.ground) { BLACK } else { WHITE };
        paper.text(self.at, Align::Middle, self.font, ink, &self.text);
    }
}

fn inset(area: Area, by: f64) -> Area {
    let [width, height] = [area.width, area.height].map(|n| (n - 2.0 * by).max(0.5));
    Area { x: area.x + by, y: area.y + by, width, height }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::plots::ScaleOptions;

    fn isolux(columns: usize, rows: usize, value: impl Fn(usize) -> Option<f64>) -> Isolux {
        let at =
            |i: usize| DVec3::new((i % columns) as f64 * 0.5, (i / columns) as f64 * 0.5, 0.75);
        let points: Vec<DVec3> = (0..columns * rows).map(at).collect();
        let lattice = Lattice::of(&points, DVec3::Z).expect("a grid");
        let values: Vec<Option<f64>> = (0..points.len()).map(value).collect();
        let known: Vec<f64> = values.iter().flatten().copied().collect();
        let scale = ScaleOptions::default().fitted(&known, 1.0).expect("a scale");
        let [title, unit] = ["desk", "lx"].map(String::from);
        Isolux { title, unit, lattice, values, scale, extremes: false }
    }

    #[test]
    fn dark_constant_non_finite_and_hidden_grids_are_drawn() {
        for value in [Some(0.0), Some(5.0), Some(f64::NAN), Some(f64::INFINITY), None] {
            let mut grid = isolux(3, 2, |_| value);
            grid.extremes = true;
            assert!(grid.to_svg().expect("drawn").starts_with("<svg"), "{value:?}");
        }
        let mut non_finite = isolux(3, 2, |i| (i != 1).then_some(f64::NAN));
        non_finite.extremes = true;
        let image = image::load_from_memory(&non_finite.to_png().expect("drawn")).expect("a PNG");
        assert!(image.into_rgb8().pixels().any(|p| p.0 == NOT_FINITE));
        let mut short = isolux(3, 2, |_| Some(1.0));
        short.values.pop();
        assert!(short.to_svg().is_err());
    }

    #[test]
    fn values_summary_axes_and_lines_are_written() {
        let svg = isolux(6, 4, |i| Some(100.0 + 20.0 * i as f64)).to_svg().expect("drawn");
        for words in [
            "desk",
            "mean 330 lx",
            "least 100 lx",
            "U0 0.30",
            "6 \u{d7} 4 sensors at z = 0.75 m, seen from above",
            ">x, m<",
            ">y, m<",
            ">560<",
            ">400<",
        ] {
            assert!(svg.contains(words), "{words}");
        }
    }

    #[test]
    fn no_line_lies_beyond_the_values_of_the_sensors() {
        let levels = |top: f64| {
            let mut grid = isolux(5, 5, |i| Some(if i == 12 { top } else { 150.0 }));
            let wish = ScaleOptions { high: Some(500.0), ..Default::default() };
            grid.scale = wish.fitted(&[], 1.0).expect("a scale");
            grid.reached_levels().into_iter().map(|(level, _)| level).collect::<Vec<_>>()
        };
        assert_eq!(levels(399.0), [200.0, 300.0]);
        assert_eq!(levels(400.0), [200.0, 300.0, 400.0]);
        assert_eq!(levels(f64::NAN), [0.0; 0]);
    }

    #[test]
    fn what_does_not_count_is_hatched_and_left_out() {
        let grid = isolux(4, 4, |i| (i != 5).then_some(if i == 6 { f64::NAN } else { 7.0 }));
        let tally = grid.tally();
        assert_eq!((tally.finite, tally.not_finite, tally.mean), (14, 1, 7.0));
        let svg = grid.to_svg().expect("drawn");
        assert!(svg.contains(">behind<") && svg.contains(">not finite<"));
        // Places are those of sensors, not of what counts.
        let grid = isolux(2, 2, |i| (i != 0).then_some(i as f64));
        assert_eq!((grid.tally().least, grid.tally().largest), (Some((1, 1.0)), Some((3, 3.0))));
    }

    #[test]
    fn cells_too_small_for_their_values_have_none() {
        let svg = isolux(60, 40, |i| Some(1000.0 + i as f64)).to_svg().expect("drawn");
        assert!(!svg.contains(">1234<"));
        let long = isolux(400, 2, |i| Some(i as f64)).to_svg().expect("drawn");
        assert!(long.contains(">lx<"));
    }

    #[test]
    fn tilted_grids_say_along_what_they_are_measured() {
        let mut grid = isolux(3, 3, |i| Some(i as f64));
        let turn = glam::DQuat::from_rotation_z(0.3) * glam::DQuat::from_rotation_x(1.0);
        let points: Vec<DVec3> =
            (0..9).map(|i| turn * DVec3::new(f64::from(i % 3), f64::from(i / 3), 0.0)).collect();
        grid.lattice = Lattice::of(&points, turn * DVec3::Z).expect("a grid");
        let svg = grid.to_svg().expect("drawn");
        assert!(svg.contains("along (0.955, 0.296, 0), m") && svg.contains("0 is at (0, 0, 0) m"));
    }
}
