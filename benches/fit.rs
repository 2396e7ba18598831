//! The head's projection onto the basis, all threads: `cargo bench --bench fit`.
//!
//! Peer: a script of trimesh, Embree and pyshtools takes 0.21 s for a grid that aliases to 1e-3.

use std::path::Path;

use divan::Bencher;
use glam::DVec3;
use harmolux::io::meshes;
use harmolux::surface::{Mesh, MeshSurface, project_conforming, project_grid};

fn main() {
    divan::main();
}

fn head() -> Mesh {
    meshes::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("data/head.obj")).expect("the head")
}

#[divan::bench(args = [8, 16, 32, 64])]
fn conforming(bencher: Bencher, lmax: usize) {
    let mesh = head();
    bencher.bench_local(|| project_conforming(&mesh, DVec3::ZERO, lmax));
}

#[divan::bench(args = [8, 16, 32, 64])]
fn grid_oversampled_4_times(bencher: Bencher, lmax: usize) {
    let surface = MeshSurface::new(head()).expect("valid");
    bencher.bench_local(|| project_grid(&surface, DVec3::ZERO, lmax, 4));
}
