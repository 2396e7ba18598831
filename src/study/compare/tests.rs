use std::f64::consts::PI;

use glam::DVec3;

use super::*;
use crate::fit::{Resolution, tessellate};
use crate::sh::{Coefficients, Evaluator};

const DEFAULT: CompareSettings = CompareSettings { width: None, centre: DVec3::ZERO };

fn ball(radius: f64, centre: DVec3) -> Shape {
    let mut c = Coefficients::zeros(0);
    c.set(0, 0, radius, 0.0);
    Shape { centre, ..Shape::new(c) }
}

fn bumpy(k: f64) -> Shape {
    let mut c = Coefficients::zeros(6);
    c.set(0, 0, 1.0, 0.0);
    for l in 1..=6 {
        for m in 0..=l {
            c.set(l, m, k * ((3 * l + m) as f64).sin(), k * ((l + 5 * m) as f64).cos());
        }
    }
    Shape::new(c)
}

fn meshed(shape: &Shape, tolerance: f64) -> Mesh {
    let made = tessellate(&shape.coefficients, shape.centre, Resolution::Adaptive { tolerance });
    made.expect("positive").mesh
}

fn encloses(h: &Hausdorff, exact: f64, width: f64) {
    assert!(h.lower <= exact && exact <= h.upper, "{exact} {h:?}");
    assert!(h.upper - h.lower <= width, "{h:?}");
}

#[test]
fn bad_widths_and_empty_meshes_are_refused() {
    let a = ball(1.0, DVec3::ZERO);
    for width in [0.0, -1.0, f64::NAN] {
        let settings = CompareSettings { width: Some(width), ..DEFAULT };
        assert!(compare(Subject::Series(&a), Subject::Series(&a), &settings).is_err());
    }
    let empty = Mesh::default();
    assert!(compare(Subject::Series(&a), Subject::Mesh(&empty), &DEFAULT).is_err());
    let negative = ball(-1.0, DVec3::ZERO);
    for other in [&a, &negative] {
        let refused = compare(Subject::Series(&negative), Subject::Series(other), &DEFAULT);
        assert!(refused.is_err_and(|e| e.to_string().contains("the radius towards")));
    }
}

#[test]
fn concentric_balls_differ_by_their_radii() {
    let (a, b) = (ball(1.0, DVec3::X), ball(1.25, DVec3::X));
    let found = compare(Subject::Series(&a), Subject::Series(&b), &DEFAULT).expect("compared");
    encloses(&found.hausdorff, 0.25, 4e-3);
    let radial = found.radial.expect("one centre");
    assert!((radial.rms - 0.25).abs() <= 1e-15 && (radial.max - 0.25).abs() <= 1e-14);
    // Nearest points of tessellations are off the common radius by an edge at most.
    assert!(found.normals.mean <= 0.02 && found.normals.percentile_95 <= 0.05);
    assert!((found.volumes[1].expect("closed") - 4.0 / 3.0 * PI * 1.25_f64.powi(3)).abs() <= 1e-12);
    assert!((found.areas[0] / (4.0 * PI) - 1.0).abs() <= 1e-12);
}

#[test]
fn balls_about_two_centres_have_no_radial_difference() {
    let (a, b) = (ball(1.0, DVec3::ZERO), ball(1.0, DVec3::new(0.0, 0.3, 0.0)));
    let found = compare(Subject::Series(&a), Subject::Series(&b), &DEFAULT).expect("compared");
    encloses(&found.hausdorff, 0.3, 4e-3);
    let reason = found.radial.expect_err("two centres").to_string();
    assert_eq!(reason, "their centres are 3.000e-1 m apart");
}

/// Holds the intervals of ever narrower widths to the two one-sided distances: each contains its
/// distance, is no wider than asked for and lies in the one before.
fn narrows(a: Subject, b: Subject, exact: [f64; 2], accuracy: f64) {
    let mut before = [[0.0, f64::INFINITY]; 2];
    for width in [0.1, 0.01, 0.001, 1e-4] {
        let settings = CompareSettings { width: Some(width), ..DEFAULT };
        let found = compare(a, b, &settings).expect("compared").hausdorff;
        assert!(found.upper - found.lower <= width && found.limit().is_none(), "{found:?}");
        for (i, p) in found.one_sided.iter().enumerate() {
            assert!(p.lower <= exact[i] + accuracy && exact[i] <= p.upper + accuracy, "{p:?}");
            assert!(p.upper - p.lower <= width, "{width} {p:?}");
            assert!(found.lower >= p.lower && found.upper >= p.upper);
            assert!(p.lower >= before[i][0] && p.upper <= before[i][1], "{width} {p:?}");
            before[i] = [p.lower, p.upper];
        }
    }
}

/// Makes a body of revolution.
fn turned(degrees: &[f64]) -> Shape {
    let mut c = Coefficients::zeros(degrees.len() - 1);
    degrees.iter().enumerate().for_each(|(l, value)| c.set(l, 0, *value, 0.0));
    Shape::new(c)
}

/// Measures how far the outline of the first of two bodies of revolution is from that of the
/// second, by trying many points of both.
fn tried(a: &Shape, b: &Shape) -> f64 {
    let outline = |shape: &Shape, count: usize| -> Vec<DVec3> {
        let series = Evaluator::new(&shape.coefficients).expect("a low degree");
        let angle = |i: usize| PI * i as f64 / count as f64;
        let w = |i: usize| DVec3::new(angle(i).sin(), 0.0, angle(i).cos());
        (0..=count).map(|i| series.value(w(i)) * w(i)).collect()
    };
    let (from, onto) = (outline(a, 1600), outline(b, 4000));
    let nearest = |p: &DVec3| onto.iter().map(|q| p.distance(*q)).fold(f64::INFINITY, f64::min);
    from.iter().map(nearest).fold(0.0, f64::max)
}

#[test]
fn spheres_have_their_distance_at_every_width() {
    // Any point of either is from the other what it is from the other's centre less the radius.
    let (a, b) = (ball(1.0, DVec3::ZERO), ball(1.5, DVec3::new(0.0, 0.16, 0.12)));
    narrows(Subject::Series(&a), Subject::Series(&b), [0.7; 2], 0.0);
}

#[test]
fn bodies_of_revolution_have_the_distances_of_their_outlines() {
    let wavy = turned(&[1.0, 0.0, -0.2, 0.1, 0.0, 0.05, 0.0, 0.0, 0.03]);
    let cut = Shape::new(wavy.coefficients.truncated(4));
    for (a, b) in [(&wavy, &turned(&[1.0])), (&wavy, &cut)] {
        // 4000 points of an outline are at most 1e-3 apart, so that a distance d of 0.03 or more
        // is too large by at most 1e-6 / 8 d; 1600 miss the largest by as little.
        let exact = [tried(a, b), tried(b, a)];
        narrows(Subject::Series(a), Subject::Series(b), exact, 2e-5);
    }
}

#[test]
fn a_cube_and_a_sphere_have_their_two_distances() {
    let cube = crate::mesh::shapes::cube().translated(DVec3::splat(-0.5)).scaled(2.0);
    let cube = cube.expect("positive");
    let sphere = ball(1.0, DVec3::ZERO);
    // A corner from the sphere; the point below the corner from the three faces.
    let exact = [3_f64.sqrt() - 1.0, 1.0 - 1.0 / 3_f64.sqrt()];
    narrows(Subject::Mesh(&cube), Subject::Series(&sphere), exact, 0.0);
}

#[test]
fn a_series_is_at_no_distance_from_itself() {
    let shape = bumpy(0.03);
    let found = compare(Subject::Series(&shape), Subject::Series(&shape), &DEFAULT);
    let found = found.expect("compared").hausdorff;
    assert_eq!((found.lower, found.upper, found.limit()), (0.0, 0.0, None));
}

#[test]
fn a_width_below_rounding_is_not_met_and_said() {
    // A billion metres away a number has ten digits behind the point less.
    let far = DVec3::new(1e9, 0.0, 0.0);
    let (a, b) = (ball(1.0, far), ball(1.0, far + DVec3::new(0.0, 0.3, 0.0)));
    let settings = CompareSettings { width: Some(1e-9), ..DEFAULT };
    let found = compare(Subject::Series(&a), Subject::Series(&b), &settings).expect("compared");
    assert_eq!(found.hausdorff.limit(), Some(Limit::Rounding));
    encloses(&found.hausdorff, 0.3, 1e-4);
}

#[test]
fn a_shape_is_as_far_from_its_mesh_as_the_chords() {
    let shape = bumpy(0.02);
    let made = tessellate(&shape.coefficients, DVec3::ZERO, Resolution::Icosphere { frequency: 8 });
    let made = made.expect("positive");
    let settings = CompareSettings { width: Some(2e-3), ..DEFAULT };
    for swap in [false, true] {
        let pair = [Subject::Series(&shape), Subject::Mesh(&made.mesh)];
        let found = compare(pair[usize::from(swap)], pair[usize::from(!swap)], &settings);
        let found = found.expect("compared");
        let bound = made.chord_error.bound.expect("low degree");
        assert!(
            found.hausdorff.lower <= bound
                && found.hausdorff.upper >= 0.9 * made.chord_error.measured
        );
        assert!(found.radial.expect("star-shaped").max <= bound);
        // Faces of 9 degrees are tilted by a few degrees against the surface.
        assert!(found.normals.percentile_95.to_degrees() <= 8.0);
    }
}

#[test]
fn two_meshes_are_compared_about_the_origin_when_that_sees_both() {
    let (a, b) = (meshed(&bumpy(0.02), 1e-3), meshed(&bumpy(0.03), 1e-3));
    let found = compare(Subject::Mesh(&a), Subject::Mesh(&b), &DEFAULT).expect("compared");
    let series = compare(Subject::Series(&bumpy(0.02)), Subject::Series(&bumpy(0.03)), &DEFAULT);
    let series = series.expect("compared");
    let (mesh, exact) = (found.radial.expect("star-shaped"), series.radial.expect("one centre"));
    assert!((mesh.rms - exact.rms).abs() <= 1e-3 && (mesh.max - exact.max).abs() <= 4e-3);
    assert!((found.hausdorff.upper - series.hausdorff.upper).abs() <= 8e-3);
    let moved = CompareSettings { centre: DVec3::splat(5.0), ..DEFAULT };
    let found = compare(Subject::Mesh(&a), Subject::Mesh(&b), &moved).expect("compared");
    assert!(found.radial.is_err_and(|reason| reason.to_string().starts_with("the first: ")));
}

#[test]
fn open_meshes_have_distances_and_no_volume() {
    let sheet = |z: f64| {
        let p = |x, y| DVec3::new(x, y, z);
        let corners = vec![p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)];
        Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).expect("indices in range")
    };
    let (a, b) = (sheet(0.0), sheet(0.5));
    let found = compare(Subject::Mesh(&a), Subject::Mesh(&b), &DEFAULT).expect("compared");
    encloses(&found.hausdorff, 0.5, 1e-3);
    assert_eq!((found.volumes, found.areas), ([None, None], [1.0, 1.0]));
    assert!(found.normals.percentile_95 <= 1e-7 && found.radial.is_err());
    let map = |a, b| {
        let pair = Pair::new(Subject::Mesh(a), Subject::Mesh(b), &DEFAULT).expect("ready");
        pair.distance_map().expect("a mesh").distances
    };
    assert_eq!(map(&a, &b), [0.5; 4]);
    assert_eq!(map(&b, &a), [-0.5; 4]);
}

#[test]
fn colours_run_from_blue_over_white_to_red() {
    let map = DistanceMap { mesh: Mesh::default(), distances: vec![-2.0, 0.0, 2.0] };
    assert_eq!(map.colours(), (vec![[0, 114, 178], [255; 3], [178, 24, 43]], 2.0));
    let none = DistanceMap { mesh: Mesh::default(), distances: vec![0.0] };
    assert_eq!(none.colours(), (vec![[255; 3]], 0.0));
}
