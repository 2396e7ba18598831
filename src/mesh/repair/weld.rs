//! Joins vertices that are at one place, or nearly.

use std::hash::{BuildHasher, RandomState};

use glam::DVec3;
use hashbrown::HashTable;

use crate::Result;
use crate::math::Aabb;
use crate::mesh::Mesh;
use crate::mesh::repair::RepairReport;

/// Joins every vertex to the first one within the distance, if any.
pub(super) fn welded(mesh: &Mesh, distance: f64, done: &mut RepairReport) -> Result<Mesh> {
    let positions = mesh.positions();
    let bounds = Aabb::of_points(positions.iter().copied().filter(|p| p.is_finite()));
    // Where cells are too many to be numbered only equal coordinates are as near as that.
    let distance = if (bounds.extent() / distance).is_finite() { distance } else { 0.0 };
    let cells = Cells { hasher: RandomState::new(), origin: bounds.min, distance };
    let mut kept = HashTable::new();
    let count = positions.len() as u32;
    let mut target: Vec<u32> = (0..count).collect();
    for v in (0..count).filter(|&v| positions[v as usize].is_finite()) {
        if let Some(first) = cells.first_near(&kept, positions, v) {
            target[v as usize] = first;
        } else {
            let hash = |v: u32| cells.hash(positions[v as usize]);
            kept.insert_unique(hash(v), v, |&other| hash(other));
        }
    }
    let mut is_used = vec![false; target.len()];
    mesh.triangles().iter().flatten().for_each(|&v| is_used[v as usize] = true);
    done.welded = (0..count).filter(|&v| target[v as usize] != v && is_used[v as usize]).count();
    let triangles = mesh.triangles().iter().map(|t| t.map(|v| target[v as usize])).collect();
    Mesh::new(positions.to_vec(), triangles)
}

/// Divides space into cells as wide as the welding distance; where only equal coordinates are
/// joined they are their own cells.
struct Cells {
    hasher: RandomState,
    origin: DVec3,
    distance: f64,
}

impl Cells {
    fn hash(&self, p: DVec3) -> u64 {
        let is_exact = self.distance == 0.0;
        let cell = if is_exact { p } else { ((p - self.origin) / self.distance).floor() };
        // Zeros of both signs are one.
        self.hasher.hash_one((cell + 0.0).to_array().map(f64::to_bits))
    }

    /// Finds the first of the vertices that stay within the distance of another.
    fn first_near(&self, kept: &HashTable<u32>, positions: &[DVec3], vertex: u32) -> Option<u32> {
        let p = positions[vertex as usize];
        let steps: &[f64] = if self.distance == 0.0 { &[0.0] } else { &[-1.0, 0.0, 1.0] };
        let mut first = None;
        for &x in steps {
            for &y in steps {
                for &z in steps {
                    let hash = self.hash(p + self.distance * DVec3::new(x, y, z));
                    let near = kept.iter_hash(hash).copied();
                    let near = near.filter(|&v| positions[v as usize].distance(p) <= self.distance);
                    first = near.chain(first).min();
                }
            }
        }
        first
    }
}
