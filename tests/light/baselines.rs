//! The baselines against exact answers and against the local estimate: photons counted on discs,
//! radiosity with bodies of every kind.
//!
//! Photons measure the mean over their disc. Against that mean they are judged with a false-alarm
//! rate of 1e-3 (`Estimate::agrees_with`); the difference from the centre is their known bias.

use std::f64::consts::{PI, TAU};

use crate::common::{bumpy, go_on, grey, placed, room, sensors};
use glam::DVec3;
use harmolux::estimators::{Ending, Estimator, RadiositySettings, Survey, Weighting, illuminance};
use harmolux::exact::{Cube, Plane as SobolevPlane, SobolevProblem};
use harmolux::math::Rgb;
use harmolux::math::quadrature::Rule;
use harmolux::scene::{Measure, Object, PointLight, Scene, Sensor};
use harmolux::surface::primitives::Plane;

/// The mean of a function over a disc, from its values at the polar coordinates of Gauss's rule
/// (radius) and equal steps (angle).
fn disc_mean(radius: f64, f: impl Fn(f64, f64) -> f64) -> f64 {
    let around = |r: f64| {
        let angles = (0..16).map(|k| TAU * (f64::from(k) + 0.5) / 16.0);
        angles.map(|a| f(r * a.cos(), r * a.sin())).sum::<f64>() / 16.0
    };
    let rule = Rule::gauss_legendre(6).on(0.0, radius);
    rule.integrate(|r| 2.0 * r * around(r)) / (radius * radius)
}

fn cube() -> Scene {
    let lamp = PointLight::isotropic("lamp", DVec3::splat(2.0), Rgb::grey(10_000.0 / (4.0 * PI)));
    Scene::new(vec![room(DVec3::splat(4.0), &[(); 6].map(|()| grey(0.5)))], vec![lamp])
        .expect("valid")
}

fn run(scene: &Scene, points: &[Sensor], estimator: Estimator, walks: u64) -> Survey {
    illuminance(scene, points, &sensors(estimator, walks), &go_on).expect("runs")
}

#[test]
fn photons_measure_the_mean_over_their_disc_in_the_cube() {
    let radius = 0.3;
    let exact = Cube { edge: 4.0, flux: 10_000.0, reflectance: 0.5 }.solve().expect("solves");
    let offsets = [(0.0, 0.0), (0.5, 0.5), (1.0, 0.0), (1.5, 1.5)];
    let points = offsets.map(|(x, y)| Sensor::plane(DVec3::new(2.0 + x, 2.0 + y, 0.0), DVec3::Z));
    let photon = Estimator::Photon { radius: Some(radius) };
    let survey = run(&cube(), &points, photon, 1 << 18);
    for ((x, y), found) in offsets.iter().zip(&survey.results) {
        let value = |u: f64, v: f64| exact.illuminance(x + u, y + v).expect("on the floor");
        let mean = disc_mean(radius, value);
        assert!(found.total.agrees_with(mean, 1e-5 * mean, 4), "({x}, {y}): {found:?} {mean}");
        assert!(found.total.relative_error() <= 0.02, "{found:?}");
        // The known bias: some (r / distance)^2.
        assert!((mean / value(0.0, 0.0) - 1.0).abs() <= 0.03, "{mean}");
    }
    // The corner cuts three quarters of the disc off.
    let corner = [Sensor::plane(DVec3::new(3.99, 3.99, 0.0), DVec3::Z)];
    let found = run(&cube(), &corner, photon, 1 << 16).results[0].total.mean;
    let exact = exact.illuminance(1.99, 1.99).expect("on the floor");
    assert!((0.2..0.4).contains(&(found / exact)), "{found} {exact}");
}

#[test]
fn photons_measure_the_mean_over_their_disc_between_sobolevs_planes() {
    let object = |name: &str, z: f64, n: DVec3| Object {
        name: name.to_owned(),
        surface: std::sync::Arc::new(Plane::new(z * DVec3::Z, n).expect("valid")),
        area: None,
        materials: vec![grey(0.5)],
    };
    let objects = vec![object("floor", 0.0, DVec3::Z), object("ceiling", 1.0, DVec3::NEG_Z)];
    let lamp = PointLight::isotropic("lamp", DVec3::new(0.0, 0.0, 0.5), Rgb::WHITE);
    let scene = Scene::new(objects, vec![lamp]).expect("valid");
    let exact = SobolevProblem::default();
    let (radius, radii) = (0.1, [0.0, 0.5, 1.0]);
    let points = radii.map(|r| Sensor::plane(DVec3::new(r, 0.0, 0.0), DVec3::Z));
    let survey = run(&scene, &points, Estimator::Photon { radius: Some(radius) }, 1 << 19);
    for (r, found) in radii.iter().zip(&survey.results) {
        let mean = disc_mean(radius, |x, y| {
            exact.illuminance(SobolevPlane::Lower, (r + x).hypot(y)).expect("valid radius")
        });
        assert!(found.total.agrees_with(mean, 0.0, 3), "{r}: {found:?} {mean}");
        let direct = disc_mean(radius, |x, y| {
            exact.direct(SobolevPlane::Lower, (r + x).hypot(y)).expect("valid radius")
        });
        // Straight below the source Sobol points give each of the 2^14 walks' replicates the same
        // whole number of photons.
        let photon = 4.0 * PI / (f64::from(1 << 14) * PI * radius * radius);
        assert!(found.direct.agrees_with(direct, 0.5 * photon, 3), "{r}: {found:?} {direct}");
    }
    let unset = Estimator::Photon { radius: None };
    let refused = illuminance(&scene, &points, &sensors(unset, 32), &go_on);
    assert!(refused.is_err_and(|e| e.to_string().contains("set `radius`")));
    let cylinder = [Sensor { measure: Measure::Cylinder, ..points[0] }];
    let photon = Estimator::Photon { radius: Some(radius) };
    let refused = illuminance(&scene, &cylinder, &sensors(photon, 32), &go_on);
    assert!(refused.is_err_and(|e| e.to_string().contains("on planes only")));
}

#[test]
fn radiosity_and_the_local_estimate_agree_about_a_room_with_a_body() {
    let walls = room(DVec3::new(4.0, 5.0, 3.0), &[0.5, 0.6, 0.2, 0.7, 0.3, 0.8].map(grey));
    let body = Object::new("body", placed(bumpy(), DVec3::new(2.0, 2.5, 1.2), 0.7), grey(0.45));
    let lamp = PointLight::isotropic("lamp", DVec3::new(0.9, 1.6, 2.6), Rgb::grey(100.0));
    let scene = Scene::new(vec![walls, body], vec![lamp]).expect("valid");
    let points = [
        Sensor::plane(DVec3::new(1.0, 1.0, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(2.6, 3.2, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(4.0, 2.0, 1.0), DVec3::NEG_X),
        Sensor::plane(DVec3::new(3.0, 1.0, 1.7), DVec3::new(0.6, 0.0, -0.8)),
        Sensor { measure: Measure::Cylinder, ..Sensor::plane(DVec3::new(3.0, 4.0, 1.0), DVec3::Z) },
    ];
    let local = run(&scene, &points, Estimator::Local(Weighting::of(&scene)), 1 << 14);
    let settings = RadiositySettings { patches: 1000, ..RadiositySettings::default() };
    let radiosity = run(&scene, &points, Estimator::Radiosity(settings), 1);
    assert_eq!(radiosity.ending, Ending::Converged);
    for (i, (a, b)) in radiosity.results.iter().zip(&local.results).enumerate() {
        // Direct light is the same in both; the patches cost a per cent or so.
        assert!((a.direct.mean - b.direct.mean).abs() <= 1e-9 * b.direct.mean, "{i}: {a:?} {b:?}");
        let error = (a.total.mean / b.total.mean - 1.0).abs();
        assert!(error <= 0.02 + 4.0 * b.total.relative_error(), "{i}: {a:?} {b:?}");
    }
}
