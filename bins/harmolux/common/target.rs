//! Where a table that is also a plot goes, by the extension of a file.

use std::path::Path;

use harmolux::Result;
use harmolux::io::output::Output;
use harmolux::io::tables::Table;
use harmolux::plots::Figure;

use crate::common::plot::{PlotFormat, unknown_output};

/// A file to write.
pub(crate) enum Target {
    Table(Output),
    Plot(PlotFormat, Output),
}

impl Target {
    /// Opens a file for a table (.csv) or a plot (.svg, .png).
    pub(crate) fn open(path: &Path, table: &Table, force: bool) -> Result<Self> {
        if let Some(format) = PlotFormat::of_extension(path) {
            return Ok(Self::Plot(format, Output::open(path, &format.kind(), force)?));
        }
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv")) {
            return Ok(Self::Table(Output::open(path, &table.csv_kind()?, force)?));
        }
        Err(unknown_output(path, ".csv, .svg or .png"))
    }

    /// Writes the table, or the plot.
    pub(crate) fn write(self, table: &Table, figure: &Figure) -> Result<()> {
        match self {
            Self::Table(output) => output.write(&table.to_csv()?),
            Self::Plot(format, output) => format.write(figure, output),
        }
    }
}
