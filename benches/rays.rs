//! First hits and occlusion on the head, random chords of its bounding ball, and in a hall of many
//! heads, random chords of the hall; one thread: `cargo bench --bench rays`.
//!
//! Peer: Embree's rtcIntersect1 and rtcOccluded1 on data/head.obj with random chords.

use std::path::Path;
use std::sync::Arc;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::{DQuat, DVec3};
use harmolux::fit::project_conforming;
use harmolux::io::meshes;
use harmolux::math::sampling::uniform_sphere;
use harmolux::math::{Placement, Ray, Rgb};
use harmolux::mesh::Mesh;
use harmolux::scene::{Material, Object, Scene};
use harmolux::surface::primitives::AxisBox;
use harmolux::surface::{Instance, Intersector, MeshSurface, ShSurface, StepBisection, Surface};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const RAYS: usize = 1000;

fn main() {
    divan::main();
}

fn head() -> Mesh {
    meshes::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("data/head.obj")).expect("the head")
}

fn chords() -> Vec<Ray> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut point = || 0.1414 * uniform_sphere(rng.random());
    (0..RAYS)
        .filter_map(|_| Ray::between(point(), point()))
        .map(|ray| ray.up_to(f64::INFINITY))
        .collect()
}

fn run(bencher: Bencher, surface: &dyn Surface, occlusion: bool) {
    let rays = chords();
    bencher.counter(ItemsCount::new(rays.len())).bench_local(|| {
        let met =
            |ray: &&Ray| if occlusion { surface.blocked(ray) } else { surface.hit(ray).is_some() };
        black_box(&rays).iter().filter(met).count()
    });
}

fn body(lmax: usize, intersector: Intersector) -> ShSurface {
    let coefficients = project_conforming(&head(), DVec3::ZERO, lmax).expect("fits");
    ShSurface::new(&coefficients, intersector).expect("a positive radius")
}

#[divan::bench(args = [8, 16, 32, 64])]
fn certified_first_hit(bencher: Bencher, lmax: usize) {
    run(bencher, &body(lmax, Intersector::Certified), false);
}

#[divan::bench(args = [8, 16, 32, 64])]
fn certified_occlusion(bencher: Bencher, lmax: usize) {
    run(bencher, &body(lmax, Intersector::Certified), true);
}

#[divan::bench]
fn step_and_bisection_degree_32(bencher: Bencher) {
    run(bencher, &body(32, Intersector::StepBisection(StepBisection::default())), false);
}

#[divan::bench]
fn mesh_first_hit(bencher: Bencher) {
    run(bencher, &MeshSurface::new(head()).expect("valid"), false);
}

#[divan::bench]
fn mesh_occlusion(bencher: Bencher) {
    run(bencher, &MeshSurface::new(head()).expect("valid"), true);
}

/// Puts `heads` heads of degree 16, a metre apart, into a hall of 32 m x 32 m x 4 m.
fn hall(heads: usize) -> Scene {
    let grey = Material::lambert(Rgb::grey(0.5)).expect("valid");
    let walls = AxisBox::new(DVec3::ZERO, DVec3::new(32.0, 32.0, 4.0)).expect("valid");
    let head = Arc::new(body(16, Intersector::default()));
    let mut objects = vec![Object::new("hall", walls.turned_inward(true), grey.clone())];
    objects.extend((0..heads).map(|i| {
        // Three times its size, a head reaches 0.42 m at most; neighbours stand at different
        // heights.
        let at = DVec3::new((i % 31) as f64, (i / 31 % 31) as f64, 0.25 * (i % 7) as f64) + 0.75;
        let turn = DQuat::from_rotation_z(i as f64);
        let placement = Placement::new(turn, 3.0, at).expect("valid");
        Object::new("head", Instance::new(Arc::clone(&head), placement), grey.clone())
    }));
    Scene::new(objects, Vec::new()).expect("valid")
}

fn run_hall(bencher: Bencher, heads: usize, answer: impl Fn(&Scene, &[Ray]) -> usize) {
    let scene = hall(heads);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    let mut point = || DVec3::from(rng.random::<[f64; 3]>()) * DVec3::new(32.0, 32.0, 4.0);
    let rays: Vec<Ray> = (0..RAYS).filter_map(|_| Ray::between(point(), point())).collect();
    bencher.counter(ItemsCount::new(rays.len())).bench_local(|| answer(&scene, black_box(&rays)));
}

#[divan::bench(args = [1, 10, 100, 1000])]
fn hall_first_hit(bencher: Bencher, heads: usize) {
    run_hall(bencher, heads, |scene, rays| {
        let mut hits = vec![None; rays.len()];
        scene.hits(rays, &mut hits);
        hits.iter().flatten().count()
    });
}

#[divan::bench(args = [1, 10, 100, 1000])]
fn hall_occlusion(bencher: Bencher, heads: usize) {
    run_hall(bencher, heads, |scene, rays| {
        let mut blocked = vec![false; rays.len()];
        scene.mark_blocked(rays, &mut blocked);
        blocked.iter().filter(|blocked| **blocked).count()
    });
}
