//! Error bounds against 32 digits, and departures, on shapes of all sizes and places.

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::super::exact::{self, Exact};
use super::super::{AxisBox, Disc, Plane, Rectangle, Sphere};
use super::v;
use crate::math::{Frame, Ray, sampling};
use crate::surface::{Hit, Surface};

/// Draws a number of either sign whose size is log-uniform within 10^low..10^high.
fn sized(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low..high, any::<bool>())
        .prop_map(|(e, minus)| if minus { -10_f64.powf(e) } else { 10_f64.powf(e) })
}

fn direction() -> impl Strategy<Value = DVec3> {
    (0.0..1.0, 0.0..1.0).prop_map(|(u, v)| sampling::uniform_sphere([u, v]).normalize())
}

fn position() -> impl Strategy<Value = DVec3> {
    (sized(-3.0, 6.0), sized(-3.0, 6.0), sized(-3.0, 6.0)).prop_map(|(x, y, z)| v(x, y, z))
}

/// Makes the direction with this cosine to the hit's normal.
fn grazing(hit: &Hit, cos: f64, azimuth: f64) -> DVec3 {
    let frame = Frame::about(hit.normal);
    let sin = (1.0 - cos * cos).sqrt();
    frame.to_world(v(sin * azimuth.cos(), sin * azimuth.sin(), cos)).normalize()
}

/// Calls `check` with outward and inward cosines from 1 down to 1e-12 in a few azimuths.
fn for_grazing_cosines(hit: &Hit, mut check: impl FnMut(DVec3, bool)) {
    for cos in [1.0, 0.3, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
        for azimuth in [0.0, 0.9, 2.5, 4.1] {
            check(grazing(hit, cos, azimuth), true);
            check(grazing(hit, -cos, azimuth), false);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        rng_seed: prop::test_runner::RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn sphere_bound_holds_and_departures_are_clean(
        centre in position(), radius in sized(-3.0, 6.0), aim in direction(),
        within in direction(), away in sized(-3.0, 9.0), through_origin in any::<bool>()
    ) {
        // Where the point is near the origin its own rounding no longer hides that of the radius.
        let within = if aim.dot(within) > 0.0 { -within } else { within };
        let centre = if through_origin { 1e-9 * centre - radius.abs() * within } else { centre };
        let sphere = Sphere::new(centre, radius.abs()).expect("valid");
        let target = centre + 0.999_999 * sphere.radius() * within;
        let ray = Ray::new(target - away.abs() * aim, aim);
        // A target rounded at a coordinate of 1e9 can lie outside a small sphere.
        let Some(hit) = sphere.hit(&ray) else {
            prop_assert!(away.abs() > 1e12 * sphere.radius());
            return Ok(());
        };
        let off = exact::from_sphere(hit.point.into(), centre, sphere.radius()).abs();
        prop_assert!(off <= hit.error, "{off:e} > {:e}", hit.error);
        prop_assert!(hit.error <= 8.0 * f64::EPSILON * (sphere.radius() + centre.length()));
        for_grazing_cosines(&hit, |direction, outward| {
            let ray = hit.leave(direction);
            let next = sphere.hit(&ray);
            assert_eq!(next.is_some(), !outward, "{direction} {next:?}");
            // Turned inward nothing changes but the normal.
            assert_eq!(sphere.turned_inward(true).hit(&ray).is_some(), !outward);
            if let Some(next) = next {
                assert!(next.distance > 0.0);
                let off = exact::from_sphere(next.point.into(), centre, sphere.radius()).abs();
                assert!(off <= next.error);
            }
        });
    }

    #[test]
    fn flat_bounds_hold_and_departures_are_clean(
        at in position(), normal in direction(), size in sized(-3.0, 6.0), aspect in 0.01..1.0,
        x in 0.0..0.7, y in 0.0..0.7, aim in direction(), away in sized(-3.0, 9.0),
        turn in 0.0..6.0, through_origin in any::<bool>()
    ) {
        prop_assume!(aim.dot(normal).abs() > 1e-6);
        let frame = Frame::about(normal);
        let (t, b) = (DVec2::from_angle(turn), DVec2::from_angle(turn).perp());
        let edge_u = size.abs() * frame.to_world(v(t.x, t.y, 0.0));
        let edge_v = aspect * size.abs() * frame.to_world(v(b.x, b.y, 0.0));
        let shift: DVec3 = if aspect < 0.5 { x * edge_u + y * edge_v } else { aspect * y * edge_v };
        let at = if through_origin { -shift } else { at };
        let rectangle = Rectangle::new(at, edge_u, edge_v).expect("valid");
        let disc = Disc::new(at, normal, edge_v.length()).expect("valid");
        let plane = Plane::new(at, normal).expect("valid");
        let flat = Exact::from(rectangle.edge_u()).cross(rectangle.edge_v().into());
        let truths = [flat, disc.normal().into(), plane.normal().into()];
        let surfaces: [&dyn Surface; 3] = [&rectangle, &disc, &plane];
        for (surface, truth) in surfaces.into_iter().zip(truths) {
            let ray = Ray::new(at + shift - away.abs() * aim, aim);
            let Some(hit) = surface.hit(&ray) else { continue };
            let off = exact::from_plane(hit.point.into(), at, truth).abs();
            prop_assert!(off <= hit.error, "{off:e} > {:e}", hit.error);
            let reach = (hit.point - at).length() + at.length();
            prop_assert!(hit.error <= 8.0 * f64::EPSILON * reach);
            for_grazing_cosines(&hit, |direction, _| {
                let next = surface.hit(&hit.leave(direction));
                assert_eq!(next, None, "a flat shape is not met again");
            });
        }
    }

    #[test]
    fn box_departures_are_clean(
        at in position(), size in (sized(-3.0, 6.0), sized(-3.0, 6.0), sized(-3.0, 6.0)),
        within in direction(), aim in direction(), away in sized(-3.0, 9.0)
    ) {
        let size = v(size.0, size.1, size.2).abs();
        let solid = AxisBox::new(at, at + size).expect("valid");
        let target = at + 0.5 * size + 0.5 * size * within;
        let ray = Ray::new(target - away.abs() * aim, aim);
        let Some(hit) = solid.hit(&ray) else { return Ok(()) };
        let axis = hit.part as usize / 2;
        let face = if hit.part % 2 == 0 { solid.bounds().min } else { solid.bounds().max };
        prop_assert_eq!(hit.point[axis], face[axis]);
        prop_assert!(solid.bounds().contains(hit.point));
        for_grazing_cosines(&hit, |direction, outward| {
            let next = solid.hit(&hit.leave(direction));
            assert_eq!(next.is_some(), !outward, "{direction} {hit:?} {next:?}");
            if let Some(next) = next {
                assert!(next.distance > 0.0 && solid.bounds().contains(next.point));
                assert_ne!(next.part, hit.part, "the opposite side or a neighbour");
            }
        });
    }
}
