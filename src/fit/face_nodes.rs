//! The points of a mesh's faces as quadrature nodes on the sphere about a centre.
//!
//! d omega = d_T dA / |x|^3, d_T the distance of the face's plane from the centre: an integral over
//! the sphere becomes a sum over faces of smooth integrals, each taken by a Duffy rule whose number
//! of points follows from the face's angular size and the degree.

use glam::DVec3;
use rayon::prelude::*;

use crate::math::quadrature::Rule;

/// Returns how many faces are added up together, by their number alone, so that sums do not depend
/// on the number of threads; few large faces are as much work as many small ones.
fn faces_per_task(faces: usize) -> usize {
    (faces / 64).clamp(1, 512)
}

/// Tasks under way at once for each thread: what they hold together bounds the memory.
const TASKS_PER_THREAD: usize = 4;

/// The largest number of points along each side of a face; one that wants more is split in four.
pub(super) const FINEST: usize = 24;

/// How often a face may be split for its size: enough for one that fills half the sphere at degree
/// 1000.
pub(super) const DEEPEST: usize = 8;

/// A point of a face as a quadrature node on the sphere about the centre.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    /// From the centre to the point, a unit vector.
    pub(super) direction: DVec3,
    /// The distance from the centre, metres.
    pub(super) radius: f64,
    /// The part of the sphere the node stands for; negative on a face seen from behind.
    pub(super) solid_angle: f64,
    /// The part of the face the node stands for, m2.
    pub(super) area: f64,
}

/// Works on all faces in tasks and merges what they give in the order of the faces: sums do not
/// depend on the number of threads, and no more than a few results for each thread exist at once.
pub(super) fn fold_faces<T: Send>(
    faces: usize,
    task: impl Fn(std::ops::Range<usize>) -> T + Sync,
    mut merge: impl FnMut(T),
) {
    let each = faces_per_task(faces);
    let tasks = faces.div_ceil(each);
    let at_once = TASKS_PER_THREAD * rayon::current_num_threads();
    for first in (0..tasks).step_by(at_once) {
        let parts: Vec<T> = (first..(first + at_once).min(tasks))
            .into_par_iter()
            .map(|i| task(i * each..((i + 1) * each).min(faces)))
            .collect();
        parts.into_iter().for_each(&mut merge);
    }
}

/// Returns the Gauss-Legendre rules on [0, 1] with 0..=FINEST points (index 0 repeats 1).
pub(super) fn rules() -> Vec<Rule> {
    (0..=FINEST).map(|n| Rule::gauss_legendre(n).on(0.0, 1.0)).collect()
}

/// Chooses the points along each side of a face: Gauss-Legendre converges once it has about one
/// point per radian of the basis functions' phase, which is lmax times the angle the face spans; a
/// face seen edge-on adds the swing of 1/|x|^2.
pub(super) fn points_per_side(corners: &[DVec3; 3], lmax: usize) -> usize {
    let radii = corners.map(DVec3::length);
    let swing = (radii[0].max(radii[1]).max(radii[2]) / radii[0].min(radii[1]).min(radii[2])).ln();
    // The last ten radians of phase stand for the turn of 1/|x|^2 itself.
    let points = 4.0 + (lmax as f64 + 10.0) * span(corners) + 8.0 * swing;
    if points.is_finite() { points as usize } else { FINEST }
}

/// Returns the largest angle, radians, that a side of a face spans.
pub(super) fn span([a, b, c]: &[DVec3; 3]) -> f64 {
    a.angle_between(*b).max(b.angle_between(*c)).max(c.angle_between(*a))
}

/// Splits a face in four at the middles of its edges.
pub(super) fn quarters([a, b, c]: [DVec3; 3]) -> [[DVec3; 3]; 4] {
    let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// Visits the quadrature nodes of a face, after splitting it as often as its size asks for.
pub(super) fn visit_face(
    corners: [DVec3; 3],
    points: &impl Fn(&[DVec3; 3]) -> usize,
    rules: &[Rule],
    splits: usize,
    visit: &mut impl FnMut(Node),
) {
    let wanted = points(&corners);
    if wanted <= FINEST || splits == 0 {
        for_each_node(&corners, &rules[wanted.min(FINEST)], visit);
        return;
    }
    for quarter in quarters(corners) {
        visit_face(quarter, points, rules, splits - 1, visit);
    }
}

/// Walks over the Duffy points of a face: the square collapsed onto the triangle, u towards the
/// side opposite to the first corner.
pub(super) fn for_each_node([a, b, c]: &[DVec3; 3], rule: &Rule, mut visit: impl FnMut(Node)) {
    // Twice the area, and that times the distance of the plane from the centre.
    let double_area = (*b - *a).cross(*c - *a).length();
    let volume = a.dot(b.cross(*c));
    for (u, weight_u) in rule.iter() {
        for (v, weight_v) in rule.iter() {
            let x = *a + u * ((*b - *a) + v * (*c - *b));
            let radius = x.length();
            if radius > 0.0 {
                let weight = u * weight_u * weight_v;
                visit(Node {
                    direction: x / radius,
                    radius,
                    solid_angle: volume * weight / radius.powi(3),
                    area: double_area * weight,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn solid_angles_and_areas_of_a_closed_mesh_add_up() {
        let mesh = shapes::sphere(0).scaled(2.0).expect("positive");
        let centre = DVec3::new(0.1, -0.2, 0.3);
        let rules = rules();
        let (mut sphere, mut area) = (0.0, 0.0);
        for face in 0..8 {
            let corners = mesh.corners(face).map(|x| x - centre);
            for_each_node(&corners, &rules[FINEST], |node| {
                sphere += node.solid_angle;
                area += node.area;
            });
        }
        assert!((sphere - 4.0 * PI).abs() <= 1e-12);
        assert!((area - mesh.area()).abs() <= 1e-12);
    }

    #[test]
    fn points_follow_the_angular_size() {
        let wide = [DVec3::X, DVec3::Y, DVec3::Z];
        let narrow = [DVec3::X, DVec3::new(1.0, 0.01, 0.0), DVec3::new(1.0, 0.0, 0.01)];
        assert!(points_per_side(&wide, 64) > FINEST);
        assert_eq!(points_per_side(&narrow, 32), 4);
    }

    #[test]
    fn tasks_come_in_order_and_none_is_lost() {
        for faces in [0, 1, 100, 512, 20_487] {
            let mut next = 0;
            fold_faces(
                faces,
                |range| range,
                |range| {
                    assert_eq!(range.start, next);
                    next = range.end;
                },
            );
            assert_eq!(next, faces);
        }
    }
}
