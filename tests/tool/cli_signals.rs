//! Signals, limits and runs that go on, as a user meets them: nothing that is done is lost, and all
//! ends when it is asked to.

use std::fs;
use std::process::Command;
use std::thread::sleep;
use std::time::Duration;

use crate::common::desk::{Desk, assert_says, interrupt, is_ignored};
use crate::common::running::Running;
use crate::common::scenes::{LAMP, ROOM};
use crate::common::solids::cube;

/// A group of two sensors.
const FLOOR: &str = "[sensors.floor.points]
at = [[1, 1, 0], [3, 4, 0]]
normal = [0, 0, 1]
";

/// Starts the tool by a shell that does something first.
fn by_shell(desk: &Desk, first: &str, words: &str) -> Command {
    let tool = desk.command(words);
    let mut shell = Command::new("sh");
    shell.current_dir(desk.path("")).args(["-c", &format!("{first}; exec \"$0\" \"$@\"")]);
    shell.arg(tool.get_program()).args(tool.get_args());
    shell
}

/// A folder with a small cube, and a pipe that nobody writes to: a fit of it never ends.
fn desk_with_pipe() -> Desk {
    let desk = Desk::of(&["fit"]).with("a.obj", cube(1.0));
    desk.put_pipe("b.obj");
    desk
}

#[test]
fn signals_that_were_ignored_stay_ignored() {
    let desk = Desk::new().with("room.toml", [ROOM, LAMP, FLOOR].concat());
    let words = "illum room.toml -o a.csv -D illum.stop={time=3}";
    let mut run = Running::start(&mut by_shell(&desk, "trap '' HUP INT", words));
    for signal in ["-HUP", "-INT", "-HUP", "-INT"] {
        sleep(Duration::from_millis(400));
        run.send(signal);
    }
    let said = run.end();
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(desk.text("a.csv").lines().count(), 3, "a header and two sensors");
}

#[test]
fn limit_on_the_size_of_files_is_an_error_of_the_write() {
    let desk = Desk::new().with("a.obj", cube(1.0));
    let words = "fit a.obj -l 2 -o a.txt";
    let output = by_shell(&desk, "ulimit -f 0", words).output().expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert_says(&said, &["error: a.txt: cannot write: "]);
    assert!(!desk.path("a.txt").exists());
}

#[test]
fn long_fit_says_what_it_is_at_and_ends_at_any_signal() {
    let heard = [("-HUP", 1), ("-INT", 2), ("-TERM", 15)];
    let heard = heard.into_iter().filter(|(_, number)| !is_ignored(*number));
    let runs: Vec<_> = heard
        .map(|(signal, _)| {
            let desk = desk_with_pipe();
            let run = Running::start(&mut desk.command("b.obj -l 2 -o b.txt"));
            (signal, desk, run)
        })
        .collect();
    for (signal, desk, mut run) in runs {
        assert!(run.wait_for(|run| run.err().contains(" s  fitting b.obj")), "{}", run.err());
        run.send(signal);
        let said = run.end();
        assert_eq!(said.code, 130, "{signal}");
        assert!(said.err.ends_with("interrupted\n"), "{}", said.err);
        for name in ["b.txt", "b.unfinished.txt"] {
            assert!(!desk.path(name).exists(), "{name}");
        }
    }
}

#[test]
fn fits_that_are_done_stay_and_the_next_run_goes_on() {
    let desk = desk_with_pipe();
    let words = "a.obj b.obj -l 2 -o out -j 1";
    let mut run = Running::start(&mut desk.command(words));
    let rows = || fs::read_to_string(desk.path("out/fits.csv")).map_or(0, |t| t.lines().count());
    assert!(run.wait_for(|_| rows() == 2 && desk.path("out/a.txt").exists()), "{}", run.err());
    run.send(interrupt());
    let said = run.end();
    assert_eq!(said.code, 130, "{}", said.err);
    let before = desk.text("out/fits.csv");
    assert!(before.lines().count() == 2 && before.contains("\na.obj,2,"), "{before}");
    fs::remove_file(desk.path("b.obj")).expect("a pipe");
    desk.put("b.obj", cube(2.0));
    desk.done(words);
    let after = desk.text("out/fits.csv");
    // With the time that it took: the first was not fitted again.
    assert!(after.starts_with(&before) && after.contains("\nb.obj,2,"), "{after}");
    desk.done(words);
    assert_eq!(desk.text("out/fits.csv"), after);
}

#[test]
fn fits_that_were_killed_in_a_row_or_lost_a_file_are_made_again() {
    let desk = Desk::of(&["fit"]);
    for (name, side) in [("a.obj", 1.0), ("b.obj", 2.0), ("c.obj", 3.0)] {
        desk.put(name, cube(side));
    }
    let words = "a.obj b.obj c.obj -l 2 -o out";
    desk.done(words);
    let (whole, file) = (desk.text("out/fits.csv"), desk.bytes("out/b.txt"));
    let rows: Vec<&str> = whole.lines().collect();
    // The header, a row of the user, one that is whole and one that was cut off.
    let user = rows[1].replace("a.obj", "mine.obj");
    let cut = &rows[2][..20];
    desk.put("out/fits.csv", format!("{}\n{user}\n{}\n{cut}", rows[0], rows[3]));
    for name in ["a.txt", "b.txt"] {
        fs::remove_file(desk.path(&format!("out/{name}"))).expect("it was written");
    }
    desk.done(words);
    let again = desk.text("out/fits.csv");
    let now: Vec<&str> = again.lines().collect();
    assert_eq!((now.len(), now[3], now[4]), (5, rows[3], &*user), "{again}");
    assert!(now[1].starts_with("a.obj,2,") && now[2].starts_with("b.obj,2,"), "{again}");
    assert_eq!(desk.bytes("out/b.txt"), file);
    // What follows from another mesh or other settings is another result.
    desk.refused("a.obj -l 3 -o out", &["the row of a.obj is of another run", "--force"]);
    desk.put("a.obj", cube(4.0));
    desk.refused(words, &["out/fits.csv: the row of a.obj is of another run"]);
    assert_eq!(desk.text("out/fits.csv"), again);
    desk.done("a.obj -l 3 -o out --force");
    assert_eq!(desk.text("out/fits.csv").lines().count(), 2);
}

#[test]
fn table_that_cannot_be_read_stays_as_it_is() {
    let desk = Desk::of(&["fit", "a.obj", "-l", "2", "-o", "out"]).with("a.obj", cube(1.0));
    desk.done("");
    let whole = desk.text("out/fits.csv");
    for more in ["mine,2\n", "a.obj\n,,\n"] {
        desk.put("out/fits.csv", format!("{whole}{more}"));
        let words = ["out/fits.csv:3: this is no row of 33 columns", "--force"];
        desk.refused("", &words);
        assert_eq!(desk.text("out/fits.csv"), format!("{whole}{more}"));
    }
    // A row without its end is no row yet; when the run fails it stays all the same.
    let header = whole.lines().next().expect("a header");
    let cut = format!("{header}\nmine,2");
    desk.put("out/fits.csv", &cut);
    desk.refused("", &["out/a.txt: this file is there already"]);
    assert_eq!(desk.text("out/fits.csv"), cut);
}
