//! A mesh seen from a centre: one radius in every direction.
//!
//! Of a mesh that is star-shaped about the centre the radius is the mesh itself; of one that is not
//! it is an [`Envelope`], and each point of the mesh counts by how much it belongs to it.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use crate::Result;
use crate::fit::Envelope;
use crate::fit::envelope::{Layers, Seen};
use crate::fit::face_nodes::{
    DEEPEST, FINEST, Node, fold_faces, for_each_node, points_per_side, quarters, rules, span,
    visit_face,
};
use crate::fit::star::seen_solid_angle;
use crate::math::quadrature::Rule;
use crate::mesh::Mesh;

/// A face that belongs to the envelope in part is split until its sides span no more than this
/// angle, radians: the strip along the border of a fold, where quadrature is blind, becomes as
/// narrow.
const BORDER: f64 = 4e-3;

/// How often a face may be split for the border of a fold: enough for one that fills half the
/// sphere.
const BORDER_SPLITS: usize = 10;

/// Sees a mesh from a centre as a radius in every direction.
#[derive(Debug, Clone)]
pub struct RadialMesh<'a> {
    mesh: &'a Mesh,
    centre: DVec3,
    rules: Vec<Rule>,
    layers: Option<Layers>,
}

/// Describes how much of the sphere the folds of a mesh affect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Folds {
    /// Which radius was taken there.
    pub envelope: Envelope,
    /// The share, 0 to 1, of the directions that meet the mesh more than once.
    pub share: f64,
    /// By how much the solid angles of the nodes miss the whole sphere, over 4 pi: the error of the
    /// quadrature at the borders of folds.
    pub defect: f64,
}

/// Holds samples of the radius at the vertices of a mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RadialSamples {
    /// Unit vectors from the centre.
    pub directions: Vec<DVec3>,
    /// The radius in each direction, metres.
    pub radii: Vec<f64>,
    /// The solid angle each sample stands for.
    pub weights: Vec<f64>,
}

impl<'a> RadialMesh<'a> {
    /// Takes a mesh that is star-shaped about `centre`, see [`super::star`]; faces seen from behind
    /// count negatively.
    pub fn star(mesh: &'a Mesh, centre: DVec3) -> Self {
        Self { mesh, centre, rules: rules(), layers: None }
    }

    /// Takes an envelope of a closed mesh about a centre inside it.
    ///
    /// # Errors
    /// [`crate::Error::Geometry`] when the mesh does not surround the centre once.
    pub fn folded(mesh: &'a Mesh, centre: DVec3, envelope: Envelope) -> Result<Self> {
        let layers = Some(Layers::new(mesh, centre, envelope)?);
        Ok(Self { mesh, centre, rules: rules(), layers })
    }

    /// Returns the mesh.
    pub fn mesh(&self) -> &Mesh {
        self.mesh
    }

    /// Returns the centre, metres.
    pub fn centre(&self) -> DVec3 {
        self.centre
    }

    /// Returns the envelope; `None` for a mesh that was called star-shaped.
    pub(super) fn layers(&self) -> Option<&Layers> {
        self.layers.as_ref()
    }

    /// Visits the quadrature nodes of a face; `points` chooses how many along each side.
    pub(super) fn visit(
        &self,
        face: usize,
        points: &impl Fn(&[DVec3; 3]) -> usize,
        visit: &mut impl FnMut(Node),
    ) {
        let corners = self.mesh.corners(face).map(|x| x - self.centre);
        match &self.layers {
            None => visit_face(corners, points, &self.rules, DEEPEST, visit),
            Some(layers) => {
                let splits = [DEEPEST, BORDER_SPLITS];
                self.visit_seen(layers, corners, points, splits, &mut |node, _| visit(node));
            }
        }
    }

    /// Visits the nodes of a face that belong to the envelope, with their share of the solid angle,
    /// and whether their ray meets the mesh again.
    fn visit_seen(
        &self,
        layers: &Layers,
        corners: [DVec3; 3],
        points: &impl Fn(&[DVec3; 3]) -> usize,
        [for_size, for_border]: [usize; 2],
        visit: &mut impl FnMut(Node, bool),
    ) {
        let wanted = points(&corners);
        if wanted > FINEST && for_size > 0 {
            for quarter in quarters(corners) {
                self.visit_seen(layers, quarter, points, [for_size - 1, for_border], visit);
            }
            return;
        }
        let mut nodes: Vec<(Node, Seen)> = Vec::new();
        for_each_node(&corners, &self.rules[wanted.min(FINEST)], |node| {
            nodes.push((node, layers.see(node.direction, node.radius)));
        });
        let alike = nodes.windows(2).all(|pair| {
            let [a, b] = [pair[0].1, pair[1].1];
            (a.share, a.folded) == (b.share, b.folded)
        });
        if !alike && for_border > 0 && span(&corners) > BORDER {
            for quarter in quarters(corners) {
                self.visit_seen(layers, quarter, points, [for_size, for_border - 1], visit);
            }
            return;
        }
        for (node, seen) in nodes.iter().filter(|(_, seen)| seen.share > 0.0) {
            let counted = Node {
                radius: seen.radius,
                solid_angle: seen.share * node.solid_angle.abs(),
                area: seen.share * node.area,
                ..*node
            };
            visit(counted, seen.folded);
        }
    }

    /// Measures how much of the sphere folds affect; `None` for a mesh that was called star-shaped.
    pub fn folds(&self) -> Option<Folds> {
        let layers = self.layers.as_ref()?;
        let (mut folded, mut all) = (0.0, 0.0);
        // The borders of folds are followed by splitting faces, not by many points on each.
        let points = |corners: &[DVec3; 3]| points_per_side(corners, 0);
        let task = |range: std::ops::Range<usize>| {
            let (mut folded, mut all) = (0.0, 0.0);
            for face in range {
                let corners = self.mesh.corners(face).map(|x| x - self.centre);
                let splits = [DEEPEST, BORDER_SPLITS];
                self.visit_seen(layers, corners, &points, splits, &mut |node, again| {
                    all += node.solid_angle;
                    folded += if again { node.solid_angle } else { 0.0 };
                });
            }
            (folded, all)
        };
        fold_faces(self.mesh.triangles().len(), task, |part| {
            folded += part.0;
            all += part.1;
        });
        Some(Folds {
            envelope: layers.envelope(),
            share: folded / all,
            defect: (all / (4.0 * PI) - 1.0).abs(),
        })
    }

    /// Returns the direction of a vertex and the radius there; `None` for a vertex at the centre or
    /// (of an envelope) seen by no ray.
    pub(super) fn at_vertex(&self, vertex: DVec3) -> Option<(DVec3, f64)> {
        let from_centre = vertex - self.centre;
        let direction = from_centre.try_normalize()?;
        let radius = match &self.layers {
            None => from_centre.length(),
            Some(layers) => layers.radius(direction)?.0,
        };
        Some((direction, radius))
    }

    /// Samples the radius in the directions of the vertices; each stands for a third of the solid
    /// angle of the faces around it.
    pub fn vertex_samples(&self) -> RadialSamples {
        let mut weights = vec![0.0; self.mesh.positions().len()];
        for (face, triangle) in self.mesh.triangles().iter().enumerate() {
            let third = seen_solid_angle(self.mesh.corners(face), self.centre).abs() / 3.0;
            for &v in triangle {
                weights[v as usize] += third;
            }
        }
        let found: Vec<_> =
            self.mesh.positions().par_iter().map(|&vertex| self.at_vertex(vertex)).collect();
        let mut samples = RadialSamples::default();
        for (sample, weight) in found.into_iter().zip(weights) {
            if let Some((direction, radius)) = sample.filter(|_| weight > 0.0) {
                samples.directions.push(direction);
                samples.radii.push(radius);
                samples.weights.push(weight);
            }
        }
        samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn a_convex_mesh_has_no_folds_and_loses_no_solid_angle() {
        let cube = shapes::cube();
        let middle = DVec3::new(0.4, 0.5, 0.6);
        let folds = RadialMesh::folded(&cube, middle, Envelope::First).expect("inside").folds();
        let Folds { share, defect, .. } = folds.expect("an envelope");
        assert!(share == 0.0 && defect <= 1e-9, "{share} {defect}");
        assert_eq!(RadialMesh::star(&cube, middle).folds(), None);
    }

    #[test]
    fn folded_share_of_a_u_is_the_solid_angle_behind_its_inner_walls() {
        // From the middle of the bottom bar each arm's inner wall is wholly seen through the inner
        // floor: a rectangle 0.5 away that reaches from 0.5 to 2.5 along one axis and from -0.5 to
        // 0.5 along the other.
        let quadrant =
            |a: f64, b: f64, d: f64| (a * b / (d * (a * a + b * b + d * d).sqrt())).atan();
        let wall = 2.0 * (quadrant(2.5, 0.5, 0.5) - quadrant(0.5, 0.5, 0.5));
        let expected = 2.0 * wall / (4.0 * PI);
        let u = shapes::u_shape();
        let at = DVec3::new(1.5, 0.5, 0.5);
        for envelope in [Envelope::Outermost, Envelope::First, Envelope::Mean] {
            let folds = RadialMesh::folded(&u, at, envelope).expect("inside").folds();
            let Folds { share, defect, .. } = folds.expect("an envelope");
            // Borders of some 20 radians in strips of 1e-3 err by 1e-3, less where nodes fall on
            // either side.
            let tolerance = 2e-4;
            assert!(
                (share - expected).abs() <= tolerance && defect <= tolerance,
                "{envelope}: {share} {defect}"
            );
        }
    }

    #[test]
    fn vertex_weights_fill_the_sphere() {
        let sphere = shapes::sphere(3);
        let samples = RadialMesh::star(&sphere, DVec3::new(0.1, 0.2, -0.1)).vertex_samples();
        let all: f64 = samples.weights.iter().sum();
        assert!((all - 4.0 * PI).abs() <= 1e-12 && samples.radii.len() == 258);
    }
}
