//! Turns what TOML and serde report into errors that name the key, its table, and what to write
//! instead.
//!
//! Where the fault lies follows from the span alone; the wording of serde is read only for what was
//! expected, and tests pin it.

use std::ops::Range;

use super::source::{Source, header};
use super::suggest::{example, suggest};
use crate::Error;

/// Explains text that is not TOML.
pub(super) fn syntax(error: &toml::de::Error, source: &Source) -> Error {
    let span = error.span().unwrap_or(0..0);
    let (message, help) = match error.message() {
        "duplicate key" => (
            format!("duplicate key `{}`", source.written(&span)),
            "it is written twice; keep one of the two",
        ),
        "string values must be quoted, expected literal string" => unquoted(source.written(&span)),
        other => (
            format!("not valid TOML: {other}"),
            "a scene is made of headers such as [lights.lamp.point] and lines such as `intensity \
             = 100`; words need quotes",
        ),
    };
    source.error_at(&span, message, Some(help.to_owned()))
}

/// Explains a word where a value belongs.
fn unquoted(word: &str) -> (String, &'static str) {
    if word.trim().is_empty() {
        return (
            "a value is missing behind `=`".to_owned(),
            "write a number, a word in quotes, or an array",
        );
    }
    (format!("not valid TOML: found `{word}`"), "words need quotes, numbers a point and no unit")
}

/// Explains a tree that is not a scene.
pub(super) fn structure(error: &toml::de::Error, source: &Source) -> Error {
    let span = error.span().unwrap_or(0..0);
    let fault = Fault::new(&span, source);
    let message = error.message();
    let (message, help) = if let Some(rest) = message.strip_prefix("unknown field") {
        fault.unknown_key(rest)
    } else if let Some(rest) = message.strip_prefix("unknown variant") {
        fault.unknown_word(rest)
    } else if let Some(rest) = message.strip_prefix("missing field") {
        fault.missing_key(rest)
    } else if let Some(rest) = message.strip_prefix("invalid type: ") {
        fault.wrong_type(rest, source.written(&span))
    } else {
        fault.as_told(message)
    };
    source.error_at(&span, message, help)
}

/// What is known about the place of a fault.
struct Fault<'a> {
    /// The path to the key or value that was refused, without numbers of array elements.
    path: &'a [String],
    /// Whether the key itself was refused.
    on_key: bool,
}

type Words = (String, Option<String>);

impl<'a> Fault<'a> {
    fn new(span: &Range<usize>, source: &'a Source) -> Self {
        let Some((path, place)) = source.find(span) else {
            return Self { path: &[], on_key: false };
        };
        Self { path: source.keyed(path), on_key: place.key.as_ref() == Some(span) }
    }

    /// Returns what the path is about: the kind it starts with, a line of sensors, or the table of
    /// details that its last key is in.
    fn kind(&self) -> &str {
        match self.path {
            [kind, table, _] if kind == "render" && table == "detail" => table,
            [_, _, _, table, _] if table == "detail" => table,
            [kind, _, r#type, _] if kind == "sensors" && r#type == "line" => r#type,
            [kind, ..] => kind,
            [] => "",
        }
    }

    /// Writes "`key` in [table]".
    fn subject(&self) -> String {
        match self.path {
            [] => "the scene".to_owned(),
            [key] => format!("`{key}`"),
            [table @ .., key] => format!("`{key}` in {}", header(table)),
        }
    }

    fn unknown_key(&self, rest: &str) -> Words {
        let key = self.path.last().map_or("", String::as_str);
        (
            format!("unknown key {}", self.subject()),
            Some(suggest(key, &after_expected(rest), "keys here")),
        )
    }

    fn unknown_word(&self, rest: &str) -> Words {
        if self.on_key {
            return self.unknown_key(rest);
        }
        let words = after_expected(rest);
        let found = backticked(rest).into_iter().next().unwrap_or_default();
        let message = format!("{} cannot be `{found}`", self.subject());
        (message, Some(suggest(found, &words, "words here")))
    }

    fn missing_key(&self, rest: &str) -> Words {
        let key = backticked(rest).into_iter().next().unwrap_or_default();
        let table =
            if self.path.is_empty() { String::new() } else { format!(" in {}", header(self.path)) };
        (
            format!("missing key `{key}`{table}"),
            example(self.kind(), key).map(|line| format!("add `{line}`")),
        )
    }

    fn wrong_type(&self, rest: &str, written: &str) -> Words {
        let (found, expected) = rest.rsplit_once(", expected ").unwrap_or((rest, "something else"));
        let expected = match expected {
            "a map" => "a table",
            "a boolean" => "true or false",
            other => other,
        };
        let found = match found {
            "map" => "a table".to_owned(),
            "sequence" => "an array".to_owned(),
            _ if written.trim().is_empty() || written.contains('\n') => found.to_owned(),
            _ => format!("{} {written}", kind_of(found)),
        };
        let is_quoted_number =
            expected.contains("number") && written.trim_matches(['"', '\'']).parse::<f64>().is_ok();
        let unquote = (is_quoted_number && found.starts_with("the string"))
            .then(|| "write it without quotes".to_owned());
        let help = unquote.or_else(|| self.pattern());
        (format!("{} must be {expected}, found {found}", self.subject()), help)
    }

    /// Shows what the refused key may look like.
    fn pattern(&self) -> Option<String> {
        let line = self.path.last().and_then(|key| example(self.kind(), key))?;
        Some(format!("write it like `{line}`"))
    }

    /// Completes a message of our own checks; what follows its line break is the help.
    fn as_told(&self, message: &str) -> Words {
        let (message, help) = match message.split_once('\n') {
            Some((message, help)) => (message, Some(help.to_owned())),
            None => (message, None),
        };
        (format!("{} {message}", self.subject()), help.or_else(|| self.pattern()))
    }
}

/// Names the kind of a scalar that serde describes.
fn kind_of(found: &str) -> &'static str {
    match found.split([' ', '`']).next() {
        Some("string") => "the string",
        Some("integer" | "floating") => "the number",
        Some("boolean") => "the word",
        _ => "the value",
    }
}

/// Reads the names in backticks behind ", expected"; none when there are no names to expect.
fn after_expected(rest: &str) -> Vec<&str> {
    rest.rsplit_once(", expected ").map(|(_, names)| backticked(names)).unwrap_or_default()
}

fn backticked(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}
