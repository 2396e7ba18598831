//! The tool `harmolux`: parses the command line, calls the library, prints. Data goes to stdout,
//! talk to stderr. The verbs are described each in a file or folder of its own; what they share is
//! in `common`.

mod check;
mod common;
mod compare;
mod convert;
mod diff;
mod evaluate;
mod exact;
mod falsecolor;
mod fit;
mod illum;
mod info;
mod mean;
mod mesh;
mod modes;
mod probe;
mod random;
mod render;
mod spectrum;
mod sweep;
mod transform;
mod view;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use common::{exit, interrupt, resources, say};

/// Spherical-harmonic shapes, and light in rooms by Monte Carlo local estimates.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, arg_required_else_help = true, after_help = EXAMPLES)]
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

const EXAMPLES: &str = "\
Examples:
  harmolux render data/scenes/head_room.toml             a picture: head_room.png and head_room.exr
  harmolux illum data/scenes/head_room.toml              lux at the scene's sensors, each with its \
                                                         interval
  harmolux probe data/scenes/head_room.toml < rays.txt   cd/m2 along rays, a line each
  harmolux exact sobolev                                 light whose answer is known: two planes
  harmolux falsecolor head_room.exr -o cd.png            cd/m2 in colours, with a legend; lux of \
                                                         grids
  harmolux compare new.exr old.exr                       how far two pictures differ: relMSE, FLIP
  harmolux check data/head.obj                           closed, oriented, star-shaped?
  harmolux fit data/head.obj -l 32 -o head.txt           a mesh becomes 1089 coefficients
  harmolux info head.txt                                 what a file holds
  harmolux convert head.txt head.bshc                    coefficients in another format
  harmolux sweep data/head.obj -l 4,8,16,32,64 -o out    what each degree costs and buys
  harmolux view head.txt -o head.html                    a page that shows it at every degree
  harmolux spectrum head.txt --plot                      how much each degree carries
  harmolux mesh head.txt -o head.ply                     coefficients become a mesh
  harmolux evaluate head.txt --at 45,-120                radius and normal in a direction
  harmolux diff head.txt data/head.obj                   how far two shapes are from each other

Exit codes: 0 done, 1 failed, 2 wrong command line, 3 bad input, 4 requirement or target error not \
met, 130 interrupted (after saving).";

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    Render(render::Render),
    Illum(illum::Illum),
    Probe(probe::Probe),
    Exact(exact::Exact),
    Falsecolor(falsecolor::Falsecolor),
    Compare(compare::Compare),
    Check(check::Check),
    Fit(fit::Fit),
    Info(info::Info),
    Convert(convert::Convert),
    Sweep(Box<sweep::Sweep>),
    Spectrum(spectrum::Spectrum),
    Diff(diff::Diff),
    Mesh(mesh::Mesh),
    Evaluate(evaluate::Evaluate),
    Transform(Box<transform::Transform>),
    Mean(mean::Mean),
    Modes(modes::Modes),
    Random(random::Random),
    View(view::View),
}

fn main() -> ExitCode {
    resources::fail_when_memory_is_out();
    let arguments = Arguments::parse();
    if let Some(bytes) = arguments.max_memory {
        resources::limit_memory(bytes);
    }
    if let Err(error) = resources::start_threads(arguments.threads) {
        say::note(&format!("error: {error}"));
        return exit::Code::Failed.into();
    }
    interrupt::listen();
    let done = match &arguments.verb {
        Verb::Render(verb) => render::run(verb, arguments.json),
        Verb::Illum(verb) => illum::run(verb, arguments.json),
        Verb::Probe(verb) => probe::run(verb, arguments.json),
        Verb::Exact(verb) => exact::run(verb, arguments.json),
        Verb::Falsecolor(verb) => falsecolor::run(verb, arguments.json),
        Verb::Compare(verb) => compare::run(verb, arguments.json),
        Verb::Check(verb) => check::run(verb, arguments.json),
        Verb::Fit(verb) => fit::run(verb, arguments.json),
        Verb::Info(verb) => info::run(verb, arguments.json),
        Verb::Convert(verb) => convert::run(verb, arguments.json),
        Verb::Sweep(verb) => sweep::run(verb, arguments.json),
        Verb::Spectrum(verb) => spectrum::run(verb, arguments.json),
        Verb::Diff(verb) => diff::run(verb, arguments.json),
        Verb::Mesh(verb) => mesh::run(verb, arguments.json),
        Verb::Evaluate(verb) => evaluate::run(verb, arguments.json),
        Verb::Transform(verb) => transform::run(verb, arguments.json),
        Verb::Mean(verb) => mean::run(verb, arguments.json),
        Verb::Modes(verb) => modes::run(verb, arguments.json),
        Verb::Random(verb) => random::run(verb, arguments.json),
        Verb::View(verb) => view::run(verb, arguments.json),
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
    use clap::CommandFactory;

    #[test]
    fn command_line_is_consistent() {
        Arguments::command().debug_assert();
    }
}
