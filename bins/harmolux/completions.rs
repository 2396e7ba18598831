//! `harmolux completions`: what a shell completes.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use crate::Arguments;
use crate::common::exit::Code;
use crate::common::say;

/// Print what lets a shell complete verbs, flags and files
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux completions bash > ~/.local/share/bash-completion/completions/harmolux
  harmolux completions zsh > ~/.zfunc/_harmolux
  harmolux completions fish > ~/.config/fish/completions/harmolux.fish")]
pub(crate) struct Completions {
    /// The shell
    pub(crate) shell: Shell,
}

/// Runs the verb.
pub(crate) fn run(verb: &Completions) -> Code {
    let mut script = Vec::new();
    clap_complete::generate(verb.shell, &mut Arguments::command(), "harmolux", &mut script);
    say::raw(String::from_utf8_lossy(&script).trim_end());
    Code::Done
}
