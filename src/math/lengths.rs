//! Which lengths can be computed with.

use crate::{Error, Result};

/// The smallest and the largest size of a thing, metres: squares of areas are lengths to the fourth
/// power, and the parts of a thing are far smaller than the whole.
const SIZES: [f64; 2] = [1e-60, 1e60];

/// Asks for a size, metres, whose areas, their squares and volumes are numbers; `what` has it. None
/// at all (0) is for others to judge.
pub(crate) fn require_measurable(what: &str, size: f64) -> Result<()> {
    let [least, most] = SIZES;
    if size == 0.0 || (least..=most).contains(&size) {
        return Ok(());
    }
    Err(Error::Geometry(format!(
        "{what} is {size:.3e} m, but areas can be squared from {least:e} m to {most:e} m only; \
         scale it, or state its unit"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_beyond_all_bodies_are_refused() {
        for size in [0.0, 1e-60, 1.0, 1e60] {
            assert!(require_measurable("it", size).is_ok(), "{size}");
        }
        for size in [5e-324, 1e-61, 1e61, f64::INFINITY, f64::NAN] {
            let error = require_measurable("its size", size).expect_err("refused").to_string();
            assert!(error.starts_with(&format!("its size is {size:.3e} m, but")), "{error}");
        }
    }
}
