//! The one error of the library, sorted by who must act: the author of a file, of a shape, the
//! caller, or the machine.

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
    /// Another error, and how to go on.
    #[error("{error}{}{advice}", advice.joint())]
    Advised {
        /// What went wrong.
        error: Box<Error>,
        /// What the caller may choose instead.
        advice: Advice,
    },
}

/// Says how to go on where that is a choice of the caller: a setting, or another function. Shown in
/// words of the library; a program says in its place which of its own switches to use, see
/// [`Error::told`].
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Advice {
    /// Writes over what stands in the output's place.
    Overwrite,
    /// Begins a run anew instead of resuming its checkpoint; or does first what is named.
    BeginAnew(Option<&'static str>),
    /// Keeps the largest piece of a mesh alone.
    KeepLargestPiece,
    /// Fits an envelope of a mesh with folds.
    FitEnvelope,
    /// Looks for no faces that cross.
    SkipCrossings,
    /// Accepts a larger share of directions in folds.
    AcceptFolds,
    /// Fits the mesh of a surface that is no radial shape.
    FitSurface,
    /// States the format of a coefficient file; its names.
    StateFormat(String),
    /// Reads a file as coefficient text.
    ReadAsText,
    /// States the convention of a coefficient file.
    StateConvention,
    /// States no convention.
    LeaveOutConvention,
    /// Adds the comment that a coefficient text lacks, or removes all of them and states the
    /// convention.
    CompleteComments {
        /// Its key.
        key: &'static str,
        /// What its value may look like.
        example: &'static str,
    },
    /// States no unit.
    LeaveOutUnit,
    /// Chooses a row of a table.
    ChooseRow,
    /// Chooses no row.
    LeaveOutRow,
    /// Follows the advice when the file is converted, and uses what that makes.
    Convert {
        /// What to say of the file.
        advice: Box<Advice>,
        /// The file.
        path: PathBuf,
    },
}

impl fmt::Display for Advice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Overwrite => write!(f, "choose another name, or have it replaced"),
            Self::BeginAnew(first) => write!(f, "{}begin anew", first.unwrap_or("")),
            Self::KeepLargestPiece => write!(f, "keep one piece alone (the repair can)"),
            Self::FitEnvelope => write!(f, "an envelope fits a mesh with small folds"),
            Self::SkipCrossings => {
                write!(f, "remove repeated faces (the repair can), or look for no crossings")
            }
            Self::AcceptFolds => {
                write!(f, "raise the accepted share, give another centre, or cut the mesh in parts")
            }
            Self::FitSurface => write!(
                f,
                "write its surface as a mesh (SPHARM-PDM makes a .vtk file of it) and fit that"
            ),
            Self::StateFormat(names) => write!(f, "say its format: {names}"),
            Self::ReadAsText => write!(f, "read a table without header as text"),
            Self::StateConvention => write!(
                f,
                "state normalisation and phase (pyshtools writes 4pi and 1 unless told otherwise)"
            ),
            Self::LeaveOutConvention => write!(f, "state no normalisation and phase"),
            Self::CompleteComments { key, example } => write!(
                f,
                "add a line as `# {key}: {example}`, or remove all comments and state \
                 normalisation and phase"
            ),
            Self::LeaveOutUnit => write!(f, "state no unit"),
            Self::ChooseRow => write!(f, "choose one, counted from 1"),
            Self::LeaveOutRow => write!(f, "choose no row"),
            Self::Convert { advice, .. } => {
                write!(f, "{advice}, when you convert it, and name the new file instead")
            }
        }
    }
}

impl Advice {
    /// Returns what stands between an error and the advice behind it.
    fn joint(&self) -> &'static str {
        match self {
            Self::Overwrite | Self::LeaveOutRow => ": ",
            _ => "; ",
        }
    }

    /// Whether it is about the convention of a coefficient file.
    pub fn is_of_convention(&self) -> bool {
        matches!(
            self,
            Self::StateConvention | Self::LeaveOutConvention | Self::CompleteComments { .. }
        )
    }
}

/// Describes where in a file an unusable thing stands, what was found and what would do instead.
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
    /// What the caller may choose instead; stands in the place of `help`.
    pub advice: Option<Box<Advice>>,
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, &Advice::to_string)
    }
}

impl std::error::Error for InputError {}

impl InputError {
    fn write(&self, f: &mut dyn fmt::Write, words: &dyn Fn(&Advice) -> String) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
            if let Some(column) = self.column {
                write!(f, ":{column}")?;
            }
        }
        write!(f, ": {}", self.message)?;
        match self.advice.as_deref().map(words).as_ref().or(self.help.as_ref()) {
            Some(help) => write!(f, "\n  help: {help}"),
            None => Ok(()),
        }
    }

    /// Starts an error about the whole file.
    pub fn new(path: &Path, message: impl Into<String>) -> Self {
        Self {
            path: path.to_owned(),
            line: None,
            column: None,
            message: message.into(),
            help: None,
            advice: None,
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

    /// Adds what the caller may choose instead.
    pub fn advise(mut self, advice: Advice) -> Self {
        self.advice = Some(Box::new(advice));
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

    /// Adds what the caller may choose instead.
    pub fn advise(self, advice: Advice) -> Self {
        Self::Advised { error: Box::new(self), advice }
    }

    /// Changes the error that any advice is about.
    pub fn map(self, change: impl FnOnce(Self) -> Self) -> Self {
        match self {
            Self::Advised { error, advice } => error.map(change).advise(advice),
            other => change(other),
        }
    }

    /// Returns the text of the error, each advice in the given words.
    pub fn told(&self, words: &dyn Fn(&Advice) -> String) -> String {
        match self {
            Self::Advised { error, advice } => {
                format!("{}{}{}", error.told(words), advice.joint(), words(advice))
            }
            Self::Input(error) => {
                let mut text = String::new();
                // Writing into a String cannot fail.
                let _ = error.write(&mut text, words);
                text
            }
            other => other.to_string(),
        }
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

    #[test]
    fn advice_is_told_in_either_words() {
        let words = |_: &Advice| "use `-f`".to_owned();
        let plain = Error::Parameter("it stands there".to_owned());
        let error = plain.advise(Advice::Overwrite).advise(Advice::FitEnvelope);
        assert_eq!(error.told(&words), "it stands there: use `-f`; use `-f`");
        assert!(error.to_string().starts_with("it stands there: choose another name"));
        let about = |e: Error| Error::Parameter(format!("a.txt: {e}"));
        assert_eq!(error.map(about).told(&words), "a.txt: it stands there: use `-f`; use `-f`");
        let error = InputError::new(Path::new("a"), "wrong").advise(Advice::LeaveOutUnit);
        assert_eq!(error.to_string(), "a: wrong\n  help: state no unit");
        assert_eq!(Error::from(error).told(&words), "a: wrong\n  help: use `-f`");
    }
}
