//! The ranges that the parameters of this room share, each refused with the name, the value and
//! what would do.

use crate::{Error, Result};

/// Accepts a finite number above 0.
pub(super) fn positive(name: &str, value: f64) -> Result<()> {
    accept(value.is_finite() && value > 0.0, name, value, "a finite number above 0")
}

/// Accepts a finite number of at least 0.
pub(super) fn not_negative(name: &str, value: f64) -> Result<()> {
    accept(value.is_finite() && value >= 0.0, name, value, "a finite number of at least 0")
}

/// Accepts 0 <= `value` <= 1.
pub(super) fn reflectance(name: &str, value: f64) -> Result<()> {
    accept((0.0..=1.0).contains(&value), name, value, "between 0 and 1")
}

/// Accepts 0 <= `value` < 1, where light that is never absorbed has no answer.
pub(super) fn absorbing(name: &str, value: f64) -> Result<()> {
    accept((0.0..1.0).contains(&value), name, value, "at least 0 and below 1")
}

/// Accepts when `condition` holds (NaN never does); otherwise says what `name` must be.
pub(super) fn accept(condition: bool, name: &str, value: f64, range: &str) -> Result<()> {
    if condition {
        return Ok(());
    }
    Err(Error::Parameter(format!("{name} is {value}; it must be {range}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_and_infinity_are_refused_everywhere() {
        for value in [f64::NAN, f64::INFINITY, -1.0] {
            for check in [positive, not_negative, reflectance, absorbing] {
                assert!(check("height", value).is_err(), "{value}");
            }
        }
    }

    #[test]
    fn limits_belong_where_the_documentation_says() {
        assert!(positive("x", 0.0).is_err() && not_negative("x", 0.0).is_ok());
        assert!(reflectance("x", 1.0).is_ok() && absorbing("x", 1.0).is_err());
    }

    #[test]
    fn message_names_value_and_range() {
        let error = absorbing("reflectance", 1.5).expect_err("too bright");
        assert_eq!(error.to_string(), "reflectance is 1.5; it must be at least 0 and below 1");
    }
}
