//! Radiosity against exact answers. Nothing here is random: the tolerances are the errors that were found, with a little room.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use glam::DVec3;

use super::*;
use crate::estimators::{Ending, SensorEstimator, SensorSettings, illuminance, luminance};
use crate::exact::{Cube, Plane as ExactPlane, SobolevProblem};
use crate::math::{Randomness, Ray};
use crate::scene::{Material, Measure, Object, PointLight, Sensor};
use crate::surface::primitives::{AxisBox, Disc, Plane, Rectangle, Sphere};
use crate::surface::{MeshSurface, mesh_shapes};

fn grey(reflectance: f64) -> Material {
    Material::lambert(Rgb::grey(reflectance)).expect("valid")
}

fn settings(patches: usize) -> SensorSettings {
    let radiosity = RadiositySettings { patches, ..RadiositySettings::default() };
    SensorSettings {
        estimator: SensorEstimator::Radiosity(radiosity),
        randomness: Randomness::Sobol,
        seed: 1,
        stop: Stop::default(),
    }
}

fn survey(scene: &Scene, sensors: &[Sensor], patches: usize) -> Survey {
    let go_on = |_: &_| ControlFlow::Continue(());
    let survey = illuminance(scene, sensors, &settings(patches), &go_on).expect("runs");
    assert_eq!(survey.ending, Ending::Converged);
    survey
}

fn refusal(scene: &Scene, patches: usize) -> String {
    let go_on = |_: &_| ControlFlow::Continue(());
    illuminance(scene, &[], &settings(patches), &go_on).expect_err("refused").to_string()
}

/// The cube of CIE 171, case 5.8: edge 4 m, 10 000 lm in the middle.
fn cube(reflectance: f64) -> Scene {
    let walls = AxisBox::new(DVec3::splat(-2.0), DVec3::splat(2.0)).expect("valid");
    let room = Object::new("room", walls.turned_inward(true), grey(reflectance));
    let intensity = Rgb::grey(10_000.0 / (4.0 * PI));
    Scene::new(vec![room], vec![PointLight::isotropic("lamp", DVec3::ZERO, intensity)])
        .expect("valid")
}

const ON_FLOOR: [[f64; 2]; 7] =
    [[0.0, 0.0], [0.5, 0.5], [1.0, 0.0], [1.0, 1.0], [1.5, 1.5], [1.9, 1.9], [1.99, 1.99]];

/// The relative errors at seven points of the floor.
fn cube_errors(reflectance: f64, patches: usize) -> Vec<f64> {
    let exact = Cube { edge: 4.0, flux: 10_000.0, reflectance }.solve().expect("solves");
    let sensors = ON_FLOOR.map(|[x, y]| Sensor::plane(DVec3::new(x, y, -2.0), DVec3::Z));
    let survey = survey(&cube(reflectance), &sensors, patches);
    let exchange = survey.radiosity.expect("told");
    eprintln!("cube {reflectance} {patches}: {exchange:?} {:?}", survey.elapsed);
    assert!((exchange.absorbed + exchange.unshot - 1.0).abs() <= 0.02, "{exchange:?}");
    let error = |(r, [x, y]): (&Measured, &[f64; 2])| {
        r.total.mean / exact.illuminance(*x, *y).expect("on the floor") - 1.0
    };
    survey.results.iter().zip(&ON_FLOOR).map(error).collect()
}

#[test]
fn cube_of_cie_171() {
    for reflectance in [0.5, 0.8] {
        for n in [150, 600, 2400] {
            eprintln!("{:.6?}", cube_errors(reflectance, n));
        }
    }
}

#[test]
fn sobolev_discs() {
    for radius in [5.0, 10.0, 20.0] {
        let exact = SobolevProblem::default().discs(radius).expect("solves");
        let disc = |z: f64, n: DVec3| Disc::new(z * DVec3::Z, n, radius).expect("valid");
        let objects = vec![
            Object::new("floor", disc(0.0, DVec3::Z), grey(0.5)),
            Object::new("ceiling", disc(1.0, DVec3::NEG_Z), grey(0.5)),
        ];
        let lamp = PointLight::isotropic("lamp", DVec3::new(0.0, 0.0, 0.5), Rgb::WHITE);
        let scene = Scene::new(objects, vec![lamp]).expect("valid");
        let radii = [0.0, 0.25, 0.5, 1.0, 2.0, 3.0];
        let sensors = radii.map(|r| Sensor::plane(DVec3::new(r, 0.0, 0.0), DVec3::Z));
        for n in [200, 500, 2000, 8000] {
            let survey = survey(&scene, &sensors, n);
            let errors: Vec<f64> = radii
                .iter()
                .zip(&survey.results)
                .map(|(r, found)| {
                    found.total.mean - exact.illuminance(ExactPlane::Lower, *r).expect("inside")
                })
                .collect();
            eprintln!("R {radius} {n}: {:?} {:?} {errors:.6?}", survey.radiosity, survey.elapsed);
        }
    }
}

#[test]
fn concentric_spheres() {
    // Reference, section 2: R1 / R2 = 0.5, only the inner one emits.
    for n in [200, 800, 3200] {
        let ball = |radius| Sphere::new(DVec3::ONE, radius).expect("valid");
        let objects = vec![
            Object::new("inner", ball(1.0), grey(0.4).emitting(Rgb::WHITE)),
            Object::new("outer", ball(2.0).turned_inward(true), grey(0.7)),
        ];
        let scene = Scene::new(objects, Vec::new()).expect("valid");
        let along = DVec3::new(0.48, 0.6, 0.64);
        let sensors = [
            Sensor::plane(DVec3::ONE + along, along),
            Sensor::plane(DVec3::ONE + 2.0 * along, -along),
        ];
        let survey = survey(&scene, &sensors, n);
        let found: Vec<f64> = survey.results.iter().map(|r| r.total.mean).collect();
        eprintln!("spheres {n} {found:?} exact 0.4320987654 0.6172839506 {:?}", survey.radiosity);
    }
}
