//! The geodesic sphere of any frequency: an icosahedron whose edges are cut into n parts and whose
//! faces into n^2.

use std::f64::consts::PI;

use glam::DVec3;

use crate::fit::tessellation::SphereMesh;

/// The corners of an icosahedron: a pole, two rings of five, a pole.
const CORNERS: usize = 12;
const EDGES: usize = 30;

/// Makes the sphere of 20 n^2 faces and 10 n^2 + 2 vertices; n is at least 1.
pub(super) fn icosphere(n: usize) -> SphereMesh {
    let corners = corners();
    let faces = faces();
    let edges = Edges::of(&faces);
    let mut directions = corners.to_vec();
    for &[low, high] in &edges.ends {
        let between = |k: usize| blend([corners[low], corners[high], DVec3::ZERO], [n - k, k, 0]);
        directions.extend((1..n).map(between));
    }
    let mut triangles = Vec::with_capacity(faces.len() * n * n);
    for face in &faces {
        let first = directions.len();
        let inner = lattice(n).filter(|weights| !weights.contains(&0));
        directions.extend(inner.map(|weights| blend(face.map(|c| corners[c]), weights)));
        let number = |weights: [usize; 3]| edges.number(face, weights, n, first);
        triangles.extend(split(n).map(|t| t.map(|weights| number(weights) as u32)));
    }
    SphereMesh { directions, triangles }
}

fn corners() -> [DVec3; CORNERS] {
    let height = 0.2_f64.sqrt();
    std::array::from_fn(|i| match i {
        0 => DVec3::Z,
        11 => DVec3::NEG_Z,
        _ => {
            let upper = i <= 5;
            let steps = if upper { 2 * (i - 1) } else { 2 * (i - 6) + 1 };
            let (sin, cos) = (PI * steps as f64 / 5.0).sin_cos();
            let z = if upper { height } else { -height };
            DVec3::new(2.0 * height * cos, 2.0 * height * sin, z)
        }
    })
}

/// Lists the faces, counter-clockwise seen from outside.
fn faces() -> Vec<[usize; 3]> {
    let upper = |i: usize| 1 + i % 5;
    let lower = |i: usize| 6 + i % 5;
    let sector = |i: usize| {
        [
            [0, upper(i), upper(i + 1)],
            [upper(i), lower(i), upper(i + 1)],
            [lower(i), lower(i + 1), upper(i + 1)],
            [11, lower(i + 1), lower(i)],
        ]
    };
    (0..5).flat_map(sector).collect()
}

/// Numbers the edges of the icosahedron, each from its lower to its higher corner.
struct Edges {
    ends: Vec<[usize; 2]>,
    numbers: [[usize; CORNERS]; CORNERS],
}

impl Edges {
    fn of(faces: &[[usize; 3]]) -> Self {
        let mut edges = Self { ends: Vec::with_capacity(EDGES), numbers: [[0; CORNERS]; CORNERS] };
        for &[a, b, c] in faces {
            for [low, high] in [[a, b], [b, c], [c, a]].into_iter().filter(|[l, h]| l < h) {
                edges.numbers[low][high] = edges.ends.len();
                edges.ends.push([low, high]);
            }
        }
        edges
    }

    /// Returns the number of the vertex with these weights of the corners of a face; vertices
    /// inside the face start at `first`.
    fn number(&self, face: &[usize; 3], weights: [usize; 3], n: usize, first: usize) -> usize {
        if let Some(corner) = weights.iter().position(|&w| w == n) {
            return face[corner];
        }
        let Some(opposite) = weights.iter().position(|&w| w == 0) else {
            let [_, j, k] = weights;
            // Rows of constant k hold the j from 1 to n - k - 1.
            let rows_before = (k - 1) * (n - 1) - k * (k - 1) / 2;
            return first + rows_before + j - 1;
        };
        let [a, b] = [(opposite + 1) % 3, (opposite + 2) % 3];
        let [low, high] = if face[a] < face[b] { [a, b] } else { [b, a] };
        CORNERS + self.numbers[face[low]][face[high]] * (n - 1) + weights[high] - 1
    }
}

/// Lists the weights (i, j, k) that add up to n, k outermost.
fn lattice(n: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..=n).flat_map(move |k| (0..=n - k).map(move |j| [n - j - k, j, k]))
}

/// Lists the n^2 small triangles of a face by the weights of their corners, turning as the face
/// does.
fn split(n: usize) -> impl Iterator<Item = [[usize; 3]; 3]> {
    let at = move |j: usize, k: usize| [n - j - k, j, k];
    let upright =
        (0..n).flat_map(move |k| (0..n - k).map(move |j| [at(j, k), at(j + 1, k), at(j, k + 1)]));
    let turned = (0..n)
        .flat_map(move |k| (1..n - k).map(move |j| [at(j, k), at(j, k + 1), at(j - 1, k + 1)]));
    upright.chain(turned)
}

fn blend(corners: [DVec3; 3], weights: [usize; 3]) -> DVec3 {
    let sum: DVec3 = corners.iter().zip(weights).map(|(c, w)| *c * w as f64).sum();
    sum.normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, MeshReport};

    #[test]
    fn every_frequency_is_closed_outward_and_complete() {
        for n in [1, 2, 3, 5, 8] {
            let sphere = icosphere(n);
            assert_eq!(sphere.directions.len(), 10 * n * n + 2);
            assert_eq!(sphere.triangles.len(), 20 * n * n);
            let mesh = Mesh::new(sphere.directions, sphere.triangles).expect("indices in range");
            let report = MeshReport::of(&mesh);
            assert!(report.is_closed() && report.volume > 0.0 && report.unused_vertices == 0);
            assert_eq!((report.euler(), report.components), (2, 1));
            assert!(mesh.positions().iter().all(|p| (p.length() - 1.0).abs() <= 4e-16));
        }
    }

    #[test]
    fn icosahedron_has_its_volume() {
        let sphere = icosphere(1);
        let mesh = Mesh::new(sphere.directions, sphere.triangles).expect("indices in range");
        // (5/12)(3 + sqrt 5) a^3 with a = 1/sin(2 pi/5).
        let edge = 1.0 / (2.0 * PI / 5.0).sin();
        assert!((mesh.volume() - 5.0 / 12.0 * (3.0 + 5_f64.sqrt()) * edge.powi(3)).abs() <= 1e-14);
    }
}
