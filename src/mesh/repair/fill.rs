//! Fills small holes of a mesh.

use glam::DVec3;

use crate::Result;
use crate::mesh::Mesh;
use crate::mesh::boundary::for_each_loop;
use crate::mesh::edges::{EdgeFault, for_each_edge};
use crate::mesh::repair::RepairReport;

/// Fills the holes of up to `most` edges: one of three by a face, others by a fan about the middle
/// of the rim.
pub(super) fn filled(mesh: &Mesh, most: usize, done: &mut RepairReport) -> Result<Mesh> {
    let mut rims = Vec::new();
    for_each_edge(mesh, |walks| {
        if EdgeFault::of(walks) == Some(EdgeFault::Boundary) {
            rims.push(walks[0].direction());
        }
    });
    let (mut positions, mut triangles) = (mesh.positions().to_vec(), mesh.triangles().to_vec());
    for_each_loop(&rims, |edges| {
        if edges.len() > most || edges.len() < 3 || !is_rim(edges) {
            return;
        }
        done.filled += 1;
        if let [[a, b], [c, d], _] = *edges {
            // The face walks every edge against its neighbour.
            let third = if c == a || c == b { d } else { c };
            triangles.push([b, a, third]);
            return;
        }
        let middle = positions.len() as u32;
        let sum: DVec3 = edges.iter().map(|e| positions[e[0] as usize]).sum();
        positions.push(sum / edges.len() as f64);
        triangles.extend(edges.iter().map(|&[a, b]| [b, a, middle]));
    });
    Mesh::new(positions, triangles)
}

/// Whether edges form one loop that passes each of its vertices once, all in one direction.
fn is_rim(edges: &[[u32; 2]]) -> bool {
    let mut starts: Vec<u32> = edges.iter().map(|e| e[0]).collect();
    let mut ends: Vec<u32> = edges.iter().map(|e| e[1]).collect();
    starts.sort_unstable();
    ends.sort_unstable();
    starts == ends && starts.windows(2).all(|w| w[0] < w[1])
}
