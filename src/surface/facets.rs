//! Surfaces in pieces small enough to be taken as flat: what radiosity exchanges light between.
//!
//! A facet is the image of a cell of some parameters, a quadrilateral between four points of the
//! surface (three for a triangle). Its contour is what other points see of it, by Lambert's
//! formula, flat or not; the points inside stand for it where light is received or looked for. They
//! are the four of Gauss's rule by area, so that their plain mean is that over the cell up to cubic
//! functions.

use std::f64::consts::{FRAC_PI_4, TAU};

use glam::{DVec2, DVec3};

use super::Hit;
use crate::math::{Frame, Placement};

/// Says how finely a surface is divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Division<'a> {
    /// About how many facets the surface gets, at least 1. Each shape rounds to what suits it; a
    /// mesh has no fewer than triangles.
    pub count: usize,
    /// Where the light comes from, metres: discs are divided more finely towards the nearest of
    /// these points.
    pub lights: &'a [DVec3],
}

/// Holds a piece of a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Facet {
    /// The contour, counter-clockwise about the normal; a triangle has its last corner twice.
    pub corners: [DVec3; 4],
    /// The point in the middle.
    pub middle: Hit,
    /// Points of equal weight: 4, or 3 in a triangle.
    pub points: Vec<Hit>,
    /// The area of the surface in the facet, m2.
    pub area: f64,
}

/// The abscissae of Gauss's rule with two nodes on [0, 1].
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// How many times as wide as long the cells of discs are.
const WIDTH: f64 = 4.0;

/// A cell of the parameters of a surface, each from the first number to the second.
#[derive(Debug, Clone, Copy)]
struct Cell {
    u: [f64; 2],
    v: [f64; 2],
}

impl Facet {
    /// Makes a facet; the contour is turned so that it runs counter-clockwise about the normal in
    /// the middle.
    fn new(mut corners: [DVec3; 4], middle: Hit, points: Vec<Hit>, area: f64) -> Self {
        if area_vector(&corners).dot(middle.normal) < 0.0 {
            corners.reverse();
        }
        Self { corners, middle, points, area }
    }

    /// Makes the facet that a map from the parameters to the surface gives of a cell.
    fn of_cell(cell: &Cell, at: impl Fn(DVec2) -> Hit, area: f64) -> Self {
        let corners = cell.corners().map(|p| at(p).point);
        let points = cell.points().map(&at).to_vec();
        Self::new(corners, at(cell.middle()), points, area)
    }

    /// Returns the area of the facet if it is flat, m2: that of its contour.
    pub fn flat_area(&self) -> f64 {
        area_vector(&self.corners).length()
    }

    /// Places the facet where hits go by `place`.
    pub(super) fn placed(self, placement: &Placement, place: impl Fn(&Hit) -> Hit) -> Self {
        Self {
            corners: self.corners.map(|c| placement.apply(c)),
            middle: place(&self.middle),
            points: self.points.iter().map(place).collect(),
            area: self.area * placement.scale().powi(2),
        }
    }
}

/// Returns half the cross product of the diagonals: normal times area.
fn area_vector([a, b, c, d]: &[DVec3; 4]) -> DVec3 {
    0.5 * (*c - *a).cross(*d - *b)
}

impl Cell {
    /// Divides the unit square into `columns` times `rows` cells.
    fn all([columns, rows]: [usize; 2]) -> impl Iterator<Item = Self> {
        let span = |i: usize, n: usize| [i as f64 / n as f64, (i + 1) as f64 / n as f64];
        (0..columns * rows)
            .map(move |k| Self { u: span(k % columns, columns), v: span(k / columns, rows) })
    }

    fn at(&self, [u, v]: [f64; 2]) -> DVec2 {
        let between = |[a, b]: [f64; 2], t: f64| a + t * (b - a);
        DVec2::new(between(self.u, u), between(self.v, v))
    }

    fn corners(&self) -> [DVec2; 4] {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|p| self.at(p))
    }

    fn middle(&self) -> DVec2 {
        self.at([0.5, 0.5])
    }

    fn points(&self) -> [DVec2; 4] {
        let [a, b] = GAUSS;
        [[a, a], [b, a], [b, b], [a, b]].map(|p| self.at(p))
    }
}

/// Divides a rectangle with sides of these lengths, whose points `at` gives by parameters in the
/// unit square, into nearly square cells.
pub(super) fn rectangle(lengths: DVec2, count: usize, at: impl Fn(DVec2) -> Hit) -> Vec<Facet> {
    let columns = (count as f64 * lengths.x / lengths.y).sqrt().round().clamp(1.0, count as f64);
    let rows = (count as f64 / columns).round().max(1.0);
    let area = lengths.x * lengths.y / (columns * rows);
    Cell::all([columns as usize, rows as usize])
        .map(|cell| Facet::of_cell(&cell, &at, area))
        .collect()
}

/// Divides a disc, whose points `at` gives by their offset from the centre, into sectors and rings
/// about the point nearest to a light.
///
/// At height h over the disc the light falls off over a distance of h, farther out in proportion to
/// the distance itself. So the rings have the radii h sinh(k d), k = 0, 1, ..., equal steps of
/// which are that. Light changes little along a ring, and the sectors are four times as wide as the
/// rings: on Sobolev's discs that takes a third of the error of square cells. Without a light the
/// rings are about the centre and evenly wide. About a point aside all rings are flattened alike,
/// the last onto the rim.
pub(super) fn disc(
    centre: DVec3,
    normal: DVec3,
    radius: f64,
    division: &Division,
    at: impl Fn(DVec3) -> Hit,
) -> Vec<Facet> {
    let frame = Frame::about(normal);
    let (foot, height) = foot(centre, normal, radius, division.lights);
    let span = (radius / height).asinh();
    let count = division.count as f64;
    let sectors = (TAU * count / (WIDTH * span)).sqrt().round().clamp(8.0, (count / 2.0).max(8.0));
    let rings = (count / sectors).round().max(1.0);
    let offset = |distance: f64, angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let along = cos * frame.tangent + sin * frame.bitangent;
        foot + distance * to_rim(foot, along, radius) * along
    };
    let ring = |k: usize| (span * (k as f64 / rings)).sinh() / span.sinh();
    let rim = |angle: f64| offset(1.0, angle) - foot;
    Cell::all([sectors as usize, rings as usize])
        .map(|cell| {
            let k = (cell.v[0] * rings).round() as usize;
            let squared = [ring(k), ring(k + 1)].map(|s| s * s);
            let angles = cell.u.map(|u| TAU * u);
            // The area between two angles and two squared relative radii, which with them are the
            // parameters of equal area.
            let fan = GAUSS.map(|t| rim(angles[0] + t * (angles[1] - angles[0])).length_squared());
            let fan = 0.25 * (fan[0] + fan[1]) * (angles[1] - angles[0]);
            let flat = 0.5 * rim(angles[0]).cross(rim(angles[1])).length();
            // A chord cuts off a part of the sector; the contour is enlarged to have its area.
            let stretch = (fan / flat).sqrt();
            let by_area = Cell { u: angles, v: squared };
            let place = |p: DVec2| at(offset(p.y.max(0.0).sqrt().min(1.0), p.x));
            let corners = by_area
                .corners()
                .map(|p| centre + foot + stretch * (offset(p.y.sqrt(), p.x) - foot));
            let points = by_area.points().map(place).to_vec();
            let area = fan * (squared[1] - squared[0]);
            Facet::new(corners, place(by_area.middle()), points, area)
        })
        .collect()
}

/// Returns the offset, from the centre, of the point of a disc that is nearest to a light, kept off
/// the rim, and the light's distance.
fn foot(centre: DVec3, normal: DVec3, radius: f64, lights: &[DVec3]) -> (DVec3, f64) {
    let nearest = |light: &DVec3| {
        let offset = *light - centre;
        let aside = offset.reject_from_normalized(normal).clamp_length_max(0.8 * radius);
        (aside, aside.distance(offset))
    };
    let feet = lights.iter().map(nearest).min_by(|a, b| a.1.total_cmp(&b.1));
    // Nearer than a thousandth of the radius, ever finer rings would leave none for the rest;
    // beyond it, they are even.
    feet.map_or((DVec3::ZERO, radius), |(aside, height)| {
        (aside, height.clamp(1e-3 * radius, radius))
    })
}

/// Returns the distance to the rim of a disc about the origin from `foot`, inside it, along a unit
/// vector in its plane.
fn to_rim(foot: DVec3, along: DVec3, radius: f64) -> f64 {
    let b = foot.dot(along);
    (b * b + radius * radius - foot.length_squared()).sqrt() - b
}

/// Divides a surface around the origin, whose points and areas per solid angle `at` gives by
/// direction, by the cells of a cube whose faces have at least `least` of them along an edge.
pub(super) fn around(
    count: usize,
    least: usize,
    at: impl Fn(DVec3) -> (Hit, f64),
) -> impl Iterator<Item = Facet> {
    let along = ((count as f64 / 6.0).sqrt().round() as usize).max(least);
    let faces = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let cells = faces.into_iter().flat_map(move |face| {
        let frame = Frame::about(face);
        Cell::all([along; 2]).map(move |cell| (frame, cell))
    });
    cells.map(move |(frame, cell)| {
        // Equal steps of angle instead of length make the cells nearly alike.
        let direction = |p: DVec2| {
            let flat = (2.0 * p - 1.0).map(|x| (FRAC_PI_4 * x).tan());
            frame.to_world(flat.extend(1.0)).normalize()
        };
        let [a, b, c, d] = cell.corners().map(direction);
        let solid_angle = solid_angle(a, b, c) + solid_angle(a, c, d);
        let points = cell.points().map(|p| at(direction(p)));
        let factor = 0.25 * points.iter().map(|(_, factor)| factor).sum::<f64>();
        let corners = stretched([a, b, c, d].map(|corner| at(corner).0.point), arcs(&[a, b, c, d]));
        let points = points.map(|(hit, _)| hit).to_vec();
        Facet::new(corners, at(direction(cell.middle())).0, points, factor * solid_angle)
    })
}

/// Returns how much larger the vector area of a quadrilateral of arcs between unit vectors is than
/// that of its chords.
fn arcs(corners: &[DVec3; 4]) -> f64 {
    let arc = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        a.cross(b).normalize_or_zero() * (0.5 * a.angle_between(b))
    };
    (0..4).map(arc).sum::<DVec3>().length() / area_vector(corners).length()
}

/// Enlarges a contour about its middle to `by` times its area.
fn stretched(corners: [DVec3; 4], by: f64) -> [DVec3; 4] {
    let middle = 0.25 * corners.iter().sum::<DVec3>();
    corners.map(|corner| middle + by.sqrt() * (corner - middle))
}

/// Returns the solid angle of a triangle of unit vectors, sr (Van Oosterom and Strackee 1983).
fn solid_angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// Divides a triangle, whose points `at` gives by the weights of its second and third corner, into
/// about `area / largest` equal ones.
pub(super) fn triangle(
    corners: [DVec3; 3],
    largest: f64,
    at: impl Fn(DVec2) -> Hit,
    into: &mut Vec<Facet>,
) {
    let [a, b, c] = corners;
    let area = 0.5 * (b - a).cross(c - a).length();
    let along = (area / largest).sqrt().round().clamp(1.0, 1e6) as usize;
    let step = 1.0 / along as f64;
    let part = |origin: DVec2, side: f64| {
        let corner = |x: f64, y: f64| origin + side * step * DVec2::new(x, y);
        let point = |p: DVec2| a + p.x * (b - a) + p.y * (c - a);
        let [p, q, r] = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
        let middle = (p + q + r) / 3.0;
        // Halfway from the middle to the corners: exact up to quadratic functions.
        let points = [p, q, r].map(|corner| at(0.5 * (middle + corner))).to_vec();
        let contour = [point(p), point(q), point(r), point(r)];
        Facet::new(contour, at(middle), points, area * step * step)
    };
    for i in 0..along {
        for j in 0..along - i {
            let origin = step * DVec2::new(i as f64, j as f64);
            into.push(part(origin, 1.0));
            if i + j + 1 < along {
                into.push(part(origin + step, -1.0));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;
    use std::sync::Arc;

    use super::*;
    use crate::math::Placement;
    use crate::mesh::shapes;
    use crate::sh::Coefficients;
    use crate::surface::primitives::{AxisBox, Disc, Rectangle, Sphere};
    use crate::surface::{Instance, Intersector, MeshSurface, SampleArea, ShSurface};

    const NOWHERE: Division = Division { count: 200, lights: &[] };

    /// Every facet is on its surface, turned to its normal, and all together have its area and
    /// close where the surface does.
    fn check(surface: &dyn SampleArea, division: &Division, area_error: f64, flat_error: f64) {
        let facets = surface.facets(division);
        let area: f64 = facets.iter().map(|f| f.area).sum();
        assert!((area / surface.area() - 1.0).abs() <= area_error, "{area} {}", surface.area());
        for facet in &facets {
            let normal = area_vector(&facet.corners);
            assert!(normal.dot(facet.middle.normal) > 0.9 * normal.length(), "{facet:?}");
            assert!((facet.flat_area() / facet.area - 1.0).abs() <= flat_error, "{facet:?}");
            let half = facet.area.sqrt();
            for hit in facet.points.iter().chain([&facet.middle]) {
                let off = surface.hit(&hit.leave(-hit.normal));
                assert!(off.is_none_or(|h| h.distance > 0.0), "{hit:?}");
                let back = surface
                    .hit(&crate::math::Ray::new(hit.point + 1e-3 * half * hit.normal, -hit.normal));
                let distance = back.expect("on the surface").distance;
                assert!((distance / (1e-3 * half) - 1.0).abs() <= 1e-6, "{distance} {hit:?}");
            }
        }
    }

    #[test]
    fn facets_cover_their_surfaces() {
        let solid = AxisBox::new(DVec3::ZERO, DVec3::new(4.0, 5.0, 3.0)).expect("valid");
        check(&solid, &NOWHERE, 1e-12, 1e-9);
        check(&solid.turned_inward(true), &NOWHERE, 1e-12, 1e-9);
        assert_eq!(solid.facets(&Division { count: 1, lights: &[] }).len(), 6);
        let plate = Rectangle::new(DVec3::ONE, 10.0 * DVec3::X, DVec3::Y).expect("valid");
        check(&plate, &NOWHERE, 1e-12, 1e-9);
        assert_eq!(plate.facets(&Division { count: 10, lights: &[] }).len(), 10);
        check(&Sphere::new(DVec3::ONE, 2.0).expect("valid"), &NOWHERE, 1e-12, 0.02);
    }

    #[test]
    fn discs_are_graded_towards_a_light() {
        let disc = Disc::new(DVec3::ONE, DVec3::new(1.0, 2.0, 3.0), 2.0).expect("valid");
        check(&disc, &NOWHERE, 1e-12, 1e-3);
        for light in [disc.centre() + 0.05 * disc.normal(), DVec3::ZERO, DVec3::new(50.0, 0.0, 0.0)]
        {
            let division = Division { count: 200, lights: &[light] };
            // About a point aside the sectors' areas are integrated by two nodes each.
            check(&disc, &division, 1e-3, 1e-2);
            let near = |f: &&Facet| f.middle.point.distance(light);
            let facets = disc.facets(&division);
            let first = facets.iter().min_by(|a, b| near(a).total_cmp(&near(b)));
            let largest = facets.iter().map(|f| f.area).fold(0.0, f64::max);
            assert!(first.expect("facets").area <= largest, "{light}");
        }
    }

    #[test]
    fn bodies_and_meshes_are_covered_too() {
        let mut c = Coefficients::zeros(2);
        c.set(0, 0, 1.0, 0.0);
        c.set(2, 0, 0.2, 0.0);
        let egg = Arc::new(ShSurface::new(&c, Intersector::Certified).expect("positive"));
        check(&*egg, &NOWHERE, 1e-4, 0.05);
        let turn = glam::DQuat::from_rotation_x(1.0);
        let placement = Placement::new(turn, 3.0, DVec3::ONE).expect("valid");
        check(&Instance::new(egg, placement), &NOWHERE, 1e-4, 0.05);
        let mesh = MeshSurface::new(shapes::cube()).expect("valid");
        check(&mesh, &NOWHERE, 1e-12, 1e-9);
        assert_eq!(mesh.facets(&NOWHERE).len(), 12 * 16);
    }

    #[test]
    fn points_integrate_cubic_functions_on_rectangles_and_quadratic_ones_on_triangles() {
        let plate = Rectangle::new(DVec3::ZERO, DVec3::X, DVec3::Y).expect("valid");
        let mean = |f: &Facet, g: &dyn Fn(DVec3) -> f64| {
            f.points.iter().map(|h| g(h.point)).sum::<f64>() / f.points.len() as f64
        };
        let facets = plate.facets(&Division { count: 4, lights: &[] });
        let sum: f64 = facets.iter().map(|f| f.area * mean(f, &|p| p.x.powi(3) * p.y)).sum();
        assert!((sum - 0.125).abs() <= 1e-14, "{sum}");
        let mut triangles = Vec::new();
        let at = |p: DVec2| Hit { ..plate.facets(&NOWHERE)[0].middle }.moved(p);
        triangle([DVec3::ZERO, DVec3::X, DVec3::Y], 0.1, at, &mut triangles);
        let sum: f64 = triangles.iter().map(|f| f.area * mean(f, &|p| p.x * p.y)).sum();
        assert!((sum - 1.0 / 24.0).abs() <= 1e-14, "{sum}");
        let disc = Disc::new(DVec3::ZERO, DVec3::Z, 1.0).expect("valid");
        let sum: f64 =
            disc.facets(&NOWHERE).iter().map(|f| f.area * mean(f, &|p| p.length_squared())).sum();
        assert!((sum - 0.5 * PI).abs() <= 1e-12, "{sum}");
    }

    impl Hit {
        /// The same hit at other parameters of the unit triangle.
        fn moved(self, p: DVec2) -> Self {
            Self { point: p.extend(0.0), ..self }
        }
    }
}
