//! Where the numbers of isolines stand: on their line, apart from each other and, where that is
//! possible, from what else is written.

use crate::plots::paper::Area;

/// The share of a label that may lie over something else.
const HIDDEN: f64 = 0.3;

/// Places labels one after the other.
pub(super) struct Placing {
    /// Where labels may be.
    frame: Area,
    /// What labels should leave free.
    soft: Vec<Area>,
    /// What has been placed.
    taken: Vec<Area>,
    /// The length of line for which one label is enough.
    reach: f64,
}

impl Placing {
    pub(super) fn new(frame: Area, soft: Vec<Area>, reach: f64) -> Self {
        Self { frame, soft, taken: Vec::new(), reach }
    }

    /// Keeps an area free of what comes.
    pub(super) fn take(&mut self, area: Area) {
        self.taken.push(area);
    }

    /// Finds the middles of labels of this size on the lines of one level: one or more on each that
    /// is long enough, at least one in all if there is room.
    pub(super) fn on(&mut self, lines: &[Vec<[f64; 2]>], size: [f64; 2]) -> Vec<[f64; 2]> {
        let mut order: Vec<&Vec<[f64; 2]>> = lines.iter().collect();
        order.sort_by(|a, b| length(b).total_cmp(&length(a)));
        let mut middles = Vec::new();
        for line in order {
            let long = length(line);
            if long < 2.5 * size[0] && !(middles.is_empty() && long >= 0.8 * size[0]) {
                break;
            }
            let parts = 1 + (long / self.reach) as usize;
            for part in 0..parts {
                let [from, to] = [part, part + 1].map(|k| long * k as f64 / parts as f64);
                let strict = !middles.is_empty();
                middles.extend(self.best(line, [from, to], size, strict));
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
            let allowed = !strict || hidden <= HIDDEN;
            (free && allowed && self.frame.holds(&area)).then_some((
                hidden + 0.2 * (share - 0.5).abs(),
                area,
                middle,
            ))
        });
        let (_, area, middle) = candidates.min_by(|a, b| a.0.total_cmp(&b.0))?;
        self.taken.push(area);
        Some(middle)
    }
}

pub(super) fn length(line: &[[f64; 2]]) -> f64 {
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
        Placing::new(frame, soft, 300.0)
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
        placing.take(Area { x: 0.0, y: 0.0, width: 400.0, height: 100.0 });
        assert!(placing.on(&line(20.0), [30.0, 12.0]).is_empty());
    }
}
