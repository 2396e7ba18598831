//! What every reader gathers: positions, and triangles that polygons are cut into.

use glam::DVec3;

use super::source::Source;
use crate::Result;
use crate::mesh::Mesh;

/// Holds the mesh as far as it is read.
#[derive(Debug, Default)]
pub(super) struct Parts {
    pub(super) positions: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Cuts a polygon into the fan of triangles about its first corner, one corner at a time.
#[derive(Debug, Default)]
pub(super) struct Fan {
    corners: u64,
    first: u32,
    last: u32,
}

impl Fan {
    /// Takes the next corner of the polygon.
    pub(super) fn corner(&mut self, vertex: u32, triangles: &mut Vec<[u32; 3]>) {
        match self.corners {
            0 => self.first = vertex,
            1 => {}
            _ => triangles.push([self.first, self.last, vertex]),
        }
        self.last = vertex;
        self.corners += 1;
    }

    /// Returns how many corners it has.
    pub(super) fn corners(&self) -> u64 {
        self.corners
    }
}

/// How many vertices a mesh can have: their numbers are 32 bits wide.
pub(super) const MOST_VERTICES: u64 = u32::MAX as u64;

impl Parts {
    /// Asks for a place for one more vertex.
    pub(super) fn vertex(&mut self, source: &Source, position: DVec3) -> Result<()> {
        if self.positions.len() as u64 >= MOST_VERTICES {
            return Err(source.fault(too_many(MOST_VERTICES + 1), "divide the file"));
        }
        self.positions.push(position);
        Ok(())
    }

    /// Makes the mesh of a file that holds one.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when there are no faces or fewer than three vertices.
    pub(super) fn finish(mut self, source: &Source) -> Result<Mesh> {
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

/// Rejects a face of fewer than three corners.
pub(super) fn thin_face(corners: u64) -> String {
    format!("a face of {corners} {}", if corners == 1 { "vertex" } else { "vertices" })
}
