//! Limits and signals: a run that is to end ends at once, with what it knows.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::common::{camera, go_on, grey, image, room, sensors};
use glam::DVec3;
use harmolux::estimators::{Ending, Estimator, Progress, Weighting, illuminance, render};
use harmolux::math::Rgb;
use harmolux::scene::{Material, PointLight, Scene, Sensor};

fn scene(walls: &Material) -> Scene {
    let walls = room(DVec3::new(4.0, 5.0, 3.0), &std::array::from_fn(|_| walls.clone()));
    let lamp = PointLight::isotropic("lamp", DVec3::new(2.0, 2.0, 2.5), Rgb::grey(100.0));
    Scene::new(vec![walls], vec![lamp]).expect("valid")
}

fn end_at_once(_: &Progress) -> ControlFlow<()> {
    ControlFlow::Break(())
}

/// A picture of many pixels in its first pass: what is there is kept, without an error.
#[test]
fn first_pass_may_be_left_half_way() {
    let scene = scene(&grey(0.5));
    let view = camera(DVec3::new(0.5, 0.4, 1.5), DVec3::new(2.0, 2.5, 1.2), [600, 400]);
    let settings = image(Estimator::Local(Weighting::of(&scene)), 64);
    // The third question comes a few hundredths of a second into the pass.
    let asked = AtomicU32::new(0);
    let observer = |_: &Progress| {
        let breaks = asked.fetch_add(1, Ordering::Relaxed) >= 3;
        if breaks { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let rendering = render(&scene, &view, &settings, &observer).expect("renders");
    let share = rendering.unfinished.expect("in the first pass");
    assert!(share < 1.0 && rendering.ending == Ending::Interrupted, "{share}");
    assert_eq!(rendering.film.passes(), usize::from(share > 0.0));
    let lit = (0..600 * 400).filter(|i| rendering.film.pixel(*i).luminance() > 0.0).count();
    assert!((lit as f64 / 240_000.0 - share).abs() <= 0.01, "{lit} {share}");
    assert!(rendering.film.relative_error_of(0.95).is_none());
}

/// Walks of a hundred thousand hits, sensors, gathering rays through mirrors: all are left off, and
/// nothing is known.
#[test]
fn nothing_is_known_of_what_was_not_reached() {
    let white = grey(0.99999);
    let mirror = Material::mirror(Rgb::grey(0.99999)).expect("valid");
    for walls in [white, mirror] {
        let scene = scene(&walls);
        let points = [Sensor::plane(DVec3::new(1.0, 1.0, 0.0), DVec3::Z); 3];
        for estimator in [Estimator::Local(Weighting::of(&scene)), Estimator::Path] {
            let settings = sensors(estimator, 1 << 30);
            let survey = illuminance(&scene, &points, &settings, &end_at_once).expect("runs");
            assert_eq!(survey.ending, Ending::Interrupted);
            let unknown = survey.results.iter().filter(|r| r.total.mean.is_nan()).count();
            assert!(survey.walks > 0 || unknown == 3, "{estimator:?}: {survey:?}");
        }
    }
}

/// A sensor that does not count has no part in the run, and no value.
#[test]
fn results_go_to_the_places_that_count() {
    let scene = scene(&grey(0.5));
    let points = [Sensor::plane(DVec3::new(1.0, 1.0, 0.0), DVec3::Z)];
    let settings = sensors(Estimator::Local(Weighting::of(&scene)), 256);
    let survey = illuminance(&scene, &points, &settings, &go_on).expect("runs");
    let own = survey.results[0];
    let all = survey.scattered(&[false, true, false]);
    assert_eq!(all.results[1], own);
    assert!(all.results[0].total.mean.is_nan() && all.replicates[2][0].is_nan());
    assert_eq!(all.worst(), Some(own.total.relative_half_width()));
}
