//! The loops that the boundary of an open mesh forms.

use glam::DVec3;

use crate::mesh::Mesh;

/// Describes a loop of edges that have one face only: the rim of a hole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundaryLoop {
    /// How many edges it has.
    pub edges: usize,
    /// Its length, metres.
    pub length: f64,
    /// The mean of its vertices, metres.
    pub middle: DVec3,
}

impl BoundaryLoop {
    /// Measures a loop, given by its edges.
    pub(super) fn new(mesh: &Mesh, edges: &[[u32; 2]]) -> Self {
        let at = |v: u32| mesh.positions()[v as usize];
        let length = edges.iter().map(|&[a, b]| at(a).distance(at(b))).sum();
        // Every vertex ends two edges.
        let sum: DVec3 = edges.iter().map(|&[a, b]| 0.5 * (at(a) + at(b))).sum();
        Self { edges: edges.len(), length, middle: sum / edges.len() as f64 }
    }
}

/// Follows boundary edges (each in the direction of its face) from one to the next and shows every
/// loop, in a fixed order.
///
/// Where more than two of them meet, the walk goes on along the first that is left. Edges keep
/// their own direction, whichever way the walk takes them.
pub(super) fn for_each_loop(edges: &[[u32; 2]], mut see: impl FnMut(&[[u32; 2]])) {
    // Both ends of each edge, by vertex.
    let mut ends: Vec<(u32, u32)> =
        (0..).zip(edges).flat_map(|(i, &[a, b])| [(a, i), (b, i)]).collect();
    ends.sort_unstable();
    let mut is_walked = vec![false; edges.len()];
    // Where at a vertex the search goes on, so that one of many edges is not searched anew each
    // time.
    let mut next: Vec<u32> = vec![0; ends.len()];
    let mut found = Vec::new();
    for start in 0..edges.len() {
        if is_walked[start] {
            continue;
        }
        found.clear();
        let first = edges[start][0];
        let mut edge = start;
        let mut at = first;
        loop {
            is_walked[edge] = true;
            found.push(edges[edge]);
            let [a, b] = edges[edge];
            at = if at == a { b } else { a };
            if at == first {
                break;
            }
            let from = ends.partition_point(|&(v, _)| v < at);
            let skipped = &mut next[from];
            let group = ends[from..].iter().skip(*skipped as usize).take_while(|&&(v, _)| v == at);
            let Some((passed, &(_, i))) =
                group.enumerate().find(|(_, (_, i))| !is_walked[*i as usize])
            else {
                break;
            };
            *skipped += passed as u32;
            edge = i as usize;
        }
        see(&found);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loops(edges: &[[u32; 2]]) -> Vec<usize> {
        let mut lengths = Vec::new();
        for_each_loop(edges, |edges| lengths.push(edges.len()));
        lengths
    }

    #[test]
    fn edges_form_loops_whatever_their_order_and_direction() {
        assert!(loops(&[]).is_empty());
        assert_eq!(loops(&[[0, 1], [7, 8], [2, 1], [8, 9], [9, 7], [2, 0]]), [3, 3]);
        // Two loops that share vertex 5, and a chain that ends.
        assert_eq!(loops(&[[5, 1], [1, 2], [2, 5], [5, 3], [3, 4], [4, 5]]), [3, 3]);
        assert_eq!(loops(&[[0, 1], [1, 2]]), [2]);
    }
}
