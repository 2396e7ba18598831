//! Evaluation at many directions, one at a time, by the way that suits the degree.

use glam::DVec3;

use super::{Coefficients, GridSeries, Jet, Series};
use crate::Result;

/// The degree from which scattered directions go by way of a grid: there it begins to be faster.
pub(crate) const GRIDDED_FROM: usize = 96;

/// What a gridded value may be off, as a part of the largest value.
const GRIDDED_ERROR: f64 = 1e-11;

/// Evaluates a series at a cost per direction that is bounded whatever the degree.
pub(crate) enum Evaluator {
    Plain(Box<Series>),
    Gridded(Box<GridSeries>),
}

impl Evaluator {
    /// Prepares the evaluation.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] for a degree too high to evaluate.
    pub(crate) fn new(coefficients: &Coefficients) -> Result<Self> {
        let series = Series::new(coefficients)?;
        Ok(if coefficients.lmax() < GRIDDED_FROM {
            Self::Plain(Box::new(series))
        } else {
            Self::Gridded(Box::new(GridSeries::new(series)?))
        })
    }

    /// Returns the coefficients of the series.
    pub(crate) fn coefficients(&self) -> &Coefficients {
        match self {
            Self::Plain(series) => series.coefficients(),
            Self::Gridded(series) => series.coefficients(),
        }
    }

    /// Evaluates f at the unit vector `direction`.
    pub(crate) fn value(&self, direction: DVec3) -> f64 {
        match self {
            Self::Plain(series) => series.value(direction),
            Self::Gridded(series) => series.value(direction),
        }
    }

    /// Evaluates f and its surface gradient at the unit vector `direction`.
    pub(crate) fn jet(&self, direction: DVec3) -> Jet {
        match self {
            Self::Plain(series) => series.jet(direction),
            Self::Gridded(series) => series.jet(direction),
        }
    }

    /// Returns what a value may be off, `largest` being that of all.
    pub(crate) fn error(&self, largest: f64) -> f64 {
        let gridded = if let Self::Gridded(_) = self { GRIDDED_ERROR * largest } else { 0.0 };
        super::rounding(self.coefficients()) + gridded
    }
}
