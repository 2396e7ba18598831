//! Pictures as a user meets them: runs that are killed and go on, and what is refused before a run.

use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

/// A room with a ball, a lamp and a small camera; pixels near the target rest.
const ROOM: &str = r#"format = 1
[materials.grey.lambert]
reflectance = 0.6
[objects.room.box]
min = [0, 0, 0]
max = [4, 5, 3]
inward = true
material = "grey"
[objects.ball.sphere]
centre = [2, 3, 1]
radius = 0.7
material = "grey"
[lights.lamp.point]
at = [1, 1, 2.5]
intensity = 100
[cameras.main.perspective]
from = [2, 0.3, 1.5]
to = [2, 3, 1]
fov = 60
resolution = [12, 8]
[render]
estimator = "path"
checkpoint = 0.02
stop = { relative_error = 0.02, walks = 8192 }
"#;

/// A folder with `room.toml`.
struct Desk(TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().expect("a folder"));
        fs::write(desk.path("room.toml"), ROOM).expect("written");
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect("there")
    }

    fn start(&self, words: &[&str]) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_harmolux"));
        command.current_dir(self.0.path()).args(["render", "room.toml"]).args(words);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts")
    }

    fn run(&self, words: &[&str]) -> (i32, String) {
        said(&self.start(words).wait_with_output().expect("it ends"))
    }

    fn refused(&self, words: &[&str], says: &[&str]) {
        let (code, text) = self.run(words);
        assert_eq!(code, 3, "{text}");
        assert!(says.iter().all(|part| text.contains(part)), "{says:?}: {text}");
    }
}

fn said(output: &Output) -> (i32, String) {
    let text = [output.stdout.as_slice(), &output.stderr].map(String::from_utf8_lossy).concat();
    (output.status.code().unwrap_or(-1), text)
}

/// Waits until the run is over or `ready` says so; tells whether it is still on.
fn wait(child: &mut Child, ready: impl Fn() -> bool) -> bool {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(60) {
        if child.try_wait().expect("a state").is_some() {
            return false;
        }
        if ready() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    true
}

#[test]
fn killed_runs_go_on_to_the_same_picture() {
    let desk = Desk::new();
    desk.run(&["-o", "whole.exr"]);
    let mut kills = 0;
    let mut words = vec!["-o", "a.exr"];
    for _ in 0..3 {
        let mut child = desk.start(&words);
        let before = fs::read(desk.path("a.checkpoint")).ok();
        let moved = || fs::read(desk.path("a.checkpoint")).ok() != before;
        if !wait(&mut child, moved) {
            break;
        }
        child.kill().expect("killed");
        child.wait().expect("it ends");
        kills += 1;
        // The picture so far is there, after the checkpoint.
        words = vec!["-o", "a.exr", "--resume"];
    }
    assert!(kills > 0, "the run was over before its first checkpoint");
    let (_, text) = desk.run(&words);
    assert!(text.contains("going on after"), "{text}");
    assert!(desk.bytes("a.exr") == desk.bytes("whole.exr"), "after {kills} kills");
    assert!(!desk.path("a.checkpoint").exists(), "an unnamed checkpoint stays");
}

#[cfg(unix)]
#[test]
fn terminated_run_saves_and_goes_on() {
    let desk = Desk::new();
    desk.run(&["-o", "whole.exr"]);
    let mut child = desk.start(&["-o", "a.exr"]);
    assert!(wait(&mut child, || desk.path("a.checkpoint").exists()), "over too soon");
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &id]).status().expect("it runs").success());
    let (code, text) = said(&child.wait_with_output().expect("it ends"));
    assert_eq!(code, 130, "{text}");
    assert!(text.contains("--resume=a.checkpoint"), "{text}");
    assert!(!desk.bytes("a.exr").is_empty());
    desk.run(&["-o", "a.exr", "--resume=a.checkpoint"]);
    assert!(desk.bytes("a.exr") == desk.bytes("whole.exr"));
}

#[test]
fn complete_run_takes_more_walks() {
    let desk = Desk::new();
    let stop = |walks| format!("render.stop={{ walks = {walks} }}");
    desk.run(&["-o", "whole.exr", "-D", &stop(2048)]);
    let first = ["-o", "a.exr", "--checkpoint", "kept.checkpoint", "-D", &stop(800)];
    assert_eq!(desk.run(&first).0, 0);
    assert!(desk.bytes("a.exr") != desk.bytes("whole.exr"));
    let more = ["-o", "a.exr", "--resume=kept.checkpoint", "-D", &stop(2048)];
    assert_eq!(desk.run(&more).0, 0);
    assert!(desk.bytes("a.exr") == desk.bytes("whole.exr"));
    assert!(desk.path("kept.checkpoint").exists(), "a named checkpoint goes");
}

#[test]
fn checkpoints_of_other_runs_are_refused_with_the_difference() {
    let desk = Desk::new();
    let short = ["-o", "a.exr", "-D", "render.stop={ walks = 64 }"];
    desk.run(&[&short[..], &["--checkpoint", "k.checkpoint"]].concat());
    let resumed = |more: [&str; 2], says: &[&str]| {
        desk.refused(&[&short[..], &["--resume=k.checkpoint"], &more].concat(), says);
    };
    resumed(["--seed", "7"], &["another run: seed was `0`, is `7`", "help: "]);
    resumed(["--size", "10x8"], &["size was `12 x 8`, is `10 x 8`"]);
    resumed(
        ["-D", "materials.grey.lambert.reflectance=0.5"],
        &["materials.grey was", "0.6", "0.5"],
    );
    resumed(["-D", "objects.ball.sphere.radius=0.5"], &["objects.ball was", "0.7", "0.5"]);
    resumed(["-D", "cameras.main.perspective.fov=50"], &["the camera was"]);
    resumed(["-D", "render.estimator=double-local"], &["the estimator was `path`"]);
    desk.refused(&["--resume=none.checkpoint"], &["none.checkpoint: cannot read"]);
    fs::write(desk.path("k.checkpoint"), b"a picture of a cat").expect("written");
    desk.refused(&["--resume=k.checkpoint"], &["k.checkpoint", "not written by this program"]);
}

#[test]
fn what_cannot_be_written_or_held_is_refused_before_the_run() {
    let desk = Desk::new();
    desk.refused(&["--checkpoint", "a.state"], &["a.state: a checkpoint needs the extension"]);
    desk.refused(&["--checkpoint", "none/a.checkpoint"], &["there is no folder none"]);
    desk.refused(&["--size", "60000x60000"], &["60000 x 60000 pixels is beyond memory"]);
    let zero = ["-D", "cameras.main.perspective.resolution=[0, 8]"];
    desk.refused(&zero, &["resolution"]);
}
