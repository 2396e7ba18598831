//! Faces of a mesh that stand in the place of others: repeated, or back to back.

use std::collections::HashSet;
use std::hash::{BuildHasher, RandomState};

use hashbrown::HashTable;

use crate::mesh::Mesh;

/// Holds the faces that stand in the place of others, by number.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Doubles {
    /// Faces that repeat an earlier one, corners and side.
    pub repeated: Vec<u32>,
    /// Faces that have another at their back.
    pub back_to_back: HashSet<u32>,
}

impl Doubles {
    /// Looks for faces with the same three corners, to the bit.
    pub fn of(mesh: &Mesh) -> Self {
        let mut doubles = Self::default();
        let hasher = RandomState::new();
        // The first face of either side at each place: numbers alone take the least memory.
        let mut places: HashTable<[Option<u32>; 2]> = HashTable::new();
        let hash = |faces: &[Option<u32>; 2]| {
            let first = faces[0].or(faces[1]).unwrap_or(0);
            hasher.hash_one(place(mesh, first).0)
        };
        for face in 0..mesh.triangles().len() as u32 {
            let (corners, side) = place(mesh, face);
            let is_here = |faces: &[Option<u32>; 2]| {
                faces.iter().flatten().any(|f| place(mesh, *f).0 == corners)
            };
            let mut entry =
                places.entry(hasher.hash_one(corners), is_here, hash).or_insert([None; 2]);
            let sides = entry.get_mut();
            if sides[side].is_some() {
                doubles.repeated.push(face);
                continue;
            }
            sides[side] = Some(face);
            if let [Some(front), Some(back)] = *sides {
                doubles.back_to_back.extend([front, back]);
            }
        }
        doubles
    }
}

/// Returns the corners of a face in an order of their own, to the bit, and on which side of them it
/// is.
fn place(mesh: &Mesh, face: u32) -> ([[u64; 3]; 3], usize) {
    // The sum takes -0 to 0.
    let corners = mesh.corners(face as usize).map(|c| (c + 0.0).to_array().map(f64::to_bits));
    let lowest = (0..3).min_by_key(|i| corners[*i]).unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|i| corners[(lowest + i) % 3]);
    if b <= c { ([a, b, c], 0) } else { ([a, c, b], 1) }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn repeated_and_back_to_back_faces_are_found_whatever_their_vertices() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let faces = vec![[0, 1, 2], [1, 2, 0], [3, 4, 5], [5, 4, 3], [0, 1, 6]];
        let doubles = Doubles::of(&Mesh::new(corners.to_vec(), faces).expect("valid"));
        assert_eq!(doubles.repeated, [1, 2]);
        assert_eq!(doubles.back_to_back, HashSet::from([0, 3]));
    }
}
