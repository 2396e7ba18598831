//! The rival of the compact form: a mesh with its vertices rounded to a step, as few bytes as a
//! plain coder makes of it. Faces are visited one by one across the edge to the last (Rossignac
//! 1999): one symbol tells whether the third corner is new, or which edge of the border it closes.
//! A new corner is foretold by the parallelogram over the edge (Touma and Gotsman 1998), and what
//! it is off by is written. Symbols, places elsewhere and the three
//! coordinates are deflated each by itself.

use std::collections::HashMap;
use std::io::Write;

use flate2::Compression;
use flate2::write::DeflateEncoder;
use glam::I64Vec3;

use crate::io::bytes::{push_number, zigzag};
use crate::mesh::Mesh;
use crate::{Error, Result};

/// Says of the third corner of a face: it is new, or closes the edge before or behind, or both, is
/// elsewhere on the border, or there is no face.
#[derive(Clone, Copy)]
enum Symbol {
    New,
    Before,
    Behind,
    Both,
    Elsewhere,
    Open,
}

/// Writes a mesh whose vertices are rounded to multiples of `step`, metres.
///
/// # Errors
/// [`Error::Numeric`] with the complaint of the compressor; none is known.
pub(super) fn quantised(mesh: &Mesh, step: f64) -> Result<Vec<u8>> {
    let failed = |e: std::io::Error| Error::Numeric(format!("the compressor failed: {e}"));
    let least = mesh.bounds().min;
    let places: Vec<I64Vec3> =
        mesh.positions().iter().map(|p| ((*p - least) / step).round().as_i64vec3()).collect();
    let mut walk = Walk::new(mesh, &places);
    for face in 0..mesh.triangles().len() {
        if !walk.visited[face] {
            walk.component(face);
        }
    }
    // The origin, the step and the lengths of the streams.
    let mut bytes = Vec::new();
    for number in least.to_array().into_iter().chain([step]) {
        bytes.extend((number as f32).to_le_bytes());
    }
    let [x, y, z] = walk.offsets;
    for stream in [walk.symbols, walk.elsewhere, x, y, z] {
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(&stream).map_err(failed)?;
        let packed = encoder.finish().map_err(failed)?;
        push_number(&mut bytes, packed.len() as u64);
        bytes.extend(packed);
    }
    Ok(bytes)
}

/// An edge of the border between visited faces and the others, with its neighbours along it. The
/// face beyond has it from `from` to `to`.
#[derive(Clone, Copy)]
struct Gate {
    from: u32,
    to: u32,
    /// The corner opposite to it in the visited face.
    opposite: u32,
    before: usize,
    behind: usize,
    is_closed: bool,
}

struct Walk<'a> {
    triangles: &'a [[u32; 3]],
    places: &'a [I64Vec3],
    /// The face that has an edge in this direction.
    faces: HashMap<[u32; 2], u32>,
    visited: Vec<bool>,
    seen: Vec<bool>,
    gates: Vec<Gate>,
    symbols: Vec<u8>,
    elsewhere: Vec<u8>,
    offsets: [Vec<u8>; 3],
}

impl<'a> Walk<'a> {
    fn new(mesh: &'a Mesh, places: &'a [I64Vec3]) -> Self {
        let triangles = mesh.triangles();
        let edges = triangles
            .iter()
            .zip(0..)
            .flat_map(|(&[a, b, c], face)| [[a, b], [b, c], [c, a]].map(|edge| (edge, face)));
        Self {
            triangles,
            places,
            faces: edges.collect(),
            visited: vec![false; triangles.len()],
            seen: vec![false; places.len()],
            gates: Vec::new(),
            symbols: Vec::new(),
            elsewhere: Vec::new(),
            offsets: <_>::default(),
        }
    }

    /// Visits all faces that hang together with one.
    fn component(&mut self, face: usize) {
        let [a, b, c] = self.triangles[face];
        self.visited[face] = true;
        self.symbols.push(Symbol::New as u8);
        self.add(a, I64Vec3::ZERO);
        self.add(b, self.places[a as usize]);
        self.add(c, self.places[b as usize]);
        // Seen from beyond, the edges run the other way, and so does their order.
        let first = self.gates.len();
        let ring = [[b, a, c], [a, c, b], [c, b, a]];
        for (i, [from, to, opposite]) in ring.into_iter().enumerate() {
            let (before, behind) = (first + (i + 2) % 3, first + (i + 1) % 3);
            self.gates.push(Gate { from, to, opposite, before, behind, is_closed: false });
        }
        let mut open = vec![first + 2, first + 1, first];
        while let Some(gate) = open.pop() {
            if !self.gates[gate].is_closed {
                self.cross(gate, &mut open);
            }
        }
    }

    /// Goes through a gate.
    fn cross(&mut self, at: usize, open: &mut Vec<usize>) {
        let gate = self.gates[at];
        self.gates[at].is_closed = true;
        let beyond =
            self.faces.get(&[gate.from, gate.to]).filter(|face| !self.visited[**face as usize]);
        let Some(&face) = beyond else {
            self.symbols.push(Symbol::Open as u8);
            self.join(gate.before, gate.behind);
            return;
        };
        self.visited[face as usize] = true;
        let corners = self.triangles[face as usize];
        let third = corners.into_iter().find(|v| *v != gate.from && *v != gate.to);
        let third = third.unwrap_or(gate.from);
        let [before, behind] = [gate.before, gate.behind].map(|i| self.gates[i]);
        let closes_before = before.from == third && before.to == gate.from && !before.is_closed;
        let closes_behind = behind.to == third && behind.from == gate.to && !behind.is_closed;
        let symbol = match (closes_before, closes_behind) {
            (true, true) => Symbol::Both,
            (true, false) => Symbol::Before,
            (false, true) => Symbol::Behind,
            (false, false) if self.seen[third as usize] => Symbol::Elsewhere,
            (false, false) => Symbol::New,
        };
        self.symbols.push(symbol as u8);
        let mut elsewhere = None;
        match symbol {
            Symbol::New => self.add(third, self.foretold(&gate)),
            Symbol::Elsewhere => elsewhere = self.along(gate.behind, third),
            _ => {}
        }
        self.enclose(&gate, third, [closes_before, closes_behind], elsewhere, open);
    }

    /// Puts the edges of a face in the place of its gate, as far as they do not close the border,
    /// which is cut where the face touches it elsewhere.
    fn enclose(
        &mut self,
        gate: &Gate,
        third: u32,
        [closes_before, closes_behind]: [bool; 2],
        elsewhere: Option<usize>,
        open: &mut Vec<usize>,
    ) {
        let (mut left, mut right) = (gate.before, gate.behind);
        if closes_before {
            self.gates[left].is_closed = true;
            left = self.gates[left].before;
        }
        if closes_behind {
            self.gates[right].is_closed = true;
            right = self.gates[right].behind;
        }
        let mut last = left;
        for (closed, [from, to, opposite]) in [
            (closes_before, [gate.from, third, gate.to]),
            (closes_behind, [third, gate.to, gate.from]),
        ] {
            if !closed {
                let new = self.gates.len();
                let gate =
                    Gate { from, to, opposite, before: last, behind: right, is_closed: false };
                self.gates.push(gate);
                self.join(last, new);
                last = new;
                open.push(new);
            }
        }
        self.join(last, right);
        if let Some(there) = elsewhere {
            let (first, second) = (last - 1, last);
            let before = self.gates[there].before;
            self.join(first, there);
            self.join(before, second);
        }
    }

    /// Looks along the border for the gate that begins at a corner, and writes how far it is; the
    /// corner itself where it is on another border.
    fn along(&mut self, start: usize, corner: u32) -> Option<usize> {
        let mut at = start;
        for steps in 1..=self.gates.len() {
            let gate = self.gates[at];
            if gate.from == corner && !gate.is_closed {
                push_number(&mut self.elsewhere, steps as u64);
                return Some(at);
            }
            at = gate.behind;
            if at == start {
                break;
            }
        }
        self.elsewhere.push(0);
        push_number(&mut self.elsewhere, u64::from(corner));
        None
    }

    fn join(&mut self, first: usize, second: usize) {
        self.gates[first].behind = second;
        self.gates[second].before = first;
    }

    /// Foretells the third corner beyond a gate.
    fn foretold(&self, gate: &Gate) -> I64Vec3 {
        let [a, b, c] = [gate.from, gate.to, gate.opposite].map(|v| self.places[v as usize]);
        a + b - c
    }

    /// Writes by how much a new vertex is off what was foretold.
    fn add(&mut self, vertex: u32, foretold: I64Vec3) {
        self.seen[vertex as usize] = true;
        let offset = (self.places[vertex as usize] - foretold).to_array();
        for (stream, offset) in self.offsets.iter_mut().zip(offset) {
            push_number(stream, zigzag(offset));
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::fit::{Resolution, tessellate};
    use crate::sh::Coefficients;

    #[test]
    fn a_closed_mesh_takes_about_two_bits_a_face_beside_its_offsets() -> Result<()> {
        let mut ball = Coefficients::zeros(0);
        ball.set(0, 0, 1.0, 0.0);
        let resolution = Resolution::Icosphere { frequency: 16 };
        let mesh = tessellate(&ball, DVec3::ZERO, resolution)?.mesh;
        let places: Vec<I64Vec3> =
            mesh.positions().iter().map(|p| (*p * 1e3).round().as_i64vec3()).collect();
        let mut walk = Walk::new(&mesh, &places);
        walk.component(0);
        let [vertices, faces] = mesh.used_size();
        assert!(walk.visited.iter().all(|visited| *visited));
        let new = |s: &&u8| **s == Symbol::New as u8;
        // The first three corners share a symbol.
        assert_eq!(walk.symbols.iter().filter(new).count(), vertices - 2);
        assert_eq!(walk.symbols.len(), faces);
        let bytes = quantised(&mesh, 1e-3)?;
        assert!(bytes.len() < 5 * vertices, "{} bytes", bytes.len());
        Ok(())
    }

    #[test]
    fn open_meshes_and_several_pieces_are_written() -> Result<()> {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].to_vec();
        let mesh = Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]])?;
        assert!(quantised(&mesh, 0.1)?.len() > 16);
        Ok(())
    }
}
