//! Repairs of a mesh that the command line asks for, shared by the verbs that read meshes.

use std::path::Path;

use clap::Args;
use harmolux::Result;
use harmolux::mesh::{Mesh, RepairReport, RepairSettings, repair};

use crate::common::about::about;
use crate::common::say;

/// What is to be mended in a mesh; nothing is unless asked for
#[derive(Debug, Args)]
pub(crate) struct Repairs {
    /// Repair the mesh: join vertices at equal places, drop faces without area and doubled ones,
    /// turn faces outwards
    #[arg(long)]
    pub(crate) repair: bool,
    /// Join vertices up to this far apart, metres
    #[arg(
        long, value_name = "METRES", default_value_t = 0.0, requires = "repair",
        value_parser = length
    )]
    pub(crate) weld: f64,
    /// With --repair, fill holes whose rim has at most so many edges
    #[arg(long, value_name = "EDGES", default_value_t = 0, requires = "repair")]
    pub(crate) fill_holes: usize,
    /// Keep the piece with the largest area alone
    #[arg(long, requires = "repair")]
    pub(crate) largest_piece: bool,
}

impl Repairs {
    /// Repairs a mesh if that was asked for, and says on stderr what was done.
    pub(crate) fn apply(&self, path: &Path, mesh: Mesh) -> Result<(Mesh, Option<RepairReport>)> {
        if !self.repair {
            return Ok((mesh, None));
        }
        let settings = RepairSettings {
            weld: self.weld,
            largest_only: self.largest_piece,
            fill: self.fill_holes,
        };
        let (mesh, done) = repair(&mesh, &settings).map_err(|e| about(path, e))?;
        say::note(&format!("{}: {done}", path.display()));
        Ok((mesh, Some(done)))
    }
}

/// Reads a value of the command line.
fn length(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(length) if (0.0..f64::INFINITY).contains(&length) => Ok(length),
        _ => Err("write a length in metres, such as 1e-6".into()),
    }
}
