//! The part of a picture that is computed.

use crate::{Error, Result};

/// Bounds a part of a picture, pixels: from the column and row `min` to before `max`, counted from
/// the top left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    min: [u32; 2],
    max: [u32; 2],
}

impl Window {
    /// Takes the whole of a picture.
    pub const fn whole(resolution: [u32; 2]) -> Self {
        Self { min: [0, 0], max: resolution }
    }

    /// Takes the pixels from column and row `min` to before `max`.
    ///
    /// # Errors
    /// [`Error::Parameter`] when that is no pixel.
    pub fn new(min: [u32; 2], max: [u32; 2]) -> Result<Self> {
        if (0..2).all(|k| min[k] < max[k]) {
            return Ok(Self { min, max });
        }
        let [x0, y0, x1, y1] = [min[0], min[1], max[0], max[1]];
        Err(Error::Parameter(format!(
            "empty crop {x0},{y0},{x1},{y1}: write left,top,right,bottom; right must exceed left, \
             bottom top"
        )))
    }

    /// Returns the column and row of the first pixel.
    pub const fn min(&self) -> [u32; 2] {
        self.min
    }

    /// Returns the column and row behind the last pixel.
    pub const fn max(&self) -> [u32; 2] {
        self.max
    }

    /// Returns the number of columns and rows.
    pub const fn size(&self) -> [u32; 2] {
        [self.max[0] - self.min[0], self.max[1] - self.min[1]]
    }

    /// Whether a picture of this size holds all of it.
    pub const fn is_within(&self, resolution: [u32; 2]) -> bool {
        self.max[0] <= resolution[0] && self.max[1] <= resolution[1]
    }

    /// Returns the same part of the same picture with half the columns and rows, at least one pixel
    /// of it.
    #[must_use]
    pub fn halved(&self) -> Self {
        Self { min: self.min.map(|n| n / 2), max: self.max.map(|n| n.div_ceil(2)) }
    }
}
