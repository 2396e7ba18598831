//! Holds the sources to the rooms and arrows of docs/architecture.md: a room names only the rooms it may.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Room -> the rooms it may name; `error` is open to all.
const ARROWS: [(&str, &[&str]); 8] = [
    ("math", &[]),
    ("exact", &["math"]),
    ("sh", &["math"]),
    ("surface", &["sh", "math"]),
    ("scene", &["surface", "math"]),
    ("estimators", &["scene", "surface", "math"]),
    ("io", &["scene", "surface", "sh", "math"]),
    ("study", &["io", "estimators", "exact", "scene", "surface", "sh", "math"]),
];

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("the room is a folder");
    let paths = entries.map(|e| e.expect("readable").path());
    paths
        .flat_map(|p| if p.is_dir() { sources(&p) } else { vec![p] })
        .filter(|p| p.extension().is_some_and(|e| e == "rs"))
        .collect()
}

/// Drops comments, and the test module at the end of a file: tests may reach for a helper next door.
fn code(text: &str) -> String {
    let lines = text.lines().take_while(|l| !l.trim_start().starts_with("#[cfg(test)]"));
    lines.map(|l| l.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
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
            let names = named(&code(&fs::read_to_string(&file).expect("readable")));
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
    let text =
        "use crate::{Error, io::meshes::{a, b}, sh};\nuse crate::math::Ray;\n// crate::study\n";
    let names = named(&code(text));
    let expected = ["Error", "io", "math", "sh"].map(String::from);
    assert_eq!(names, BTreeSet::from(expected));
}
