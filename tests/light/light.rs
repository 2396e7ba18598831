//! The estimators against exact answers: furnace, Sobolev's planes, the cube of CIE 171; their
//! statistics and reproducibility.
//!
//! Statistical comparisons use fixed seeds and judge all values of a test together with a
//! false-alarm rate of 1e-3 (`Estimate::agrees_with`).

use std::f64::consts::PI;

use crate::common::films::{assert_alike, assert_each, assert_flat};
use crate::common::{
    bumpy, camera, furnace, go_on, grey, image, placed, room, sensors, sphere_mesh,
};
use glam::{DVec2, DVec3};
use harmolux::estimators::{
    Ending, Estimator, ImageSettings, Stop, Weighting, illuminance, luminance, render,
};
use harmolux::exact::{Cube, Plane as SobolevPlane, SobolevProblem};
use harmolux::math::{Randomness, Ray, Rgb};
use harmolux::scene::{
    Distribution, Filter, Glossy, Material, Measure, Object, PointLight, Scene, Sensor,
};
use harmolux::sh::Coefficients;
use harmolux::surface::primitives::{Plane, Sphere};
use harmolux::surface::{Intersector, MeshSurface, ShSurface};

/// Furnace scenes: a closed room around an object, everything emitting pi L0 (1 - rho), all
/// reflectances different.
fn furnace_scene(l0: f64, object: fn(f64) -> Object) -> Scene {
    let walls = [0.5, 0.6, 0.2, 0.7, 0.3, 0.8].map(|rho| furnace(rho, l0));
    let room = room(DVec3::new(4.0, 5.0, 3.0), &walls);
    Scene::new(vec![room, object(l0)], vec![]).expect("a valid scene")
}

fn sphere_object(l0: f64) -> Object {
    let sphere = Sphere::new(DVec3::new(2.0, 2.5, 1.2), 0.8).expect("valid");
    Object::new("sphere", sphere, furnace(0.45, l0))
}

fn sh_object(l0: f64) -> Object {
    Object::new("sh", placed(bumpy(), DVec3::new(2.0, 2.5, 1.2), 0.7), furnace(0.45, l0))
}

fn check_furnace(object: fn(f64) -> Object) {
    let l0 = 100.0;
    let scene = furnace_scene(l0, object);
    let view = camera(DVec3::new(0.5, 0.4, 2.5), DVec3::new(2.0, 2.5, 1.2), [32, 32]);
    for estimator in [Estimator::Local(Weighting::of(&scene)), Estimator::Path] {
        let rendering = render(&scene, &view, &image(estimator, 256), &go_on).expect("renders");
        assert_eq!(rendering.film.non_finite(), 0);
        assert!(rendering.escaped <= 0.0, "a closed room leaks");
        assert_flat(&rendering.film, l0);
    }
    let points = [
        Sensor::plane(DVec3::new(1.0, 1.0, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(0.0, 2.0, 1.0), DVec3::X),
        Sensor::plane(DVec3::new(0.01, 0.01, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(3.0, 1.0, 1.7), DVec3::new(0.6, 0.0, -0.8)),
    ];
    for estimator in [Estimator::Local(Weighting::of(&scene)), Estimator::Path] {
        let survey = illuminance(&scene, &points, &sensors(estimator, 4096), &go_on).expect("runs");
        for (i, r) in survey.results.iter().enumerate() {
            assert!(r.total.agrees_with(PI * l0, 0.0, points.len()), "sensor {i}: {:?}", r.total);
            assert!(r.total.relative_error() <= 0.02, "{:?}", r.total);
        }
    }
}

#[test]
fn furnace_with_a_sphere() {
    check_furnace(sphere_object);
}

/// The bumpy body of the SH object, cut out of 8192 triangles.
fn mesh_object(l0: f64) -> Object {
    let body = bumpy();
    let mesh = sphere_mesh(5, |w| w * body.body().series().value(w));
    let surface = MeshSurface::new(mesh).expect("valid");
    Object::new("mesh", placed(surface, DVec3::new(2.0, 2.5, 1.2), 0.7), furnace(0.45, l0))
}

#[test]
fn furnace_with_a_mesh() {
    check_furnace(mesh_object);
}

#[test]
fn furnace_with_an_sh_object() {
    check_furnace(sh_object);
}

/// A body that absorbs and emits nothing.
fn lossless_object(surface: Glossy) -> Object {
    let body = placed(bumpy(), DVec3::new(2.0, 2.5, 1.2), 0.7);
    Object::new("lossless", body, Material::glossy(surface))
}

fn white() -> Rgb {
    Rgb::grey(1.0 - 1e-9)
}

#[test]
fn furnace_with_a_rough_metal() {
    check_furnace(|_| lossless_object(Glossy::metal(white(), 0.5).expect("valid")));
}

#[test]
fn furnace_with_a_coat() {
    check_furnace(|_| lossless_object(Glossy::coated(white(), 1.5, 0.3).expect("valid")));
}

#[test]
fn glossy_bodies_look_and_light_the_same_by_both_estimators() {
    let gold = Glossy::metal(Rgb([0.9, 0.7, 0.4]), 0.35).expect("valid");
    let glaze = Glossy::coated(Rgb([0.2, 0.3, 0.6]), 1.5, 0.2).expect("valid");
    let body = placed(bumpy(), DVec3::new(1.3, 2.5, 1.0), 0.7);
    let ball = Sphere::new(DVec3::new(2.9, 3.0, 0.9), 0.6).expect("valid");
    let varnish = Material::glossy(Glossy::coated(Rgb::grey(0.4), 1.5, 0.4).expect("valid"));
    let walls = [grey(0.5), grey(0.5), grey(0.5), grey(0.5), varnish, grey(0.7)];
    let objects = vec![
        room(DVec3::new(4.0, 5.0, 3.0), &walls),
        Object::new("gold", body, Material::glossy(gold)),
        Object::new("glazed", ball, Material::glossy(glaze)),
    ];
    let lamp = PointLight::isotropic("lamp", DVec3::new(2.0, 1.5, 2.5), Rgb::grey(100.0));
    let scene = Scene::new(objects, vec![lamp]).expect("a valid scene");
    let local = Weighting::of(&scene);
    let points = [
        Sensor::plane(DVec3::new(1.0, 1.0, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(2.1, 2.6, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(0.0, 2.5, 1.0), DVec3::X),
        Sensor::plane(DVec3::new(0.01, 0.01, 0.0), DVec3::Z),
    ];
    let survey = |estimator, walks| {
        illuminance(&scene, &points, &sensors(estimator, walks), &go_on).expect("runs").results
    };
    let by_walks = survey(Estimator::Local(local), 16_384);
    let by_paths = survey(Estimator::Path, 65_536);
    for (i, (a, b)) in by_walks.iter().zip(&by_paths).enumerate() {
        let (a, b) = (a.total, b.total);
        assert!(a.agrees_with(b.mean, b.standard_error, points.len()), "{i}: {a:?} {b:?}");
        assert!(a.relative_error().hypot(b.relative_error()) <= 0.015, "{i}: {a:?} {b:?}");
    }
    let view = camera(DVec3::new(2.0, 0.4, 1.6), DVec3::new(2.0, 2.8, 0.9), [32, 24]);
    let film = |estimator, walks| {
        render(&scene, &view, &image(estimator, walks), &go_on).expect("renders").film
    };
    let by_walks = film(Estimator::Local(local), 512);
    let by_paths = film(Estimator::Path, 2048);
    assert_alike(&by_walks, &by_paths);
}

fn sobolev() -> (Scene, SobolevProblem) {
    let plane = |z: f64, n: DVec3| Plane::new(z * DVec3::Z, n).expect("valid");
    let object = |name: &str, surface: Plane| Object {
        name: name.to_owned(),
        surface: std::sync::Arc::new(surface),
        area: None,
        materials: vec![grey(0.5)],
    };
    let objects =
        vec![object("floor", plane(0.0, DVec3::Z)), object("ceiling", plane(1.0, DVec3::NEG_Z))];
    let lamp = PointLight::isotropic("lamp", DVec3::new(0.0, 0.0, 0.5), Rgb::WHITE);
    let exact = SobolevProblem::default();
    (Scene::new(objects, vec![lamp]).expect("valid"), exact)
}

const SOBOLEV_RADII: [f64; 10] = [0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 10.0];

#[test]
fn sobolev_case_a_at_ten_radii() {
    let (scene, exact) = sobolev();
    let points = SOBOLEV_RADII.map(|r| Sensor::plane(DVec3::new(r, 0.0, 0.0), DVec3::Z));
    // Ten gaps from the source only one walk in some hundred comes near: the interval needs many of
    // them.
    for (estimator, walks) in
        [(Estimator::Local(Weighting::Walk), 1 << 18), (Estimator::Path, 1 << 18)]
    {
        let survey =
            illuminance(&scene, &points, &sensors(estimator, walks), &go_on).expect("runs");
        for (r, result) in SOBOLEV_RADII.iter().zip(&survey.results) {
            let reference = exact.illuminance(SobolevPlane::Lower, *r).expect("valid radius");
            let direct = exact.direct(SobolevPlane::Lower, *r).expect("valid radius");
            assert!((result.direct.mean - direct).abs() <= 1e-12 * direct, "direct at {r}");
            assert!(
                result.total.agrees_with(reference, 0.0, SOBOLEV_RADII.len()),
                "r = {r}: {:?} against {reference}",
                result.total
            );
        }
        let at_source = survey.results[0].total;
        assert!(at_source.relative_error() <= 1e-3, "{at_source:?}");
    }
}

#[test]
fn cylinders_measure_what_their_formulas_say() {
    let at = DVec3::new(1.0, 2.0, 1.2);
    let facing = DVec3::Y;
    let points = [Measure::Cylinder, Measure::SemiCylinder { facing }]
        .map(|measure| Sensor { measure, ..Sensor::plane(at, DVec3::Z) });
    let size = DVec3::new(4.0, 5.0, 3.0);
    // A furnace of luminance 30: pi L whatever is lit.
    let glow = Scene::new(vec![room(size, &[(); 6].map(|()| furnace(0.5, 30.0)))], Vec::new())
        .expect("valid");
    // A lamp 2 m towards +y and 1 m up: E = I sin / (pi d^2), and twice that of the half that faces
    // it.
    let lamp = PointLight::isotropic("lamp", at + DVec3::new(0.0, 2.0, 1.0), Rgb::grey(100.0));
    let lit =
        Scene::new(vec![room(size, &[(); 6].map(|()| grey(0.6)))], vec![lamp]).expect("valid");
    let direct = 100.0 * (2.0 / 5.0_f64.sqrt()) / (PI * 5.0);
    let estimators = [Estimator::Local(Weighting::of(&lit)), Estimator::Path];
    let survey = |scene: &Scene, estimator| {
        illuminance(scene, &points, &sensors(estimator, 1 << 14), &go_on).expect("runs").results
    };
    for estimator in estimators {
        for found in survey(&glow, estimator) {
            assert!(found.total.agrees_with(PI * 30.0, 0.0, 2), "{estimator:?}: {found:?}");
        }
    }
    let [local, path] = estimators.map(|estimator| survey(&lit, estimator));
    for (i, (a, b)) in local.iter().zip(&path).enumerate() {
        assert!(a.total.agrees_with(b.total.mean, b.total.standard_error, 2), "{a:?} {b:?}");
        assert!((a.direct.mean - [1.0, 2.0][i] * direct).abs() <= 1e-9, "{a:?} {direct}");
    }
}

#[test]
fn luminance_along_rays_is_that_of_sobolevs_planes() {
    let (scene, exact) = sobolev();
    // Down to the floor aslant, from beside the source, up to the ceiling; the last leaves between
    // the planes.
    let radii = [0.0, 0.5, 1.0, 2.0];
    let eye = DVec3::new(-0.7, 0.3, 0.4);
    let mut rays: Vec<Ray> = radii
        .map(|r| Ray::between(eye, DVec3::new(r, 0.0, 0.0)).expect("distinct").up_to(f64::INFINITY))
        .to_vec();
    rays.push(Ray::new(eye, DVec3::X));
    for (estimator, walks) in
        [(Estimator::Local(Weighting::of(&scene)), 1 << 15), (Estimator::Path, 1 << 16)]
    {
        let survey = luminance(&scene, &rays, &sensors(estimator, walks), &go_on).expect("runs");
        for (r, found) in radii.iter().zip(&survey.results) {
            let reference = exact.luminance(SobolevPlane::Lower, *r).expect("valid radius");
            assert!(found.total.agrees_with(reference, 0.0, radii.len()), "{r}: {found:?}");
        }
        assert_eq!(survey.results[4].total.mean, 0.0);
    }
}

#[test]
fn every_pixel_of_sobolevs_floor_is_rho_e_over_pi() {
    let (scene, exact) = sobolev();
    let view = camera(DVec3::new(0.9, 0.4, 0.95), DVec3::new(0.3, 0.1, 0.0), [20, 15]);
    // The exact luminance on a fine line, and between its points by straight lines: good to 1e-4.
    let step = 0.01;
    let table: Vec<f64> = (0..400)
        .map(|i| exact.luminance(SobolevPlane::Lower, step * f64::from(i)).expect("valid radius"))
        .collect();
    let at = |r: f64| {
        let (i, t) = ((r / step) as usize, (r / step).fract());
        table[i] * (1.0 - t) + table[i + 1] * t
    };
    // The mean over the square of a pixel, by 8 x 8 of its points.
    let expected = |pixel: usize| -> f64 {
        let corner = DVec2::new((pixel % 20) as f64, (pixel / 20) as f64);
        let points = (0..64).map(|k| DVec2::new(f64::from(k % 8) + 0.5, f64::from(k / 8) + 0.5));
        let seen = points.map(|p| {
            let ray = view.ray(corner + p / 8.0).expect("all of the film sees");
            let point = ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
            at(point.truncate().length())
        });
        seen.sum::<f64>() / 64.0
    };
    for estimator in [Estimator::Local(Weighting::of(&scene)), Estimator::Path] {
        let settings = ImageSettings { filter: Filter::Box, ..image(estimator, 2048) };
        let film = render(&scene, &view, &settings, &go_on).expect("renders").film;
        assert_each(&film, expected);
        assert!(film.median_relative_error().is_some_and(|e| e <= 0.02));
    }
}

#[test]
fn spots_and_flat_lamps_shed_the_light_of_their_intensity() {
    let at = DVec3::new(1.0, 2.0, 2.5);
    let axis = DVec3::new(0.6, 0.0, -0.8);
    let cosine = |degrees: f64| degrees.to_radians().cos();
    let spot = Distribution::Spot { axis, inner: cosine(20.0), outer: cosine(35.0) };
    let points = [(1.0, 2.0), (2.875, 2.0), (2.875, 4.9), (3.9, 0.1)]
        .map(|(x, y)| Sensor::plane(DVec3::new(x, y, 0.0), DVec3::Z));
    for distribution in [spot, Distribution::Lambert { axis }] {
        let intensity = Rgb::grey(100.0);
        let lamp = PointLight { name: "lamp".into(), at, intensity, distribution };
        let walls = room(DVec3::new(4.0, 5.0, 3.0), &[(); 6].map(|()| grey(0.6)));
        let scene = Scene::new(vec![walls], vec![lamp]).expect("valid");
        let survey = |estimator, walks| {
            illuminance(&scene, &points, &sensors(estimator, walks), &go_on).expect("runs").results
        };
        let local = survey(Estimator::Local(Weighting::of(&scene)), 1 << 14);
        let path = survey(Estimator::Path, 1 << 15);
        for (i, (a, b)) in local.iter().zip(&path).enumerate() {
            assert!(
                a.total.agrees_with(b.total.mean, b.total.standard_error, points.len()),
                "{distribution:?}, sensor {i}: {a:?} {b:?}"
            );
        }
        // Where the axis meets the floor: E = I cos / d^2 with cos 0.8 and d = 2.5 / 0.8.
        assert!((local[1].direct.mean - 100.0 * 0.8 * 0.8 * 0.8 / 6.25).abs() <= 1e-9, "{local:?}");
    }
}

#[test]
fn cube_of_cie_171_at_seven_floor_points() {
    let half = 2.0;
    let cube = room(DVec3::splat(2.0 * half), &[(); 6].map(|()| grey(0.5)));
    let intensity = Rgb::grey(10_000.0 / (4.0 * PI));
    let lamp = PointLight::isotropic("lamp", DVec3::splat(half), intensity);
    let scene = Scene::new(vec![cube], vec![lamp]).expect("valid");
    let offsets =
        [(0.0, 0.0), (0.5, 0.5), (1.0, 0.0), (1.0, 1.0), (1.5, 1.5), (1.9, 1.9), (1.99, 1.99)];
    let points = offsets.map(|(x, y)| Sensor::plane(DVec3::new(half + x, half + y, 0.0), DVec3::Z));
    let exact =
        Cube { edge: 2.0 * half, flux: 10_000.0, reflectance: 0.5 }.solve().expect("solves");
    for (estimator, walks) in
        [(Estimator::Local(Weighting::of(&scene)), 1 << 14), (Estimator::Path, 1 << 14)]
    {
        let survey =
            illuminance(&scene, &points, &sensors(estimator, walks), &go_on).expect("runs");
        for ((x, y), result) in offsets.iter().zip(&survey.results) {
            let reference = exact.illuminance(*x, *y).expect("on the floor");
            // The reference itself is a numerical solution good to 1e-5.
            assert!(
                result.total.agrees_with(reference, 1e-5 * reference, offsets.len()),
                "({x}, {y}): {:?} against {reference}",
                result.total
            );
            assert!(result.total.relative_error() <= 0.005, "({x}, {y}): {:?}", result.total);
        }
    }
}

#[test]
fn error_falls_with_the_number_of_walks() {
    let (scene, _) = sobolev();
    let points = [0.5, 1.0, 2.0].map(|r| Sensor::plane(DVec3::new(r, 0.0, 0.0), DVec3::Z));
    let error = |randomness, walks| {
        let settings = harmolux::estimators::SensorSettings {
            randomness,
            ..sensors(Estimator::Local(Weighting::Walk), walks)
        };
        let survey = illuminance(&scene, &points, &settings, &go_on).expect("runs");
        let sum: f64 = survey.results.iter().map(|r| r.total.standard_error.powi(2)).sum();
        sum.sqrt()
    };
    let plain = error(Randomness::Pseudorandom, 1 << 10) / error(Randomness::Pseudorandom, 1 << 14);
    // 16 times the walks: 4 times the accuracy; a ratio of two errors from 32 replicates each
    // scatters by some 20 %.
    assert!((2.4..=6.5).contains(&plain), "plain random numbers: {plain}");
    let sobol = error(Randomness::Sobol, 1 << 10) / error(Randomness::Sobol, 1 << 14);
    assert!(sobol >= 4.0, "Sobol points should do better than 4: {sobol}");
    assert!(error(Randomness::Sobol, 1 << 12) <= 0.5 * error(Randomness::Pseudorandom, 1 << 12));
}

/// A sensor whose normal lies in a surface is on the front of it: all walls count in corners, and a
/// body hides the half of space it fills.
#[test]
fn sensors_in_surfaces_see_what_is_before_them() {
    let black = grey(0.0);
    let cylinder = |x, y, z| Sensor {
        measure: Measure::Cylinder,
        ..Sensor::plane(DVec3::new(x, y, z), DVec3::Z)
    };
    let plane = |x, y, z| Sensor::plane(DVec3::new(x, y, z), DVec3::Z);
    let in_walls = [
        (plane(0.0, 0.0, 0.0), 1.0),
        (plane(4.0, 1.3, 0.0), 1.0),
        (cylinder(0.0, 4.0, 2.0), 1.0),
        (cylinder(0.0, 1.0, 2.0), 1.0),
    ];
    let on_balls = [(plane(3.0, 2.0, 2.0), 0.5), (cylinder(2.0, 3.0, 2.0), 0.5)];
    let sphere = Sphere::new(DVec3::splat(2.0), 1.0).expect("valid");
    let mut series = Coefficients::zeros(0);
    series.set(0, 0, 1.0, 0.0);
    let series = ShSurface::new(&series, Intersector::Certified).expect("a positive radius");
    let series = placed(series, DVec3::splat(2.0), 1.0);
    for (ball, points) in [
        (None, &in_walls[..]),
        (Some(Object::new("ball", sphere, black.clone())), &on_balls[..]),
        (Some(Object::new("ball", series, black.clone())), &on_balls[..]),
    ] {
        let walls = room(DVec3::splat(4.0), &[(); 6].map(|()| black.clone().emitting(Rgb::WHITE)));
        let scene = Scene::new(std::iter::once(walls).chain(ball).collect(), vec![]);
        let scene = scene.expect("valid");
        let at: Vec<Sensor> = points.iter().map(|(sensor, _)| *sensor).collect();
        for by in [Estimator::Local(Weighting::of(&scene)), Estimator::Path] {
            let survey = illuminance(&scene, &at, &sensors(by, 1 << 13), &go_on).expect("runs");
            for ((sensor, expected), found) in points.iter().zip(&survey.results) {
                let agrees = found.total.agrees_with(*expected, 1e-6, 6);
                assert!(agrees, "{} {:?}: {found:?}", sensor.at, sensor.measure);
            }
        }
    }
}

#[test]
fn bounded_kernel_tames_the_corner_without_bias() {
    let cube = room(DVec3::splat(2.0), &[(); 6].map(|()| grey(0.5)));
    let lamp = PointLight::isotropic("lamp", DVec3::ONE, Rgb::grey(100.0));
    let scene = Scene::new(vec![cube], vec![lamp]).expect("valid");
    let corner = [Sensor::plane(DVec3::new(0.01, 0.01, 0.0), DVec3::Z)];
    let run = |weighting, walks| {
        let settings = sensors(Estimator::Local(weighting), walks);
        illuminance(&scene, &corner, &settings, &go_on).expect("runs").results[0].total
    };
    let bounded = run(Weighting::of(&scene), 1 << 13);
    let plain = run(Weighting::Walk, 1 << 13);
    // The plain estimate's error is itself understated: its rare, large contributions are mostly
    // not in the sample.
    assert!(bounded.standard_error <= 0.25 * plain.standard_error, "{bounded:?} against {plain:?}");
    let tracer = illuminance(&scene, &corner, &sensors(Estimator::Path, 1 << 15), &go_on)
        .expect("runs")
        .results[0]
        .total;
    assert!(
        bounded.agrees_with(tracer.mean, tracer.standard_error, 1),
        "{bounded:?} against {tracer:?}"
    );
}

#[test]
fn same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let scene = furnace_scene(10.0, sh_object);
    let view = camera(DVec3::new(0.5, 0.4, 2.5), DVec3::new(2.0, 2.5, 1.2), [16, 12]);
    let settings = image(Estimator::Local(Weighting::of(&scene)), 16);
    let points = [Sensor::plane(DVec3::new(1.0, 1.0, 0.0), DVec3::Z)];
    let survey = sensors(Estimator::Local(Weighting::of(&scene)), 512);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let film = render(&scene, &view, &settings, &go_on).expect("renders").film;
            let lux =
                illuminance(&scene, &points, &survey, &go_on).expect("runs").results[0].total.mean;
            let bits: Vec<u64> = film
                .image()
                .iter()
                .flat_map(|p| p.0.map(f64::to_bits))
                .chain([lux.to_bits()])
                .collect();
            (bits, film.standard_errors().iter().map(|e| e.to_bits()).collect::<Vec<_>>())
        })
    };
    let one = run(1);
    assert!(one == run(2) && one == run(3));
}

#[test]
fn runs_end_on_error_walks_time_and_interruption() {
    let (scene, _) = sobolev();
    let points = [Sensor::plane(DVec3::X, DVec3::Z)];
    let run = |stop, observer: harmolux::estimators::Observer| {
        let settings = harmolux::estimators::SensorSettings {
            stop,
            ..sensors(Estimator::Local(Weighting::Walk), 1)
        };
        illuminance(&scene, &points, &settings, observer).expect("runs")
    };
    let error = run(Stop { relative_error: Some(0.01), ..Stop::default() }, &go_on);
    assert_eq!(error.ending, Ending::Error);
    assert!(error.results[0].total.relative_half_width() <= 0.01);
    let time = run(Stop { time: Some(std::time::Duration::ZERO), ..Stop::default() }, &go_on);
    assert_eq!(time.ending, Ending::Time);
    let walks = run(Stop { walks: Some(1000), ..Stop::default() }, &go_on);
    assert_eq!((walks.ending, walks.walks), (Ending::Walks, 1024));
    let broken =
        run(
            Stop { walks: Some(1 << 30), ..Stop::default() },
            &|_| std::ops::ControlFlow::Break(()),
        );
    assert_eq!(broken.ending, Ending::Interrupted);
}

#[test]
fn a_scene_without_light_is_refused() {
    let scene =
        Scene::new(vec![room(DVec3::ONE, &[(); 6].map(|()| grey(0.5)))], vec![]).expect("valid");
    let refused = illuminance(&scene, &[], &sensors(Estimator::Path, 32), &go_on);
    assert!(refused.is_err_and(|e| e.to_string().contains("no light")));
}

/// A panel under the ceiling of a room, and a table that hides it from a part of the floor.
fn panel_scene(with_table: bool) -> Scene {
    use harmolux::surface::primitives::Rectangle;
    let black = || grey(0.0);
    let room = room(DVec3::new(4.0, 4.0, 3.0), &[(); 6].map(|()| black()));
    let panel = Rectangle::new(DVec3::new(1.5, 1.5, 2.999), DVec3::Y, DVec3::X).expect("valid");
    let panel = Object::new("panel", panel, black().emitting(Rgb::grey(1000.0 * PI)));
    let mut objects = vec![room, panel];
    if with_table {
        let low = DVec3::new(0.5, 1.0, 1.0);
        let table = Rectangle::new(low, DVec3::X * 1.5, DVec3::Y * 1.5).expect("valid");
        objects.push(Object::new("table", table, black()));
    }
    Scene::new(objects, vec![]).expect("a valid scene")
}

#[test]
fn flat_lights_are_exact_where_nothing_hides_them() {
    // Case 5.3 of CIE 171 to 1e-6: E = pi L C by the contour formula of `exact`, with the panel a
    // millimetre below the ceiling.
    let scene = panel_scene(false);
    let points = [
        Sensor::plane(DVec3::new(2.0, 0.25, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(2.0, 1.75, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(2.0, 0.0, 1.75), DVec3::Y),
        Sensor::plane(DVec3::new(0.3, 2.0, 2.9), DVec3::X),
    ];
    let settings = sensors(Estimator::Local(Weighting::of(&scene)), 128);
    let survey = illuminance(&scene, &points, &settings, &go_on).expect("runs");
    let corners = [[1.5, 1.5], [2.5, 1.5], [2.5, 2.5], [1.5, 2.5]];
    let corners = corners.map(|[x, y]| DVec3::new(x, y, 2.999));
    for (sensor, result) in points.iter().zip(&survey.results) {
        let exact = 1000.0 * PI * polygon(&corners, sensor.at, sensor.normal).abs();
        let total = result.total;
        assert!((total.mean - exact).abs() <= 1e-9 * exact, "{total:?} {exact}");
        assert!(total.standard_error <= 1e-12 * exact, "{total:?}");
    }
}

/// Lambert's formula by itself, for a polygon wholly above the horizon.
fn polygon(corners: &[DVec3], at: DVec3, normal: DVec3) -> f64 {
    let edge = |i: usize| {
        let (a, b) = (corners[i] - at, corners[(i + 1) % corners.len()] - at);
        let cross = a.cross(b);
        cross.length().atan2(a.dot(b)) * cross.normalize().dot(normal)
    };
    (0..corners.len()).map(edge).sum::<f64>() / (2.0 * PI)
}

#[test]
fn flat_lights_are_unbiased_where_something_hides_them() {
    let scene = panel_scene(true);
    // From full light through the half shadow to the full shadow of the table.
    let points: Vec<Sensor> = (0..8)
        .map(|i| Sensor::plane(DVec3::new(1.2, 0.2 + 0.25 * f64::from(i), 0.0), DVec3::Z))
        .collect();
    let survey = |estimator, walks| {
        illuminance(&scene, &points, &sensors(estimator, walks), &go_on).expect("runs").results
    };
    let by_paths = survey(Estimator::Path, 65_536);
    for weighting in [Weighting::of(&scene), Weighting::Walk] {
        let by_walks = survey(Estimator::Local(weighting), 16_384);
        for (i, (a, b)) in by_walks.iter().zip(&by_paths).enumerate() {
            let (a, b) = (a.total, b.total);
            assert!(a.agrees_with(b.mean, b.standard_error, 2 * points.len()), "{i}: {a:?} {b:?}");
        }
        // Some see all of it, some nothing, and both are exact.
        let exact = |r: &&harmolux::scene::Measured| r.total.standard_error <= 1e-9;
        assert!(by_walks.iter().filter(exact).count() >= 2, "{by_walks:?}");
        assert!(by_walks.iter().filter(exact).count() < points.len());
    }
}
