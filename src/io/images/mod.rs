//! Images as bytes: PNG to look at, EXR to compute with. Pixel 0 is the top left, rows follow from
//! left to right.

mod exr;
mod png;

pub use exr::{Attribute, Computed, Exr, colour_channels, colour_samples};
pub use png::{NOT_FINITE, Png, encode_png, png, shown};

use crate::{Error, Result};

/// Rejects sizes that do not multiply to the number of pixels, and empty images.
fn check_size(width: usize, height: usize, pixels: usize) -> Result<()> {
    if width.checked_mul(height) == Some(pixels) && pixels > 0 {
        return Ok(());
    }
    Err(Error::Parameter(format!(
        "an image of {width} x {height} cannot be made of {pixels} pixels"
    )))
}
