//! The tool `harmolux`: parses the command line, calls the library, prints. Data goes to stdout, talk to stderr.

mod arguments;
mod check;
mod convert;
mod convert_mesh;
mod detail_report;
mod diff;
mod exact;
mod exit;
mod falsecolor;
mod fit;
mod fit_many;
mod fit_report;
mod foresight;
mod illum;
mod illum_map;
mod illum_report;
mod illum_target;
mod info;
mod interrupt;
mod mean;
mod mesh;
mod plot;
mod probe;
mod progress;
mod random;
mod render;
mod render_keep;
mod render_target;
mod repairs;
mod say;
mod shape_file;
mod spectrum;
mod subject;
mod sweep;
mod target;
mod transform;

use std::process::ExitCode;

use clap::Parser;

use arguments::{Arguments, Verb};

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Some(threads) = arguments.threads {
        // Fails only when the pool exists already, and nothing has used it yet.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
    }
    let done = match &arguments.verb {
        Verb::Render(verb) => render::run(verb, arguments.json),
        Verb::Illum(verb) => illum::run(verb, arguments.json),
        Verb::Probe(verb) => probe::run(verb, arguments.json),
        Verb::Exact(verb) => exact::run(verb, arguments.json),
        Verb::Falsecolor(verb) => falsecolor::run(verb, arguments.json),
        Verb::Check(verb) => check::run(verb, arguments.json),
        Verb::Fit(verb) => fit::run(verb, arguments.json),
        Verb::Info(verb) => info::run(verb, arguments.json),
        Verb::Convert(verb) => convert::run(verb, arguments.json),
        Verb::Sweep(verb) => sweep::run(verb, arguments.json),
        Verb::Spectrum(verb) => spectrum::run(verb, arguments.json),
        Verb::Diff(verb) => diff::run(verb, arguments.json),
        Verb::Mesh(verb) => mesh::run(verb, arguments.json),
        Verb::Transform(verb) => transform::run(verb, arguments.json),
        Verb::Mean(verb) => mean::run(verb, arguments.json),
        Verb::Random(verb) => random::run(verb, arguments.json),
    };
    match done {
        Ok(code) => code.into(),
        Err(error) => {
            say::error(&error);
            exit::Code::of(&error).into()
        }
    }
}
