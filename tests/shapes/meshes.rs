//! Mesh files that other programs wrote, and what is written here read again: always the same
//! shape.

use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec3;
use harmolux::io::meshes::{self, MeshFormat};
use harmolux::mesh::{Mesh, MeshReport};

const FILES: [&str; 12] = [
    "meshio.obj",
    "meshio.off",
    "meshio.ply",
    "meshio.stl",
    "plyfile_big_endian.ply",
    "trimesh.glb",
    "trimesh.obj",
    "trimesh.off",
    "trimesh.ply",
    "trimesh.stl",
    "trimesh_text.ply",
    "trimesh_text.stl",
];

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/meshes").join(name)
}

fn read(name: &str) -> Mesh {
    meshes::read(&file(name)).unwrap_or_else(|e| panic!("{e}"))
}

/// Lists the faces by their corners, in units of 1/1024, each beginning with its lowest one: the
/// order of vertices and faces is gone.
fn faces(mesh: &Mesh) -> Vec<[[i64; 3]; 3]> {
    let whole = |p: DVec3| {
        let units = 1024.0 * p;
        // The largest error is that of the eight decimals that trimesh writes into OBJ: 1024 *
        // 5e-9.
        assert!((units - units.round()).abs().max_element() <= 1e-5, "{p}");
        units.round().to_array().map(|x| x as i64)
    };
    let mut all: Vec<_> = (0..mesh.triangles().len())
        .map(|face| {
            let mut corners = mesh.corners(face).map(whole);
            let lowest = (0..3).min_by_key(|&i| corners[i]).unwrap_or(0);
            corners.rotate_left(lowest);
            corners
        })
        .collect();
    all.sort_unstable();
    all
}

/// Reads an OBJ file that has nothing odd, word by word: numbers from 1, fans of polygons.
fn read_plainly(path: &Path) -> Mesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for line in fs::read_to_string(path).expect("text").lines() {
        let words: Vec<_> = line.split_whitespace().collect();
        if words.first() == Some(&"v") {
            positions
                .push(DVec3::from_slice(&[1, 2, 3].map(|i| words[i].parse().expect("a number"))));
        } else if words.first() == Some(&"f") {
            let vertex = |i: usize| words[i].split('/').next().and_then(|v| v.parse::<u32>().ok());
            let corners: Vec<_> =
                (1..words.len()).map(|i| vertex(i).expect("a corner") - 1).collect();
            triangles.extend((2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]]));
        }
    }
    Mesh::new(positions, triangles).expect("indices in range")
}

#[test]
fn obj_is_what_its_lines_say() {
    let head = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/head.obj");
    for path in [head, file("meshio.obj"), file("trimesh.obj")] {
        assert!(
            meshes::read(&path).expect("readable") == read_plainly(&path),
            "{}",
            path.display()
        );
    }
}

#[test]
fn files_of_other_programs_hold_the_same_shape() {
    let expected = faces(&read("plyfile_big_endian.ply"));
    for name in FILES {
        let mesh = read(name);
        assert!(faces(&mesh) == expected, "{name}");
        let report = MeshReport::of(&mesh);
        assert_eq!((report.vertices, report.faces, report.unused_vertices), (42, 80, 0), "{name}");
        assert!(report.require_closed().is_ok(), "{name}");
        // As trimesh computes them; it writes eight decimals into OBJ, which move each radius by
        // 1e-8 at most.
        assert!((mesh.volume() - 3.847_947_504_371_404_6).abs() <= 2e-7, "{name}");
        assert!((mesh.area() - 12.080_659_785_844_242).abs() <= 6e-7, "{name}");
    }
}

#[test]
fn node_of_a_gltf_scene_is_turned() {
    // The node turns the geometry by 90 degrees about z: the same shape comes out.
    let turned = read("trimesh_turned.gltf");
    assert!(faces(&turned) == faces(&read("trimesh.glb")));
}

#[test]
fn content_tells_the_format_and_the_extension_does_not() {
    let folder = tempfile::tempdir().expect("a folder");
    let expected = faces(&read("trimesh.ply"));
    for name in FILES {
        for extension in ["obj", "ply", "stl", "off", "gltf", "glb", "txt", ""] {
            let path = folder.path().join("mesh").with_extension(extension);
            fs::copy(file(name), &path).expect("copied");
            let mesh = meshes::read(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert!(faces(&mesh) == expected, "{name} as .{extension}");
        }
    }
}

#[test]
fn what_is_written_is_read_again() {
    let mesh = read("trimesh.ply");
    let folder = tempfile::tempdir().expect("a folder");
    for format in MeshFormat::writable() {
        let path = folder.path().join("mesh");
        fs::write(&path, meshes::encode(&mesh, format).expect("encoded")).expect("written");
        let back = meshes::read(&path).expect("readable");
        if format == MeshFormat::Stl {
            assert!(faces(&back) == faces(&mesh));
        } else {
            assert!(back == mesh, "{format:?}");
        }
    }
}

#[test]
fn no_cut_of_any_file_makes_it_panic() {
    for name in FILES.into_iter().chain(["trimesh_turned.gltf"]) {
        let bytes = fs::read(file(name)).expect("there");
        for length in (0..bytes.len()).step_by(7) {
            // A text cut at the end of a line may still be a mesh, of fewer faces.
            let _ = meshes::parse(&file(name), &bytes[..length]);
        }
    }
}

#[test]
fn no_wrong_byte_makes_it_panic() {
    for name in FILES.into_iter().chain(["trimesh_turned.gltf"]) {
        let bytes = fs::read(file(name)).expect("there");
        for at in (0..bytes.len()).step_by(3) {
            for value in [0, 0xff, b'9', b'-', b'"'] {
                let mut wrong = bytes.clone();
                wrong[at] = value;
                if let Ok(mesh) = meshes::parse(&file(name), &wrong) {
                    assert!(mesh.positions().iter().all(|p| p.is_finite()));
                }
            }
        }
    }
}
