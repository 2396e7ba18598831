//! The best and the preferred centre of a mesh.
//!
//! The best centre maximises the clearance: a linear program with four unknowns, max rho subject to
//! n_i.c + rho <= n_i.v_i, solved by constraint generation, since only a few faces bind.

use glam::{DMat3, DVec3};
use microlp::{ComparisonOp, OptimizationDirection, Problem};

use crate::fit::star::{Plane, check_faces, least_clearance, planes};
use crate::mesh::Mesh;
use crate::{Error, Result};

/// Finds the centre, metres, with the largest clearance, metres, within the bounds of the mesh. A
/// positive clearance says that it sees every face; the clearance is that of the centre given, and
/// within 1e-6 of the size of the mesh of the best.
///
/// # Errors
/// As [`super::test()`]; [`Error::Numeric`] when the linear program fails.
pub fn best_centre(mesh: &Mesh) -> Result<(DVec3, f64)> {
    check_faces(mesh)?;
    let bounds = mesh.bounds();
    let unit = Unit { middle: bounds.centre(), size: 0.5 * bounds.extent().max_element() };
    let half = bounds.extent() / (2.0 * unit.size);
    // Any few faces start it: the extreme ones are found within a few rounds.
    let step = mesh.triangles().len().div_ceil(START);
    let mut chosen: Vec<Row> = planes(mesh).step_by(step).map(|p| unit.row(&p)).collect();
    for _ in 0..ROUNDS {
        let (centre, rho) = solve(&chosen, half)?;
        let missed = most_violated(mesh, &unit, &chosen, centre, rho);
        if missed.is_empty() {
            let centre = unit.middle + unit.size * centre;
            return Ok((centre, least_clearance(mesh, centre).1));
        }
        chosen.extend(missed);
    }
    Err(Error::Numeric(format!(
        "the search for the best centre did not settle in {ROUNDS} rounds; give the centre yourself"
    )))
}

/// Faces the search starts with.
const START: usize = 32;
/// Violated faces taken in a round.
const TAKEN: usize = 16;
/// Rounds after which the search gives up; the head takes about ten.
const ROUNDS: usize = 1000;
/// The tolerance of the linear program, which a face must miss by more to be taken, in units of
/// half the size of the mesh.
const TOLERANCE: f64 = 2e-7;

/// The units of the linear program: the mesh within [-1, 1], where microlp's absolute tolerance of
/// 1e-7 means something.
struct Unit {
    middle: DVec3,
    size: f64,
}

/// One constraint: normal.c + rho <= offset.
#[derive(Clone, Copy)]
struct Row {
    face: usize,
    normal: DVec3,
    offset: f64,
}

impl Unit {
    fn row(&self, plane: &Plane) -> Row {
        Row {
            face: plane.face,
            normal: plane.normal,
            offset: plane.clearance(self.middle) / self.size,
        }
    }
}

/// Solves the linear program for these faces, the centre within a box of these half edges.
fn solve(rows: &[Row], half: DVec3) -> Result<(DVec3, f64)> {
    let mut problem = Problem::new(OptimizationDirection::Maximize);
    let c = half.to_array().map(|h| problem.add_var(0.0, (-h, h)));
    // No plane of a mesh within [-1, 1] is farther than sqrt 12 from a point within.
    let rho = problem.add_var(1.0, (-4.0, 4.0));
    for Row { normal: n, offset, .. } in rows {
        let sum = [(c[0], n.x), (c[1], n.y), (c[2], n.z), (rho, 1.0)];
        problem.add_constraint(sum, ComparisonOp::Le, *offset);
    }
    let failed = |reason: String| {
        Error::Numeric(format!(
            "the linear program for the best centre failed ({reason}); give the centre yourself"
        ))
    };
    let outcome = problem.solve().map_err(|e| failed(e.to_string()))?;
    let solution = outcome.solution().ok_or_else(|| failed("no solution".to_owned()))?;
    let centre = DVec3::from_array(c.map(|v| solution.var_value(v)));
    Ok((centre, solution.var_value(rho)))
}

/// Lists up to a few faces that are not in use and that the solution violates most.
fn most_violated(mesh: &Mesh, unit: &Unit, in_use: &[Row], centre: DVec3, rho: f64) -> Vec<Row> {
    let mut worst: Vec<(f64, Row)> = Vec::with_capacity(TAKEN + 1);
    for plane in planes(mesh) {
        let row = unit.row(&plane);
        let excess = row.normal.dot(centre) + rho - row.offset;
        let least = if worst.len() < TAKEN { TOLERANCE } else { worst[TAKEN - 1].0 };
        if excess > least && in_use.iter().all(|used| used.face != row.face) {
            let place = worst.partition_point(|(e, _)| *e >= excess);
            worst.insert(place, (excess, row));
            worst.truncate(TAKEN);
        }
    }
    worst.into_iter().map(|(_, row)| row).collect()
}

/// The share of the best clearance that a preferred centre keeps.
const KEPT: f64 = 0.5;

/// Finds, among the centres with at least half the best clearance, the one nearest the centroid of
/// the volume; with it, its clearance, metres. Where no centre is valid (the best clearance is not
/// positive) it is the best one.
///
/// The best centre of a shape may be far from its middle, where a series about it converges slowly;
/// a centre that barely sees some face makes the radius steep there. This keeps away from both.
///
/// # Errors
/// As [`best_centre`].
pub fn preferred_centre(mesh: &Mesh) -> Result<(DVec3, f64)> {
    Ok(centres(mesh)?.1)
}

/// Finds the best centre and the preferred one, each with its clearance, metres: one search for
/// both.
///
/// # Errors
/// As [`best_centre`].
pub fn centres(mesh: &Mesh) -> Result<((DVec3, f64), (DVec3, f64))> {
    let best = best_centre(mesh)?;
    Ok((best, preferred_beside(mesh, best)))
}

fn preferred_beside(mesh: &Mesh, (best, most): (DVec3, f64)) -> (DVec3, f64) {
    if most.is_nan() || most <= 0.0 {
        return (best, most);
    }
    let goal = mesh.centroid(best);
    let size = mesh.bounds().extent().max_element();
    let centre = nearest(mesh, goal, KEPT * most, size).unwrap_or(best);
    (centre, least_clearance(mesh, centre).1)
}

/// A half-space normal.y <= offset, relative to the goal.
#[derive(Clone, Copy)]
struct HalfSpace {
    normal: DVec3,
    offset: f64,
}

/// Finds the point nearest the goal with this clearance: the projection on a polyhedron, which at
/// most three faces decide. The face missed most is taken up until none is missed; of those in use
/// the best three are kept. `None` when rounding stops that.
fn nearest(mesh: &Mesh, goal: DVec3, clearance: f64, size: f64) -> Option<DVec3> {
    let tolerance = TOLERANCE * size;
    let half_space =
        |p: super::Plane| HalfSpace { normal: p.normal, offset: p.clearance(goal) - clearance };
    let (mut at, mut basis) = (DVec3::ZERO, Vec::new());
    for _ in 0..ROUNDS {
        let excess = |h: &HalfSpace| h.normal.dot(at) - h.offset;
        let missed = planes(mesh).map(half_space).max_by(|a, b| excess(a).total_cmp(&excess(b)))?;
        if excess(&missed) <= tolerance {
            return Some(goal + at);
        }
        let (next, kept) = exchanged(&basis, missed, tolerance * 1e-3)?;
        if next.length_squared() <= at.length_squared() {
            return None;
        }
        (at, basis) = (next, kept);
    }
    None
}

/// Finds the point nearest 0 within the half-spaces in use and a new one, which is on the plane of
/// the new one, and keeps those whose planes it is on.
fn exchanged(
    basis: &[HalfSpace],
    new: HalfSpace,
    tolerance: f64,
) -> Option<(DVec3, Vec<HalfSpace>)> {
    let mut choices = vec![vec![new]];
    for (i, &a) in basis.iter().enumerate() {
        choices.push(vec![new, a]);
        choices.extend(basis[i + 1..].iter().map(|&b| vec![new, a, b]));
    }
    let is_within =
        |p: DVec3| basis.iter().chain([&new]).all(|h| h.normal.dot(p) - h.offset <= tolerance);
    let found = choices.into_iter().filter_map(|planes| Some((nearest_on(&planes)?, planes)));
    found
        .filter(|(p, _)| is_within(*p))
        .min_by(|a, b| a.0.length_squared().total_cmp(&b.0.length_squared()))
}

/// Returns the point nearest 0 that is on one, two or three planes; `None` when they are parallel.
fn nearest_on(planes: &[HalfSpace]) -> Option<DVec3> {
    let point = match *planes {
        [a] => a.offset * a.normal,
        [a, b] => {
            let cosine = a.normal.dot(b.normal);
            let below = 1.0 - cosine * cosine;
            let [u, v] = [a.offset - cosine * b.offset, b.offset - cosine * a.offset];
            (u * a.normal + v * b.normal) / below
        }
        [a, b, c] => {
            let rows = DMat3::from_cols(a.normal, b.normal, c.normal).transpose();
            rows.inverse() * DVec3::new(a.offset, b.offset, c.offset)
        }
        _ => return None,
    };
    point.is_finite().then_some(point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::star;
    use crate::math::{Randomness, Stream, sampling};
    use crate::mesh::shapes;

    #[test]
    fn preferred_centre_is_the_centroid_where_that_sees_enough() {
        let mesh = shapes::cube().translated(DVec3::splat(7.0));
        let (centre, clearance) = preferred_centre(&mesh).expect("faces");
        assert!((centre - DVec3::splat(7.5)).length() <= 1e-14 && (clearance - 0.5).abs() <= 1e-14);
        // No centre sees a U: the best one is given.
        let u_shape = shapes::u_shape();
        assert_eq!(
            preferred_centre(&u_shape).expect("faces"),
            best_centre(&u_shape).expect("faces")
        );
        assert!(preferred_centre(&Mesh::default()).is_err());
    }

    #[test]
    fn preferred_centre_of_an_l_goes_towards_the_centroid() {
        // The kernel is the unit cube and the centroid (1.1, 1.1, 0.5), so that a clearance of 1/4
        // leaves (3/4, 3/4, 1/2).
        let (centre, clearance) = preferred_centre(&shapes::l_shape()).expect("faces");
        assert!((centre - DVec3::new(0.75, 0.75, 0.5)).length() <= 2e-6, "{centre}");
        assert!((clearance - 0.25).abs() <= 2e-6, "{clearance}");
    }

    #[test]
    fn no_centre_with_half_the_clearance_is_nearer_the_centroid() {
        let pear = |p: DVec3| p * (1.0 + 0.5 * p.z.max(-0.3)) + 0.6 * p.z * p.z * DVec3::X;
        let sphere = shapes::sphere(4);
        let positions = sphere.positions().iter().map(|&p| pear(p)).collect();
        let mesh = Mesh::new(positions, sphere.triangles().to_vec()).expect("indices in range");
        let (best, most) = best_centre(&mesh).expect("faces");
        let goal = mesh.centroid(best);
        let (centre, clearance) = preferred_centre(&mesh).expect("faces");
        assert!(clearance >= 0.5 * most - 1e-6, "{clearance} {most}");
        let distance = centre.distance(goal);
        for i in 0..2000 {
            let [a, b, c, _] = Stream::new(Randomness::Sobol, 9, i).next_4d();
            let other = goal + c.cbrt() * distance * sampling::uniform_sphere([a, b]);
            let sees = star::test(&mesh, other).expect("faces").clearance;
            assert!(sees <= 0.5 * most + 1e-5 || other.distance(goal) >= distance - 1e-5);
        }
    }

    #[test]
    fn constraint_generation_equals_the_full_program() {
        // A lumpy star: 2048 faces, none of them special.
        let lumpy = |p: DVec3| p * (1.0 + 0.3 * (3.0 * p.x).sin() * (5.0 * p.y).cos() + 0.1 * p.z);
        let sphere = shapes::sphere(4);
        let positions = sphere.positions().iter().map(|&p| lumpy(p)).collect();
        let mesh = Mesh::new(positions, sphere.triangles().to_vec()).expect("indices in range");
        let unit = Unit { middle: DVec3::ZERO, size: 1.0 };
        let rows: Vec<_> = planes(&mesh).map(|p| unit.row(&p)).collect();
        let (_, rho) = solve(&rows, DVec3::splat(1.5)).expect("a solution");
        let (centre, clearance) = best_centre(&mesh).expect("faces");
        assert!((clearance - rho).abs() <= 1e-6, "{clearance} {rho}");
        assert!((star::test(&mesh, centre).expect("faces").clearance - clearance).abs() <= 0.0);
    }
}
