//! Meshes, points and shapes as several verbs read them.

use std::path::{Path, PathBuf};

use glam::DVec3;
use harmolux::Result;
use harmolux::io::coefficients::{self, NamedShape, ReadOptions, SeriesFormat, spharm_pdm};
use harmolux::io::input::{FilesRead, Input};
use harmolux::io::meshes::{self, MeshFormat};
use harmolux::io::points::{self, PointOptions};
use harmolux::mesh::{Mesh, Points, RepairReport};

use crate::common::flags::MeshHabits;
use crate::common::say;

/// A mesh from a file.
pub(crate) struct MeshRead {
    pub(crate) mesh: Mesh,
    /// What was repaired, where that was asked for.
    pub(crate) repair: Option<RepairReport>,
    pub(crate) files: FilesRead,
}

/// Reads a mesh, turns it to metres, z up, and repairs it if asked to.
pub(crate) fn read_mesh(input: Input, habits: &MeshHabits) -> Result<MeshRead> {
    let path = input.path();
    let (mesh, read) = read_surface(input)?;
    let mesh = mesh.with_up(habits.up).scaled(habits.unit.metres())?;
    let (mesh, repair) = habits.repairs.apply(path, mesh)?;
    Ok(MeshRead { mesh, repair, files: read })
}

/// Reads a mesh as it stands in its file, or the parametric surface of SPHARM-PDM as one, and says
/// what was passed over.
pub(crate) fn read_surface(mut input: Input) -> Result<(Mesh, FilesRead)> {
    let (path, length) = (input.path(), input.length());
    let (mesh, read) = match coefficients::recognise_content(input.ahead()?, length) {
        Some(SeriesFormat::SpharmPdm) => spharm_pdm::read_surface(input),
        _ => meshes::read_input(input),
    }?;
    for remark in &read.remarks {
        say::note(&format!("{}: {remark}", path.display()));
    }
    Ok((mesh, read))
}

/// Says what a mesh or point file consists of, with the files that it names.
pub(crate) fn files(path: &Path) -> Result<FilesRead> {
    let input = Input::open_file(path)?;
    match MeshFormat::of_extension(input.name()) {
        // Only its reader knows what it names.
        Some(MeshFormat::Gltf) => Ok(meshes::read_input(input)?.1),
        _ => input.finish(),
    }
}

/// Whether a file holds points: its content has their mark, its name says it, or its beginning
/// where that is neither of a mesh nor of coefficients.
pub(crate) fn holds_points(input: &mut Input) -> Result<bool> {
    let (path, length) = (input.name(), input.length());
    let head = input.ahead()?;
    if points::is_marked(head) || points::is_points(path) {
        return Ok(true);
    }
    if MeshFormat::of_extension(path).is_some() {
        return Ok(false);
    }
    let is_other = meshes::recognise(head, length).is_some()
        || coefficients::recognise_content(head, length).is_some();
    Ok(!is_other && points::recognise(head))
}

/// Reads a point file and turns it to metres, z up.
pub(crate) fn read_points(
    input: Input,
    options: PointOptions,
    habits: &MeshHabits,
) -> Result<(Points, FilesRead)> {
    let (mut cloud, read) = points::read_input(input, options)?;
    cloud.positions.iter_mut().for_each(|p| *p = habits.unit.metres() * habits.up.to_z(*p));
    Ok((cloud, read))
}

/// Reads the shapes of several coefficient files, of a table all rows.
pub(crate) fn read_shapes(paths: &[PathBuf], options: &ReadOptions) -> Result<Vec<NamedShape>> {
    let read = paths.iter().map(|path| coefficients::read_all(path, options));
    Ok(read.collect::<Result<Vec<_>>>()?.concat())
}

/// Averages the expansion centres, so that shapes about one point keep it.
pub(crate) fn mean_centre(shapes: &[NamedShape], weights: &[f64]) -> DVec3 {
    let first = shapes.first().map_or(DVec3::ZERO, |s| s.shape.centre);
    let total: f64 = weights.iter().sum();
    let offsets = shapes.iter().zip(weights).map(|(s, w)| w / total * (s.shape.centre - first));
    first + offsets.sum::<DVec3>()
}

/// Returns the format of a coefficient file by its beginning; a mesh is none, whatever its
/// extension.
pub(crate) fn series_format(
    input: &mut Input,
    options: &ReadOptions,
) -> Result<Option<SeriesFormat>> {
    let (path, length) = (input.name(), input.length());
    let head = input.ahead()?;
    let told = options.format.or_else(|| coefficients::recognise_content(head, length));
    let is_mesh = || meshes::recognise(head, length).is_some();
    Ok(told.or_else(|| if is_mesh() { None } else { SeriesFormat::of_extension(path) }))
}
