//! The surface of a series in space: how far it is from the triangles it bends over, which of its
//! points is near another, and how far it certainly is from one.
//!
//! P(omega) = c + f(omega) omega is a point of the surface. Along any great circle |P''| <= K =
//! sqrt((M2 + R)^2 + 4 M1^2), R, M1 and M2 the bounds of f, of its slope and of its curvature
//! (`sh::Bounds`). So over an arc of length l P is off linear interpolation of its ends by at most
//! K l^2 t (1 - t) / 2 at the part t. A spherical triangle is filled by the arcs from the corner
//! that faces its shortest side, a, to the points of that side; none is longer than the longest
//! side, m. Interpolated along both, P is off the flat triangle of its corners by at most K (m +
//! a^2 / 4m)^2 / 8, in both directions, since the arcs' parts run over the whole triangle: 17 %
//! above what is sharp for equal sides.

use glam::DVec3;

use crate::Result;
use crate::fit::{Resolution, Shape, surface_mesh};
use crate::mesh::triangle::nearest_on_triangle;
use crate::mesh::{Mesh, NearestPoint};
use crate::sh::{Bounds, Evaluator};

/// A series as a surface about its centre.
pub(super) struct Smooth {
    pub(super) series: Evaluator,
    pub(super) centre: DVec3,
    /// Bounds the second derivative of its points along great circles.
    bend: f64,
    /// Bounds what a point of it may be off.
    pub(super) rounding: f64,
    /// The directions of the vertices of the mesh it is looked for by.
    pub(super) directions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// The most that the surface is off a face of that mesh.
    bulge: f64,
}

/// A point of a surface, as near to another as was found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Foot {
    pub(super) point: DVec3,
    /// The direction of the point from the centre of a series.
    pub(super) direction: DVec3,
    /// The face of the mesh it is on, or was looked for from.
    pub(super) face: u32,
    pub(super) distance: f64,
}

/// What is certain of the distance of a point.
pub(super) struct Certain {
    /// It is not less.
    pub(super) lower: f64,
    /// The nearest point that was found.
    pub(super) foot: Foot,
    /// How many patches that took.
    pub(super) looked_at: usize,
}

/// A part of the surface above a spherical triangle.
struct Patch {
    directions: [DVec3; 3],
    points: [DVec3; 3],
    /// It is not nearer.
    lower: f64,
}

/// The least frequency of the icosphere a series is looked for by.
const FREQUENCY: usize = 24;
/// Degrees for each cut of the icosahedron's edges.
const DEGREES: usize = 4;
/// Steps towards the nearest point, and the part of the radius that a step must gain.
const STEPS: usize = 8;
const GAIN: f64 = 1e-9;
/// Patches looked at for one certain distance.
const MOST_PATCHES: usize = 1 << 16;
/// Angles above this, radians, are not bounded.
const WIDEST: f64 = 1.0;

/// Returns what a function with a second derivative of at most 1 along great circles may be off
/// linear interpolation over a spherical triangle.
pub(super) fn spread([a, b, c]: [DVec3; 3]) -> f64 {
    let sides = [a.distance(b), b.distance(c), c.distance(a)];
    let angle = |chord: f64| 2.0 * (0.5 * chord).min(1.0).asin();
    let longest = angle(sides.into_iter().fold(0.0, f64::max));
    let shortest = angle(sides.into_iter().fold(f64::INFINITY, f64::min));
    if longest == 0.0 {
        return 0.0;
    }
    // NaN is no angle either.
    if longest <= WIDEST {
        (longest + 0.25 * shortest * shortest / longest).powi(2) / 8.0
    } else {
        f64::INFINITY
    }
}

impl Smooth {
    /// Prepares a series, with the mesh it is looked for by.
    ///
    /// # Errors
    /// As [`Bounds::of`] and [`crate::fit::tessellate`].
    pub(super) fn new(shape: &Shape) -> Result<(Self, Mesh)> {
        let f = &shape.coefficients;
        let series = Evaluator::new(f)?;
        let frequency = FREQUENCY.max(f.lmax() / DEGREES);
        let mesh = surface_mesh(&series, Resolution::Icosphere { frequency })?;
        let Bounds { min, max, slope, curvature } = Bounds::of(f)?;
        let radius = max.max(-min);
        let mut made = Self {
            bend: (curvature + radius).hypot(2.0 * slope),
            rounding: 4.0 * series.error(radius) + 4.0 * f64::EPSILON * shape.centre.length(),
            series,
            centre: shape.centre,
            directions: mesh.positions().iter().map(|p| p.normalize()).collect(),
            triangles: mesh.triangles().to_vec(),
            bulge: 0.0,
        };
        let faces = 0..made.triangles.len() as u32;
        made.bulge = faces.map(|face| made.bulge(made.face(face))).fold(0.0, f64::max);
        Ok((made, mesh.translated(shape.centre)))
    }

    /// Returns the point in a direction.
    pub(super) fn point(&self, direction: DVec3) -> DVec3 {
        self.centre + self.series.value(direction) * direction
    }

    /// Returns the outward normal in a direction, along f omega - grad_S f.
    pub(super) fn normal(&self, direction: DVec3) -> DVec3 {
        let jet = self.series.jet(direction);
        (jet.value * direction - jet.gradient).normalize()
    }

    /// Returns the direction of a point from the centre.
    pub(super) fn direction(&self, point: DVec3) -> DVec3 {
        (point - self.centre).normalize()
    }

    /// Bounds how far the surface above a spherical triangle is from the flat triangle of its
    /// corners, and that from the surface.
    pub(super) fn bulge(&self, directions: [DVec3; 3]) -> f64 {
        self.bend * spread(directions)
    }

    fn face(&self, face: u32) -> [DVec3; 3] {
        self.triangles[face as usize].map(|v| self.directions[v as usize])
    }

    /// Finds a point near `point`, from a direction on: the part of the way there along the tangent
    /// plane is gone until it brings nothing more.
    pub(super) fn foot(&self, point: DVec3, direction: DVec3, face: u32) -> Foot {
        let at = |direction: DVec3| {
            let jet = self.series.jet(direction);
            let found = self.centre + jet.value * direction;
            let foot = Foot { point: found, direction, face, distance: found.distance(point) };
            (foot, jet.value * direction - jet.gradient)
        };
        let (mut foot, mut normal) = at(direction);
        for _ in 0..STEPS {
            let way = point - foot.point;
            let along = way - normal * (way.dot(normal) / normal.length_squared());
            let (next, there) = at(self.direction(foot.point + along));
            let gain = foot.distance - next.distance;
            if gain > 0.0 {
                (foot, normal) = (next, there);
            }
            if gain.is_nan() || gain <= GAIN * self.bend {
                break;
            }
        }
        foot
    }

    /// Bounds the distance of a point from below, to within `slack` of the nearest point there is,
    /// which is found as well: parts of the surface that may be nearer than the nearest known by
    /// more are halved until none is, or there are too many.
    pub(super) fn certain(
        &self,
        point: DVec3,
        known: Foot,
        slack: f64,
        tree: &NearestPoint,
    ) -> Certain {
        let mut foot = known;
        let near = tree.faces_within(point, foot.distance + self.bulge - slack);
        let whole = |face: u32| {
            let directions = self.face(face);
            self.patch(point, directions, directions.map(|d| self.point(d)))
        };
        let mut open: Vec<Patch> = near.into_iter().map(whole).collect();
        let mut looked_at = 0;
        loop {
            open.retain(|patch| patch.lower < foot.distance - slack);
            looked_at += open.len();
            if open.is_empty() || looked_at > MOST_PATCHES {
                let lower = open.iter().map(|patch| patch.lower);
                let lower = lower.fold(foot.distance - slack, f64::min).max(0.0);
                return Certain { lower, foot, looked_at };
            }
            open = open.iter().flat_map(|patch| self.quarters(point, patch)).collect();
            let corners = open.iter().flat_map(|p| p.directions.into_iter().zip(p.points));
            for (direction, there) in corners {
                if there.distance(point) < foot.distance - 0.5 * slack {
                    foot = self.foot(point, direction, foot.face);
                }
            }
        }
    }

    fn patch(&self, point: DVec3, directions: [DVec3; 3], points: [DVec3; 3]) -> Patch {
        let flat = point.distance(nearest_on_triangle(point, points));
        Patch { directions, points, lower: flat - self.bulge(directions) }
    }

    fn quarters(&self, point: DVec3, patch: &Patch) -> [Patch; 4] {
        let [a, b, c] = patch.directions;
        let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[p, q]| (p + q).normalize());
        let [pa, pb, pc] = patch.points;
        let [pab, pbc, pca] = [ab, bc, ca].map(|d| self.point(d));
        [
            self.patch(point, [a, ab, ca], [pa, pab, pca]),
            self.patch(point, [ab, b, bc], [pab, pb, pbc]),
            self.patch(point, [ca, bc, c], [pca, pbc, pc]),
            self.patch(point, [ab, bc, ca], [pab, pbc, pca]),
        ]
    }
}
