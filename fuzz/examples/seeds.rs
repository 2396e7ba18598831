//! Writes what the fuzzer starts from into `corpus/TARGET/`: the fixtures of tests/data, and what
//! the writers make of a small shape.
//!
//!     cargo run --release --example seeds     (from the folder fuzz)

use std::fs;
use std::path::Path;

use harmolux::io::coefficients::compact::Tolerance;
use harmolux::io::coefficients::{SeriesFormat, WriteOptions, binary, compact, encode};
use harmolux::fit::{Shape, Source};
use harmolux::io::meshes::{self, MeshFormat};
use harmolux::sh::Coefficients;
use harmolux::mesh::Mesh;

type Done = Result<(), Box<dyn std::error::Error>>;

const FIXTURES: [(&str, &str); 9] = [
    ("text", "interop/pyshtools_ortho.sh"),
    ("dov", "interop/pyshtools_schmidt.dov"),
    ("bshc", "interop/pyshtools_unnorm.bshc"),
    ("npy", "interop/pyshtools_4pi.npy"),
    ("alm", "interop/healpy_alm.npy"),
    ("alm", "interop/ducc0_alm.npy"),
    ("spharm_pdm", "interop/spharm_pdm_mm.coef"),
    ("aics", "interop/aicsshparam.csv"),
    ("shadr", "interop/shadr_km.tab"),
];

const OFF: &str = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],"bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]}"#;

fn main() -> Done {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (target, name) in FIXTURES {
        let bytes = fs::read(here.join("../tests/data").join(name))?;
        seed(target, &name.replace('/', "_"), &bytes)?;
    }
    for entry in fs::read_dir(here.join("../data/scenes"))? {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "toml") {
            seed(
                "scene",
                &path.file_name().unwrap_or_default().to_string_lossy(),
                &fs::read(&path)?,
            )?;
        }
    }
    shapes()?;
    tetrahedra()
}

fn seed(target: &str, name: &str, bytes: &[u8]) -> Done {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
    fs::create_dir_all(&folder)?;
    Ok(fs::write(folder.join(name), bytes)?)
}

/// Writes a small shape in every format.
fn shapes() -> Done {
    let mut coefficients = Coefficients::zeros(5);
    for (l, m) in (0..=5).flat_map(|l| (0..=l).map(move |m| (l, m))) {
        let x = (7 * l + 3 * m + 1) as f64;
        coefficients.set(l, m, x.sin() / x, x.cos() / x);
    }
    let bare = Shape::new(coefficients);
    let source = Some(Source::new(Path::new("a.obj"), b"v"));
    let whole = Shape { source, truncated_from: Some(9), ..bare.clone() };
    for shape in [&bare, &whole] {
        let name = if shape.source.is_some() { "whole" } else { "bare" };
        seed("binary", name, &binary::encode(shape)?)?;
        for tolerance in [1e-1, 1e-4, 1e-12] {
            let bytes = compact::encode(shape, Tolerance::OfMeanRadius(tolerance))?.bytes;
            seed("compact", &format!("{name}-{tolerance:e}"), &bytes)?;
            // The target puts a checksum behind what it gets.
            seed("compact", &format!("{name}-{tolerance:e}-open"), &bytes[..bytes.len() - 4])?;
        }
        seed("text", name, &encode(shape, SeriesFormat::Text, &WriteOptions::default())?)?;
        seed("dov", name, &encode(shape, SeriesFormat::Dov, &WriteOptions::default())?)?;
    }
    Ok(())
}

/// Writes a tetrahedron in every format.
fn tetrahedra() -> Done {
    let corners =
        [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]].map(glam::DVec3::from_array);
    let mesh = Mesh::new(corners.to_vec(), vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
    seed("obj", "tetrahedron", &meshes::encode(&mesh, MeshFormat::Obj)?)?;
    seed("ply", "tetrahedron", &meshes::encode(&mesh, MeshFormat::Ply)?)?;
    seed("stl", "tetrahedron", &meshes::encode(&mesh, MeshFormat::Stl)?)?;
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    seed("ply", "text", text.as_bytes())?;
    let text = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
    seed("stl", "text", text.as_bytes())?;
    seed("off", "tetrahedron", OFF.as_bytes())?;
    seed("gltf", "triangle", GLTF.as_bytes())
}
