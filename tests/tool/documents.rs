//! What README and docs show is true: every command runs and says what is printed, every scene is
//! read, every link leads somewhere, and every page is in the book.
//!
//! A `console` block has commands behind `$ ` and what they print; `...` stands for any lines,
//! numbers may differ by a hundredth, and times are not compared. The commands of an `sh`
//! block must succeed. All commands of a page run in one folder, which has `data/` of the
//! repository; in `sh` blocks pictures are small and estimates short. A `toml` block is a whole
//! scene, or a part that is put into one. Rust blocks are tests of the documentation (`src/lib.rs`).

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use harmolux::io::scene_file::SceneFile;
use rayon::prelude::*;
use tempfile::TempDir;
use toml::{Table, Value};

use crate::common::desk::{Said, repository};
use crate::golden::{masked, pieces};

/// Commands of the README that are not run: the build, and these tests.
const NOT_RUN: [&str; 2] = ["cargo test", "cargo install --path ."];
/// How the README starts the tool before it is on the path.
const BY_CARGO: &str = "cargo run --release -- ";
/// How far numbers may be from what is printed: other processors round differently, and walks
/// follow.
const TOLERANCE: f64 = 0.01;

/// A part of a page between fences.
struct Block {
    line: usize,
    language: String,
    text: String,
}

/// Returns README and all pages of docs, and their texts.
fn pages() -> Vec<(PathBuf, String)> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        let entries = fs::read_dir(folder).expect("a folder").map(|e| e.expect("readable").path());
        for path in entries {
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|e| e == "md") {
                found.push(path);
            }
        }
    }
    let mut paths = vec![PathBuf::from(repository("README.md"))];
    walk(Path::new(&repository("docs")), &mut paths);
    paths.sort();
    let read = |path: &PathBuf| fs::read_to_string(path).expect("UTF-8");
    paths.into_iter().map(|path| (path.clone(), read(&path))).collect()
}

fn blocks(text: &str) -> Vec<Block> {
    let (mut blocks, mut open): (Vec<Block>, bool) = (Vec::new(), false);
    for (i, line) in text.lines().enumerate() {
        match (line.trim_start().strip_prefix("```"), open) {
            (Some(language), false) => {
                let language = language.trim().to_owned();
                blocks.push(Block { line: i + 1, language, text: String::new() });
                open = true;
            }
            (Some(_), true) => open = false,
            (None, true) => {
                let block = blocks.last_mut().expect("one is open");
                block.text.push_str(line);
                block.text.push('\n');
            }
            (None, false) => {}
        }
    }
    assert!(!open, "a fence is not closed");
    blocks
}

fn short(path: &Path) -> String {
    path.strip_prefix(repository("")).unwrap_or(path).display().to_string()
}

/// A folder to run the commands of a page in.
struct Shell {
    folder: TempDir,
    programs: TempDir,
}

impl Shell {
    fn new() -> Self {
        let (folder, programs) = (tempfile::tempdir(), tempfile::tempdir());
        let shell = Self { folder: folder.expect("made"), programs: programs.expect("made") };
        let tool = env!("CARGO_BIN_EXE_harmolux");
        let exact = format!("#!/bin/sh\nexec '{tool}' \"$@\"\n");
        // Runs the same with a fraction of the effort.
        let brief = format!(
            "#!/bin/sh\ncase \"$1\" in\n\
             render) case \"$*\" in *--size*|*--crop*) ;; *) set -- \"$@\" --size 60x40 ;; esac\n\
             set -- \"$@\" -D 'render.stop={{walks=64}}' ;;\n\
             illum) set -- \"$@\" -D 'illum.stop={{walks=2000}}' ;;\n\
             probe) set -- \"$@\" --quick ;;\nesac\nexec '{tool}' \"$@\"\n"
        );
        shell.put("exact/harmolux", &exact);
        shell.put("brief/harmolux", &brief);
        let data = Path::new(&repository("data")).to_owned();
        std::os::unix::fs::symlink(data, shell.folder.path().join("data")).expect("linked");
        shell
    }

    fn put(&self, name: &str, text: &str) {
        use std::os::unix::fs::PermissionsExt;
        let path = self.programs.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(&path, text).expect("written");
        fs::set_permissions(path, fs::Permissions::from_mode(0o755)).expect("set");
    }

    /// Runs a command line.
    fn run(&self, line: &str, effort: &str) -> Said {
        let path = std::env::var("PATH").unwrap_or_default();
        let own = self.programs.path().join(effort);
        let mut shell = Command::new("sh");
        shell.args(["-c", line]).current_dir(self.folder.path()).env_remove("COLUMNS");
        shell.env("PATH", format!("{}:{path}", own.display()));
        Said::of(&shell.output().expect("a shell"))
    }
}

/// Cuts the text of a block into commands and what each prints.
fn commands(block: &Block) -> Vec<(String, Option<Vec<String>>)> {
    let mut commands: Vec<(String, Option<Vec<String>>)> = Vec::new();
    let mut goes_on = false;
    for line in block.text.lines() {
        let (start, is_command) = match block.language.as_str() {
            "console" => (line.strip_prefix("$ "), line.starts_with("$ ")),
            _ => (Some(line), !line.trim().is_empty() && !line.starts_with('#')),
        };
        if goes_on {
            let (last, _) = commands.last_mut().expect("it goes on");
            *last = format!("{} {}", last.trim_end_matches('\\'), line.trim());
        } else if is_command {
            let printed = (block.language == "console").then(Vec::new);
            commands.push((start.expect("a command").to_owned(), printed));
        } else if let Some((_, Some(printed))) = commands.last_mut() {
            printed.push(line.to_owned());
        }
        goes_on =
            commands.last().is_some_and(|(l, _)| l.ends_with('\\')) && (goes_on || is_command);
    }
    commands
}

#[test]
fn commands_do_what_the_pages_say() {
    let wrong: Vec<String> =
        pages().par_iter().flat_map_iter(|(path, text)| faults(path, text)).collect();
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n\n"));
}

/// Runs the commands of a page and tells what is not as it says.
fn faults(path: &Path, text: &str) -> Vec<String> {
    let shell = Shell::new();
    let mut faults = Vec::new();
    for block in blocks(text).iter().filter(|b| ["console", "sh"].contains(&&*b.language)) {
        for (line, printed) in commands(block) {
            let line = line.replace(BY_CARGO, "harmolux ");
            if NOT_RUN.iter().any(|command| line.starts_with(command)) {
                continue;
            }
            let said = shell.run(&line, if printed.is_some() { "exact" } else { "brief" });
            let all = format!("{}{}", said.out, said.err);
            let fault = match printed {
                None if said.code != 0 => Some(format!("exit code {}: {all}", said.code)),
                None => None,
                Some(printed) => {
                    let lines = |text: &str| -> Vec<String> {
                        masked(text).lines().map(str::to_owned).collect()
                    };
                    let page = lines(&printed.join("\n"));
                    // Talk on stderr may be shown or not.
                    let is_so = agree(&page, &lines(&said.out)) || agree(&page, &lines(&all));
                    (!is_so).then(|| format!("the page has\n{}\nit says\n{all}", page.join("\n")))
                }
            };
            let at = format!("{}:{}: $ {line}", short(path), block.line);
            faults.extend(fault.map(|fault| format!("{at}\n{fault}")));
        }
    }
    faults
}

/// Whether lines are those that a page has, where `...` stands for any lines.
fn agree(page: &[String], found: &[String]) -> bool {
    match page {
        [] => found.iter().all(|line| line.trim().is_empty()),
        [dots, rest @ ..] if dots.trim() == "..." => {
            (0..=found.len()).any(|skipped| agree(rest, &found[skipped..]))
        }
        [line, rest @ ..] => match found {
            [first, more @ ..] => line_agrees(line, first) && agree(rest, more),
            [] => page.iter().all(|line| line.trim().is_empty()),
        },
    }
}

/// Whether the words of two lines are the same, and numbers nearly.
fn line_agrees(page: &str, found: &str) -> bool {
    let even = |line: &str| -> String {
        let words = line.split_whitespace().filter(|word| !word.chars().all(|c| "-|:".contains(c)));
        words.collect::<Vec<_>>().join(" ")
    };
    let [page, found] = [page, found].map(even);
    let [page, found] = [pieces(&page), pieces(&found)];
    let number = |text: &str| text.parse::<f64>().ok();
    let alike = |(a, b): (&&str, &&str)| match (number(a), number(b)) {
        (Some(x), Some(y)) => (x - y).abs() <= TOLERANCE * x.abs().max(y.abs()),
        _ => a == b,
    };
    page.len() == found.len() && page.iter().zip(&found).all(alike)
}

#[test]
fn scenes_of_the_pages_are_read() {
    let mut wrong = Vec::new();
    for (path, text) in pages() {
        for block in blocks(&text).iter().filter(|block| block.language == "toml") {
            let scene = if block.text.contains("format = 1") {
                block.text.clone()
            } else {
                within_a_scene(&block.text)
            };
            let file = PathBuf::from(repository("data/scenes/page.toml"));
            if let Err(error) = SceneFile::parse(&file, &scene, &[]) {
                wrong.push(format!("{}:{}: {error}\n{}", short(&path), block.line, block.text));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n\n"));
}

/// What fragments of the pages may name.
const SCENE: &str = r#"
format = 1
[materials]
white = { lambert = { reflectance = 0.5 } }
walls = { lambert = { reflectance = 0.5 } }
floor = { lambert = { reflectance = 0.5 } }
dust = { lambert = { reflectance = 0.5 } }
silver = { mirror = { reflectance = 0.9 } }
[objects]
room = { box = { min = [0, 0, 0], max = [4, 5, 3], inward = true, material = "walls" } }
head = { sh = { file = "../head.obj", degree = 8, material = "white" } }
twin = { mesh = { file = "../head.obj", material = "white" } }
[lights]
lamp = { point = { at = [1, 1, 2], intensity = 100 } }
[sensors]
desk = { points = { at = [[1, 1, 1], [2, 1, 1]], normal = [0, 0, 1] } }
[cameras]
main = { perspective = { from = [2, 0.3, 1.5], to = [2, 3, 1], fov = 45, resolution = [64, 48] } }
"#;

/// Puts a part into a scene, in the place of what has its names.
fn within_a_scene(part: &str) -> String {
    let mut scene: Table = SCENE.parse().expect("a scene");
    let Ok(part) = part.parse::<Table>() else { return part.to_owned() };
    let desk = part.get("compare").and_then(|compare| compare.get("desk"));
    let values = desk.and_then(Value::as_array).map_or(2, Vec::len);
    for (kind, things) in part {
        match (scene.get_mut(&kind), things) {
            (Some(Value::Table(own)), Value::Table(things)) => own.extend(things),
            (_, things) => {
                scene.insert(kind, things);
            }
        }
    }
    let at = &mut scene["sensors"]["desk"];
    if let Some(Value::Array(points)) = at.get_mut("points").and_then(|p| p.get_mut("at")) {
        let one = points[0].clone();
        points.resize(values, one);
    }
    scene.to_string()
}

#[test]
fn every_page_is_in_the_book_and_every_link_leads_somewhere() {
    let contents = fs::read_to_string(repository("docs/SUMMARY.md")).expect("the book");
    let rust = fs::read_to_string(repository("src/lib.rs")).expect("the library");
    let mut wrong = Vec::new();
    for (path, text) in pages() {
        let name = short(&path);
        let folder = path.parent().expect("a folder");
        if let Some(page) = name.strip_prefix("docs/").filter(|page| *page != "SUMMARY.md")
            && !contents.contains(&format!("({page})"))
        {
            wrong.push(format!("{name}: not in docs/SUMMARY.md"));
        }
        if blocks(&text).iter().any(|b| b.language == "rust") && !rust.contains(&name) {
            wrong.push(format!("{name}: has Rust, and src/lib.rs does not test it"));
        }
        for target in links(&text) {
            let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let to = if file.is_empty() { path.clone() } else { folder.join(file) };
            let Ok(whole) = fs::canonicalize(&to) else {
                wrong.push(format!("{name}: no {target}"));
                continue;
            };
            if !anchor.is_empty() && !anchors(&whole).contains(anchor) {
                wrong.push(format!("{name}: no heading {target}"));
            }
        }
        let mut is_code = false;
        for (i, line) in text.lines().enumerate() {
            is_code ^= line.trim_start().starts_with("```");
            let is_free = is_code
                || line.starts_with("    ")
                || line.starts_with('|')
                || line.starts_with("![");
            if !is_free && line.chars().count() > 100 {
                wrong.push(format!("{name}:{}: more than 100 columns", i + 1));
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// Lists what a page links to in the repository.
fn links(text: &str) -> Vec<String> {
    let mut prose = String::new();
    let mut is_code = false;
    for line in text.lines() {
        is_code ^= line.trim_start().starts_with("```");
        if !is_code {
            prose.push_str(line);
            prose.push('\n');
        }
    }
    let ends = prose.match_indices("](").map(|(at, _)| &prose[at + 2..]);
    let targets = ends.filter_map(|rest| rest.split_once(')').map(|(target, _)| target));
    let here = targets.filter(|target| !target.contains("://") && !target.contains('`'));
    here.map(str::to_owned).collect()
}

/// Lists the anchors of a page's headings, as they are made on the web.
fn anchors(page: &Path) -> BTreeSet<String> {
    let text = fs::read_to_string(page).unwrap_or_default();
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let anchor = |line: &str| -> String {
        let title = line.trim_start_matches('#').trim().to_lowercase();
        let kept = title.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

#[test]
fn lines_agree_as_they_should() {
    assert!(line_agrees("| a | 1.000 |", "| a  | 1.001  |"));
    assert!(!line_agrees("| a | 1.000 |", "| a | 1.1 |"));
    assert!(!line_agrees("desk_1", "desk_2"));
    assert!(!line_agrees("done", "done now"));
    let [page, other, found] = ["a ... d", "a ... e", "a b c d"]
        .map(|t| t.split(' ').map(str::to_owned).collect::<Vec<_>>());
    assert!(agree(&page, &found) && !agree(&other, &found));
}
