//! What is wrong with a mesh, in numbers and in sentences; what to do about it is the reader's to
//! decide, nothing is repaired.
//!
//! Most is read off the edges (`mesh_edges`): an edge of a closed, oriented surface is walked
//! exactly once each way. Time is linear in the size of the mesh; beside the mesh there is never
//! more than another two thirds of its memory.

use crate::error::Advice;
use crate::mesh::Mesh;
use crate::mesh::boundary::{BoundaryLoop, for_each_loop};
use crate::mesh::edges::{BadEdge, EdgeFault, for_each_edge, for_each_group};
use crate::mesh::triangle::is_collapsed;
use crate::{Error, Result};

/// Lists the deficiencies of a mesh and its topology.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshReport {
    /// How many vertices faces use.
    pub vertices: usize,
    /// How many vertices no face uses.
    pub unused_vertices: usize,
    /// How many edges there are, each counted once.
    pub edges: usize,
    /// How many faces there are.
    pub faces: usize,
    /// The vertices, used or not, with a coordinate that is NaN or infinite.
    pub non_finite: Vec<u32>,
    /// The faces without area: corners that coincide or lie in a line, to rounding.
    pub degenerate: Vec<u32>,
    /// How many of those name a vertex twice; they have no place in the topology.
    pub collapsed: usize,
    /// The faces that repeat the three vertices of an earlier one, in whatever order.
    pub duplicate: Vec<u32>,
    /// How many edges have one face only.
    pub boundary: usize,
    /// How many loops the boundary forms; chains that do not close, which need an edge of three
    /// faces, count too.
    pub boundary_loops: usize,
    /// The longest of them.
    pub longest_loop: Option<BoundaryLoop>,
    /// How many edges have three faces or more.
    pub non_manifold: usize,
    /// The vertices where faces meet in several fans that no edge of two faces joins.
    pub pinched: Vec<u32>,
    /// How many edges have two faces that disagree about the outside.
    pub inconsistent: usize,
    /// The first few edges of these three kinds, in this order of kinds.
    pub examples: Vec<BadEdge>,
    /// How many pieces the faces fall into; pieces that share a vertex are one.
    pub components: usize,
    /// The enclosed volume, m3, negative when inside out; means something for closed meshes only.
    pub volume: f64,
}

/// How many edges of a kind, faces and vertices a report shows.
const SHOWN: usize = 3;

impl MeshReport {
    /// Examines a mesh.
    pub fn of(mesh: &Mesh) -> Self {
        let edges = Edges::of(mesh);
        let (vertices, components) = count_components(mesh);
        let numbers = |n: usize, wanted: &dyn Fn(usize) -> bool| {
            (0..n).filter(|&i| wanted(i)).map(|i| i as u32).collect::<Vec<_>>()
        };
        let faces = mesh.triangles().len();
        Self {
            vertices,
            unused_vertices: mesh.positions().len() - vertices,
            edges: edges.count,
            faces,
            non_finite: numbers(mesh.positions().len(), &|v| !mesh.positions()[v].is_finite()),
            // The area of a face with a vertex that is not finite is NaN: that face is not called
            // degenerate too.
            degenerate: numbers(faces, &|f| is_degenerate(mesh, f)),
            collapsed: mesh.triangles().iter().filter(|t| is_collapsed(t)).count(),
            duplicate: duplicate_faces(mesh),
            boundary: edges.faults[0],
            boundary_loops: edges.loops,
            longest_loop: edges.longest,
            pinched: pinched_vertices(mesh),
            non_manifold: edges.faults[1],
            inconsistent: edges.faults[2],
            examples: edges.examples.into_iter().flatten().collect(),
            components,
            volume: mesh.volume(),
        }
    }

    /// Returns V - E + F: 2 for every closed piece without a hole through it.
    pub fn euler(&self) -> i64 {
        // Indices are 32 bits wide: no count comes near the limits of i64.
        let [v, e, f] = [self.vertices, self.edges, self.faces - self.collapsed]
            .map(|n| i64::try_from(n).unwrap_or(i64::MAX));
        v - e + f
    }

    /// Whether every edge has exactly two faces that agree about the outside, and there is a face
    /// at all.
    pub fn is_closed(&self) -> bool {
        self.faces > 0 && self.boundary + self.non_manifold + self.inconsistent == 0
    }

    /// Whether no edge has more than two faces and the faces around each vertex form one fan.
    pub fn is_manifold(&self) -> bool {
        self.non_manifold == 0 && self.pinched.is_empty()
    }

    /// Whether no two faces at an edge disagree about the outside.
    pub fn is_oriented(&self) -> bool {
        self.inconsistent == 0
    }

    /// Returns the number of handles of all pieces together, of a closed manifold mesh.
    pub fn genus(&self) -> Option<i64> {
        let pieces = i64::try_from(self.components).unwrap_or(i64::MAX);
        (self.is_closed() && self.is_manifold()).then(|| pieces - self.euler() / 2)
    }

    /// Whether the faces look inwards.
    pub fn is_inside_out(&self) -> bool {
        self.is_closed() && self.volume < 0.0
    }

    /// Returns one sentence for each deficiency: what, how many, where, how to go on. None for a
    /// clean mesh.
    pub fn deficiencies(&self) -> Vec<String> {
        let mut all = self.surface_faults();
        all.extend(self.face_faults());
        all
    }

    /// Asks for a closed, consistently oriented mesh with finite vertices whose faces look
    /// outwards.
    ///
    /// # Errors
    /// [`Error::Geometry`] with the sentences about whatever is missing, and what a repair can do
    /// about it.
    pub fn require_closed(&self) -> Result<()> {
        let faults = self.surface_faults();
        if faults.is_empty() {
            return Ok(());
        }
        let sentence = format!("the mesh does not enclose a volume: {}", faults.join("; "));
        let error = Error::Geometry(sentence);
        Err(match self.advice() {
            Some(advice) => error.advise(advice),
            None => error,
        })
    }

    /// Returns the repair that may make the mesh enclose a volume, where one may.
    pub fn advice(&self) -> Option<Advice> {
        let is_mended = self.boundary + self.non_manifold + self.inconsistent > 0;
        let rim = self.longest_loop.as_ref().map(|rim| rim.edges);
        (is_mended || self.is_inside_out()).then_some(Advice::Repair(rim))
    }

    /// Returns the deficiencies that keep a mesh from enclosing a volume.
    fn surface_faults(&self) -> Vec<String> {
        let mut all = Vec::new();
        if self.faces == 0 {
            all.push("it has no faces; check that the file holds triangles or polygons".to_owned());
        }
        if !self.non_finite.is_empty() {
            all.push(format!(
                "{} a coordinate that is not finite ({}); mend or remove",
                plural(self.non_finite.len(), "vertex has", "vertices have"),
                listed("vertex", &self.non_finite)
            ));
        }
        let edges = [
            (
                self.boundary,
                EdgeFault::Boundary,
                "one face only",
                "fill the holes, or merge vertices that coincide",
            ),
            (
                self.non_manifold,
                EdgeFault::NonManifold,
                "three faces or more",
                "remove inner walls and doubled faces",
            ),
            (
                self.inconsistent,
                EdgeFault::Inconsistent,
                "two faces that disagree about the outside",
                "let all faces be counter-clockwise seen from outside",
            ),
        ];
        for (count, kind, has, remedy) in edges {
            if count > 0 {
                let verb = plural(count, "edge has", "edges have");
                all.push(format!("{verb} {has} ({}); {remedy}", self.shown_edges(kind)));
            }
        }
        if self.is_inside_out() {
            all.push(format!(
                "its faces look inwards (signed volume {:.6e} m3); reverse the order of the \
                 vertices in every face",
                self.volume
            ));
        }
        all
    }

    /// Returns the deficiencies of single faces, which do no harm to the volume.
    fn face_faults(&self) -> Vec<String> {
        let mut all = Vec::new();
        if !self.degenerate.is_empty() {
            all.push(format!(
                "{} no area ({}); they can be removed if the holes they leave are closed",
                plural(self.degenerate.len(), "face has", "faces have"),
                listed("face", &self.degenerate)
            ));
        }
        if !self.pinched.is_empty() {
            all.push(format!(
                "{} faces in several fans that no edge joins ({}); divide the vertex among them",
                plural(self.pinched.len(), "vertex has", "vertices have"),
                listed("vertex", &self.pinched)
            ));
        }
        if !self.duplicate.is_empty() {
            all.push(format!(
                "{} the vertices of an earlier one ({}); remove one of each pair",
                plural(self.duplicate.len(), "face repeats", "faces repeat"),
                listed("face", &self.duplicate)
            ));
        }
        all
    }

    fn shown_edges(&self, kind: EdgeFault) -> String {
        let shown: Vec<_> =
            self.examples.iter().filter(|e| e.kind == kind).map(BadEdge::to_string).collect();
        format!("the first: {}", shown.join(", "))
    }
}

/// Counts what the edges tell.
#[derive(Default)]
struct Edges {
    count: usize,
    /// By kind, in the order of [`EdgeFault`].
    faults: [usize; 3],
    examples: [Vec<BadEdge>; 3],
    loops: usize,
    longest: Option<BoundaryLoop>,
}

impl Edges {
    fn of(mesh: &Mesh) -> Self {
        let mut all = Self::default();
        let mut boundary = Vec::new();
        for_each_edge(mesh, |walks| {
            all.count += 1;
            let Some(kind) = EdgeFault::of(walks) else { return };
            let place = kind as usize;
            all.faults[place] += 1;
            if kind == EdgeFault::Boundary {
                boundary.push(walks[0].direction());
            }
            if all.examples[place].len() < SHOWN {
                all.examples[place].push(BadEdge::new(mesh, kind, &walks[0]));
            }
        });
        for_each_loop(&boundary, |edges| {
            all.loops += 1;
            let found = BoundaryLoop::new(mesh, edges);
            if all.longest.as_ref().is_none_or(|longest| found.length > longest.length) {
                all.longest = Some(found);
            }
        });
        all
    }
}

/// Whether the sine of an angle between two edges is zero to the rounding of their cross product.
pub(super) fn is_degenerate(mesh: &Mesh, face: usize) -> bool {
    let [a, b, c] = mesh.corners(face);
    let (ab, ac) = (b - a, c - a);
    ab.cross(ac).length() <= 8.0 * f64::EPSILON * ab.length() * ac.length()
}

/// Finds the faces whose three vertices an earlier face has, in ascending order.
pub(crate) fn duplicate_faces(mesh: &Mesh) -> Vec<u32> {
    let sorted = || {
        let faces = mesh.triangles().iter().enumerate().filter(|(_, t)| !is_collapsed(t));
        faces.map(|(face, &triangle)| {
            let mut key = triangle;
            key.sort_unstable();
            (key[0], (key[1], key[2], face as u32))
        })
    };
    let mut repeated = Vec::new();
    for_each_group(mesh.positions().len(), sorted, |_, faces| {
        for same in faces.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            repeated.extend(same[1..].iter().map(|&(_, _, face)| face));
        }
    });
    repeated.sort_unstable();
    repeated
}

/// Finds the vertices where faces meet in more than one fan, joined by the vertex alone: a cone on
/// the tip of another.
///
/// Corners of faces that share an edge of two faces are joined (union-find); what is left at a
/// vertex are its fans.
fn pinched_vertices(mesh: &Mesh) -> Vec<u32> {
    // More corners than 32 bits can number are not looked at: half a terabyte of mesh.
    let Ok(corners) = u32::try_from(3 * mesh.triangles().len()) else { return Vec::new() };
    let mut parent: Vec<u32> = (0..corners).collect();
    for_each_edge(mesh, |walks| {
        let [one, other] = walks else { return };
        for (a, b) in
            [(one.low_corner(), other.low_corner()), (one.high_corner(), other.high_corner())]
        {
            let (a, b) = (find(&mut parent, a), find(&mut parent, b));
            parent[a.max(b) as usize] = a.min(b);
        }
    });
    let mut fans = vec![0_u8; mesh.positions().len()];
    for (face, triangle) in mesh.triangles().iter().enumerate().filter(|(_, t)| !is_collapsed(t)) {
        for (corner, &v) in (3 * face..).zip(triangle) {
            if parent[corner] as usize == corner {
                fans[v as usize] = fans[v as usize].saturating_add(1);
            }
        }
    }
    // An edge of three faces parts their fans as well, but is a fault of its own.
    (0..fans.len() as u32).filter(|&v| fans[v as usize] > 1).collect()
}

/// Counts the vertices in use and the pieces they form (union-find with path halving).
fn count_components(mesh: &Mesh) -> (usize, usize) {
    let mut parent: Vec<u32> = (0..mesh.positions().len() as u32).collect();
    let mut used = vec![false; parent.len()];
    for &[a, b, c] in mesh.triangles() {
        for v in [a, b, c] {
            used[v as usize] = true;
        }
        let root = find(&mut parent, a);
        for other in [b, c] {
            let other = find(&mut parent, other);
            parent[other as usize] = root;
        }
    }
    let vertices = used.iter().filter(|&&u| u).count();
    let roots = (0..parent.len()).filter(|&v| used[v] && parent[v] as usize == v).count();
    (vertices, roots)
}

pub(crate) fn find(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        let up = parent[parent[v as usize] as usize];
        parent[v as usize] = up;
        v = up;
    }
    v
}

/// Writes a count with the form of the verb that fits.
fn plural(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// Names the first few numbers of a list.
fn listed(noun: &str, numbers: &[u32]) -> String {
    let shown: Vec<_> = numbers.iter().take(SHOWN).map(u32::to_string).collect();
    let dots = if numbers.len() > SHOWN { ", ..." } else { "" };
    format!("number, from 0, of the {noun}: {}{dots}", shown.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use glam::DVec3;

    /// Makes a mesh from another's parts, changed.
    fn changed(mesh: &Mesh, change: impl Fn(&mut Vec<DVec3>, &mut Vec<[u32; 3]>)) -> MeshReport {
        let (mut positions, mut triangles) = (mesh.positions().to_vec(), mesh.triangles().to_vec());
        change(&mut positions, &mut triangles);
        MeshReport::of(&Mesh::new(positions, triangles).expect("indices in range"))
    }

    #[test]
    fn empty_mesh_encloses_nothing() {
        let report = MeshReport::of(&Mesh::default());
        assert_eq!((report.edges, report.components, report.euler()), (0, 0, 0));
        assert!(report.require_closed().unwrap_err().to_string().contains("no faces"));
    }

    #[test]
    fn clean_meshes_have_no_deficiency() {
        for mesh in [shapes::cube(), shapes::sphere(3), shapes::l_shape(), shapes::u_shape()] {
            let report = MeshReport::of(&mesh);
            assert!(report.is_closed() && report.require_closed().is_ok());
            assert_eq!(report.deficiencies(), [""; 0]);
            assert_eq!((report.components, report.euler(), report.unused_vertices), (1, 2, 0));
        }
    }

    #[test]
    fn open_mesh_names_its_boundary() {
        let report = changed(&shapes::cube(), |_, triangles| {
            triangles.remove(0);
        });
        assert_eq!((report.boundary, report.examples.len(), report.euler()), (3, 3, 1));
        assert_eq!(report.advice(), Some(Advice::Repair(Some(3))));
        let message = report.require_closed().unwrap_err().to_string();
        assert!(message.contains("3 edges have one face only"), "{message}");
        assert!(message.contains("vertices 0-4 at [0.000000, 0.000000, 0.000000] to"), "{message}");
    }

    #[test]
    fn third_face_on_an_edge_is_non_manifold() {
        let report = changed(&shapes::cube(), |positions, triangles| {
            positions.push(DVec3::splat(-1.0));
            triangles.push([0, 1, 8]);
        });
        assert_eq!((report.non_manifold, report.boundary), (1, 2));
        assert!(report.require_closed().is_err());
    }

    #[test]
    fn one_flipped_face_is_inconsistent_and_all_are_inside_out() {
        let report = changed(&shapes::cube(), |_, triangles| triangles[5].swap(0, 1));
        assert_eq!((report.inconsistent, report.boundary, report.non_manifold), (3, 0, 0));
        assert!(!report.is_closed());
        assert_eq!(report.advice(), Some(Advice::Repair(None)));
        let report = MeshReport::of(&shapes::cube().flipped());
        assert_eq!(report.advice(), Some(Advice::Repair(None)));
        assert!(report.is_closed() && report.is_inside_out());
        assert!(report.require_closed().unwrap_err().to_string().contains("look inwards"));
    }

    #[test]
    fn degenerate_and_duplicate_faces_are_listed() {
        let report = changed(&shapes::cube(), |positions, triangles| {
            positions.push(DVec3::new(0.3, 0.3, 0.0));
            triangles.push([4, 0, 6]);
            triangles.push([1, 1, 2]);
            triangles.push([0, 3, 8]);
        });
        assert_eq!(
            (report.duplicate, report.degenerate, report.collapsed),
            (vec![12], vec![13, 14], 1)
        );
        let report = changed(&shapes::cube(), |_, triangles| triangles.push([1, 1, 2]));
        assert!(report.is_closed());
        assert_eq!((report.euler(), report.deficiencies().len()), (2, 1));
    }

    #[test]
    fn vertices_that_are_not_finite_or_unused_are_counted() {
        let report = changed(&shapes::cube(), |positions, _| {
            positions[3].y = f64::NAN;
            positions.push(DVec3::ONE);
            positions.push(DVec3::INFINITY);
        });
        assert_eq!((report.non_finite.clone(), report.unused_vertices), (vec![3, 9], 2));
        assert!(report.degenerate.is_empty());
        let message = report.require_closed().unwrap_err().to_string();
        assert!(message.contains("2 vertices have a coordinate that is not finite"), "{message}");
    }

    #[test]
    fn boundary_falls_into_loops() {
        // Two holes: both triangles of the upper side, and one of the lower.
        let report = changed(&shapes::cube(), |_, triangles| {
            triangles.drain(10..);
            triangles.remove(8);
        });
        assert_eq!((report.boundary, report.boundary_loops, report.genus()), (7, 2, None));
        let longest = report.longest_loop.expect("two loops");
        assert_eq!((longest.edges, longest.length), (4, 4.0));
        assert_eq!(longest.middle, DVec3::new(0.5, 0.5, 1.0));
    }

    #[test]
    fn cones_that_meet_at_their_tips_are_pinched() {
        let report = changed(&shapes::cube(), |positions, triangles| {
            // A second cube that shares the corner (1, 1, 1), number 7, with the first.
            positions.extend(shapes::cube().positions()[1..].iter().map(|&p| p + 1.0));
            let shifted = |v: u32| if v == 0 { 7 } else { v + 7 };
            triangles.extend(shapes::cube().triangles().iter().map(|t| t.map(shifted)));
        });
        assert_eq!((report.pinched.clone(), report.components), (vec![7], 1));
        assert!(report.is_closed() && !report.is_manifold() && report.genus().is_none());
        assert!(report.deficiencies()[0].starts_with("1 vertex has faces in several fans"));
    }

    #[test]
    fn genus_counts_the_handles() {
        assert_eq!(MeshReport::of(&shapes::cube()).genus(), Some(0));
        assert_eq!(MeshReport::of(&shapes::torus(8, 5)).genus(), Some(1));
    }

    #[test]
    fn pieces_are_counted() {
        let report = changed(&shapes::cube(), |positions, triangles| {
            positions.extend(shapes::cube().positions().iter().map(|&p| p + 5.0));
            triangles.extend(shapes::cube().triangles().iter().map(|t| t.map(|v| v + 8)));
        });
        assert_eq!((report.components, report.euler()), (2, 4));
        assert!(report.is_closed());
    }
}
