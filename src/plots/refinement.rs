//! A field on a regular grid, refined by the cubic of Catmull and Rom: it passes through the values
//! it is given, and isolines of it have no corners.
//!
//! At a border, or where a value is missing, the cubic goes on straight.

/// Refines `values`, row by row of `columns` each, by `times` steps between neighbours:
/// (columns - 1) times + 1 values a row come back, and rows likewise. Where one of the four values
/// around is not finite, what is between them is NaN; at the nodes what was there stays.
pub fn refined(columns: usize, values: &[f64], times: usize) -> (usize, Vec<f64>) {
    let rows = values.len().checked_div(columns).unwrap_or(0);
    if columns < 2 || rows < 2 || times < 2 {
        return (columns, values.to_vec());
    }
    let finer = |n: usize| (n - 1) * times + 1;
    let mut fine = vec![f64::NAN; finer(columns) * finer(rows)];
    for row in 0..rows - 1 {
        for column in 0..columns - 1 {
            let patch = Patch { columns, rows, values, column, row };
            for (i, j) in (0..=times).flat_map(|j| (0..=times).map(move |i| (i, j))) {
                let place = (row * times + j) * finer(columns) + column * times + i;
                let value = patch.at(i as f64 / times as f64, j as f64 / times as f64);
                // What a neighbour knows is not lost where this patch knows nothing.
                if value.is_finite() {
                    fine[place] = value;
                }
            }
        }
    }
    for (node, value) in values.iter().enumerate().take(rows * columns) {
        fine[node / columns * times * finer(columns) + node % columns * times] = *value;
    }
    (finer(columns), fine)
}

/// What lies between four neighbours.
struct Patch<'a> {
    columns: usize,
    rows: usize,
    values: &'a [f64],
    column: usize,
    row: usize,
}

impl Patch<'_> {
    fn at(&self, u: f64, v: f64) -> f64 {
        cubic([0, 1, 2, 3].map(|k| self.row_at(k, u)), v)
    }

    /// Interpolates the row `k` - 1 after the patch's first.
    fn row_at(&self, k: usize, u: f64) -> f64 {
        cubic([0, 1, 2, 3].map(|i| self.value(self.column + i, self.row + k)), u)
    }

    /// Returns a value, its place counted from 1; NaN outside.
    fn value(&self, column: usize, row: usize) -> f64 {
        let inside = (1..=self.columns).contains(&column) && (1..=self.rows).contains(&row);
        let value = || self.values[(row - 1) * self.columns + column - 1];
        if inside { value() } else { f64::NAN }
    }
}

/// Interpolates between the second and the third of four values; the first and the last may be
/// missing.
fn cubic([a, b, c, d]: [f64; 4], t: f64) -> f64 {
    let a = if a.is_finite() { a } else { 2.0 * b - c };
    let d = if d.is_finite() { d } else { 2.0 * c - b };
    let [slope_b, slope_c] = [0.5 * (c - a), 0.5 * (d - b)];
    let s = 1.0 - t;
    b * (1.0 + 2.0 * t) * s * s + slope_b * t * s * s + c * t * t * (3.0 - 2.0 * t)
        - slope_c * t * t * s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_refined_comes_back() {
        for (columns, values, times) in
            [(0, vec![], 4), (1, vec![1.0, 2.0], 4), (2, vec![1.0; 4], 1)]
        {
            assert_eq!(refined(columns, &values, times), (columns, values));
        }
    }

    #[test]
    fn planes_are_kept_and_nodes_passed_through() {
        let plane = |x: f64, y: f64| 3.0 + 2.0 * x - 0.5 * y;
        let values: Vec<f64> = (0..20).map(|i| plane(f64::from(i % 5), f64::from(i / 5))).collect();
        let (columns, fine) = refined(5, &values, 4);
        assert_eq!((columns, fine.len()), (17, 17 * 13));
        for (i, value) in fine.iter().enumerate() {
            let expected = plane((i % 17) as f64 / 4.0, (i / 17) as f64 / 4.0);
            assert!((value - expected).abs() <= 1e-12, "{i}: {value} {expected}");
        }
        let rough: Vec<f64> = (0..20).map(|i| f64::from(i * i % 7)).collect();
        let (_, fine) = refined(5, &rough, 4);
        assert!((0..20).all(|i| fine[i / 5 * 4 * 17 + i % 5 * 4] == rough[i]));
    }

    #[test]
    fn missing_values_stay_missing_and_spoil_no_neighbour() {
        let mut values = vec![1.0; 16];
        values[5] = f64::NAN;
        let (columns, fine) = refined(4, &values, 2);
        let missing: Vec<usize> = (0..fine.len()).filter(|i| !fine[*i].is_finite()).collect();
        // The node and what is between its neighbours; edges that a whole patch shares are known.
        assert_eq!(missing, [1, 3, 7, 8, 9, 10, 15, 16, 17, 21, 22, 23, 24]);
        assert_eq!(columns, 7);
        assert!(fine.iter().all(|v| v.is_nan() || (v - 1.0).abs() <= 1e-15));
    }
}
