//! Areas, and points sampled evenly on them.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::super::{AxisBox, Disc, Rectangle, Sphere};
use super::v;
use crate::math::{Randomness, Ray, Stream, sampling};
use crate::surface::{Hit, SampleArea, Surface};

/// Averages over 2^16 scrambled Sobol points of the unit square.
fn mean(shape: &dyn SampleArea, f: impl Fn(&Hit) -> f64) -> f64 {
    let n = 1_u64 << 16;
    let sum: f64 = (0..n)
        .map(|i| {
            let u = DVec2::from_array(Stream::new(Randomness::Sobol, 9, i).next_2d());
            let at = shape.sample_area(u);
            assert!((at.density * shape.area() - 1.0).abs() <= 4.0 * f64::EPSILON);
            assert_eq!(at.density, shape.density(&at.hit));
            assert!((at.hit.normal.length() - 1.0).abs() <= 4.0 * f64::EPSILON);
            assert!(shape.bounds().contains(at.hit.point) && at.hit.distance == 0.0);
            f(&at.hit)
        })
        .sum();
    sum / n as f64
}

// 65536 Owen-scrambled points integrate these smooth or once-broken moments to a few times 1e-6 at
// worst; 1e-4 leaves room.
const MOMENT: f64 = 1e-4;

#[test]
fn sphere_and_disc_samples_have_uniform_moments() {
    let sphere = Sphere::new(v(1.0, 2.0, 3.0), 2.0).expect("valid");
    assert!((sphere.area() - 16.0 * PI).abs() <= 1e-13);
    for axis in 0..3 {
        let offset = |h: &Hit| h.point[axis] - sphere.centre()[axis];
        assert!(mean(&sphere, offset).abs() <= MOMENT);
        assert!((mean(&sphere, |h| offset(h).powi(2)) - 4.0 / 3.0).abs() <= MOMENT);
    }
    let disc = Disc::new(v(1.0, 2.0, 3.0), v(1.0, 1.0, 1.0), 2.0).expect("valid");
    let from_centre = |h: &Hit| (h.point - disc.centre()).length();
    assert!((disc.area() - 4.0 * PI).abs() <= 1e-14);
    assert!((mean(&disc, |h| from_centre(h).powi(2)) - 2.0).abs() <= MOMENT);
    assert!((mean(&disc, from_centre) - 4.0 / 3.0).abs() <= MOMENT);
}

#[test]
fn rectangle_and_box_samples_have_uniform_moments() {
    let table = Rectangle::new(v(1.0, 1.0, 1.0), 2.0 * DVec3::Y, 3.0 * DVec3::X).expect("valid");
    assert!((mean(&table, |h| h.point.x) - 2.5).abs() <= MOMENT);
    assert!((mean(&table, |h| (h.point.y - 2.0).powi(2)) - 1.0 / 3.0).abs() <= MOMENT);
    let room = AxisBox::new(DVec3::ZERO, v(4.0, 5.0, 3.0)).expect("valid");
    assert_eq!(room.area(), 94.0);
    for (part, area) in [15.0, 15.0, 12.0, 12.0, 20.0, 20.0].into_iter().enumerate() {
        let share = mean(&room, |h| f64::from(u8::from(h.part as usize == part)));
        assert!((share - area / 94.0).abs() <= MOMENT, "part {part}");
    }
    // On the floor and the lid x is uniform, on the x faces it is 0 or 4.
    let second = (2.0 * 15.0 * 4.0 + 64.0 * 4.0 / 3.0) / 94.0;
    assert!((mean(&room, |h| (h.point.x - 2.0).powi(2)) - second).abs() <= 2.0 * MOMENT);
}

/// Estimates the area by uniform directions from a point inside: the mean of 4 pi t^2/cos over the
/// hits.
fn area_by_rays(shape: &dyn Surface, from: DVec3) -> f64 {
    let n = 1_u64 << 16;
    let sum: f64 = (0..n)
        .filter_map(|i| {
            let u = Stream::new(Randomness::Sobol, 3, i).next_2d();
            let ray = Ray::new(from, sampling::uniform_sphere(u));
            let hit = shape.hit(&ray)?;
            Some(hit.distance.powi(2) / hit.normal.dot(ray.direction).abs())
        })
        .sum();
    4.0 * PI * sum / n as f64
}

#[test]
fn area_agrees_with_the_solid_angle_of_rays() {
    // The integrand is broken at rims and edges: Sobol points are good to about n^-3/4 = 2.4e-4 of
    // the area there.
    let from = v(0.2, 0.1, 0.3);
    let flat = Rectangle::new(v(-0.5, -0.4, 0.0), DVec3::X, DVec3::Y).expect("valid");
    let disc = Disc::new(v(0.1, 0.0, 0.0), DVec3::Z, 0.6).expect("valid");
    let sphere = Sphere::new(DVec3::ZERO, 1.0).expect("valid");
    let cube = AxisBox::new(v(-0.5, -0.3, -0.4), v(0.6, 0.7, 0.8)).expect("valid");
    let all: [&dyn SampleArea; 4] = [&flat, &disc, &sphere, &cube];
    for shape in all {
        let ratio = area_by_rays(shape, from) / shape.area();
        assert!((ratio - 1.0).abs() <= 3e-3, "{ratio}");
    }
}
