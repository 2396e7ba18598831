//! Rays and SH surfaces: the default intersector against certified stepping, and sense in every
//! answer to every finite ray.

use std::path::Path;

use crate::common::bumpy;
use crate::ray_check::{CheckShape, RayCheckSettings, check_rays, check_shapes};
use glam::DVec3;
use harmolux::fit::project_conforming;
use harmolux::io::meshes;
use harmolux::math::sampling::uniform_sphere;
use harmolux::math::{Ray, unit};
use harmolux::sh::Coefficients;
use harmolux::surface::{Hit, Intersector, ShSurface, StepBisection, Surface};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestRunner};

/// The same rules and kinds of rays as in `benches/experiments/ray_check.rs`, which asks ten
/// million.
#[test]
fn default_intersector_keeps_to_certified_stepping() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/head.obj");
    let mesh = meshes::read(&path).expect("the head can be read");
    let head = project_conforming(&mesh, DVec3::ZERO, 32).expect("fits");
    let mut shapes = check_shapes().expect("fixed degrees");
    shapes.push(CheckShape { name: "head", coefficients: head });
    for CheckShape { name, coefficients } in shapes {
        let of = |intersector| ShSurface::new(&coefficients, intersector).expect("positive");
        let (examined, oracle) = (of(Intersector::default()), of(Intersector::Certified));
        let rays = if name == "head" { 4000 } else { 2000 };
        let check = check_rays(&examined, &oracle, &RayCheckSettings { rays, seed: 7 }, |_| {});
        let lmax = coefficients.lmax();
        assert!(check.holds(), "{name} of degree {lmax}, {}", check.faults[0]);
        assert!(check.rays == rays && check.grazing == rays / 100 && check.hits > rays / 5);
    }
}

/// Returns a surface of each intersector for a sphere and a bumpy body of degree 12.
fn surfaces() -> Vec<ShSurface> {
    let mut sphere = Coefficients::zeros(0);
    sphere.set(0, 0, 1.0, 0.0);
    let bumpy = bumpy().body().series().coefficients().clone();
    let march = Intersector::StepBisection(StepBisection { step: 0.2, tolerance: 1e-6 });
    let intersectors = [Intersector::Patches, Intersector::Certified, march];
    let with = |shape: &Coefficients| {
        intersectors.map(|intersector| ShSurface::new(shape, intersector).expect("positive"))
    };
    [with(&sphere), with(&bumpy)].concat()
}

/// Numbers of every size: ordinary, huge, down to denormal, zeros of both signs.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => -3.0..3.0,
        1 => (-323.0..300.0, any::<bool>()).prop_map(|(e, s): (f64, bool)| {
            if s { 10_f64.powf(e) } else { -10_f64.powf(e) }
        }),
        1 => prop::sample::select(&[0.0, -0.0, 5e-324, -1e-310, 1e300, 1.0][..]),
    ]
}

/// Unit vectors, many with components that are zero or denormal.
fn direction() -> impl Strategy<Value = DVec3> {
    let component = prop_oneof![
        4 => -1.0..1.0,
        1 => prop_oneof![Just(0.0), Just(-0.0), Just(5e-324), Just(-3e-310), Just(1e-160)],
    ];
    [component.clone(), component.clone(), component]
        .prop_filter_map("no direction", |d| unit(DVec3::from_array(d)))
}

fn end() -> impl Strategy<Value = f64> {
    prop_oneof![3 => number(), 1 => Just(f64::INFINITY), 1 => Just(f64::NEG_INFINITY)]
}

fn ray() -> impl Strategy<Value = Ray> {
    // Half the rays are half lines: of others few come near.
    let ends = prop_oneof![Just((0.0, f64::INFINITY)), (end(), end())];
    ([number(), number(), number()], direction(), ends).prop_map(|(origin, direction, ends)| Ray {
        t_min: ends.0,
        t_max: ends.1,
        ..Ray::new(DVec3::from_array(origin), direction)
    })
}

/// Checks that a hit has numbers, lies between the ends of its ray, and has unit normals and a
/// positive error.
fn check_sense(ray: &Ray, hit: &Hit) {
    assert!(hit.distance.is_finite() && ray.contains(hit.distance), "{hit:?}");
    assert!(hit.point.is_finite() && hit.error > 0.0 && hit.error.is_finite(), "{hit:?}");
    assert!((hit.normal.length() - 1.0).abs() <= 1e-12, "{hit:?}");
    assert!((hit.shading_normal.length() - 1.0).abs() <= 1e-12, "{hit:?}");
}

/// Whether a ray comes so near to grazing, or starts or ends so near to the surface, that the error
/// bound of the fastest intersector (below 1e-5 for these bodies) may decide whether it hits: some
/// local extremum of the gap, of 4000 samples 5e-4 apart, is below that.
fn is_in_doubt(surface: &ShSurface, ray: &Ray) -> bool {
    let body = surface.body();
    let Some(chord) = body.chord(ray) else { return true };
    let at = |i: u32| {
        let t = chord.start + (chord.end - chord.start) * f64::from(i) / 4000.0;
        body.gap_value(ray.at(t)).abs()
    };
    let gaps: Vec<f64> = (0..=4000).map(at).collect();
    let extremum = |w: &[f64]| w[1] <= w[0] && w[1] <= w[2] && w[1] <= 1e-5;
    gaps[0] <= 1e-5 || gaps[4000] <= 1e-5 || gaps.windows(3).any(extremum)
}

#[test]
fn every_answer_to_every_finite_ray_has_sense() {
    let surfaces = surfaces();
    let mut runner = TestRunner::new(Config {
        cases: 400,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..Config::default()
    });
    let rays = prop::collection::vec(ray(), 1..40);
    runner
        .run(&rays, |rays| {
            for surface in &surfaces {
                let single: Vec<_> = rays.iter().map(|ray| surface.hit(ray)).collect();
                let mut batch = vec![None; rays.len()];
                surface.hits(&rays, &mut batch);
                prop_assert_eq!(&single, &batch);
                let mut marks: Vec<bool> = (0..rays.len()).map(|i| i % 5 == 0).collect();
                surface.mark_blocked(&rays, &mut marks);
                for (i, (ray, hit)) in rays.iter().zip(&single).enumerate() {
                    let blocked = surface.blocked(ray);
                    prop_assert_eq!(marks[i], blocked || i % 5 == 0);
                    if let Some(hit) = hit {
                        check_sense(ray, hit);
                        check_sense(ray, &Hit { distance: hit.distance, ..surface.refine(hit) });
                    }
                    prop_assert!(blocked == hit.is_some() || is_in_doubt(surface, ray), "{ray:?}");
                }
            }
            Ok(())
        })
        .expect("every ray keeps to it");
}

/// From 1e9 radii off, where one rounding of the distance is more than what a cell of the shell is
/// widened by, rays once stood still for ever; from 1e6 radii off some passed through a sphere, on
/// which the point where they came in was rounded to its inside.
#[test]
fn rays_from_far_off_end_and_hit() {
    for (which, surface) in surfaces().iter().enumerate() {
        // The march may miss.
        let is_certain = which % 3 < 2;
        for exponent in 6..18 {
            for i in 0..200 {
                let u = [(f64::from(i) + 0.5) / 200.0, (f64::from(i) * 0.618).fract()];
                let d = uniform_sphere(u);
                let aside = 0.005 * f64::from(i) * d.any_orthonormal_vector();
                let ray = Ray::new(aside - 10_f64.powi(exponent) * d, d);
                let hit = surface.hit(&ray);
                // Up to 0.3 radii beside the centre of bodies that hold a ball of 0.5; points are
                // rounded to 1e-7 of that at most.
                let must_hit = is_certain && i <= 60 && exponent <= 9;
                assert!(!must_hit || hit.is_some() && surface.blocked(&ray), "{which}: {ray:?}");
            }
        }
    }
}

#[test]
fn rays_without_sense_hit_nothing() {
    let nan = DVec3::splat(f64::NAN);
    for surface in surfaces() {
        for ray in [
            Ray::new(nan, DVec3::X),
            Ray::new(DVec3::ZERO, nan),
            Ray::new(DVec3::splat(f64::INFINITY), DVec3::X),
            Ray { t_min: 2.0, t_max: 1.0, ..Ray::new(DVec3::new(-3.0, 0.0, 0.0), DVec3::X) },
        ] {
            assert!(surface.hit(&ray).is_none() && !surface.blocked(&ray), "{ray:?}");
        }
    }
}
