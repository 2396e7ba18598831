//! Inputs as a user meets them: pipes, files that change between runs, names that would steer a
//! terminal, paths that are no UTF-8.

use std::ffi::OsString;
use std::fs;
use std::os::unix::ffi::OsStringExt;
use std::process::Command;

use crate::common::desk::{Desk, assert_says, repository};
use crate::common::scenes::{BALL, CAMERA, LAMP, ROOM};

/// What is measured in the room and in the ball, and how it is rendered.
const MEASURED: &str = r#"[sensors.desk.points]
at = [[1, 1, 0], [2, 3, 1]]
normal = [0, 0, 1]
[illum]
stop = { walks = 32 }
[render]
estimator = "path"
stop = { walks = 32 }
"#;

/// A room with a ball, a lamp and a sensor in the room and one in the ball.
fn room() -> String {
    [ROOM, BALL, LAMP, CAMERA, "resolution = [4, 3]\n", MEASURED].concat()
}

/// A table of `illum`, a column of sensors.
const LUX: &str = "group,x_m,y_m,z_m,normal_x,normal_y,normal_z,illuminance_lx,behind\n\
                   g,0,0,0,0,0,1,5,\ng,1,0,0,0,0,1,6,\ng,0,1,0,0,0,1,7,\ng,1,1,0,0,0,1,8,\n";

/// A file that stands in the folder, or comes through a pipe.
fn put(desk: &Desk, name: &str, bytes: &[u8], piped: bool) {
    let (path, bytes) = (desk.path(name), bytes.to_vec());
    if !piped {
        return desk.put(name, bytes);
    }
    desk.put_pipe(name);
    // Ends when the pipe is read, or with this process.
    std::thread::spawn(move || fs::write(path, bytes));
}

fn data(path: &str) -> Vec<u8> {
    fs::read(repository(path)).expect("readable")
}

#[test]
fn pipes_give_what_files_give() {
    let (stone, rock) = (data("tests/data/meshes/trimesh.obj"), data("data/shapes/pebble.txt"));
    let points = String::from_utf8_lossy(&stone).replace("v ", "");
    let points = points.split("f ").next().expect("vertices").replace('#', "# ");
    for (line, input, bytes) in [
        ("info in", "in", &stone[..]),
        ("info in", "in", &data("tests/data/meshes/trimesh.stl")),
        ("info in", "in", &data("tests/data/meshes/trimesh.glb")),
        ("info in", "in", &rock),
        ("check in.obj", "in.obj", &stone),
        ("fit in.obj -l 2 -o a.txt", "in.obj", &stone),
        ("fit in -l 2 -o a.txt", "in", points.as_bytes()),
        ("convert in a.dov", "in", &rock),
        (
            "convert in.coef a.txt --unit mm",
            "in.coef",
            &data("tests/data/interop/spharm_pdm_mm.coef"),
        ),
        ("convert in a.ply", "in", &stone),
        ("diff in in", "in", &rock),
        ("diff rock.txt in --width 0.1", "in", &stone),
        ("mesh in -o a.ply --resolution 2", "in", &rock),
        ("transform in -o a.txt -l 2", "in", &rock),
        ("mean in rock.txt -o a.txt", "in", &rock),
        ("spectrum in -o a.csv", "in", &rock),
        ("random --spectrum in -l 2 -o a.txt", "in", &rock),
        ("random --spectrum in --radius 1 -o a.txt", "in", b"degree,power\n2,1e-4\n"),
        ("falsecolor in -o a.svg", "in", LUX.as_bytes()),
        ("probe in.toml", "in.toml", room().as_bytes()),
    ] {
        let line = if line == "diff in in" { "diff in rock.txt --width 0.1" } else { line };
        let [file, pipe] = [false, true].map(|piped| {
            let desk = Desk::new().with("rock.txt", &rock);
            put(&desk, input, bytes, piped);
            let said = desk.done(line);
            let written: Vec<Vec<u8>> = ["a.txt", "a.ply", "a.dov", "a.csv", "a.svg"]
                .iter()
                .filter_map(|name| fs::read(desk.path(name)).ok())
                .collect();
            // The time that a fit took.
            let lines = said.out.lines().filter(|line| !line.starts_with("time "));
            (written, lines.map(str::to_owned).collect::<Vec<_>>())
        });
        assert_eq!(file, pipe, "{line}");
    }
}

#[test]
fn bash_substitutes_a_process_for_a_file() {
    let stone = data("tests/data/meshes/trimesh.obj");
    let desk = Desk::new().with("stone.obj", &stone);
    desk.done("fit stone.obj -l 2 -o a.txt");
    let tool = env!("CARGO_BIN_EXE_harmolux");
    let line = format!("'{tool}' fit <(cat stone.obj) -l 2 -o b.txt");
    let mut bash = Command::new("bash");
    let output = bash.args(["-c", &line]).current_dir(desk.path("")).output().expect("bash");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let hash = |name: &str| {
        let text = desk.text(name);
        text.split("fnv1a64:").nth(1).and_then(|rest| rest.get(..16)).expect("a hash").to_owned()
    };
    assert_eq!(hash("a.txt"), hash("b.txt"));
}

#[test]
fn pipe_in_a_scene_is_refused_and_not_waited_for() {
    let mesh = "[objects.head.mesh]\nfile = \"head.obj\"\nmaterial = \"grey\"\n";
    let series = "[objects.head.sh]\nfile = \"head.obj\"\ndegree = 2\nmaterial = \"grey\"\n";
    for object in [mesh, series] {
        let desk = Desk::new().with("room.toml", room() + object);
        desk.put_pipe("head.obj");
        let said = desk.ends(3, "illum room.toml");
        assert_says(&said.err, &["head.obj: this is a pipe, not a file", "help: write what"]);
    }
    let said = Desk::new().ends(3, "info /dev/zero");
    assert_says(&said.err, &["/dev/zero: this is a device, not a file"]);
}

/// A tetrahedron whose corners stand in `m.bin`; only the first `length` bytes count.
fn gltf(length: usize) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}},
{{"bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR"}}],
"bufferViews": [{{"buffer": 0, "byteLength": 48}},
{{"buffer": 0, "byteOffset": 48, "byteLength": 12}}],
"buffers": [{{"uri": "m.bin", "byteLength": {length}}}]}}"#
    )
}

fn buffer(height: f32) -> Vec<u8> {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, height]];
    let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|x: &f32| x.to_le_bytes()).collect();
    bytes.extend([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]);
    bytes
}

#[test]
fn run_goes_on_only_with_the_buffers_it_began_with() {
    let object = "[objects.m.mesh]\nfile = \"m.gltf\"\nat = [1, 1, 1]\nmaterial = \"grey\"\n";
    let desk = Desk::of(&["render", "room.toml", "-o", "a.exr"])
        .with("room.toml", room() + object)
        .with("m.gltf", gltf(60))
        .with("m.bin", buffer(0.5));
    desk.done(["--checkpoint", "k.checkpoint"]);
    let resume = ["--resume=k.checkpoint", "-D", "render.stop={ walks = 64 }"];
    desk.put("m.bin", buffer(0.75));
    let said = desk.ends(3, resume);
    let difference = "another run: the file `m.bin` of objects.m was `60 bytes, fnv1a64:";
    assert_says(&said.err, &[difference]);
    // What stands behind the buffer is not read, and may change.
    desk.put("m.bin", [buffer(0.5), vec![7]].concat());
    desk.done(resume);
    desk.put("m.gltf", gltf(61));
    let said = desk.ends(3, resume);
    assert_says(&said.err, &["another run: the file of objects.m was `"]);
}

#[test]
fn row_of_a_mesh_is_of_its_buffers_too() {
    let desk = Desk::of(&["fit", "m.gltf", "-l", "1", "-o", "out"])
        .with("m.gltf", gltf(60))
        .with("m.bin", buffer(0.5));
    desk.done(["--centre", "0.1,0.1,0.1"]);
    desk.done(["--centre", "0.1,0.1,0.1"]);
    desk.put("m.bin", buffer(0.75));
    let difference = ["the row of m.gltf is of another run"];
    desk.refused(["--centre", "0.1,0.1,0.1"], &difference);
}

#[test]
fn names_and_words_of_files_do_not_steer_the_terminal() {
    let evil = format!(r#""x\u001b[2J\nerror: all is lost\u202e{}""#, "y".repeat(300));
    let room = room().replace("objects.ball", &format!("objects.{evil}"));
    let room = room.replace("sensors.desk", &format!("sensors.{evil}"));
    let desk = Desk::new()
        .with("room.toml", room)
        .with("a.obj", format!("v 0 0 \x1b[2J{}\n", "z".repeat(500)))
        .with("b.xyz", "1 2 \x1b[2J\n")
        .with("c.csv", format!("group,\x1b[2J{},x_m\n", "w".repeat(5000)))
        .with("d.toml", "format = 1\n[objects.\"\\u001b[2J\".sphere]\nradius = 1\n")
        .with("\u{1b}[2J.txt", "");
    for (code, line) in [
        (0, "illum room.toml"),
        (3, "info a.obj"),
        (3, "fit b.xyz -l 1 -o a.txt"),
        (3, "falsecolor c.csv -o a.svg"),
        (3, "illum d.toml"),
        (3, "info \x1b[2J.txt"),
    ] {
        let (_, text) = desk.ends(code, line).all();
        assert!(!text.contains(['\x1b', '\u{202e}']), "{line}: {text}");
        assert!(text.contains("\\u{1b}"), "{line}: {text}");
        assert!(!text.lines().any(|line| line.starts_with("error: all")), "{line}: {text}");
        for long in ["y", "z"] {
            assert!(!text.contains(&long.repeat(200)), "{line}: {text}");
        }
        assert!(text.len() < 8000, "{line}: {text}");
    }
    let report = desk.json("illum room.toml");
    let name = report["groups"][0]["group"].as_str().expect("a name").to_owned();
    assert!(name.starts_with("x\x1b[2J\nerror: all"), "{name}");
}

#[cfg(target_os = "linux")]
#[test]
fn paths_that_are_no_utf8_are_written_as_text_and_bytes() {
    // ODD is the one byte 0xff.
    let words = |line: &str| -> Vec<OsString> {
        let word = |word: &str| {
            let parts: Vec<&[u8]> = word.split("ODD").map(str::as_bytes).collect();
            OsString::from_vec(parts.join(&0xff))
        };
        line.split_whitespace().map(word).collect()
    };
    let desk = Desk::new()
        .with("stone.obj", data("tests/data/meshes/trimesh.obj"))
        .with("rock.txt", data("data/shapes/pebble.txt"))
        .with("lux.csv", LUX)
        .with("room.toml", room());
    for (line, text, bytes) in [
        ("check stone.obj --repair -o ODD.ply", "\u{fffd}.ply", "/y5wbHk="),
        ("convert rock.txt ODD.dov", "\u{fffd}.dov", "/y5kb3Y="),
        ("convert stone.obj ODD.stl", "\u{fffd}.stl", "/y5zdGw="),
        ("mesh rock.txt -o ODD.obj --resolution 2", "\u{fffd}.obj", "/y5vYmo="),
        ("transform rock.txt -o ODD.txt", "\u{fffd}.txt", "/y50eHQ="),
        ("mean rock.txt -o ODD.txt --force", "\u{fffd}.txt", "/y50eHQ="),
        (
            "random --power-law rms=0.1,exponent=3 -l 4 -o ODD.txt --force",
            "\u{fffd}.txt",
            "/y50eHQ=",
        ),
        ("fit stone.obj -l 2 -o ODD.txt --force", "\u{fffd}.txt", "/y50eHQ="),
        ("render room.toml -o ODD.exr", "\u{fffd}.exr", "/y5leHI="),
        ("falsecolor lux.csv -o ODD.svg", "\u{fffd}.svg", "/y5zdmc="),
    ] {
        let report = desk.json(words(line));
        let single = |key: &str| match &report[key] {
            serde_json::Value::Array(list) if list.len() == 1 => list[0].clone(),
            other => other.clone(),
        };
        let found = [single("written"), single("written_bytes")];
        assert_eq!(found, [text, bytes], "{line}");
    }
    let report = desk.json(words("diff ODD.txt rock.txt --width 0.1"));
    assert_eq!((&report["a_bytes"], &report["b_bytes"]), (&"/y50eHQ=".into(), &().into()));
    let report = desk.json(words("mean ODD.txt rock.txt -o a.txt --force"));
    assert_eq!(report["distances"][0]["shape_bytes"], "/y50eHQ=");
}
