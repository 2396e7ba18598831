//! What the constructors of the shapes ask of their parameters, and how they say so.
//!
//! Sizes are kept within 1e-100..1e100, so that squares and products neither overflow nor
//! underflow.

use std::fmt::Display;

use glam::DVec3;

use crate::{Error, Result};

const SMALLEST: f64 = 1e-100;
const LARGEST: f64 = 1e100;

/// Accepts a positive finite length.
pub(super) fn length(what: &str, value: f64) -> Result<f64> {
    if (SMALLEST..=LARGEST).contains(&value) {
        return Ok(value);
    }
    Err(refused(what, "must be a positive, finite number of metres", value))
}

/// Accepts a finite point.
pub(super) fn point(what: &str, value: DVec3) -> Result<DVec3> {
    if value.abs().max_element() <= LARGEST && !value.is_nan() {
        return Ok(value);
    }
    Err(refused(what, "must have three finite coordinates", value))
}

/// Accepts a finite vector that is not zero, and normalises it.
pub(super) fn direction(what: &str, value: DVec3) -> Result<DVec3> {
    let size = value.length();
    if (SMALLEST..=LARGEST).contains(&size) {
        return Ok(value / size);
    }
    Err(refused(what, "must be a finite vector that is not zero", value))
}

/// Accepts a size that rounding can resolve at the place where the shape stands.
pub(super) fn resolvable(what: &str, size: f64, at: DVec3) -> Result<()> {
    let coordinate = at.abs().max_element();
    if size >= 1e-12 * coordinate {
        return Ok(());
    }
    Err(Error::Parameter(format!(
        "{what} of {size} m is lost in rounding at coordinates of {coordinate} m; move the scene \
         nearer to the origin"
    )))
}

/// Says what a parameter must be and what was found.
fn refused(what: &str, must: &str, found: impl Display) -> Error {
    Error::Parameter(format!("{what} {must}, found {found}"))
}
