//! The rival of a series: the mesh with fewer vertices, by collapsing the edges that cost least
//! (Garland and Heckbert 1997: quadrics of the faces' planes, weighted by area; the vertex goes to
//! where the error is least). No collapse turns a face over or changes the topology.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::{DMat3, DVec3};

use crate::mesh::Mesh;
use crate::sh::outer;
use crate::{Result, memory};

/// How strongly a vertex is held at the middle of its edge where the planes leave it free, relative
/// to the weight of the planes.
const HELD: f64 = 1e-6;

/// The least cosine between the normals of a face before and after.
const LEAST_COSINE: f64 = 0.2;

/// Bytes for each face of the mesh while it is decimated: measured.
const BYTES_EACH: f64 = 300.0;

/// A mesh whose edges are collapsed, cheapest first.
pub(super) struct Decimation {
    /// The vertices, relative to the centre, metres.
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// The faces around each vertex; none around one that is gone.
    around: Vec<Vec<u32>>,
    quadrics: Vec<Quadric>,
    /// How often each vertex was moved: what was queued before does not count.
    moves: Vec<u32>,
    queue: BinaryHeap<Collapse>,
    centre: DVec3,
    star: bool,
    /// How many vertices faces use.
    left: usize,
}

/// An edge in the queue, the second vertex to become one with the first.
#[derive(Clone, Copy)]
struct Collapse {
    cost: f64,
    ends: [u32; 2],
    moves: [u32; 2],
}

impl Decimation {
    /// Begins with the whole mesh. With `star` all its faces see `centre` from outside, and go on
    /// to.
    ///
    /// # Errors
    /// [`crate::Error::Memory`] for more than is free.
    pub(super) fn new(mesh: &Mesh, centre: DVec3, star: bool) -> Result<Self> {
        let faces = mesh.triangles().len();
        memory::ask_each(faces, BYTES_EACH, "decimating a mesh", "take a coarser one")?;
        let positions: Vec<DVec3> = mesh.positions().iter().map(|p| *p - centre).collect();
        let mut quadrics = vec![Quadric::default(); positions.len()];
        let mut around = vec![Vec::new(); positions.len()];
        for (face, corners) in mesh.triangles().iter().enumerate() {
            let quadric = Quadric::of_face(corners.map(|v| positions[v as usize]));
            for v in corners {
                quadrics[*v as usize].add(&quadric);
                around[*v as usize].push(face as u32);
            }
        }
        let left = around.iter().filter(|faces| !faces.is_empty()).count();
        let mut decimation = Self {
            moves: vec![0; positions.len()],
            positions,
            triangles: mesh.triangles().to_vec(),
            around,
            quadrics,
            queue: BinaryHeap::new(),
            centre,
            star,
            left,
        };
        let sides =
            |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]].map(|[u, v]| [u.min(v), u.max(v)]);
        let mut edges: Vec<[u32; 2]> = mesh.triangles().iter().flat_map(sides).collect();
        edges.sort_unstable();
        edges.dedup();
        for [u, v] in edges {
            decimation.enqueue(u, v);
        }
        Ok(decimation)
    }

    /// Collapses edges until so many vertices are left or none can be collapsed, and returns the
    /// mesh that is left; the targets of calls descend.
    ///
    /// # Errors
    /// As [`Mesh::new`]; none is known.
    pub(super) fn down_to(&mut self, vertices: usize) -> Result<Mesh> {
        while self.left > vertices.max(4) {
            let Some(edge) = self.queue.pop() else { break };
            let [u, v] = edge.ends;
            if edge.moves != edge.ends.map(|v| self.moves[v as usize]) {
                continue;
            }
            let Some((quadric, place)) = self.place(edge.ends) else { continue };
            if quadric.at(place) > edge.cost {
                // Faces around it have changed, and the best place would turn one over.
                self.queue.push(Collapse { cost: quadric.at(place), ..edge });
                continue;
            }
            self.collapse(u, v, quadric, place);
        }
        self.mesh()
    }

    /// Returns the mesh that is left.
    fn mesh(&self) -> Result<Mesh> {
        let mut places = vec![u32::MAX; self.positions.len()];
        let mut positions = Vec::new();
        let mut place = |v: u32| {
            let place = &mut places[v as usize];
            if *place == u32::MAX {
                *place = positions.len() as u32;
                positions.push(self.centre + self.positions[v as usize]);
            }
            *place
        };
        let lives = |[a, b, _]: &&[u32; 3]| a != b;
        let triangles = self.triangles.iter().filter(lives).map(|t| t.map(&mut place)).collect();
        Mesh::new(positions, triangles)
    }

    fn enqueue(&mut self, u: u32, v: u32) {
        let ends = [u, v];
        if let Some((quadric, place)) = self.place(ends) {
            let moves = ends.map(|v| self.moves[v as usize]);
            self.queue.push(Collapse { cost: quadric.at(place), ends, moves });
        }
    }

    /// Finds where the vertex of a collapsed edge goes: the best place, else the middle or an end,
    /// that turns no face over.
    fn place(&self, ends: [u32; 2]) -> Option<(Quadric, DVec3)> {
        let [u, v] = ends.map(|v| v as usize);
        let mut quadric = self.quadrics[u];
        quadric.add(&self.quadrics[v]);
        let [a, b] = [self.positions[u], self.positions[v]];
        let middle = 0.5 * (a + b);
        let places = [quadric.lowest(middle), middle, a, b].into_iter();
        let fits = places.filter(|place| self.turns_none(ends, *place));
        let best = fits.min_by(|p, q| quadric.at(*p).total_cmp(&quadric.at(*q)))?;
        Some((quadric, best))
    }

    /// Whether all faces around an edge keep their side when its ends go to a place.
    fn turns_none(&self, ends: [u32; 2], place: DVec3) -> bool {
        ends.iter().flat_map(|end| &self.around[*end as usize]).all(|face| {
            let corners = self.triangles[*face as usize];
            let now = corners.map(|v| self.positions[v as usize]);
            let moved = corners.map(|v| ends.contains(&v));
            if moved.iter().filter(|moved| **moved).count() == 2 {
                // It vanishes.
                return true;
            }
            let then: [DVec3; 3] = std::array::from_fn(|i| if moved[i] { place } else { now[i] });
            let [before, after] = [now, then].map(area_vector);
            let sees = !self.star || after.dot(then[0]) > 0.0;
            sees && before.dot(after) > LEAST_COSINE * before.length() * after.length()
        })
    }

    /// Makes `v` one with `u`, unless that would join what does not touch.
    fn collapse(&mut self, u: u32, v: u32, quadric: Quadric, place: DVec3) {
        let [of_u, of_v] = [u, v].map(|end| self.neighbours(end));
        let shared = self.around[v as usize].iter().filter(|f| self.has(**f, u)).count();
        // The link condition: the ends share the corners opposite to their edge and no other.
        let is_pinched = of_u.iter().filter(|w| of_v.contains(w)).count() != shared;
        let all = self.around[u as usize].len() + self.around[v as usize].len();
        if is_pinched || shared > 2 || all == 2 * shared {
            return;
        }
        for face in std::mem::take(&mut self.around[v as usize]) {
            let corners = self.triangles[face as usize];
            if self.has(face, u) {
                for corner in corners.into_iter().filter(|corner| *corner != v) {
                    self.around[corner as usize].retain(|f| *f != face);
                    let is_left = corner == u || !self.around[corner as usize].is_empty();
                    self.left -= usize::from(!is_left);
                }
                self.triangles[face as usize] = [u32::MAX; 3];
            } else {
                self.triangles[face as usize] = corners.map(|w| if w == v { u } else { w });
                self.around[u as usize].push(face);
            }
        }
        (self.quadrics[u as usize], self.positions[u as usize]) = (quadric, place);
        self.moves[u as usize] += 1;
        self.moves[v as usize] += 1;
        self.left -= 1;
        for w in self.neighbours(u) {
            self.enqueue(u, w);
        }
    }

    fn has(&self, face: u32, vertex: u32) -> bool {
        self.triangles[face as usize].contains(&vertex)
    }

    /// Lists the other corners of the faces around a vertex.
    fn neighbours(&self, vertex: u32) -> Vec<u32> {
        let faces = self.around[vertex as usize].iter();
        let mut corners: Vec<u32> = faces.flat_map(|f| self.triangles[*f as usize]).collect();
        corners.sort_unstable();
        corners.dedup();
        corners.retain(|corner| *corner != vertex);
        corners
    }
}

impl Ord for Collapse {
    /// The cheapest is the greatest; among equals the one with the lowest vertices.
    fn cmp(&self, other: &Self) -> Ordering {
        other.cost.total_cmp(&self.cost).then_with(|| other.ends.cmp(&self.ends))
    }
}

impl PartialOrd for Collapse {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Collapse {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Collapse {}

fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    0.5 * (b - a).cross(c - a)
}

/// A sum of squared distances from planes: x' A x + 2 b' x + c.
#[derive(Clone, Copy)]
struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
}

impl Default for Quadric {
    fn default() -> Self {
        Self { a: DMat3::ZERO, b: DVec3::ZERO, c: 0.0 }
    }
}

impl Quadric {
    /// The squared distance from the plane of a face, times its area.
    fn of_face(corners: [DVec3; 3]) -> Self {
        let vector = area_vector(corners);
        let (area, normal) = (vector.length(), vector.normalize_or_zero());
        let distance = normal.dot(corners[0]);
        Self {
            a: area * outer(normal),
            b: -area * distance * normal,
            c: area * distance * distance,
        }
    }

    fn add(&mut self, other: &Self) {
        self.a += other.a;
        self.b += other.b;
        self.c += other.c;
    }

    fn at(&self, x: DVec3) -> f64 {
        x.dot(self.a * x) + 2.0 * self.b.dot(x) + self.c
    }

    /// Returns where it is least, near `middle` where the planes leave that open.
    fn lowest(&self, middle: DVec3) -> DVec3 {
        let weight = self.a.x_axis.x + self.a.y_axis.y + self.a.z_axis.z;
        let held = self.a + DMat3::from_diagonal(DVec3::splat(HELD * weight));
        let lowest = middle - held.inverse() * (self.a * middle + self.b);
        if lowest.is_finite() { lowest } else { middle }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{Resolution, tessellate};
    use crate::mesh::MeshReport;
    use crate::sh::Coefficients;

    #[test]
    fn a_ball_keeps_its_form_with_a_twentieth_of_its_vertices() -> Result<()> {
        let mut ball = Coefficients::zeros(0);
        ball.set(0, 0, 1.0, 0.0);
        let centre = DVec3::new(1.0, 2.0, 3.0);
        let fine = tessellate(&ball, centre, Resolution::Icosphere { frequency: 16 })?.mesh;
        let mut decimation = Decimation::new(&fine, centre, true)?;
        for target in [1000, 128, 4] {
            let left = decimation.down_to(target)?;
            assert_eq!(left.used_size(), [target, 2 * target - 4]);
            assert!(MeshReport::of(&left).is_closed());
            let radii = left.positions().iter().map(|p| (p.distance(centre) - 1.0).abs());
            let largest = radii.fold(0.0, f64::max);
            // Faces of an N-th of the ball bend away by 2 pi / sqrt 27 / N = 1.2 / N, to both
            // sides.
            assert!(target == 4 || largest <= 4.0 / target as f64, "{largest}");
        }
        Ok(())
    }

    #[test]
    fn an_open_mesh_and_one_with_three_faces_at_an_edge_stay_what_they_are() -> Result<()> {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_Y].to_vec();
        let book = Mesh::new(corners, vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]])?;
        let left = Decimation::new(&book, DVec3::ZERO, false)?.down_to(4)?;
        assert!(left.triangles().len() >= 2 && left.area() > 0.0);
        Ok(())
    }
}
