//! A field on a regular grid, refined by the cubic of Catmull and Rom: it passes through the values
//! it is given, and isolines of it have no corners.
//!
//! At a border, or where a value is missing, the cubic goes on straight.

/// Refines `values`, row by row of `columns` each, by `times` steps between neighbours:
/// (columns - 1) times + 1 values a row come back, and rows likewise. Between a value that is not
/// finite and its neighbours nothing is finite.
pub(super) fn refined(columns: usize, values: &[f64], times: usize) -> (usize, Vec<f64>) {
    if columns < 2 || values.len() < 2 * columns || times < 2 {
        return (columns, values.to_vec());
    }
    let across = values.chunks_exact(columns).flat_map(|row| refined_line(row, times));
    let across: Vec<f64> = across.collect();
    let finer = (columns - 1) * times + 1;
    let column = |c: usize| across.iter().skip(c).step_by(finer).copied().collect::<Vec<f64>>();
    let down: Vec<f64> = (0..finer).flat_map(|c| refined_line(&column(c), times)).collect();
    let rows = down.len() / finer;
    (finer, (0..down.len()).map(|i| down[i % finer * rows + i / finer]).collect())
}

fn refined_line(values: &[f64], times: usize) -> Vec<f64> {
    let at = |i: usize| values.get(i).copied().unwrap_or(f64::NAN);
    let fine = |k: usize| match (k / times, k % times) {
        (node, 0) => at(node),
        (node, step) => {
            let around = [at(node.wrapping_sub(1)), at(node), at(node + 1), at(node + 2)];
            cubic(around, step as f64 / times as f64)
        }
    };
    (0..=(values.len() - 1) * times).map(fine).collect()
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
        // The node and what is between it and its neighbours.
        assert_eq!(missing, [8, 9, 10, 15, 16, 17, 22, 23, 24]);
        assert_eq!(columns, 7);
        assert!(fine.iter().all(|v| v.is_nan() || (v - 1.0).abs() <= 1e-15));
    }
}
