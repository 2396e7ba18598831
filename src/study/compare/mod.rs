//! How far two shapes are from each other, each a series or a mesh.
//!
//! In space: the two-sided Hausdorff distance, as an interval that is certain (`farthest`, and
//! `smooth` for series), and the angle between the normals at nearest points. About one centre: the
//! radial difference, by Parseval's theorem for two series, by quadrature on the faces for a series
//! and a mesh, by rays for two meshes.

mod farthest;
mod radial;
mod side;
mod smooth;

use glam::DVec3;
use rayon::prelude::*;

use self::farthest::{Aim, Apart, farthest_point};
use self::side::Side;
use crate::fit::{Resolution, Shape, surface_mesh};
use crate::mesh::Mesh;
use crate::sh::difference;
use crate::{Error, Result};

pub use farthest::{FarthestPoint, Limit};
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
    /// The distance is not more.
    pub upper: f64,
    /// The largest distance of the first from the second, and of the second from the first.
    pub one_sided: [FarthestPoint; 2],
    /// How wide each interval may be.
    pub width: f64,
}

impl Hausdorff {
    /// Returns why an interval is wider than it may be, if one is.
    pub fn limit(&self) -> Option<Limit> {
        self.one_sided.iter().find_map(|found| found.limit)
    }
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
    /// the size (the radius of the ball of equal area of the larger one), as far as seconds allow.
    pub width: Option<f64>,
    /// The centre about which the radii of two meshes are compared.
    pub centre: DVec3,
}

/// The default width relative to the size, and the points that are looked at for it.
const RELATIVE_WIDTH: f64 = 1e-3;
const POINTS: usize = 1 << 20;
/// The points that are looked at for a width that was asked for.
const MOST_POINTS: usize = 1 << 23;
/// The chord error of the mesh of a series that a map is painted on, relative to the size.
const MAP_ERROR: f64 = 1e-3;
/// Points on each shape at which normals are compared.
const NORMAL_SAMPLES: u64 = 8192;

/// Two shapes made ready to be compared.
pub struct Pair<'a> {
    subjects: [Subject<'a>; 2],
    sides: [Side; 2],
    /// The radial difference of two series about one centre.
    apart: Option<Apart>,
    aim: Aim,
    centre: DVec3,
}

impl<'a> Pair<'a> {
    /// Makes two shapes ready.
    ///
    /// # Errors
    /// [`Error::Geometry`] for a radius that is not positive, a mesh without faces or area or with
    /// vertices that are not finite; [`Error::Parameter`] for a width that is not positive, and for
    /// a degree too high; [`Error::Memory`] for more than is free.
    pub fn new(a: Subject<'a>, b: Subject<'a>, settings: &CompareSettings) -> Result<Self> {
        let aim = aim(a, b, settings)?;
        let (first, second) = rayon::join(|| Side::new(a), || Side::new(b));
        let sides = [first?, second?];
        let apart = match (a, b) {
            (Subject::Series(a), Subject::Series(b)) => apart(a, b)?,
            _ => None,
        };
        Ok(Self { subjects: [a, b], sides, apart, aim, centre: settings.centre })
    }

    /// Compares them.
    ///
    /// # Errors
    /// [`Error::Memory`] for more than is free; [`Error::Numeric`] and [`Error::Parameter`] as the
    /// integrals over the shapes, of which none is known for shapes that could be made ready.
    pub fn compare(&self) -> Result<Comparison> {
        let ([a, b], sides) = (self.subjects, &self.sides);
        Ok(Comparison {
            radial: radial::radial(a, b, self.centre)?,
            hausdorff: self.hausdorff()?,
            normals: normal_angles(sides),
            volumes: [sides[0].volume, sides[1].volume],
            areas: [sides[0].area, sides[1].area],
        })
    }

    fn hausdorff(&self) -> Result<Hausdorff> {
        let ([a, b], aim) = (&self.sides, self.aim);
        let found = |sides| farthest_point(sides, self.apart.as_ref(), aim);
        let one_sided = [found([a, b])?, found([b, a])?];
        let larger = |key: fn(&FarthestPoint) -> f64| key(&one_sided[0]).max(key(&one_sided[1]));
        Ok(Hausdorff {
            lower: larger(|p| p.lower),
            upper: larger(|p| p.upper),
            one_sided,
            width: aim.width,
        })
    }

    /// Measures the distance of the second shape at the vertices of the first, or of a mesh of it.
    ///
    /// # Errors
    /// As [`crate::fit::tessellate`].
    pub fn distance_map(&self) -> Result<DistanceMap> {
        let mesh = match &self.sides[0].smooth {
            Some(smooth) => {
                let tolerance = MAP_ERROR * side::size(self.subjects[0]);
                let mesh = surface_mesh(&smooth.series, Resolution::Adaptive { tolerance })?;
                mesh.translated(smooth.centre)
            }
            None => self.sides[0].mesh().clone(),
        };
        let normals = vertex_normals(&mesh);
        let distance = |(p, normal): (&DVec3, &DVec3)| {
            let nearest = self.sides[1].foot(*p);
            let outside = (nearest.point - *p).dot(*normal) >= 0.0;
            if outside { nearest.distance } else { -nearest.distance }
        };
        let distances = mesh.positions().par_iter().zip(&normals).map(distance).collect();
        Ok(DistanceMap { mesh, distances })
    }
}

/// Prepares the radial difference of two series, if it is about one centre.
fn apart(a: &Shape, b: &Shape) -> Result<Option<Apart>> {
    let [fa, fb] = [&a.coefficients, &b.coefficients];
    let centres = a.centre.distance(b.centre);
    let is_one = centres <= RELATIVE_WIDTH * fa.mean().abs();
    is_one.then(|| Apart::new(&difference(fa, fb), centres)).transpose()
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

fn aim(a: Subject, b: Subject, settings: &CompareSettings) -> Result<Aim> {
    match settings.width {
        None => {
            let width = RELATIVE_WIDTH * side::size(a).max(side::size(b));
            Ok(Aim { width, points: POINTS })
        }
        Some(width) if width > 0.0 && width.is_finite() => Ok(Aim { width, points: MOST_POINTS }),
        Some(width) => Err(Error::Parameter(format!(
            "the width of the interval must be a positive number of metres, found {width}"
        ))),
    }
}

fn normal_angles(sides: &[Side; 2]) -> NormalAngles {
    let angle = |i: u64| {
        let [from, to] =
            if i < NORMAL_SAMPLES { [&sides[0], &sides[1]] } else { [&sides[1], &sides[0]] };
        let (point, normal) = from.sample(i % NORMAL_SAMPLES);
        normal.angle_between(to.normal(&to.foot(point)))
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
