//! `harmolux check` and `--repair` as a user meets them: what is said of good, bad and hopeless
//! meshes, and what is written.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use glam::DVec3;
use harmolux::io::meshes::{self, MeshFormat};
use harmolux::mesh::{Mesh, MeshReport};
use serde_json::Value;

use crate::common::desk::{Desk, Said, assert_says};
use crate::common::solids::{prism, u_shape};

/// A cube of side 1 from the origin.
fn cube() -> String {
    prism(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], [0.0, 1.0], &[[0, 1, 2, 3]])
}

fn parsed(obj: &str) -> Mesh {
    meshes::parse(Path::new("mesh.obj"), obj.as_bytes()).expect("readable")
}

#[test]
fn sound_mesh_ends_with_0_and_names_a_centre() {
    let desk = Desk::new();
    desk.put("cube.obj", cube());
    let Said { out, err, .. } = desk.ends(0, ["check", "cube.obj"]);
    let words = [
        "8 vertices, 12 faces",
        "closed           yes",
        "manifold         yes",
        "oriented         yes, outwards",
        "1, Euler number 2, genus 0",
        "crossings        none",
        "star-shaped      yes, about (0.5000, 0.5000, 0.5000) m, which every face clears by 0.5000 \
         m",
        "from the origin  about (0, 0, 0) m, which lies 0 m behind face",
    ];
    assert_says(&out, &words);
    assert_eq!(err, "");
    let value = desk.json(["check", "cube.obj", "--unit", "mm"]);
    assert_eq!(value["sound"], true);
    assert_eq!(value["genus"], 0);
    assert_eq!(value["star"]["folds"], Value::Null);
    assert!((value["star"]["clearance"].as_f64().expect("a number") - 5e-4).abs() <= 1e-12);
}

#[test]
fn shape_that_no_centre_sees_ends_with_4_and_is_coloured() {
    let desk = Desk::new();
    desk.put("u.obj", u_shape());
    let Said { out, .. } = desk.ends(4, ["check", "u.obj", "--bad", "bad.ply"]);
    assert_says(
        &out,
        &[
            "closed           yes",
            "star-shaped      no, about",
            "behind face",
            "turned faces",
            "patch ",
            "of the sphere",
            "meet the mesh twice or from behind",
            "written          bad.ply",
        ],
    );
    let bytes = fs::read(desk.path("bad.ply")).expect("written");
    assert!(bytes.starts_with(b"ply\nformat binary_little_endian 1.0\ncomment harmolux "));
    assert_eq!(meshes::read(&desk.path("bad.ply")).expect("readable"), parsed(&u_shape()));
    let value = desk.json_at(4, ["check", "u.obj", "--centre", "0.5,0.5,0.5"]);
    let folds = &value["star"]["folds"];
    let red = bytes.windows(3).filter(|w| *w == [215, 35, 35]).count();
    assert!(red > 0 && folds["share"].as_f64().expect("a share") > 0.01);
    assert!(folds["error"].as_f64().expect("a bound") < 0.002);
}

#[test]
fn open_inside_out_crossing_and_divided_meshes_are_told_apart() {
    let desk = Desk::new();
    let cube = cube();
    let (open, _) = cube.trim_end().rsplit_once('\n').expect("several lines");
    desk.put("open.obj", open);
    let Said { out, .. } = desk.ends(4, ["check", "open.obj"]);
    assert_says(
        &out,
        &[
            "closed           no",
            "boundary         1 loop, of 4 edges, 4.000 m",
            "4 edges have one face only",
        ],
    );

    let flipped = meshes::encode(&parsed(&cube).flipped(), MeshFormat::Ply).expect("encoded");
    desk.put("flipped.ply", flipped);
    let Said { out, .. } = desk.ends(4, ["check", "flipped.ply"]);
    assert_says(&out, &["oriented         yes, but inwards", "its faces look inwards"]);

    let second = |shift: f64| {
        let moved = parsed(&cube).translated(DVec3::new(shift, 0.3, 0.2));
        let mut text = cube.clone();
        moved
            .positions()
            .iter()
            .for_each(|p| writeln!(text, "v {} {} {}", p.x, p.y, p.z).expect("a String"));
        moved.triangles().iter().for_each(|t| {
            writeln!(text, "f {} {} {}", t[0] + 9, t[1] + 9, t[2] + 9).expect("a String");
        });
        text
    };
    desk.put("crossing.obj", second(0.4));
    let Said { out, .. } = desk.ends(4, ["check", "crossing.obj"]);
    assert_says(&out, &["pairs of faces cross, the first", "pieces           2, Euler number 4"]);
    let Said { out, .. } = desk.ends(4, ["check", "crossing.obj", "--skip-crossings"]);
    assert!(!out.contains("crossings"));
    assert_says(
        &out,
        &["star-shaped      no, about", "2 surfaces, one within the other", "100 % of all"],
    );
    desk.put("apart.obj", second(3.0));
    let value = desk.json_at(4, ["check", "apart.obj"]);
    assert_eq!((&value["components"], &value["crossings"]["pairs"]), (&2.into(), &0.into()));

    // What cures a mesh stands in the first error about it.
    let flipped = "`--repair` mends that (`harmolux check --repair -o FILE` writes it)";
    for (file, cure) in [
        ("flipped.ply", flipped),
        ("apart.obj", "is in 2 pieces; keep one piece alone (`harmolux check --repair --largest-"),
    ] {
        let Said { err, .. } = desk.ends(3, ["fit", file, "-l", "2", "-o", "a.txt"]);
        assert_says(&err, &[cure]);
    }
    let Said { out, .. } = desk.ends(4, ["check", "flipped.ply"]);
    assert_says(&out, &[flipped]);

    desk.put("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let Said { out, .. } = desk.ends(4, ["check", "one.obj"]);
    let cure = "`--repair --fill-holes 3` fills holes too";
    assert_says(&out, &["closed           no", "3 edges have one face only", cure]);
}

#[test]
fn repair_mends_says_what_it_did_and_writes_the_mesh() {
    let desk = Desk::new();
    let cube = parsed(&cube());
    // Every face on its own, every other one turned.
    let mut soup = String::new();
    for face in 0..12 {
        let [a, mut b, mut c] = cube.corners(face);
        if face % 2 == 1 {
            std::mem::swap(&mut b, &mut c);
        }
        for p in [a, b, c] {
            writeln!(soup, "v {} {} {}", p.x, p.y, p.z).expect("a String takes all");
        }
        soup.push_str("f -3 -2 -1\n");
    }
    desk.put("soup.obj", &soup);
    desk.ends(4, ["check", "soup.obj"]);
    let Said { out, err, .. } = desk.ends(0, ["check", "soup.obj", "--repair", "-o", "mended.stl"]);
    assert_eq!(err, "soup.obj: joined 28 vertices, turned 6 faces\n");
    assert_says(&out, &["written          mended.stl"]);
    let mended = meshes::read(&desk.path("mended.stl")).expect("readable");
    assert!(MeshReport::of(&mended).require_closed().is_ok() && mended.volume() == 1.0);
    // The verbs that shape meshes take it as well.
    desk.ends(3, ["fit", "soup.obj", "-l", "2", "-o", "a.txt"]);
    let Said { err, .. } = desk.ends(0, ["fit", "soup.obj", "-l", "2", "-o", "a.txt", "--repair"]);
    assert_says(&err, &["soup.obj: joined 28 vertices, turned 6 faces"]);
    let value = desk.json(["check", "soup.obj", "--repair", "--weld", "1e-6"]);
    assert_eq!(value["repair"]["welded_vertices"], 28);
    // Without `--repair` its settings mean nothing.
    for wrong in
        [&["--weld", "1e-6"][..], &["--fill-holes", "3"], &["--largest-piece"], &["-o", "b.ply"]]
    {
        desk.ends(2, [&["check", "soup.obj"], wrong].concat());
    }
}

#[test]
fn holes_are_filled_and_small_pieces_dropped_when_asked() {
    let desk = Desk::new();
    let cube = cube();
    let (open, _) = cube.trim_end().rsplit_once('\n').expect("several lines");
    desk.put("open.obj", format!("{open}\nv 5 5 5\nv 5 5 6\nv 5 6 5\nf -1 -2 -3\n"));
    desk.ends(4, ["check", "open.obj", "--repair", "--fill-holes", "4"]);
    let Said { err, .. } =
        desk.ends(0, ["check", "open.obj", "--repair", "--fill-holes", "4", "--largest-piece"]);
    assert_says(&err, &["dropped 1 smaller piece, filled 1 hole, dropped 3 unused vertices"]);
}

#[test]
fn files_that_cannot_be_used_end_with_3_and_say_why() {
    let desk = Desk::new();
    let cube = parsed(&cube());
    let ply = meshes::encode(&cube, MeshFormat::Ply).expect("encoded");
    let stl = meshes::encode(&cube, MeshFormat::Stl).expect("encoded");
    let text = |from: &str, to: &str| {
        let head = String::from_utf8_lossy(&ply[..ply.len() - 8 * 24 - 12 * 13]).into_owned();
        assert!(head.contains(from), "{head}");
        [head.replace(from, to).as_bytes(), &ply[ply.len() - 8 * 24 - 12 * 13..]].concat()
    };
    let mut lies = stl.clone();
    lies[80..84].copy_from_slice(&4_000_000_000_u32.to_le_bytes());
    let garbage: Vec<u8> =
        (0..4096_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let cases: [(&str, Vec<u8>, &str); 16] = [
        ("empty.obj", vec![], "empty.obj: no vertices and no faces"),
        ("empty.ply", vec![], "empty.ply: this is no PLY file"),
        ("empty", vec![], "empty: unrecognised mesh format"),
        ("garbage.obj", garbage.clone(), "garbage.obj: no vertices and no faces"),
        ("garbage.stl", garbage.clone(), "garbage.stl: the header announces"),
        ("garbage.glb", garbage, "garbage.glb:1:1: this is no glTF file"),
        (
            "cut.ply",
            ply[..ply.len() - 20].to_vec(),
            "cut.ply: the file ends after 10 of the 12 rows of element face",
        ),
        (
            "cut.stl",
            stl[..300].to_vec(),
            "cut.stl: the header announces 12 facets, which take 684 bytes, but the file has 300",
        ),
        ("lies.stl", lies, "lies.stl: the header announces 4000000000 facets"),
        (
            "lies.ply",
            text("vertex 8", "vertex 4000000000"),
            "lies.ply:4: the header announces 4000000000 rows of element vertex",
        ),
        ("few.ply", text("vertex 8", "vertex 7"), "few.ply: face 0 (from 0): "),
        ("mixed.ply", text("binary_little", "binary_big"), "mixed.ply: face 0 (from 0): vertex "),
        (
            "nan.obj",
            b"v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n".to_vec(),
            "nan.obj:3: vertex 3 is at",
        ),
        (
            "stray.off",
            b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n".to_vec(),
            "stray.off:6: vertex 3 is not there",
        ),
        ("points.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\np 1\n".to_vec(), "points.obj: no faces"),
        (
            "other.gltf",
            b"{ \"software\": \"other\" }".to_vec(),
            "other.gltf:1:23: this is no glTF file: missing field `asset`",
        ),
    ];
    for (name, bytes, message) in cases {
        desk.put(name, bytes);
        let Said { out, err, .. } = desk.ends(3, ["check", name, "--bad", "bad.ply"]);
        assert!(err.starts_with(&format!("error: {message}")), "{name}: {err}");
        assert!(err.contains("\n  help: ") && out.is_empty(), "{name}: {err}");
        assert!(!desk.path("bad.ply").exists());
    }
    fs::create_dir(desk.path("folder.ply")).expect("made");
    assert_says(
        &desk.ends(3, ["check", "folder.ply"]).err,
        &["folder.ply: this is a folder, not a file"],
    );
    assert_says(&desk.ends(3, ["check", "none.ply"]).err, &["none.ply: cannot read"]);
}

#[test]
fn foreign_files_and_unknown_formats_are_not_written() {
    let desk = Desk::new();
    desk.put("cube.obj", cube());
    desk.put("bad.ply", "ply\nformat ascii 1.0\ncomment not ours\n");
    assert_says(&desk.ends(3, ["check", "cube.obj", "--bad", "bad.ply"]).err, &["--force"]);
    desk.ends(0, ["check", "cube.obj", "--bad", "bad.ply", "--force"]);
    let Said { err, .. } = desk.ends(3, ["check", "cube.obj", "--repair", "-o", "cube.off"]);
    assert_says(&err, &["cube.off: meshes are written as .obj, .ply or .stl: name it cube.ply"]);
    // The input itself is not overwritten by its own repair.
    assert_says(
        &desk.ends(3, ["check", "cube.obj", "--repair", "-o", "cube.obj"]).err,
        &["--force"],
    );
    let before = fs::read(desk.path("cube.obj")).expect("there");
    assert_eq!(before, cube().into_bytes());
}
