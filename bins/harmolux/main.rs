//! The tool `harmolux`: parses the command line, calls the library, prints. Data goes to stdout, talk to stderr.

mod arguments;
mod check;
mod convert;
mod convert_mesh;
mod exit;
mod fit;
mod illum;
mod info;
mod interrupt;
mod progress;
mod render;
mod repairs;
mod say;
mod sweep;

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
        Verb::Check(verb) => check::run(verb, arguments.json),
        Verb::Fit(verb) => fit::run(verb, arguments.json),
        Verb::Info(verb) => info::run(verb, arguments.json),
        Verb::Convert(verb) => convert::run(verb, arguments.json),
        Verb::Sweep(verb) => sweep::run(verb, arguments.json),
    };
    match done {
        Ok(code) => code.into(),
        Err(error) => {
            say::error(&error);
            exit::Code::of(&error).into()
        }
    }
}
