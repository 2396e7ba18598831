//! How far two shapes are from each other, each a series or a mesh.
//!
//! In space: the two-sided Hausdorff distance, as an interval that is certain (meshes by branch and
//! bound, see [`farthest_point`]; series through a mesh whose own bounded distance is added), and
//! the angle between the normals at nearest points. About one centre: the radial difference, by
//! Parseval's theorem for two series, by quadrature on the faces for a series and a mesh, by rays
//! for two meshes.

mod radial;
mod side;

use glam::DVec3;
use rayon::prelude::*;

use self::side::Side;
use crate::fit::ChordError;
use crate::fit::Shape;
use crate::mesh::{FarthestPoint, Mesh, farthest_point};
use crate::{Error, Result};

pub use radial::RadialDifference;

/// Names what is compared.
#[derive(Debug, Clone, Copy)]
pub enum Subject<'a> {
    /// A series about its centre.
    Series(&'a Shape),
    /// A mesh; open ones have no volume and no radius.
    Mesh(&'a Mesh),
}

/// Holds what two shapes differ in. The first of a pair is always about the first shape.
#[derive(Debug)]
pub struct Comparison {
    /// The radial difference; else why there is none.
    pub radial: Result<RadialDifference>,
    /// The two-sided Hausdorff distance.
    pub hausdorff: Hausdorff,
    /// The angles between the normals at nearest points.
    pub normals: NormalAngles,
    /// The volumes, m3; `None` for a mesh that is not closed.
    pub volumes: [Option<f64>; 2],
    /// The areas, m2.
    pub areas: [f64; 2],
}

/// Encloses the Hausdorff distance of two surfaces: the largest distance of a point of either from
/// the other, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hausdorff {
    /// The distance is not less.
    pub lower: f64,
    /// The distance is not more; infinite where a series is of so high a degree that its mesh has
    /// no bounded error.
    pub upper: f64,
    /// The largest distance of the first from the second, and of the second from the first, between
    /// the meshes that stand for them.
    pub one_sided: [FarthestPoint; 2],
    /// How far the mesh that stands for a series is from it; `None` for meshes.
    pub chord_errors: [Option<ChordError>; 2],
}

/// Holds the angles, radians, between the outward normal at points spread evenly by area over both
/// shapes and the normal at the nearest point of the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalAngles {
    /// The mean.
    pub mean: f64,
    /// The angle that 95 % of the points stay below.
    pub percentile_95: f64,
    /// How many points there are, both shapes together.
    pub samples: usize,
}

/// Holds, for each vertex of a mesh, how far the other shape is from it.
#[derive(Debug, Clone, PartialEq)]
pub struct DistanceMap {
    /// The mesh: the first shape, or the mesh that stands for it.
    pub mesh: Mesh,
    /// Per vertex the distance to the nearest point of the second shape, metres; positive where
    /// that is outside the first (ahead of the vertex's normal).
    pub distances: Vec<f64>,
}

impl DistanceMap {
    /// Returns a colour for each vertex, from blue (negative) over white to red, and the distance
    /// at which they are full, the largest; the strength of a colour grows with the square root, so
    /// that small differences show beside a large one.
    pub fn colours(&self) -> (Vec<[u8; 3]>, f64) {
        let end = self.distances.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
        let share = |d: &f64| if end > 0.0 { d / end } else { 0.0 };
        (self.distances.iter().map(|d| diverging(share(d))).collect(), end)
    }
}

/// Returns the colour of -1 to 1: blue, white, red, which all kinds of colour vision tell apart.
fn diverging(share: f64) -> [u8; 3] {
    const ENDS: [[f64; 3]; 2] = [[0.0, 114.0, 178.0], [178.0, 24.0, 43.0]];
    let end = ENDS[usize::from(share > 0.0)];
    let strength = share.abs().min(1.0).sqrt();
    end.map(|channel| (255.0 + strength * (channel - 255.0)).round() as u8)
}

/// Sets a comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompareSettings {
    /// How wide the interval of the Hausdorff distance may be, metres; `None` for a thousandth of
    /// the size (the radius of the ball of equal area of the larger one).
    pub width: Option<f64>,
    /// The centre about which the radii of two meshes are compared.
    pub centre: DVec3,
}

/// The share of the width that the meshes of series may take: their bound is some times the chord
/// error that is measured.
const CHORD_SHARE: f64 = 0.1;
/// The default width relative to the size.
const RELATIVE_WIDTH: f64 = 1e-3;
/// Points on each shape at which normals are compared.
const NORMAL_SAMPLES: u64 = 8192;

/// Two shapes made ready to be compared.
pub struct Pair<'a> {
    subjects: [Subject<'a>; 2],
    sides: [Side; 2],
    width: f64,
    centre: DVec3,
}

impl<'a> Pair<'a> {
    /// Makes two shapes ready: a series becomes a mesh fine enough for the width of the interval.
    ///
    /// # Errors
    /// [`Error::Geometry`] for a radius that is not positive, a mesh without faces or area or with
    /// vertices that are not finite; [`Error::Parameter`] for a width that is not positive or takes
    /// too many faces, and for a degree too high.
    pub fn new(a: Subject<'a>, b: Subject<'a>, settings: &CompareSettings) -> Result<Self> {
        let width = width(a, b, settings)?;
        let side = |subject| Side::new(subject, CHORD_SHARE * width);
        let (first, second) = rayon::join(|| side(a), || side(b));
        let sides = [first?, second?];
        Ok(Self { subjects: [a, b], sides, width, centre: settings.centre })
    }

    /// Compares them.
    ///
    /// # Errors
    /// [`Error::Numeric`] and [`Error::Parameter`] as the integrals over the shapes; none is known
    /// for shapes that could be made ready.
    pub fn compare(&self) -> Result<Comparison> {
        let ([a, b], sides) = (self.subjects, &self.sides);
        Ok(Comparison {
            radial: radial::radial(a, b, self.centre)?,
            hausdorff: hausdorff(sides, self.width),
            normals: normal_angles(sides),
            volumes: [sides[0].volume, sides[1].volume],
            areas: [sides[0].area, sides[1].area],
        })
    }

    /// Measures the distance of the second shape at the vertices of the first.
    pub fn distance_map(&self) -> DistanceMap {
        let mesh = self.sides[0].mesh();
        let normals = vertex_normals(mesh);
        let distance = |(p, normal): (&DVec3, &DVec3)| {
            let nearest = self.sides[1].tree.nearest(*p);
            let outside = (nearest.point - *p).dot(*normal) >= 0.0;
            if outside { nearest.distance } else { -nearest.distance }
        };
        let distances = mesh.positions().par_iter().zip(&normals).map(distance).collect();
        DistanceMap { mesh: mesh.clone(), distances }
    }
}

/// Compares two shapes.
///
/// # Errors
/// As [`Pair::new`] and [`Pair::compare`].
pub fn compare(a: Subject, b: Subject, settings: &CompareSettings) -> Result<Comparison> {
    Pair::new(a, b, settings)?.compare()
}

/// Adds up the area vectors around each vertex: the sign of a distance needs no more than the side
/// they look to.
fn vertex_normals(mesh: &Mesh) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; mesh.positions().len()];
    for (face, vertices) in mesh.triangles().iter().enumerate() {
        let area = mesh.area_vector(face);
        for v in vertices {
            normals[*v as usize] += area;
        }
    }
    normals
}

fn width(a: Subject, b: Subject, settings: &CompareSettings) -> Result<f64> {
    match settings.width {
        None => Ok(RELATIVE_WIDTH * side::size(a).max(side::size(b))),
        Some(width) if width > 0.0 && width.is_finite() => Ok(width),
        Some(width) => Err(Error::Parameter(format!(
            "the width of the interval must be a positive number of metres, found {width}"
        ))),
    }
}

fn hausdorff([a, b]: &[Side; 2], width: f64) -> Hausdorff {
    let chord_errors = [a.chord_error, b.chord_error];
    // The Hausdorff distance obeys the triangle inequality: two series are as far apart as their
    // meshes, give or take the meshes' own distances.
    let around: f64 =
        chord_errors.iter().flatten().map(|error| error.bound.unwrap_or(f64::INFINITY)).sum();
    let open = if around < 0.5 * width { width - 2.0 * around } else { 0.5 * width };
    let one_sided =
        [farthest_point(a.mesh(), &b.tree, open), farthest_point(b.mesh(), &a.tree, open)];
    let larger = |key: fn(&FarthestPoint) -> f64| key(&one_sided[0]).max(key(&one_sided[1]));
    Hausdorff {
        lower: (larger(|p| p.lower) - around).max(0.0),
        upper: larger(|p| p.upper) + around,
        one_sided,
        chord_errors,
    }
}

fn normal_angles(sides: &[Side; 2]) -> NormalAngles {
    let angle = |i: u64| {
        let [from, to] =
            if i < NORMAL_SAMPLES { [&sides[0], &sides[1]] } else { [&sides[1], &sides[0]] };
        let (point, normal) = from.sample(i % NORMAL_SAMPLES);
        let nearest = to.tree.nearest(point);
        normal.angle_between(to.normal(nearest.point, nearest.face))
    };
    let mut angles: Vec<f64> = (0..2 * NORMAL_SAMPLES).into_par_iter().map(angle).collect();
    angles.sort_by(f64::total_cmp);
    let samples = angles.len();
    NormalAngles {
        mean: angles.iter().sum::<f64>() / samples as f64,
        percentile_95: angles[samples * 95 / 100],
        samples,
    }
}

#[cfg(test)]
mod tests;
