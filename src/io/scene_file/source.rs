//! The text a scene was read from and where each key stands in it, so that any room can point at a
//! key long after parsing.
//!
//! Overrides live in the same space of offsets, behind the end of the text: one span type serves
//! both.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use super::overrides::Override;
use crate::{Error, error::InputError};

/// Remembers a scene file's path, text and overrides, and where each key stands.
#[derive(Debug, Clone)]
pub struct Source {
    path: PathBuf,
    text: String,
    overrides: Vec<Behind>,
    places: BTreeMap<Vec<String>, Place>,
}

/// An override as it stands behind the end of the text.
#[derive(Debug, Clone)]
struct Behind {
    key: String,
    value: String,
    region: Range<usize>,
    value_start: usize,
}

/// Describes where a key and its value stand; array elements have no key.
#[derive(Debug, Clone)]
pub(super) struct Place {
    pub(super) key: Option<Range<usize>>,
    pub(super) value: Range<usize>,
    /// Whether the value is a table that holds something.
    holds: bool,
}

impl Source {
    /// Starts with the text and the overrides, before anything is known about keys.
    pub(super) fn new(path: &Path, text: &str, overrides: &[Override]) -> Self {
        let behind = |o: &Override| Behind {
            key: o.key.to_owned(),
            value: o.text.to_owned(),
            region: o.region.clone(),
            value_start: o.value_start,
        };
        let overrides = overrides.iter().map(behind).collect();
        Self { path: path.to_owned(), text: text.to_owned(), overrides, places: BTreeMap::new() }
    }

    /// Records where every key of the tree stands.
    pub(super) fn index(&mut self, tree: &Spanned<DeTable>) {
        self.places.insert(Vec::new(), Place { key: None, value: tree.span(), holds: true });
        self.index_table(&mut Vec::new(), tree.get_ref());
    }

    fn index_table(&mut self, path: &mut Vec<String>, table: &DeTable) {
        for (key, value) in table {
            path.push(key.get_ref().clone().into_owned());
            self.index_value(path, Some(key.span()), value);
            path.pop();
        }
    }

    fn index_value(
        &mut self,
        path: &mut Vec<String>,
        key: Option<Range<usize>>,
        value: &Spanned<DeValue>,
    ) {
        let holds = value.get_ref().as_table().is_some_and(|table| !table.is_empty());
        self.places.insert(path.clone(), Place { key, value: value.span(), holds });
        match value.get_ref() {
            DeValue::Table(table) => self.index_table(path, table),
            DeValue::Array(items) => {
                for (i, item) in items.iter().enumerate() {
                    path.push(i.to_string());
                    self.index_value(path, None, item);
                    path.pop();
                }
            }
            _ => {}
        }
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the folder to which the file paths of the scene are relative.
    pub fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// Returns the bytes of the text where the value of `key` stands, such as `["objects", "head",
    /// "sh", "file"]`; array elements are named by their number. `None` when the key is not in the
    /// file.
    pub fn span(&self, key: &[&str]) -> Option<Range<usize>> {
        self.place(key).map(|place| place.value.clone())
    }

    /// Lists the values below `key` in order, each with its key path: `objects.ball.sphere.radius`
    /// and `0.7`. Numbers, words and arrays are written in one way however the file has them.
    pub fn values(&self, key: &[&str]) -> Vec<(String, String)> {
        let above: Vec<String> = key.iter().map(|&part| part.to_owned()).collect();
        let below = self.places.range(above.clone()..).take_while(|(p, _)| p.starts_with(&above));
        let mut values: Vec<(&[String], String)> = Vec::new();
        for (path, place) in below.filter(|(_, place)| !place.holds) {
            let is_element = values.last().is_some_and(|(array, _)| path.starts_with(array));
            if !is_element {
                values.push((path, one_way(self.written(&place.value))));
            }
        }
        values.into_iter().map(|(path, value)| (joined(path), value)).collect()
    }

    /// Whether the key itself was written on the command line.
    pub fn is_override(&self, key: &[&str]) -> bool {
        let place = self.place(key);
        place.is_some_and(|p| p.key.as_ref().unwrap_or(&p.value).start > self.text.len())
    }

    fn place(&self, key: &[&str]) -> Option<&Place> {
        let key: Vec<String> = key.iter().map(|&part| part.to_owned()).collect();
        self.places.get(&key)
    }

    /// Turns an offset in bytes into line and column, both from 1, the column in characters.
    pub fn line_column(&self, offset: usize) -> (usize, usize) {
        line_column(&self.text, offset)
    }

    /// Makes the error that points at the value of `key`, or at what encloses it when the file does
    /// not write the key.
    ///
    /// It is an [`Error::Input`] with line and column, or an [`Error::Parameter`] that names `-D
    /// key` when an override wrote the value.
    pub fn error(&self, key: &[&str], message: impl Into<String>, help: Option<String>) -> Error {
        let nearest = (0..=key.len()).rev().find_map(|n| self.span(&key[..n]));
        self.error_at(&nearest.unwrap_or(0..0), message, help)
    }

    /// Makes the error that points at a span.
    pub(super) fn error_at(
        &self,
        span: &Range<usize>,
        message: impl Into<String>,
        help: Option<String>,
    ) -> Error {
        if let Some(Behind { key, .. }) = self.override_at(span.start) {
            let help = help.map(|help| format!("\n  help: {help}")).unwrap_or_default();
            return Error::Parameter(format!("-D {key}: {}{help}", message.into()));
        }
        let (line, column) = self.line_column(span.start);
        let mut error = InputError::new(&self.path, message).at(line, Some(column));
        error.help = help;
        error.into()
    }

    fn override_at(&self, offset: usize) -> Option<&Behind> {
        self.overrides.iter().find(|one| one.region.contains(&offset))
    }

    /// Finds the key whose own span or whose value's span this is; the outermost where several
    /// share it.
    pub(super) fn find(&self, span: &Range<usize>) -> Option<(&[String], &Place)> {
        let is_here = |place: &Place| place.key.as_ref() == Some(span) || place.value == *span;
        let found = self.places.iter().find(|(_, place)| is_here(place));
        found.map(|(path, place)| (path.as_slice(), place))
    }

    /// Drops the numbers of array elements from the end of a path.
    pub(super) fn keyed<'a>(&self, mut path: &'a [String]) -> &'a [String] {
        let is_element =
            |path: &[String]| self.places.get(path).is_some_and(|place| place.key.is_none());
        while !path.is_empty() && is_element(path) {
            path = &path[..path.len() - 1];
        }
        path
    }

    /// Returns the value that stands at a span, as written in the text or in an override.
    pub(super) fn written(&self, span: &Range<usize>) -> &str {
        let (text, start) = match self.override_at(span.start) {
            Some(one) => (&one.value, one.value_start),
            None => (&self.text, 0),
        };
        let within = span.start.saturating_sub(start)..span.end.saturating_sub(start);
        text.get(within).unwrap_or_default()
    }
}

/// Writes a value as one that means the same is written; what is not TOML is a word of the command
/// line.
fn one_way(written: &str) -> String {
    DeValue::parse(written).map_or_else(|_| format!("{:?}", written.trim()), |value| plain(&value))
}

fn plain(value: &Spanned<DeValue>) -> String {
    let number = || f64::deserialize(ValueDeserializer::from(value.clone())).ok();
    match value.get_ref() {
        DeValue::String(text) => format!("{text:?}"),
        DeValue::Integer(_) | DeValue::Float(_) => number().map_or_else(String::new, plain_number),
        DeValue::Boolean(truth) => truth.to_string(),
        DeValue::Datetime(time) => time.to_string(),
        DeValue::Array(items) => {
            format!("[{}]", items.iter().map(plain).collect::<Vec<_>>().join(", "))
        }
        DeValue::Table(table) => {
            let entry =
                |(key, value): (&Spanned<_>, _)| format!("{} = {}", key.get_ref(), plain(value));
            format!("{{{}}}", table.iter().map(entry).collect::<Vec<_>>().join(", "))
        }
    }
}

/// Writes a number as short as brings it back, turning to exponents where plain digits would be
/// hundreds.
fn plain_number(x: f64) -> String {
    let text = format!("{x:?}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// Turns an offset in bytes into line and column, both from 1, the column in characters.
pub(super) fn line_column(text: &str, offset: usize) -> (usize, usize) {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    let before = &text[..offset];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

/// Points at one thing of the scene: what the checks of a single `[kind.NAME.type]` need to report
/// errors.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry<'a> {
    pub(super) source: &'a Source,
    pub(super) path: [&'a str; 3],
}

impl Entry<'_> {
    /// Makes the error that points at `key` of this thing; an empty key means the thing itself.
    pub(super) fn error(&self, key: &str, message: impl Into<String>, help: &str) -> Error {
        let mut path = self.path.to_vec();
        path.extend((!key.is_empty()).then_some(key));
        self.source.error(&path, message, Some(help.to_owned()))
    }

    /// Picks, of two keys that exclude each other, the one from the command line, else the second.
    pub(super) fn culprit<'k>(&self, first: &'k str, second: &'k str) -> &'k str {
        let [kind, name, r#type] = self.path;
        let overridden = self.source.is_override(&[kind, name, r#type, first]);
        if overridden { first } else { second }
    }

    /// Writes the header of this thing: `[lights.lamp.point]`.
    pub(super) fn header(&self) -> String {
        header(&self.path)
    }
}

/// Writes a key path in brackets.
pub(super) fn header<S: AsRef<str>>(path: &[S]) -> String {
    format!("[{}]", joined(path))
}

fn joined<S: AsRef<str>>(path: &[S]) -> String {
    path.iter().map(|part| quoted(part.as_ref())).collect::<Vec<_>>().join(".")
}

/// Writes one part of a key path, in quotes where TOML needs them.
fn quoted(part: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !part.is_empty() && part.chars().all(bare) { part.to_owned() } else { format!("{part:?}") }
}
