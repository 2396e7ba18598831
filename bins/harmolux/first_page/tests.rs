//! The groups and the page; and the reference of verbs, `docs/reference/verbs.md`, which is made of
//! their help. After a change: `HARMOLUX_BLESS=1 cargo test --bins verbs`.

use std::path::Path;

use clap::{Arg, CommandFactory};

use super::*;
use crate::Arguments;

const INTRODUCTION: &str = "\
# Verbs

<!-- Made of the help by `HARMOLUX_BLESS=1 cargo test --bins verbs`. -->

What `harmolux VERB --help` says. Data go to stdout (`--json` for machines: [keys](json.md)), talk
to stderr. Exit codes: 0 done, 1 failed, 2 wrong command line, 3 bad input, 4 requirement or target
error not met, 130 interrupted after saving.

Every verb also takes `-j N` (threads; results do not depend on it), `--max-memory BYTES` (such as
2G; what needs more is refused with what would fit) and `--json`.
";

#[test]
fn verbs_are_those_of_the_help() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference/verbs.md");
    let mut tool = Arguments::command().term_width(100);
    tool.build();
    let mut text = INTRODUCTION.to_owned();
    for (heading, names) in GROUPS {
        let _ = write!(text, "\n## {heading}\n");
        for verb in names.iter().filter(|name| **name != "help") {
            let verb = tool.find_subcommand(verb).expect("a verb");
            describe(&mut text, verb, verb.get_name());
        }
    }
    if std::env::var_os("HARMOLUX_BLESS").is_some() {
        std::fs::write(&path, &text).expect("written");
    }
    let stored = std::fs::read_to_string(&path).expect("docs/reference/verbs.md");
    assert!(stored == text, "stale: HARMOLUX_BLESS=1 cargo test --bins verbs");
}

/// Writes the help of a verb, and of the verbs in it.
fn describe(text: &mut String, verb: &Command, name: &str) {
    let own = |arg: Arg| if arg.is_global_set() { arg.hide(true) } else { arg };
    let help = verb.clone().mut_args(own).render_long_help().to_string();
    let lines = help.lines().map(str::trim_end).filter(|line| !is_global(line));
    let lines = lines.collect::<Vec<_>>().join("\n");
    let _ = write!(text, "\n### {name}\n\n```text\n{}\n```\n", lines.trim_end());
    for inner in verb.get_subcommands().filter(|inner| inner.get_name() != "help") {
        describe(text, inner, &format!("{name} {}", inner.get_name()));
    }
}

/// Whether a line is of every verb alike.
fn is_global(line: &str) -> bool {
    line.trim_start().starts_with("-h, --help") || line.trim_start().starts_with("-V, --version")
}

#[test]
fn every_verb_is_in_one_group() {
    let mut tool = Arguments::command();
    tool.build();
    let mut own: Vec<&str> = tool.get_subcommands().map(Command::get_name).collect();
    let mut listed: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| *names).copied().collect();
    own.sort_unstable();
    listed.sort_unstable();
    assert_eq!(listed, own);
}

#[test]
fn lines_fit_a_terminal() {
    let help = grouped(Arguments::command()).render_help().to_string();
    let lines = TEXT.lines().chain(help.lines());
    assert_eq!(lines.filter(|line| line.chars().count() > 100).collect::<Vec<_>>(), [""; 0]);
}
