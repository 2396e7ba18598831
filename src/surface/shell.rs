//! A shell around a body: on each cell of a cube-face grid, certified bounds of the radius.
//!
//! The cells of a cube face are bounded by planes through the origin, so a ray crosses them like a
//! straight line crosses the squares of a board. While it stays above the largest radius of a cell
//! it cannot meet the body there, and once it is below the smallest it is inside: both without
//! evaluating the series. With r the angular radius of a cell about its middle c, |f - f(c)| <=
//! |grad_S f(c)| r + M2 r^2 / 2. Two levels, the coarse one made of blocks of the fine one, let a
//! ray pass far from the body in a few steps.

use glam::DVec3;
use rayon::prelude::*;

use crate::math::Ray;
use crate::sh::{Bounds, Series};

/// Holds the bounds of the radius over one cell, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    pub(super) min: f32,
    pub(super) max: f32,
}

/// Fine cells along one side of a coarse one.
const BLOCK: usize = 8;

/// Cells are widened by this angle, radians: far more than the rounding of where a ray crosses from
/// one to the next.
const MARGIN: f64 = 1e-6;

/// The two levels of a body's shell.
#[derive(Debug, Clone)]
pub(super) struct Shell {
    coarse: Level,
    fine: Level,
}

/// One grid of side x side cells on each of the six cube faces.
#[derive(Debug, Clone)]
struct Level {
    side: usize,
    cells: Vec<Range>,
}

/// What a ray finds where it is: the bounds there, and until which distance they hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stay {
    pub(super) range: Range,
    pub(super) until: f64,
}

impl Shell {
    /// Bounds the radius on a grid fine enough for the degree of the series.
    pub(super) fn new(series: &Series, bounds: &Bounds) -> Self {
        let blocks = (series.coefficients().lmax() / 4 + 2).min(32);
        let side = blocks * BLOCK;
        let cells =
            (0..6 * side * side).into_par_iter().map(|i| bound_cell(series, bounds, side, i));
        let fine = Level { side, cells: cells.collect() };
        Self { coarse: fine.blocks(blocks), fine }
    }

    /// Returns in which coarse cell the ray is at distance `t`, and until when.
    #[inline]
    pub(super) fn coarse(&self, ray: &Ray, t: f64) -> Stay {
        self.coarse.stay(ray, t)
    }

    /// Returns in which fine cell the ray is at distance `t`, and until when.
    #[inline]
    pub(super) fn fine(&self, ray: &Ray, t: f64) -> Stay {
        self.fine.stay(ray, t)
    }
}

/// Bounds the radius over cell `i` of a level.
fn bound_cell(series: &Series, bounds: &Bounds, side: usize, i: usize) -> Range {
    let (face, cell) = (i / (side * side), i % (side * side));
    let edge = |k: usize| 2.0 * k as f64 / side as f64 - 1.0;
    let (row, column) = (cell / side, cell % side);
    let corner = |di: usize, dj: usize| direction(face, edge(column + di), edge(row + dj));
    let middle = direction(face, edge(column) + 1.0 / side as f64, edge(row) + 1.0 / side as f64);
    let corners = [corner(0, 0), corner(0, 1), corner(1, 0), corner(1, 1)];
    let radius = corners.map(|c| middle.angle_between(c)).into_iter().fold(0.0, f64::max) + MARGIN;
    let jet = series.jet(middle);
    let reach = jet.gradient.length() * radius + 0.5 * bounds.curvature * radius * radius;
    let (min, max) = ((jet.value - reach).max(bounds.min), (jet.value + reach).min(bounds.max));
    // Rounding to f32 must not tighten the bounds.
    Range { min: (min as f32).next_down(), max: (max as f32).next_up() }
}

/// Returns the unit vector through (u, v) of a cube face; faces 0..6 are +x, -x, +y, -y, +z, -z.
fn direction(face: usize, u: f64, v: f64) -> DVec3 {
    let w = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    let mut d = DVec3::ZERO;
    let axis = face / 2;
    d[axis] = w;
    d[(axis + 1) % 3] = u * w;
    d[(axis + 2) % 3] = v * w;
    d.normalize()
}

impl Level {
    /// Joins blocks of cells into one each.
    fn blocks(&self, side: usize) -> Self {
        let fine = |face: usize, row: usize, column: usize| {
            self.cells[(face * self.side + row) * self.side + column]
        };
        let join = |i: usize| {
            let (face, row, column) = (i / (side * side), i / side % side, i % side);
            (0..BLOCK * BLOCK)
                .map(|k| fine(face, row * BLOCK + k / BLOCK, column * BLOCK + k % BLOCK))
                .fold(Range { min: f32::INFINITY, max: 0.0 }, |a, b| Range {
                    min: a.min.min(b.min),
                    max: a.max.max(b.max),
                })
        };
        Self { side, cells: (0..6 * side * side).map(join).collect() }
    }

    /// Finds the cell of the ray's point at `t` and where the ray leaves it.
    #[inline]
    fn stay(&self, ray: &Ray, t: f64) -> Stay {
        let (p, o, d) = (ray.at(t), ray.origin, ray.direction);
        let a = p.abs();
        let axis = if a.x >= a.y && a.x >= a.z {
            0
        } else if a.y >= a.z {
            1
        } else {
            2
        };
        let w = p[axis];
        let n = self.side as f64;
        let nudge = 0.1 * MARGIN * w.abs();
        let (mut cell, mut until) = (2 * axis + usize::from(w < 0.0), f64::INFINITY);
        for q in [(axis + 2) % 3, (axis + 1) % 3] {
            let line = (0.5 * n * (p[q] / w + 1.0)).clamp(0.0, n - 1.0) as usize;
            cell = cell * self.side + line;
            // Along a ray q/w moves one way only: towards the upper plane q = b w of the cell, or
            // towards the lower.
            let up = d[q] * w - p[q] * d[axis] > 0.0;
            let b = 2.0 * (line + usize::from(up)) as f64 / n - 1.0;
            let exit = (b * o[axis] - o[q]) / (d[q] - b * d[axis]);
            // An exit behind says that the plane is not met ahead, unless it is behind by rounding
            // only.
            if exit >= t - nudge {
                until = until.min(exit);
            }
        }
        Stay { range: self.cells[cell], until: until.max(t) + nudge }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::math::sampling::uniform_sphere;
    use crate::sh::Coefficients;

    fn bumpy() -> (Series, Shell) {
        let mut c = Coefficients::zeros(10);
        c.set(0, 0, 1.0, 0.0);
        for l in 1..=10 {
            for m in 0..=l {
                c.set(l, m, 0.1 * ((l + 2 * m) as f64).sin() / l as f64, 0.1 / (l + m) as f64);
            }
        }
        let series = Series::new(&c).expect("degree 10");
        let shell = Shell::new(&series, &Bounds::of(&c).expect("degree 10"));
        (series, shell)
    }

    #[test]
    fn bounds_hold_all_along_every_stay() {
        let (series, shell) = bumpy();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(8);
        for i in 0..4000 {
            let from = 2.0 * uniform_sphere(rng.random());
            // Every other ray runs along a plane between cells or through a cube's edge.
            let to = 2.0 * uniform_sphere(rng.random());
            let to = if i % 2 == 0 { to } else { (to * 4.0).round() / 4.0 + DVec3::splat(1e-17) };
            let from = if i % 4 == 3 { (from * 4.0).round() / 4.0 } else { from };
            let Some(ray) = Ray::between(from, to) else { continue };
            for level in [Shell::coarse, Shell::fine] {
                let (mut t, mut stays) = (0.0, 0);
                while t < ray.t_max {
                    let stay = level(&shell, &ray, t);
                    assert!(stay.until > t, "no progress at {t} along {ray:?}");
                    for k in 0..=4 {
                        let at = ray.at((t + (stay.until - t) * f64::from(k) / 4.0).min(ray.t_max));
                        if at.length() > 1e-3 {
                            let f = series.value(at.normalize());
                            assert!(
                                f64::from(stay.range.min) <= f && f <= f64::from(stay.range.max),
                                "{ray:?}"
                            );
                        }
                    }
                    (t, stays) = (stay.until, stays + 1);
                    assert!(stays < 1000, "creeping along {ray:?}");
                }
            }
        }
    }

    #[test]
    fn fine_bounds_are_tight() {
        let (_, shell) = bumpy();
        let width = |r: &Range| f64::from(r.max - r.min);
        let mean = shell.fine.cells.iter().map(width).sum::<f64>() / shell.fine.cells.len() as f64;
        assert!(mean <= 0.1, "{mean}");
    }
}
