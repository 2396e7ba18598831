//! Turns the faces of a mesh outwards.

use crate::Result;
use crate::math::Aabb;
use crate::mesh::Mesh;
use crate::mesh::edges::for_each_edge;
use crate::mesh::repair::RepairReport;

/// Turns faces so that neighbours agree and each piece encloses a positive volume.
pub(super) fn oriented(mesh: &Mesh, done: &mut RepairReport) -> Result<Mesh> {
    let neighbours = Neighbours::of(mesh);
    let mut is_turned: Vec<Option<bool>> = vec![None; mesh.triangles().len()];
    let mut piece = Vec::new();
    for start in 0..is_turned.len() {
        if is_turned[start].is_some() {
            continue;
        }
        piece.clear();
        piece.push(start as u32);
        is_turned[start] = Some(false);
        let mut next = 0;
        while let Some(&face) = piece.get(next) {
            next += 1;
            let own = is_turned[face as usize] == Some(true);
            for &(other, agrees) in neighbours.around(face) {
                if is_turned[other as usize].is_none() {
                    is_turned[other as usize] = Some(own == agrees);
                    piece.push(other);
                }
            }
        }
        let turned = |face: u32| is_turned[face as usize] == Some(true);
        if signed_volume(mesh, &piece, turned) < 0.0 {
            for &face in &piece {
                is_turned[face as usize] = is_turned[face as usize].map(|turned| !turned);
            }
        }
    }
    done.turned = is_turned.iter().filter(|&&t| t == Some(true)).count();
    let turn = |(&[a, b, c], turned): (&[u32; 3], &Option<bool>)| {
        if *turned == Some(true) { [a, c, b] } else { [a, b, c] }
    };
    let triangles = mesh.triangles().iter().zip(&is_turned).map(turn).collect();
    Mesh::new(mesh.positions().to_vec(), triangles)
}

fn signed_volume(mesh: &Mesh, faces: &[u32], is_turned: impl Fn(u32) -> bool) -> f64 {
    let corners = |face: u32| mesh.corners(face as usize);
    let middle = Aabb::of_points(faces.iter().flat_map(|&f| corners(f))).centre();
    let cone = |face: u32| {
        let [a, b, c] = corners(face).map(|p| p - middle);
        let six_fold = a.dot(b.cross(c));
        if is_turned(face) { -six_fold } else { six_fold }
    };
    faces.iter().map(|&face| cone(face)).sum()
}

/// The faces beside each face across edges of two faces, and whether both agree about the outside.
struct Neighbours {
    /// Up to three for each face.
    of: Vec<[(u32, bool); 3]>,
    counts: Vec<u8>,
}

impl Neighbours {
    fn of(mesh: &Mesh) -> Self {
        let faces = mesh.triangles().len();
        let mut all = Self { of: vec![[(0, false); 3]; faces], counts: vec![0; faces] };
        for_each_edge(mesh, |walks| {
            if let [a, b] = walks {
                all.add(a.face, (b.face, a.agrees(b)));
                all.add(b.face, (a.face, a.agrees(b)));
            }
        });
        all
    }

    fn add(&mut self, face: u32, neighbour: (u32, bool)) {
        let count = &mut self.counts[face as usize];
        self.of[face as usize][usize::from(*count)] = neighbour;
        *count += 1;
    }

    fn around(&self, face: u32) -> &[(u32, bool)] {
        &self.of[face as usize][..usize::from(self.counts[face as usize])]
    }
}
