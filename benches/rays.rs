//! First hits and occlusion on the head, random chords of its bounding ball, one thread: `cargo bench --bench rays`.
//!
//! Peer: Embree's rtcIntersect1 and rtcOccluded1 on data/head.obj with random chords.

use std::path::Path;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::DVec3;
use harmolux::io::meshes;
use harmolux::math::Ray;
use harmolux::math::sampling::uniform_sphere;
use harmolux::surface::{
    Intersector, Mesh, MeshSurface, ShSurface, StepBisection, Surface, project_conforming,
};
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
