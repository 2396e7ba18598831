//! Where things are on an isolux picture, and its axes.

use glam::DVec3;

use crate::plots::Lattice;
use crate::plots::isolux::FONT;
use crate::plots::paper::{Align, Area, FRAME, INK, Paper, text_width};
use crate::plots::ticks;

/// The room for the grid, in units of the SVG.
const ROOM: [f64; 2] = [900.0, 660.0];
/// The limits for the size of values in cells.
const VALUES: [f64; 2] = [8.0, 15.0];

pub(super) const NAMES: [char; 3] = ['x', 'y', 'z'];

/// Returns along which axis of space a direction is, and whether with it (1) or against it (-1).
pub(super) fn along_axis(direction: DVec3) -> Option<(usize, f64)> {
    (0..3).find(|k| direction[*k].abs() > 1.0 - 1e-9).map(|k| (k, direction[k].signum()))
}

pub(super) fn direction(d: DVec3) -> String {
    let [x, y, z] = d.to_array().map(|v| ticks::short((v * 1e3).round() / 1e3, 6));
    format!("({x}, {y}, {z})")
}

/// An axis of the picture: what its numbers are.
pub(super) struct Axis {
    label: String,
    /// The coordinate at node 0, and how much a node adds.
    start: f64,
    step: f64,
}

impl Axis {
    pub(super) fn of(lattice: &Lattice, which: usize) -> Self {
        let along = if which == 0 { lattice.right } else { lattice.up };
        let step = lattice.spacing[which];
        match along_axis(along) {
            Some((axis, sign)) => Self {
                label: format!("{}, m", NAMES[axis]),
                start: lattice.origin[axis],
                step: sign * step,
            },
            None => Self { label: format!("along {}, m", direction(along)), start: 0.0, step },
        }
    }

    /// Lists the numbers along it, over so many nodes, with their places in nodes.
    fn ticks(&self, nodes: usize, count: usize) -> Vec<(f64, String)> {
        let ends = [-0.5, nodes as f64 - 0.5].map(|node| self.start + node * self.step);
        let values = ticks::linear(ends[0].min(ends[1]), ends[0].max(ends[1]), count);
        let texts = ticks::texts(&values, 6);
        values.iter().zip(texts).map(|(v, text)| ((v - self.start) / self.step, text)).collect()
    }
}

/// Where things are on the paper.
pub(super) struct Layout {
    pub(super) plot: Area,
    /// The size of a cell.
    cell: [f64; 2],
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Layout {
    pub(super) fn of(lattice: &Lattice, axes: &[Axis; 2]) -> Self {
        let [columns, rows] = lattice.size;
        let [wide, high] = [0, 1].map(|k| lattice.spacing[k] * lattice.size[k] as f64);
        let scale = (ROOM[0] / wide).min(ROOM[1] / high);
        let numbers = axes[1].ticks(rows, 8);
        let numbers = numbers.iter().map(|(_, text)| text_width(text, FONT)).fold(0.0, f64::max);
        let plot = Area {
            x: (3.2 * FONT + numbers).round(),
            y: 84.0,
            width: (wide * scale).round().max(1.0),
            height: (high * scale).round().max(1.0),
        };
        let cell = [plot.width / columns as f64, plot.height / rows as f64];
        Self { plot, cell, columns, rows }
    }

    /// Returns where a place in nodes is.
    pub(super) fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [width, height] = self.cell;
        [self.plot.x + (x + 0.5) * width, self.plot.bottom() - (y + 0.5) * height]
    }

    /// Returns the middle of a plate above a cell, or below where there is no room.
    pub(super) fn beside(&self, cell: Area, size: [f64; 2]) -> [f64; 2] {
        let half = 0.5 * size[0];
        let above = cell.y - 0.7 * size[1];
        let y = if above - size[1] > self.plot.y { above } else { cell.bottom() + 0.7 * size[1] };
        let [left, right] = [self.plot.x + half, self.plot.right() - half];
        [(cell.x + 0.5 * cell.width).clamp(left, right.max(left)), y]
    }

    pub(super) fn middle(&self, node: usize) -> [f64; 2] {
        self.place([node % self.columns, node / self.columns].map(|n| n as f64))
    }

    /// Returns the area of a cell, with half a pixel more to the right and below so that no seam
    /// shows.
    pub(super) fn cell(&self, node: usize) -> Area {
        let area = Area::about(self.middle(node), self.cell);
        let (right, bottom) = (area.right() + 0.5, area.bottom() + 0.5);
        let width = right.min(self.plot.right()) - area.x;
        let height = bottom.min(self.plot.bottom()) - area.y;
        Area { width, height, ..area }
    }

    /// Returns the size in which these texts fit their cells; `None` when that is too small to be
    /// read.
    pub(super) fn value_font<'a>(&self, texts: impl Iterator<Item = &'a str>) -> Option<f64> {
        let widest = texts.map(|text| text_width(text, 1.0)).fold(0.0, f64::max);
        let fits = (0.86 * self.cell[0] / widest).min(0.62 * self.cell[1]).min(VALUES[1]).floor();
        (widest > 0.0 && fits >= VALUES[0]).then_some(fits)
    }
}

/// Draws the frame with its numbers and labels.
pub(super) fn draw_axes(paper: &mut Paper, layout: &Layout, axes: &[Axis; 2]) {
    let plot = layout.plot;
    paper.frame(plot, FRAME, 1.0);
    let count = |length: f64, gap: f64| (length / gap).clamp(2.0, 10.0) as usize;
    for (node, text) in axes[0].ticks(layout.columns, count(plot.width, 70.0)) {
        let [x, _] = layout.place([node, 0.0]);
        paper.polyline(&[[x, plot.bottom()], [x, plot.bottom() + 5.0]], FRAME, 1.0);
        paper.text([x, plot.bottom() + 6.0 + 0.8 * FONT], Align::Middle, FONT, INK, &text);
    }
    for (node, text) in axes[1].ticks(layout.rows, count(plot.height, 36.0)) {
        let [_, y] = layout.place([0.0, node]);
        paper.polyline(&[[plot.x - 5.0, y], [plot.x, y]], FRAME, 1.0);
        paper.text([plot.x - 9.0, y], Align::Right, FONT, INK, &text);
    }
    let [x, y] = [plot.x + 0.5 * plot.width, plot.y + 0.5 * plot.height];
    paper.text([x, plot.bottom() + 2.9 * FONT], Align::Middle, FONT, INK, &axes[0].label);
    paper.text([FONT, y], Align::Upwards, FONT, INK, &axes[1].label);
}
