//! Isolines of a field known at the nodes of a regular grid, by marching squares.
//!
//! Between the nodes of an edge the field is taken as linear, in a cell as bilinear: where two
//! opposite corners are above the level and two below, the value at the saddle of the bilinear
//! field decides which of them are joined (Nielson and Hamann, "The asymptotic decider", 1991).
//! Cells with a corner that is not finite have no line.

use hashbrown::HashMap;

/// Points in order, the first once more at the end of a closed line.
pub(super) type Line = Vec<[f64; 2]>;

/// An edge of the grid: twice the node where it begins, and 1 more if it ends in the next row.
type Edge = usize;

/// Finds the isolines of a level in `values`, row by row, of a grid of `columns` nodes a row, in
/// units of the grid: node (column, row) is at [column, row]. A last row that is not whole is
/// passed over.
pub(super) fn isolines(columns: usize, values: &[f64], level: f64) -> Vec<Line> {
    let segments = segments(columns, values, level);
    let mut links: HashMap<Edge, [Option<Edge>; 2]> = HashMap::with_capacity(segments.len());
    for [a, b] in &segments {
        for (from, to) in [(a, b), (b, a)] {
            let [first, second] = links.entry(*from).or_default();
            *(if first.is_none() { first } else { second }) = Some(*to);
        }
    }
    let is_end = |edge: &&Edge| links.get(*edge).is_some_and(|[_, second]| second.is_none());
    let ends: Vec<Edge> = segments.iter().flatten().filter(is_end).copied().collect();
    let starts = ends.into_iter().chain(segments.iter().map(|segment| segment[0]));
    let chains = starts.map(|start| follow(start, &mut links)).filter(|edges| edges.len() > 1);
    let crossing = |edge| crossing(columns, values, edge, level);
    chains.map(|edges| edges.into_iter().map(crossing).collect()).collect()
}

/// Takes the line that begins at an edge out of the links.
fn follow(start: Edge, links: &mut HashMap<Edge, [Option<Edge>; 2]>) -> Vec<Edge> {
    let mut edges = vec![start];
    let mut here = start;
    while let Some(next) = links.get_mut(&here).and_then(|l| l.iter_mut().find_map(Option::take)) {
        let back = links.get_mut(&next).into_iter().flatten().find(|link| **link == Some(here));
        back.map(Option::take);
        edges.push(next);
        here = next;
    }
    edges
}

/// Lists the pieces of lines in all cells, by the edges they join.
fn segments(columns: usize, values: &[f64], level: f64) -> Vec<[Edge; 2]> {
    let rows = values.len().checked_div(columns).unwrap_or(0);
    let mut segments = Vec::new();
    let cells = (1..rows).flat_map(|row| (1..columns).map(move |c| (row - 1) * columns + c - 1));
    for node in cells {
        let below = node + columns;
        // Around the cell; edge k follows corner k.
        let corners = [node, node + 1, below + 1, below].map(|n| values[n]);
        let edges = [2 * node, 2 * node + 3, 2 * below, 2 * node + 1];
        if !corners.iter().all(|v| v.is_finite()) {
            continue;
        }
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
    segments
}

/// Returns where an edge has the level.
fn crossing(columns: usize, values: &[f64], edge: Edge, level: f64) -> [f64; 2] {
    let (node, to_next_row) = (edge / 2, edge % 2 == 1);
    let (from, to) = (values[node], values[node + if to_next_row { columns } else { 1 }]);
    let share = (level - from) / (to - from);
    // Differences of the largest numbers overflow.
    let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 };
    let [x, y] = [node % columns, node / columns].map(|n| n as f64);
    if to_next_row { [x, y + share] } else { [x + share, y] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_closed(line: &Line) -> bool {
        line.len() > 2 && line.first() == line.last()
    }

    #[test]
    fn degenerate_grids_have_no_lines() {
        for (columns, values) in
            [(0, vec![]), (1, vec![0.0, 1.0]), (3, vec![0.0, 1.0, 2.0]), (2, vec![1.0; 4])]
        {
            assert!(isolines(columns, &values, 0.5).is_empty(), "{columns} {values:?}");
        }
        assert!(isolines(2, &[0.0, 1.0, f64::NAN, 1.0], 0.5).is_empty());
        assert!(isolines(2, &[0.0, 1.0, f64::INFINITY, 1.0], 0.5).is_empty());
        assert!(isolines(2, &[0.0, 1.0, 0.0, 1.0], f64::NAN).is_empty());
    }

    #[test]
    fn straight_line_crosses_where_the_field_has_the_level() {
        let lines = isolines(3, &[0.0, 1.0, 2.0, 0.0, 1.0, 2.0], 0.25);
        assert_eq!(lines, [[[0.25, 0.0], [0.25, 1.0]]]);
        // A level that is met exactly at the nodes gives one line as well.
        assert_eq!(isolines(3, &[0.0, 1.0, 2.0, 0.0, 1.0, 2.0], 1.0).len(), 1);
        let huge = isolines(2, &[-1e308, 1e308, -1e308, 1e308], 0.0);
        assert!(huge[0].iter().flatten().all(|x| x.is_finite()));
    }

    #[test]
    fn peak_is_encircled_by_one_closed_line() {
        let mut values = [0.0; 25];
        values[12] = 1.0;
        let lines = isolines(5, &values, 0.5);
        assert_eq!(lines.len(), 1);
        assert!(is_closed(&lines[0]) && lines[0].len() == 5);
        assert!(lines[0].contains(&[1.5, 2.0]) && lines[0].contains(&[2.0, 2.5]));
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
                l.iter().all(near) && l.iter().any(|p| p[0] == 0.0) && l.iter().any(|p| p[1] == 0.0)
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
        for [x, y] in &lines[0] {
            assert!(((x - 20.0).hypot(y - 20.0) - 12.0).abs() <= 1.0 / 96.0);
        }
        // Cut by the border there are four open ones.
        let open = isolines(n, &values, 24.0);
        assert!(open.len() == 4 && !open.iter().any(is_closed));
    }

    #[test]
    fn every_crossed_edge_is_on_exactly_one_line() {
        let values: Vec<f64> = (0..30 * 20).map(|i| f64::from(i * i % 97)).collect();
        let level = 48.5;
        let crossed = |a: usize, b: usize| (values[a] >= level) != (values[b] >= level);
        let across = (0..600).filter(|i| i % 30 < 29 && crossed(*i, i + 1)).count();
        let down = (0..570).filter(|i| crossed(*i, i + 30)).count();
        let lines = isolines(30, &values, level);
        let points: usize = lines.iter().map(|l| l.len() - usize::from(is_closed(l))).sum();
        assert_eq!(points, across + down);
    }
}
