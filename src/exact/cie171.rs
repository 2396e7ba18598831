//! The analytic cases of CIE 171:2006, section 5, as tables of points with their exact values.
//!
//! One room throughout: 4 x 4 x 3 m with a corner at the origin, points in the plane x = 2: A to F
//! on the wall y = 0 from z = 2.75 down to 0.25, G to N on the floor or the ceiling from y = 0.25
//! up to 3.75. The values are computed from the formulas, not copied from the report, whose Table
//! 19 (case 5.7) is wrong (errata by I. Ashdown). Case 5.5 is the glass of [`glass`], case 5.8 the
//! cube of [`interreflection`].

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::form_factors::polygon;
use super::ranges::accept;
use super::{Cube, Pane};
use crate::Result;

/// Holds one point of a case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// The report's letter, or a digit where it has none.
    pub label: char,
    /// The point, metres.
    pub point: DVec3,
    /// The unit normal of the receiver, into the room.
    pub normal: DVec3,
    /// The exact value; its unit is the case's.
    pub value: f64,
    /// The figure that the report prints, in the same unit, where it differs from the exact one and
    /// is known here.
    pub published: Option<f64>,
}

/// Holds what one face of the room receives in case 5.4.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceFlux {
    /// The face, named as those of a box in a scene: `x_min` to `z_max`.
    pub face: &'static str,
    /// The area, m2.
    pub area: f64,
    /// The flux that arrives, lm.
    pub flux: f64,
}

/// The side of the floor, metres.
const SIDE: f64 = 4.0;
/// The height of the room, metres.
const HEIGHT: f64 = 3.0;
/// The luminance of the source of case 5.3, cd/m2.
pub const AREA_SOURCE_LUMINANCE: f64 = 1000.0;
/// The flux of the sources of cases 5.4 and 5.8, lm.
pub const SOURCE_FLUX: f64 = 10_000.0;
/// The refractive index of the glass of case 5.5.
pub const GLASS_INDEX: f64 = 1.52;
/// The intensity along the axis of the source of case 5.2, cd.
pub const POINT_SOURCE_INTENSITY: f64 = 1000.0;

/// Returns case 5.2, lx: a Lambertian point source at (0, 0, 3) that looks down, over the 4 x 4 m
/// plane about the origin.
///
/// E = I0 h^2/(h^2 + x^2 + y^2)^2; the labels count the points from 0.
pub fn point_source() -> Vec<Reading> {
    let places = [
        (0.0, 0.0),
        (0.5, 0.0),
        (1.0, 0.0),
        (1.5, 0.0),
        (0.5, 0.5),
        (1.0, 0.5),
        (1.5, 0.5),
        (1.0, 1.0),
        (1.5, 1.0),
        (1.5, 1.5),
    ];
    let reading = |(label, (x, y))| Reading {
        label,
        point: DVec3::new(x, y, 0.0),
        normal: DVec3::Z,
        value: point_source_at(DVec2::new(x, y)),
        published: None,
    };
    ('0'..='9').zip(places).map(reading).collect()
}

/// Returns the illuminance, lx, of case 5.2 at `offset` metres from the foot of the source.
pub fn point_source_at(offset: DVec2) -> f64 {
    let h2 = HEIGHT * HEIGHT;
    POINT_SOURCE_INTENSITY * h2 / (h2 + offset.length_squared()).powi(2)
}

/// Returns case 5.3, lx: a uniform source of 1 x 1 m and 1000 cd/m2 in the middle of the ceiling of
/// a black room, wall and floor.
///
/// The report's own figures stand beside the exact ones; they are up to 0.3 % off.
pub fn area_source() -> Vec<Reading> {
    // A to F, then G to J; K to N mirror these.
    let published = [32.68, 75.09, 81.38, 69.12, 53.41, 39.90, 61.27, 79.18, 95.52, 105.89];
    let of_point = published.into_iter().chain(published.into_iter().rev().take(4));
    let readings = read(wall(6).chain(floor(8)), area_source_at);
    readings.into_iter().zip(of_point).map(|(r, p)| Reading { published: Some(p), ..r }).collect()
}

/// Returns the illuminance, lx, of case 5.3 at any point below the ceiling.
pub fn area_source_at(point: DVec3, normal: DVec3) -> f64 {
    let source = [(1.5, 1.5), (2.5, 1.5), (2.5, 2.5), (1.5, 2.5)];
    let source = source.map(|(x, y)| DVec3::new(x, y, HEIGHT));
    PI * AREA_SOURCE_LUMINANCE * polygon(&source, point, normal)
}

/// Returns case 5.4, lm: what each face of the black room receives of an isotropic source of 10 000
/// lm at `source`, metres.
///
/// The flux is that of the source times the solid angle of the face over 4 pi; the six add up to
/// the whole. From the foot of the perpendicular to a face, a rectangle of a x b at distance d
/// fills atan(a b/(d sqrt(a^2 + b^2 + d^2))) for each quadrant.
///
/// # Errors
/// [`Error::Parameter`](crate::Error::Parameter) for a source that is not inside the room.
pub fn flux_conservation(source: DVec3) -> Result<[FaceFlux; 6]> {
    let size = [SIDE, SIDE, HEIGHT];
    let at = source.to_array();
    for ((name, c), length) in ["x", "y", "z"].into_iter().zip(at).zip(size) {
        let name = format!("the source's {name}, in metres,");
        accept(c > 0.0 && c < length, &name, c, &format!("between 0 and {length}"))?;
    }
    let faces = [("x_min", "x_max"), ("y_min", "y_max"), ("z_min", "z_max")];
    Ok(std::array::from_fn(|i| {
        let axis = i / 2;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let (face, distance) = match i % 2 {
            0 => (faces[axis].0, at[axis]),
            _ => (faces[axis].1, size[axis] - at[axis]),
        };
        let quadrants = [at[u], size[u] - at[u]]
            .into_iter()
            .flat_map(|a| [at[v], size[v] - at[v]].map(|b| solid_angle(a, b, distance)));
        let share = quadrants.sum::<f64>() / (4.0 * PI);
        FaceFlux { face, area: size[u] * size[v], flux: SOURCE_FLUX * share }
    }))
}

/// Returns the solid angle of a rectangle of `a` x `b` from a point at `distance` over one of its
/// corners.
fn solid_angle(a: f64, b: f64, distance: f64) -> f64 {
    (a * b).atan2(distance * DVec3::new(a, b, distance).length())
}

/// Returns case 5.5: the clear glass whose directional transmittance is asked for, by its
/// transmittance inside along the normal.
pub const fn glass(internal_transmittance: f64) -> Pane {
    Pane { refractive_index: GLASS_INDEX, internal_transmittance }
}

/// Returns case 5.6, percent: E/(E_hz rho) on wall (A to E) and ceiling (G to N) when only the
/// floor is lit, by E_hz, and reflects.
pub fn diffuse_reflection() -> Vec<Reading> {
    read(wall(5).chain(ceiling()), diffuse_reflection_at)
}

/// Returns the value, percent, of case 5.6 at any point above the floor.
pub fn diffuse_reflection_at(point: DVec3, normal: DVec3) -> f64 {
    let lit = [(0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE)];
    100.0 * polygon(&lit.map(|(x, y)| DVec3::new(x, y, 0.0)), point, normal)
}

/// Returns case 5.7, percent: E/(E_v rho) on wall (A to F) and floor (G to K) when only the wall y
/// = 4 is lit, by E_v, and reflects, while a black box across the whole room (2.5 <= y <= 2.7, z
/// <= 1) stands before it.
pub fn obstruction() -> Vec<Reading> {
    read(wall(6).chain(floor(5)), obstruction_at)
}

/// Returns the value, percent, of case 5.7 at any point before the box (y < 2.5).
pub fn obstruction_at(point: DVec3, normal: DVec3) -> f64 {
    // Both upper edges of the box hide the wall below the line through them.
    let hidden_by = |y: f64| point.z + (1.0 - point.z) * (SIDE - point.y) / (y - point.y);
    let shadow = hidden_by(2.5).max(hidden_by(2.7)).clamp(0.0, HEIGHT);
    let seen = [(0.0, shadow), (SIDE, shadow), (SIDE, HEIGHT), (0.0, HEIGHT)];
    100.0 * polygon(&seen.map(|(x, z)| DVec3::new(x, SIDE, z)), point, normal)
}

/// Returns case 5.8: a cube of 4 m, all faces of one reflectance, with an isotropic source of 10
/// 000 lm in its middle.
///
/// The report's formula is [`Cube::mean_indirect`], exact as a mean over the faces; [`Cube::solve`]
/// gives every point.
pub const fn interreflection(reflectance: f64) -> Cube {
    Cube { edge: 4.0, flux: SOURCE_FLUX, reflectance }
}

/// Evaluates a case at its points.
fn read(
    places: impl Iterator<Item = (char, DVec3, DVec3)>,
    value: impl Fn(DVec3, DVec3) -> f64,
) -> Vec<Reading> {
    places
        .map(|(label, point, normal)| Reading {
            label,
            point,
            normal,
            value: value(point, normal),
            published: None,
        })
        .collect()
}

/// Returns the first `count` points of the wall y = 0, from A downwards.
fn wall(count: usize) -> impl Iterator<Item = (char, DVec3, DVec3)> {
    ('A'..='F')
        .zip(0_u32..)
        .take(count)
        .map(|(label, i)| (label, DVec3::new(2.0, 0.0, 2.75 - 0.5 * f64::from(i)), DVec3::Y))
}

/// Returns the first `count` points of the floor, from G away from the wall.
fn floor(count: usize) -> impl Iterator<Item = (char, DVec3, DVec3)> {
    ('G'..='N')
        .zip(0_u32..)
        .take(count)
        .map(|(label, i)| (label, DVec3::new(2.0, 0.25 + 0.5 * f64::from(i), 0.0), DVec3::Z))
}

/// Returns the points of the ceiling, G to N.
fn ceiling() -> impl Iterator<Item = (char, DVec3, DVec3)> {
    floor(8).map(|(label, point, up)| (label, point + HEIGHT * up, -up))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares a case with its values, printed to four decimals.
    fn compare(readings: &[Reading], printed: &[(&str, f64)]) {
        for &(labels, value) in printed {
            for label in labels.chars() {
                let reading = readings.iter().find(|r| r.label == label).expect("listed");
                assert!((reading.value - value).abs() <= 5.1e-5, "{reading:?} for {value}");
            }
        }
        let named: usize = printed.iter().map(|(labels, _)| labels.len()).sum();
        assert_eq!(named, readings.len());
    }

    #[test]
    fn point_source_is_the_printed_table() {
        let printed = [
            111.1111, 105.1863, 90.0000, 71.1111, 99.7230, 85.6633, 68.0529, 74.3802, 59.9750,
            49.3827,
        ];
        for (reading, value) in point_source().iter().zip(printed) {
            assert!((reading.value - value).abs() <= 5.1e-5, "{reading:?}");
        }
        assert_eq!(point_source().len(), printed.len());
    }

    #[test]
    fn area_source_is_the_printed_table() {
        compare(
            &area_source(),
            &[
                ("A", 32.6769),
                ("B", 75.1939),
                ("C", 81.3232),
                ("D", 69.0606),
                ("E", 53.4035),
                ("F", 40.0019),
                ("GN", 61.4241),
                ("HM", 79.2552),
                ("IL", 95.6673),
                ("JK", 105.7782),
            ],
        );
    }

    #[test]
    fn published_figures_stand_at_their_points() {
        for reading in area_source() {
            let published = reading.published.unwrap();
            // The report's own accuracy; neighbouring points differ by 10 % and more.
            assert!((published / reading.value - 1.0).abs() <= 3e-3, "{reading:?}");
        }
        assert!(diffuse_reflection().iter().all(|r| r.published.is_none()));
    }

    #[test]
    fn flux_of_a_point_source_is_conserved_wherever_it_is() {
        for source in [[2.0, 2.0, 1.5], [0.1, 3.7, 2.99], [1e-9, 1e-9, 1e-9]] {
            let faces = flux_conservation(DVec3::from_array(source)).unwrap();
            let (area, flux) = faces.iter().fold((0.0, 0.0), |(a, f), x| (a + x.area, f + x.flux));
            assert_eq!(area, 80.0);
            assert!((flux / SOURCE_FLUX - 1.0).abs() <= 1e-14, "{source:?}: {flux}");
        }
        for wrong in [[0.0, 2.0, 1.5], [2.0, 4.0, 1.5], [2.0, 2.0, f64::NAN]] {
            assert!(flux_conservation(DVec3::from_array(wrong)).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn each_face_receives_what_its_illuminance_adds_up_to() {
        use crate::math::quadrature::Rule;
        let source = DVec3::new(1.2, 2.9, 1.7);
        let size = [SIDE, SIDE, HEIGHT];
        for (i, face) in flux_conservation(source).unwrap().iter().enumerate() {
            let (axis, far) = (i / 2, i % 2);
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let rule = |length: f64| Rule::gauss_legendre(40).on(0.0, length);
            let illuminance = |a: f64, b: f64| {
                let mut point = [far as f64 * size[axis]; 3];
                (point[u], point[v]) = (a, b);
                let ray = DVec3::from_array(point) - source;
                SOURCE_FLUX / (4.0 * PI) * ray[axis].abs() / ray.length().powi(3)
            };
            let flux = rule(size[u]).integrate(|a| rule(size[v]).integrate(|b| illuminance(a, b)));
            assert!((face.flux / flux - 1.0).abs() <= 1e-9, "{face:?}: {flux}");
        }
    }

    #[test]
    fn diffuse_reflection_is_the_printed_table() {
        compare(
            &diffuse_reflection(),
            &[
                ("E", 35.9005),
                ("D", 27.9916),
                ("C", 21.6385),
                ("B", 16.7163),
                ("A", 12.9674),
                ("GN", 26.7952),
                ("HM", 30.9387),
                ("IL", 33.9757),
                ("JK", 35.5666),
            ],
        );
    }

    #[test]
    fn obstruction_is_the_corrected_table() {
        compare(
            &obstruction(),
            &[
                ("A", 16.0706),
                ("B", 16.3297),
                ("C", 15.3988),
                ("D", 13.3220),
                ("E", 10.3169),
                ("F", 7.0790),
                ("G", 3.3823),
                ("H", 3.6290),
                ("I", 3.0130),
                ("JK", 0.0),
            ],
        );
    }

    #[test]
    fn flux_of_the_area_source_arrives() {
        // Floor, and four walls by symmetry, take all of pi L A = 1000 pi lm.
        use crate::math::quadrature::Rule;
        let (across, up) =
            (Rule::gauss_legendre(24).on(0.0, 4.0), Rule::gauss_legendre(24).on(0.0, 3.0));
        let on_floor = across
            .integrate(|x| across.integrate(|y| area_source_at(DVec3::new(x, y, 0.0), DVec3::Z)));
        let on_wall =
            across.integrate(|x| up.integrate(|z| area_source_at(DVec3::new(x, 0.0, z), DVec3::Y)));
        let share = (on_floor + 4.0 * on_wall) / (1000.0 * PI);
        assert!((share - 1.0).abs() <= 1e-6, "{share}");
    }
}
