//! `harmolux new`: a scene to begin with.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use harmolux::Result;
use harmolux::io::output::{Kind, Output};
use serde_json::json;

use crate::common::exit::Code;
use crate::common::{paths, say};

/// Write a commented scene to begin with
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux new room.toml                then: harmolux render room.toml --quick
  harmolux new office.toml office       then: harmolux illum office.toml")]
pub(crate) struct New {
    /// The scene file to write
    #[arg(value_name = "SCENE.toml")]
    pub(crate) scene: PathBuf,
    /// What it shows
    #[arg(default_value = "room")]
    pub(crate) kind: Starter,
    /// Replace a file that is there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// What is written.
const SCENE: Kind = Kind::unmarked("a scene", &["toml"]);

/// A scene to begin with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Starter {
    /// A room with a lamp, a ball and a table
    Room,
    /// Lux at desks, and whether a requirement is met
    Office,
    /// Two planes, held to an exact solution
    Sobolev,
    /// Four materials on plinths
    Gallery,
}

impl Starter {
    /// Returns the text of the scene.
    const fn text(self) -> &'static str {
        match self {
            Self::Room => include_str!("room.toml"),
            Self::Office => include_str!("office.toml"),
            Self::Sobolev => include_str!("../../../data/scenes/sobolev.toml"),
            Self::Gallery => include_str!("gallery.toml"),
        }
    }

    /// Returns the verb to try it with.
    const fn verb(self) -> &'static str {
        match self {
            Self::Room | Self::Gallery => "render",
            Self::Office | Self::Sobolev => "illum",
        }
    }
}

/// Runs the verb.
pub(crate) fn run(verb: &New, as_json: bool) -> Result<Code> {
    let output = Output::open(&verb.scene, &SCENE, verb.force)?;
    output.write(verb.kind.text().as_bytes())?;
    let next = format!("harmolux {} {}", verb.kind.verb(), verb.scene.display());
    if as_json {
        let mut value = json!({ "next": next });
        paths::put(&mut value, "written", &verb.scene);
        say::json(&value);
    } else {
        say::note(&format!("written {}: now try `{next}`", verb.scene.display()));
    }
    Ok(Code::Done)
}
