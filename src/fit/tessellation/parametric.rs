//! The mesh of a parametric surface: x, y and z as three series over a sphere of parameters, as
//! SPHARM-PDM describes surfaces.

use glam::DVec3;
use rayon::prelude::*;

use super::{ask_for, icosphere::icosphere};
use crate::Result;
use crate::mesh::Mesh;
use crate::sh::{Coefficients, Evaluator};

/// How many parts of an edge of the icosahedron each degree takes: the finest wave of a series has
/// some 30 of them.
const PARTS: usize = 8;

/// The fewest and the most parts of an edge.
const FEWEST: usize = 32;
const MOST: usize = 256;

/// Makes a closed mesh of the surface (x, y, z)(omega), whose three series have one degree, fine
/// enough for that; its faces look outward, whichever way the parameters turn.
///
/// # Errors
/// [`crate::Error::Parameter`] for a degree too high to evaluate; [`crate::Error::Memory`].
pub fn parametric_mesh(set: &[Coefficients; 3]) -> Result<Mesh> {
    let frequency = (PARTS * set[0].lmax()).clamp(FEWEST, MOST);
    ask_for(20 * frequency * frequency)?;
    let sphere = icosphere(frequency);
    let [x, y, z] = [Evaluator::new(&set[0])?, Evaluator::new(&set[1])?, Evaluator::new(&set[2])?];
    let point = |w: &DVec3| DVec3::new(x.value(*w), y.value(*w), z.value(*w));
    let points = sphere.directions.par_iter().map(point).collect();
    let mesh = Mesh::new(points, sphere.triangles)?;
    Ok(if mesh.volume() < 0.0 { mesh.flipped() } else { mesh })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::mesh::MeshReport;
    use crate::sh::positions;

    #[test]
    fn ellipsoid_has_its_volume_whichever_way_its_parameters_turn() {
        let mut ball = Coefficients::zeros(0);
        ball.set(0, 0, 1.0, 0.0);
        let unit = positions(&ball, DVec3::ZERO);
        let of = |axes: [f64; 3]| [0, 1, 2].map(|i| unit[i].clone().scaled(axes[i]));
        let exact = 4.0 / 3.0 * PI * 6.0;
        for axes in [[1.0, 2.0, 3.0], [-1.0, 2.0, 3.0]] {
            let mesh = parametric_mesh(&of(axes)).expect("low");
            // Of the sphere itself faces of 2 degrees leave 4e-4 out, and so of what it is
            // stretched to.
            let lost = 1.0 - mesh.volume() / exact;
            assert!((1e-4..=1e-3).contains(&lost), "{lost}");
            assert!(MeshReport::of(&mesh).is_closed());
            let bounds = mesh.bounds();
            assert!((bounds.max - DVec3::new(1.0, 2.0, 3.0)).abs().max_element() <= 5e-3);
        }
    }
}
