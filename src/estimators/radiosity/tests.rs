//! Radiosity against exact answers. Nothing here is random: the tolerances are the errors that were
//! found, with a little room.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use glam::DVec3;

use super::super::estimator::MAX_PATCHES;
use super::*;
use crate::estimators::{Ending, Estimator, SensorSettings, illuminance, luminance};
use crate::math::{Randomness, Ray};
use crate::mesh::shapes;
use crate::scene::{Material, Measure, Object, PointLight, Sensor};
use crate::surface::MeshSurface;
use crate::surface::primitives::{AxisBox, Disc, Plane, Rectangle, Sphere};

fn grey(reflectance: f64) -> Material {
    Material::lambert(Rgb::grey(reflectance)).expect("valid")
}

fn settings(patches: usize) -> SensorSettings {
    let radiosity = RadiositySettings { patches, ..RadiositySettings::default() };
    SensorSettings {
        estimator: Estimator::Radiosity(radiosity),
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

/// What `exact::Cube` gives there, lx.
const HALF: [f64; 7] = [310.981, 278.103, 253.230, 216.074, 161.07, 119.38, 106.45];
const FOUR_FIFTHS: [f64; 7] = [629.90, 596.55, 571.37, 531.78, 467.32, 402.14, 370.92];

/// The relative errors at seven points of the floor.
fn cube_errors(reflectance: f64, exact: [f64; 7], patches: usize) -> Vec<f64> {
    let sensors = ON_FLOOR.map(|[x, y]| Sensor::plane(DVec3::new(x, y, -2.0), DVec3::Z));
    let survey = survey(&cube(reflectance), &sensors, patches);
    let exchange = survey.radiosity.expect("told");
    assert!((exchange.absorbed + exchange.unshot - 1.0).abs() <= 2e-3, "{exchange:?}");
    survey.results.iter().zip(exact).map(|(r, exact)| r.total.mean / exact - 1.0).collect()
}

#[test]
fn cube_of_cie_171() {
    // The mean over all surfaces is exact to the share that is absorbed, and the error falls with
    // the patches: fivefold and more from 150 to 2400 (sixteen times as many) away from edges. 1
    // and 14 cm from two walls (the last two points) patches of 40 and 20 cm cannot follow the
    // light.
    for (reflectance, exact, coarse, middle) in
        [(0.5, HALF, 6e-3, 2e-3), (0.8, FOUR_FIFTHS, 7e-3, 2.5e-3)]
    {
        let by = |patches| cube_errors(reflectance, exact, patches);
        let (few, more) = (by(150), by(600));
        assert!(few[..5].iter().all(|e| e.abs() <= coarse), "{few:?}");
        assert!(more[..5].iter().all(|e| e.abs() <= middle), "{more:?}");
        assert!(more[5..].iter().all(|e| (0.0..=0.09).contains(e)), "{more:?}");
    }
}

#[test]
fn sensors_in_edges_and_corners_see_all_walls() {
    // In a furnace of exitance 1 and reflectance 1/2 the illuminance is 2 everywhere.
    let walls = AxisBox::new(DVec3::splat(-2.0), DVec3::splat(2.0)).expect("valid");
    let glowing = grey(0.5).emitting(Rgb::WHITE);
    let room = Object::new("room", walls.turned_inward(true), glowing);
    let scene = Scene::new(vec![room], vec![]).expect("valid");
    let places = [[0.0, 0.0, -2.0], [2.0, 0.3, -2.0], [-2.0, 2.0, -2.0], [-2.0, -2.0, 0.0]];
    let planes = places.map(|at| Sensor::plane(at.into(), DVec3::Z));
    let cylinders = planes.map(|s| Sensor { measure: Measure::Cylinder, ..s });
    // A cylinder that stands on the floor has the lower half of its view in the floor.
    let of_cylinders = [1.0, 1.0, 1.0, 2.0];
    for (sensors, expected) in [(planes, [2.0; 4]), (cylinders, of_cylinders)] {
        let found = survey(&scene, &sensors, 600);
        for ((sensor, found), expected) in sensors.iter().zip(&found.results).zip(expected) {
            let mean = found.total.mean;
            let at = (sensor.at, sensor.measure);
            assert!((mean - expected).abs() <= 2e-3, "{at:?}: {mean}, not {expected}");
        }
    }
}

/// Case A of Sobolev's problem with discs of this radius, and the radii at which it is looked at.
fn discs(radius: f64) -> Scene {
    let disc = |z: f64, n: DVec3| Disc::new(z * DVec3::Z, n, radius).expect("valid");
    let objects = vec![
        Object::new("floor", disc(0.0, DVec3::Z), grey(0.5)),
        Object::new("ceiling", disc(1.0, DVec3::NEG_Z), grey(0.5)),
    ];
    let lamp = PointLight::isotropic("lamp", DVec3::new(0.0, 0.0, 0.5), Rgb::WHITE);
    Scene::new(objects, vec![lamp]).expect("valid")
}

const RADII: [f64; 5] = [0.0, 0.5, 1.0, 2.0, 3.0];

/// What `exact::SobolevDiscs` gives there for discs of radius 5, 10 and 20, lx.
const EXACT: [(f64, [f64; 5]); 3] = [
    (5.0, [4.527_821_817_2, 1.859_975_153_0, 0.653_104_733_4, 0.166_052_397_1, 0.061_442_126_4]),
    (10.0, [4.528_121_985_8, 1.860_282_481_3, 0.653_434_536_7, 0.166_489_196_3, 0.062_140_203_6]),
    (20.0, [4.528_129_353_4, 1.860_289_908_0, 0.653_442_143_4, 0.166_497_572_0, 0.062_150_055_6]),
];

#[test]
fn sobolev_discs() {
    // The largest error over the value in the middle, by some 200 and 500 patches.
    let bounds = [[2e-3, 8e-4], [2.5e-3, 9e-4], [3.5e-3, 1e-3]];
    let sensors = RADII.map(|r| Sensor::plane(DVec3::new(r, 0.0, 0.0), DVec3::Z));
    for ((radius, exact), bounds) in EXACT.into_iter().zip(bounds) {
        for (patches, bound) in [200, 500].into_iter().zip(bounds) {
            let found = survey(&discs(radius), &sensors, patches);
            let errors = found.results.iter().zip(exact).map(|(r, e)| (r.total.mean - e).abs());
            let largest = errors.fold(0.0, f64::max) / exact[0];
            assert!(largest <= bound, "{radius} {patches}: {largest}");
            // What does not escape between discs of radius 10 is absorbed, by their integral
            // equation.
            let absorbed = found.radiosity.expect("told").absorbed;
            assert!(radius != 10.0 || (absorbed - 0.935_699).abs() <= 2e-3, "{absorbed}");
        }
    }
}

#[test]
fn concentric_spheres() {
    // Reference, section 2: R1 / R2 = 0.5, only the inner one emits.
    let exact = [0.432_098_765_4, 0.617_283_950_6];
    let ball = |radius| Sphere::new(DVec3::ONE, radius).expect("valid");
    let objects = vec![
        Object::new("inner", ball(1.0), grey(0.4).emitting(Rgb::WHITE)),
        Object::new("outer", ball(2.0).turned_inward(true), grey(0.7)),
    ];
    let scene = Scene::new(objects, Vec::new()).expect("valid");
    let along = DVec3::new(0.48, 0.6, 0.64);
    let sensors =
        [Sensor::plane(DVec3::ONE + along, along), Sensor::plane(DVec3::ONE + 2.0 * along, -along)];
    let errors = |patches| {
        let survey = survey(&scene, &sensors, patches);
        let errors = survey.results.iter().zip(exact);
        errors.map(|(r, exact)| (r.total.mean / exact - 1.0).abs()).fold(0.0, f64::max)
    };
    // A hollow patch does not see itself, which loses light in proportion to its size squared.
    let (few, more) = (errors(200), errors(800));
    assert!(few <= 0.05 && more <= 0.02, "{few} {more}");
}

#[test]
fn furnace_of_boxes_tables_and_meshes() {
    // All emit pi L0 (1 - rho): E = pi L0 on both sides of the table, around the cube, in free
    // space, and for a cylinder.
    let furnace = |rho: f64| grey(rho).emitting(Rgb::grey(PI * (1.0 - rho)));
    let walls = AxisBox::new(DVec3::ZERO, DVec3::new(4.0, 5.0, 3.0)).expect("valid");
    let cube = MeshSurface::new(shapes::cube().translated(DVec3::new(2.5, 3.0, 0.5)));
    let objects = vec![
        Object::new("room", walls.turned_inward(true), furnace(0.5)),
        Object::new("cube", cube.expect("valid"), furnace(0.3)),
    ];
    let scene = Scene::new(objects, Vec::new()).expect("valid");
    let sensor = |at: DVec3, normal, measure| Sensor { measure, ..Sensor::plane(at, normal) };
    let sensors = [
        sensor(DVec3::new(1.0, 1.0, 0.0), DVec3::Z, Measure::Plane),
        sensor(DVec3::new(2.5, 3.5, 1.0), DVec3::NEG_X, Measure::Plane),
        sensor(DVec3::new(1.2, 3.0, 1.1), DVec3::new(0.6, 0.0, -0.8), Measure::Plane),
        sensor(DVec3::new(1.2, 3.0, 1.1), DVec3::Z, Measure::Cylinder),
        sensor(DVec3::new(1.2, 3.0, 1.1), DVec3::Z, Measure::SemiCylinder { facing: DVec3::X }),
    ];
    let found = survey(&scene, &sensors, 800);
    for r in &found.results {
        assert!((r.total.mean / PI - 1.0).abs() <= 0.02, "{r:?}");
        assert!(r.total.standard_error.is_nan() && r.total.half_width(0.05).is_nan());
    }
    let go_on = |_: &_| ControlFlow::Continue(());
    let ray = Ray::new(DVec3::ONE, DVec3::X);
    let seen = luminance(&scene, &[ray], &settings(800), &go_on).expect("runs");
    assert!((seen.results[0].total.mean - 1.0).abs() <= 0.02, "{:?}", seen.results);
}

#[test]
fn tables_cast_shadows_and_reflect_below() {
    // A lamp over a table: no light straight below it, and some that the floor and then its
    // underside reflect.
    let plate = |corner: DVec3, side: f64| {
        Rectangle::new(corner, side * DVec3::X, side * DVec3::Y).expect("valid")
    };
    let objects = vec![
        Object::new("floor", plate(DVec3::new(-2.0, -2.0, 0.0), 4.0), grey(0.5)),
        Object::new("table", plate(DVec3::new(-0.5, -0.5, 1.0), 1.0), grey(0.5)),
    ];
    let lamp = PointLight::isotropic("lamp", DVec3::new(0.0, 0.0, 2.0), Rgb::grey(100.0));
    let scene = Scene::new(objects, vec![lamp]).expect("valid");
    let sensors = [
        Sensor::plane(DVec3::ZERO, DVec3::Z),
        Sensor::plane(DVec3::new(1.5, 0.0, 0.0), DVec3::Z),
        Sensor::plane(DVec3::new(0.0, 0.0, 1.0), DVec3::Z),
    ];
    let [below, beside, above]: [Measured; 3] =
        survey(&scene, &sensors, 1000).results.try_into().expect("three");
    assert!(below.direct.mean == 0.0 && below.total.mean > 0.01, "{below:?}");
    assert!((beside.direct.mean - 200.0 / 6.25_f64.powf(1.5)).abs() <= 1e-9, "{beside:?}");
    // Nothing reflects onto its upper side.
    assert_eq!((above.direct.mean, above.total.mean), (100.0, 100.0));
}

#[test]
fn what_cannot_be_meshed_or_set_is_refused() {
    let plane = Plane::new(DVec3::ZERO, DVec3::Z).expect("valid");
    let floor = Object {
        name: "floor".into(),
        surface: std::sync::Arc::new(plane),
        area: None,
        materials: vec![grey(0.5)],
    };
    let lamp = || PointLight::isotropic("lamp", DVec3::Z, Rgb::WHITE);
    let scene = Scene::new(vec![floor], vec![lamp()]).expect("valid");
    let said = refusal(&scene, 100);
    assert!(said.contains("`floor` is infinite") && said.contains("disc or a rectangle"), "{said}");
    for count in [0, MAX_PATCHES + 1] {
        assert!(refusal(&cube(0.5), count).contains("from 1 to 100000"));
    }
    for tolerance in [0.0, 1.0, f64::NAN] {
        assert!(RadiositySettings { tolerance, ..Default::default() }.check().is_err());
    }
    let dark = Scene::new(Vec::new(), Vec::new()).expect("valid");
    assert!(refusal(&dark, 100).contains("no light"));
    // Nothing to light but the sensors.
    let empty = Scene::new(Vec::new(), vec![lamp()]).expect("valid");
    let found = survey(&empty, &[Sensor::plane(DVec3::ZERO, DVec3::Z)], 100);
    assert_eq!(found.results[0].total.mean, 1.0);
}

#[test]
fn an_interrupted_exchange_says_so() {
    let stop = |_: &_| ControlFlow::Break(());
    let survey = illuminance(&cube(0.5), &[], &settings(150), &stop).expect("runs");
    assert_eq!(survey.ending, Ending::Interrupted);
    assert!(survey.radiosity.is_some_and(|e| e.unshot > 0.1 && e.shots == 0), "{survey:?}");
}
