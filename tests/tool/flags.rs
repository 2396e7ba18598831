//! No verb ignores a flag: for every kind of input, each flag of its help changes what is said or
//! written, or is refused.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rayon::prelude::*;

use crate::common::desk::Desk;
use crate::golden::{self, transcript};

/// Commands to which flags are added, one for each kind of input that a verb tells apart.
const COMMANDS: [&str; 44] = [
    "exact sobolev",
    "exact sphere",
    "exact cap",
    "exact concentric",
    "exact planes",
    "exact room",
    "exact cie171-5.4",
    "exact cie171-5.5",
    "rays.txt < probe room.toml --quick",
    "rays.txt < probe room.toml --quick -I",
    "render room.toml --quick -o x.exr",
    "illum room.toml --quick",
    "falsecolor view.exr -o x.svg",
    "falsecolor lux.csv -o x.svg",
    "compare view.exr second.exr -o x.svg",
    "check torn.obj",
    "fit stone.obj -l 3 -o x.txt",
    "fit stone.obj -l 3 -o x.hxc",
    "fit points.xyz -l 1 -o x.txt",
    "fit stone.obj other.ply -l 2 -o d",
    "info stone.obj",
    "info rock.txt",
    "info small.hxc",
    "info points.xyz",
    "info cells.csv --row 1",
    "info skull.coef",
    "convert rock.txt x.npy",
    "convert stone.obj x.ply",
    "convert small.hxc x.txt",
    "convert rock.txt x.hxc",
    "evaluate small.hxc --grid 3x4",
    "sweep stone.obj -l 2 -o d",
    "sweep rock.txt -l 1 -o d --scene room.toml",
    "view small.hxc -o x.html",
    "spectrum rock.txt",
    "diff small.hxc stone.obj",
    "mesh rock.txt -o x.obj",
    "transform small.hxc -o x.txt",
    "mean small.hxc small.hxc -o x.txt",
    "modes rock.txt small.hxc third.txt",
    "modes table.csv",
    "random --power-law rms=0.1,exponent=2 -l 2 -o x.txt",
    "random --gaussian-sphere sigma=0.1,nu=4 -l 8 -o x.txt",
    "random --spectrum rock.txt -o x.txt",
];

/// What makes the inputs that the repository does not have.
const BEFORE: &str = "fit stone.obj -l 3 -o small.hxc; \
    random --power-law rms=0.1,exponent=2 -l 3 -o third.txt; \
    mesh third.txt -o third.obj --resolution 4; \
    fit stone.obj other.ply third.obj -l 2 -o fits --table table.csv; \
    render room.toml --quick -o view.exr; \
    render room.toml --quick --seed 2 -o second.exr; illum room.toml --quick -o lux.csv";

/// A value of each flag that has one, another than its default; of one verb, where its flag is
/// another thing than that of others.
const VALUES: [(&str, &str); 87] = [
    ("compare --map", "flip"),
    ("compare --tolerance", "flip=0"),
    ("sweep --tolerance", "rms=50%"),
    ("-D", "lights.lamp.point.intensity=31"),
    ("--area", "7"),
    ("--angles", "20"),
    ("--boundary", "0.1"),
    ("--distances", "1,2"),
    ("--edge", "2"),
    ("--emission", "1,3"),
    ("--flux", "70"),
    ("--fraction", "0.3"),
    ("--gap", "3"),
    ("--grid", "4x5"),
    ("--height", "1.5"),
    ("--intensity", "7"),
    ("--internal", "0.5"),
    ("--offset", "0.1"),
    ("--orders", "3"),
    ("--pixels-per-degree", "20"),
    ("--plane", "upper"),
    ("--points", "rays.txt"),
    ("--reflectance", "0.31"),
    ("--width", "0.0123"),
    ("--add-radius", "2"),
    ("--align-to", "rock.txt"),
    ("--angle", "30"),
    ("--at", "1"),
    ("--axis", "0,0,1"),
    ("--bad", "bad.ply"),
    ("--camera", "other"),
    ("--centre", "0.1,0,0"),
    ("--channel", "stderr.Y"),
    ("--checkpoint", "c.checkpoint"),
    ("--count", "2"),
    ("--crop", "0,0,4,4"),
    ("--csphase", "-1"),
    ("--degree", "1"),
    ("--divisions", "3"),
    ("--estimator", "path"),
    ("--euler", "10,20,30"),
    ("--exposure", "0.3"),
    ("--tone", "filmic"),
    ("--fill-holes", "5"),
    ("--filter", "lanczos"),
    ("--from", "dov"),
    ("--gaussian-sphere", "sigma=0.2"),
    ("--group", "other"),
    ("--label", "W"),
    ("--lambda", "0.01"),
    ("--lat-long", "5x6"),
    ("--layers", "none"),
    ("--log", "3"),
    ("--map", "map.ply"),
    ("--mesh", "stone.obj"),
    ("--matrix", "0,-1,0,1,0,0,0,0,1"),
    ("--min", "0.5"),
    ("--mirror", "x"),
    ("--modes", "1"),
    ("--normalisation", "ortho"),
    ("--not-star", "first"),
    ("--not-star-limit", "1"),
    ("--oversampling", "7"),
    ("--output", "other"),
    ("--palette", "magma"),
    ("--power-law", "rms=0.2,exponent=3"),
    ("--projection", "grid"),
    ("--quaternion", "0,0,1,1"),
    ("--radius", "3"),
    ("--recentre", "centroid"),
    ("--resolution", "2"),
    ("--row", "2"),
    ("--samples", "3"),
    ("--scale", "2"),
    ("--scene", "room.toml"),
    ("--seed", "7"),
    ("--size", "9x7"),
    ("--spectrum", "rock.txt"),
    ("--table", "new.csv"),
    ("--table-layout", "aics"),
    ("--to", "dov"),
    ("--to-csphase", "-1"),
    ("--to-normalisation", "ortho"),
    ("--tolerance", "0.01"),
    ("--unit", "km"),
    ("--up", "x"),
    ("--weld", "0.001"),
];

/// What does nothing with a command, and why that is right.
const SAME: [(&str, &str, &str); 5] = [
    ("falsecolor lux.csv -o x.svg", "--lines", "a grid has isolines always, as the help says"),
    ("fit stone.obj -l 3 -o x.txt", "--not-star first", STAR),
    ("fit stone.obj -l 3 -o x.hxc", "--not-star first", STAR),
    ("fit stone.obj other.ply -l 2 -o d", "--not-star first", STAR),
    ("sweep stone.obj -l 2 -o d", "--not-star first", STAR),
];

const STAR: &str = "the mesh is star-shaped, and needs no envelope";

/// What other tests look at: how a run is made, not of what.
const ELSEWHERE: [&str; 6] =
    ["--threads", "--max-memory", "--json", "--help", "--version", "--force"];

#[test]
fn no_verb_ignores_a_flag() {
    let before = inputs();
    let said = |command: &str| {
        let desk = Desk::new();
        for (name, bytes) in &before {
            desk.put(name, bytes);
        }
        let said = transcript(&desk, command);
        said.split_once('\n').expect("the command comes first").1.to_owned()
    };
    let help = Desk::new();
    let idle = COMMANDS.par_iter().flat_map_iter(|command| {
        let plain = said(command);
        let words = if command.starts_with("exact") { 2 } else { 1 };
        let verb = command.split_once(" < ").map_or(*command, |(_, verb)| verb);
        let verb = verb.split(' ').take(words);
        let flags = flags(&help.done(verb.chain(["--help"]).collect::<Vec<_>>()).out);
        let added = flags.into_iter().filter(|flag| !given(command, flag));
        let all = added.map(|flag| format!("{command} {}", with_value(command, flag)));
        all.filter(|line| said(line) == plain).collect::<Vec<_>>()
    });
    let is_right =
        |line: &String| SAME.iter().any(|(command, flag, _)| *line == format!("{command} {flag}"));
    let (right, wrong): (Vec<_>, Vec<_>) = idle.collect::<Vec<_>>().into_iter().partition(is_right);
    assert_eq!(wrong, Vec::<String>::new(), "flags that do nothing");
    assert_eq!(right.len(), SAME.len(), "some of SAME do something");
}

/// Makes all files that the commands read.
fn inputs() -> BTreeMap<String, Vec<u8>> {
    let desk = golden::desk();
    transcript(&desk, BEFORE);
    let files = desk.content().into_iter().filter(|(path, _)| path.is_file());
    let name = |path: PathBuf| path.file_name().expect("a file").to_string_lossy().into_owned();
    files.map(|(path, bytes)| (name(path), bytes)).collect()
}

/// Lists the flags of a help, by their long names where they have one.
fn flags(help: &str) -> Vec<String> {
    let lines = help.lines().filter(|line| line.len() - line.trim_start().len() <= 6);
    let flags = lines.filter_map(|line| {
        let mut names = line.split_whitespace().take_while(|word| word.starts_with('-'));
        let first = names.next()?;
        let last = names.next().unwrap_or(first);
        let end = last.find(['[', '=']).unwrap_or(last.len());
        Some(last[..end].trim_end_matches(',').to_owned())
    });
    flags.filter(|flag| !ELSEWHERE.contains(&flag.as_str())).collect()
}

/// Whether a command has a flag already.
fn given(command: &str, flag: &str) -> bool {
    let short = match flag {
        "--output" => "-o",
        "--degree" | "--degrees" => "-l",
        _ => flag,
    };
    command.split(' ').any(|word| word == flag || word == short)
}

/// Puts a value behind a flag that takes one.
fn with_value(command: &str, flag: String) -> String {
    let own = format!("{} {flag}", command.split(' ').next().unwrap_or_default());
    match VALUES.iter().find(|(name, _)| [&own, &flag].contains(&&(*name).to_owned())) {
        Some((_, value)) => format!("{flag} {value}"),
        None => flag,
    }
}
