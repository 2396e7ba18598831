//! Tests of the shapes: degenerate inputs, analytic hits, error bounds against 32 digits, departures, closed rooms, sampling.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::exact::{self, Exact};
use super::{AxisBox, Disc, Plane, Rectangle, Sphere};
use crate::math::{Frame, Randomness, Ray, Stream, sampling};
use crate::surface::{Hit, SampleArea, Surface};

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn unit_box() -> AxisBox {
    AxisBox::new(DVec3::ZERO, DVec3::ONE).expect("valid")
}

fn shapes() -> Vec<Box<dyn Surface>> {
    vec![
        Box::new(Plane::new(DVec3::ZERO, DVec3::Z).expect("valid")),
        Box::new(
            Rectangle::new(v(-1.0, -1.0, 0.0), 2.0 * DVec3::X, 2.0 * DVec3::Y).expect("valid"),
        ),
        Box::new(Disc::new(DVec3::ZERO, DVec3::Z, 1.0).expect("valid")),
        Box::new(Sphere::new(DVec3::ZERO, 1.0).expect("valid")),
        Box::new(AxisBox::new(DVec3::NEG_ONE, DVec3::ONE).expect("valid")),
    ]
}

// Degenerate inputs.

#[test]
fn parameters_that_make_no_shape_are_refused() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300, 1e300] {
        assert!(Sphere::new(DVec3::ZERO, bad).is_err(), "radius {bad}");
        assert!(Disc::new(DVec3::ZERO, DVec3::Z, bad).is_err(), "radius {bad}");
    }
    for bad in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY, v(0.0, 0.0, 1e-300)] {
        assert!(Plane::new(DVec3::ZERO, bad).is_err(), "normal {bad}");
        assert!(Disc::new(DVec3::ZERO, bad, 1.0).is_err(), "normal {bad}");
        assert!(Rectangle::new(DVec3::ZERO, bad, DVec3::X).is_err(), "edge {bad}");
        assert!(Rectangle::new(DVec3::ZERO, DVec3::X, bad).is_err(), "edge {bad}");
    }
    for bad in [DVec3::NAN, DVec3::INFINITY, v(0.0, f64::NAN, 0.0)] {
        assert!(Plane::new(bad, DVec3::Z).is_err());
        assert!(Disc::new(bad, DVec3::Z, 1.0).is_err());
        assert!(Sphere::new(bad, 1.0).is_err());
        assert!(Rectangle::new(bad, DVec3::X, DVec3::Y).is_err());
        assert!(AxisBox::new(bad, DVec3::ONE).is_err());
        assert!(AxisBox::new(DVec3::ZERO, bad).is_err());
    }
    assert!(AxisBox::new(DVec3::ZERO, v(1.0, 0.0, 1.0)).is_err());
    assert!(AxisBox::new(DVec3::ONE, DVec3::ZERO).is_err());
    assert!(Rectangle::new(DVec3::ZERO, DVec3::X, v(1e-8, 1.0, 0.0)).is_err());
}

#[test]
fn shapes_lost_in_rounding_are_refused_with_advice() {
    let error = Sphere::new(v(1e6, 0.0, 0.0), 1e-7).expect_err("below one ulp or so");
    assert!(error.to_string().contains("nearer to the origin"), "{error}");
    assert!(Disc::new(v(1e6, 0.0, 0.0), DVec3::Z, 1e-7).is_err());
    assert!(Rectangle::new(v(1e6, 0.0, 0.0), 1e-7 * DVec3::X, DVec3::Y).is_err());
    assert!(AxisBox::new(DVec3::splat(1e6), v(2e6, 2e6, 1e6 + 1e-7)).is_err());
}

#[test]
fn rays_that_are_no_rays_hit_nothing() {
    let (good, bad) = (v(0.1, 0.2, 3.0), v(0.0, f64::NAN, 0.0));
    for shape in shapes() {
        assert!(shape.hit(&Ray::new(good, DVec3::NEG_Z)).is_some());
        for ray in [
            Ray::new(bad, DVec3::NEG_Z),
            Ray::new(good, bad),
            Ray::new(good, v(f64::NAN, 0.0, -1.0)),
            Ray::new(DVec3::NAN, DVec3::NAN),
            Ray::new(good, DVec3::ZERO),
            Ray::new(v(0.1, 0.2, 0.3), DVec3::ZERO),
            Ray::new(DVec3::INFINITY, DVec3::NEG_Z),
            Ray::new(good, v(0.0, 0.0, f64::NEG_INFINITY)),
            Ray::new(good, DVec3::NEG_Z).up_to(f64::NAN),
            Ray { t_min: f64::NAN, ..Ray::new(good, DVec3::NEG_Z) },
            Ray::new(good, DVec3::NEG_Z).up_to(1.9),
            Ray { t_min: 5.1, ..Ray::new(good, DVec3::NEG_Z) },
        ] {
            assert_eq!(shape.hit(&ray), None, "{ray:?}");
            assert!(!shape.blocked(&ray));
        }
    }
}

#[test]
fn ends_of_a_ray_choose_the_crossing() {
    for (shape, far) in [(&shapes()[3], -1.0), (&shapes()[4], -1.0)] {
        let ray = Ray::new(v(0.0, 0.0, 3.0), DVec3::NEG_Z);
        assert_eq!(shape.hit(&ray.up_to(2.0)).map(|h| h.distance), Some(2.0));
        let late = Ray { t_min: 2.5, ..ray };
        assert_eq!(shape.hit(&late).map(|h| (h.distance, h.point.z)), Some((4.0, far)));
        assert_eq!(shape.hit(&late.up_to(3.9)), None);
    }
}

#[test]
fn rays_within_a_flat_shape_pass() {
    for shape in &shapes()[..3] {
        for sign in [0.0, -0.0] {
            assert_eq!(shape.hit(&Ray::new(v(-3.0, 0.0, sign), v(1.0, 0.0, sign))), None);
        }
    }
}

#[test]
fn signed_zeros_make_no_difference() {
    let cube = unit_box();
    for (x, y) in [(0.0, 0.0), (-0.0, 0.0), (0.0, -0.0), (-0.0, -0.0)] {
        let through = cube.hit(&Ray::new(v(0.5, 0.5, 3.0), v(x, y, -1.0))).expect("hits the lid");
        assert_eq!((through.distance, through.part), (2.0, 5));
        assert_eq!(cube.hit(&Ray::new(v(1.5, 0.5, 3.0), v(x, y, -1.0))), None);
    }
}

#[test]
fn ray_in_the_plane_of_a_box_face_touches_it() {
    let cube = unit_box();
    let outside = cube.hit(&Ray::new(v(-1.0, 0.5, 1.0), DVec3::X)).expect("touches");
    assert_eq!((outside.distance, outside.part), (1.0, 0));
    let inside = cube.hit(&Ray::new(v(0.25, 0.5, 1.0), DVec3::X)).expect("stays in the closed box");
    assert_eq!((inside.distance, inside.part), (0.75, 1));
    assert_eq!(cube.hit(&Ray::new(v(-1.0, 0.5, 1.0 + 1e-15), DVec3::X)), None);
}

// Analytic hits.

#[test]
fn box_faces_have_their_parts_normals_and_distances() {
    let cube = AxisBox::new(v(-1.0, -2.0, -3.0), v(4.0, 5.0, 6.0)).expect("valid");
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    for part in 0..6_u32 {
        let outward = axes[part as usize / 2] * if part % 2 == 0 { -1.0 } else { 1.0 };
        let reach = [1.0, 4.0, 2.0, 5.0, 3.0, 6.0][part as usize];
        let from_inside = cube.hit(&Ray::new(DVec3::ZERO, outward)).expect("inside");
        assert_eq!((from_inside.part, from_inside.distance), (part, reach));
        assert_eq!((from_inside.normal, from_inside.point), (outward, reach * outward));
        let from_outside = cube.hit(&Ray::new(10.0 * outward, -outward)).expect("ahead");
        assert_eq!((from_outside.part, from_outside.distance), (part, 10.0 - reach));
        assert_eq!(cube.hit(&Ray::new(10.0 * outward, outward)), None);
        let room = cube.turned_inward(true);
        assert_eq!(room.hit(&Ray::new(DVec3::ZERO, outward)).map(|h| h.normal), Some(-outward));
    }
}

#[test]
fn sphere_is_met_where_the_quadratic_says() {
    let sphere = Sphere::new(v(1.0, 2.0, 3.0), 2.0).expect("valid");
    // Impact parameter 1.2, so half the chord is 1.6.
    let ray = Ray::new(v(-9.0, 3.2, 3.0), DVec3::X);
    let hit = sphere.hit(&ray).expect("a chord");
    assert!((hit.distance - 8.4).abs() <= 1e-14);
    assert!((hit.point - v(-0.6, 3.2, 3.0)).length() <= 1e-14);
    assert!((hit.normal - v(-0.8, 0.6, 0.0)).length() <= 1e-15);
    let back = sphere.turned_inward(true).hit(&Ray { t_min: 9.0, ..ray }).expect("far side");
    assert!(
        (back.distance - 11.6).abs() <= 1e-14
            && (back.normal - v(-0.8, -0.6, 0.0)).length() <= 1e-15
    );
    assert_eq!(sphere.hit(&Ray::new(v(-9.0, 4.1, 3.0), DVec3::X)), None);
    assert_eq!(sphere.hit(&Ray::new(v(-9.0, 3.2, 3.0), DVec3::NEG_X)), None);
}

#[test]
fn small_sphere_is_found_from_afar() {
    // The quadratic's usual discriminant would have lost R^2 = 1 beside 1e18.
    let sphere = Sphere::new(DVec3::ZERO, 1.0).expect("valid");
    for (offset, meets) in [(0.999_999, true), (1.000_001, false)] {
        let hit = sphere.hit(&Ray::new(v(-1e9, offset, 0.0), DVec3::X));
        assert_eq!(hit.is_some(), meets, "offset {offset}");
        if let Some(hit) = hit {
            assert!((hit.point.y - offset).abs() <= 1e-12);
            assert!(hit.error <= 5.0 * f64::EPSILON);
        }
    }
}

#[test]
fn rectangle_and_disc_end_at_their_rims() {
    let table = Rectangle::new(v(1.0, 1.0, 1.0), 2.0 * DVec3::Y, 3.0 * DVec3::X).expect("valid");
    assert_eq!(table.normal(), DVec3::NEG_Z);
    assert!((table.area() - 6.0).abs() <= 1e-15);
    let disc = Disc::new(v(0.0, 0.0, 1.0), v(0.0, 0.0, 5.0), 2.0).expect("valid");
    let down = |x, y| Ray::new(v(x, y, 3.0), DVec3::NEG_Z);
    for (x, y, on) in [
        (1.0, 1.0, true),
        (4.0, 3.0, true),
        (3.9, 2.9, true),
        (4.1, 2.0, false),
        (2.0, 3.1, false),
        (0.9, 2.0, false),
        (2.0, 0.9, false),
    ] {
        assert_eq!(table.hit(&down(x, y)).is_some(), on, "({x}, {y})");
    }
    for (x, y, on) in [
        (0.0, 0.0, true),
        (2.0, 0.0, true),
        (1.41, 1.41, true),
        (1.42, 1.42, false),
        (-2.1, 0.0, false),
    ] {
        assert_eq!(disc.hit(&down(x, y)).is_some(), on, "({x}, {y})");
    }
}

#[test]
fn planes_across_an_axis_are_bounded_along_it_alone() {
    let bounds = Plane::new(v(1.0, 2.0, 3.0), -7.0 * DVec3::Y).expect("valid").bounds();
    assert_eq!(
        (bounds.min, bounds.max),
        (v(f64::NEG_INFINITY, 2.0, f64::NEG_INFINITY), v(f64::INFINITY, 2.0, f64::INFINITY))
    );
    let slanted = Plane::new(v(1.0, 2.0, 3.0), v(1e-20, 1.0, 0.0)).expect("valid").bounds();
    assert_eq!(slanted, crate::math::Aabb::ALL);
}

// Error bounds and departures, on shapes of all sizes and places.

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
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: prop::test_runner::RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn sphere_bound_holds_and_departures_are_clean(
        centre in position(), radius in sized(-3.0, 6.0), aim in direction(), within in direction(), away in sized(-3.0, 9.0),
        through_origin in any::<bool>()
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
        at in position(), normal in direction(), size in sized(-3.0, 6.0), aspect in 0.01..1.0, x in 0.0..0.7, y in 0.0..0.7,
        aim in direction(), away in sized(-3.0, 9.0), turn in 0.0..6.0, through_origin in any::<bool>()
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
            let Some(hit) = surface.hit(&Ray::new(at + shift - away.abs() * aim, aim)) else { continue };
            let off = exact::from_plane(hit.point.into(), at, truth).abs();
            prop_assert!(off <= hit.error, "{off:e} > {:e}", hit.error);
            prop_assert!(hit.error <= 8.0 * f64::EPSILON * ((hit.point - at).length() + at.length()));
            for_grazing_cosines(&hit, |direction, _| {
                let next = surface.hit(&hit.leave(direction));
                assert_eq!(next, None, "a flat shape is not met again");
            });
        }
    }

    #[test]
    fn box_departures_are_clean(
        at in position(), size in (sized(-3.0, 6.0), sized(-3.0, 6.0), sized(-3.0, 6.0)), within in direction(), aim in direction(),
        away in sized(-3.0, 9.0)
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

// The closed room.

/// Draws a cosine-distributed direction on the hit's outer side, now and then one that all but grazes.
fn bounce(hit: &Hit, [u, v, pick, graze]: [f64; 4]) -> DVec3 {
    let local = if pick < 0.2 {
        let cos = 10_f64.powf(-15.0 * graze);
        DVec3::new((6.3 * u).cos(), (6.3 * u).sin(), cos).normalize()
    } else if pick < 0.3 {
        // Exactly along a wall: zero components of either sign.
        [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y][(4.0 * u) as usize]
    } else {
        sampling::cosine_hemisphere([u, v])
    };
    Frame::about(hit.normal).to_world(local)
}

/// Follows `bounces` reflections in an inward box and counts the rays that find no wall or see the back of one.
fn escapes(room: &AxisBox, bounces: u64, mut aim: impl FnMut(&Hit, [f64; 4]) -> DVec3) -> u64 {
    let centre = room.bounds().centre();
    let start = || room.hit(&Ray::new(centre, v(0.36, 0.48, 0.8))).expect("from the middle");
    let (mut lost, mut hit) = (0, start());
    for i in 0..bounces {
        let direction = aim(&hit, Stream::new(Randomness::Pseudorandom, 5, i).next_4d());
        let ray = hit.leave(direction);
        let next = room.hit(&ray).filter(|next| next.normal.dot(direction) <= 0.0);
        lost += u64::from(next.is_none() || !room.bounds().contains(ray.origin));
        hit = next.unwrap_or_else(start);
    }
    lost
}

fn rooms() -> [AxisBox; 5] {
    [
        (DVec3::ZERO, v(4.0, 5.0, 3.0)),
        (v(-1.0, -0.3, -1.0 / 3.0), v(0.1, 0.7, 0.9)),
        (v(1e6, -1e6, 1e-3), v(1e6 + 3.0, 4.1 - 1e6, 2.7)),
        (v(-1e-3, 0.0, 1e-3), v(1e-3, 1e-3, 2e-3)),
        (v(0.0, 0.0, 1e6), v(1e6, 1.0, 1e6 + 1e-3)),
    ]
    .map(|(min, max)| AxisBox::new(min, max).expect("valid").turned_inward(true))
}

#[test]
fn nothing_escapes_from_a_closed_room_in_a_million_bounces() {
    for room in rooms() {
        assert_eq!(escapes(&room, 200_000, bounce), 0, "{room:?}");
    }
}

#[test]
fn nothing_escapes_through_edges_and_corners() {
    for room in rooms() {
        let (low, extent) = (room.bounds().min, room.bounds().extent());
        // Aims at points from 1e-12 down to 0 (of the room's size, then in ulps) off a random edge or corner, and beyond it.
        let lost = escapes(&room, 200_000, |hit, [u, w, pick, nudge]| {
            let mut at = v(u, w, pick);
            let corner = [u, w, pick].map(|x| (16.0 * x) as u32 % 2);
            for axis in 0..3 {
                if nudge < 0.3 || axis != (32.0 * u) as usize % 3 {
                    let tiny = [0.0, 1e-12, 1e-15, -1e-15, -1e-12, 3e-16][(64.0 * w) as usize % 6];
                    at[axis] = f64::from(corner[axis]) + tiny * nudge;
                }
            }
            let direction = (low + at * extent - hit.point).try_normalize();
            // The side of the wall is a walk's own choice: it never sends light behind it.
            let direction = direction.filter(|d| d.dot(hit.normal) != 0.0).unwrap_or(hit.normal);
            if direction.dot(hit.normal) < 0.0 { -direction } else { direction }
        });
        assert_eq!(lost, 0, "{room:?}");
    }
}

#[test]
fn every_ray_that_starts_in_a_closed_box_hits_it_from_inside() {
    // Origins in the box, on faces, on edges and in corners to the last bit; directions with zero components among them.
    let values = [0.0, f64::from_bits(1), 1e-12, 0.5, 1.0 - f64::EPSILON / 2.0, 1.0];
    let steps = [-1.0, -1e-300, -0.0, 0.0, 1e-9, 1.0];
    let room = unit_box().turned_inward(true);
    for i in 0..216 {
        let from = v(values[i % 6], values[i / 6 % 6], values[i / 36]);
        for j in 0..216 {
            let towards = v(steps[j % 6], steps[j / 6 % 6], steps[j / 36]);
            let Some(direction) = towards.try_normalize() else { continue };
            let hit = room.hit(&Ray::new(from, direction)).expect("closed");
            assert!(hit.distance >= 0.0 && hit.normal.dot(direction) < 0.0, "{from} {direction}");
        }
    }
}

#[test]
fn departed_corner_points_stay_inside() {
    let room = rooms()[0];
    let (low, high) = (room.bounds().min, room.bounds().max);
    for corner in [low, high, v(low.x, high.y, low.z), v(high.x, high.y, low.z)] {
        let inwards = (room.bounds().centre() - corner).normalize();
        let hit = room.hit(&Ray::new(room.bounds().centre(), -inwards)).expect("the corner");
        for direction in
            [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z, inwards]
        {
            if direction.dot(hit.normal) >= 0.0 {
                assert!(room.bounds().contains(hit.departure(direction)));
            }
        }
    }
}

// Sampling.

/// Averages over 2^16 scrambled Sobol points of the unit square.
fn mean(shape: &dyn SampleArea, f: impl Fn(&Hit) -> f64) -> f64 {
    let n = 1_u64 << 16;
    let sum: f64 = (0..n)
        .map(|i| {
            let u = DVec2::from_array(Stream::new(Randomness::Sobol, 9, i).next_2d());
            let at = shape.sample_area(u);
            assert!((at.density * shape.area() - 1.0).abs() <= 4.0 * f64::EPSILON);
            assert_eq!(at.density, shape.density(&at.hit));
            assert!((at.hit.normal.length() - 1.0).abs() <= 4.0 * f64::EPSILON);
            assert!(shape.bounds().contains(at.hit.point) && at.hit.distance == 0.0);
            f(&at.hit)
        })
        .sum();
    sum / n as f64
}

// 65536 Owen-scrambled points integrate these smooth or once-broken moments to a few times 1e-6 at worst; 1e-4 leaves room.
const MOMENT: f64 = 1e-4;

#[test]
fn sphere_and_disc_samples_have_uniform_moments() {
    let sphere = Sphere::new(v(1.0, 2.0, 3.0), 2.0).expect("valid");
    assert!((sphere.area() - 16.0 * PI).abs() <= 1e-13);
    for axis in 0..3 {
        let offset = |h: &Hit| h.point[axis] - sphere.centre()[axis];
        assert!(mean(&sphere, offset).abs() <= MOMENT);
        assert!((mean(&sphere, |h| offset(h).powi(2)) - 4.0 / 3.0).abs() <= MOMENT);
    }
    let disc = Disc::new(v(1.0, 2.0, 3.0), v(1.0, 1.0, 1.0), 2.0).expect("valid");
    let from_centre = |h: &Hit| (h.point - disc.centre()).length();
    assert!((disc.area() - 4.0 * PI).abs() <= 1e-14);
    assert!((mean(&disc, |h| from_centre(h).powi(2)) - 2.0).abs() <= MOMENT);
    assert!((mean(&disc, from_centre) - 4.0 / 3.0).abs() <= MOMENT);
}

#[test]
fn rectangle_and_box_samples_have_uniform_moments() {
    let table = Rectangle::new(v(1.0, 1.0, 1.0), 2.0 * DVec3::Y, 3.0 * DVec3::X).expect("valid");
    assert!((mean(&table, |h| h.point.x) - 2.5).abs() <= MOMENT);
    assert!((mean(&table, |h| (h.point.y - 2.0).powi(2)) - 1.0 / 3.0).abs() <= MOMENT);
    let room = AxisBox::new(DVec3::ZERO, v(4.0, 5.0, 3.0)).expect("valid");
    assert_eq!(room.area(), 94.0);
    for (part, area) in [15.0, 15.0, 12.0, 12.0, 20.0, 20.0].into_iter().enumerate() {
        let share = mean(&room, |h| f64::from(u8::from(h.part as usize == part)));
        assert!((share - area / 94.0).abs() <= MOMENT, "part {part}");
    }
    // On the floor and the lid x is uniform, on the x faces it is 0 or 4.
    let second = (2.0 * 15.0 * 4.0 + 64.0 * 4.0 / 3.0) / 94.0;
    assert!((mean(&room, |h| (h.point.x - 2.0).powi(2)) - second).abs() <= 2.0 * MOMENT);
}

/// Estimates the area by uniform directions from a point inside: the mean of 4 pi t^2/cos over the hits.
fn area_by_rays(shape: &dyn Surface, from: DVec3) -> f64 {
    let n = 1_u64 << 16;
    let sum: f64 = (0..n)
        .filter_map(|i| {
            let u = Stream::new(Randomness::Sobol, 3, i).next_2d();
            let ray = Ray::new(from, sampling::uniform_sphere(u));
            let hit = shape.hit(&ray)?;
            Some(hit.distance.powi(2) / hit.normal.dot(ray.direction).abs())
        })
        .sum();
    4.0 * PI * sum / n as f64
}

#[test]
fn area_agrees_with_the_solid_angle_of_rays() {
    // The integrand is broken at rims and edges: Sobol points are good to about n^-3/4 = 2.4e-4 of the area there.
    let from = v(0.2, 0.1, 0.3);
    let flat = Rectangle::new(v(-0.5, -0.4, 0.0), DVec3::X, DVec3::Y).expect("valid");
    let disc = Disc::new(v(0.1, 0.0, 0.0), DVec3::Z, 0.6).expect("valid");
    let sphere = Sphere::new(DVec3::ZERO, 1.0).expect("valid");
    let cube = AxisBox::new(v(-0.5, -0.3, -0.4), v(0.6, 0.7, 0.8)).expect("valid");
    let all: [&dyn SampleArea; 4] = [&flat, &disc, &sphere, &cube];
    for shape in all {
        let ratio = area_by_rays(shape, from) / shape.area();
        assert!((ratio - 1.0).abs() <= 3e-3, "{ratio}");
    }
}
