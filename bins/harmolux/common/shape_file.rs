//! Coefficient files as several verbs write them: the extension chooses the format.

use std::path::Path;

use harmolux::fit::Shape;
use harmolux::io::coefficients::{SeriesFormat, Tolerance, WriteOptions, encode};
use harmolux::io::output::{Kind, Output};
use harmolux::sh::require_positive;
use harmolux::{Error, Result};

use crate::common::{advice, idle, say};

/// The highest degree of which it is looked for certain whether the radius is positive: above it
/// that takes longer than most of what is done with a file.
const LOOKED_AT: usize = 360;

/// Warns of a shape whose radius is not positive in every direction, which is no surface.
pub(crate) fn warn_of_no_surface(path: &Path, shape: &Shape) -> Result<()> {
    if shape.coefficients.lmax() > LOOKED_AT {
        return Ok(());
    }
    match require_positive(&shape.coefficients) {
        Err(error @ (Error::Geometry(_) | Error::Advised { .. })) => {
            let said = advice::told(&error);
            say::warning(&format!("{}: no closed surface: {said}", path.display()));
            Ok(())
        }
        other => other,
    }
}

/// Refuses a tolerance for a format that writes all digits.
pub(crate) fn take_tolerance(format: SeriesFormat, tolerance: Option<Tolerance>) -> Result<()> {
    let given = tolerance.is_some() && !format.is_lossy();
    let why = format!("{} has all digits; only .hxc is within a tolerance", format.noun());
    idle::refuse(&why, &[(given, "--tolerance")])
}

/// A coefficient file that can be written.
#[derive(Debug)]
pub(crate) struct ShapeFile {
    output: Output,
    format: SeriesFormat,
}

/// Checks that a coefficient file can be written, before the work.
pub(crate) fn open(path: &Path, force: bool) -> Result<ShapeFile> {
    opened(path, |kind| Output::open(path, kind, force))
}

/// As [`open`], for a run that goes on: a file that this program wrote may stand there.
pub(crate) fn open_again(path: &Path, force: bool) -> Result<ShapeFile> {
    opened(path, |kind| Output::open_again(path, kind, force))
}

fn opened(path: &Path, open: impl FnOnce(&Kind) -> Result<Output>) -> Result<ShapeFile> {
    let format = SeriesFormat::of_extension(path).unwrap_or(SeriesFormat::Text);
    format.require_written()?;
    Ok(ShapeFile { output: open(&format.kind())?, format })
}

impl ShapeFile {
    /// Refuses a tolerance that this format has no use for.
    pub(crate) fn take_tolerance(&self, tolerance: Option<Tolerance>) -> Result<()> {
        take_tolerance(self.format, tolerance)
    }

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
