//! PLY files written by hand, whole and broken.

use std::path::Path;

use super::*;
use crate::io::meshes::{MeshColours, MeshFormat, encode, encode_ply};
use crate::mesh::shapes;

/// A pyramid over a square, with things that a mesh has no use for.
const PYRAMID: &str = "ply\nformat ascii 1.0\ncomment by hand\nobj_info nothing\nelement camera 1\n\
                       property float focus\nproperty list uchar int lens\nelement vertex 5\n\
                       property uchar red\nproperty float z\nproperty float x\nproperty double y\n\
                       property list uchar float weights\nelement nothing 4000000000\n\
                       element face 5\nproperty list uchar int vertex_indices\nproperty uchar red\n\
                       end_header\n0.5 2 3 4\n9 0 0 0 0\n9 0 1 0 1 0.5\n9 0 1 1 0\n\n9 0 0 1 0\n\
                       9 1 0.5 0.5 0\n4 3 2 1 0 7\n3 0 1 4 7\n3 1 2 4 7\n3 2 3 4 7\n3 3 0 4 7\n";

fn read(bytes: &[u8]) -> Result<Mesh> {
    parse(&mut Source::of_bytes(Path::new("test.ply"), bytes))
}

fn error_of(bytes: &[u8]) -> String {
    read(bytes).unwrap_err().to_string()
}

/// Writes the same pyramid in binary, with these two ways to write numbers.
fn binary(format: &str, int: impl Fn(i32) -> [u8; 4], double: impl Fn(f64) -> [u8; 8]) -> Vec<u8> {
    let mut bytes = format!(
        "ply\r\nformat {format} 1.0\r\nelement vertex 5\r\nproperty double x\r\n\
         property double y\r\nproperty double z\r\nproperty uchar red\r\nelement face 5\r\n\
         property list int int vertex_index\r\nend_header\r\n"
    )
    .into_bytes();
    for [x, y, z] in [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0.5, 0.5, 1.0]] {
        bytes.extend([x, y, z].into_iter().flat_map(&double));
        bytes.push(9);
    }
    for face in [&[3, 2, 1, 0][..], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]] {
        bytes.extend(int(face.len() as i32));
        bytes.extend(face.iter().flat_map(|&v| int(v)));
    }
    bytes
}

fn little() -> Vec<u8> {
    binary("binary_little_endian", i32::to_le_bytes, f64::to_le_bytes)
}

#[test]
fn empty_files_say_what_is_missing() {
    assert!(error_of(b"").starts_with("test.ply: this is no PLY file"));
    assert!(error_of(b"ply\n").starts_with("test.ply: the header does not end"));
    assert!(error_of(b"ply\nformat ascii 1.0\nend_header\n").contains("no element vertex"));
    let bare = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n\
                property float z\nelement face 0\nproperty list uchar int vertex_indices\n\
                end_header\n";
    assert!(error_of(bare.as_bytes()).starts_with("test.ply: no vertices and no faces"));
}

#[test]
fn text_and_both_binaries_are_one_mesh() {
    let mesh = read(PYRAMID.as_bytes()).expect("readable");
    assert_eq!((mesh.positions().len(), mesh.triangles().len()), (5, 6));
    assert!((mesh.volume() - 1.0 / 3.0).abs() <= 1e-15);
    let big = binary("binary_big_endian", i32::to_be_bytes, f64::to_be_bytes);
    assert_eq!(read(&little()).expect("little"), mesh);
    assert_eq!(read(&big).expect("big"), mesh);
    // Whatever follows the last row.
    for more in [&b"\r\n"[..], b"more", &vec![0; 100_000]] {
        assert_eq!(read(&[&little()[..], more].concat()).expect("trailing bytes"), mesh);
        assert_eq!(read(&[PYRAMID.as_bytes(), more].concat()).expect("trailing lines"), mesh);
    }
}

#[test]
fn lines_may_end_with_returns_alone_and_bytes_begin_with_a_feed() {
    let mesh = read(PYRAMID.as_bytes()).expect("readable");
    let returns = |ends: &str| PYRAMID.replace('\n', ends);
    assert_eq!(read(returns("\r").as_bytes()).expect("CR"), mesh);
    assert_eq!(read(returns("\r\n").as_bytes()).expect("CR LF"), mesh);
    assert_eq!(read(format!("\u{feff}{PYRAMID}").as_bytes()).expect("marked"), mesh);
    let error = error_of(returns("\r").replace("9 1 0.5 0.5 0", "9 1 0.5 nan 0").as_bytes());
    assert!(error.starts_with("test.ply:25: vertex 4"), "{error}");
    // The number of corners of the first face is 10, a line feed: no part of the header's end.
    for ends in ["\n", "\r", "\r\n"] {
        let mut bytes = Vec::new();
        for line in [
            "ply",
            "format binary_big_endian 1.0",
            "element face 1",
            "property list uchar uchar vertex_index",
            "element vertex 3",
            "property uchar x",
            "property uchar y",
            "property uchar z",
            "end_header",
        ] {
            bytes.extend([line, ends].concat().bytes());
        }
        bytes.extend([10, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0]);
        bytes.extend([0, 0, 0, 9, 0, 0, 0, 9, 0]);
        let mesh = read(&bytes).expect("readable");
        assert_eq!((mesh.triangles().len(), mesh.positions().len()), (8, 3), "{ends:?}");
    }
}

/// The corners of a cube of side 2, and its sides as strips.
const STRIPS: &str = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
    element tristrips 2\nproperty list int int vertex_indices\nend_header\n-1 -1 -1\n1 -1 -1\n-1 1 -1\n1 1 -1\n\
    -1 -1 1\n1 -1 1\n-1 1 1\n1 1 1\n13 0 4 1 5 3 7 2 6 0 4 -1 0 1\n10 0 1 2 3 -1 5 4 7 6 -1\n";

#[test]
fn strips_are_triangles_every_other_one_turned() {
    // The second row ends the strip of the first: `0 1` alone is nothing.
    let mesh = read(STRIPS.as_bytes()).expect("readable");
    let report = crate::mesh::MeshReport::of(&mesh);
    assert_eq!((report.vertices, report.faces), (8, 12));
    assert!(report.is_closed(), "{:?}", report.deficiencies());
    assert!((mesh.volume().abs() - 8.0).abs() <= 1e-14 && (mesh.area() - 24.0).abs() <= 1e-14);
    // A strip goes on over corners named twice.
    let joined = STRIPS.replace("10 0 1 2 3 -1 5 4 7 6 -1", "10 0 1 2 3 3 5 5 4 7 6");
    assert!(crate::mesh::MeshReport::of(&read(joined.as_bytes()).expect("read")).is_closed());
    for (from, to, message) in [
        ("13 0 4", "13 0 8", "18: vertex 8 is not there"),
        ("13 0 4", "13 0 -2", "18: vertex -2 is not there"),
        ("13 0", "14 0", "18: a tristrips with too few values"),
        ("int vertex_indices", "float vertex_indices", "7: tristrips have no list of vertices"),
        ("tristrips 2", "edges 2", " the header has no element face"),
    ] {
        let error = error_of(STRIPS.replacen(from, to, 1).as_bytes());
        assert!(error.starts_with(&format!("test.ply:{message}")), "{to}: {error}");
    }
}

#[test]
fn faces_before_their_vertices_are_cut_as_those_behind() {
    let (head, rows) = ("ply\nformat ascii 1.0\n", "0 0 0\n4 0 0\n4 4 0\n2 1 0\n0 4 0\n");
    let vertex = "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n";
    let face = "element face 1\nproperty list uchar int vertex_index\n";
    let (corners, end) = ("5 1 2 3 4 0\n", "end_header\n");
    let texts = [
        [head, vertex, face, end, rows, corners].concat(),
        [head, face, vertex, end, corners, rows].concat(),
    ];
    let meshes = texts.map(|text| read(text.as_bytes()).expect("readable"));
    assert_eq!(meshes[0], meshes[1]);
    assert!((meshes[0].area() - 10.0).abs() <= 1e-14, "{:?}", meshes[0].triangles());
}

#[test]
fn what_is_written_is_read() {
    let mesh = shapes::l_shape().translated(DVec3::new(0.1, 1.0 / 3.0, -1e-300));
    assert_eq!(read(&encode(&mesh, MeshFormat::Ply).expect("written")).expect("read"), mesh);
    let colours = vec![[1, 2, 3]; mesh.positions().len()];
    let coloured = encode_ply(&mesh, Some(MeshColours::OfVertices(&colours))).expect("written");
    assert_eq!(read(&coloured).expect("read"), mesh);
}

#[test]
fn faults_of_a_text_name_the_line() {
    for (from, to, message) in [
        ("format ascii 1.0", "format ascii 2.0", "2: `ascii 2.0` is not a known format"),
        ("element vertex 5", "element vertex many", "8: `many` is no number of rows"),
        (
            "element vertex 5",
            "element vertex 4000000000",
            "8: the header announces 4000000000 rows of element vertex",
        ),
        ("element vertex 5", "element vertex 99999999999", "8: 99999999999 vertices, more than"),
        ("element vertex 5", "element vertex 4", "25: `0.5` is no whole number"),
        ("element vertex 5", "element vertex 6", "26: `7` is more than a vertex holds"),
        (
            "element face 5",
            "element face 6",
            " the file ends after 5 of the 6 rows of element face",
        ),
        ("element face", "element camera", "15: element camera is declared twice"),
        ("element face", "element faces", " the header has no element face"),
        ("property float z", "property float w", "8: vertices have no property z"),
        ("property float z", "property real z", "10: `real z` is no property"),
        (
            "list uchar int vertex_indices",
            "list uchar float vertex_indices",
            "15: faces have no list of vertices",
        ),
        ("list uchar int vertex_indices", "list float int vertex_indices", "16: `list float int"),
        ("element camera 1\n", "", "5: a property of no element"),
        ("format ascii 1.0\n", "", " the header has no format"),
        ("end_header\n", "", "18: `0.5` is no statement"),
        ("9 1 0.5 0.5 0", "9 1 0.5 high 0", "25: `high` is no number"),
        ("9 1 0.5 0.5 0", "9 1 0.5 nan 0", "25: vertex 4 (from 0) is at [0.5, NaN, 1]"),
        ("9 1 0.5 0.5 0", "9 1 0.5 0.5", "25: a vertex with too few values"),
        ("9 1 0.5 0.5 0", "9 1 0.5 0.5 -1", "25: -1 is no length of a list"),
        ("9 1 0.5 0.5 0", "9 1 0.5 0.5 99", "25: a vertex with too few values"),
        ("3 0 1 4 7", "3 0 1 5 7", "27: vertex 5 is not there; the file has 5 vertices"),
        ("3 0 1 4 7", "3 0 1 -1 7", "27: vertex -1 is not there"),
        ("3 0 1 4 7", "1 0 7", "27: a face of 1 vertex"),
    ] {
        assert!(PYRAMID.contains(from), "{from}");
        let found = error_of(PYRAMID.replacen(from, to, 1).as_bytes());
        assert!(found.starts_with(&format!("test.ply:{message}")), "{to}: {found}");
        assert!(found.contains("\n  help: "), "{found}");
    }
}

#[test]
fn binary_file_that_is_cut_or_lies_is_refused_without_allocating() {
    let whole = little();
    for length in [0, 3, 40, 100, 200, 300, whole.len() - 1] {
        assert!(read(&whole[..length]).is_err(), "{length} bytes");
    }
    assert!(
        error_of(&whole[..whole.len() - 1])
            .contains("the file ends after 4 of the 5 rows of element face")
    );
    let lie = |from: &str, to: &str| {
        let at = whole.windows(from.len()).position(|w| w == from.as_bytes()).expect("there");
        error_of(&[&whole[..at], to.as_bytes(), &whole[at + from.len()..]].concat())
    };
    assert!(
        lie("vertex 5", "vertex 4294967295")
            .contains("announces 4294967295 rows of element vertex, of 25 bytes")
    );
    assert!(
        lie("face 5", "face 18446744073709551615").contains("announces 18446744073709551615 rows")
    );
    let shifted = lie("vertex 5", "vertex 4");
    assert!(shifted.contains("face 0 (from 0): "), "{shifted}");
}

#[test]
fn number_of_a_vertex_that_is_not_there_is_located_in_binary() {
    let mut bytes = little();
    let last = bytes.len() - 4;
    bytes[last..].copy_from_slice(&5_i32.to_le_bytes());
    assert!(error_of(&bytes).starts_with("test.ply: face 4 (from 0): vertex 5 is not there"));
}

#[test]
fn very_many_elements_are_told_apart_in_one_pass() {
    let elements: Vec<String> = (0..200_000).map(|i| format!("element e{i} 0\n")).collect();
    let elements = elements.concat();
    let text = PYRAMID.replacen("element nothing", &format!("{elements}element nothing"), 1);
    assert_eq!(read(text.as_bytes()).expect("readable").triangles().len(), 6);
    let twice = text.replacen("element nothing", "element e77 1\nelement nothing", 1);
    assert!(error_of(twice.as_bytes()).contains("element e77 is declared twice"));
}
