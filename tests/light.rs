//! The estimators against exact answers: furnace, Sobolev's planes, the cube of CIE 171; their statistics and reproducibility.
//!
//! Statistical comparisons use fixed seeds and judge all values of a test together with a false-alarm rate of 1e-3 (`Estimate::agrees_with`).

mod common;

use std::f64::consts::PI;

use common::{bumpy, camera, furnace, go_on, grey, image, placed, room, sensors, sphere_mesh};
use glam::DVec3;
use harmolux::estimators::{
    Ending, Estimator, SensorEstimator, Stop, Weighting, illuminance, luminance, render,
};
use harmolux::exact::{Cube, Plane as SobolevPlane, SobolevProblem};
use harmolux::math::stats::Estimate;
use harmolux::math::{Randomness, Ray, Rgb};
use harmolux::scene::{Distribution, Film, Measure, Object, PointLight, Scene, Sensor};
use harmolux::surface::MeshSurface;
use harmolux::surface::primitives::{Plane, Sphere};

/// Judges every pixel against one luminance, and the image mean.
fn assert_flat(film: &Film, expected: f64) {
    let n = film.size()[0] * film.size()[1];
    let values = film.image().into_iter().zip(film.standard_errors());
    for (i, (pixel, se)) in values.enumerate() {
        let estimate =
            Estimate { mean: pixel.luminance(), standard_error: se, replicates: film.replicates() };
        assert!(estimate.agrees_with(expected, 0.0, n + 1), "pixel {i}: {estimate:?}");
    }
    let (mean, standard_error) = film.mean();
    let mean = Estimate { mean, standard_error, replicates: film.replicates() };
    // Replicate sums are kept in f32: 1e-7 of the value.
    assert!(
        (mean.mean - expected).abs() <= 6.0 * standard_error + 1e-6 * expected,
        "mean {mean:?}"
    );
    assert!(standard_error <= 0.01 * expected, "too noisy to say anything: {mean:?}");
}

/// Furnace scenes: a closed room around an object, everything emitting pi L0 (1 - rho), all reflectances different.
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
    for estimator in [Estimator::DoubleLocal(Weighting::of(&scene)), Estimator::Path] {
        let rendering = render(&scene, &view, &image(estimator, 256), &go_on).expect("renders");
        assert_eq!(rendering.film.spoilt(), 0);
        assert!(rendering.escaped <= 0.0, "a closed room leaks");
        assert_flat(&rendering.film, l0);
    }
    let points = [
        Sensor::plane(DVec3::new(1.0, 1.0, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(0.0, 2.0, 1.0), DVec3::X),
        Sensor::plane(DVec3::new(0.01, 0.01, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(3.0, 1.0, 1.7), DVec3::new(0.6, 0.0, -0.8)),
    ];
    for estimator in [SensorEstimator::Local(Weighting::of(&scene)), SensorEstimator::Path] {
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
    // Ten gaps from the source only one walk in some hundred comes near: the interval needs many of them.
    for (estimator, walks) in
        [(SensorEstimator::Local(Weighting::Walk), 1 << 18), (SensorEstimator::Path, 1 << 18)]
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
    let glow = Scene::new(vec![room(size, &[furnace(0.5, 30.0); 6])], Vec::new()).expect("valid");
    // A lamp 2 m towards +y and 1 m up: E = I sin / (pi d^2), and twice that of the half that faces it.
    let lamp = PointLight::isotropic("lamp", at + DVec3::new(0.0, 2.0, 1.0), Rgb::grey(100.0));
    let lit = Scene::new(vec![room(size, &[grey(0.6); 6])], vec![lamp]).expect("valid");
    let direct = 100.0 * (2.0 / 5.0_f64.sqrt()) / (PI * 5.0);
    let estimators = [SensorEstimator::Local(Weighting::of(&lit)), SensorEstimator::Path];
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
    // Down to the floor aslant, from beside the source, up to the ceiling; the last leaves between the planes.
    let radii = [0.0, 0.5, 1.0, 2.0];
    let eye = DVec3::new(-0.7, 0.3, 0.4);
    let mut rays: Vec<Ray> = radii
        .map(|r| Ray::between(eye, DVec3::new(r, 0.0, 0.0)).expect("distinct").up_to(f64::INFINITY))
        .to_vec();
    rays.push(Ray::new(eye, DVec3::X));
    for (estimator, walks) in
        [(SensorEstimator::Local(Weighting::of(&scene)), 1 << 15), (SensorEstimator::Path, 1 << 16)]
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
        let walls = room(DVec3::new(4.0, 5.0, 3.0), &[grey(0.6); 6]);
        let scene = Scene::new(vec![walls], vec![lamp]).expect("valid");
        let survey = |estimator, walks| {
            illuminance(&scene, &points, &sensors(estimator, walks), &go_on).expect("runs").results
        };
        let local = survey(SensorEstimator::Local(Weighting::of(&scene)), 1 << 14);
        let path = survey(SensorEstimator::Path, 1 << 15);
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
    let cube = room(DVec3::splat(2.0 * half), &[grey(0.5); 6]);
    let intensity = Rgb::grey(10_000.0 / (4.0 * PI));
    let lamp = PointLight::isotropic("lamp", DVec3::splat(half), intensity);
    let scene = Scene::new(vec![cube], vec![lamp]).expect("valid");
    let offsets =
        [(0.0, 0.0), (0.5, 0.5), (1.0, 0.0), (1.0, 1.0), (1.5, 1.5), (1.9, 1.9), (1.99, 1.99)];
    let points = offsets.map(|(x, y)| Sensor::plane(DVec3::new(half + x, half + y, 0.0), DVec3::Z));
    let exact =
        Cube { edge: 2.0 * half, flux: 10_000.0, reflectance: 0.5 }.solve().expect("solves");
    for (estimator, walks) in
        [(SensorEstimator::Local(Weighting::of(&scene)), 1 << 14), (SensorEstimator::Path, 1 << 14)]
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
            ..sensors(SensorEstimator::Local(Weighting::Walk), walks)
        };
        let survey = illuminance(&scene, &points, &settings, &go_on).expect("runs");
        let sum: f64 = survey.results.iter().map(|r| r.total.standard_error.powi(2)).sum();
        sum.sqrt()
    };
    let plain = error(Randomness::Pseudorandom, 1 << 10) / error(Randomness::Pseudorandom, 1 << 14);
    // 16 times the walks: 4 times the accuracy; a ratio of two errors from 32 replicates each scatters by some 20 %.
    assert!((2.4..=6.5).contains(&plain), "plain random numbers: {plain}");
    let sobol = error(Randomness::Sobol, 1 << 10) / error(Randomness::Sobol, 1 << 14);
    assert!(sobol >= 4.0, "Sobol points should do better than 4: {sobol}");
    assert!(error(Randomness::Sobol, 1 << 12) <= 0.5 * error(Randomness::Pseudorandom, 1 << 12));
}

#[test]
fn bounded_kernel_tames_the_corner_without_bias() {
    let cube = room(DVec3::splat(2.0), &[grey(0.5); 6]);
    let lamp = PointLight::isotropic("lamp", DVec3::ONE, Rgb::grey(100.0));
    let scene = Scene::new(vec![cube], vec![lamp]).expect("valid");
    let corner = [Sensor::plane(DVec3::new(0.01, 0.01, 0.0), DVec3::Z)];
    let run = |weighting, walks| {
        let settings = sensors(SensorEstimator::Local(weighting), walks);
        illuminance(&scene, &corner, &settings, &go_on).expect("runs").results[0].total
    };
    let bounded = run(Weighting::of(&scene), 1 << 13);
    let plain = run(Weighting::Walk, 1 << 13);
    // The plain estimate's error is itself understated: its rare, large contributions are mostly not in the sample.
    assert!(bounded.standard_error <= 0.25 * plain.standard_error, "{bounded:?} against {plain:?}");
    let tracer = illuminance(&scene, &corner, &sensors(SensorEstimator::Path, 1 << 15), &go_on)
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
    let settings = image(Estimator::DoubleLocal(Weighting::of(&scene)), 16);
    let points = [Sensor::plane(DVec3::new(1.0, 1.0, 0.0), DVec3::Z)];
    let survey = sensors(SensorEstimator::Local(Weighting::of(&scene)), 512);
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
            ..sensors(SensorEstimator::Local(Weighting::Walk), 1)
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
    let scene = Scene::new(vec![room(DVec3::ONE, &[grey(0.5); 6])], vec![]).expect("valid");
    let refused = illuminance(&scene, &[], &sensors(SensorEstimator::Path, 32), &go_on);
    assert!(refused.is_err_and(|e| e.to_string().contains("no light")));
}

#[test]
fn double_local_estimate_and_path_tracing_give_the_same_head_room() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes/head_room.toml");
    let file = harmolux::io::scene_file::SceneFile::read(&path, &[]).expect("a valid scene");
    let loaded = harmolux::study::load(&file).expect("loads");
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let view = harmolux::study::camera(&file).expect("a camera").with_resolution([32, 24]);
    let film = |estimator, walks| {
        let film =
            render(&loaded.scene, &view, &image(estimator, walks), &go_on).expect("renders").film;
        assert_eq!(film.spoilt(), 0);
        film
    };
    let local = film(Estimator::DoubleLocal(Weighting::of(&loaded.scene)), 256);
    let path = film(Estimator::Path, 2048);
    let n = 32 * 24;
    let pixels = |film: &Film| -> Vec<Estimate> {
        let values = film.image().into_iter().zip(film.standard_errors());
        values
            .map(|(c, se)| Estimate { mean: c.luminance(), standard_error: se, replicates: 32 })
            .collect()
    };
    for (i, (a, b)) in pixels(&local).iter().zip(pixels(&path)).enumerate() {
        assert!(a.agrees_with(b.mean, b.standard_error, n), "pixel {i}: {a:?} against {b:?}");
    }
    let (a, b) = (local.mean(), path.mean());
    assert!((a.0 - b.0).abs() <= 4.0 * a.1.hypot(b.1), "means {a:?} and {b:?}");
    assert!(a.1.hypot(b.1) <= 0.01 * a.0, "too noisy to say anything: {a:?} {b:?}");
}
