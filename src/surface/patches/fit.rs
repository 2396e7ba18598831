//! From heights at Chebyshev points to a patch that is certainly above the surface.
//!
//! The heights at 12 x 12 points give an interpolant of degree 11 whose distance from the surface
//! is bounded by the coefficients (`certificate`). Its Chebyshev series is cut at degree 7; what is
//! cut is at most the sum of the coefficients left out. Rounding to f32 is counted term by term,
//! evaluation in f32 by the usual bound on sums.

use super::board::Cell;
use super::patch::{ORDER, Patch};

/// Chebyshev points along each direction of a patch.
pub(super) const POINTS: usize = 12;

/// Nodes along each direction at which derivatives are sampled; a polynomial of degree 7 is nowhere
/// larger than the largest sample over cos(7 pi / (2 NODES)) (Ehlich and Zeller 1964), once for
/// each direction.
const NODES: usize = 20;

/// How many roundings of f32 enter a term of a sum: monomials 5, Horner 3, 4 levels of adding lanes
/// and some to spare.
const ROUNDINGS: f64 = 20.0;

type Square = [[f64; ORDER]; ORDER];

/// Tables that all patches share.
#[derive(Debug, Clone)]
pub(super) struct Fitter {
    /// T_i at the points, with the norm of the interpolation.
    analysis: [[f64; POINTS]; POINTS],
    /// Row i: the monomials of T_i.
    monomials: Square,
    /// Row k: x^i at node k, and its first and second derivatives.
    powers: [[[f64; ORDER]; NODES]; 3],
    /// Row k: what Bernstein coefficient k takes of x^i on [-1, 1], for the degree of a patch and
    /// for one more.
    bernstein: Square,
    raised: [[f64; ORDER + 1]; ORDER + 1],
}

/// A fitted patch, and two planes in w between which the surface lies over it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fitted {
    pub(super) patch: Patch,
    pub(super) planes: Planes,
    /// The heights of the surface are between these.
    pub(super) range: [f64; 2],
}

/// Two parallel planes w = low + by_u u + by_v v and w = high + by_u u + by_v v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Planes {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) by_u: f64,
    pub(super) by_v: f64,
}

/// Returns Chebyshev point `k` of `count`.
pub(super) fn chebyshev_point(k: usize, count: usize) -> f64 {
    (std::f64::consts::PI * (k as f64 + 0.5) / count as f64).cos()
}

impl Fitter {
    pub(super) fn new() -> Self {
        let mut monomials = [[0.0; ORDER]; ORDER];
        (monomials[0][0], monomials[1][1]) = (1.0, 1.0);
        for i in 2..ORDER {
            for k in 0..ORDER {
                let shifted = if k == 0 { 0.0 } else { monomials[i - 1][k - 1] };
                monomials[i][k] = 2.0 * shifted - monomials[i - 2][k];
            }
        }
        let analysis = std::array::from_fn(|i| {
            let norm = if i == 0 { 1.0 } else { 2.0 } / POINTS as f64;
            let angle = |k: usize| std::f64::consts::PI * (k as f64 + 0.5) / POINTS as f64;
            std::array::from_fn(|k| norm * (i as f64 * angle(k)).cos())
        });
        let node = |k: usize| chebyshev_point(k, NODES);
        let power = |x: f64, i: usize, order: usize| {
            let factor: f64 = (0..order).map(|d| i as f64 - d as f64).product();
            if i < order { 0.0 } else { factor * x.powi((i - order) as i32) }
        };
        let powers = std::array::from_fn(|order| {
            std::array::from_fn(|k| std::array::from_fn(|i| power(node(k), i, order)))
        });
        Self { analysis, monomials, powers, bernstein: bernstein(), raised: bernstein() }
    }

    /// Fits the heights at the points, row by row along v; `beyond` bounds their interpolation and
    /// their own error.
    pub(super) fn fit(
        &self,
        heights: &[[f64; POINTS]; POINTS],
        beyond: f64,
        [across, along]: [&Cell; 2],
    ) -> Fitted {
        let series = self.series(heights);
        let cut = cut_off(&series);
        let exact = self.to_monomials(&series);
        let mut patch = Patch {
            rows: [[0.0; 16]; ORDER / 2],
            base: 0.0,
            width: 0.0,
            slope: 0.0,
            curvature: 0.0,
        };
        let (mut kept, mut rounding, mut size) = ([[0.0; ORDER]; ORDER], 0.0, 0.0);
        for j in 0..ORDER {
            for i in 0..ORDER {
                if i + j == 0 {
                    continue;
                }
                let rounded = exact[j][i] as f32;
                patch.rows[j / 2][i + ORDER * (j % 2)] = rounded;
                kept[j][i] = f64::from(rounded);
                rounding += (exact[j][i] - kept[j][i]).abs();
                size += kept[j][i].abs() * (1.0 + (i + j) as f64 / ROUNDINGS);
            }
        }
        // Where the line stands in the patch is rounded to f32 too: that moves each term by (i + j)
        // roundings.
        let evaluation = ROUNDINGS * size * 0.5 * f64::from(f32::EPSILON);
        let error = cut + rounding + evaluation + beyond;
        kept[0][0] = exact[0][0];
        patch.base = exact[0][0] + error;
        patch.width = upward(2.0 * error);
        let (slope, curvature) = self.derivatives(&kept);
        patch.slope = upward(slope + rounding + evaluation);
        patch.curvature = upward(curvature);
        let [low, high] = hull(&self.bernstein, &kept);
        let range = [low - error, high + error];
        Fitted { patch, planes: self.planes(&kept, range, error, across, along), range }
    }

    /// Puts two planes around w = 1/Z: parallel to the tangent in the middle, and as far apart as Z
    /// (a + b x + c y) - 1 says.
    fn planes(
        &self,
        heights: &Square,
        [small, large]: [f64; 2],
        error: f64,
        across: &Cell,
        along: &Cell,
    ) -> Planes {
        let middle = heights[0][0];
        let slope = |by: f64, cell: &Cell| f64::from((-by / (middle * middle) * cell.scale) as f32);
        let (by_u, by_v) = (slope(heights[0][1], across), slope(heights[1][0], along));
        let plane = [1.0 / middle, by_u * across.half, by_v * along.half];
        let mut product = [[0.0; ORDER + 1]; ORDER + 1];
        for (j, row) in heights.iter().enumerate() {
            for (i, z) in row.iter().enumerate() {
                product[j][i] += plane[0] * z;
                product[j][i + 1] += plane[1] * z;
                product[j + 1][i] += plane[2] * z;
            }
        }
        // w - plane = (1 - Z plane) / Z, and Z itself is uncertain by `error`.
        let [least, most] = hull(&self.raised, &product).map(|product| 1.0 - product);
        let uncertain = error * (plane[0] + plane[1].abs() + plane[2].abs());
        let (up, down) = (least + uncertain, most - uncertain);
        let over = |x: f64, of_sign: [f64; 2]| x / if x > 0.0 { of_sign[0] } else { of_sign[1] };
        let base = plane[0] - by_u * across.middle - by_v * along.middle;
        if small > 0.0 {
            Planes {
                low: base + over(down, [large, small]),
                high: base + over(up, [small, large]),
                by_u,
                by_v,
            }
        } else {
            // A height that may reach zero has no plane above it.
            Planes { low: 1.0 / large, high: f64::INFINITY, by_u: 0.0, by_v: 0.0 }
        }
    }

    /// Returns the Chebyshev coefficients of the interpolant, row j for T_j(y).
    fn series(&self, heights: &[[f64; POINTS]; POINTS]) -> [[f64; POINTS]; POINTS] {
        let mut half = [[0.0; POINTS]; POINTS];
        for (row, out) in heights.iter().zip(&mut half) {
            for (weights, value) in self.analysis.iter().zip(out) {
                *value = dot(weights, row);
            }
        }
        let mut series = [[0.0; POINTS]; POINTS];
        for (weights, row) in self.analysis.iter().zip(&mut series) {
            for (weight, source) in weights.iter().zip(&half) {
                for (value, x) in row.iter_mut().zip(source) {
                    *value += weight * x;
                }
            }
        }
        series
    }

    fn to_monomials(&self, series: &[[f64; POINTS]; POINTS]) -> Square {
        let mut result = [[0.0; ORDER]; ORDER];
        for (j, of_y) in self.monomials.iter().enumerate() {
            let mut row = [0.0; ORDER];
            for (i, of_x) in self.monomials.iter().enumerate() {
                (0..=i).for_each(|k| row[k] += series[j][i] * of_x[k]);
            }
            for k in 0..=j {
                for (value, x) in result[k].iter_mut().zip(&row) {
                    *value += of_y[k] * x;
                }
            }
        }
        result
    }

    /// Bounds the gradient's length and the Hessian's norm.
    fn derivatives(&self, monomials: &Square) -> (f64, f64) {
        let (mut slope, mut curvature) = (0.0_f64, 0.0_f64);
        for k in 0..NODES {
            let [rows, dy_rows, dyy_rows] = [0, 1, 2].map(|order| {
                let weights = &self.powers[order][k];
                let mut row = [0.0; ORDER];
                for (weight, source) in weights.iter().zip(monomials) {
                    for (value, x) in row.iter_mut().zip(source) {
                        *value += weight * x;
                    }
                }
                row
            });
            for i in 0..NODES {
                let [at, d, dd] = [0, 1, 2].map(|order| &self.powers[order][i]);
                let (x, y) = (dot(d, &rows), dot(at, &dy_rows));
                let (xx, xy, yy) = (dot(dd, &rows), dot(d, &dy_rows), dot(at, &dyy_rows));
                slope = slope.max(x * x + y * y);
                // The larger eigenvalue of the Hessian in absolute value.
                let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
                curvature = curvature.max(mean.abs() + half.hypot(xy));
            }
        }
        let degree = (ORDER - 1) as f64;
        let inflate = (0.5 * std::f64::consts::PI * degree / NODES as f64).cos().powi(-2);
        (inflate * slope.sqrt(), inflate * curvature)
    }
}

/// Sums the coefficients above the degree that is kept.
fn cut_off(series: &[[f64; POINTS]; POINTS]) -> f64 {
    let mut sum = 0.0;
    for (j, row) in series.iter().enumerate() {
        for (i, value) in row.iter().enumerate() {
            if i >= ORDER || j >= ORDER {
                sum += value.abs();
            }
        }
    }
    sum
}

/// Bounds a polynomial by its Bernstein coefficients.
fn hull<const N: usize>(bernstein: &[[f64; N]; N], monomials: &[[f64; N]; N]) -> [f64; 2] {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for of_y in bernstein {
        let mut row = [0.0; N];
        for (weight, source) in of_y.iter().zip(monomials) {
            for (value, x) in row.iter_mut().zip(source) {
                *value += weight * x;
            }
        }
        for of_x in bernstein {
            let value = dot(of_x, &row);
            (low, high) = (low.min(value), high.max(value));
        }
    }
    [low, high]
}

/// Returns the Bernstein coefficients of x^i on [-1, 1] for N - 1 end points: the blossom, the mean
/// over all choices of i of them.
fn bernstein<const N: usize>() -> [[f64; N]; N] {
    let n = N - 1;
    let choose = |n: usize, k: usize| -> f64 {
        if k > n { 0.0 } else { (0..k).map(|d| (n - d) as f64 / (d + 1) as f64).product() }
    };
    // k of the end points are +1, the others -1.
    std::array::from_fn(|k| {
        std::array::from_fn(|i| {
            let terms = (0..=i).map(|minus| {
                let sign = if minus % 2 == 0 { 1.0 } else { -1.0 };
                sign * choose(k, i - minus) * choose(n - k, minus)
            });
            terms.sum::<f64>() / choose(n, i)
        })
    })
}

fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Rounds a bound to f32 so that it stays one.
fn upward(x: f64) -> f32 {
    (x as f32).next_up()
}

#[cfg(test)]
mod tests {
    use super::super::board::Board;
    use super::*;

    /// Samples Z at the points of a cell, and at a fine grid.
    fn heights(z: impl Fn(f64, f64) -> f64, cells: [&Cell; 2]) -> [[f64; POINTS]; POINTS] {
        let at = |cell: &Cell, k| cell.middle + cell.half * chebyshev_point(k, POINTS);
        std::array::from_fn(|j| std::array::from_fn(|i| z(at(cells[0], i), at(cells[1], j))))
    }

    fn value(patch: &Patch, x: f64, y: f64) -> f64 {
        let term = |k: usize| {
            let (i, j) = (k % ORDER, k / ORDER);
            f64::from(patch.rows[j / 2][i + ORDER * (j % 2)]) * x.powi(i as i32) * y.powi(j as i32)
        };
        patch.base + (0..ORDER * ORDER).map(term).sum::<f64>()
    }

    #[test]
    fn patch_is_above_the_surface_by_no_more_than_its_width_and_between_its_planes() {
        let board = Board::new(8);
        let z = |u: f64, v: f64| {
            (0.8 + 0.1 * (3.0 * u + v).sin() * (2.0 * v).cos()) / (1.0 + u * u + v * v).sqrt()
        };
        let fitter = Fitter::new();
        for (column, row) in [(0, 0), (3, 4), (7, 2), (5, 5)] {
            let cells = [board.cell(column), board.cell(row)];
            let Fitted { patch, planes, range } = fitter.fit(&heights(z, cells), 1e-9, cells);
            assert!(f64::from(patch.width) <= 1e-6, "{}", patch.width);
            for k in 0..=40 * 40 {
                let (x, y) = (f64::from(k % 41) / 20.0 - 1.0, f64::from(k / 41) / 20.0 - 1.0);
                let (u, v) =
                    (cells[0].middle + x * cells[0].half, cells[1].middle + y * cells[1].half);
                let (exact, above) = (z(u, v), value(&patch, x, y));
                assert!(exact <= above && above <= exact + f64::from(patch.width));
                assert!(range[0] <= exact && exact <= range[1]);
                let plane = planes.by_u * u + planes.by_v * v;
                assert!(planes.low + plane <= 1.0 / exact && 1.0 / exact <= planes.high + plane);
            }
            // Over a cell of 0.2 the surface leaves its tangent by a few hundredths.
            assert!(planes.high - planes.low <= 0.1, "{planes:?}");
        }
    }

    #[test]
    fn derivatives_of_a_polynomial_are_bounded_tightly() {
        let board = Board::new(4);
        let cells = [board.cell(1), board.cell(2)];
        let local = |at: f64, cell: &Cell| (at - cell.middle) * cell.scale;
        // Z = 1 + x y / 10 + x^2 / 5 in the cell: the Hessian is ((0.4, 0.1), (0.1, 0)).
        let z = |u: f64, v: f64| {
            let (x, y) = (local(u, cells[0]), local(v, cells[1]));
            1.0 + 0.1 * x * y + 0.2 * x * x
        };
        let patch = Fitter::new().fit(&heights(z, cells), 0.0, cells).patch;
        let (curvature, slope) = (f64::from(patch.curvature), f64::from(patch.slope));
        let exact = 0.2 + 0.2_f64.hypot(0.1);
        assert!(exact <= curvature && curvature <= 1.4 * exact);
        let steepest = 0.5_f64.hypot(0.1);
        assert!(steepest <= slope && slope <= 1.4 * steepest);
    }
}
