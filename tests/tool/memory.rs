//! Too little memory, too many threads, texts without end: each run ends, and says why.

use crate::common::desk::{Desk, Said, assert_says};
use crate::common::scenes::{CAMERA, LAMP, ROOM};

/// A folder for pictures of 16 x 16 pixels of the room.
fn desk() -> Desk {
    let render = "resolution = [16, 16]\n[render]\nstop = { walks = 1 }\n";
    let scene = [ROOM, LAMP, CAMERA, render].concat();
    Desk::of(&["render", "room.toml"]).with("room.toml", scene)
}

#[test]
fn what_does_not_fit_is_refused_with_what_would() {
    let desk = desk();
    let before = desk.content();
    let said = desk.ends(1, ["--size", "4096x4096", "--max-memory", "200M", "-o", "a.png"]);
    assert_says(
        &said.err,
        &["error: a film of 4096 x 4096 pixels needs 4.03 GB, ", " MB are free"],
    );
    assert_says(&said.err, &[" would fit; choose fewer pixels"]);
    assert!(desk.content() == before);
    desk.done(["--max-memory", "1G", "-o", "a.png"]);
    let said = desk.ends(2, ["--max-memory", "2GB"]);
    assert_says(&said.err, &["a number of bytes above 0, or one with K, M, G or T behind"]);
}

#[cfg(target_os = "linux")]
#[test]
fn what_nobody_asked_for_ends_with_the_code_of_a_failure() {
    let desk = desk();
    let mut seen = Vec::new();
    // From what a program of this size just starts with.
    for megabytes in (100..420).step_by(40) {
        let limited = format!("ulimit -v {}; exec \"$0\" \"$@\"", megabytes << 10);
        let mut command = std::process::Command::new("sh");
        command.current_dir(desk.path("")).env("RUST_BACKTRACE", "0");
        command.args(["-c", &limited, env!("CARGO_BIN_EXE_harmolux"), "render", "room.toml"]);
        let said =
            Said::of(&command.args(["-o", "a.png", "--force"]).output().expect("the tool starts"));
        assert!(!said.err.contains("panicked"), "{megabytes} MB: {}", said.err);
        assert!([0, 1].contains(&said.code), "{megabytes} MB: {} {}", said.code, said.err);
        assert!(said.code == 0 || !said.err.is_empty(), "{megabytes} MB end without a word");
        seen.push(said.code);
    }
    assert_eq!(seen.last(), Some(&0), "{seen:?}");
}

#[test]
fn more_threads_than_are_of_use_are_not_started() {
    let desk = Desk::new();
    let mut command = desk.command(["exact", "sobolev"]);
    let said = Said::of(&command.env("RAYON_NUM_THREADS", "100000").output().expect("starts"));
    assert_eq!(said.code, 0, "{}", said.err);
    assert_says(&said.err, &["warning: ", " threads are used instead of 100000"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_mesh_of_one_line_without_end_is_cut() {
    let desk = Desk::new().with("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 ");
    let file = std::fs::OpenOptions::new().write(true).open(desk.path("a.obj")).expect("there");
    file.set_len(1 << 27).expect("as a sparse file");
    let said = desk.ends(3, ["check", "a.obj"]);
    assert_says(&said.err, &["a.obj: cannot read: a line does not end within 67.1 MB"]);
}
