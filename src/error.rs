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
    #[error("{}", presented(.0))]
    Geometry(String),
    /// A number or name given by the caller is outside its valid range.
    #[error("{}", presented(.0))]
    Parameter(String),
    /// A computation did not reach what it promises.
    #[error("{}", presented(.0))]
    Numeric(String),
    /// Something needs more memory than is free; says what would fit.
    #[error("{}", presented(.0))]
    Memory(String),
    /// The operating system refused to read or write.
    #[error("{}: cannot {action}: {}", shown_path(path), presented(&source.to_string()))]
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
    /// Repairs a mesh; fills its holes too, whose rims have so many edges at most.
    Repair(Option<usize>),
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
    /// Fits the mesh that stands where coefficients are wanted.
    FitMesh,
    /// Adds the reference radius to heights above it.
    AddRadius,
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
            Self::Repair(None) => write!(f, "repair it"),
            Self::Repair(Some(edges)) => {
                write!(f, "repair it, and fill holes of up to {edges} edges")
            }
            Self::KeepLargestPiece => write!(f, "keep one piece alone (the repair can)"),
            Self::FitEnvelope => write!(f, "an envelope fits a mesh with small folds"),
            Self::SkipCrossings => {
                write!(f, "remove repeated faces (the repair can), or look for no crossings")
            }
            Self::AcceptFolds => {
                write!(f, "raise the accepted share, give another centre, or cut the mesh in parts")
            }
            Self::FitSurface => write!(f, "make a mesh of its surface, and fit that"),
            Self::FitMesh => write!(f, "fit it, and take the coefficients"),
            Self::AddRadius => write!(f, "if these are heights, add their reference radius"),
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
        write!(f, "{}", shown_path(&self.path))?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
            if let Some(column) = self.column {
                write!(f, ":{column}")?;
            }
        }
        write!(f, ": {}", sentence(&self.message))?;
        match (&self.advice, &self.help) {
            (Some(advice), _) => write!(f, "{HELP}{}", presented(&words(advice))),
            (None, Some(help)) => write!(f, "{HELP}{}", sentence(help)),
            (None, None) => Ok(()),
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

/// The most characters that are shown of what is quoted.
const MOST_SHOWN: usize = 200;

/// The most characters between two quotes.
const MOST_OF_WORDS: usize = 1000;

/// The most characters that are shown of a path, which takes no more on any system.
const MOST_OF_PATH: usize = 4096;

/// What stands between what went wrong and how to go on.
const HELP: &str = "\n  help: ";

/// Shows a word or name from outside, as that of an object: on one line, without what a terminal
/// would obey, at most 200 characters.
///
/// ```
/// assert_eq!(harmolux::error::shown("head\n\x1b[2J"), r"head\n\u{1b}[2J");
/// assert!(harmolux::error::shown(&"long ".repeat(100)).ends_with("lo..."));
/// ```
pub fn shown(text: &str) -> String {
    escaped(text, MOST_SHOWN)
}

/// Shows bytes from outside as [`shown`] does, those that are no text as U+FFFD.
pub fn shown_bytes(bytes: &[u8]) -> String {
    // As many as the characters that are shown, and one more, can take.
    shown(&String::from_utf8_lossy(&bytes[..bytes.len().min(4 * (MOST_SHOWN + 1))]))
}

/// Shows a path as [`shown`] does, but whole.
pub fn shown_path(path: &Path) -> String {
    escaped(&path.to_string_lossy(), MOST_OF_PATH)
}

/// Shows a sentence on one line, without what a terminal would obey. Help that follows it stays on
/// a line of its own.
pub fn presented(text: &str) -> String {
    let parts: Vec<String> = text.split(HELP).map(|part| escaped(part, usize::MAX)).collect();
    parts.join(HELP)
}

/// Shows a sentence as [`presented`] does, and what is quoted in it, `` `so` ``, as [`shown`] does.
pub fn abridged(text: &str) -> String {
    text.split(HELP).map(sentence).collect::<Vec<_>>().join(HELP)
}

fn sentence(text: &str) -> String {
    // What is quoted are the odd parts; between them stand our own words, and lists.
    let part = |(i, part): (usize, &str)| {
        escaped(part, if i % 2 == 1 { MOST_SHOWN } else { MOST_OF_WORDS })
    };
    text.split('`').enumerate().map(part).collect::<Vec<_>>().join("`")
}

/// Escapes what is obeyed, not shown: control characters, and those that turn the direction of what
/// follows. Of a text that takes more than `most` characters the beginning is left.
fn escaped(text: &str, most: usize) -> String {
    let mut shown = String::new();
    // How much of it leaves room for the dots.
    let (mut count, mut kept) = (0, 0);
    for c in text.chars() {
        count += push(c, &mut shown);
        if count > most {
            shown.truncate(kept);
            shown.push_str("...");
            break;
        }
        if count + 3 <= most {
            kept = shown.len();
        }
    }
    shown
}

/// Adds a character, escaped where it is obeyed, and gives how many it takes.
fn push(c: char, shown: &mut String) -> usize {
    let before = shown.len();
    match c {
        '\n' => shown.push_str("\\n"),
        '\r' => shown.push_str("\\r"),
        '\t' => shown.push_str("\\t"),
        _ if is_obeyed(c) => shown.extend(c.escape_unicode()),
        _ => {
            shown.push(c);
            return 1;
        }
    }
    shown.len() - before
}

fn is_obeyed(c: char) -> bool {
    let turns = ['\u{61c}', '\u{200e}', '\u{200f}', '\u{2028}', '\u{2029}'];
    let embeds = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || embeds || turns.contains(&c)
}

/// Shows a text of several lines without what a terminal would obey but their ends and tabs.
pub fn shown_lines(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' | '\t' => shown.push(c),
            _ => {
                push(c, &mut shown);
            }
        }
    }
    shown
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
    fn what_is_quoted_is_escaped_and_short() {
        assert_eq!(shown(""), "");
        assert_eq!(shown("Kopf \u{1f600} t\u{ea}te"), "Kopf \u{1f600} t\u{ea}te");
        assert_eq!(
            shown("a\r\n\t\x1b]0;x\x07\u{9b}\u{202e}b\x7f"),
            r"a\r\n\t\u{1b}]0;x\u{7}\u{9b}\u{202e}b\u{7f}"
        );
        for (length, end) in [(199, "xx"), (200, "xx"), (201, "x..."), (10_000_000, "x...")] {
            let text = shown(&"x".repeat(length));
            assert!(text.chars().count() == length.min(200) && text.ends_with(end), "{text}");
            assert_eq!(shown(&text), text);
            assert_eq!(shown_bytes("x".repeat(length).as_bytes()), text);
            let bells = shown(&"\x07".repeat(length));
            assert!(bells.ends_with(r"\u{7}...") && bells.len() <= 200, "{bells}");
        }
        assert_eq!(shown_bytes(&"\u{1f600}".repeat(300).into_bytes()).chars().count(), 200);
        assert_eq!(shown_bytes(b"\xffa"), "\u{fffd}a");
        assert_eq!(shown_lines("a\tb\n\x1bc\r\n"), "a\tb\n\\u{1b}c\\r\n");
    }

    #[test]
    fn errors_never_steer_a_terminal() {
        let evil = format!("\x1b[2J\n{}", "y".repeat(300));
        let path = Path::new("a\x1bb.obj");
        let input =
            InputError::new(path, format!("no `{evil}` here")).help(format!("not `{evil}`"));
        let geometry = Error::Geometry(format!("{evil}\n  help: write `z`"));
        assert!(geometry.to_string().ends_with("y\n  help: write `z`"), "{geometry}");
        let read = Error::io(path, "read", std::io::Error::other(evil.clone()));
        let memory = Error::Memory(evil.clone());
        for error in [input.into(), geometry, memory, read.advise(Advice::Overwrite)] {
            for text in [error.to_string(), error.told(&|_| "`-f`".to_owned())] {
                let lines: Vec<&str> = text.lines().collect();
                assert!(!text.contains('\x1b') && text.contains("\\u{1b}"), "{text}");
                assert!(lines.len() == 1 || lines[1].starts_with("  help: "), "{text}");
            }
        }
        let error = InputError::new(path, format!("no `{evil}` here")).to_string();
        assert!(error.contains(r"a\u{1b}b.obj: no `\u{1b}[2J\n") && error.contains("...` here"));
        assert!(error.chars().count() < 260, "{error}");
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
