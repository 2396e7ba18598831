//! Meshes with one fault each, and mended.

use glam::DVec3;

use super::*;
use crate::mesh::{MeshReport, shapes};

fn mended(mesh: &Mesh, settings: RepairSettings) -> (Mesh, RepairReport) {
    repair(mesh, &settings).expect("valid settings")
}

fn changed(mesh: &Mesh, change: impl Fn(&mut Vec<DVec3>, &mut Vec<[u32; 3]>)) -> Mesh {
    let (mut positions, mut triangles) = (mesh.positions().to_vec(), mesh.triangles().to_vec());
    change(&mut positions, &mut triangles);
    Mesh::new(positions, triangles).expect("indices in range")
}

/// Returns every face its own three vertices, each moved by up to `by`.
fn soup(mesh: &Mesh, by: f64) -> Mesh {
    let corners = (0..mesh.triangles().len()).flat_map(|f| mesh.corners(f));
    let moved =
        corners.enumerate().map(|(i, p)| p + by * DVec3::new((i % 3) as f64 - 1.0, 0.0, 0.0));
    let triangles = (0..mesh.triangles().len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]);
    Mesh::new(moved.collect(), triangles.collect()).expect("indices in range")
}

fn is_clean(mesh: &Mesh) -> bool {
    let report = MeshReport::of(mesh);
    report.deficiencies().is_empty() && report.is_closed() && report.unused_vertices == 0
}

#[test]
fn empty_and_clean_meshes_stay_as_they_are() {
    for mesh in [Mesh::default(), shapes::cube(), shapes::torus(6, 5), shapes::u_shape()] {
        let settings = RepairSettings { weld: 1e-6, largest_only: true, fill: 9 };
        let (same, done) = mended(&mesh, settings);
        assert!(same == mesh && done.is_empty());
        assert_eq!(done.to_string(), "nothing to repair");
    }
}

#[test]
fn welding_distance_must_be_a_length() {
    for weld in [-1.0, f64::NAN, f64::INFINITY] {
        let settings = RepairSettings { weld, ..RepairSettings::default() };
        assert!(repair(&shapes::cube(), &settings).is_err());
    }
}

#[test]
fn soup_is_welded_exactly_or_within_a_distance() {
    let sphere = shapes::sphere(3);
    let (mesh, done) = mended(&soup(&sphere, 0.0), RepairSettings::default());
    assert!(is_clean(&mesh) && mesh.positions().len() == sphere.positions().len());
    assert_eq!(done.welded, 3 * 512 - 258);
    assert_eq!(done.to_string(), "joined 1278 vertices");
    let (mesh, _) = mended(&soup(&sphere, 1e-5), RepairSettings::default());
    assert!(!is_clean(&mesh));
    let settings = RepairSettings { weld: 3e-5, ..RepairSettings::default() };
    let (mesh, _) = mended(&soup(&sphere, 1e-5), settings);
    assert!(is_clean(&mesh) && mesh.positions().len() == sphere.positions().len());
}

#[test]
fn vertices_that_are_not_finite_are_not_joined() {
    let mesh = changed(&shapes::cube(), |positions, triangles| {
        positions.extend([DVec3::NAN, DVec3::NAN, DVec3::INFINITY]);
        triangles.push([8, 9, 10]);
    });
    let settings = RepairSettings { weld: 0.1, ..RepairSettings::default() };
    assert_eq!(mended(&mesh, settings).0.positions().len(), 11);
}

#[test]
fn distances_below_all_rounding_join_equal_coordinates_in_one_pass() {
    let corner = |k: f64| DVec3::new(k, k * k, 0.0);
    let positions = (0..100_000).map(|i| corner(f64::from(i % 50_000))).collect();
    let mesh = Mesh::new(positions, vec![[0, 50_001, 2], [3, 4, 50_005]]).expect("in range");
    let settings = RepairSettings { weld: 1e-310, ..RepairSettings::default() };
    assert_eq!(mended(&mesh, settings).1.welded, 2);
}

#[test]
fn flat_and_doubled_faces_are_dropped() {
    let mesh = changed(&shapes::cube(), |positions, triangles| {
        positions.push(DVec3::ONE);
        triangles.extend([[1, 1, 2], [0, 3, 3], [4, 6, 0], triangles[5]]);
    });
    let (mesh, done) = mended(&mesh, RepairSettings::default());
    assert!(is_clean(&mesh) && mesh.triangles().len() == 12);
    assert_eq!((done.zero_area, done.duplicate, done.unused), (2, 2, 1));
    assert_eq!(
        done.to_string(),
        "dropped 2 faces without area, dropped 2 doubled faces, dropped 1 unused vertex"
    );
}

#[test]
fn flat_face_in_a_closed_surface_trades_its_long_side() {
    // A vertex in the middle of the edge 1-3 of the cube, that only one of both sides knows: a flat
    // face joins them.
    let mesh = changed(&shapes::cube(), |positions, triangles| {
        let middle = positions.len() as u32;
        positions.push(0.5 * (positions[1] + positions[3]));
        let face = triangles.iter().position(|t| has_edge(t, 1, 3)).expect("an edge of the cube");
        let t = triangles[face];
        let third = t.into_iter().find(|v| ![1, 3].contains(v)).expect("a third");
        triangles[face] = [1, middle, third];
        triangles.extend([[middle, 3, third], [1, 3, middle]]);
    });
    let before = MeshReport::of(&mesh);
    assert!(before.is_closed() && before.degenerate.len() == 1, "{:?}", before.deficiencies());
    let (mesh, done) = mended(&mesh, RepairSettings::default());
    assert!(is_clean(&mesh), "{:?}", MeshReport::of(&mesh).deficiencies());
    assert_eq!((done.zero_area, mesh.positions().len(), mesh.volume()), (1, 9, 1.0));
}

fn has_edge(t: &[u32; 3], a: u32, b: u32) -> bool {
    (0..3).any(|i| (t[i], t[(i + 1) % 3]) == (a, b))
}

#[test]
fn faces_are_turned_outwards_piece_by_piece() {
    let mesh = changed(&shapes::sphere(2), |positions, triangles| {
        triangles.iter_mut().step_by(3).for_each(|t| t.swap(0, 1));
        let shift = positions.len() as u32;
        positions.extend(shapes::cube().positions().iter().map(|&p| p + 5.0));
        triangles.extend(shapes::cube().flipped().triangles().iter().map(|t| t.map(|v| v + shift)));
    });
    let (mesh, done) = mended(&mesh, RepairSettings::default());
    assert!(is_clean(&mesh) && mesh.volume() > 4.0);
    assert_eq!(done.turned, 43 + 12);
    let settings = RepairSettings { largest_only: true, ..RepairSettings::default() };
    let (mesh, done) = mended(&mesh, settings);
    assert_eq!((mesh.triangles().len(), done.pieces, done.unused), (128, 1, 8));
}

#[test]
fn small_holes_are_filled_and_large_ones_left() {
    let open = changed(&shapes::cube(), |_, triangles| {
        triangles.drain(10..);
        triangles.remove(8);
    });
    let fill = |fill| mended(&open, RepairSettings { fill, ..RepairSettings::default() });
    assert_eq!(fill(2).1.filled, 0);
    assert_eq!((fill(3).1.filled, MeshReport::of(&fill(3).0).boundary), (1, 4));
    let (mesh, done) = fill(4);
    assert!(is_clean(&mesh) && done.filled == 2);
    assert_eq!((mesh.volume(), mesh.positions().len(), mesh.triangles().len()), (1.0, 9, 14));
}
