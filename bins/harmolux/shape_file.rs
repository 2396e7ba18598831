//! Coefficient files as several verbs read and write them.

use std::path::Path;

use harmolux::Result;
use harmolux::io::coefficients::{Shape, shtools_text};
use harmolux::io::output::{Kind, Output};
use harmolux::sh::Convention;

/// Checks that a coefficient file can be written, before the work.
pub(crate) fn open(path: &Path, force: bool) -> Result<Output> {
    Output::open(path, &Kind::COEFFICIENTS, force)
}

/// Writes a shape.
pub(crate) fn write(output: Output, shape: &Shape) -> Result<()> {
    output.write(&shtools_text::write(shape, Convention::default())?)
}
