//! What the exit code says; 2, for a wrong command line, is clap's own.

use std::io::ErrorKind;
use std::process::ExitCode;

use harmolux::Error;

/// Says how the run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Code {
    /// All done.
    Done = 0,
    /// A computation failed, or had no memory.
    Failed = 1,
    /// A file or shape cannot be used, or an output cannot be written.
    BadInput = 3,
    /// A target error was not met.
    NotMet = 4,
    /// Interrupted; what there was is saved.
    Interrupted = 130,
}

impl Code {
    /// Sorts an error by who must act.
    pub(crate) fn of(error: &Error) -> Self {
        match error {
            Error::Numeric(_) | Error::Memory(_) => Self::Failed,
            Error::Io { source, .. } if source.kind() == ErrorKind::OutOfMemory => Self::Failed,
            Error::Advised { error, .. } => Self::of(error),
            _ => Self::BadInput,
        }
    }
}

impl From<Code> for ExitCode {
    fn from(code: Code) -> Self {
        Self::from(code as u8)
    }
}
