//! Rids a mesh of faces whose three corners lie in a line.
//!
//! The long side of such a face has its third corner on it. The face a, b, c with c between a and
//! b, and its neighbour b, a, d across the long side, become a, d, c and d, b, c: the same surface,
//! and no flat face. One without a neighbour there is dropped.

use std::collections::{HashMap, HashSet};

use crate::Result;
use crate::mesh::Mesh;
use crate::mesh::repair::RepairReport;
use crate::mesh::report::is_degenerate;

/// How often flat faces are gone through: several side by side need several rounds.
const ROUNDS: usize = 8;

pub(super) fn without_flat_faces(mut mesh: Mesh, done: &mut RepairReport) -> Result<Mesh> {
    for _ in 0..ROUNDS {
        let flat = flat_faces(&mesh);
        if flat.is_empty() {
            break;
        }
        let changed = traded(&mesh, &flat)?;
        let left = flat_faces(&changed).len();
        // A trade that makes a new flat face may go on for ever: only progress counts.
        if left >= flat.len() {
            break;
        }
        done.zero_area += flat.len() - left;
        mesh = changed;
    }
    Ok(mesh)
}

fn flat_faces(mesh: &Mesh) -> Vec<usize> {
    (0..mesh.triangles().len()).filter(|&f| is_degenerate(mesh, f)).collect()
}

/// What is beside the long side of a flat face.
#[derive(Clone, Copy)]
enum Beside {
    Nothing,
    /// One other face, which walks along it the other way; the face itself is named too.
    Neighbour([usize; 2]),
    /// Faces that disagree, or several.
    Others,
}

/// Two faces that trade their common side.
struct Trade {
    faces: [usize; 2],
    new: [[u32; 3]; 2],
    edge: [u32; 2],
}

/// Trades the long sides of flat faces with their neighbours, and drops the flat faces that have
/// none.
fn traded(mesh: &Mesh, flat: &[usize]) -> Result<Mesh> {
    let beside = beside_long_sides(mesh, flat);
    let mut is_dropped = vec![false; mesh.triangles().len()];
    let mut trades = Vec::new();
    for &face in flat {
        let [a, b, c] = long_side(mesh, face);
        match beside.get(&sorted(a, b)) {
            Some(Beside::Nothing) => is_dropped[face] = true,
            Some(&Beside::Neighbour([one, two])) => {
                let other = if one == face { two } else { one };
                let tip = mesh.triangles()[other].into_iter().find(|v| ![a, b, c].contains(v));
                trades.extend(tip.map(|d| Trade {
                    faces: [face, other],
                    new: [[a, d, c], [d, b, c]],
                    edge: sorted(c, d),
                }));
            }
            _ => {}
        }
    }
    let mut triangles = mesh.triangles().to_vec();
    apply(&trades, &mut triangles);
    let mut dropped = is_dropped.into_iter();
    triangles.retain(|_| dropped.next() != Some(true));
    Mesh::new(mesh.positions().to_vec(), triangles)
}

/// Makes the trades whose new edge does not exist yet and whose faces no earlier trade has changed.
fn apply(trades: &[Trade], triangles: &mut [[u32; 3]]) {
    let mut free: HashSet<[u32; 2]> = trades.iter().map(|t| t.edge).collect();
    for t in triangles.iter() {
        for [p, q] in sides(t) {
            free.remove(&sorted(p, q));
        }
    }
    let mut is_changed = vec![false; triangles.len()];
    for Trade { faces, new, edge } in trades {
        if faces.iter().all(|&f| !is_changed[f]) && free.remove(edge) {
            for (&face, &triangle) in faces.iter().zip(new) {
                triangles[face] = triangle;
                is_changed[face] = true;
            }
        }
    }
}

/// Finds what is beside the long side of each flat face.
fn beside_long_sides(mesh: &Mesh, flat: &[usize]) -> HashMap<[u32; 2], Beside> {
    let mut walks: HashMap<[u32; 2], Vec<(usize, bool)>> = HashMap::new();
    for &face in flat {
        let [a, b, _] = long_side(mesh, face);
        walks.insert(sorted(a, b), Vec::new());
    }
    for (face, t) in mesh.triangles().iter().enumerate() {
        for [p, q] in sides(t) {
            if let Some(known) = walks.get_mut(&sorted(p, q)) {
                known.push((face, p < q));
            }
        }
    }
    let judged = walks.into_iter().map(|(edge, walks)| {
        let beside = match walks[..] {
            [_] => Beside::Nothing,
            [(a, up), (b, down)] if up != down => Beside::Neighbour([a, b]),
            _ => Beside::Others,
        };
        (edge, beside)
    });
    judged.collect()
}

fn sides(&[a, b, c]: &[u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

fn sorted(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Returns the corners of a face in their order, the longest side first.
fn long_side(mesh: &Mesh, face: usize) -> [u32; 3] {
    let [a, b, c] = mesh.triangles()[face];
    let [p, q, r] = mesh.corners(face);
    let (pq, qr, rp) = (p.distance(q), q.distance(r), r.distance(p));
    if pq >= qr && pq >= rp {
        [a, b, c]
    } else if qr >= rp {
        [b, c, a]
    } else {
        [c, a, b]
    }
}
