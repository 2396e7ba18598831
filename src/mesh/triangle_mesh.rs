//! A triangle mesh as plain indexed data: positions and triangles, nothing derived, nothing
//! repaired.
//!
//! Whether it is closed, oriented and star-shaped is asked in `mesh_check` and `star`; rays meet it
//! in `mesh_surface`.

use glam::DVec3;

use crate::math::choice::choice;
use crate::math::{Aabb, require_measurable};
use crate::{Error, Result};

/// Holds vertices and the triangles that join them; counter-clockwise seen from outside where the
/// mesh is oriented.
///
/// Every index is in range; coordinates may be anything a file can say, even not finite (see
/// [`super::MeshReport`]).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

/// Names the axis that points up in a file; inside, up is always z.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum UpAxis {
    /// x is up.
    X,
    /// y is up, as in most modelling programs.
    Y,
    /// z is up: nothing to turn.
    #[default]
    Z,
}

choice!(UpAxis, "axis":
    X = "x" "",
    Y = "y" "",
    Z = "z" "",
);

impl UpAxis {
    /// Turns a vector so that this axis becomes +z; a rotation, so that outside stays outside.
    pub fn to_z(self, v: DVec3) -> DVec3 {
        match self {
            Self::X => DVec3::new(v.y, v.z, v.x),
            Self::Y => DVec3::new(v.x, -v.z, v.y),
            Self::Z => v,
        }
    }
}

impl Mesh {
    /// Joins positions, metres, by triangles of indices into them (from 0).
    ///
    /// # Errors
    /// [`Error::Geometry`] when a triangle names a vertex that is not there.
    ///
    /// ```
    /// use glam::DVec3;
    /// use harmolux::mesh::Mesh;
    /// let mesh = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]])?;
    /// assert_eq!(mesh.area(), 0.5);
    /// assert!(Mesh::new(vec![DVec3::ZERO], vec![[0, 1, 2]]).is_err());
    /// # Ok::<(), harmolux::Error>(())
    /// ```
    pub fn new(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Self> {
        let count = positions.len();
        let stray = |&v: &u32| v as usize >= count;
        if let Some(face) = triangles.iter().position(|t| t.iter().any(stray)) {
            let vertex = triangles[face].iter().copied().find(stray).unwrap_or(0);
            return Err(Error::Geometry(format!(
                "face {face} names vertex {vertex}, but the mesh has {count} vertices (numbered \
                 from 0); give every face three numbers below {count}"
            )));
        }
        Ok(Self { positions, triangles })
    }

    /// Returns the vertices, metres.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Returns the triangles: three indices into the positions each.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Returns the number of vertices that faces use, and the number of faces: what it takes to
    /// store the mesh.
    pub fn used_size(&self) -> [usize; 2] {
        [self.used_positions().len(), self.triangles.len()]
    }

    /// Returns the vertices that faces use, in their order, metres.
    pub fn used_positions(&self) -> Vec<DVec3> {
        let mut is_used = vec![false; self.positions.len()];
        for &vertex in self.triangles.iter().flatten() {
            is_used[vertex as usize] = true;
        }
        self.positions.iter().zip(is_used).filter(|(_, used)| *used).map(|(p, _)| *p).collect()
    }

    /// Returns the three corners of a face.
    ///
    /// # Panics
    /// When there is no such face: a programmer's error. The same holds for the other questions
    /// about one face.
    pub fn corners(&self, face: usize) -> [DVec3; 3] {
        self.triangles[face].map(|v| self.positions[v as usize])
    }

    /// Returns the vector along the outward normal whose length is the area of the face, m2.
    pub fn area_vector(&self, face: usize) -> DVec3 {
        let [a, b, c] = self.corners(face);
        0.5 * (b - a).cross(c - a)
    }

    /// Returns the outward unit normal of a face; `None` when it has no area.
    pub fn normal(&self, face: usize) -> Option<DVec3> {
        self.area_vector(face).try_normalize()
    }

    /// Returns the middle of a face.
    pub fn middle(&self, face: usize) -> DVec3 {
        self.corners(face).into_iter().sum::<DVec3>() / 3.0
    }

    /// Returns the area of all faces, m2.
    pub fn area(&self) -> f64 {
        (0..self.triangles.len()).map(|f| self.area_vector(f).length()).sum()
    }

    /// Returns the enclosed volume, m3, negative when the faces look inwards; of a closed mesh
    /// only.
    ///
    /// Sums the signed tetrahedra over the middle of the bounds, so that a mesh far from the origin
    /// loses no digits.
    pub fn volume(&self) -> f64 {
        let middle = self.bounds().centre();
        let six_fold = |face| {
            let [a, b, c] = self.corners(face).map(|p| p - middle);
            a.dot(b.cross(c))
        };
        (0..self.triangles.len()).map(six_fold).sum::<f64>() / 6.0
    }

    /// Returns the centroid of the cones from `apex` over the faces, metres: of the enclosed volume
    /// where the mesh is closed, whatever the apex.
    pub fn centroid(&self, apex: DVec3) -> DVec3 {
        let (mut volume, mut moment) = (0.0, DVec3::ZERO);
        for face in 0..self.triangles.len() {
            let [a, b, c] = self.corners(face).map(|p| p - apex);
            let cone = a.dot(b.cross(c));
            volume += cone;
            moment += cone * (a + b + c) / 4.0;
        }
        apex + moment / volume
    }

    /// Bounds the vertices that faces use; empty without faces.
    pub fn bounds(&self) -> Aabb {
        let used = self.triangles.iter().flatten();
        Aabb::of_points(used.map(|&v| self.positions[v as usize]))
    }

    /// Asks for a size whose areas and volumes can be computed. Vertices that are not finite are
    /// for others to judge.
    ///
    /// # Errors
    /// [`Error::Geometry`] when it is below 1e-60 or above 1e60 m.
    pub fn require_measurable(&self) -> Result<()> {
        let Aabb { min, max } = self.bounds();
        if !(min.is_finite() && max.is_finite()) {
            return Ok(());
        }
        let (size, reach) = ((max - min).max_element(), min.abs().max(max.abs()).max_element());
        require_measurable("the size of the mesh", size)?;
        require_measurable("its distance from the origin", reach)
    }

    /// Makes a copy `factor` times as large: 0.001 for a file in millimetres.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless `factor` is finite and positive (a negative one would turn the
    /// mesh inside out).
    pub fn scaled(&self, factor: f64) -> Result<Self> {
        if !(factor.is_finite() && factor > 0.0) {
            return Err(Error::Parameter(format!(
                "a mesh can be scaled by a finite factor above 0 only, found {factor}"
            )));
        }
        Ok(self.mapped(|p| factor * p))
    }

    /// Makes a copy turned so that `up` becomes +z.
    pub fn with_up(&self, up: UpAxis) -> Self {
        self.mapped(|p| up.to_z(p))
    }

    /// Makes a copy moved by `offset`, metres.
    pub fn translated(&self, offset: DVec3) -> Self {
        self.mapped(|p| p + offset)
    }

    /// Makes a copy whose faces look to the other side.
    pub fn flipped(&self) -> Self {
        let triangles = self.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        Self { positions: self.positions.clone(), triangles }
    }

    /// Makes a copy with every vertex moved by an orientation-keeping map.
    fn mapped(&self, map: impl Fn(DVec3) -> DVec3) -> Self {
        let positions = self.positions.iter().map(|&p| map(p)).collect();
        Self { positions, triangles: self.triangles.clone() }
    }
}

/// Shapes the tests of several files share.
#[cfg(test)]
pub(crate) mod shapes {
    use super::*;
    use std::collections::HashMap;

    /// Encloses the unit cube [0, 1]^3 by 12 outward triangles.
    pub(crate) fn cube() -> Mesh {
        let corner =
            |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
        let quads =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Mesh::new((0..8).map(corner).collect(), triangles).expect("indices in range")
    }

    /// Encloses the prism over a counter-clockwise polygon in the plane z = 0, triangulated as
    /// told, up to z = 1.
    pub(crate) fn prism(outline: &[[f64; 2]], cap: &[[u32; 3]]) -> Mesh {
        let n = outline.len() as u32;
        let at = |z| outline.iter().map(move |&[x, y]| DVec3::new(x, y, z));
        let positions = at(0.0).chain(at(1.0)).collect();
        let top = cap.iter().map(|t| t.map(|v| v + n));
        let bottom = cap.iter().map(|&[a, b, c]| [a, c, b]);
        let sides = (0..n).flat_map(|i| {
            let j = (i + 1) % n;
            [[i, j, j + n], [i, j + n, i + n]]
        });
        Mesh::new(positions, top.chain(bottom).chain(sides).collect()).expect("indices in range")
    }

    /// Encloses an L: star-shaped about points near its inner corner only.
    pub(crate) fn l_shape() -> Mesh {
        let outline = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        prism(&outline, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]])
    }

    /// Encloses a U: star-shaped about no point.
    pub(crate) fn u_shape() -> Mesh {
        let outline = [
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [2.0, 3.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [0.0, 3.0],
        ];
        let cap = [[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4], [0, 5, 6], [0, 6, 7]];
        prism(&outline, &cap)
    }

    /// Approximates a torus of radii 2 and 1 by `n` times `m` quadrilaterals, each cut in two.
    pub(crate) fn torus(n: u32, m: u32) -> Mesh {
        let angle = |i: u32, of: u32| std::f64::consts::TAU * f64::from(i) / f64::from(of);
        let point = |i: u32| {
            let (u, v) = (angle(i / m, n), angle(i % m, m));
            DVec3::new((2.0 + v.cos()) * u.cos(), (2.0 + v.cos()) * u.sin(), v.sin())
        };
        let triangles = (0..n * m).flat_map(|i| {
            let at = |du: u32, dv: u32| (i / m + du) % n * m + (i % m + dv) % m;
            [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]]
        });
        Mesh::new((0..n * m).map(point).collect(), triangles.collect()).expect("indices in range")
    }

    /// Approximates the unit sphere: an octahedron whose faces are split in four `levels` times.
    pub(crate) fn sphere(levels: u32) -> Mesh {
        let mut positions =
            vec![DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        let mut triangles: Vec<[u32; 3]> = vec![
            [0, 2, 4],
            [2, 1, 4],
            [1, 3, 4],
            [3, 0, 4],
            [2, 0, 5],
            [1, 2, 5],
            [3, 1, 5],
            [0, 3, 5],
        ];
        for _ in 0..levels {
            let mut middles = HashMap::new();
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let p = (positions[a as usize] + positions[b as usize]).normalize();
                    positions.push(p);
                    positions.len() as u32 - 1
                })
            };
            triangles = triangles
                .into_iter()
                .flat_map(|[a, b, c]| {
                    let (d, e, f) = (middle(a, b), middle(b, c), middle(c, a));
                    [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
                })
                .collect();
        }
        Mesh::new(positions, triangles).expect("indices in range")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_mesh_has_nothing() {
        let mesh = Mesh::default();
        assert!(mesh.bounds().is_empty());
        assert_eq!((mesh.area(), mesh.volume()), (0.0, 0.0));
    }

    #[test]
    fn vertices_that_no_face_uses_take_no_part() {
        let cube = shapes::cube();
        let far = [cube.positions(), &[DVec3::splat(1e9)]].concat();
        let with_one_more = Mesh::new(far, cube.triangles().to_vec()).expect("valid");
        for mesh in [&cube, &with_one_more] {
            assert_eq!(mesh.used_size(), [8, 12]);
            assert_eq!(mesh.used_positions(), cube.positions());
            assert_eq!(mesh.bounds(), cube.bounds());
        }
    }

    #[test]
    fn stray_index_is_named() {
        let error = Mesh::new(vec![DVec3::ZERO; 3], vec![[0, 1, 2], [0, 7, 1]]).unwrap_err();
        assert!(error.to_string().starts_with("face 1 names vertex 7, but the mesh has 3"));
    }

    #[test]
    fn cube_has_its_area_volume_and_normals() {
        let cube = shapes::cube();
        assert_eq!((cube.area(), cube.volume()), (6.0, 1.0));
        assert_eq!(cube.flipped().volume(), -1.0);
        let middle = DVec3::splat(0.5);
        for face in 0..12 {
            let n = cube.normal(face).expect("no face is degenerate");
            assert_eq!(n.dot(cube.middle(face) - middle), 0.5);
        }
    }

    #[test]
    fn volume_keeps_its_digits_far_from_the_origin() {
        // The vertices themselves are rounded to 1e6 * 1.1e-16 there.
        let far = shapes::cube().scaled(0.1).expect("positive").translated(DVec3::splat(1e6));
        assert!((far.volume() - 1e-3).abs() <= 1e-11);
    }

    #[test]
    fn copies_are_moved_and_stay_outward() {
        let cube = shapes::cube();
        for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
            assert_eq!(cube.with_up(up).volume(), 1.0);
        }
        assert_eq!(UpAxis::X.to_z(DVec3::X), DVec3::Z);
        assert_eq!(UpAxis::Y.to_z(DVec3::Y), DVec3::Z);
        let moved = cube.scaled(2.0).expect("positive").translated(DVec3::X).bounds();
        assert_eq!(moved, Aabb::new(DVec3::X, DVec3::new(3.0, 2.0, 2.0)));
        for factor in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(cube.scaled(factor).is_err());
        }
    }

    #[test]
    fn test_shapes_are_what_they_claim() {
        // Areas of the outlines times height 1.
        assert!((shapes::l_shape().volume() - 5.0).abs() <= 1e-14);
        assert!((shapes::u_shape().volume() - 7.0).abs() <= 1e-14);
        let ball = shapes::sphere(4).volume() / (4.0 / 3.0 * std::f64::consts::PI);
        assert!(ball > 0.99 && ball < 1.0);
    }
}
