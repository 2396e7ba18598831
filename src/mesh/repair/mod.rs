//! Repairs what `mesh_check` reports, in the order in which one step helps the next: weld, drop,
//! turn, keep, fill. Nothing here runs unless asked for, and the report says what was done.

mod fill;
mod flat;
mod orient;
mod weld;

use std::collections::HashMap;
use std::fmt;

use crate::mesh::Mesh;
use crate::mesh::report::{duplicate_faces, find};
use crate::mesh::triangle::is_collapsed;
use crate::{Error, Result, memory};

/// Sets a repair. The default joins vertices at equal coordinates, drops faces without area and
/// doubled ones, and turns the faces outwards.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RepairSettings {
    /// Vertices this near each other, metres, become one; 0 for those at equal coordinates.
    pub weld: f64,
    /// Keep the piece with the largest area alone.
    pub largest_only: bool,
    /// Fill holes whose rim has up to so many edges; 0 for none.
    pub fill: usize,
}

/// Says what a repair has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RepairReport {
    /// Vertices that became one with an earlier one.
    pub welded: usize,
    /// Faces without area that were dropped.
    pub zero_area: usize,
    /// Faces that repeated an earlier one and were dropped.
    pub duplicate: usize,
    /// Faces that were turned to the other side.
    pub turned: usize,
    /// Pieces that were dropped beside the largest.
    pub pieces: usize,
    /// Holes that were filled.
    pub filled: usize,
    /// Vertices that no face uses and that were dropped.
    pub unused: usize,
}

impl RepairReport {
    /// Whether there was nothing to do.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl fmt::Display for RepairReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let done: Vec<String> = [
            (self.welded, "joined", "vertex", "vertices"),
            (self.zero_area, "dropped", "face without area", "faces without area"),
            (self.duplicate, "dropped", "doubled face", "doubled faces"),
            (self.turned, "turned", "face", "faces"),
            (self.pieces, "dropped", "smaller piece", "smaller pieces"),
            (self.filled, "filled", "hole", "holes"),
            (self.unused, "dropped", "unused vertex", "unused vertices"),
        ]
        .into_iter()
        .filter(|&(count, ..)| count > 0)
        .map(|(count, verb, one, many)| {
            format!("{verb} {count} {}", if count == 1 { one } else { many })
        })
        .collect();
        f.write_str(if done.is_empty() { "nothing to repair" } else { "" })?;
        f.write_str(&done.join(", "))
    }
}

/// What the repair of a face takes, bytes: measured, and a quarter more.
const BYTES_EACH: f64 = 300.0;

/// Repairs a mesh. Faces are turned so that neighbours agree, piece by piece, and each piece
/// encloses a positive volume (of an open piece: about the middle of its bounds); a cavity's skin
/// is turned outwards too.
///
/// A face without area whose corners are three different vertices in a line cannot simply be
/// dropped: its neighbours would no longer meet. It trades its long side with the neighbour there,
/// which leaves the surface as it is.
///
/// # Errors
/// [`Error::Parameter`] unless the welding distance is finite and not negative;
/// [`Error::Geometry`] for a mesh so small or large that areas cannot be computed.
///
/// ```
/// use glam::DVec3;
/// use harmolux::mesh::{Mesh, RepairSettings, repair};
/// let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X, DVec3::Z];
/// let mesh = Mesh::new(corners, vec![[0, 1, 2], [0, 3, 4]])?;
/// let (mesh, done) = repair(&mesh, &RepairSettings::default())?;
/// assert_eq!((mesh.positions().len(), done.welded), (4, 1));
/// # Ok::<(), harmolux::Error>(())
/// ```
pub fn repair(mesh: &Mesh, settings: &RepairSettings) -> Result<(Mesh, RepairReport)> {
    if !(settings.weld.is_finite() && settings.weld >= 0.0) {
        return Err(Error::Parameter(format!(
            "vertices can be joined within a distance of 0 m or more, found {}",
            settings.weld
        )));
    }
    mesh.require_measurable()?;
    let faces = mesh.triangles().len();
    let what = format_args!("repairing {faces} faces");
    memory::ask_each(faces, BYTES_EACH, what, "take a coarser mesh")?;
    let mut done = RepairReport::default();
    let mut mesh = weld::welded(mesh, settings.weld, &mut done)?;
    mesh = without_collapsed(&mesh, &mut done)?;
    mesh = without_duplicates(mesh, &mut done)?;
    if settings.largest_only {
        mesh = largest_piece(&mesh, &mut done)?;
    }
    mesh = orient::oriented(&mesh, &mut done)?;
    mesh = flat::without_flat_faces(mesh, &mut done)?;
    if settings.fill > 0 {
        mesh = fill::filled(&mesh, settings.fill, &mut done)?;
    }
    Ok((compacted(&mesh, &mut done)?, done))
}

/// Drops the faces that name a vertex twice.
fn without_collapsed(mesh: &Mesh, done: &mut RepairReport) -> Result<Mesh> {
    let mut triangles = mesh.triangles().to_vec();
    triangles.retain(|t| !is_collapsed(t));
    done.zero_area = mesh.triangles().len() - triangles.len();
    Mesh::new(mesh.positions().to_vec(), triangles)
}

fn without_duplicates(mesh: Mesh, done: &mut RepairReport) -> Result<Mesh> {
    let repeated = duplicate_faces(&mesh);
    done.duplicate = repeated.len();
    if repeated.is_empty() {
        return Ok(mesh);
    }
    let stays = |face: &(usize, &[u32; 3])| repeated.binary_search(&(face.0 as u32)).is_err();
    let triangles = mesh.triangles().iter().enumerate().filter(stays).map(|(_, &t)| t).collect();
    Mesh::new(mesh.positions().to_vec(), triangles)
}

/// Keeps the piece of the largest area; faces that share a vertex are of one piece.
fn largest_piece(mesh: &Mesh, done: &mut RepairReport) -> Result<Mesh> {
    let mut parent: Vec<u32> = (0..mesh.positions().len() as u32).collect();
    for &[a, b, c] in mesh.triangles() {
        for other in [b, c] {
            let (root, other) = (find(&mut parent, a), find(&mut parent, other));
            parent[other as usize] = root;
        }
    }
    let mut areas: HashMap<u32, f64> = HashMap::new();
    for (face, t) in mesh.triangles().iter().enumerate() {
        *areas.entry(find(&mut parent, t[0])).or_default() += mesh.area_vector(face).length();
    }
    let largest =
        areas.iter().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0))).map(|(&root, _)| root);
    done.pieces = areas.len().saturating_sub(1);
    let triangles = mesh
        .triangles()
        .iter()
        .filter(|t| Some(find(&mut parent, t[0])) == largest)
        .copied()
        .collect();
    Mesh::new(mesh.positions().to_vec(), triangles)
}

/// Drops the vertices that no face uses.
fn compacted(mesh: &Mesh, done: &mut RepairReport) -> Result<Mesh> {
    let mut is_used = vec![false; mesh.positions().len()];
    mesh.triangles().iter().flatten().for_each(|&v| is_used[v as usize] = true);
    let mut number = vec![0_u32; is_used.len()];
    let mut positions = Vec::new();
    for (v, &p) in mesh.positions().iter().enumerate().filter(|&(v, _)| is_used[v]) {
        number[v] = positions.len() as u32;
        positions.push(p);
    }
    // Those that were joined to another are told apart.
    done.unused = (is_used.len() - positions.len()).saturating_sub(done.welded);
    let triangles = mesh.triangles().iter().map(|t| t.map(|v| number[v as usize])).collect();
    Mesh::new(positions, triangles)
}

#[cfg(test)]
mod tests;
