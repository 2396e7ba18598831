//! Joins the corners of formats that have no shared vertices: those equal to the last bit become
//! one vertex.

use std::hash::{BuildHasher, RandomState};

use glam::DVec3;
use hashbrown::HashTable;

use super::parts::Parts;
use crate::Result;
use crate::io::source::Source;

/// Finds vertices by their coordinates. It holds their numbers only, 5 bytes each; the hash is
/// seeded by chance, so that no file can be made to slow it down, and the result does not depend on
/// it.
#[derive(Default)]
pub(super) struct Welding {
    numbers: HashTable<u32>,
    hasher: RandomState,
}

impl Welding {
    /// Returns the number of the vertex at a finite position, a new one where there is none.
    pub(super) fn vertex(
        &mut self,
        source: &Source,
        position: DVec3,
        parts: &mut Parts,
    ) -> Result<u32> {
        // Zeros of both signs are one.
        let position = position + 0.0;
        let hash = |p: DVec3| self.hasher.hash_one(p.to_array().map(f64::to_bits));
        let is_there = |&v: &u32| parts.positions[v as usize] == position;
        if let Some(&vertex) = self.numbers.find(hash(position), is_there) {
            return Ok(vertex);
        }
        let vertex = parts.positions.len() as u32;
        parts.vertex(source, position)?;
        let again = |&v: &u32| hash(parts.positions[v as usize]);
        self.numbers.insert_unique(hash(position), vertex, again);
        Ok(vertex)
    }
}
