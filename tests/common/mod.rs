//! Scenes and settings that several test files share.
#![allow(dead_code, unreachable_pub, reason = "each test binary uses its own part")]

#[cfg(feature = "cli")]
pub mod desk;
pub mod films;
#[cfg(feature = "cli")]
pub mod running;
pub mod scenes;
pub mod solids;

use std::f64::consts::PI;
use std::ops::ControlFlow;

use glam::{DQuat, DVec3};
use harmolux::estimators::{Estimator, ImageSettings, Progress, SensorSettings, Stop};
use harmolux::math::{Placement, Randomness, Rgb};
use harmolux::mesh::Mesh;
use harmolux::scene::{Camera, Filter, Material, Object};
use harmolux::sh::Coefficients;
use harmolux::surface::primitives::AxisBox;
use harmolux::surface::{Instance, Intersector, SampleArea, ShSurface};
use std::sync::Arc;

/// Lets a run go on.
pub fn go_on(_: &Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// A Lambertian material.
pub fn grey(reflectance: f64) -> Material {
    Material::lambert(Rgb::grey(reflectance)).expect("a valid reflectance")
}

/// A Lambertian material whose emission makes any closed scene of such materials a furnace of
/// luminance `l0`: exitance pi L0 (1 - rho).
pub fn furnace(reflectance: f64, l0: f64) -> Material {
    grey(reflectance).emitting(Rgb::grey(PI * l0 * (1.0 - reflectance)))
}

/// A closed room with one material for each of its six faces.
pub fn room(size: DVec3, materials: &[Material; 6]) -> Object {
    let walls = AxisBox::new(DVec3::ZERO, size).expect("a valid box").turned_inward(true);
    Object { materials: materials.to_vec(), ..Object::new("room", walls, materials[0].clone()) }
}

/// A bumpy body of degree 12 and mean radius 1.
pub fn bumpy() -> ShSurface {
    let mut c = Coefficients::zeros(12);
    c.set(0, 0, 1.0, 0.0);
    for l in 1..=12 {
        for m in 0..=l {
            let k = 0.25 / (l * l) as f64;
            c.set(l, m, k * ((3 * l + m) as f64).sin(), k * ((l + 5 * m) as f64).cos());
        }
    }
    ShSurface::new(&c, Intersector::Certified).expect("a positive radius")
}

/// Places a surface at `at`, scaled.
pub fn placed<S: SampleArea + 'static>(surface: S, at: DVec3, scale: f64) -> Instance<S> {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    Instance::new(Arc::new(surface), Placement::new(turn, scale, at).expect("a valid placement"))
}

/// A small camera.
pub fn camera(from: DVec3, to: DVec3, resolution: [u32; 2]) -> Camera {
    Camera::perspective(from, to, 60.0_f64.to_radians(), resolution).expect("a valid camera")
}

/// Image settings with a fixed seed for as many samples of a pixel as take `paths` paths, or four
/// times as many walks.
pub fn image(estimator: Estimator, paths: u64) -> ImageSettings {
    let walks = if estimator == Estimator::Path { paths } else { 4 * paths };
    let stop = Stop { walks: Some(walks), ..Stop::default() };
    ImageSettings {
        estimator,
        randomness: Randomness::Sobol,
        seed: 2012,
        stop,
        filter: Filter::Tent,
    }
}

/// Sensor settings with `walks` in all and a fixed seed.
pub fn sensors(estimator: Estimator, walks: u64) -> SensorSettings {
    let stop = Stop { walks: Some(walks), ..Stop::default() };
    SensorSettings { estimator, randomness: Randomness::Sobol, seed: 2012, stop }
}

/// An octahedron whose faces are split in four `times` times, each vertex moved to `place` of its
/// direction from the origin.
pub fn sphere_mesh(times: usize, place: impl Fn(DVec3) -> DVec3) -> Mesh {
    let p = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let faces = vec![
        [0, 1, 4],
        [1, 2, 4],
        [2, 3, 4],
        [3, 0, 4],
        [1, 0, 5],
        [2, 1, 5],
        [3, 2, 5],
        [0, 3, 5],
    ];
    let mut mesh = Mesh::new(p.to_vec(), faces).expect("valid");
    for _ in 0..times {
        mesh = split_faces(&mesh);
    }
    let positions = mesh.positions().iter().map(|p| place(p.normalize())).collect();
    Mesh::new(positions, mesh.triangles().to_vec()).expect("as valid as the octahedron")
}

/// Splits every face in four at the middles of its edges; vertices are not shared.
pub fn split_faces(mesh: &Mesh) -> Mesh {
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for face in 0..mesh.triangles().len() {
        let [a, b, c] = mesh.corners(face);
        let first = u32::try_from(positions.len()).expect("small");
        positions.extend([a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)]);
        let quarters: [[u32; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];
        faces.extend(quarters.map(|f| f.map(|i| i + first)));
    }
    Mesh::new(positions, faces).expect("as valid as the whole")
}
