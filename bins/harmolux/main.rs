//! The tool `harmolux`: parses the command line, calls the library, prints. Data goes to stdout,
//! talk to stderr. The verbs are described each in a file or folder of its own; what they share is
//! in `common`.

mod check;
mod common;
mod compare;
mod completions;
mod convert;
mod diff;
mod evaluate;
mod exact;
mod falsecolor;
mod first_page;
mod fit;
mod illum;
mod info;
mod man;
mod mean;
mod mesh;
mod modes;
mod new;
mod probe;
mod random;
mod render;
mod spectrum;
mod sweep;
mod transform;
mod view;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use common::{exit, interrupt, resources, say};

/// Spherical-harmonic shapes, and light in rooms by Monte Carlo local estimates.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, subcommand_required = true, after_help = EXIT_CODES)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) verb: Verb,
    /// Use this many threads instead of one per core; results do not depend on it
    #[arg(
        short = 'j', long, global = true, display_order = 900, value_name = "N",
        value_parser = clap::value_parser!(u16).range(1..=1024)
    )]
    pub(crate) threads: Option<u16>,
    /// Take at most this much memory, such as 500M or 2G; what needs more is refused with what
    /// would fit [default: what is free]
    #[arg(
        long, global = true, display_order = 900, value_name = "BYTES",
        value_parser = resources::bytes
    )]
    pub(crate) max_memory: Option<u64>,
    /// Print the result as JSON on stdout
    #[arg(long, global = true, display_order = 901)]
    pub(crate) json: bool,
}

const EXIT_CODES: &str = "\
Exit codes: 0 done, 1 failed, 2 wrong command line, 3 bad input, 4 requirement or target error not \
met, 130 interrupted (after saving).";

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    Check(check::Check),
    Fit(fit::Fit),
    Info(info::Info),
    Mesh(mesh::Mesh),
    Diff(diff::Diff),
    Spectrum(spectrum::Spectrum),
    Evaluate(evaluate::Evaluate),
    Transform(Box<transform::Transform>),
    Mean(mean::Mean),
    Modes(modes::Modes),
    Random(random::Random),
    Sweep(Box<sweep::Sweep>),
    View(view::View),
    New(new::New),
    Render(render::Render),
    Illum(illum::Illum),
    Probe(probe::Probe),
    Exact(exact::Exact),
    Falsecolor(falsecolor::Falsecolor),
    Compare(compare::Compare),
    Convert(convert::Convert),
    Completions(completions::Completions),
    Man(man::Man),
}

fn main() -> ExitCode {
    resources::fail_when_memory_is_out();
    if std::env::args_os().len() == 1 {
        say::raw(first_page::TEXT);
        return ExitCode::SUCCESS;
    }
    let matches = first_page::grouped(Arguments::command()).get_matches();
    let arguments = match Arguments::from_arg_matches(&matches) {
        Ok(arguments) => arguments,
        Err(error) => error.exit(),
    };
    if let Some(bytes) = arguments.max_memory {
        resources::limit_memory(bytes);
    }
    if let Err(error) = resources::start_threads(arguments.threads) {
        say::note(&format!("error: {error}"));
        return exit::Code::Failed.into();
    }
    interrupt::listen();
    let done = match &arguments.verb {
        Verb::Check(verb) => check::run(verb, arguments.json),
        Verb::Fit(verb) => fit::run(verb, arguments.json),
        Verb::Info(verb) => info::run(verb, arguments.json),
        Verb::Mesh(verb) => mesh::run(verb, arguments.json),
        Verb::Diff(verb) => diff::run(verb, arguments.json),
        Verb::Spectrum(verb) => spectrum::run(verb, arguments.json),
        Verb::Evaluate(verb) => evaluate::run(verb, arguments.json),
        Verb::Transform(verb) => transform::run(verb, arguments.json),
        Verb::Mean(verb) => mean::run(verb, arguments.json),
        Verb::Modes(verb) => modes::run(verb, arguments.json),
        Verb::Random(verb) => random::run(verb, arguments.json),
        Verb::Sweep(verb) => sweep::run(verb, arguments.json),
        Verb::View(verb) => view::run(verb, arguments.json),
        Verb::New(verb) => new::run(verb, arguments.json),
        Verb::Render(verb) => render::run(verb, arguments.json),
        Verb::Illum(verb) => illum::run(verb, arguments.json),
        Verb::Probe(verb) => probe::run(verb, arguments.json),
        Verb::Exact(verb) => exact::run(verb, arguments.json),
        Verb::Falsecolor(verb) => falsecolor::run(verb, arguments.json),
        Verb::Compare(verb) => compare::run(verb, arguments.json),
        Verb::Convert(verb) => convert::run(verb, arguments.json),
        Verb::Completions(verb) => Ok(completions::run(verb)),
        Verb::Man(verb) => man::run(verb, arguments.json),
    };
    match done {
        Ok(code) => code.into(),
        Err(error) => {
            say::error(&error);
            exit::Code::of(&error).into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn command_line_is_consistent() {
        Arguments::command().debug_assert();
    }
}
