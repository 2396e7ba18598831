//! What a body measures: volume, area, centroid, inertia, and numbers of its form.
//!
//! Form is told by the dynamically equivalent equal-volume ellipsoid: that of the body's volume,
//! centroid and principal axes whose moments of inertia are in the ratios of the body's. Of its
//! semi-axes a >= b >= c, elongation is b/a and flatness c/b (Zingg 1935). Sphericity is the area
//! of the ball of the same volume over that of the body (Wadell 1935). Roughness is the root mean
//! square, over the area, of the distance between surface and ellipsoid along the ray from the
//! centroid: Sq of ISO 25178 with that ellipsoid as the form.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::Shape;
use super::face_nodes::{DEEPEST, FINEST, fold_faces, points_per_side, rules, visit_face};
use crate::mesh::Mesh;
use crate::sh::{PrincipalAxes, Solid, outer, over_surface};
use crate::{Error, Result};

/// The change of the area between two grids, relative to it, at which the finer is fine enough:
/// errors fall geometrically with its rings, so that its own is about the square of that.
const SETTLED: f64 = 1e-6;

/// How many points fewer than for a fit are enough for the distance from an ellipsoid, along each
/// side of a face.
const FEWER: usize = 2;

/// Points along each side of a face at least: over a flat one the squared distance from an
/// ellipsoid near it is about a polynomial of degree four.
const LEAST: usize = 4;

/// Holds what a body measures, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measures {
    /// The volume, m3.
    pub volume: f64,
    /// The area of the surface, m2.
    pub area: f64,
    /// The centroid of the volume, m, in the axes of the file.
    pub centroid: DVec3,
    /// The principal moments of inertia about the centroid and their axes, of unit density.
    pub principal: PrincipalAxes,
    /// The semi-axes of the ellipsoid of equal volume and equivalent inertia, m, descending: along
    /// the principal axes in their order.
    pub semi_axes: [f64; 3],
    /// The root mean square distance of the surface from that ellipsoid, m.
    pub roughness: f64,
}

impl Measures {
    /// Measures the body of a series: its integrals exactly but for rounding, area and roughness on
    /// grids refined until the area changes by less than 1e-6 of itself, and is then right to far
    /// less than that (or up to 2^24 samples).
    ///
    /// # Errors
    /// [`Error::Geometry`] when a radius is not positive; [`Error::Parameter`] for a degree too
    /// high to evaluate.
    pub fn of_shape(shape: &Shape) -> Result<Self> {
        let solid = Solid::of(&shape.coefficients)?;
        let form = Ellipsoid::of(&solid)?;
        let square = |place: DVec3| form.distance(place - solid.centroid).powi(2);
        let (area, squares) = over_surface(&shape.coefficients, SETTLED, square)?;
        Ok(form.measures(&solid, shape.centre, area.value, squares))
    }

    /// Measures the body inside a closed mesh, exactly but for rounding; the roughness by
    /// quadrature on the faces, to about a millionth of the size.
    ///
    /// ```
    /// use glam::DVec3;
    /// use harmolux::fit::Measures;
    /// use harmolux::mesh::Mesh;
    ///
    /// let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    /// let tetrahedron = Mesh::new(corners, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
    /// let measures = Measures::of_mesh(&tetrahedron)?;
    /// assert!((measures.volume - 1.0 / 6.0).abs() <= 1e-15);
    /// assert!(measures.centroid.distance(DVec3::splat(0.25)) <= 1e-15);
    /// # Ok::<(), harmolux::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Geometry`] when the volume is not positive, or no body has its moments: the faces
    /// look inwards, say, or pieces overlap.
    pub fn of_mesh(mesh: &Mesh) -> Result<Self> {
        let middle = mesh.bounds().centre();
        let solid = enclosed(mesh, middle);
        let form = Ellipsoid::of(&solid)?;
        let squares = form.squares(mesh, middle + solid.centroid);
        Ok(form.measures(&solid, middle, mesh.area(), squares))
    }

    /// Returns the area of the ball of the same volume over that of the body (Wadell): 1 for a
    /// ball, less for anything else.
    pub fn sphericity(&self) -> f64 {
        PI.cbrt() * (6.0 * self.volume).powf(2.0 / 3.0) / self.area
    }

    /// Returns b/a of the semi-axes a >= b >= c: 1 where the two longest are equal.
    pub fn elongation(&self) -> f64 {
        self.semi_axes[1] / self.semi_axes[0]
    }

    /// Returns c/b of the semi-axes a >= b >= c: 1 where the two shortest are equal.
    pub fn flatness(&self) -> f64 {
        self.semi_axes[2] / self.semi_axes[1]
    }
}

/// Integrates over the inside of a closed mesh, about `middle`: tetrahedra over the faces.
pub(crate) fn enclosed(mesh: &Mesh, middle: DVec3) -> Solid {
    let (mut volume, mut moment, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    for face in 0..mesh.triangles().len() {
        let [a, b, c] = mesh.corners(face).map(|p| p - middle);
        let (sum, six_fold) = (a + b + c, a.dot(b.cross(c)));
        volume += six_fold / 6.0;
        moment += (six_fold / 24.0) * sum;
        second += (six_fold / 120.0) * (outer(a) + outer(b) + outer(c) + outer(sum));
    }
    Solid::of_moments(volume, moment, second)
}

/// The ellipsoid that tells the form of a body.
struct Ellipsoid {
    principal: PrincipalAxes,
    semi_axes: [f64; 3],
}

impl Ellipsoid {
    fn of(solid: &Solid) -> Result<Self> {
        let principal = solid.principal_axes();
        let sum: f64 = principal.moments.iter().sum();
        // Second moments along the axes are as the squares of the semi-axes.
        let lengths = principal.moments.map(|moment| (0.5 * sum - moment).sqrt());
        let scale = 0.75 * solid.volume / PI / lengths.iter().product::<f64>();
        let semi_axes = lengths.map(|length| length * scale.cbrt());
        if solid.volume > 0.0 && semi_axes.iter().all(|a| a.is_finite() && *a > 0.0) {
            return Ok(Self { principal, semi_axes });
        }
        Err(Error::Geometry(format!(
            "no body has a volume of {:e} m3 and the moments of inertia {:e}, {:e}, {:e} m5: let \
             the faces look outwards, and leave pieces out that overlap",
            solid.volume, principal.moments[0], principal.moments[1], principal.moments[2]
        )))
    }

    /// Returns how far a place, from the centroid, is outside of the ellipsoid along its ray.
    fn distance(&self, place: DVec3) -> f64 {
        let along = self.principal.axes.transpose() * place / DVec3::from_array(self.semi_axes);
        let times = along.length();
        if times > 0.0 { place.length() * (1.0 - 1.0 / times) } else { -self.semi_axes[2] }
    }

    /// Integrates the squared distance over the faces of a mesh.
    fn squares(&self, mesh: &Mesh, centroid: DVec3) -> f64 {
        let points = |corners: &[DVec3; 3]| match points_per_side(corners, 0) {
            few @ ..=FINEST => few.saturating_sub(FEWER).max(LEAST),
            many => many,
        };
        let rules = rules();
        let task = |range: std::ops::Range<usize>| {
            let mut sum = 0.0;
            for face in range {
                let corners = mesh.corners(face).map(|p| p - centroid);
                visit_face(corners, &points, &rules, DEEPEST, &mut |node| {
                    sum += node.area * self.distance(node.radius * node.direction).powi(2);
                });
            }
            sum
        };
        let mut total = 0.0;
        fold_faces(mesh.triangles().len(), task, |part: f64| total += part);
        total
    }

    fn measures(self, solid: &Solid, centre: DVec3, area: f64, squares: f64) -> Measures {
        Measures {
            volume: solid.volume,
            area,
            centroid: centre + solid.centroid,
            principal: self.principal,
            semi_axes: self.semi_axes,
            roughness: (squares / area).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{Resolution, tessellate};
    use crate::mesh::shapes;
    use crate::sh::{Coefficients, Grid, Spectrum, analysis};

    /// Expands a radius about the origin on a grid fine enough that aliasing is rounding.
    fn expanded(lmax: usize, radius: impl Fn(DVec3) -> f64) -> Shape {
        let grid = Grid::gauss_legendre(150, 300);
        let values: Vec<f64> = (0..grid.len()).map(|i| radius(grid.direction(i))).collect();
        Shape::new(analysis(&values, &grid, lmax).expect("fine enough"))
    }

    fn ellipsoid(axes: DVec3) -> Shape {
        expanded(64, move |w| (w / axes).length().recip())
    }

    fn of(shape: &Shape) -> Measures {
        Measures::of_shape(shape).expect("a body")
    }

    /// Makes a box of these edges, one corner at `corner`.
    fn cuboid(edges: DVec3, corner: DVec3) -> Mesh {
        let cube = shapes::cube();
        let positions = cube.positions().iter().map(|p| corner + edges * *p).collect();
        Mesh::new(positions, cube.triangles().to_vec()).expect("indices in range")
    }

    /// The area of an ellipsoid by Gauss's arithmetic-geometric mean: Legendre's formula
    /// 2 pi (c^2 + a b / sin p (E sin^2 p + F cos^2 p)), cos p = c / a, k^2 sin^2 p a^2 (b^2 - c^2)
    /// = b^2 (a^2 - c^2), the incomplete integrals by Landen's descending steps.
    fn area_of_ellipsoid(a: f64, b: f64, c: f64) -> f64 {
        let p = (c / a).acos();
        let m = a * a * (b * b - c * c) / (b * b * (a * a - c * c));
        let (mut mean, mut root, mut k) = (1.0, (1.0 - m).sqrt(), m.sqrt());
        let (mut phi, mut power, mut squares, mut sines) = (p, 1.0, k * k, 0.0);
        while k.abs() > 1e-17 {
            let half_turns = (phi / PI + 0.5).floor();
            phi += (root / mean * phi.tan()).atan() + half_turns * PI;
            (mean, root, k) = (0.5 * (mean + root), (mean * root).sqrt(), 0.5 * (mean - root));
            power *= 2.0;
            squares += power * k * k;
            sines += k * phi.sin();
        }
        let first = phi / (power * mean);
        let second = first * (1.0 - 0.5 * squares) + sines;
        2.0 * PI * (c * c + a * b / p.sin() * (second * p.sin().powi(2) + first * p.cos().powi(2)))
    }

    fn assert_near(found: f64, exact: f64, tolerance: f64) {
        assert!((found - exact).abs() <= tolerance * exact.abs(), "{found} is not {exact}");
    }

    #[test]
    fn ball_anywhere_is_a_ball() {
        let mut c = Coefficients::zeros(3);
        c.set(0, 0, 2.0, 0.0);
        let centre = DVec3::new(100.0, -7.0, 0.5);
        let ball = of(&Shape { centre, ..Shape::new(c) });
        // The same about a centre that is not its own.
        let off = DVec3::new(0.3, -0.2, 0.1);
        let seen =
            expanded(48, |w| w.dot(off) + (w.dot(off).powi(2) + 4.0 - off.length_squared()).sqrt());
        let seen = of(&Shape { centre: centre - off, ..seen });
        for (ball, tolerance) in [(ball, 1e-13), (seen, 1e-11)] {
            assert!(ball.centroid.distance(centre) <= 100.0 * tolerance);
            assert_near(ball.volume, 32.0 * PI / 3.0, tolerance);
            assert_near(ball.area, 16.0 * PI, tolerance);
            for (moment, axis) in ball.principal.moments.into_iter().zip(ball.semi_axes) {
                assert_near(moment, 0.4 * ball.volume * 4.0, tolerance);
                assert_near(axis, 2.0, tolerance);
            }
            for one in [ball.sphericity(), ball.elongation(), ball.flatness()] {
                assert_near(one, 1.0, 2.0 * tolerance);
            }
            assert!(ball.roughness <= tolerance, "{}", ball.roughness);
        }
    }

    #[test]
    fn ellipsoid_has_its_axes_area_and_no_roughness() {
        let (a, b, c) = (1.2, 1.0, 0.8);
        // By incomplete elliptic integrals in 30 digits (mpmath).
        assert_near(area_of_ellipsoid(a, b, c), 12.501_094_893_352_27, 1e-14);
        for axes in [DVec3::new(a, b, c), DVec3::new(c, a, b), DVec3::new(b, 0.9, 1.3)] {
            let body = of(&ellipsoid(axes));
            let mut sorted = axes.to_array();
            sorted.sort_by(|x, y| y.total_cmp(x));
            let [a, b, c] = sorted;
            assert_near(body.area, area_of_ellipsoid(a, b, c), 1e-10);
            assert_near(body.volume, 4.0 * PI / 3.0 * a * b * c, 1e-12);
            body.semi_axes.iter().zip(sorted).for_each(|(f, e)| assert_near(*f, e, 1e-10));
            assert_near(body.elongation(), b / a, 1e-10);
            assert_near(body.flatness(), c / b, 1e-10);
            let ball = 4.0 * PI * (a * b * c).powf(2.0 / 3.0);
            assert_near(body.sphericity(), ball / area_of_ellipsoid(a, b, c), 1e-10);
            assert!(body.roughness <= 1e-9, "{}", body.roughness);
            let place = axes.to_array().iter().position(|x| *x == a).expect("there");
            assert!((body.principal.axes.x_axis[place].abs() - 1.0).abs() <= 1e-12);
        }
    }

    #[test]
    fn box_has_its_closed_forms_wherever_it_stands() {
        for corner in [DVec3::ZERO, DVec3::new(1e4, -2e4, 3e4)] {
            let body =
                Measures::of_mesh(&cuboid(DVec3::new(1.0, 3.0, 2.0), corner)).expect("closed");
            assert_near(body.volume, 6.0, 1e-12);
            assert_near(body.area, 22.0, 1e-12);
            assert!(body.centroid.distance(corner + DVec3::new(0.5, 1.5, 1.0)) <= 1e-11);
            // m (b^2 + c^2) / 12.
            for (moment, exact) in body.principal.moments.into_iter().zip([2.5, 5.0, 6.5]) {
                assert_near(moment, exact, 1e-10);
            }
            let scale = (6.0_f64 * 0.75 / PI / 6.0).cbrt();
            for (axis, edge) in body.semi_axes.into_iter().zip([3.0, 2.0, 1.0]) {
                assert_near(axis, scale * edge, 1e-10);
            }
            assert_near(body.sphericity(), PI.cbrt() * 36.0_f64.powf(2.0 / 3.0) / 22.0, 1e-12);
            assert_near(body.elongation(), 2.0 / 3.0, 1e-10);
            assert_near(body.flatness(), 0.5, 1e-10);
        }
    }

    /// The midpoints of a million squares on each face of the cube, against the ball of radius R.
    #[test]
    fn cube_is_as_rough_as_its_squares_say() {
        let body = Measures::of_mesh(&shapes::cube()).expect("closed");
        let (radius, n) = ((0.75 / PI).cbrt(), 1000);
        let middle = |i: i32| (f64::from(i) + 0.5) / f64::from(n) - 0.5;
        let square = |x: f64, y: f64| ((x * x + y * y + 0.25).sqrt() - radius).powi(2);
        let sum: f64 = (0..n).flat_map(|i| (0..n).map(move |j| square(middle(i), middle(j)))).sum();
        assert_near(body.roughness, (sum / f64::from(n * n)).sqrt(), 1e-5);
    }

    /// A ball with a bump of one degree is as rough as the root mean square of that, to first order
    /// in its height; its mesh is as rough as itself.
    #[test]
    fn plank_is_as_rough_as_the_points_of_its_sides_say() {
        // Midpoints of a grid over each pair of sides, by the definition.
        let edges = DVec3::new(10.0, 1.0, 2.0);
        let body = Measures::of_mesh(&cuboid(edges, DVec3::ZERO)).expect("closed");
        let radius = (6.0 / PI).cbrt();
        let (mut squares, mut area) = (0.0, 0.0);
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            let side = edges[i] * edges[j];
            area += side;
            for (u, v) in (0..400).flat_map(|u| (0..400).map(move |v| (u, v))) {
                let middle = |n: i32| (f64::from(n) + 0.5) / 400.0 - 0.5;
                let mut p = DVec3::ZERO;
                (p[i], p[j], p[k]) = (middle(u) * edges[i], middle(v) * edges[j], 0.5 * edges[k]);
                let times = (p / (0.5 * radius * edges)).length();
                squares += side * (p.length() * (1.0 - 1.0 / times)).powi(2) / 160_000.0;
            }
        }
        let expected = (squares / area).sqrt();
        assert!((body.roughness / expected - 1.0).abs() <= 1e-4, "{} {expected}", body.roughness);
    }

    #[test]
    fn bumps_are_the_roughness_of_series_and_mesh() {
        let mut c = Coefficients::zeros(8);
        c.set(0, 0, 1.0, 0.0);
        c.set(8, 3, 1e-3, 0.0);
        let body = of(&Shape::new(c.clone()));
        assert_near(body.roughness, Spectrum::of(&c).degrees()[8].amplitude, 1e-2);
        let mesh = tessellate(&c, DVec3::ZERO, Resolution::Icosphere { frequency: 60 });
        let mesh = Measures::of_mesh(&mesh.expect("a body").mesh).expect("closed");
        assert_near(mesh.roughness, body.roughness, 0.02);
        assert_near(mesh.area, body.area, 1e-3);
    }

    #[test]
    fn what_encloses_nothing_is_refused() {
        let message = |mesh: &Mesh| Measures::of_mesh(mesh).expect_err("refused").to_string();
        assert!(message(&shapes::cube().flipped()).contains("look outwards"));
        assert!(message(&Mesh::default()).contains("no body"));
        let flat = cuboid(DVec3::new(1.0, 1.0, 0.0), DVec3::ZERO);
        assert!(message(&flat).contains("no body"));
        assert!(Measures::of_shape(&Shape::new(Coefficients::zeros(2))).is_err());
    }
}
