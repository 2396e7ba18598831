//! Pictures as a user meets them: runs that are killed and go on, runs that meet, and what is
//! refused before a run.

use std::fs;

use crate::common::desk::{Desk, assert_says};
use crate::common::running::Running;
use crate::common::scenes::{BALL, CAMERA, LAMP, ROOM};

/// How it is rendered: pixels near the target rest.
const RENDER: &str = r#"resolution = [12, 8]
[render]
estimator = "path"
checkpoint = 0.02
stop = { relative_error = 0.02, walks = 8192 }
"#;

/// A stop after a moment.
const SHORT: &str = "render.stop={ walks = 64 }";

/// A folder with `room.toml`, which is rendered.
fn desk() -> Desk {
    let scene = [ROOM, BALL, LAMP, CAMERA, RENDER].concat();
    Desk::of(&["render", "room.toml"]).with("room.toml", scene)
}

#[test]
fn picture_without_light_has_no_exposure_and_no_error() {
    let desk = desk();
    let dark = ["-D", "materials.grey.lambert.reflectance=0", "-D", SHORT, "-o", "a.png"];
    let dark = [&dark[..], &["--force"]].concat();
    let said = desk.done(&dark);
    assert_says(&said.err, &["no exposure: the PNG is black", "no light came to any pixel"]);
    assert!(!said.all().1.to_lowercase().contains("nan"), "a dark picture has numbers");
    let report = desk.json(&dark);
    for name in ["median_relative_error", "relative_error_of_95_percent"] {
        assert!(report[name].is_null(), "{name}: {report}");
    }
    let given = desk.done([&dark[..], &["--exposure", "2"]].concat()).err;
    assert_says(&given, &["exposure 2.000 (PNG value per cd/m2)"]);
    // Light that is fainter than one over the largest number.
    let faint = ["-D", "lights.lamp.point.intensity=1e-318", "-D", SHORT, "-o", "b.png"];
    assert_says(&desk.done(faint).err, &["exposure 1.798e308 (PNG value per cd/m2)"]);
}

#[test]
fn killed_runs_go_on_to_the_same_picture() {
    let desk = desk();
    desk.run(["-o", "whole.exr"]);
    let mut kills = 0;
    let mut words = vec!["-o", "a.exr"];
    for _ in 0..3 {
        let mut run = Running::start(&mut desk.command(&words));
        let before = fs::read(desk.path("a.checkpoint")).ok();
        let moved = |_: &Running| {
            let now = fs::read(desk.path("a.checkpoint")).ok();
            now.as_ref().is_some_and(|bytes| !bytes.is_empty()) && now != before
        };
        if !run.wait_for(moved) {
            break;
        }
        drop(run);
        kills += 1;
        words = vec!["-o", "a.exr", "--resume"];
    }
    assert!(kills > 0, "the run was over before its first checkpoint");
    let said = desk.run(&words);
    assert_says(&said.err, &["going on after"]);
    assert!(desk.bytes("a.exr") == desk.bytes("whole.exr"), "after {kills} kills");
    let left: Vec<_> = desk.content().into_keys().collect();
    assert_eq!(left.len(), 3, "the scene and two pictures: {left:?}");
}

#[cfg(unix)]
#[test]
fn terminated_run_saves_and_goes_on() {
    let desk = desk();
    desk.run(["-o", "whole.exr"]);
    let mut run = Running::start(&mut desk.command(["-o", "a.exr"]));
    // Held from the beginning, empty until the first save.
    let saved =
        |_: &Running| fs::metadata(desk.path("a.checkpoint")).is_ok_and(|file| file.len() > 0);
    assert!(run.wait_for(saved), "over too soon");
    run.send("-TERM");
    let said = run.end();
    assert_eq!(said.code, 130, "{}", said.err);
    assert_says(&said.err, &["--resume=a.checkpoint"]);
    assert_says(&said.out, &["written         a.unfinished.exr"]);
    assert!(!desk.bytes("a.unfinished.exr").is_empty() && !desk.path("a.exr").exists());
    desk.run(["-o", "a.exr", "--resume=a.checkpoint"]);
    assert!(desk.bytes("a.exr") == desk.bytes("whole.exr"));
}

#[test]
fn two_runs_never_write_one_file_and_a_killed_one_leaves_it_free() {
    let desk = desk();
    let long = ["-o", "a.exr", "-D", "render.stop={ time = 60 }", "-D", "render.checkpoint=60"];
    let mut first = Running::start(&mut desk.command(long));
    assert!(first.wait_for(|_| desk.path("a.checkpoint").exists()), "over too soon");
    let words = ["a.exr: another run is under way", "wait until that run ends"];
    for more in [&[][..], &["--resume"], &["--force"]] {
        desk.refused([&["-o", "a.exr"][..], more].concat(), &words);
    }
    let other = ["-o", "c.exr", "--checkpoint", "a.checkpoint", "-D", SHORT];
    desk.refused(other, &["a.checkpoint: another run is under way"]);
    desk.done(["-o", "b.exr", "-D", SHORT]);
    drop(first);
    // It was killed before it saved anything: the next run begins anew, asked to go on or not.
    let said = desk.done(["-o", "a.exr", "-D", SHORT, "--resume"]);
    assert_says(&said.err, &["nothing to go on with in a.checkpoint: beginning anew"]);
    desk.put("a.checkpoint", "");
    desk.done(["-o", "a.exr", "-D", SHORT, "--force"]);
    assert!(desk.bytes("a.exr") == desk.bytes("b.exr"));
    assert_eq!(desk.content().len(), 3, "{:?}", desk.content().keys());
}

#[test]
fn one_file_named_twice_is_refused() {
    let desk = desk();
    desk.refused(["-o", "a.exr", "-o", "./a.exr"], &["a.exr: ", "or it is named twice"]);
}

#[test]
fn only_what_carries_our_mark_is_taken_for_what_a_killed_run_left() {
    let desk = desk();
    desk.done(["-o", "a.exr", "-D", SHORT]);
    desk.put("b.unfinished.exr", desk.bytes("a.exr"));
    desk.put("c.unfinished.exr", "notes of a user");
    for name in ["b.exr", "c.exr"] {
        desk.done(["-o", name, "-D", SHORT]);
        assert!(desk.bytes(name) == desk.bytes("a.exr"));
    }
    assert!(!desk.path("b.unfinished.exr").exists());
    assert_eq!(desk.text("c.unfinished.exr"), "notes of a user");
    // A run that is refused leaves both kinds.
    desk.put("a.unfinished.exr", desk.bytes("a.exr"));
    desk.refused(["-o", "a.exr", "-D", SHORT], &["a.exr: this file is there already"]);
    desk.refused(["-o", "c.exr", "-D", SHORT], &["c.exr: this file is there already"]);
}

#[test]
fn nothing_to_go_on_with_begins_anew_until_the_picture_is_there() {
    let desk = desk();
    // As `until harmolux render room.toml --resume` does, the last time after a kill between the
    // end of the run and that of the process.
    for _ in 0..2 {
        let said = desk.done(["-o", "a.exr", "-D", SHORT, "--resume"]);
        assert_says(&said.err, &["nothing to go on with in a.checkpoint: beginning anew"]);
    }
    let before = desk.bytes("a.exr");
    desk.refused(["-o", "a.exr", "-D", SHORT], &["a.exr: this file is there already"]);
    let words = ["a.exr: it is of another run", "--force"];
    desk.refused(["-o", "a.exr", "-D", SHORT, "--resume", "--seed", "7"], &words);
    desk.put("a.exr", "a picture of a cat");
    desk.refused(["-o", "a.exr", "-D", SHORT, "--resume"], &["not written by this program"]);
    desk.done(["-o", "a.exr", "-D", SHORT, "--resume", "--force"]);
    assert!(desk.bytes("a.exr") == before);
}

#[test]
fn picture_without_a_place_is_kept_with_its_checkpoint() {
    let desk = desk();
    let stop = "render.stop={ walks = 2048 }";
    desk.done(["-o", "whole.exr", "-D", stop]);
    fs::create_dir(desk.path("out")).expect("made");
    let words = ["-o", "out/a.exr", "-o", "out/b.exr", "-D", stop];
    let mut run = Running::start(&mut desk.command(words));
    let held = ["out/a.unfinished.exr", "out/b.unfinished.exr", "out/a.checkpoint"];
    let is_on = |_: &Running| held.iter().all(|name| desk.path(name).exists());
    assert!(run.wait_for(is_on), "over too soon");
    while desk.path("out").exists() {
        let _ = fs::remove_dir_all(desk.path("out"));
    }
    let said = run.end();
    assert_eq!(said.code, 3, "{}", said.err);
    for name in ["a", "b"] {
        let kept = format!("{name}.kept-1.exr");
        assert_says(&said.err, &[&format!("out/{name}.exr: cannot write"), &kept]);
        assert!(desk.bytes(&kept) == desk.bytes("whole.exr"));
    }
    // One copy of the state, however often it was saved.
    assert_says(&said.err, &["go on with the same command and `--resume="]);
    assert!(desk.path("a.kept-1.checkpoint").exists());
    assert_eq!(desk.content().len(), 5, "{:?}", desk.content().keys());
    let resumed = ["-o", "c.exr", "-D", stop, "--resume=a.kept-1.checkpoint"];
    desk.done(resumed);
    assert!(desk.bytes("c.exr") == desk.bytes("whole.exr"));
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
    fs::write(desk.path("k.checkpoint"), b"a picture of a cat").expect("written");
    desk.refused(["--resume=k.checkpoint"], &["k.checkpoint", "not written by this program"]);
}

#[test]
fn state_of_a_run_is_replaced_only_by_its_own_or_by_force() {
    let desk = desk();
    for (name, seed) in [("a.checkpoint", "1"), ("b.checkpoint", "2")] {
        desk.done(["-o", "p.exr", "-D", SHORT, "--checkpoint", name, "--seed", seed, "--force"]);
    }
    let other = desk.bytes("b.checkpoint");
    let words = ["--resume=a.checkpoint", "--checkpoint=b.checkpoint", "--seed=1", "-o", "q.exr"];
    desk.refused(words, &["b.checkpoint is of a run that was interrupted", "--force"]);
    assert!(desk.bytes("b.checkpoint") == other);
    // What a run without a result would replace stays.
    let none = ["-o", "b.exr", "--force", "-D", "render.stop={ time = 1e-9 }"];
    desk.ends(4, none);
    assert!(desk.bytes("b.checkpoint") == other);
    desk.done([&words[..], &["--force"]].concat());
    assert!(desk.bytes("b.checkpoint") != other);
}

#[test]
fn what_cannot_be_written_or_held_is_refused_before_the_run() {
    let desk = desk();
    desk.refused(["--checkpoint", "a.state"], &["a.state: a checkpoint needs the extension"]);
    desk.refused(["--checkpoint", "none/a.checkpoint"], &["there is no folder none"]);
    desk.refused(["--size", "60000x60000"], &["60000 x 60000 pixels is beyond what a film holds"]);
    let zero = ["-D", "cameras.main.perspective.resolution=[0, 8]"];
    desk.refused(zero, &["resolution"]);
    desk.refused(["-o", "a.jpg"], &["a.jpg: ", "name a file .png or .exr"]);
    desk.refused(["--layers", "none,depth"], &["--layers none,depth: `none` stands alone"]);
}
