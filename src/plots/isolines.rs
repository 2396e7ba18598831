//! Isolines of a field known at the nodes of a regular grid, by marching squares.
//!
//! Between the nodes of an edge the field is taken as linear, in a cell as bilinear: where two
//! opposite corners are above the level and two below, the value at the saddle of the bilinear
//! field decides which of them are joined (Nielson and Hamann, "The asymptotic decider", 1991).
//! Cells with a corner that is not finite have no line.

use hashbrown::HashMap;

/// A line along which a field has one value.
#[derive(Debug, Clone, PartialEq)]
pub struct Isoline {
    /// Its points in order, in units of the grid: node (column, row) is at [column, row].
    pub points: Vec<[f64; 2]>,
    /// Whether it ends where it begins; the first point then stands at the end again.
    pub closed: bool,
}

/// Finds the isolines of a level in `values`, row by row, of a grid of `columns` nodes a row; a
/// last row that is not whole is passed over.
pub fn isolines(columns: usize, values: &[f64], level: f64) -> Vec<Isoline> {
    let field = Field { columns, rows: values.len().checked_div(columns).unwrap_or(0), values };
    let segments = field.segments(level);
    let mut ends: HashMap<Edge, [Option<usize>; 2]> = HashMap::with_capacity(segments.len());
    for (number, segment) in segments.iter().enumerate() {
        for edge in segment {
            let [first, second] = ends.entry(*edge).or_default();
            *(if first.is_none() { first } else { second }) = Some(number);
        }
    }
    let mut trace = Trace { segments: &segments, ends: &ends, used: vec![false; segments.len()] };
    let is_end = |edge: &Edge| ends.get(edge).is_some_and(|[_, second]| second.is_none());
    let open = segments.iter().enumerate();
    let open = open.flat_map(|(n, s)| s.iter().filter(|e| is_end(e)).map(move |e| (n, *e)));
    let loops = segments.iter().enumerate().map(|(n, s)| (n, s[0]));
    let chains = open.chain(loops).filter_map(|(n, edge)| trace.follow(n, edge));
    chains.map(|edges| field.line(&edges, level)).collect()
}

/// An edge of the grid: from the node of this number to the next in its row, or to the one under it
/// in the next row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Edge {
    node: usize,
    to_next_row: bool,
}

struct Field<'a> {
    columns: usize,
    rows: usize,
    values: &'a [f64],
}

impl Field<'_> {
    /// Lists the pieces of lines in all cells, by the edges they join.
    fn segments(&self, level: f64) -> Vec<[Edge; 2]> {
        let mut segments = Vec::new();
        for row in 1..self.rows {
            for column in 1..self.columns {
                self.cell((row - 1) * self.columns + column - 1, level, &mut segments);
            }
        }
        segments
    }

    /// Adds the pieces in the cell whose first corner is this node.
    fn cell(&self, node: usize, level: f64, segments: &mut Vec<[Edge; 2]>) {
        let below = node + self.columns;
        // Around the cell: this corner, the next in its row, the one under that, the one under
        // this.
        let corners = [node, node + 1, below + 1, below].map(|n| self.values[n]);
        if !corners.iter().all(|v| v.is_finite()) {
            return;
        }
        let across = |node| Edge { node, to_next_row: false };
        let down = |node| Edge { node, to_next_row: true };
        // Edge k follows corner k.
        let edges = [across(node), down(node + 1), across(below), down(node)];
        let above = corners.map(|v| v >= level);
        let crossed: Vec<usize> = (0..4).filter(|k| above[*k] != above[(k + 1) % 4]).collect();
        match crossed[..] {
            [a, b] => segments.push([edges[a], edges[b]]),
            [_, _, _, _] => {
                let [a, b, c, d] = corners.map(|v| v - level);
                // The saddle's value, (ac - bd) / (a + c - b - d), has the sign of the pair whose
                // product is the larger: that pair is joined. Corners of the other are cut off one
                // by one; corner k lies between edges k - 1 and k.
                let cut_off = if a * c >= b * d { [1, 3] } else { [0, 2] };
                segments.extend(cut_off.map(|k: usize| [edges[(k + 3) % 4], edges[k]]));
            }
            _ => {}
        }
    }

    fn line(&self, edges: &[Edge], level: f64) -> Isoline {
        let points = edges.iter().map(|edge| self.crossing(*edge, level)).collect();
        Isoline { points, closed: edges.len() > 2 && edges.first() == edges.last() }
    }

    /// Returns where an edge has the level.
    fn crossing(&self, Edge { node, to_next_row }: Edge, level: f64) -> [f64; 2] {
        let next = if to_next_row { node + self.columns } else { node + 1 };
        let (from, to) = (self.values[node], self.values[next]);
        let share = (level - from) / (to - from);
        // Differences of the largest numbers overflow.
        let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 };
        let [x, y] = [node % self.columns, node / self.columns].map(|n| n as f64);
        if to_next_row { [x, y + share] } else { [x + share, y] }
    }
}

/// Joins pieces to lines.
struct Trace<'a> {
    segments: &'a [[Edge; 2]],
    ends: &'a HashMap<Edge, [Option<usize>; 2]>,
    used: Vec<bool>,
}

impl Trace<'_> {
    /// Follows a line from one of its edges, through a piece that touches it; `None` when that has
    /// been followed.
    fn follow(&mut self, segment: usize, from: Edge) -> Option<Vec<Edge>> {
        if self.used[segment] {
            return None;
        }
        let mut edges = vec![from];
        let (mut edge, mut next) = (from, Some(segment));
        while let Some(segment) = next {
            self.used[segment] = true;
            let [a, b] = self.segments[segment];
            edge = if a == edge { b } else { a };
            edges.push(edge);
            let here = self.ends.get(&edge).copied().unwrap_or_default();
            next = here.into_iter().flatten().find(|s| !self.used[*s]);
        }
        Some(edges)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degenerate_grids_have_no_lines() {
        for (columns, values) in
            [(0, vec![]), (1, vec![0.0, 1.0]), (3, vec![0.0, 1.0, 2.0]), (2, vec![1.0; 4])]
        {
            assert_eq!(isolines(columns, &values, 0.5), [], "{columns} {values:?}");
        }
        assert_eq!(isolines(2, &[0.0, 1.0, f64::NAN, 1.0], 0.5), []);
        assert_eq!(isolines(2, &[0.0, 1.0, f64::INFINITY, 1.0], 0.5), []);
        assert_eq!(isolines(2, &[0.0, 1.0, 0.0, 1.0], f64::NAN), []);
    }

    #[test]
    fn straight_line_crosses_where_the_field_has_the_level() {
        let lines = isolines(3, &[0.0, 1.0, 2.0, 0.0, 1.0, 2.0], 0.25);
        assert_eq!(lines, [Isoline { points: vec![[0.25, 0.0], [0.25, 1.0]], closed: false }]);
        // A level that is met exactly at the nodes gives one line as well.
        assert_eq!(isolines(3, &[0.0, 1.0, 2.0, 0.0, 1.0, 2.0], 1.0).len(), 1);
        let huge = isolines(2, &[-1e308, 1e308, -1e308, 1e308], 0.0);
        assert!(huge[0].points.iter().flatten().all(|x| x.is_finite()));
    }

    #[test]
    fn peak_is_encircled_by_one_closed_line() {
        let mut values = [0.0; 25];
        values[12] = 1.0;
        let lines = isolines(5, &values, 0.5);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].closed && lines[0].points.len() == 5);
        assert_eq!(lines[0].points.first(), lines[0].points.last());
        assert!(lines[0].points.contains(&[1.5, 2.0]) && lines[0].points.contains(&[2.0, 2.5]));
    }

    #[test]
    fn saddle_is_decided_by_the_value_in_its_middle() {
        // Opposite corners at 1 are high, the others 0: the bilinear field is 1/2 at the saddle.
        let high_first = [1.0, 0.0, 0.0, 1.0];
        let high_second = [0.0, 1.0, 1.0, 0.0];
        for (values, level, cuts_first) in [
            (high_first, 0.4, false),
            (high_first, 0.6, true),
            (high_second, 0.4, true),
            (high_second, 0.6, false),
        ] {
            let lines = isolines(2, &values, level);
            assert_eq!(lines.len(), 2, "{values:?} {level}");
            // A line that cuts off node [0, 0] joins its two edges.
            let near = |p: &[f64; 2]| p[0] == 0.0 || p[1] == 0.0;
            let cut = lines.iter().any(|l| {
                l.points.iter().all(near)
                    && l.points.iter().any(|p| p[0] == 0.0)
                    && l.points.iter().any(|p| p[1] == 0.0)
            });
            assert_eq!(cut, cuts_first, "{values:?} {level}: {lines:?}");
        }
    }

    #[test]
    fn circle_has_its_radius_and_is_one_line() {
        let n = 41;
        let at = |i: usize| [(i % n) as f64 - 20.0, (i / n) as f64 - 20.0];
        let values: Vec<f64> = (0..n * n).map(|i| at(i)[0].hypot(at(i)[1])).collect();
        let lines = isolines(n, &values, 12.0);
        assert_eq!(lines.len(), 1);
        // Linear interpolation of a distance over a cell is off by at most 1/(8 r).
        for [x, y] in &lines[0].points {
            assert!(((x - 20.0).hypot(y - 20.0) - 12.0).abs() <= 1.0 / 96.0);
        }
        // Cut by the border there are four open ones.
        let open = isolines(n, &values, 24.0);
        assert!(open.len() == 4 && open.iter().all(|l| !l.closed));
    }

    #[test]
    fn every_crossed_edge_is_on_exactly_one_line() {
        let values: Vec<f64> = (0..30 * 20).map(|i| f64::from(i * i % 97)).collect();
        let level = 48.5;
        let crossed = |a: usize, b: usize| (values[a] >= level) != (values[b] >= level);
        let across = (0..600).filter(|i| i % 30 < 29 && crossed(*i, i + 1)).count();
        let down = (0..570).filter(|i| crossed(*i, i + 30)).count();
        let lines = isolines(30, &values, level);
        let points: usize = lines.iter().map(|l| l.points.len() - usize::from(l.closed)).sum();
        assert_eq!(points, across + down);
    }
}
