//! Meshes, points and shapes as several verbs read them.

use std::path::Path;

use harmolux::fit::Source;
use harmolux::io::coefficients::{self, ReadOptions, SeriesFormat};
use harmolux::io::{meshes, points};
use harmolux::mesh::{Mesh, Points, RepairReport};
use harmolux::{Error, Result};

use crate::common::flags::MeshHabits;

/// Reads a mesh, turns it to metres, z up, and repairs it if asked to.
pub(crate) fn read_mesh(path: &Path, habits: &MeshHabits) -> Result<Mesh> {
    Ok(read_and_repair(path, habits)?.0)
}

/// As [`read_mesh`], with what was repaired.
pub(crate) fn read_and_repair(
    path: &Path,
    habits: &MeshHabits,
) -> Result<(Mesh, Option<RepairReport>)> {
    let mesh = meshes::read(path)?.with_up(habits.up).scaled(habits.unit.metres())?;
    habits.repairs.apply(path, mesh)
}

/// Reads a point file and turns it to metres, z up.
pub(crate) fn read_points(path: &Path, habits: &MeshHabits) -> Result<Points> {
    let mut cloud = points::read(path)?;
    cloud.positions.iter_mut().for_each(|p| *p = habits.unit.metres() * habits.up.to_z(*p));
    Ok(cloud)
}

/// Names a file by its name and content.
pub(crate) fn source(path: &Path) -> Result<Source> {
    let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
    Ok(Source::new(path, &bytes))
}

/// Returns the format of a coefficient file; a mesh is none, whatever its extension.
pub(crate) fn series_format(
    path: &Path,
    bytes: &[u8],
    options: &ReadOptions,
) -> Option<SeriesFormat> {
    let told = options.format.or_else(|| coefficients::recognise_content(bytes));
    let is_mesh = || meshes::recognise(bytes).is_some();
    told.or_else(|| if is_mesh() { None } else { SeriesFormat::of_extension(path) })
}
