//! Level of detail as a user meets it: `render` says which degree each SH object got, and what that may cost.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

const ROOM: &str = r#"format = 1
[materials.walls.lambert]
reflectance = 0.5
[objects.room.box]
min = [0, 0, 0]
max = [4, 40, 3]
inward = true
material = "walls"
[objects.near.sh]
file = "head.txt"
degree = 12
at = [2, 2.5, 1.5]
scale = 5
material = "walls"
[objects.far.sh]
file = "head.txt"
degree = 12
at = [2, 38, 1.5]
scale = 5
material = "walls"
[lights.lamp.point]
at = [1, 1, 2.5]
intensity = 100
[cameras.main.perspective]
from = [2, 0.25, 1.6]
to = [2, 3, 1.6]
fov = 60
resolution = [32, 24]
[illum]
stop = { walks = 64 }
[sensors.spot.points]
at = [[1, 1, 0]]
normal = [0, 0, 1]
"#;

/// A folder to work in, with a fitted head and a room that holds it near and far.
struct Desk(TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().expect("a folder"));
        let head = concat!(env!("CARGO_MANIFEST_DIR"), "/data/head.obj");
        desk.run(&["fit", head, "-l", "12", "-o", "head.txt"]);
        fs::write(desk.path("room.toml"), ROOM).expect("written");
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, words: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_harmolux"));
        let output = command.current_dir(self.0.path()).args(words).output().expect("it starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        output
    }

    /// Runs `harmolux render` for a moment, with these words more.
    fn render(&self, words: &[&str]) -> Output {
        self.run(&[&["render", "room.toml", "-D", "render.stop.walks=64"], words].concat())
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect("written")
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn far_objects_are_drawn_at_a_lower_degree_that_is_certified() {
    let desk = Desk::new();
    let define = "render.detail={ pixels = 0.25, normal = 180 }";
    let output = desk.render(&["-D", define, "-o", "a.exr", "--json"]);
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let details = report["details"].as_array().expect("a list");
    let [far, near] = ["far", "near"]
        .map(|name| details.iter().find(|d| d["name"] == name).expect("both objects are listed"));
    let number = |d: &Value, key: &str| d[key].as_f64().unwrap_or(f64::NAN);
    assert!(number(far, "degree") < number(near, "degree"), "{far} {near}");
    assert!((number(far, "distance") - number(near, "distance") - 35.5).abs() <= 0.01);
    for d in [far, near] {
        assert!(number(d, "pixels") <= 0.25 && number(d, "full_degree") == 12.0, "{d}");
    }
    assert!(number(far, "error") > number(near, "error") && number(far, "normal_degrees") > 0.0);
}

#[test]
fn degrees_are_said_and_nothing_is_simplified_unasked() {
    let desk = Desk::new();
    let plain = said(&desk.render(&["-o", "a.exr"]));
    assert!(!plain.contains("detail"), "{plain}");
    let one = said(&desk.render(&["-D", "objects.far.sh.detail={}", "-o", "b.exr"]));
    assert!(one.contains("detail: `far` at") && !one.contains("`near`"), "{one}");
    let none = said(&desk.render(&["-D", "render.detail={ pixels = 0 }", "-o", "c.exr"]));
    assert!(none.contains("detail: 2 objects at full degree 12, from 1."), "{none}");
    assert_eq!(desk.bytes("a.exr"), desk.bytes("c.exr"));
    // Sensors need exact shapes: nothing is chosen for them.
    let illum = said(&desk.run(&["illum", "room.toml", "-D", "render.detail={}"]));
    assert!(!illum.contains("detail"), "{illum}");
}
