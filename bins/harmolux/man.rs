//! `harmolux man`: the manual pages.

use std::path::{Path, PathBuf};

use clap::{Args, CommandFactory};
use clap_mangen::Man as Page;
use harmolux::io::output::{Kind, Output};
use harmolux::{Error, Result};
use serde_json::json;

use crate::Arguments;
use crate::common::exit::Code;
use crate::common::{folders, paths, say};

/// Write the manual pages: one of the tool, one of each verb
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux man -o ~/.local/share/man/man1    then: man harmolux-render")]
pub(crate) struct Man {
    /// The folder of the pages; it is made where it is not there
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) output: PathBuf,
    /// Replace pages that are there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// What is written.
const PAGE: Kind = Kind::unmarked("a manual page", &["1"]);

/// Runs the verb.
pub(crate) fn run(verb: &Man, as_json: bool) -> Result<Code> {
    let written = folders::within(&verb.output, || write(&verb.output, verb.force))?;
    if as_json {
        let mut value = json!({});
        paths::put_all(&mut value, "written", written.iter().map(PathBuf::as_path));
        say::json(&value);
    } else {
        say::note(&format!("{} pages written to {}", written.len(), verb.output.display()));
    }
    Ok(Code::Done)
}

/// Writes the pages into a folder and returns their files.
fn write(folder: &Path, force: bool) -> Result<Vec<PathBuf>> {
    let mut tool = Arguments::command().disable_help_subcommand(true);
    tool.build();
    let pages = [&tool].into_iter().chain(tool.get_subcommands()).map(|command| {
        let page = Page::new(command.clone());
        let path = folder.join(page.get_filename());
        let mut text = Vec::new();
        page.render(&mut text).map_err(|e| Error::io(&path, "write", e))?;
        Output::open(&path, &PAGE, force)?.write(&text)?;
        Ok(path)
    });
    pages.collect()
}
