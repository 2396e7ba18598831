//! Scenes that are problems with an exact answer, as files: what `[compare]` knows of each, and
//! what the estimators make of it.
//!
//! Estimates use fixed seeds and judge all sensors of a scene together with a false-alarm rate of
//! 1e-3 (`Estimate::agrees_with`).

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::common::{self, go_on, sensors};
use glam::{DQuat, DVec3};
use harmolux::estimators::{Estimator, Weighting, illuminance};
use harmolux::exact::cie171;
use harmolux::io::scene_file::SceneFile;
use harmolux::math::Placement;
use harmolux::scene::{Distribution, Object, PointLight, Scene, Sensor};
use harmolux::study::{Loaded, known_illuminance, load};
use harmolux::surface::Instance;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/scenes")
}

/// A scene with what its sensors are known to receive, lx, group by group.
fn read(name: &str) -> (Loaded, Vec<(String, Vec<f64>)>) {
    let file = SceneFile::read(&folder().join(name), &[]).expect("a valid scene");
    let loaded = load(&file).expect("loads");
    assert!(loaded.warnings.is_empty(), "{name}: {:?}", loaded.warnings);
    let known = loaded.sensors.iter().map(|group| {
        let values = known_illuminance(&file, group)
            .expect("the problem it names")
            .expect("named in [compare]");
        (group.name.clone(), values)
    });
    let known = known.collect();
    (loaded, known)
}

/// The known values of a group.
fn group(name: &str, group: &str) -> Vec<f64> {
    let (_, known) = read(name);
    known.into_iter().find(|(found, _)| found == group).expect("there").1
}

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= tolerance * expected.abs(), "{found} {expected}");
    }
}

/// Judges all sensors of a scene by both estimators.
fn judge(name: &str, walks: u64) {
    let (Loaded { scene, sensors: groups, .. }, known) = read(name);
    let points: Vec<Sensor> = groups.iter().flat_map(|g| g.sensors.iter().copied()).collect();
    let known: Vec<f64> = known.into_iter().flat_map(|(_, values)| values).collect();
    for estimator in [Estimator::Local(Weighting::of(&scene)), Estimator::Path] {
        let survey = illuminance(&scene, &points, &sensors(estimator, walks), &go_on);
        let survey = survey.expect("runs");
        for (i, (result, exact)) in survey.results.iter().zip(&known).enumerate() {
            let total = result.total;
            assert!(
                total.agrees_with(*exact, 0.0, points.len()),
                "{name}, {estimator:?}, sensor {i}: {total:?} against {exact}"
            );
            assert_eq!(result.non_finite, 0, "{name}, {estimator:?}, sensor {i}");
            let largest = known.iter().copied().fold(0.0, f64::max);
            assert!(
                total.standard_error <= 0.02 * exact.max(0.1 * largest),
                "too noisy to say anything: {name}, {estimator:?}, sensor {i}: {total:?}"
            );
        }
    }
}

#[test]
fn every_exact_scene_is_judged_here() {
    let here = include_str!("exact_scenes.rs");
    for entry in folder().join("exact").read_dir().expect("there") {
        let name = entry.expect("readable").file_name().into_string().expect("plain");
        assert!(here.contains(&format!("judge(\"exact/{name}\"")), "{name} is not judged");
    }
}

#[test]
fn sobolevs_planes_and_discs_agree() {
    // Ends of the tables of the reference, printed to 12 and 10 digits.
    let lower = group("exact/sobolev_b.toml", "lower");
    assert_near(&[lower[0], lower[6]], &[2.472_169_062_193, 0.054_784_166_608], 1e-10);
    let upper = group("exact/sobolev_b.toml", "upper");
    assert_near(&[upper[0], upper[6]], &[11.745_207_517_055, 0.072_677_877_713], 1e-10);
    let printed =
        [4.528_121_985_8, 1.860_282_481_3, 0.653_434_536_7, 0.166_489_196_3, 0.062_140_203_6];
    assert_near(&group("sobolev_discs.toml", "radius"), &printed, 1e-9);
    let rim = group("exact/discs_rim.toml", "radius");
    assert_near(&rim[..3], &[4.514_082_781_9, 1.845_390_249_1, 0.635_696_282_9], 1e-9);
    judge("sobolev.toml", 1 << 14);
    judge("sobolev_discs.toml", 1 << 16);
    judge("exact/sobolev_b.toml", 1 << 16);
    judge("exact/discs_rim.toml", 1 << 14);
}

#[test]
fn spheres_agree() {
    assert_near(&group("exact/sphere_glow.toml", "wall"), &[1000.0; 8], 1e-12);
    let across = group("exact/hemisphere.toml", "across");
    assert_near(&across, &[5.0 / 6.0; 4], 1e-12);
    for of_cap in ["pole", "aslant", "low"] {
        assert_near(&group("exact/hemisphere.toml", of_cap), &[25.0 / 24.0], 1e-12);
    }
    assert_near(&group("exact/concentric.toml", "lamp"), &[0.432_098_765_4; 4], 1e-9);
    assert_near(&group("exact/concentric.toml", "wall"), &[0.617_283_950_6; 6], 1e-9);
    judge("exact/sphere.toml", 1 << 12);
    judge("exact/sphere_glow.toml", 1 << 12);
    judge("exact/hemisphere.toml", 1 << 14);
    judge("exact/concentric.toml", 1 << 13);
}

#[test]
fn cube_agrees_at_all_seven_points() {
    let printed = [310.981, 278.103, 253.230, 216.074, 161.07, 119.38, 106.45];
    assert_near(&group("exact/cie171_5_8.toml", "floor"), &printed, 5e-5);
    judge("exact/cie171_5_8.toml", 1 << 14);
}

#[test]
fn direct_cases_of_cie_171_are_those_of_the_tables_and_agree() {
    let table = |cases: Vec<cie171::Reading>, labels: &str| -> Vec<f64> {
        cases.iter().filter(|r| labels.contains(r.label)).map(|r| r.value).collect()
    };
    let points = table(cie171::point_source(), "0123456789");
    assert_near(&group("exact/cie171_5_2.toml", "plane"), &points, 1e-12);
    for (scene, cases, rest) in [
        ("exact/cie171_5_3.toml", cie171::area_source(), "floor"),
        ("exact/cie171_5_6.toml", cie171::diffuse_reflection(), "ceiling"),
        ("exact/cie171_5_7.toml", cie171::obstruction(), "floor"),
    ] {
        assert_near(&group(scene, "wall"), &table(cases.clone(), "ABCDEF"), 1e-11);
        assert_near(&group(scene, rest), &table(cases, "GHIJKLMN"), 1e-11);
    }
    judge("exact/cie171_5_2.toml", 32);
    judge("exact/cie171_5_3.toml", 1 << 14);
    judge("exact/cie171_5_4.toml", 32);
    judge("exact/cie171_5_6.toml", 1 << 13);
    judge("exact/cie171_5_7.toml", 1 << 14);
}

#[test]
fn flux_of_case_5_4_arrives() {
    let (Loaded { scene, sensors: groups, .. }, _) = read("exact/cie171_5_4.toml");
    let local = Estimator::Local(Weighting::of(&scene));
    let survey = illuminance(&scene, &groups[0].sensors, &sensors(local, 4096), &go_on);
    let survey = survey.expect("runs");
    assert!(survey.escaped <= 0.0, "{}", survey.escaped);
    // 400 points spread evenly over six walls: each has some 1/400 of the area, off by one point a
    // wall at most.
    let mean = survey.results.iter().map(|r| r.total.mean).sum::<f64>() / 400.0;
    assert!((mean / 125.0 - 1.0).abs() <= 0.02, "{mean}");
}

#[test]
fn furnace_agrees_on_a_series_and_on_its_mesh() {
    judge("exact/furnace.toml", 1 << 12);
}

/// Where the exact scenes are put: moved, a little and far, and scaled.
const PLACES: [(f64, DVec3); 9] = [
    (1.0, DVec3::new(1e-17, -3e-16, 2e-15)),
    (1.0, DVec3::new(7.0, -11.0, 13.0)),
    (1.0, DVec3::new(-1e3, 1e3, 1e3)),
    (1.0, DVec3::new(4.1e5, 5.6e6, 30.0)),
    (1e-6, DVec3::ZERO),
    (1e-3, DVec3::new(0.1, 0.2, -0.3)),
    (1e3, DVec3::ZERO),
    (1e3, DVec3::new(1e6, -1e6, 1e6)),
    (1e6, DVec3::ZERO),
];

/// Scales and then moves a scene file.
fn put(table: &mut toml::Table, scale: f64, shift: DVec3) {
    for (key, value) in table.iter_mut() {
        match key.as_str() {
            "at" | "centre" | "corner" | "from" | "max" | "min" | "point" | "to"
                if value.is_array() =>
            {
                put_point(value, scale, shift);
            }
            "edge_u" | "edge_v" => put_point(value, scale, DVec3::ZERO),
            "radius" | "scale" | "spacing" if number(value).is_some() => {
                *value = (scale * number(value).expect("a number")).into();
            }
            // Lamps grow with the scene, so that lux stay.
            "flux" | "intensity" => {
                *value = (scale * scale * number(value).expect("a number")).into();
            }
            "file" => *value = folder().join("../head.obj").to_string_lossy().as_ref().into(),
            _ => {
                if let Some(inner) = value.as_table_mut() {
                    put(inner, scale, shift);
                }
            }
        }
    }
}

fn number(value: &toml::Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64))
}

/// Puts a point, or each of a list.
fn put_point(value: &mut toml::Value, scale: f64, shift: DVec3) {
    let list = value.as_array_mut().expect("a point or a list of points");
    if list[0].is_array() {
        return list.iter_mut().for_each(|point| put_point(point, scale, shift));
    }
    for (x, shift) in list.iter_mut().zip(shift.to_array()) {
        *x = (scale * number(x).expect("a number") + shift).into();
    }
}

/// Turns and moves a scene, each object as an instance.
fn turned(loaded: &Loaded, placement: &Placement) -> (Scene, Vec<Sensor>) {
    let objects = loaded.scene.objects().iter().map(|object| match object.area.clone() {
        Some(area) => Object {
            materials: object.materials.clone(),
            ..Object::new(
                &object.name,
                Instance::new(area, *placement),
                object.materials[0].clone(),
            )
        },
        None => Object {
            surface: Arc::new(Instance::new(object.surface.clone(), *placement)),
            ..object.clone()
        },
    });
    let along = |d: DVec3| placement.apply_direction(d);
    let lights = loaded.scene.lights().iter().map(|light| {
        let mut light = PointLight { at: placement.apply(light.at), ..light.clone() };
        if let Distribution::Lambert { axis } = &mut light.distribution {
            *axis = along(*axis);
        }
        light
    });
    let scene = Scene::new(objects.collect(), lights.collect()).expect("valid");
    let sensors = loaded.sensors.iter().flat_map(|group| &group.sensors);
    let turn = |s: &Sensor| {
        let plain = Sensor::plane(placement.apply(s.at), along(s.normal));
        Sensor { measure: s.measure, error: s.error, ..plain }
    };
    (scene, sensors.map(turn).collect())
}

/// Every exact scene keeps its values wherever it stands, however large, however turned.
#[test]
fn exact_scenes_may_stand_anywhere() {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 0.8);
    let turns = [DVec3::ZERO, DVec3::new(3.0, 1.0, -2.0)]
        .map(|shift| Placement::new(turn, 1.0, shift).expect("valid"));
    let exact = folder().join("exact").read_dir().expect("there");
    let exact = exact.map(|entry| entry.expect("readable").path());
    for path in exact.chain([folder().join("sobolev.toml")]) {
        let name = path.display();
        let text = std::fs::read_to_string(&path).expect("readable");
        let file = SceneFile::read(&path, &[]).expect("a valid scene");
        let here = load(&file).expect("loads");
        let known: Vec<f64> = here
            .sensors
            .iter()
            .flat_map(|group| known_illuminance(&file, group).expect("a problem").expect("named"))
            .collect();
        let check = |scene: &Scene, sensors: &[Sensor], place: &str| {
            assert_eq!(sensors.len(), known.len(), "{name}, {place}");
            let local = Estimator::Local(Weighting::of(scene));
            let survey = illuminance(scene, sensors, &common::sensors(local, 1 << 12), &go_on);
            let largest = known.iter().copied().fold(0.0, f64::max);
            for (i, (result, exact)) in survey.expect("runs").results.iter().zip(&known).enumerate()
            {
                let total = result.total;
                // Far off the scene itself is rounded.
                let count = known.len() * (PLACES.len() + turns.len()) * 14;
                let agrees = total.agrees_with(*exact, 1e-8 * exact, count);
                assert!(agrees, "{name}, {place}, sensor {i}: {total:?} against {exact}");
                let noise = total.standard_error / exact.max(0.1 * largest);
                assert!(noise <= 0.05, "{name}, {place}, sensor {i}: {total:?} is noise");
            }
        };
        for (scale, shift) in PLACES {
            let mut table: toml::Table = text.parse().expect("TOML");
            put(&mut table, scale, shift);
            let file = SceneFile::parse(&path, &table.to_string(), &[]).expect("a valid scene");
            let there = load(&file).unwrap_or_else(|e| panic!("{name}, {scale} {shift}: {e}"));
            let sensors: Vec<Sensor> =
                there.sensors.iter().flat_map(|g| g.sensors.iter().copied()).collect();
            check(&there.scene, &sensors, &format!("scaled by {scale:e}, moved by {shift}"));
        }
        for placement in &turns {
            let (scene, sensors) = turned(&here, placement);
            check(&scene, &sensors, &format!("{placement:?}"));
        }
    }
}
