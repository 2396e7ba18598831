//! Holds the sources to the rooms and arrows of docs/how/architecture.md: a room names only the rooms
//! it may.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Room -> the rooms it may name; `error` and `memory` are open to all.
const ARROWS: [(&str, &[&str]); 11] = [
    ("math", &[]),
    ("exact", &["math"]),
    ("sh", &["math"]),
    ("mesh", &["math"]),
    ("surface", &["mesh", "sh", "math"]),
    ("fit", &["surface", "mesh", "sh", "math"]),
    ("scene", &["surface", "math"]),
    ("estimators", &["scene", "surface", "math"]),
    ("plots", &["io", "scene", "mesh", "sh", "math"]),
    ("io", &["scene", "fit", "surface", "mesh", "sh", "math"]),
    (
        "study",
        &["io", "plots", "estimators", "exact", "scene", "fit", "surface", "mesh", "sh", "math"],
    ),
];

/// Lists the source files below a folder but those of tests.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("the room is a folder");
    let paths = entries.map(|e| e.expect("readable").path());
    paths
        .filter(|p| p.file_stem().is_some_and(|name| name != "tests"))
        .flat_map(|p| if p.is_dir() { sources(&p) } else { vec![p] })
        .filter(|p| p.extension().is_some_and(|e| e == "rs"))
        .collect()
}

/// Drops comments and whatever is marked `#[cfg(test)]`: tests may reach for a helper next door.
fn code(text: &str) -> String {
    let lines = text.lines().map(|l| l.split("//").next().unwrap_or(""));
    let text = lines.collect::<Vec<_>>().join("\n");
    let mut parts = text.split("#[cfg(test)]");
    let first = parts.next().unwrap_or("").to_owned();
    parts.fold(first, |kept, part| kept + &part[item_end(part)..])
}

/// Finds where an item ends: at its first semicolon outside braces, or at its closing brace.
fn item_end(text: &str) -> usize {
    let mut depth = 0;
    for (i, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 1 => return i + 1,
            '}' => depth -= 1,
            ';' if depth == 0 => return i + 1,
            _ => {}
        }
    }
    text.len()
}

/// Lists the names of the crate's root that a file of this module path reaches by `super` chains.
fn named_by_super(code: &str, depth: usize) -> BTreeSet<String> {
    let chain = "super::".repeat(depth);
    let ends = code.match_indices(&chain).filter(|(at, _)| !code[..*at].ends_with("super::"));
    let rest = ends.map(|(at, _)| &code[at + chain.len()..]);
    rest.filter(|r| !r.starts_with("super::"))
        .flat_map(|r| match r.strip_prefix('{') {
            Some(group) => group_heads(group),
            None => vec![identifier(r)],
        })
        .collect()
}

/// Returns how many modules deep a file stands below the root of the crate.
fn depth(src: &Path, file: &Path) -> usize {
    let inner = file.strip_prefix(src).expect("in src");
    inner.components().count() - usize::from(file.ends_with("mod.rs"))
}

/// Lists the first path segments named after `crate::` or `harmolux::`, braces opened.
fn named(code: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for prefix in ["crate::", "harmolux::"] {
        for (at, _) in code.match_indices(prefix) {
            let rest = &code[at + prefix.len()..];
            match rest.strip_prefix('{') {
                Some(group) => names.extend(group_heads(group)),
                None => names.extend([identifier(rest)]),
            }
        }
    }
    names
}

/// Lists the heads of a brace group: what follows its opening brace and each comma at depth 1.
fn group_heads(group: &str) -> Vec<String> {
    let (mut depth, mut heads, mut start) = (1, vec![identifier(group.trim_start())], false);
    for (i, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 1 => start = true,
            c if start && !c.is_whitespace() => {
                heads.push(identifier(&group[i..]));
                start = false;
            }
            _ => {}
        }
        if depth == 0 {
            break;
        }
    }
    heads
}

fn identifier(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

#[test]
fn rooms_name_only_the_rooms_they_may() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut wrong = Vec::new();
    for (room, allowed) in ARROWS {
        for file in sources(&src.join(room)) {
            let code = code(&fs::read_to_string(&file).expect("readable"));
            let mut names = named(&code);
            names.extend(named_by_super(&code, depth(&src, &file)));
            let rooms = names.iter().filter(|n| ARROWS.iter().any(|(r, _)| r == n));
            wrong.extend(
                rooms
                    .filter(|n| *n != room && !allowed.contains(&n.as_str()))
                    .map(|n| format!("{} names {n}", file.display())),
            );
        }
    }
    assert!(wrong.is_empty(), "forbidden arrows:\n{}", wrong.join("\n"));
}

/// Who opens files, but for `io::input`: who writes them, who reads its own again, and who asks the
/// system about the process.
const OPEN_THEIR_OWN: [&str; 5] = [
    "src/io/output",
    "src/io/checkpoint",
    "src/io/failing.rs",
    "src/memory.rs",
    "bins/harmolux/common/interrupt.rs",
];

#[test]
fn inputs_are_opened_in_one_place() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let opens = |file: &Path| {
        let code = code(&fs::read_to_string(file).expect("readable"));
        ["fs::read(", "fs::read_to_string(", "File::open("].iter().any(|call| code.contains(call))
    };
    let files = ["src", "bins"].map(|folder| sources(&root.join(folder))).concat();
    let opening = files.iter().filter(|file| opens(file));
    let opening = opening.map(|file| file.strip_prefix(root).expect("in the repository"));
    let strangers = opening.filter(|file| !OPEN_THEIR_OWN.iter().any(|own| file.starts_with(own)));
    assert_eq!(strangers.collect::<Vec<_>>(), [Path::new("src/io/input.rs")]);
}

#[test]
fn every_folder_of_src_is_a_room() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for entry in fs::read_dir(src).expect("src exists") {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            let name = path.file_name().and_then(|n| n.to_str()).expect("plain name");
            assert!(ARROWS.iter().any(|(room, _)| *room == name), "{name} is no room of the house");
        }
    }
}

#[test]
fn the_reader_of_arrows_sees_them() {
    let text = "use crate::{Error, io::meshes::{a, b}, sh};\nuse crate::math::Ray;\n\
                // crate::study\n#[cfg(test)]\nmod tests { use crate::exact; fn f() {} }\n\
                use super::super::fit;\n#[cfg(test)]\nuse crate::exact;\n\
                use super::super::{mesh::Mesh, plots};\nuse super::own;";
    let code = code(text);
    let expected = ["Error", "io", "math", "sh"].map(String::from);
    assert_eq!(named(&code), BTreeSet::from(expected));
    let expected = ["fit", "mesh", "plots"].map(String::from);
    assert_eq!(named_by_super(&code, 2), BTreeSet::from(expected));
}
