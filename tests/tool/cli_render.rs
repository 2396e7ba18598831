//! Pictures as a user meets them: runs that are killed and go on, runs that meet, and what is
//! refused before a run.

use std::fs;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use crate::common::desk::{Desk, Said, assert_says};

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

/// A stop after a moment.
const SHORT: &str = "render.stop={ walks = 64 }";

/// A folder with `room.toml`, which is rendered.
fn desk() -> Desk {
    Desk::of(&["render", "room.toml"]).with("room.toml", ROOM)
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
fn picture_without_light_has_no_exposure_and_no_error() {
    let desk = desk();
    let dark = ["-D", "materials.grey.lambert.reflectance=0", "-D", SHORT, "-o", "a.png"];
    let said = desk.done(dark);
    assert_says(&said.err, &["no exposure: the PNG is black", "no light came to any pixel"]);
    assert!(!said.all().1.to_lowercase().contains("nan"), "a dark picture has numbers");
    let report = desk.json(dark);
    for name in ["median_relative_error", "relative_error_of_95_percent"] {
        assert!(report[name].is_null(), "{name}: {report}");
    }
    let given = desk.done([&dark[..], &["--exposure", "2"]].concat()).err;
    assert_says(&given, &["exposure 2.000 (PNG value per cd/m2)"]);
    // Light that is fainter than one over the largest number.
    let faint = ["-D", "lights.lamp.point.intensity=1e-318", "-D", SHORT, "-o", "a.png"];
    assert_says(&desk.done(faint).err, &["exposure 1.798e308 (PNG value per cd/m2)"]);
}

#[test]
fn killed_runs_go_on_to_the_same_picture() {
    let desk = desk();
    desk.run(["-o", "whole.exr"]);
    let mut kills = 0;
    let mut words = vec!["-o", "a.exr"];
    for _ in 0..3 {
        let mut child = desk.start(&words);
        let before = fs::read(desk.path("a.checkpoint")).ok();
        let moved = || {
            let now = fs::read(desk.path("a.checkpoint")).ok();
            now.as_ref().is_some_and(|bytes| !bytes.is_empty()) && now != before
        };
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
    let said = desk.run(&words);
    assert_says(&said.err, &["going on after"]);
    assert!(desk.bytes("a.exr") == desk.bytes("whole.exr"), "after {kills} kills");
    assert!(!desk.path("a.checkpoint").exists(), "an unnamed checkpoint stays");
}

#[cfg(unix)]
#[test]
fn terminated_run_saves_and_goes_on() {
    let desk = desk();
    desk.run(["-o", "whole.exr"]);
    let mut child = desk.start(["-o", "a.exr"]);
    // It holds something once a pass is complete.
    let saved = || fs::metadata(desk.path("a.checkpoint")).is_ok_and(|data| data.len() > 0);
    assert!(wait(&mut child, saved), "over too soon");
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &id]).status().expect("it runs").success());
    let said = Said::of(&child.wait_with_output().expect("it ends"));
    assert_eq!(said.code, 130, "{}", said.err);
    assert_says(&said.err, &["--resume=a.checkpoint"]);
    assert!(!desk.bytes("a.exr").is_empty());
    desk.run(["-o", "a.exr", "--resume=a.checkpoint"]);
    assert!(desk.bytes("a.exr") == desk.bytes("whole.exr"));
}

#[test]
fn two_runs_never_share_a_checkpoint_and_a_killed_one_leaves_it_free() {
    let desk = desk();
    let long = ["-o", "a.exr", "-D", "render.stop={ time = 60 }", "-D", "render.checkpoint=60"];
    let mut first = desk.start(long);
    assert!(wait(&mut first, || desk.path("a.checkpoint").exists()), "over too soon");
    let words = ["a.checkpoint: another run is under way", "wait until it ends"];
    for more in [&[][..], &["--resume"], &["--force"]] {
        desk.refused([&["-o", "a.exr"][..], more].concat(), &words);
    }
    desk.done(["-o", "b.exr", "-D", SHORT]);
    first.kill().expect("killed");
    first.wait().expect("it ends");
    // It was killed before it saved anything: the next run begins anew, asked to go on or not.
    let said = desk.done(["-o", "a.exr", "-D", SHORT, "--resume"]);
    assert_says(&said.err, &["a.checkpoint holds nothing yet: beginning anew"]);
    desk.put("a.checkpoint", "");
    desk.done(["-o", "a.exr", "-D", SHORT]);
    assert!(desk.bytes("a.exr") == desk.bytes("b.exr"));
    assert_eq!(desk.content().len(), 3, "{:?}", desk.content().keys());
}

#[test]
fn what_a_killed_run_left_unfinished_is_removed_by_the_next() {
    let desk = desk().with("a.unfinished.exr", "half of a picture");
    desk.put("b.unfinished.exr", "half of another");
    desk.done(["-o", "a.exr", "-D", SHORT]);
    let left = ["a", "b"].map(|n| desk.path(&format!("{n}.unfinished.exr")).exists());
    assert_eq!(left, [false, true]);
}

#[test]
fn complete_run_takes_more_walks() {
    let desk = desk();
    let stop = |walks| format!("render.stop={{ walks = {walks} }}");
    desk.run(["-o", "whole.exr", "-D", &stop(2048)]);
    let first = ["-o", "a.exr", "--checkpoint", "kept.checkpoint", "-D", &stop(800)];
    desk.done(first);
    assert!(desk.bytes("a.exr") != desk.bytes("whole.exr"));
    let more = ["-o", "a.exr", "--resume=kept.checkpoint", "-D", &stop(2048)];
    desk.done(more);
    assert!(desk.bytes("a.exr") == desk.bytes("whole.exr"));
    assert!(desk.path("kept.checkpoint").exists(), "a named checkpoint goes");
}

#[test]
fn checkpoints_of_other_runs_are_refused_with_the_difference() {
    let desk = desk();
    let short = ["-o", "a.exr", "-D", SHORT];
    desk.run([&short[..], &["--checkpoint", "k.checkpoint"]].concat());
    let resumed = |more: [&str; 2], says: &[&str]| {
        desk.refused([&short[..], &["--resume=k.checkpoint"], &more].concat(), says);
    };
    resumed(["--seed", "7"], &["another run: seed was `0`, is `7`", "help: "]);
    resumed(["--size", "10x8"], &["size was `12 x 8`, is `10 x 8`"]);
    resumed(
        ["-D", "materials.grey.lambert.reflectance=0.5"],
        &["materials.grey.lambert.reflectance was `0.6`, is `0.5`"],
    );
    resumed(
        ["-D", "objects.ball.sphere.radius=0.5"],
        &["objects.ball.sphere.radius was `0.7`, is `0.5`"],
    );
    resumed(
        ["-D", "cameras.main.perspective.fov=50"],
        &["cameras.main.perspective.fov was `60`, is `50`"],
    );
    resumed(["--crop", "0,0,6,8"], &["the crop was `0,0,12,8`, is `0,0,6,8`"]);
    let other = "cameras.other.panorama={ from = [2, 2, 2], resolution = [12, 8] }";
    resumed(["--camera=other", &format!("-D{other}")], &["the camera was `main`, is `other`"]);
    resumed(["-D", "render.estimator=double-local"], &["the estimator was `path`"]);
    desk.refused(["--resume=none.checkpoint"], &["none.checkpoint: cannot read"]);
    fs::write(desk.path("k.checkpoint"), b"a picture of a cat").expect("written");
    desk.refused(["--resume=k.checkpoint"], &["k.checkpoint", "not written by this program"]);
}

#[test]
fn what_cannot_be_written_or_held_is_refused_before_the_run() {
    let desk = desk();
    desk.refused(["--checkpoint", "a.state"], &["a.state: a checkpoint needs the extension"]);
    desk.refused(["--checkpoint", "none/a.checkpoint"], &["there is no folder none"]);
    desk.refused(["--size", "60000x60000"], &["60000 x 60000 pixels is beyond memory"]);
    let zero = ["-D", "cameras.main.perspective.resolution=[0, 8]"];
    desk.refused(zero, &["resolution"]);
    desk.refused(["-o", "a.jpg"], &["a.jpg: ", "name a file .png or .exr"]);
    desk.refused(["--layers", "none,depth"], &["--layers none,depth: `none` stands alone"]);
}
