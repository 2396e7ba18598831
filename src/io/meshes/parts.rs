//! What every reader gathers: positions, and triangles that polygons are cut into.

use std::ops::Range;

use glam::DVec3;

use super::polygon::{self, Intricate};
use crate::Result;
use crate::io::source::Source;
use crate::mesh::Mesh;

/// Holds the mesh as far as it is read.
#[derive(Debug, Default)]
pub(super) struct Parts {
    pub(super) positions: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// The polygons that stood before their vertices: where their triangles are.
    uncut: Vec<Range<usize>>,
    /// How many faces of two corners there were.
    edges: u64,
}

/// How many vertices a mesh can have: their numbers are 32 bits wide.
pub(super) const MOST_VERTICES: u64 = u32::MAX as u64;

impl Parts {
    /// Begins with all vertices.
    pub(super) fn of(positions: Vec<DVec3>) -> Self {
        Self { positions, ..Self::default() }
    }

    /// Asks for a place for one more vertex.
    pub(super) fn vertex(&mut self, source: &Source, position: DVec3) -> Result<()> {
        if self.positions.len() as u64 >= MOST_VERTICES {
            return Err(source.fault(too_many(MOST_VERTICES + 1), "divide the file"));
        }
        self.positions.push(position);
        Ok(())
    }

    /// Takes a face of two corners or more. One of two encloses nothing: it is counted.
    pub(super) fn polygon(&mut self, corners: &[u32]) -> Result<(), Intricate> {
        let [first, rest @ ..] = corners else { return Ok(()) };
        let start = self.triangles.len();
        self.triangles.extend(rest.windows(2).map(|side| [*first, side[0], side[1]]));
        match corners.len() {
            ..3 => self.edges += 1,
            3 => {}
            _ if corners.iter().all(|&v| (v as usize) < self.positions.len()) => {
                return polygon::cut(&self.positions, &mut self.triangles[start..]);
            }
            _ => self.uncut.push(start..self.triangles.len()),
        }
        Ok(())
    }

    /// Makes the mesh of a file that holds one.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when there are no faces or fewer than three vertices.
    pub(super) fn finish(mut self, source: &mut Source) -> Result<Mesh> {
        for faces in std::mem::take(&mut self.uncut) {
            let cut = polygon::cut(&self.positions, &mut self.triangles[faces]);
            cut.map_err(|e| source.fault(e.to_string(), CUT))?;
        }
        if self.edges > 0 {
            source.remark(format!(
                "{} of two vertices passed over",
                if self.edges == 1 { "1 face".to_owned() } else { format!("{} faces", self.edges) }
            ));
        }
        if self.triangles.is_empty() {
            let help =
                "export the surface as triangles or polygons, not as points, lines or curves";
            let none =
                if self.positions.is_empty() { "no vertices and no faces" } else { "no faces" };
            return Err(source.fault(none, help));
        }
        if self.positions.len() < 3 {
            let help = "a face needs three vertices at least; check that the file is whole";
            return Err(source.fault(format!("only {} vertices", self.positions.len()), help));
        }
        self.positions.shrink_to_fit();
        self.triangles.shrink_to_fit();
        Mesh::new(self.positions, self.triangles)
    }
}

/// Says that there are more vertices than numbers for them.
pub(super) fn too_many(count: u64) -> String {
    format!("{count} vertices, more than the {MOST_VERTICES} that a mesh can have")
}

/// What to do about a polygon that is too intricate.
pub(super) const CUT: &str = "export the surface as triangles";

/// Rejects a face of fewer than two corners.
pub(super) fn thin_face(corners: u64) -> String {
    format!("a face of {corners} {}", if corners == 1 { "vertex" } else { "vertices" })
}
