//! Which reflectances are possible.

use crate::math::Rgb;
use crate::{Error, Result};

/// Rejects reflectances outside [0, 1).
pub(super) fn check_reflectance(reflectance: Rgb) -> Result<()> {
    if reflectance.0.iter().all(|r| (0.0..1.0).contains(r)) {
        return Ok(());
    }
    Err(Error::Parameter(format!(
        "a reflectance must be at least 0 and below 1, found {:?}; with 1 light would never be \
         absorbed",
        reflectance.0
    )))
}
