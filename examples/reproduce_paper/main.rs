//! Runs the claims of the paper behind this program (Budak, Zheltov, Kalakutsky 2012) through the
//! library and writes one page: `DIR/paper.md`, `DIR/paper.html` and the figures.
//!
//!     cargo run --release --example reproduce_paper -- -o DIR [--full] [--only GROUP]
//!
//! Quick by default, about two minutes on two cores; `--full` takes more walks, rounds and pixels,
//! a quarter of an hour. `--only` runs one group of claims. What is random has a fixed seed.
//! Verdicts follow from the numbers by the rules of `claims::Verdict`. Times are those of one
//! thread, in turns, so that what else the machine does befalls both sides.

mod claims;
mod figures;
mod html;
mod machine;
mod markdown;
mod page;
mod timing;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use harmolux::{Error, Result};

use claims::{GROUPS, Run};
use page::Page;

const USAGE: &str = "usage: reproduce_paper -o DIR [--full] [--only GROUP]";

/// Holds what the command line asks for.
struct Arguments {
    folder: PathBuf,
    full: bool,
    only: Option<String>,
}

fn main() -> ExitCode {
    match arguments(std::env::args().skip(1)) {
        Err(message) => {
            let groups = GROUPS.map(|(name, _)| name).join(", ");
            eprintln!("{message}\n{USAGE}\ngroups: {groups}");
            ExitCode::from(2)
        }
        Ok(arguments) => match run(&arguments) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("error: {error}");
                ExitCode::FAILURE
            }
        },
    }
}

fn arguments(mut words: impl Iterator<Item = String>) -> std::result::Result<Arguments, String> {
    let (mut folder, mut full, mut only) = (None, false, None);
    while let Some(word) = words.next() {
        match word.as_str() {
            "-o" => folder = words.next().map(PathBuf::from),
            "--full" => full = true,
            "--only" => only = words.next(),
            other => return Err(format!("unknown argument `{other}`")),
        }
    }
    let folder = folder.ok_or("where to? -o DIR is missing")?;
    match &only {
        Some(name) if !GROUPS.iter().any(|(group, _)| group == name) => {
            Err(format!("unknown group `{name}`"))
        }
        _ => Ok(Arguments { folder, full, only }),
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let started = Instant::now();
    let run = Run::new(arguments.full)?;
    let mut claims = Vec::new();
    for (name, group) in GROUPS {
        if arguments.only.as_ref().is_some_and(|only| only != name) {
            continue;
        }
        let begun = Instant::now();
        let found = group(&run)?;
        for claim in &found {
            println!("{:28} {}", claim.verdict.name(), claim.title);
        }
        eprintln!("{name}: {:.1} s", begun.elapsed().as_secs_f64());
        claims.extend(found);
    }
    let (full, only) = (arguments.full, arguments.only.clone());
    let page = Page { claims, full, only, took: started.elapsed() };
    page.write(&arguments.folder)
        .map_err(|error| Error::Parameter(format!("{}: {error}", arguments.folder.display())))
}
