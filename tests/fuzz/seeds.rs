//! What fuzzing starts from: the fixtures of tests/data, the scenes of data/scenes, and what the
//! writers make of small things.

use std::fs;
use std::path::Path;

use glam::DVec3;
use harmolux::fit::{Shape, Source};
use harmolux::io::checkpoint;
use harmolux::io::coefficients::compact::Tolerance;
use harmolux::io::coefficients::{SeriesFormat, WriteOptions, binary, compact, encode};
use harmolux::io::images::Exr;
use harmolux::io::meshes::{self, MeshFormat};
use harmolux::io::npy::rows;
use harmolux::io::output::{Claim, Kind};
use harmolux::math::Rgb;
use harmolux::mesh::Mesh;
use harmolux::scene::Film;
use harmolux::sh::Coefficients;

use crate::targets::checkpoint_of;

/// A target's name, the seed's name and its bytes.
pub(crate) type Seed = (&'static str, String, Vec<u8>);

type Done = Result<(), Box<dyn std::error::Error>>;

const FIXTURES: [(&str, &str); 10] = [
    ("text", "interop/pyshtools_ortho.sh"),
    ("series_to_rays", "interop/pyshtools_ortho.sh"),
    ("dov", "interop/pyshtools_schmidt.dov"),
    ("bshc", "interop/pyshtools_unnorm.bshc"),
    ("npy", "interop/pyshtools_4pi.npy"),
    ("alm", "interop/healpy_alm.npy"),
    ("alm", "interop/ducc0_alm.npy"),
    ("spharm_pdm", "interop/spharm_pdm_mm.coef"),
    ("aics", "interop/aicsshparam.csv"),
    ("shadr", "interop/shadr_km.tab"),
];

/// Text of each kind: its target and what stands in it.
const TEXTS: [(&str, &str); 22] = [
    (
        "table",
        "name,normalisation,csphase,centre_x_m,C0_0_m,C1_0_m,C1_1_m,S1_1_m\n\
         a,4pi,1,0,1,0,0.5,0\nb,ortho,-1,2,1,0,0,-1e-3\n",
    ),
    ("off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"),
    (
        "ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
         property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
         0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    ),
    (
        "stl",
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
         endloop\nendfacet\nendsolid a\n",
    ),
    ("off", "off4 4\n6\n0 0\n0 1 0 0 0 1\n0 0 0 1 3 0 2 1 3 0\n1 3 3 0 3 2 3 1 2 3"),
    (
        "off",
        "COFF # colours\r5 2 0\r0 0 0 9 9 9\r4 0 0\r4 4 0\r2 1\r0 9\r0 4 0\r5 1 2 3 4 0 9\r2 0 1\r",
    ),
    (
        "ply",
        "ply\rformat ascii 1.0\relement vertex 4\rproperty int x\rproperty int y\r\
         property int z\relement tristrips 1\rproperty list int int vertex_indices\r\
         end_header\r0 0 0\r1 0 0\r0 1 0\r0 0 1\r9 0 1 2 3 3 -1 0 1 3\rmore\r",
    ),
    (
        "ply",
        "ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int vertex_index\n\
         element vertex 5\nproperty int x\nproperty int y\nproperty int z\nend_header\n\
         5 1 2 3 4 0\n2 0 1\n0 0 0\n4 0 0\n4 4 0\n2 1 0\n0 4 0\n",
    ),
    (
        "stl",
        "\u{feff}solid a facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 \
         end loop end facet\rend solid a\r",
    ),
    (
        "gltf",
        concat!(
            r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"#,
            r#""nodes":[{"mesh":0}],"#,
            r#""meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"#,
            "\n",
            r#""buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,"#,
            r#"AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],"#,
            "\n",
            r#""bufferViews":[{"buffer":0,"byteLength":36}],"#,
            "\n",
            r#""accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","#,
            r#""min":[0,0,0],"max":[1,1,0]}]}"#,
        ),
    ),
    ("points", "# a cloud\n1 0 0\n0,1,0\n0;0;1\n-1 0 0 2\n0 -1 0\n0 0 -1\n0.6 0.8 0\n"),
    ("points", "//X,Y,Z,R,G,B\n1,0,0,9,9,9\n0,1.0D+00,0,9,9,9\n"),
    ("points", "2\n1 0 0 -1200 9 9 9\n0 1 0 7 9 9 9\n"),
    (
        "points",
        "ply\nformat ascii 1.0\nelement camera 1\nproperty list uchar int a\nelement vertex 2\n\
         property float x\nproperty double y\nproperty float z\nproperty uchar weight\nend_header\n\
         2 7 8\n1 0 0 1\n0 1 0 2\n",
    ),
    (
        "icgem",
        "product_type topography\nmax_degree 1\nnorm fully_normalized\nend_of_head ==\n\
         gfc 0 0 1.0D+00 0\ngfct 1 1 0.1 0.2 0 0 20050101\ngfc 1 0 0.5 0 1e-3 0\n",
    ),
    ("csv", "degree,power_m2\n0,1.5\n1,0.25\n2,1e-3\n"),
    ("csv", "latitude,longitude\n45,-120\n-90,0\n"),
    (
        "csv",
        "group,x_m,y_m,z_m,normal_x,normal_y,normal_z,illuminance_lx,behind\n\
         desk,1,2,0.75,0,0,1,310.5,\ndesk,1.5,2,0.75,0,0,1,,shelf\n",
    ),
    ("probe", "# point, direction\n0 0 3  0 0 -1\n1,2,3,0.6,-0.8,0\n"),
    (
        "obj",
        "\u{feff}v 0 0 0\rv 4 0 0\rv 4 4 0\rv 2 1 \\ \r0\rv 0 4 0\rf 2 3 4 5 1\rf 1 2\r# a \\\r",
    ),
    (
        "mesh_to_fit",
        "OFF 4 4 6\n1 1 1\n1 -1 -1\n-1 1 -1\n-1 -1 1\n3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n",
    ),
    ("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0 # a corner\nvn 0 0 1\no part\nf 1//1 2//1 \\\n3//1\n"),
];

/// A scene whose node has a skin and whose positions are sparse ones alone.
const SPARSE: &str = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0,"skin":0,"scale":[2,2,2]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"buffers":[{"byteLength":28,"uri":"data:;base64,AQACAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAA=="}],
"bufferViews":[{"buffer":0,"byteLength":4},{"buffer":0,"byteOffset":4,"byteLength":24}],
"accessors":[{"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":2,
"indices":{"bufferView":0,"componentType":5123},"values":{"bufferView":1}}}]}"#;

/// Packs a scene into a binary file with a chunk of an unknown kind.
fn packed_scene() -> Vec<u8> {
    let chunk = |kind: &[u8], content: &[u8]| {
        [&(content.len() as u32).to_le_bytes()[..], kind, content].concat()
    };
    let chunks = [chunk(b"JSON", SPARSE.as_bytes()), chunk(b"MORE", &[1, 2, 3, 4])].concat();
    let length = 12 + chunks.len() as u32;
    [&b"glTF\x02\0\0\0"[..], &length.to_le_bytes(), &chunks].concat()
}

/// Writes a triangle in binary STL with attributes behind it.
fn attributed_facet() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(1_u32.to_le_bytes());
    let numbers = [0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0].map(|n| (n as f32).to_le_bytes());
    bytes.extend(numbers.concat());
    bytes.extend([3, 0, 7, 7, 7]);
    bytes
}

/// Makes all seeds; `package` is the folder of the package.
///
/// # Errors
/// A fixture that cannot be read, something that cannot be written.
pub(crate) fn all(package: &Path) -> Result<Vec<Seed>, Box<dyn std::error::Error>> {
    let mut seeds = Vec::new();
    for (target, name) in FIXTURES {
        let bytes = fs::read(package.join("tests/data").join(name))?;
        seeds.push((target, name.replace('/', "_"), bytes));
    }
    let mut scenes: Vec<_> =
        fs::read_dir(package.join("data/scenes"))?.collect::<Result<_, _>>()?;
    scenes.sort_by_key(fs::DirEntry::file_name);
    for entry in scenes.iter().filter(|e| e.path().extension().is_some_and(|e| e == "toml")) {
        let name = entry.file_name().to_string_lossy().into_owned();
        seeds.push(("scene", name, fs::read(entry.path())?));
    }
    for (i, (target, text)) in TEXTS.iter().enumerate() {
        seeds.push((target, format!("text-{i}"), text.as_bytes().to_vec()));
    }
    seeds.push(("gltf", "sparse".into(), SPARSE.into()));
    seeds.push(("gltf", "packed".into(), packed_scene()));
    seeds.push(("stl", "attributes".into(), attributed_facet()));
    shapes(&mut seeds)?;
    octahedra(&mut seeds)?;
    pictures(&mut seeds)?;
    seeds.push(("points", "rows".into(), rows(4, &[1.0, 0.0, 0.0, 9.0, 0.0, 1.0, 0.0, 9.0])));
    seeds.push(("fits", "healpy".into(), healpy_table()));
    let rays: [f64; 8] = [0.0, 0.0, 3.0, 0.1, 0.0, -1.0, 0.0, f64::INFINITY];
    seeds.push(("rays", "ray".into(), rays.iter().flat_map(|x| x.to_le_bytes()).collect()));
    Ok(seeds)
}

/// Makes the a_lm of degree 1 as healpy does.
fn healpy_table() -> Vec<u8> {
    let first = "SIMPLE  = T\nBITPIX  = 8\nNAXIS   = 0\nEND";
    let second = "XTENSION= 'BINTABLE'\nBITPIX  = 8\nNAXIS   = 2\nNAXIS1  = 20\nNAXIS2  = 3\n\
        TFIELDS = 3\nTTYPE1  = 'index'\nTFORM1  = 'J'\nTTYPE2  = 'real'\nTFORM2  = 'D'\n\
        TTYPE3  = 'imag'\nTFORM3  = '1D'\nEND";
    let mut bytes = Vec::new();
    for header in [first, second] {
        bytes.extend(header.lines().flat_map(|card| format!("{card:<80}").into_bytes()));
        bytes.resize(bytes.len().next_multiple_of(2880), b' ');
    }
    for (index, real) in [(1_i32, 3.5_f64), (3, 0.1), (4, 0.2)] {
        bytes.extend([&index.to_be_bytes()[..], &real.to_be_bytes(), &[0; 8]].concat());
    }
    bytes
}

/// Writes a small shape in every format.
fn shapes(seeds: &mut Vec<Seed>) -> Done {
    let mut coefficients = Coefficients::zeros(5);
    for (l, m) in (0..=5).flat_map(|l| (0..=l).map(move |m| (l, m))) {
        let x = (7 * l + 3 * m + 1) as f64;
        coefficients.set(l, m, x.sin() / x, x.cos() / x);
    }
    let bare = Shape::new(coefficients);
    let source = Some(Source::new(Path::new("a.obj"), b"v"));
    let whole = Shape { source, truncated_from: Some(9), ..bare.clone() };
    for (name, shape) in [("bare", &bare), ("whole", &whole)] {
        seeds.push(("binary", name.into(), binary::encode(shape)?));
        for tolerance in [1e-1, 1e-4, 1e-12] {
            let bytes = compact::encode(shape, Tolerance::OfMeanRadius(tolerance))?.bytes;
            // The target puts a checksum behind what it gets.
            let open = bytes[..bytes.len() - 4].to_vec();
            seeds.push(("compact", format!("{name}-{tolerance:e}"), bytes));
            seeds.push(("compact", format!("{name}-{tolerance:e}-open"), open));
        }
        for (target, format) in [("text", SeriesFormat::Text), ("dov", SeriesFormat::Dov)] {
            let bytes = encode(shape, format, &WriteOptions::default())?;
            if target == "text" {
                seeds.push(("series_to_rays", name.into(), bytes.clone()));
            }
            seeds.push((target, name.into(), bytes));
        }
    }
    Ok(())
}

/// Writes an octahedron in every format.
fn octahedra(seeds: &mut Vec<Seed>) -> Done {
    let corners = [DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].to_vec();
    let sides = [[0, 1], [1, 2], [2, 3], [3, 0]];
    let faces = sides.iter().flat_map(|&[a, b]| [[a, b, 4], [b, a, 5]]).collect();
    let mesh = Mesh::new(corners, faces)?;
    let formats = [("obj", MeshFormat::Obj), ("ply", MeshFormat::Ply), ("stl", MeshFormat::Stl)];
    for (target, format) in formats {
        let bytes = meshes::encode(&mesh, format)?;
        seeds.push(("mesh_to_fit", target.into(), bytes.clone()));
        seeds.push((target, "octahedron".into(), bytes));
    }
    Ok(())
}

/// Writes a small picture and the checkpoint of one.
fn pictures(seeds: &mut Vec<Seed>) -> Done {
    let pixels: Vec<Rgb> = (0..6).map(|i| Rgb::grey(f64::from(i))).collect();
    seeds.push(("exr", "small".into(), Exr::new(3, 2).with_colour("", &pixels)?.to_bytes()?));
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("a.checkpoint");
    let mut claim = Claim::open(&path, &Kind::CHECKPOINT, false)?;
    checkpoint::write(&mut claim, &checkpoint_of(), &Film::new([3, 2], 4)?)?;
    seeds.push(("checkpoint", "empty".into(), fs::read(&path)?));
    Ok(())
}
