//! Samples that are not finite: counted, reported, never averaged in.

use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::common::{go_on, grey, sensors};
use glam::DVec3;
use harmolux::estimators::{Estimator, Weighting, illuminance};
use harmolux::exact::Cube;
use harmolux::math::{Aabb, Ray, Rgb};
use harmolux::scene::{Object, PointLight, Scene, Sensor};
use harmolux::surface::primitives::AxisBox;
use harmolux::surface::{Hit, Surface};

/// A room whose normal is NaN once: at the hit of this number that is refined.
struct Flawed {
    room: AxisBox,
    refined: AtomicU64,
    flaw: u64,
}

impl Surface for Flawed {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        self.room.hit(ray)
    }

    fn bounds(&self) -> Aabb {
        self.room.bounds()
    }

    fn refine(&self, hit: &Hit) -> Hit {
        let hit = self.room.refine(hit);
        if self.refined.fetch_add(1, Ordering::Relaxed) + 1 != self.flaw {
            return hit;
        }
        let nan = DVec3::splat(f64::NAN);
        Hit { normal: nan, shading_normal: nan, ..hit }
    }
}

fn flawed_cube(flaw: u64) -> Scene {
    let room = AxisBox::new(DVec3::ZERO, DVec3::splat(4.0)).expect("valid").turned_inward(true);
    let surface = Flawed { room, refined: AtomicU64::new(0), flaw };
    let cube = Object {
        name: "cube".into(),
        surface: Arc::new(surface),
        area: Some(Arc::new(room)),
        materials: vec![grey(0.5)],
    };
    let lamp = PointLight::isotropic("lamp", DVec3::splat(2.0), Rgb::grey(10_000.0 / (4.0 * PI)));
    Scene::new(vec![cube], vec![lamp]).expect("valid")
}

#[test]
fn one_nan_in_a_million_walks_is_counted_and_not_averaged_in() {
    let exact = Cube { edge: 4.0, flux: 10_000.0, reflectance: 0.5 }.solve().expect("solves");
    let exact = exact.illuminance(0.5, 0.5).expect("on the floor");
    let point = [Sensor::plane(DVec3::new(2.5, 2.5, 0.0), DVec3::Z)];
    let walks = 1 << 20;
    // The first hits are those of the uncounted pilot replicate of the local estimate.
    for flaw in [1000, 1_000_000] {
        let local = Estimator::Local(Weighting::of(&flawed_cube(flaw)));
        for estimator in [local, Estimator::Local(Weighting::Walk), Estimator::Path] {
            let scene = flawed_cube(flaw);
            let survey = illuminance(&scene, &point, &sensors(estimator, walks), &go_on);
            let survey = survey.expect("runs");
            let found = survey.results[0];
            assert_eq!((found.non_finite, survey.walks), (1, walks), "{estimator:?} {flaw}");
            // One of six values; the cube's own solution is good to 1e-7.
            assert!(found.total.agrees_with(exact, 1e-7 * exact, 6), "{flaw}: {found:?} {exact}");
            assert!(found.total.relative_error() <= 1e-3, "{found:?}");
            assert!(survey.escaped.is_nan() || survey.escaped.abs() <= 2e-6, "{}", survey.escaped);
        }
    }
}
