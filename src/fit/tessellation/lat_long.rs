//! The sphere by latitude and longitude: each pole is one vertex with a fan of faces around it, so
//! no face is without area.

use std::f64::consts::PI;

use glam::DVec3;

use crate::fit::tessellation::SphereMesh;

/// Makes a sphere of `bands` from pole to pole (at least 2) and `azimuths` around (at least 3): 2
/// azimuths (bands - 1) faces.
pub(super) fn lat_long(bands: usize, azimuths: usize) -> SphereMesh {
    let rings = bands - 1;
    let mut directions = Vec::with_capacity(2 + rings * azimuths);
    directions.push(DVec3::Z);
    for ring in 1..bands {
        let (s, z) = (PI * ring as f64 / bands as f64).sin_cos();
        directions.extend((0..azimuths).map(|j| {
            let (sin, cos) = (2.0 * PI * j as f64 / azimuths as f64).sin_cos();
            DVec3::new(s * cos, s * sin, z)
        }));
    }
    directions.push(DVec3::NEG_Z);
    let south = directions.len() - 1;
    let at = |ring: usize, j: usize| 1 + ring * azimuths + j % azimuths;
    let mut triangles = Vec::with_capacity(2 * azimuths * rings);
    for j in 0..azimuths {
        triangles.push([0, at(0, j), at(0, j + 1)]);
        for ring in 0..rings - 1 {
            let [a, b] = [at(ring, j), at(ring, j + 1)];
            let [c, d] = [at(ring + 1, j), at(ring + 1, j + 1)];
            triangles.extend([[a, c, d], [a, d, b]]);
        }
        triangles.push([south, at(rings - 1, j + 1), at(rings - 1, j)]);
    }
    let triangles = triangles.into_iter().map(|t| t.map(|v| v as u32)).collect();
    SphereMesh { directions, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, MeshReport};

    #[test]
    fn poles_are_proper_and_the_seam_is_closed() {
        for (bands, azimuths) in [(2, 3), (3, 4), (9, 16)] {
            let sphere = lat_long(bands, azimuths);
            assert_eq!(sphere.triangles.len(), 2 * azimuths * (bands - 1));
            let mesh = Mesh::new(sphere.directions, sphere.triangles).expect("indices in range");
            let report = MeshReport::of(&mesh);
            assert!(report.is_closed() && report.volume > 0.0);
            assert_eq!(report.deficiencies(), Vec::<String>::new());
            assert_eq!((report.euler(), report.vertices), (2, 2 + (bands - 1) * azimuths));
        }
    }
}
