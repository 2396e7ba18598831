//! Where a table that is also a plot goes, by the extension of a file; and several outputs of one
//! run.

use std::path::Path;

use harmolux::Result;
use harmolux::io::output::{Output, Stage};
use harmolux::io::tables::Table;
use harmolux::plots::Figure;

use crate::common::plot::{PlotFormat, unknown_output};
use crate::common::say;

/// Does each of several writes, whatever becomes of the others: all that fails is told, the last
/// by whoever gets it from here.
pub(crate) fn write_all(writes: impl IntoIterator<Item = Result<()>>) -> Result<()> {
    let mut all = Ok(());
    for done in writes {
        if let (Err(earlier), Err(_)) = (&all, &done) {
            say::error(earlier);
        }
        all = if done.is_err() { done } else { all };
    }
    all
}

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

    /// Returns where it goes.
    pub(crate) fn path_at(&self, stage: Stage) -> &Path {
        let (Self::Table(output) | Self::Plot(_, output)) = self;
        output.path_at(stage)
    }

    /// Writes the table, or the plot.
    pub(crate) fn write(self, table: &Table, figure: &Figure, stage: Stage) -> Result<()> {
        match self {
            Self::Table(mut output) => output.write_at(stage, &table.to_csv()?),
            Self::Plot(format, output) => format.write(figure, output, stage),
        }
    }
}
