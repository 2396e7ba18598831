//! Mirrors, and mixtures with them: against the furnace, and against the room that one sees in a
//! mirror, built.
//!
//! Statistical comparisons use fixed seeds and judge all values of a test together with a
//! false-alarm rate of 1e-3.

use std::f64::consts::PI;

use crate::common::films::{assert_alike, assert_flat, assert_same_mean};
use crate::common::{bumpy, camera, furnace, go_on, grey, image, placed, room, sensors};
use glam::DVec3;
use harmolux::estimators::{Estimator, Weighting, illuminance, luminance, render};
use harmolux::math::{Ray, Rgb};
use harmolux::scene::{Camera, Film, Glossy, Material, Object, PointLight, Scene, Sensor};
use harmolux::surface::primitives::Sphere;

const L0: f64 = 100.0;

fn mirror() -> Material {
    Material::mirror(Rgb::grey(1.0 - 1e-9)).expect("valid")
}

fn film(scene: &Scene, view: &Camera, estimator: Estimator, walks: u64) -> Film {
    let rendering = render(scene, view, &image(estimator, walks), &go_on).expect("renders");
    assert_eq!(rendering.film.non_finite(), 0);
    rendering.film
}

/// A furnace with a mirror wall around a body.
fn furnace_around(body: Material) -> Scene {
    let [a, b, c, d, e] = [0.5, 0.2, 0.7, 0.3, 0.8].map(|rho| furnace(rho, L0));
    let walls = room(DVec3::new(4.0, 5.0, 3.0), &[a, mirror(), b, c, d, e]);
    let body = Object::new("body", placed(bumpy(), DVec3::new(2.0, 2.5, 1.2), 0.7), body);
    Scene::new(vec![walls, body], vec![]).expect("valid")
}

fn check_furnace(body: Material) {
    let scene = furnace_around(body);
    let view = camera(DVec3::new(0.5, 0.4, 2.5), DVec3::new(2.0, 2.5, 1.2), [24, 24]);
    for estimator in [Estimator::Local(Weighting::of(&scene)), Estimator::Path] {
        assert_flat(&film(&scene, &view, estimator, 256), L0);
    }
    let points = [
        Sensor::plane(DVec3::new(1.0, 1.0, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(3.99, 2.0, 0.0), DVec3::Z),
    ];
    for estimator in [Estimator::Local(Weighting::of(&scene)), Estimator::Path] {
        let survey = illuminance(&scene, &points, &sensors(estimator, 4096), &go_on).expect("runs");
        for r in &survey.results {
            assert!(r.total.agrees_with(PI * L0, 0.0, points.len()), "{estimator:?}: {r:?}");
            assert!(r.total.relative_error() <= 0.02, "{r:?}");
        }
    }
}

#[test]
fn furnace_with_a_mirror() {
    check_furnace(mirror());
}

#[test]
fn furnace_with_a_mixture() {
    let gold = Material::glossy(Glossy::metal(Rgb::grey(1.0 - 1e-9), 0.4).expect("valid"));
    let parts = [(0.4, mirror()), (0.3, furnace(0.45, L0)), (0.3, gold)];
    check_furnace(Material::mixture(&parts).expect("valid"));
}

/// Rooms with a shining ceiling: one with a mirror for a wall, and one of twice the length with
/// what the mirror shows.
fn mirrored_and_built(reflecting: &Material) -> [Scene; 2] {
    let ball = |x: f64| {
        let ball = Sphere::new(DVec3::new(x, 3.5, 0.8), 0.6).expect("valid");
        Object::new("ball", ball, reflecting.clone())
    };
    let ceiling = || grey(0.7).emitting(Rgb::grey(300.0));
    let walls = |far: Material| [grey(0.3), far, grey(0.6), grey(0.5), grey(0.4), ceiling()];
    let size = DVec3::new(4.0, 5.0, 3.0);
    let mirrored = vec![room(size, &walls(mirror())), ball(2.0)];
    let built = room(DVec3::new(2.0, 1.0, 1.0) * size, &walls(grey(0.3)));
    [mirrored, vec![built, ball(2.0), ball(6.0)]]
        .map(|objects| Scene::new(objects, vec![]).expect("valid"))
}

#[test]
fn a_room_with_a_mirror_is_the_room_one_sees_in_it() {
    let varnish = Material::glossy(Glossy::coated(Rgb::grey(0.4), 1.5, 0.4).expect("valid"));
    let [mirrored, built] = mirrored_and_built(&varnish);
    // On the left the room itself, on the right the mirror.
    let view = camera(DVec3::new(1.5, 0.4, 1.5), DVec3::new(3.0, 3.0, 1.2), [24, 18]);
    let expected = film(&built, &view, Estimator::Local(Weighting::of(&built)), 512);
    for estimator in [Estimator::Local(Weighting::of(&mirrored)), Estimator::Path] {
        assert_alike(&film(&mirrored, &view, estimator, 1024), &expected);
    }
    let points = [
        Sensor::plane(DVec3::new(1.0, 1.0, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(3.9, 2.0, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(2.0, 2.5, 1.0), DVec3::X),
    ];
    let survey = |scene: &Scene, estimator, walks| {
        illuminance(scene, &points, &sensors(estimator, walks), &go_on).expect("runs").results
    };
    let expected = survey(&built, Estimator::Local(Weighting::of(&built)), 1 << 14);
    let local = Estimator::Local(Weighting::of(&mirrored));
    for estimator in [local, Estimator::Path, Estimator::Local(Weighting::Gather)] {
        for (a, b) in survey(&mirrored, estimator, 1 << 15).iter().zip(&expected) {
            let (a, b) = (a.total, b.total);
            assert!(a.agrees_with(b.mean, b.standard_error, 3), "{estimator:?}: {a:?} {b:?}");
            assert!(a.relative_error().hypot(b.relative_error()) <= 0.02, "{a:?} {b:?}");
        }
    }
}

#[test]
fn each_strategy_alone_gives_the_picture_of_both() {
    let varnish = Material::glossy(Glossy::coated(Rgb::grey(0.4), 1.5, 0.6).expect("valid"));
    let [mirrored, _] = mirrored_and_built(&varnish);
    let view = camera(DVec3::new(1.0, 0.6, 1.5), DVec3::new(3.0, 3.0, 1.2), [24, 18]);
    let expected = film(&mirrored, &view, Estimator::Local(Weighting::of(&mirrored)), 1024);
    // Near edges the variance of a strategy alone has no bound, and the errors of pixels there are
    // not known: only the means can be judged.
    for weighting in [Weighting::Walk, Weighting::Gather] {
        let alone = film(&mirrored, &view, Estimator::Local(weighting), 2048);
        assert_same_mean(&alone, &expected);
    }
}

#[test]
fn luminance_along_a_ray_goes_through_mirrors() {
    let [mirrored, built] = mirrored_and_built(&grey(0.5));
    let [mixed, _] = {
        let dull =
            [(0.5, Material::mirror(Rgb([0.9, 0.6, 0.3])).expect("valid")), (0.5, grey(0.4))];
        mirrored_and_built(&Material::mixture(&dull).expect("valid"))
    };
    // To a wall, into the mirror, and to the ball, which in the last scene is in part a mirror.
    let eye = DVec3::new(1.0, 1.0, 1.5);
    let rays = [DVec3::NEG_X, DVec3::new(1.0, 0.3, -0.1), DVec3::new(1.0, 2.5, -0.7)]
        .map(|to| Ray::new(eye, to.normalize()));
    let survey = |scene: &Scene, weighting| {
        let settings = sensors(Estimator::Local(weighting), 1 << 14);
        luminance(scene, &rays, &settings, &go_on).expect("runs").results
    };
    let expected = survey(&built, Weighting::of(&built));
    for (a, b) in survey(&mirrored, Weighting::of(&mirrored)).iter().zip(&expected) {
        let (a, b) = (a.total, b.total);
        assert!(a.agrees_with(b.mean, b.standard_error, 3), "{a:?} {b:?}");
    }
    let paths = sensors(Estimator::Path, 1 << 16);
    let paths = luminance(&mixed, &rays, &paths, &go_on).expect("runs").results;
    for (a, b) in survey(&mixed, Weighting::of(&mixed)).iter().zip(&paths) {
        let (a, b) = (a.total, b.total);
        assert!(a.agrees_with(b.mean, b.standard_error, 3), "{a:?} {b:?}");
        assert!(a.mean > 0.0 && a.relative_error() <= 0.02, "{a:?}");
    }
    // The picture of one pixel about the last ray sees the same.
    let view = Camera::perspective(eye, eye + rays[2].direction, 1e-4, [1, 1]).expect("valid");
    let pixel = film(&mixed, &view, Estimator::Local(Weighting::of(&mixed)), 2048);
    let (mean, standard_error) = pixel.mean();
    let probed = survey(&mixed, Weighting::of(&mixed))[2].total;
    assert!(probed.agrees_with(mean, standard_error, 1), "{probed:?} {mean} {standard_error}");
}

/// Rooms with a point lamp before a mirror, and with the lamp that one sees in it.
fn lamp_before_a_mirror() -> [Scene; 2] {
    let lamp = |x: f64| PointLight::isotropic("lamp", DVec3::new(x, 1.5, 2.2), Rgb::grey(100.0));
    let walls = |far: Material| [grey(0.3), far, grey(0.6), grey(0.5), grey(0.4), grey(0.7)];
    let mirrored = room(DVec3::new(4.0, 5.0, 3.0), &walls(mirror()));
    let built = room(DVec3::new(8.0, 5.0, 3.0), &walls(grey(0.3)));
    [
        Scene::new(vec![mirrored], vec![lamp(1.0)]).expect("valid"),
        Scene::new(vec![built], vec![lamp(1.0), lamp(7.0)]).expect("valid"),
    ]
}

#[test]
fn walks_show_the_light_of_a_point_in_a_mirror() {
    let [mirrored, built] = lamp_before_a_mirror();
    // Away from the mirror, which would show places that no strategy lights, and from edges, where
    // the variance of either strategy alone has no bound.
    let from = DVec3::new(3.8, 2.5, 1.5);
    let to = DVec3::new(0.0, 2.6, 1.3);
    for view in [
        Camera::perspective(from, to, 20.0_f64.to_radians(), [16, 12]).expect("valid"),
        Camera::orthographic(from, to, 2.0, [16, 12]).expect("valid"),
    ] {
        let expected = film(&built, &view, Estimator::Local(Weighting::of(&built)), 512);
        for weighting in [Weighting::of(&mirrored), Weighting::Walk, Weighting::Gather] {
            let seen = film(&mirrored, &view, Estimator::Local(weighting), 1024);
            assert_alike(&seen, &expected);
        }
    }
}

#[test]
fn light_that_no_ray_finds_is_told() {
    let [mirrored, built] = lamp_before_a_mirror();
    let point = [Sensor::plane(DVec3::new(1.0, 1.0, 0.0), DVec3::Z)];
    let settings = sensors(Estimator::Local(Weighting::Walk), 64);
    let share = |scene| illuminance(scene, &point, &settings, &go_on).expect("runs").caustic;
    assert!(share(&built) <= 0.0);
    // The part of all directions in which the lamp sees the mirror, and less than a third of it
    // again for what goes to and fro.
    let straight: f64 = [(1.5, 2.2), (1.5, 0.8), (3.5, 2.2), (3.5, 0.8)]
        .map(|(a, b): (f64, f64)| {
            (a * b / (3.0 * (a * a + b * b + 9.0).sqrt())).atan() / (4.0 * PI)
        })
        .iter()
        .sum();
    let found = share(&mirrored);
    assert!((0.98..1.33).contains(&(found / straight)), "{found} {straight}");
}
