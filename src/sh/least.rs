//! The least value of a series, bounded from below as closely as it takes to tell whether it is
//! positive.
//!
//! At its minimum a function has no slope: within an angle h of it f rises by at most M h^2 / 2, M
//! the bound of its second derivative along great circles (see `bounds`). A cell of the sphere that
//! reaches h about its middle c therefore holds the minimum only if that is at least f(c) - M h^2 /
//! 2. Cells where this is above what is asked for are dropped, the others halved, so that only
//! those about the minimum are looked at closely.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use rayon::prelude::*;

use super::bounds::curvature;
use super::shape::angles;
use super::{Coefficients, Grid, Series, rounding};
use crate::error::Advice;
use crate::{Error, Result};

/// Holds what is known of the least value of a series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Least {
    /// A lower bound, true everywhere on the sphere.
    pub bound: f64,
    /// The least value that was found.
    pub value: f64,
    /// Where it was found, a unit vector.
    pub direction: DVec3,
}

/// The part of the least value found that its lower bound reaches where all values are positive.
pub(super) const TIGHT: f64 = 0.5;

/// The part of the largest value up to which a value counts as 0: rays are traced to no less of a
/// body.
pub(super) const SMALLEST: f64 = 1e-6;

/// The part of the largest value from which on one below 0 is no ringing: these may be heights.
const HEIGHTS: f64 = 0.2;

/// The most values that are taken, and the most products of coefficient and function that they may
/// cost but for the first.
const VALUES: usize = 1 << 22;
const PRODUCTS: usize = 1 << 33;
const FIRST: usize = 1 << 14;

impl Least {
    /// Makes sure that a radius whose upper bound is `largest` is positive in every direction.
    ///
    /// # Errors
    /// [`Error::Geometry`] with the place of the least value.
    pub fn require_positive(&self, largest: f64) -> Result<()> {
        let Self { bound, value, direction } = *self;
        if bound > 0.0 && bound.is_finite() && largest.is_finite() {
            return Ok(());
        }
        if !(value.is_finite() && largest.is_finite()) {
            let text = "the radius is beyond what numbers can hold: give the shape in another unit";
            return Err(Error::Geometry(text.to_owned()));
        }
        let more = if value <= 0.0 {
            String::new()
        } else if value <= SMALLEST * largest {
            format!(", less than a millionth of the largest, {largest:.3e}")
        } else {
            format!(", and no more is certain than that it is above {bound:.3e}")
        };
        let error = Error::Geometry(format!(
            "the radius must be positive in every direction, but is {value:.3e} at {}{more}; \
             choose another centre, or lower the degree or filter the series if it rings",
            angles(direction)
        ));
        Err(if value < -HEIGHTS * largest { error.advise(Advice::AddRadius) } else { error })
    }
}

/// A cell between two circles of latitude and two meridians.
#[derive(Debug, Clone, Copy)]
struct Cell {
    theta: f64,
    phi: f64,
    /// Half its extents in theta and phi.
    half: [f64; 2],
    /// The value in its middle.
    value: f64,
}

impl Cell {
    fn direction(&self) -> DVec3 {
        let ((s, z), (sin, cos)) = (self.theta.sin_cos(), self.phi.sin_cos());
        DVec3::new(s * cos, s * sin, z)
    }

    /// Returns half the lengths of its sides, along theta and along the longest circle of latitude
    /// within it; a cell may reach over a pole.
    fn sides(&self) -> [f64; 2] {
        let [a, b] = self.half;
        let (low, high) = (self.theta - a, self.theta + a);
        let holds_equator = low <= FRAC_PI_2 && high >= FRAC_PI_2;
        let longest = if holds_equator { 1.0 } else { low.sin().abs().max(high.sin().abs()) };
        [a, b * longest]
    }

    /// Bounds the least value, if it is in this cell.
    fn bound(&self, curvature: f64, rounding: f64) -> f64 {
        let [a, b] = self.sides();
        self.value - 0.5 * curvature * (a * a + b * b) - rounding
    }

    /// Halves the longer side; the values of the parts are not known yet.
    fn halves(&self) -> [Self; 2] {
        let [a, b] = self.sides();
        let axis = usize::from(b > a);
        [-0.5, 0.5].map(|to| {
            let mut part = *self;
            part.half[axis] *= 0.5;
            let by = to * self.half[axis];
            if axis == 0 {
                part.theta += by;
            } else {
                part.phi += by;
            }
            part
        })
    }
}

/// Bounds the least value of `f`, all of whose samples on an equispaced grid are positive: to at
/// least [`TIGHT`] of the least value found, unless that turns out to be as good as 0, or the work
/// grows beyond reason.
pub(super) fn refined(
    f: &Coefficients,
    grid: &Grid,
    samples: &[f64],
    largest: f64,
) -> Result<Least> {
    let (series, curvature, rounding) = (Series::new(f)?, curvature(f)?, rounding(f));
    let mut left = VALUES.min(FIRST.max(PRODUCTS / f.count().max(1)));
    let mut known = Known { lowest: f64::INFINITY, direction: DVec3::Z, dropped: f64::INFINITY };
    cells(grid, samples).for_each(|cell| known.look_at(&cell));
    let mut cells: Vec<Cell> =
        cells(grid, samples).filter(|c| known.keeps(c.bound(curvature, rounding))).collect();
    loop {
        if known.lowest <= SMALLEST * largest {
            return Ok(known.least(f64::NEG_INFINITY));
        }
        if cells.is_empty() || 2 * cells.len() > left {
            let bounds = cells.iter().map(|cell| cell.bound(curvature, rounding));
            return Ok(known.least(bounds.fold(f64::INFINITY, f64::min)));
        }
        left -= 2 * cells.len();
        cells = cells.iter().flat_map(Cell::halves).collect();
        cells.par_chunks_mut(256).for_each(|chunk| {
            let directions: Vec<DVec3> = chunk.iter().map(Cell::direction).collect();
            for (cell, value) in chunk.iter_mut().zip(series.values(&directions)) {
                cell.value = value;
            }
        });
        for cell in &cells {
            known.look_at(cell);
        }
        cells.retain(|cell| known.keeps(cell.bound(curvature, rounding)));
    }
}

/// What the cells have told so far.
struct Known {
    lowest: f64,
    direction: DVec3,
    /// The least bound of the cells that were dropped.
    dropped: f64,
}

impl Known {
    fn look_at(&mut self, cell: &Cell) {
        if cell.value < self.lowest {
            (self.lowest, self.direction) = (cell.value, cell.direction());
        }
    }

    /// Whether a cell of this bound may hold less than what is asked for.
    fn keeps(&mut self, bound: f64) -> bool {
        let keeps = bound < TIGHT * self.lowest;
        if !keeps {
            self.dropped = self.dropped.min(bound);
        }
        keeps
    }

    fn least(&self, left: f64) -> Least {
        let bound = self.dropped.min(left);
        Least { bound, value: self.lowest, direction: self.direction }
    }
}

/// Makes the cells around the samples of an equispaced grid.
fn cells<'a>(grid: &'a Grid, samples: &'a [f64]) -> impl Iterator<Item = Cell> + 'a {
    let (rings, azimuths) = (grid.rings().len(), grid.azimuths());
    let half = [FRAC_PI_2 / (rings - 1) as f64, PI / azimuths as f64];
    let cell = move |(i, value): (usize, &f64)| Cell {
        theta: PI * (i / azimuths) as f64 / (rings - 1) as f64,
        phi: 2.0 * PI * (i % azimuths) as f64 / azimuths as f64,
        half,
        value: *value,
    };
    samples.iter().enumerate().map(cell)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{EulerAngles, Rotation};
    use crate::sh::{analysis, least, range, rotate};

    /// Returns a radius that depends on the height alone, about an axis that no grid knows.
    fn about_an_axis(lmax: usize, radius: impl Fn(f64) -> f64) -> Coefficients {
        let grid = Grid::minimal(lmax);
        let values: Vec<f64> = (0..grid.len()).map(|i| radius(grid.direction(i).z)).collect();
        let upright = analysis(&values, &grid, lmax).expect("fine enough");
        let angles = EulerAngles { alpha: 0.3, beta: 0.7, gamma: 0.1 };
        rotate(&upright, &Rotation::from_euler(angles).expect("finite"))
    }

    #[test]
    fn small_positive_radius_is_certain_however_it_is_reached() {
        for small in [0.03, 1e-3, 1e-5] {
            for f in [
                about_an_axis(1, |z| 1.0 + (1.0 - small) * z),
                about_an_axis(2, |z| small + (3.0 - small) * z * z),
                about_an_axis(12, |z| small + 0.3 * (z - 0.4).powi(2) * (1.0 + z.powi(10))),
            ] {
                let found = least(&f).expect("small");
                assert!((0.49 * small..=small).contains(&found.bound), "{small}: {found:?}");
                assert!(found.value >= small - 1e-12 && found.value <= 2.0 * small, "{found:?}");
                assert_eq!(range(&f).expect("small").0, found.bound);
                assert!(found.require_positive(3.0).is_ok());
            }
        }
    }

    #[test]
    fn radius_that_touches_0_or_passes_it_is_refused_with_its_place() {
        for below in [0.0, 1e-9, 0.01] {
            for f in [
                about_an_axis(1, |z| 1.0 - below + z),
                about_an_axis(2, |z| 3.0 * z * z - below),
                about_an_axis(12, |z| 0.3 * (z - 0.4).powi(2) * (1.0 + z.powi(10)) - below),
            ] {
                let found = least(&f).expect("small");
                assert!(found.bound <= 0.0, "{below}: {found:?}");
                // Nearly 0 is looked at closely; below it any place will do.
                assert!((-below - 1e-12..=1e-5).contains(&found.value), "{below}: {found:?}");
                let error = found.require_positive(2.0).expect_err("refused").to_string();
                assert!(error.contains(" at theta = "), "{error}");
            }
        }
    }

    #[test]
    fn search_ends_where_the_least_value_is_nearly_reached_almost_everywhere() {
        let flat = about_an_axis(16, |z| 1e-5 + (0.5 * (1.0 + z)).powi(16));
        let found = least(&flat).expect("small");
        assert!(found.bound <= 1e-5 && found.value >= 0.99e-5, "{found:?}");
    }
}
