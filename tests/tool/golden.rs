//! Holds all that every verb says and writes to what is stored in `tests/golden`.
//!
//! The table of the cases is `tests/golden/input/cases.txt`: `NAME: COMMAND; COMMAND`, all commands
//! of a case in one folder. Longer ones go on in lines that are indented.
//! Words must be the same; numbers may differ by a millionth, as processors round differently;
//! times, the version, keys and the memory taken are masked, and lines that begin with `~` are not
//! compared.
//! After a change that is meant: `HARMOLUX_BLESS=1 cargo test --test tool golden`, then `git diff`,
//! which also shows what is not compared: last digits, and bytes by their checksum.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs::{self, File};
use std::io::Cursor;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use exr::prelude::{ReadChannels, ReadLayers, read};
use rayon::prelude::*;

use crate::common::desk::{Desk, Said, repository};

/// The cases; `FILE <` before a command is its stdin. The help of every verb comes in addition.
const CASES: &str = include_str!("../golden/input/cases.txt");

/// What every folder has from the repository.
const FILES: [(&str, &str); 9] = [
    ("room.toml", "tests/golden/input/room.toml"),
    ("planes.toml", "tests/golden/input/planes.toml"),
    ("rays.txt", "tests/golden/input/rays.txt"),
    ("stone.obj", "tests/data/meshes/trimesh.obj"),
    ("other.ply", "tests/data/meshes/meshio.ply"),
    ("skull.coef", "tests/data/interop/spharm_pdm_mm.coef"),
    ("cells.csv", "tests/data/interop/aicsshparam.csv"),
    ("rock.txt", "data/shapes/pebble.txt"),
    ("head.obj", "data/head.obj"),
];

/// Columns of tables, and keys of JSON, whose numbers are times or memory.
const TIMES: [&str; 10] = [
    "time",
    "fit ms",
    "ray ns",
    "seconds",
    "fit_ms",
    "prepare_ms",
    "nanoseconds_per_ray",
    "render_s",
    "relmse_equal_time",
    "patch_bytes",
];

/// Whether a column or a key holds times or memory.
fn is_timed(name: &str) -> bool {
    TIMES.contains(&name)
        || ["_seconds", "_ns", "_ratio", "_ns_q1", "_ns_q3"].iter().any(|end| name.ends_with(end))
}

#[test]
fn every_verb_says_and_writes_what_is_stored() {
    let mut cases = BTreeMap::new();
    for case in CASES.replace("\n    ", " ").lines() {
        let (name, commands) = case.split_once(": ").expect("a name");
        cases.insert(name.to_owned(), commands.to_owned());
    }
    let help = Desk::new().done("--help").out;
    let verbs = help.lines().filter_map(|line| line.strip_prefix("  ")?.split_once("  "));
    for (verb, _) in verbs.filter(|(v, _)| v.chars().all(char::is_alphabetic) && !v.is_empty()) {
        assert!(
            cases.contains_key(verb) || ["exact", "help", "completions", "man"].contains(&verb),
            "no case of {verb}"
        );
        cases.insert(format!("help_of_{verb}"), format!("{verb} --help; {verb} -h"));
    }
    let folder = repository("tests/golden");
    let bless = std::env::var_os("HARMOLUX_BLESS").is_some();
    let stored = fs::read_dir(&folder).expect("a folder").map(|e| e.expect("readable").path());
    let stored: Vec<_> = stored.filter(|path| path.is_file()).collect();
    stored.iter().filter(|_| bless).for_each(|path| fs::remove_file(path).expect("removed"));
    let all: Vec<_> =
        cases.par_iter().map(|(name, lines)| (name, transcript(&desk(), lines))).collect();
    let mut wrong = String::new();
    for (name, now) in &all {
        let path = format!("{folder}/{name}.txt");
        if bless {
            fs::write(path, now).expect("written");
        } else if let Some(what) = difference(&fs::read_to_string(path).unwrap_or_default(), now) {
            let _ = writeln!(wrong, "{name}.txt: {what}");
        }
    }
    assert!(bless || stored.len() <= cases.len(), "there are files of no case in {folder}");
    assert!(wrong.is_empty(), "{wrong}is it meant? HARMOLUX_BLESS=1 cargo test --test tool golden");
}

/// Every key of JSON in the stored outputs is explained on its page.
#[test]
fn keys_of_json_are_documented() {
    let page = fs::read_to_string(repository("docs/reference/json.md")).expect("readable");
    let keys = page.lines().filter_map(|line| line.strip_prefix("| ")?.split(" | ").next());
    let names = |cell: &str| -> Vec<String> {
        let paths = cell.split('`').skip(1).step_by(2);
        paths.map(|path| path.rsplit('.').next().unwrap_or(path).replace("[]", "")).collect()
    };
    let known: BTreeSet<String> = keys.flat_map(names).collect();
    let stored = fs::read_dir(repository("tests/golden")).expect("a folder");
    let texts = stored.map(|entry| entry.expect("readable").path()).filter(|path| path.is_file());
    let texts = texts.map(|path| fs::read_to_string(path).expect("readable"));
    let lines: Vec<String> =
        texts.flat_map(|t| t.lines().map(str::to_owned).collect::<Vec<_>>()).collect();
    // The attributes of pictures name objects.
    for line in lines.iter().filter(|line| line.trim_start().starts_with(['{', '"'])) {
        for (at, _) in line.match_indices("\":") {
            let key = line[..at].rsplit('"').next().unwrap_or("");
            let plain =
                key.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
            assert!(!plain || known.contains(key), "`{key}` is not in docs/reference/json.md");
        }
    }
}

/// Puts what the cases need in a folder.
pub(super) fn desk() -> Desk {
    let desk = Desk::new();
    for (name, from) in FILES {
        desk.put(name, fs::read(repository(from)).expect("readable"));
    }
    let stone = desk.text("stone.obj");
    desk.put("torn.obj", stone.trim_end().rsplit_once('\n').expect("a last face").0);
    desk.put("points.xyz", stone.split("f ").next().expect("vertices").replace("v ", ""));
    desk.put("nothing", "");
    desk
}

/// Runs commands in a folder and writes down what they say and write.
pub(super) fn transcript(desk: &Desk, commands: &str) -> String {
    let root = desk.path("");
    let (mut text, mut before) = (String::new(), files(&root));
    for line in commands.split(';').map(str::trim) {
        let (input, words) = line.split_once(" < ").unwrap_or(("nothing", line));
        let mut command = desk.command(words);
        command.env_remove("COLUMNS").stdin(File::open(desk.path(input)).expect("readable"));
        let said = Said::of(&command.output().expect("the tool starts"));
        let _ = writeln!(text, "$ {line}\nexit code {}", said.code);
        for (name, said) in [("stdout", &said.out), ("stderr", &said.err)] {
            let said = said.replace(&*root.to_string_lossy(), "FOLDER/");
            let _ = write!(text, "--- {name}\n{}", masked(&said));
        }
        let after = files(&root);
        for (name, bytes) in after.iter().filter(|(n, bytes)| before.get(*n) != Some(bytes)) {
            let _ = write!(text, "--- file {name}\n{}", described(name, bytes));
        }
        before = after;
    }
    text
}

/// Reads all files in a folder and the folders in it.
fn files(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let (mut all, mut folders) = (BTreeMap::new(), vec![root.to_owned()]);
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).expect("readable").map(|e| e.expect("readable").path()) {
            let name = path.strip_prefix(root).expect("inside").to_string_lossy().into_owned();
            match fs::read(&path) {
                Ok(bytes) => drop(all.insert(name, bytes)),
                Err(_) => folders.push(path),
            }
        }
    }
    all
}

/// Describes a file by what does not depend on the processor.
fn described(name: &str, bytes: &[u8]) -> String {
    let fnv1a = |h: u64, byte: &u8| (h ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
    let checksum = format!("~ fnv1a {:016x}\n", bytes.iter().fold(0xcbf2_9ce4_8422_2325, fnv1a));
    if name.contains("time_degree.") {
        return "a figure of times\n".to_owned();
    }
    match (name.rsplit('.').next(), std::str::from_utf8(bytes)) {
        (Some("html"), Ok(text)) => page(text),
        (Some("svg"), Ok(text)) => {
            let parts = text.split('"').filter(|part| !part.contains("base64,"));
            let text = parts.collect::<Vec<_>>().join("\"");
            let pieces = pieces(&text);
            let words = pieces.iter().step_by(2).copied().collect::<Vec<_>>().join("#");
            let numbers = pieces.iter().skip(1).step_by(2).map(|n| n.parse().unwrap_or(f64::NAN));
            let (hash, sum) = (crc32fast::hash(words.as_bytes()), numbers.sum::<f64>());
            format!("SVG, words {hash:#010x}, {} pieces, sum {sum:?}\n{checksum}", pieces.len())
        }
        (Some("png"), _) => {
            let picture = image::load_from_memory(bytes).expect("a PNG").to_rgb8();
            let sum: u64 = picture.iter().map(|&sample| u64::from(sample)).sum();
            format!("PNG, {} x {}, sum {sum}\n{checksum}", picture.width(), picture.height())
        }
        (Some("exr"), _) => {
            let reader = read().no_deep_data().largest_resolution_level().all_channels();
            let reader = reader.first_valid_layer().all_attributes();
            let layer = reader.from_buffered(Cursor::new(bytes)).expect("an EXR").layer_data;
            let mut text = format!("EXR, {:?}\n", layer.size);
            // What tells runs apart is another with each version.
            let mask = |name: &str| if name == "run" { "~ " } else { "" };
            let other = layer.attributes.other.iter();
            let other = other.map(|(k, v)| format!("{}{k}: {v:?}\n", mask(&k.to_string())));
            text.extend(other.collect::<BTreeSet<_>>());
            for channel in &layer.channel_data.list {
                let sum: f64 = channel.sample_data.values_as_f32().map(f64::from).sum();
                let _ = writeln!(text, "{}, sum {sum:?}", channel.name);
            }
            text + &checksum
        }
        (Some("npy"), _) => {
            let start = 10 + usize::from(bytes[8]) + 256 * usize::from(bytes[9]);
            let mut text = format!("NPY, {}", String::from_utf8_lossy(&bytes[10..start]));
            for number in bytes[start..].as_chunks().0 {
                let _ = writeln!(text, "{:?}", f64::from_le_bytes(*number));
            }
            text + &checksum
        }
        (_, Ok(text)) => masked(text),
        _ => format!("{} bytes\n{checksum}", bytes.len()),
    }
}

/// Describes a page by its data: texts, and how many things there are of a kind.
fn page(text: &str) -> String {
    let data = text.split_once("id=\"data\">").and_then(|(_, rest)| rest.split_once("</script>"));
    let data: serde_json::Value =
        serde_json::from_str(data.expect("data").0).expect("the data are JSON");
    let mut said = "HTML".to_owned();
    for (key, value) in data.as_object().expect("an object") {
        let _ = match value.as_array() {
            Some(list) => write!(said, ", {} {key}", list.len()),
            None => write!(said, ", {key} {value}"),
        };
    }
    for shape in data["shapes"].as_array().expect("shapes") {
        let numbers = STANDARD.decode(shape["coefficients"].as_str().expect("base64"));
        let numbers = numbers.expect("base64");
        let sum: f64 =
            numbers.as_chunks().0.iter().map(|n| f64::from(f32::from_le_bytes(*n))).sum();
        let _ = write!(said, ", {} about {}: {sum:.6}", shape["name"], shape["centre"]);
    }
    masked(&said)
}

/// Masks what is not the same from run to run.
pub(super) fn masked(text: &str) -> String {
    let (mut all, mut bar, mut columns) = (String::new(), ' ', Vec::new());
    let text = text.replace(env!("CARGO_PKG_VERSION"), "VERSION");
    for line in text.lines().filter(|line| !is_progress(line)) {
        let line = line.split_once(" for rays: ").map_or(line, |(what, _)| what);
        let line = &without_key(line);
        let now = if line.starts_with('|') { '|' } else { ',' };
        let mut cells: Vec<_> = line.split(now).collect();
        if cells.iter().any(|cell| is_timed(cell.trim())) {
            columns = cells.iter().map(|cell| is_timed(cell.trim())).collect();
            bar = now;
        }
        for (cell, _) in cells.iter_mut().zip(&columns).filter(|(_, timed)| **timed && bar == now) {
            *cell = "#";
        }
        let line = cells.join(&now.to_string());
        let mut pieces = pieces(&line);
        for i in (1..pieces.len()).step_by(2) {
            let key = pieces[i - 1].trim_end().strip_suffix("\":");
            let key = key.is_some_and(|key| is_timed(key.rsplit('"').next().unwrap_or(key)));
            let mut unit = pieces[i + 1].split(|c: char| !c.is_alphanumeric());
            let is_time = |unit| matches!(unit, Some("s" | "ms" | "ns" | "min"));
            if key || unit.next() == Some("") && is_time(unit.next()) {
                pieces[i] = "#";
            }
        }
        let _ = writeln!(all, "{}", pieces.concat());
    }
    all
}

/// Masks the key of a row, which follows from the version of the program.
fn without_key(line: &str) -> String {
    const KEY: &str = "fnv1a64:0123456789abcdef";
    match line.rfind(&KEY[..8]) {
        Some(at) if line[..at].ends_with(',') || line.contains("\"key\": ") => {
            format!("{}#{}", &line[..at], line.get(at + KEY.len()..).unwrap_or(""))
        }
        _ => line.to_owned(),
    }
}

/// Whether a line says how far a run is, as slow ones do.
fn is_progress(line: &str) -> bool {
    let start = line.trim_start().split_once("  ").map_or("", |(start, _)| start);
    start.starts_with(|c: char| c.is_ascii_digit())
        && (start.ends_with(" s") || start.ends_with(" %"))
}

/// Cuts a text into words and numbers in turn, words first and last.
pub(super) fn pieces(text: &str) -> Vec<&str> {
    let byte = |i: usize| text.as_bytes().get(i).copied().unwrap_or(b' ');
    let after_digits = |i| i + text[i..].bytes().take_while(u8::is_ascii_digit).count();
    let (mut all, mut start, mut i) = (Vec::new(), 0, 0);
    while i < text.len() {
        let first = i + usize::from(matches!(byte(i), b'-' | b'+'));
        let in_word = i > 0 && (byte(i - 1).is_ascii_alphanumeric() || byte(i - 1) == b'#');
        if in_word || !byte(first).is_ascii_digit() {
            i += 1;
            continue;
        }
        let mut end = after_digits(first);
        if byte(end) == b'.' && byte(end + 1).is_ascii_digit() {
            end = after_digits(end + 1);
        }
        let power = end + 1 + usize::from(matches!(byte(end + 1), b'-' | b'+'));
        if matches!(byte(end), b'e' | b'E') && byte(power).is_ascii_digit() {
            end = after_digits(power);
        }
        all.extend([&text[start..i], &text[i..end]]);
        (start, i) = (end, end);
    }
    all.push(&text[start..]);
    all
}

/// Shows the first line that is another, from a little before the place.
fn difference(stored: &str, now: &str) -> Option<String> {
    let (mut a, mut b) = (stored.lines(), now.lines());
    for number in 1.. {
        let (was, is) = (a.next(), b.next());
        if was.or(is).is_none() {
            break;
        }
        let [was, is] = [was, is].map(|line| pieces(line.unwrap_or("(the end)")));
        let at = (0..was.len().max(is.len())).find(|&i| !alike(i, was.get(i), is.get(i)));
        if let Some(at) = at.filter(|_| !(was[0].starts_with("~ ") && is[0].starts_with("~ "))) {
            let from = at.saturating_sub(6);
            let show = |line: Vec<&str>| -> String {
                line[from.min(line.len())..].concat().chars().take(150).collect()
            };
            return Some(format!("line {number}\n  was {}\n  is  {}", show(was), show(is)));
        }
    }
    None
}

/// Whether two pieces are the same, numbers nearly so; short ones must be as long.
fn alike(i: usize, was: Option<&&str>, is: Option<&&str>) -> bool {
    let (Some(a), Some(b)) = (was, is) else { return false };
    let number = |text: &str| if i % 2 == 1 { text.parse().ok() } else { None };
    let (Some(x), Some(y)) = (number(a), number(b)) else { return a == b };
    let (largest, long): (f64, _) = (f64::max(f64::abs(x), f64::abs(y)), a.len().max(b.len()) > 12);
    // Part of a fingerprint may read as a number without bound.
    a == b
        || (x - y).abs() <= 1e-6 * largest + 1e-12
            && (long || a.len() == b.len() || largest <= 1e-12)
}
