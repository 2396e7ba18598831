//! The faces of a mesh in an order in which neighbours in space are neighbours, with the area up to
//! each: what spreads points evenly over a mesh whatever the order of its file. The order is that
//! of Morton (1966): the bits of x, y and z of the middles of the faces, interleaved.

use super::Mesh;

/// Lists faces by place.
#[derive(Debug, Clone)]
pub(super) struct Spread {
    pub(super) faces: Vec<u32>,
    /// The area of the faces up to and with each, m2.
    pub(super) areas: Vec<f64>,
}

/// The cells along an axis: 21 bits for each of three make 63.
const CELLS: f64 = (1_u64 << 21) as f64;

impl Spread {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let bounds = mesh.bounds();
        // A cube, so that no axis counts more than another.
        let side = bounds.extent().max_element();
        let code = |face: u32| {
            let place = (mesh.middle(face as usize) - bounds.min) / side * (CELLS - 1.0);
            // What is not finite becomes 0.
            place.to_array().into_iter().fold(0, |code, x| (code << 1) | parted(x as u64))
        };
        let mut faces: Vec<u32> = (0..mesh.triangles().len() as u32).collect();
        faces.sort_by_cached_key(|&face| code(face));
        let mut sum = 0.0;
        let mut add = |face: &u32| {
            sum += mesh.area_vector(*face as usize).length();
            sum
        };
        let areas = faces.iter().map(&mut add).collect();
        Self { faces, areas }
    }
}

/// Puts two empty bits between the 21 bits of a number.
const fn parted(x: u64) -> u64 {
    let x = x & 0x1f_ffff;
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn bits_are_two_places_apart() {
        let slow = |x: u64| (0..21).fold(0, |y, i| y | ((x >> i & 1) << (3 * i)));
        for x in [0, 1, 2, 0x1f_ffff, 0x15_5555, 0x0a_aaaa, 0x12_3456] {
            assert_eq!(parted(x), slow(x), "{x:x}");
        }
    }

    #[test]
    fn every_face_is_there_once_and_the_next_is_near() {
        let mesh = shapes::sphere(4);
        let spread = Spread::new(&mesh);
        let mut sorted = spread.faces.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &f)| i == f as usize));
        assert!((spread.areas.last().expect("faces") - mesh.area()).abs() <= 1e-12);
        let step = |w: &[u32]| mesh.middle(w[0] as usize).distance(mesh.middle(w[1] as usize));
        let mean = spread.faces.windows(2).map(step).sum::<f64>() / sorted.len() as f64;
        // Faces of 0.08; a random order would step 4/3.
        assert!(mean <= 0.2, "{mean}");
    }
}
