//! Tests of the shapes: degenerate inputs and analytic hits here; departures, closed rooms and
//! sampling in files of their own.

mod closed_room;
mod departures;
mod sampling;

use glam::DVec3;

use super::{AxisBox, Disc, Plane, Rectangle, Sphere};
use crate::math::Ray;
use crate::surface::{SampleArea, Surface};

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
