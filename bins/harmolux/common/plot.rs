//! Plots to files and to the terminal.

use std::io::IsTerminal;
use std::path::Path;

use harmolux::io::output::{Kind, Output, Stage};
use harmolux::plots::Figure;
use harmolux::{Error, Result};

use crate::common::say;

/// The size of a terminal that does not tell its own.
const TERMINAL: [usize; 2] = [100, 30];

/// Names the format of a plot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PlotFormat {
    Svg,
    Png,
}

impl PlotFormat {
    /// Returns the format by the extension; `None` for anything but a plot.
    pub(crate) fn of_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?;
        [("svg", Self::Svg), ("png", Self::Png)]
            .into_iter()
            .find_map(|(e, format)| e.eq_ignore_ascii_case(extension).then_some(format))
    }

    /// Describes its files.
    pub(crate) fn kind(self) -> Kind {
        match self {
            Self::Svg => Kind::SVG,
            Self::Png => Kind::PNG,
        }
    }

    /// Writes a figure.
    pub(crate) fn write(self, figure: &Figure, output: Output, stage: Stage) -> Result<()> {
        let mut output = output;
        match self {
            Self::Svg => output.write_at(stage, figure.to_svg()?.as_bytes()),
            Self::Png => output.write_at(stage, &figure.to_png()?),
        }
    }
}

/// Rejects a name that is none of what a verb can write.
pub(crate) fn unknown_output(path: &Path, extensions: &str) -> Error {
    Error::Parameter(format!(
        "{}: the extension tells what is written: name a file {extensions}",
        path.display()
    ))
}

/// Prints a figure as text, as wide as the terminal is; in colour on a terminal only.
pub(crate) fn print(figure: &Figure) -> Result<()> {
    let [columns, rows] = match terminal_size::terminal_size() {
        Some((width, height)) => [usize::from(width.0), usize::from(height.0).saturating_sub(2)],
        None => TERMINAL,
    };
    let coloured = std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    say::raw(&figure.to_terminal(columns.min(120), rows.min(36), coloured)?);
    Ok(())
}
