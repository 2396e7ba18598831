//! The one error of the library, sorted by who must act: the author of a file, of a shape, the caller, or the machine.

use std::fmt;
use std::path::{Path, PathBuf};

/// Abbreviates results whose error is the library's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Says what went wrong, where, and how to go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file says something that cannot be used; its author must mend it.
    #[error(transparent)]
    Input(Box<InputError>),
    /// A shape lacks a property the operation needs (closed, star-shaped, not degenerate).
    #[error("{0}")]
    Geometry(String),
    /// A number or name given by the caller is outside its valid range.
    #[error("{0}")]
    Parameter(String),
    /// A computation did not reach what it promises.
    #[error("{0}")]
    Numeric(String),
    /// The operating system refused to read or write.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file or folder concerned.
        path: PathBuf,
        /// What was attempted: "read", "write", "create".
        action: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
}

/// Tells where in a file an unusable thing stands, what was found and what would do instead.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputError {
    /// The file.
    pub path: PathBuf,
    /// The line, counted from 1; `None` when the whole file is meant.
    pub line: Option<usize>,
    /// The column in characters, counted from 1.
    pub column: Option<usize>,
    /// What was found and why it cannot be used.
    pub message: String,
    /// What to write or do instead, when that is known.
    pub help: Option<String>,
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
            if let Some(column) = self.column {
                write!(f, ":{column}")?;
            }
        }
        write!(f, ": {}", self.message)?;
        match &self.help {
            Some(help) => write!(f, "\n  help: {help}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for InputError {}

impl InputError {
    /// Starts an error about the whole file.
    pub fn new(path: &Path, message: impl Into<String>) -> Self {
        Self {
            path: path.to_owned(),
            line: None,
            column: None,
            message: message.into(),
            help: None,
        }
    }

    /// Adds the line and, when known, the column (both from 1).
    pub fn at(mut self, line: usize, column: Option<usize>) -> Self {
        self.line = Some(line);
        self.column = column;
        self
    }

    /// Adds what to write or do instead.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl From<InputError> for Error {
    fn from(error: InputError) -> Self {
        Self::Input(Box::new(error))
    }
}

impl Error {
    /// Wraps what the operating system said when `action` ("read", "write") was tried on `path`.
    pub fn io(path: &Path, action: &'static str, source: std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), action, source }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn input_error_shows_place_and_help() {
        let error = InputError::new(Path::new("room.toml"), "unknown key `reflectence`")
            .at(12, Some(8))
            .help("write `reflectance`");
        assert_eq!(
            error.to_string(),
            "room.toml:12:8: unknown key `reflectence`\n  help: write `reflectance`"
        );
    }
}
