//! The edges of a mesh, one after the other, with all faces that walk along them.
//!
//! The walks are gathered by their lower vertex: a counting sort, then a sort of the few that share
//! it. That is done for one slice of the vertices after the other, so that the memory is a fraction
//! of that of the mesh.

use std::fmt;

use glam::DVec3;

use crate::mesh::Mesh;
use crate::mesh::triangle::is_collapsed;

/// Describes where an edge is and what is wrong with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BadEdge {
    /// What is wrong.
    pub kind: EdgeFault,
    /// The numbers of its two vertices, from 0.
    pub vertices: [u32; 2],
    /// Where they are, metres.
    pub positions: [DVec3; 2],
}

/// Says what is wrong with an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum EdgeFault {
    /// One face only: here the surface ends.
    Boundary,
    /// Three faces or more meet.
    NonManifold,
    /// The two faces disagree about the outside.
    Inconsistent,
}

/// One face's walk along an edge between two vertices, the lower number first.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Walked {
    low: u32,
    high: u32,
    upwards: bool,
    /// Which corner of its face the walk starts at.
    corner: u8,
    pub(super) face: u32,
}

impl Walked {
    /// Returns the vertices in the order of the walk.
    pub(super) fn direction(&self) -> [u32; 2] {
        if self.upwards { [self.low, self.high] } else { [self.high, self.low] }
    }

    /// Whether two faces walk in opposite ways, as faces do that agree about the outside.
    pub(super) fn agrees(&self, other: &Self) -> bool {
        self.upwards != other.upwards
    }

    /// Returns the number, three a face, of the corner at the lower vertex.
    pub(super) fn low_corner(&self) -> u32 {
        self.corner_at(self.upwards)
    }

    /// Returns the number, three a face, of the corner at the higher vertex.
    pub(super) fn high_corner(&self) -> u32 {
        self.corner_at(!self.upwards)
    }

    fn corner_at(&self, start: bool) -> u32 {
        let corner = u32::from(self.corner);
        3 * self.face + if start { corner } else { (corner + 1) % 3 }
    }
}

impl EdgeFault {
    /// Judges an edge by all walks along it; `None` for one of two faces that agree.
    pub(super) fn of(walks: &[Walked]) -> Option<Self> {
        match walks {
            [_] => Some(Self::Boundary),
            [a, b] if a.agrees(b) => None,
            [_, _] => Some(Self::Inconsistent),
            _ => Some(Self::NonManifold),
        }
    }
}

impl BadEdge {
    pub(super) fn new(mesh: &Mesh, kind: EdgeFault, walk: &Walked) -> Self {
        let vertices = [walk.low, walk.high];
        Self { kind, vertices, positions: vertices.map(|v| mesh.positions()[v as usize]) }
    }
}

impl fmt::Display for BadEdge {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let ([a, b], [p, q]) = (self.vertices, self.positions);
        write!(f, "vertices {a}-{b} at {p:.6} to {q:.6}")
    }
}

/// Returns for each face the gravest fault of its edges, if any.
pub fn edge_faults(mesh: &Mesh) -> Vec<Option<EdgeFault>> {
    let mut faults = vec![None; mesh.triangles().len()];
    for_each_edge(mesh, |walks| {
        if let Some(fault) = EdgeFault::of(walks) {
            for walk in walks {
                let worst = &mut faults[walk.face as usize];
                *worst = (*worst).max(Some(fault));
            }
        }
    });
    faults
}

/// Shows every edge once, with all walks along it; faces that name a vertex twice have none.
pub(super) fn for_each_edge(mesh: &Mesh, mut see: impl FnMut(&[Walked])) {
    let walks = || {
        let proper = mesh.triangles().iter().enumerate().filter(|(_, t)| !is_collapsed(t));
        proper.flat_map(|(face, &[a, b, c])| {
            [(a, b, 0), (b, c, 1), (c, a, 2)].map(|(p, q, corner)| {
                let (low, high, upwards) = (p.min(q), p.max(q), p < q);
                (low, Walked { low, high, upwards, corner, face: face as u32 })
            })
        })
    };
    for_each_group(mesh.positions().len(), walks, |_, group| {
        group.chunk_by(|a, b| a.high == b.high).for_each(&mut see);
    });
}

/// Into how many slices the vertices are divided at most.
const SLICES: usize = 8;
/// The fewest vertices of a slice.
const LEAST_SLICE: usize = 1 << 16;

/// Shows, for each vertex in ascending order, the items that `items` gives for it, sorted; vertices
/// without items are left out.
pub(super) fn for_each_group<T, I>(
    vertices: usize,
    items: impl Fn() -> I,
    mut see: impl FnMut(u32, &[T]),
) where
    T: Copy + Default + Ord,
    I: Iterator<Item = (u32, T)>,
{
    let width = vertices.div_ceil(SLICES).max(LEAST_SLICE);
    for first in (0..vertices).step_by(width) {
        let last = (first + width).min(vertices);
        let within = || {
            items().filter_map(move |(vertex, item)| {
                let vertex = vertex as usize;
                (first..last).contains(&vertex).then(|| (vertex - first, item))
            })
        };
        // Where the items of each vertex end, once they are placed.
        let mut ends = vec![0_usize; last - first + 1];
        within().for_each(|(vertex, _)| ends[vertex + 1] += 1);
        for i in 1..ends.len() {
            ends[i] += ends[i - 1];
        }
        let mut sorted = vec![T::default(); ends[last - first]];
        for (vertex, item) in within() {
            sorted[ends[vertex]] = item;
            ends[vertex] += 1;
        }
        let mut start = 0;
        for (vertex, &end) in (first as u32..).zip(&ends[..last - first]) {
            let group = &mut sorted[start..end];
            if !group.is_empty() {
                group.sort_unstable();
                see(vertex, group);
            }
            start = end;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn no_edges_without_faces() {
        for_each_edge(&Mesh::default(), |_| panic!("an edge of nothing"));
        assert!(edge_faults(&Mesh::default()).is_empty());
    }

    #[test]
    fn slices_show_every_edge_once() {
        // More vertices than one slice holds.
        let sphere = shapes::sphere(8);
        assert!(sphere.positions().len() > 2 * LEAST_SLICE);
        let mut edges = 0;
        for_each_edge(&sphere, |walks| {
            edges += 1;
            assert!(walks.len() == 2 && walks[0].agrees(&walks[1]));
            for walk in walks {
                let corner = |c: u32| sphere.triangles()[c as usize / 3][c as usize % 3];
                assert_eq!(
                    [corner(walk.low_corner()), corner(walk.high_corner())],
                    [walk.low, walk.high]
                );
            }
        });
        assert_eq!(2 * edges, 3 * sphere.triangles().len());
    }

    #[test]
    fn faces_know_their_gravest_edge() {
        let cube = shapes::cube();
        let open =
            Mesh::new(cube.positions().to_vec(), cube.triangles()[1..].to_vec()).expect("in range");
        let faults = edge_faults(&open);
        assert_eq!(faults.iter().filter(|f| **f == Some(EdgeFault::Boundary)).count(), 3);
        assert_eq!(faults.iter().filter(|f| f.is_none()).count(), 8);
    }
}
