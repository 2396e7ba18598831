//! Coefficient files as several verbs write them: the extension chooses the format.

use std::path::Path;

use harmolux::Result;
use harmolux::fit::Shape;
use harmolux::io::coefficients::{SeriesFormat, Tolerance, WriteOptions, encode};
use harmolux::io::output::Output;

/// A coefficient file that can be written.
#[derive(Debug)]
pub(crate) struct ShapeFile {
    output: Output,
    format: SeriesFormat,
}

/// Checks that a coefficient file can be written, before the work.
pub(crate) fn open(path: &Path, force: bool) -> Result<ShapeFile> {
    let format = SeriesFormat::of_extension(path).unwrap_or(SeriesFormat::Text);
    Ok(ShapeFile { output: Output::open(path, &format.kind(), force)?, format })
}

impl ShapeFile {
    /// Writes a shape, the compact form to a thousandth of the mean radius.
    pub(crate) fn write(self, shape: &Shape) -> Result<()> {
        self.write_to(shape, WriteOptions::default().tolerance)
    }

    /// Writes a shape, the compact form to this tolerance.
    pub(crate) fn write_to(self, shape: &Shape, tolerance: Tolerance) -> Result<()> {
        let options = WriteOptions { tolerance, ..WriteOptions::default() };
        self.output.write(&encode(shape, self.format, &options)?)
    }
}
