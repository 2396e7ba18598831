//! glTF files written by hand, whole and broken.

use std::fs;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use serde_json::{Value, json};

use super::*;
use crate::mesh::MeshReport;

/// The corners of the unit cube as a strip that goes around all six sides.
const STRIP: [u16; 14] = [0, 1, 4, 5, 7, 1, 3, 0, 2, 4, 6, 7, 2, 3];

/// Eight corners in f32, then the strip in u16.
fn buffer() -> Vec<u8> {
    let corner = |i: u8| [i & 1, i >> 1 & 1, i >> 2].map(|b| f32::from(b).to_le_bytes());
    let mut bytes: Vec<u8> = (0..8).flat_map(|i| corner(i).concat()).collect();
    bytes.extend(STRIP.iter().flat_map(|i| i.to_le_bytes()));
    bytes
}

/// A cube that the scene holds once, mirrored and moved.
fn cube() -> Value {
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(buffer()));
    json!({
        "asset": { "version": "2.0" },
        "scene": 1,
        "scenes": [{ "nodes": [] }, { "nodes": [2] }],
        "nodes": [
            { "mesh": 0, "scale": [-2, 1, 1], "rotation": [0, 0, 0.6, 0.8] },
            { "mesh": 0 },
            { "children": [0], "translation": [5, 0, 0] },
        ],
        "meshes": [{ "primitives": [
            { "attributes": { "POSITION": 0, "NORMAL": 77 }, "indices": 1, "mode": 5 },
            { "attributes": { "POSITION": 99 }, "mode": 1 },
        ] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 14, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 96 },
            { "buffer": 0, "byteOffset": 96, "byteLength": 28 },
        ],
        "buffers": [{ "uri": uri, "byteLength": 124 }],
    })
}

fn read(bytes: &[u8]) -> Result<Mesh> {
    parse(&mut Source::of_bytes(Path::new("test.gltf"), bytes))
}

fn changed(path: &str, value: Value) -> Vec<u8> {
    let mut document = cube();
    let (parent, key) = path.rsplit_once('/').expect("a path");
    match document.pointer_mut(parent).expect("a parent") {
        Value::Array(list) => list[key.parse::<usize>().expect("a number")] = value,
        other => other[key] = value,
    }
    document.to_string().into_bytes()
}

/// Packs a document and its buffer into a binary file.
fn packed(document: &Value, binary: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let word = |n: usize| (n as u32).to_le_bytes();
    let head = [MAGIC, &word(2), &word(length)].concat();
    [&head[..], &word(json.len()), JSON, &json, &word(binary.len()), BINARY, binary].concat()
}

fn packed_cube() -> Vec<u8> {
    let mut document = cube();
    document["buffers"] = json!([{ "byteLength": 124 }]);
    packed(&document, &buffer())
}

#[test]
fn strip_of_the_default_scene_is_placed_and_stays_outward() {
    let mesh = read(cube().to_string().as_bytes()).expect("readable");
    let report = MeshReport::of(&mesh);
    assert!(report.require_closed().is_ok(), "{:?}", report.deficiencies());
    assert_eq!((report.vertices, report.faces), (8, 12));
    // Scaled by -2 along x, turned by 2 acos 0.8 about z (cos 0.28, sin 0.96), moved by 5.
    assert!((mesh.volume() - 2.0).abs() <= 1e-14);
    let corner = DVec3::new(5.0 - 2.0 * 0.28, -2.0 * 0.96, 0.0);
    assert!(mesh.positions().iter().any(|p| (*p - corner).length() <= 1e-14), "{mesh:?}");
}

#[test]
fn binary_file_and_buffer_beside_are_the_same_mesh() {
    let embedded = read(cube().to_string().as_bytes()).expect("embedded");
    assert_eq!(read(&packed_cube()).expect("packed"), embedded);
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("my cube.bin"), buffer()).expect("written");
    let path = folder.path().join("cube.gltf");
    fs::write(&path, changed("/buffers/0/uri", json!("my%20cube.bin"))).expect("written");
    assert_eq!(crate::io::meshes::read(&path).expect("beside"), embedded);
}

#[test]
fn fans_triangles_and_quantised_positions_are_read() {
    let fan = json!({ "attributes": { "POSITION": 0 }, "indices": 2, "mode": 6 });
    let list = json!({ "attributes": { "POSITION": 0 } });
    let mut document = cube();
    document["meshes"][0]["primitives"] = json!([fan, list]);
    document["nodes"][0] =
        json!({ "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] });
    // Four corners of u8: a square of 255, stretched to the unit.
    let bytes = [0, 0, 0, 9, 255, 0, 0, 9, 255, 255, 0, 9, 0, 255, 0, 0, 1, 2, 3];
    document["buffers"] = json!([{ "byteLength": bytes.len() }]);
    document["bufferViews"] = json!([
        { "buffer": 0, "byteLength": 15, "byteStride": 4 },
        { "buffer": 0, "byteOffset": 15, "byteLength": 4 }
    ]);
    document["accessors"] = json!([
        { "bufferView": 0, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC3" },
        {},
        { "bufferView": 1, "componentType": 5121, "count": 4, "type": "SCALAR" },
    ]);
    assert!(read(&packed(&document, &bytes)).is_err(), "an accessor without type");
    document["accessors"][1] = document["accessors"][0].clone();
    let error = read(&packed(&document, &bytes)).unwrap_err().to_string();
    assert!(error.contains("accessor 2 names vertex 3 of 3 (from 0)"), "{error}");
    document["accessors"][0]["count"] = json!(4);
    document["meshes"][0]["primitives"][1]["attributes"]["POSITION"] = json!(1);
    let mesh = read(&packed(&document, &bytes)).expect("readable");
    // The list repeats the first triangle of the fan at the same vertices.
    assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    assert_eq!((mesh.positions().len(), mesh.positions()[2]), (4, DVec3::new(6.0, 1.0, 0.0)));
}

/// The cube, its accessors changed by sparse ones: 5 and 6 of indices u8, 1 of positions f32.
fn sparse(accessor: usize, indices: &Value, values: &Value) -> Value {
    let mut document = cube();
    let more = [&[7, 0, 3, 0][..], &[0; 24], &[5, 6, 0, 7, 0, 1, 0, 2, 0, 0]].concat();
    let bytes = [buffer(), more].concat();
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    document["buffers"] = json!([{ "uri": uri, "byteLength": bytes.len() }]);
    let views = document["bufferViews"].as_array_mut().expect("a list");
    views.push(json!({ "buffer": 0, "byteOffset": 124, "byteLength": 4 }));
    views.push(json!({ "buffer": 0, "byteOffset": 128, "byteLength": 24 }));
    views.push(json!({ "buffer": 0, "byteOffset": 152, "byteLength": 10 }));
    document["accessors"][accessor]["sparse"] =
        json!({ "count": 2, "indices": indices, "values": values });
    document
}

#[test]
fn items_are_replaced_by_those_of_a_sparse_part() {
    let indices = json!({ "bufferView": 2, "componentType": 5123 });
    let values = json!({ "bufferView": 3 });
    let read = |document: &Value| read(document.to_string().as_bytes());
    let mesh = read(&sparse(0, &indices, &values)).expect("readable");
    // Corners 7 and 3 of the cube are moved to corner 0, and so are one with it.
    assert_eq!(mesh.positions().len(), 6);
    // In the strip, items 5 and 6, which are 1 and 3, become 7 and 1.
    let indices = json!({ "bufferView": 4, "componentType": 5121 });
    let values = json!({ "bufferView": 4, "byteOffset": 3 });
    let mut document = sparse(1, &indices, &values);
    document["meshes"][0]["primitives"][0]["mode"] = json!(6);
    let fan = read(&document).expect("readable");
    document["accessors"][1]["sparse"] = Value::Null;
    let plain = read(&document).expect("readable");
    let changed: Vec<usize> =
        (0..12).filter(|&i| fan.triangles()[i] != plain.triangles()[i]).collect();
    assert_eq!(changed, [3, 4, 5]);
    // Without a buffer of its own all the others are zero.
    let indices = json!({ "bufferView": 2, "componentType": 5123 });
    let mut bare = sparse(0, &indices, &json!({ "bufferView": 0, "byteOffset": 12 }));
    bare["accessors"][0]["bufferView"] = Value::Null;
    assert_eq!(read(&bare).expect("readable").positions().len(), 3);
    for (path, value, message) in [
        ("count", json!(3), "accessor 0 has 3 items, more than its buffer"),
        ("indices/componentType", json!(5126), "accessor 0 has sparse indices that are none"),
        ("indices/componentType", json!(5125), "accessor 0 has 2 items, more than its buffer"),
        ("indices/bufferView", json!(9), "buffer view 9 is not there"),
        ("indices/bufferView", json!(4), "accessor 0 has a sparse index beyond its items"),
        ("values/byteOffset", json!(usize::MAX), "accessor 0 has 2 items, more than its buffer"),
    ] {
        let mut document = bare.clone();
        *document.pointer_mut(&format!("/accessors/0/sparse/{path}")).expect("there") =
            value.clone();
        let error = read(&document).unwrap_err().to_string();
        assert!(error.contains(message), "{path} {value}: {error}");
    }
    bare["accessors"][0]["count"] = json!(usize::MAX);
    let error = read(&bare).unwrap_err().to_string();
    assert!(error.contains("items without a buffer, more than are read"), "{error}");
}

#[test]
fn chunks_of_unknown_kinds_are_passed_over() {
    let embedded = read(cube().to_string().as_bytes()).expect("embedded");
    let chunk = |kind: &[u8], content: &[u8]| {
        [&(content.len() as u32).to_le_bytes()[..], kind, content].concat()
    };
    let file = |chunks: &[Vec<u8>]| {
        let length = 12 + chunks.iter().map(Vec::len).sum::<usize>() as u32;
        [MAGIC, &2_u32.to_le_bytes(), &length.to_le_bytes(), &chunks.concat()].concat()
    };
    let mut document = cube();
    let whole = chunk(JSON, document.to_string().as_bytes());
    document["buffers"] = json!([{ "byteLength": 124 }]);
    let json = chunk(JSON, document.to_string().as_bytes());
    let (binary, other) = (chunk(BINARY, &buffer()), chunk(b"XTRA", &[1, 2, 3, 4]));
    for chunks in [
        vec![whole.clone()],
        vec![whole, other.clone()],
        vec![json.clone(), binary.clone(), other.clone()],
        vec![json.clone(), other.clone(), chunk(b"NONE", &[]), binary],
    ] {
        assert_eq!(read(&file(&chunks)).expect("readable"), embedded);
    }
    for chunks in
        [vec![json.clone(), other.clone()], vec![other, json.clone()], vec![json, vec![9]]]
    {
        assert!(read(&file(&chunks)).is_err());
    }
}

#[test]
fn transform_of_a_node_with_a_skin_places_nothing() {
    let mut document = cube();
    document["nodes"][0]["skin"] = json!(0);
    document["skins"] = json!([{ "joints": [2] }]);
    document["nodes"][0]["children"] = json!([1]);
    let mesh = read(document.to_string().as_bytes()).expect("readable");
    assert_eq!(mesh.positions()[..8], read_at_rest()[..]);
    // Its child is moved still.
    assert!((mesh.volume() - 3.0).abs() <= 1e-14 && mesh.positions().len() == 16);
}

/// The corners of the cube in the order of its strip's accessor.
fn read_at_rest() -> Vec<DVec3> {
    (0..8).map(|i: u8| DVec3::from_array([i & 1, i >> 1 & 1, i >> 2].map(f64::from))).collect()
}

#[test]
fn documents_that_contradict_themselves_are_refused() {
    let overflow = usize::MAX;
    for (path, value, message) in [
        ("/asset/version", json!("1.0"), "this is glTF of version 1.0"),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "needs the extension KHR_draco_mesh_compression",
        ),
        ("/scene", json!(7), "scene 7 is not there"),
        ("/scenes/1/nodes", json!([9]), "node 9 is not there"),
        ("/scenes/1/nodes", json!([2, 2]), "node 2 is used twice"),
        ("/scenes/1/nodes", json!([]), "no vertices and no faces"),
        ("/nodes/2/children", json!([2]), "node 2 is used twice"),
        ("/nodes/0/mesh", json!(4), "mesh 4 is not there"),
        ("/nodes/0/scale", json!([1e308, 1e308, 1e308]), ""),
        ("/meshes/0/primitives/0/mode", json!(9), "primitives of the unknown mode 9"),
        ("/meshes/0/primitives/0/mode", json!(4), "triangles of 14 corners"),
        (
            "/meshes/0/primitives/0/indices",
            json!(0),
            "accessor 0 of indices holds no whole numbers",
        ),
        ("/meshes/0/primitives/0/indices", json!(8), "accessor 8 is not there"),
        ("/accessors/0/count", json!(0), "accessor 1 names vertex 0 of 0 (from 0)"),
        ("/accessors/0/count", json!(9), "accessor 0 has 9 items, more than its buffer"),
        ("/accessors/0/count", json!(overflow), "items, more than its buffer"),
        ("/accessors/0/byteOffset", json!(overflow), "items, more than its buffer"),
        ("/accessors/0/type", json!("VEC2"), "accessor 0 of positions is VEC2"),
        ("/accessors/0/componentType", json!(5130), "accessor 0 has numbers of an unknown type"),
        ("/accessors/0/sparse", json!({ "count": 1 }), "missing field `indices`"),
        ("/accessors/0/bufferView", json!(3), "buffer view 3 is not there"),
        ("/accessors/0/bufferView", Value::Null, "accessor 0 has no data"),
        ("/accessors/1/count", json!(13), ""),
        ("/bufferViews/0/byteOffset", json!(overflow), "items, more than its buffer"),
        ("/bufferViews/0/byteStride", json!(4), "accessor 0 has items that overlap"),
        ("/bufferViews/0/byteStride", json!(0), "accessor 0 has items that overlap"),
        ("/bufferViews/0/byteStride", json!(overflow), "items, more than its buffer"),
        ("/bufferViews/0/buffer", json!(1), "buffer 1 is not there"),
        ("/buffers/0/byteLength", json!(125), "buffer 0 has 124 bytes instead of 125"),
        ("/buffers/0/uri", json!("data:,abc"), "buffer 0 is a data URI without base64"),
        ("/buffers/0/uri", json!("data:;base64,a*"), "buffer 0 is no base64 text"),
        ("/buffers/0/uri", json!("no-such.bin"), "no-such.bin: cannot read"),
        ("/buffers/0/uri", json!("/etc/hosts"), "the buffer `/etc/hosts` is not beside the file"),
        ("/buffers/0/uri", json!("http://host/a.bin"), "is not beside the file"),
        ("/buffers/0/uri", json!("."), "this is a folder, not a file"),
        ("/buffers/0/uri", Value::Null, "buffer 0 has no content"),
    ] {
        match read(&changed(path, value.clone())) {
            Ok(mesh) => {
                assert!(message.is_empty() && mesh.positions().iter().all(|p| p.is_finite()));
            }
            Err(error) => assert!(error.to_string().contains(message), "{path} {value}: {error}"),
        }
    }
}

#[test]
fn text_that_is_no_gltf_is_located() {
    let error = |text: &str| read(text.as_bytes()).unwrap_err().to_string();
    assert!(error("").starts_with("test.gltf:1:1: this is no glTF file: EOF while parsing"));
    assert!(
        error("{\n \"asset\": 3}")
            .starts_with("test.gltf:2:11: this is no glTF file: invalid type")
    );
    assert!(error("{}").contains("missing field `asset`"));
    let text = cube().to_string().replace("\"mesh\":0", "\"mesh\":-1");
    assert!(error(&text).contains("invalid value: integer `-1`"), "{}", error(&text));
}

#[test]
fn binary_file_that_is_cut_or_lies_is_refused() {
    let whole = packed_cube();
    for length in [4, 11, 12, 19, 20, 100, whole.len() - 1] {
        let error = read(&whole[..length]).unwrap_err().to_string();
        assert!(error.starts_with("test.gltf: binary glTF "), "{length}: {error}");
    }
    for (at, value) in [(4, 1_u32), (8, u32::MAX), (12, u32::MAX), (16, 0)] {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        assert!(read(&bytes).is_err(), "{value} at {at}");
    }
}

#[test]
fn small_file_does_not_become_a_huge_mesh() {
    let mut document = cube();
    let nodes: Vec<Value> = (0..1000).map(|_| json!({ "mesh": 0 })).collect();
    let many: Vec<Value> =
        (0..1000).map(|_| document["meshes"][0]["primitives"][0].clone()).collect();
    document["nodes"] = json!(nodes);
    document["scenes"][1]["nodes"] = json!((0..1000).collect::<Vec<_>>());
    assert_eq!(read(document.to_string().as_bytes()).expect("readable").triangles().len(), 12_000);
    document["meshes"][0]["primitives"] = json!(many);
    let error = read(document.to_string().as_bytes()).unwrap_err().to_string();
    assert!(error.contains("the scene repeats its meshes"), "{error}");
}
