//! The check passes what is right and finds what is wrong.

use glam::DVec3;

use super::*;
use harmolux::math::Aabb;
use harmolux::surface::{Intersector, StepBisection};

/// Answers as certified stepping does, but for what `spoil` makes of a hit.
struct Spoilt<F> {
    right: ShSurface,
    spoil: F,
}

impl<F: Fn(&ShSurface, &Ray, Option<Hit>) -> Option<Hit> + Send + Sync> Surface for Spoilt<F> {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        (self.spoil)(&self.right, ray, self.right.hit(ray))
    }

    fn bounds(&self) -> Aabb {
        self.right.bounds()
    }
}

fn body(index: usize) -> ShSurface {
    let shapes = check_shapes().expect("fixed degrees");
    ShSurface::new(&shapes[index].coefficients, Intersector::Certified).expect("positive")
}

/// A sphere, the random body of degree 16 and the spike.
const SPHERE: usize = 0;
const RANDOM: usize = 3;
const SPIKE: usize = 5;

const SETTINGS: RayCheckSettings = RayCheckSettings { rays: 2000, seed: 5 };

fn check(
    index: usize,
    spoil: impl Fn(&ShSurface, &Ray, Option<Hit>) -> Option<Hit> + Send + Sync,
) -> RayCheck {
    let examined = Spoilt { right: body(index), spoil };
    check_rays(&examined, &body(index), &SETTINGS, |_| {})
}

fn broke(check: &RayCheck, rule: RayRule) -> bool {
    check.faults.iter().any(|fault| fault.rule == rule)
}

/// Moves a hit along its ray, with an error bound that does not own up to it.
fn moved(ray: &Ray, hit: Hit, by: f64) -> Hit {
    let distance = hit.distance + by;
    Hit { distance, point: ray.at(distance), ..hit }
}

#[test]
fn right_answers_hold_and_are_counted() {
    let told = std::sync::atomic::AtomicU64::new(0);
    let (examined, oracle) = (body(RANDOM), body(RANDOM));
    let check = check_rays(&examined, &oracle, &SETTINGS, |rays| {
        told.fetch_add(rays, std::sync::atomic::Ordering::Relaxed);
    });
    assert!(check.holds(), "{}", check.faults[0]);
    assert_eq!((check.rays, check.grazing, check.differences, check.misses), (2000, 20, 0, 0));
    assert_eq!(told.into_inner(), 2000);
    assert!((400..1900).contains(&check.hits), "{}", check.hits);
    assert!(check.largest_gap > 0.0 && check.largest_gap <= 1.0);
}

#[test]
fn answers_that_own_up_to_their_error_hold() {
    // Late by 1e-6: a gap of 1e-6 times the slope of the gap along the ray, which the error bound
    // owns up to.
    let check = check(RANDOM, |s, ray, hit| {
        let error = 1e-5;
        hit.map(|hit| {
            let late = moved(ray, hit, 1e-6);
            let distance = late.distance.min(ray.t_max);
            let point = ray.at(distance);
            Hit { distance, point, error: s.body().gap_value(point).abs().max(error), ..late }
        })
    });
    assert!(check.holds(), "{}", check.faults[0]);
    assert!(check.differences > 300 && check.deepest_passed > 0.0 && check.deepest_passed <= 1.0);
}

#[test]
fn late_and_early_roots_are_found() {
    for by in [1e-7, -1e-7] {
        let check = check(RANDOM, |_, ray, hit| hit.map(|hit| moved(ray, hit, by)));
        assert!(broke(&check, RayRule::WithinError) && check.broken > 500, "{by}");
    }
    // The last root instead of the first: on the surface, but with a body in front.
    let last = check(RANDOM, |s, ray, hit| {
        let first = hit?;
        let on = Ray { t_min: first.distance + 1e-6, ..*ray };
        s.hit(&on).or(hit)
    });
    assert!(broke(&last, RayRule::PassesNothing), "{:?}", last.faults);
}

#[test]
fn false_hits_are_found() {
    let check = check(RANDOM, |s, ray, hit| {
        hit.or_else(|| {
            let middle = -ray.origin.dot(ray.direction);
            let hit = s.at(DVec3::X);
            ray.contains(middle).then(|| moved(ray, Hit { distance: 0.0, ..hit }, middle))
        })
    });
    assert!(broke(&check, RayRule::WithinError) && broke(&check, RayRule::BlockedBySomething));
}

#[test]
fn misses_of_single_rays_are_found() {
    let check = check(RANDOM, |_, ray, hit| {
        // Every 16th ray by its bits.
        hit.filter(|_| !ray.direction.x.to_bits().is_multiple_of(16))
    });
    assert!(check.misses > 10 && broke(&check, RayRule::PassesNothing));
}

#[test]
fn rays_lost_on_borders_of_faces_are_found() {
    let is_border = |d: DVec3| d.x == d.y && d.x != 0.0;
    let lost = check(SPHERE, |_, ray, hit| hit.filter(|_| !is_border(ray.direction)));
    assert!(broke(&lost, RayRule::PassesNothing), "{:?}", lost.faults);
    assert!(lost.faults.iter().all(|fault| fault.kind == "border"), "{:?}", lost.faults);
}

#[test]
fn lobes_passed_by_coarse_steps_are_found() {
    let coarse = StepBisection { step: 0.2, tolerance: 1e-12 };
    let oracle = body(SPIKE);
    let march =
        ShSurface::new(oracle.body().series().coefficients(), Intersector::StepBisection(coarse))
            .expect("valid");
    let check = check_rays(&march, &oracle, &SETTINGS, |_| {});
    assert!(broke(&check, RayRule::PassesNothing) && check.misses > 0, "{:?}", check.faults);
}

#[test]
fn surfaces_hit_by_what_leaves_them_are_found() {
    // A surface that is traced to 1e-6 but refined to rounding: its own departures start inside its
    // error.
    let check = check(RANDOM, |s, ray, hit| {
        let gap = s.body().gap_value(ray.origin).abs();
        if gap > 0.0 && gap < 1e-6 && ray.t_min == 0.0 {
            return Some(Hit { distance: 0.0, point: ray.origin, error: 1e-6, ..s.at(DVec3::X) });
        }
        hit
    });
    assert!(broke(&check, RayRule::LeavesSurface), "{:?}", check.faults);
}

#[test]
fn answers_without_sense_are_found() {
    let nan = check(RANDOM, |_, _, hit| hit.map(|hit| Hit { error: f64::NAN, ..hit }));
    assert!(broke(&nan, RayRule::Sound));
    let behind = check(RANDOM, |_, _, hit| hit.map(|hit| Hit { distance: -1.0, ..hit }));
    assert!(broke(&behind, RayRule::OnRay));
}

#[test]
fn faults_carry_their_rays_bit_by_bit() {
    let check = check(RANDOM, |_, _, _| None);
    let text = check.faults[0].to_string();
    let bits = format!("{:#018x}", check.faults[0].ray.origin.x.to_bits());
    assert!(text.contains(&bits) && text.contains("reported  nothing"), "{text}");
    assert_eq!(check.faults.len(), 8);
    assert!(check.broken > 2 * check.misses);
}

#[test]
fn patches_hold_however_small_the_least_radius_is() {
    for small in [0.03, 1e-3, 1e-5] {
        let mut dent = harmolux::sh::Coefficients::zeros(1);
        dent.set(0, 0, 1.0, 0.0);
        dent.set(1, 0, 0.6 * (1.0 - small), 0.0);
        dent.set(1, 1, 0.8 * 2.0_f64.sqrt() * (1.0 - small), 0.0);
        let of = |intersector| ShSurface::new(&dent, intersector).expect("positive");
        let (examined, oracle) = (of(Intersector::Patches), of(Intersector::Certified));
        let check = check_rays(&examined, &oracle, &SETTINGS, |_| {});
        assert!(check.holds(), "{small}: {}", check.faults[0]);
    }
}
