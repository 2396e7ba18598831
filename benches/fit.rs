//! The head's projection onto the basis, all threads: `cargo bench --bench fit`.
//!
//! Peer: a script of trimesh, Embree and pyshtools takes 0.21 s for a grid that aliases to 1e-3.

use std::path::Path;

use divan::Bencher;
use glam::DVec3;
use harmolux::fit::{
    Envelope, RadialMesh, fit_error, project_conforming, project_faces, project_grid,
};
use harmolux::io::meshes;
use harmolux::mesh::Mesh;
use harmolux::sh::scattered_fit;
use harmolux::surface::MeshSurface;

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

/// From degree 96 on nodes go by way of a grid.
#[divan::bench(args = [95, 96, 256, 512], sample_count = 3)]
fn conforming_of_high_degree(bencher: Bencher, lmax: usize) {
    let mesh = head();
    bencher.bench_local(|| project_conforming(&mesh, DVec3::ZERO, lmax));
}

/// What an envelope costs beyond the plain projection: two rays a node.
#[divan::bench(args = [32], sample_count = 10)]
fn envelope(bencher: Bencher, lmax: usize) {
    let mesh = head();
    let radius = RadialMesh::folded(&mesh, DVec3::ZERO, Envelope::Outermost).expect("inside");
    bencher.bench_local(|| project_faces(&radius, lmax));
}

#[divan::bench(args = [8, 16, 32], sample_count = 10)]
fn least_squares_over_the_vertices(bencher: Bencher, lmax: usize) {
    let mesh = head();
    let samples = RadialMesh::star(&mesh, DVec3::ZERO).vertex_samples();
    let (at, radii, weights) = (&samples.directions, &samples.radii, &samples.weights);
    bencher.bench_local(|| scattered_fit(at, radii, weights, lmax, 0.0));
}

#[divan::bench(args = [8, 16, 32, 64])]
fn grid_oversampled_4_times(bencher: Bencher, lmax: usize) {
    let surface = MeshSurface::new(head()).expect("valid");
    bencher.bench_local(|| project_grid(&surface, DVec3::ZERO, lmax, 4));
}

#[divan::bench(args = [32])]
fn errors_of_a_fit(bencher: Bencher, lmax: usize) {
    let mesh = head();
    let series = project_conforming(&mesh, DVec3::ZERO, lmax).expect("fits");
    bencher.bench_local(|| fit_error(&RadialMesh::star(&mesh, DVec3::ZERO), &series));
}
