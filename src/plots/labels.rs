//! Isolines on the paper, and where their numbers stand: on their line, apart from each other and,
//! where that is possible, from what else is written.

use crate::plots::ColourScale;
use crate::plots::isolines::{Line, isolines};
use crate::plots::paper::{Area, plate_size};

/// The share of a label that may lie over something else.
const HIDDEN: f64 = 0.3;

/// The middle of a plate and what it says.
pub(super) type Label = ([f64; 2], String);

/// Places labels one after the other.
pub(super) struct Placing {
    /// Where labels may be.
    pub(super) frame: Area,
    /// What labels should leave free.
    pub(super) soft: Vec<Area>,
    /// What has been placed.
    pub(super) taken: Vec<Area>,
    /// The length of line for which one label is enough.
    pub(super) reach: f64,
    /// The length below which a line is not drawn.
    pub(super) shortest: f64,
    /// The size of the numbers.
    pub(super) font: f64,
}

impl Placing {
    /// Returns the isolines of a field, row by row of so many columns and even on the scale, at
    /// these levels, by the place on the paper of a place in the field; and their labels.
    pub(super) fn isolines(
        &mut self,
        scale: &ColourScale,
        levels: impl Iterator<Item = (f64, String)>,
        (columns, field): (usize, &[f64]),
        place: impl Fn([f64; 2]) -> [f64; 2],
    ) -> (Vec<Line>, Vec<Label>) {
        let (mut all, mut labels) = (Vec::new(), Vec::new());
        for (level, text) in levels {
            let lines = isolines(columns, field, scale.evened(level)).into_iter();
            let lines = lines.map(|line| line.into_iter().map(&place).collect::<Line>());
            let lines: Vec<Line> = lines.filter(|line| length(line) >= self.shortest).collect();
            let middles = self.on(&lines, plate_size(&text, self.font));
            labels.extend(middles.into_iter().map(|middle| (middle, text.clone())));
            all.extend(lines);
        }
        (all, labels)
    }

    /// Finds the middles of labels of this size on the lines of one level: one or more on each that
    /// is long enough, at least one in all if there is room.
    fn on(&mut self, lines: &[Line], size: [f64; 2]) -> Vec<[f64; 2]> {
        let mut order: Vec<&Line> = lines.iter().collect();
        order.sort_by(|a, b| length(b).total_cmp(&length(a)));
        let mut middles = Vec::new();
        for line in order {
            let long = length(line);
            if long < 2.5 * size[0] && !(middles.is_empty() && long >= 0.8 * size[0]) {
                break;
            }
            let parts = 1 + (long / self.reach) as usize;
            for part in 0..parts {
                let ends = [part, part + 1].map(|k| long * k as f64 / parts as f64);
                middles.extend(self.best(line, ends, size, !middles.is_empty()));
            }
        }
        middles
    }

    /// Takes the best place on a part of a line.
    fn best(
        &mut self,
        line: &[[f64; 2]],
        [from, to]: [f64; 2],
        size: [f64; 2],
        strict: bool,
    ) -> Option<[f64; 2]> {
        let steps = (4.0 * (to - from) / size[0]).clamp(4.0, 64.0) as usize;
        let candidates = (0..=steps).filter_map(|k| {
            let share = k as f64 / steps as f64;
            let middle = along(line, from + share * (to - from))?;
            let area = Area::about(middle, size);
            let room = Area::about(middle, size.map(|n| 1.15 * n));
            let free = self.taken.iter().all(|other| room.overlap(other) == 0.0);
            let hidden: f64 = self.soft.iter().map(|other| area.overlap(other)).sum();
            let hidden = hidden / (size[0] * size[1]);
            let allowed = self.frame.holds(&area) && (!strict || hidden <= HIDDEN);
            (free && allowed).then_some((hidden + 0.2 * (share - 0.5).abs(), area, middle))
        });
        let (_, area, middle) = candidates.min_by(|a, b| a.0.total_cmp(&b.0))?;
        self.taken.push(area);
        Some(middle)
    }
}

fn length(line: &[[f64; 2]]) -> f64 {
    line.windows(2).map(|pair| apart(pair[0], pair[1])).sum()
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Returns the point at a distance along a line.
fn along(line: &[[f64; 2]], mut distance: f64) -> Option<[f64; 2]> {
    for pair in line.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let piece = apart(a, b);
        if distance <= piece && piece > 0.0 {
            let share = distance / piece;
            return Some([0, 1].map(|k| a[k] + share * (b[k] - a[k])));
        }
        distance -= piece;
    }
    line.last().copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn placing(soft: Vec<Area>) -> Placing {
        let frame = Area { x: 0.0, y: 0.0, width: 400.0, height: 100.0 };
        Placing { frame, soft, taken: Vec::new(), reach: 300.0, shortest: 0.0, font: 10.0 }
    }

    #[test]
    fn nothing_and_points_have_no_label() {
        assert!(placing(vec![]).on(&[], [30.0, 12.0]).is_empty());
        let lines = [vec![], vec![[5.0, 5.0]], vec![[5.0, 5.0]; 3]];
        assert!(placing(vec![]).on(&lines, [30.0, 12.0]).is_empty());
    }

    #[test]
    fn label_stands_in_the_middle_of_its_line_and_beside_what_is_written() {
        let line = vec![vec![[20.0, 50.0], [220.0, 50.0]]];
        assert_eq!(placing(vec![]).on(&line, [30.0, 12.0]), [[120.0, 50.0]]);
        let written = Area::about([120.0, 50.0], [40.0, 12.0]);
        let found = placing(vec![written]).on(&line, [30.0, 12.0]);
        assert!(found.len() == 1 && (found[0][0] - 120.0).abs() >= 30.0, "{found:?}");
    }

    #[test]
    fn labels_keep_apart_and_long_lines_have_several() {
        let line = |y: f64| vec![vec![[10.0, y], [390.0, y]]];
        let mut placing = placing(vec![]);
        let first = placing.on(&line(50.0), [30.0, 12.0]);
        let second = placing.on(&line(52.0), [30.0, 12.0]);
        assert_eq!((first.len(), second.len()), (2, 2));
        for (a, b) in first.iter().zip(&second) {
            let [a, b] = [*a, *b].map(|p| Area::about(p, [30.0, 12.0]));
            assert_eq!(a.overlap(&b), 0.0);
        }
        placing.taken.push(placing.frame);
        assert!(placing.on(&line(20.0), [30.0, 12.0]).is_empty());
    }
}
