//! The head: its fit against the figures of data/README.md, mesh and SH body against each other.

use std::f64::consts::PI;
use std::path::Path;

use crate::common::{sphere_mesh, split_faces};
use glam::DVec3;
use harmolux::fit::{RadialMesh, RadialSamples, fit_error, project_conforming, project_grid};
use harmolux::io::meshes;
use harmolux::math::Ray;
use harmolux::math::sampling::uniform_sphere;
use harmolux::mesh::Mesh;
use harmolux::sh::{Coefficients, scattered_fit, volume};
use harmolux::surface::{Intersector, MeshSurface, ShSurface, StepBisection, Surface};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

fn head() -> Mesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/head.obj");
    meshes::read(&path).expect("the head can be read")
}

/// Rounds to as many digits as data/README.md gives.
fn percent(x: f64, digits: usize) -> String {
    format!("{:.digits$}", 100.0 * x)
}

#[test]
fn fit_has_the_published_errors_and_volume() {
    let mesh = head();
    let finest = project_conforming(&mesh, DVec3::ZERO, 128).expect("fits");
    let mean = finest.mean();
    assert_eq!(format!("{mean:.7}"), "0.0939276");
    let error = |f: &Coefficients| {
        fit_error(&RadialMesh::star(&mesh, DVec3::ZERO), f).expect("valid degree")
    };
    // The square of the radius, for Parseval: the error of degree 0 with a zero series.
    let whole = error(&Coefficients::zeros(128)).rms;
    for (lmax, rms, max) in
        [(4, "3.654", ""), (16, "0.933", "15.4"), (32, "0.519", "14.5"), (64, "0.249", "8.1")]
    {
        let f = finest.truncated(lmax);
        let found = error(&f);
        assert_eq!(percent(found.rms / mean, 3), rms, "degree {lmax}");
        let parseval = (whole * whole - f.energy() / (4.0 * PI)).sqrt();
        // The coarser rule of the lower degree leaves 1e-6 of the error.
        assert!((parseval / found.rms - 1.0).abs() <= 1e-5, "degree {lmax}");
        assert!(max.is_empty() || percent(found.max / mean, 1) == max, "{}", found.max / mean);
    }
    for (lmax, volume_of) in [(16, "3.65756"), (32, "3.65818"), (64, "3.65841")] {
        let v = volume(&finest.truncated(lmax)).expect("valid degree");
        assert_eq!(format!("{:.5}", 1e3 * v), volume_of, "degree {lmax}");
    }
}

#[test]
fn conforming_projection_is_converged() {
    // Splitting every face in four quarters the work's error at least 2^6-fold: the difference is
    // the error of the coarse one.
    let mesh = head();
    let coarse = project_conforming(&mesh, DVec3::ZERO, 32).expect("fits");
    let fine = project_conforming(&split_faces(&mesh), DVec3::ZERO, 32).expect("fits");
    let pairs = coarse
        .cosines()
        .iter()
        .chain(coarse.sines())
        .zip(fine.cosines().iter().chain(fine.sines()));
    let worst = pairs.fold(0.0_f64, |w, (a, b)| w.max((a - b).abs()));
    assert!(worst <= 1e-9 * coarse.mean(), "{:e}", worst / coarse.mean());
}

#[test]
fn grid_projection_agrees_with_the_conforming_one() {
    let mesh = head();
    let exact = project_conforming(&mesh, DVec3::ZERO, 32).expect("fits");
    let surface = MeshSurface::new(mesh).expect("valid");
    let difference = |oversampling| {
        let grid = project_grid(&surface, DVec3::ZERO, 32, oversampling).expect("fits");
        let minus = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
        let (a, b) = (minus(grid.cosines(), exact.cosines()), minus(grid.sines(), exact.sines()));
        let difference = Coefficients::from_parts(32, a, b).expect("finite");
        (difference.energy() / (4.0 * PI)).sqrt() / exact.mean()
    };
    // A mesh is not band-limited: what is beyond the grid's degree aliases, less so on a finer
    // grid.
    let (coarse, fine) = (difference(1), difference(4));
    assert!(coarse <= 1e-2 && fine <= 2e-4 && fine <= 0.05 * coarse, "{coarse:e} {fine:e}");
}

#[test]
fn least_squares_over_the_vertices_agree_with_the_conforming_projection() {
    let mesh = head();
    let lmax = 24;
    let radius = RadialMesh::star(&mesh, DVec3::ZERO);
    let exact = project_conforming(&mesh, DVec3::ZERO, lmax).expect("fits");
    let RadialSamples { directions, radii, weights } = radius.vertex_samples();
    let fit = scattered_fit(&directions, &radii, &weights, lmax, 0.0).expect("determined");
    let minus = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
    let (a, b) = (minus(fit.cosines(), exact.cosines()), minus(fit.sines(), exact.sines()));
    let difference = Coefficients::from_parts(lmax, a, b).expect("finite");
    let rms = (difference.energy() / (4.0 * PI)).sqrt();
    // The stated error: what truncation leaves scatters over the vertices, and of each vertex the
    // share coefficients / vertices comes back.
    let truncation = fit_error(&radius, &exact).expect("valid degree").rms;
    let stated = truncation * (exact.count() as f64 / directions.len() as f64).sqrt();
    assert!(rms <= 1.5 * stated, "{rms:e} of {stated:e}");
}

/// Random chords of a ball.
fn chords(radius: f64, count: usize, seed: u64) -> Vec<Ray> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut point = || radius * uniform_sphere(rng.random());
    (0..count)
        .filter_map(|_| Ray::between(point(), point()))
        .map(|ray| ray.up_to(f64::INFINITY))
        .collect()
}

#[test]
fn both_intersectors_agree_on_100_000_rays() {
    let coefficients = project_conforming(&head(), DVec3::ZERO, 32).expect("fits");
    let certified = ShSurface::new(&coefficients, Intersector::Certified).expect("positive radius");
    let step = 0.01;
    let march = StepBisection { step, tolerance: 1e-10 };
    let march =
        ShSurface::new(&coefficients, Intersector::StepBisection(march)).expect("positive radius");
    let radius = certified.body().bounds().max;
    let verdicts: Vec<(bool, bool)> = chords(1.1 * radius, 100_000, 1)
        .par_iter()
        .map(|ray| {
            let (a, b) = (certified.hit(ray), march.hit(ray));
            assert_eq!(certified.blocked(ray), a.is_some());
            match (a, b) {
                (Some(a), Some(b)) if (a.distance - b.distance).abs() <= 1e-8 * radius => {
                    assert!(certified.body().gap_value(a.point).abs() <= a.error);
                    (true, false)
                }
                (None, None) => (false, false),
                (Some(a), _) => {
                    // The march may jump over what it documents: a lobe that the ray leaves within
                    // one step.
                    let beyond = ray.at(a.distance + step * radius);
                    assert!(certified.body().gap_value(beyond) > 0.0, "{ray:?}");
                    (true, true)
                }
                (None, Some(_)) => panic!("certified stepping missed {ray:?}"),
            }
        })
        .collect();
    let hits = verdicts.iter().filter(|v| v.0).count();
    let thin = verdicts.iter().filter(|v| v.1).count();
    assert!(hits >= 30_000 && thin <= 200, "{hits} hits, {thin} thin lobes");
}

#[test]
fn sh_body_and_mesh_of_the_same_sphere_agree() {
    let mesh = sphere_mesh(6, |w| w);
    let depth = (0..mesh.triangles().len())
        .map(|f| 1.0 - mesh.normal(f).expect("not degenerate").dot(mesh.corners(f)[0]))
        .fold(0.0, f64::max);
    let coefficients = project_conforming(&mesh, DVec3::ZERO, 8).expect("fits");
    let sphere = ShSurface::new(&coefficients, Intersector::Certified).expect("positive radius");
    let polyhedron = MeshSurface::new(mesh).expect("valid");
    for ray in chords(1.5, 20_000, 2) {
        let offset = ray.at(-ray.origin.dot(ray.direction)).length();
        match (sphere.hit(&ray), polyhedron.hit(&ray)) {
            (Some(a), Some(b)) => {
                // A radial difference d moves the hit by at most d / cos, cos from the ray's
                // distance to the centre.
                let cos = (1.0 - offset * offset).max(1e-9).sqrt();
                assert!((a.distance - b.distance).abs() <= 4.0 * depth / cos + 1e-9);
                assert!(a.normal.dot(b.normal) >= 1.0 - 1e-3);
            }
            (None, None) => {}
            _ => assert!((offset - 1.0).abs() <= 2.0 * depth, "{offset}"),
        }
    }
}

#[test]
fn normals_match_central_differences_at_the_poles_too() {
    let coefficients = project_conforming(&head(), DVec3::ZERO, 32).expect("fits");
    let s = ShSurface::new(&coefficients, Intersector::Certified).expect("positive radius");
    let point = |w: DVec3| w * s.body().series().value(w);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
    let random = (0..200).map(|_| uniform_sphere(rng.random()));
    let poles = [
        DVec3::Z,
        DVec3::NEG_Z,
        DVec3::new(1e-7, 0.0, 1.0).normalize(),
        DVec3::new(0.0, -1e-9, -1.0).normalize(),
    ];
    for w in random.chain(poles) {
        let (u, v) = w.any_orthonormal_pair();
        // Fourth-order differences: truncation and rounding both stay below 1e-8 at this step.
        let h = 1e-3_f64;
        let along = |t: DVec3| {
            let at = |a: f64| point(w * a.cos() + t * a.sin());
            (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h)
        };
        let n = along(u).cross(along(v)).normalize();
        let n = n * n.dot(w).signum();
        assert!((n - s.at(w).normal).length() <= 1e-7, "{w}: {:e}", (n - s.at(w).normal).length());
    }
}
