//! Refinement to a tolerance: faces whose surface is too far are cut at the edges that are to
//! blame.
//!
//! A cut edge is cut for both of its faces, so the mesh stays conforming. A face with any cut edge
//! has its longest edge cut too, and first (Rivara 1984, "Algorithms for refining triangular grids
//! suitable for adaptive and multigrid techniques"): angles stay bounded below however deep it
//! goes.

use glam::DVec3;
use rayon::prelude::*;

use crate::fit::tessellation::chord_error::{lifted, point, samples};
use crate::fit::tessellation::icosphere::icosphere;
use crate::fit::tessellation::{MAX_FACES, SphereMesh, lift};
use crate::mesh::triangle::nearest_on_triangle;
use crate::sh::Evaluator;
use crate::{Error, Result};

/// Rounds of refinement, each of which may halve every edge: more than the resolution of f64
/// allows.
const ROUNDS: usize = 64;

/// A mesh on its way to the tolerance.
struct Refinement<'a> {
    series: &'a Evaluator,
    tolerance: f64,
    directions: Vec<DVec3>,
    /// The vertices, from the centre.
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// Whether each face is known to be within the tolerance.
    settled: Vec<bool>,
}

/// Refines a geodesic sphere until the surface is within `tolerance`, metres, of the faces at all
/// samples.
///
/// # Errors
/// [`Error::Parameter`] when that takes more than [`MAX_FACES`]; [`Error::Geometry`] where the
/// radius is not positive.
pub(super) fn adaptive(series: &Evaluator, tolerance: f64) -> Result<SphereMesh> {
    // Six degrees for each cut of the icosahedron's edges: the samples of a face then see every
    // lobe of the series.
    let start = icosphere(1 + series.coefficients().lmax() / 6);
    let points = lift(series, &start.directions)?;
    let mut mesh = Refinement {
        series,
        tolerance,
        settled: vec![false; start.triangles.len()],
        points,
        directions: start.directions,
        triangles: start.triangles,
    };
    for _ in 0..ROUNDS {
        if !mesh.refine()? {
            return Ok(SphereMesh { directions: mesh.directions, triangles: mesh.triangles });
        }
    }
    Err(too_many_faces(tolerance))
}

/// Says that a tolerance is too fine.
pub(super) fn too_many_faces(tolerance: f64) -> Error {
    Error::Parameter(format!(
        "a chord error of {tolerance:e} m takes more than {MAX_FACES} faces; allow a larger error"
    ))
}

impl Refinement<'_> {
    /// Cuts once all edges to blame; tells whether there were any.
    fn refine(&mut self) -> Result<bool> {
        let blamed: Vec<[bool; 3]> =
            (0..self.triangles.len()).into_par_iter().map(|face| self.judge(face)).collect();
        if !blamed.iter().flatten().any(|b| *b) {
            return Ok(false);
        }
        let edges = Edges::of(&self.triangles);
        let longest: Vec<usize> =
            (0..self.triangles.len()).into_par_iter().map(|face| self.longest(face)).collect();
        let cut = close(&edges, &blamed, &longest);
        let cuts = cut.iter().filter(|c| **c).count();
        // Each cut makes one face of each of its two neighbours into two.
        if self.triangles.len() + 2 * cuts > MAX_FACES {
            return Err(too_many_faces(self.tolerance));
        }
        super::ask_for(self.triangles.len() + 2 * cuts)?;
        let middles = self.add_middles(&edges, &cut, cuts)?;
        self.split(&edges, &middles, &longest, &blamed);
        Ok(true)
    }

    fn corners(&self, face: usize) -> [DVec3; 3] {
        self.triangles[face].map(|v| self.points[v as usize])
    }

    /// Returns which edges of a face (the one from corner k to corner k + 1 has number k) must be
    /// cut.
    fn judge(&self, face: usize) -> [bool; 3] {
        let mut blamed = [false; 3];
        if self.settled[face] {
            return blamed;
        }
        let corners = self.corners(face);
        let mut inside = false;
        for weights in samples() {
            let above = lifted(self.series, point(&corners, weights));
            let distance = above.distance(nearest_on_triangle(above, corners));
            if distance <= self.tolerance {
                continue;
            }
            match weights.iter().position(|w| *w == 0) {
                Some(corner) => blamed[(corner + 1) % 3] = true,
                None => inside = true,
            }
        }
        if inside && !blamed.contains(&true) {
            blamed[self.longest(face)] = true;
        }
        blamed
    }

    /// Returns the number of the longest edge of a face; of equal ones that between the highest
    /// vertices, so that neighbours agree.
    fn longest(&self, face: usize) -> usize {
        let vertices = self.triangles[face];
        let key = |k: usize| {
            let [a, b] = [vertices[k], vertices[(k + 1) % 3]];
            let length = self.points[a as usize].distance_squared(self.points[b as usize]);
            (length, a.max(b), a.min(b))
        };
        (1..3).fold(0, |best, k| {
            let (new, old) = (key(k), key(best));
            let longer = new.0.total_cmp(&old.0).then((new.1, new.2).cmp(&(old.1, old.2)));
            if longer.is_gt() { k } else { best }
        })
    }

    /// Puts a vertex above the middle of each cut edge; gives their numbers by the edge's, 0 where
    /// none is cut.
    fn add_middles(&mut self, edges: &Edges, cut: &[bool], cuts: usize) -> Result<Vec<u32>> {
        let mut middles = vec![0; cut.len()];
        let mut wanted = Vec::with_capacity(cuts);
        for (edge, _) in cut.iter().enumerate().filter(|(_, cut)| **cut) {
            middles[edge] = (self.points.len() + wanted.len()) as u32;
            wanted.push(edges.ends[edge].map(|v| self.points[v as usize]));
        }
        let above = |[a, b]: &[DVec3; 2]| (0.5 * (*a + *b)).normalize();
        let directions: Vec<DVec3> = wanted.par_iter().map(above).collect();
        self.points.extend(lift(self.series, &directions)?);
        self.directions.extend(directions);
        Ok(middles)
    }

    /// Splits the faces at their cut edges, the longest first.
    fn split(&mut self, edges: &Edges, middles: &[u32], longest: &[usize], blamed: &[[bool; 3]]) {
        let mut triangles = Vec::with_capacity(self.triangles.len() * 2);
        let mut settled = Vec::with_capacity(self.triangles.len() * 2);
        for (face, vertices) in self.triangles.iter().enumerate() {
            let first = longest[face];
            let turn = |k: usize| (first + k) % 3;
            let [a, b, c] = [0, 1, 2].map(|k| vertices[turn(k)]);
            let [ab, bc, ca] = [0, 1, 2].map(|k| middles[edges.of_face[face][turn(k)] as usize]);
            let before = triangles.len();
            if ab == 0 {
                triangles.push(*vertices);
                settled.push(!blamed[face].contains(&true));
                continue;
            }
            match bc {
                0 => triangles.push([ab, b, c]),
                _ => triangles.extend([[ab, b, bc], [ab, bc, c]]),
            }
            match ca {
                0 => triangles.push([ab, c, a]),
                _ => triangles.extend([[ab, c, ca], [ab, ca, a]]),
            }
            settled.extend((before..triangles.len()).map(|_| false));
        }
        self.triangles = triangles;
        self.settled = settled;
    }
}

/// Cuts the longest edge of every face that has an edge cut, until there is nothing to add.
fn close(edges: &Edges, blamed: &[[bool; 3]], longest: &[usize]) -> Vec<bool> {
    let mut cut = vec![false; edges.ends.len()];
    let mut waiting: Vec<u32> = Vec::new();
    for (face, marks) in blamed.iter().enumerate() {
        for (edge, _) in edges.of_face[face].iter().zip(marks).filter(|(_, mark)| **mark) {
            if !std::mem::replace(&mut cut[*edge as usize], true) {
                waiting.push(*edge);
            }
        }
    }
    while let Some(edge) = waiting.pop() {
        for face in edges.faces[edge as usize] {
            let longest = edges.of_face[face as usize][longest[face as usize]];
            if !std::mem::replace(&mut cut[longest as usize], true) {
                waiting.push(longest);
            }
        }
    }
    cut
}

/// Numbers the edges of a closed mesh.
struct Edges {
    /// The two vertices of each edge.
    ends: Vec<[u32; 2]>,
    /// The two faces of each edge.
    faces: Vec<[u32; 2]>,
    /// The edges of each face, from corner k to corner k + 1.
    of_face: Vec<[u32; 3]>,
}

impl Edges {
    fn of(triangles: &[[u32; 3]]) -> Self {
        let mut sides: Vec<([u32; 2], u32, u8)> = triangles
            .par_iter()
            .enumerate()
            .flat_map_iter(|(face, t)| {
                (0..3_u8).map(move |k| {
                    let [a, b] = [t[usize::from(k)], t[usize::from(k + 1) % 3]];
                    ([a.min(b), a.max(b)], face as u32, k)
                })
            })
            .collect();
        sides.par_sort_unstable();
        let mut edges = Self {
            ends: Vec::with_capacity(sides.len() / 2),
            faces: Vec::with_capacity(sides.len() / 2),
            of_face: vec![[0; 3]; triangles.len()],
        };
        for (ends, face, k) in sides {
            if edges.ends.last() == Some(&ends) {
                if let Some(pair) = edges.faces.last_mut() {
                    pair[1] = face;
                }
            } else {
                edges.ends.push(ends);
                edges.faces.push([face, face]);
            }
            edges.of_face[face as usize][usize::from(k)] = (edges.ends.len() - 1) as u32;
        }
        edges
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sh::Coefficients;

    #[test]
    fn edges_of_a_closed_mesh_have_two_faces() {
        let sphere = icosphere(3);
        let edges = Edges::of(&sphere.triangles);
        assert_eq!(edges.ends.len(), sphere.triangles.len() * 3 / 2);
        assert!(edges.faces.iter().all(|[a, b]| a != b));
        for (face, t) in sphere.triangles.iter().enumerate() {
            for k in 0..3 {
                let mut ends = [t[k], t[(k + 1) % 3]];
                ends.sort_unstable();
                assert_eq!(edges.ends[edges.of_face[face][k] as usize], ends);
            }
        }
    }

    #[test]
    fn refinement_goes_where_the_surface_bends() {
        // A sphere with a narrow bump at the north pole.
        let mut c = Coefficients::zeros(24);
        for l in 0..=24 {
            c.set(l, 0, 0.02 * (2 * l + 1) as f64 * (-0.01 * (l * l) as f64).exp(), 0.0);
        }
        c.set(0, 0, 1.0, 0.0);
        let series = Evaluator::new(&c).expect("degree 24");
        let mesh = adaptive(&series, 2e-3).expect("few faces");
        let near = |limit: f64| {
            let middles = mesh
                .triangles
                .iter()
                .map(|t| t.iter().map(|v| mesh.directions[*v as usize]).sum::<DVec3>().normalize());
            middles.filter(|w| w.z > limit).count() as f64
        };
        // The cap of 0.4 rad is 4 % of the sphere.
        assert!(near(0.4_f64.cos()) >= 0.12 * near(-1.0), "{} {}", near(0.4_f64.cos()), near(-1.0));
    }
}
