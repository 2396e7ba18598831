//! Overrides from the command line, `-D lights.lamp.point.intensity=250`: split, parse, put into
//! the tree of the scene.

use std::borrow::Cow;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::suggest::suggest;
use crate::{Error, Result};

/// One override, with its place in the space of offsets behind the end of the file's text.
#[derive(Debug)]
pub(super) struct Override<'i> {
    pub(super) key: &'i str,
    pub(super) text: &'i str,
    pub(super) region: Range<usize>,
    pub(super) value_start: usize,
    parts: Vec<Spanned<Cow<'i, str>>>,
    value: Spanned<DeValue<'i>>,
}

/// Splits `KEY=VALUE` at the first `=` outside quotes.
///
/// ```
/// use harmolux::io::scene_file::split_override;
/// assert_eq!(split_override("render.camera=main")?, ("render.camera", "main"));
/// # Ok::<(), harmolux::Error>(())
/// ```
///
/// # Errors
/// [`Error::Parameter`] when there is no `=`.
pub fn split_override(text: &str) -> Result<(&str, &str)> {
    let mut quote = None;
    for (i, c) in text.char_indices() {
        match (quote, c) {
            (None, '=') => return Ok((text[..i].trim(), text[i + 1..].trim())),
            (None, '"' | '\'') => quote = Some(c),
            (Some(open), c) if c == open => quote = None,
            _ => {}
        }
    }
    Err(malformed(text, "has no `=`"))
}

fn malformed(text: &str, why: &str) -> Error {
    Error::Parameter(format!(
        "-D {text}: {why}\n  help: write KEY=VALUE, as in lights.lamp.point.intensity=250; quote \
         names that hold dots or spaces"
    ))
}

/// Parses all overrides, giving each its place behind `end`, the end of the file's text.
pub(super) fn parse_all<'i>(
    overrides: &[(&'i str, &'i str)],
    end: usize,
) -> Result<Vec<Override<'i>>> {
    let mut start = end + 1;
    let mut parsed = Vec::with_capacity(overrides.len());
    for &(key, value) in overrides {
        let one = Override::parse(key, value, start)?;
        start = one.region.end + 1;
        parsed.push(one);
    }
    Ok(parsed)
}

impl<'i> Override<'i> {
    fn parse(key: &'i str, text: &'i str, start: usize) -> Result<Self> {
        let parts = parse_key(key, start)?;
        let value_start = start + key.len() + 1;
        let region = start..value_start + text.len() + 1;
        let value = shifted(parse_value(key, text)?, value_start);
        Ok(Self { key, text, region, value_start, parts, value })
    }

    fn error(&self, message: &str, help: &str) -> Error {
        Error::Parameter(format!("-D {}: {message}\n  help: {help}", self.key))
    }

    /// Replaces or adds the value in the tree.
    pub(super) fn apply(self, root: &mut DeTable<'i>, kinds: &[&str]) -> Result<()> {
        self.check_name(root, kinds)?;
        let mut table = root;
        let (last, parents) =
            self.parts.split_last().ok_or_else(|| malformed(self.key, "has no key"))?;
        for part in parents {
            let new = || Spanned::new(part.span(), DeValue::Table(DeTable::new()));
            table = match table.entry(part.clone()).or_insert_with(new).get_mut() {
                DeValue::Table(inner) => inner,
                other => {
                    let message = format!("`{part}` is of type {}, not a table", other.type_str());
                    return Err(self.error(&message, "give its value whole"));
                }
            };
        }
        // Removed first: an insert alone would keep the old key and its place in the file.
        table.remove(last.get_ref().as_ref());
        table.insert(last.clone(), self.value);
        Ok(())
    }

    /// Rejects a key of a thing the scene does not have: one key alone never makes a thing, so its
    /// name must be misspelt.
    fn check_name(&self, root: &DeTable, kinds: &[&str]) -> Result<()> {
        let [kind, name, _, _, ..] = self.parts.as_slice() else { return Ok(()) };
        if !kinds.contains(&kind.get_ref().as_ref()) {
            return Ok(());
        }
        let things = root.get(kind.get_ref().as_ref()).and_then(|value| value.get_ref().as_table());
        let names: Vec<String> =
            things.into_iter().flat_map(DeTable::keys).map(ToString::to_string).collect();
        if names.iter().any(|known| known == name.get_ref()) {
            return Ok(());
        }
        let message = format!("there is no `{name}` in [{kind}]");
        Err(self.error(&message, &suggest(name.get_ref(), &names, kind.get_ref())))
    }
}

/// Parses a key path by TOML's own rules, as the key of a one-line document.
fn parse_key(key: &str, start: usize) -> Result<Vec<Spanned<Cow<'static, str>>>> {
    let document = format!("{key} = 0");
    let not_a_path = || malformed(key, "the key is not a path of names with dots between them");
    let tree = DeTable::parse(&document).map_err(|_| not_a_path())?;
    let mut parts = Vec::new();
    let mut table = tree.into_inner();
    loop {
        let (part, value) = table.into_iter().next().ok_or_else(not_a_path)?;
        let span = part.span();
        let span = start + span.start..start + span.end;
        parts.push(Spanned::new(span, Cow::Owned(part.into_inner().into_owned())));
        // The value must be the 0 put there: a key with a comment or a line break of its own would
        // smuggle in another.
        let is_ours = value.span().start == key.len() + 3;
        match value.into_inner() {
            DeValue::Table(inner) => table = inner,
            DeValue::Integer(_) if is_ours => return Ok(parts),
            _ => return Err(not_a_path()),
        }
    }
}

/// Parses a value; what is not TOML and does not start like it is a string without quotes.
fn parse_value<'i>(key: &str, value: &'i str) -> Result<Spanned<DeValue<'i>>> {
    match DeValue::parse(value) {
        Ok(parsed) => Ok(parsed),
        Err(_) if value.trim().is_empty() => {
            Err(malformed(&format!("{key}={value}"), "the value is missing"))
        }
        Err(error) if value.trim_start().starts_with(['[', '{', '"', '\'']) => {
            let why = format!("the value is not valid TOML: {}", error.message());
            Err(malformed(&format!("{key}={value}"), &why))
        }
        Err(_) => Ok(Spanned::new(0..value.len(), DeValue::String(Cow::Borrowed(value.trim())))),
    }
}

/// Moves all spans of a value.
fn shifted(value: Spanned<DeValue<'_>>, by: usize) -> Spanned<DeValue<'_>> {
    let moved = |span: Range<usize>| span.start + by..span.end + by;
    let span = moved(value.span());
    let value = match value.into_inner() {
        DeValue::Array(items) => {
            DeValue::Array(items.into_iter().map(|item| shifted(item, by)).collect())
        }
        DeValue::Table(table) => {
            let entry = |(key, value): (Spanned<_>, _)| {
                (Spanned::new(moved(key.span()), key.into_inner()), shifted(value, by))
            };
            DeValue::Table(table.into_iter().map(entry).collect())
        }
        scalar => scalar,
    };
    Spanned::new(span, value)
}
