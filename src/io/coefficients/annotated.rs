//! The comment lines with which our coefficient texts begin, whatever the layout of their rows, and
//! the text as a whole.
//!
//! ```text
//! # harmolux 0.2.0 coefficients
//! # normalisation: 4pi
//! # csphase: 1
//! # unit: m
//! # centre: 0.0 0.0 0.0
//! # source: "head.obj"
//! # source-hash: fnv1a64:85944171f73967e8
//! # lmax: 32
//! # truncated-from: 64
//! ```
//!
//! `source`, `source-hash` and `truncated-from` may lack. A text that does not begin with the first
//! of these lines is a bare one: its comments mean nothing to us, its centre is the origin, and its
//! convention must be given.

use std::path::Path;

use glam::DVec3;

use super::ReadOptions;
use super::rows::{agreed, text};
use crate::error::{Advice, InputError};
use crate::fit::{Shape, Source, SourceHash};
use crate::io::output::SOFTWARE;
use crate::sh::{Coefficients, CondonShortley, Convention, Normalisation};
use crate::{Error, Result};

/// Ends the first line of our files.
const TITLE: &str = "coefficients";

/// Names the keys of the comment lines.
const NORMALISATION: &str = "normalisation";
const CSPHASE: &str = "csphase";
const UNIT: &str = "unit";
const CENTRE: &str = "centre";
const SOURCE: &str = "source";
const SOURCE_HASH: &str = "source-hash";
const LMAX: &str = "lmax";
const TRUNCATED_FROM: &str = "truncated-from";

/// Writes a shape as text: the comments, then what `row` makes of each degree, order and pair of
/// coefficients.
pub(super) fn write(
    shape: &Shape,
    convention: Convention,
    row: impl Fn(usize, usize, (f64, f64)) -> String,
) -> Result<Vec<u8>> {
    let mut lines = header(shape, convention);
    for l in 0..=shape.coefficients.lmax() {
        for m in 0..=l {
            lines.push(row(l, m, convention.export(l, m, shape.coefficients.get(l, m))?));
        }
    }
    Ok(lines.concat().into_bytes())
}

fn header(shape: &Shape, convention: Convention) -> Vec<String> {
    let DVec3 { x, y, z } = shape.centre;
    let mut lines = vec![format!("# {SOFTWARE} {TITLE}\n")];
    let mut line = |key: &str, value: &str| lines.push(format!("# {key}: {value}\n"));
    line(NORMALISATION, convention.normalisation.name());
    line(CSPHASE, &convention.phase.csphase().to_string());
    line(UNIT, "m");
    line(CENTRE, &format!("{x:?} {y:?} {z:?}"));
    if let Some(source) = &shape.source {
        line(SOURCE, &quoted(&source.name));
        line(SOURCE_HASH, &source.hash.to_string());
    }
    line(LMAX, &shape.coefficients.lmax().to_string());
    if let Some(degree) = shape.truncated_from {
        line(TRUNCATED_FROM, &degree.to_string());
    }
    lines
}

/// Quotes a text as a JSON string in pure ASCII: a name with a line break stays on its line, and
/// pyshtools decodes by the system's encoding, whichever that is.
fn quoted(text: &str) -> String {
    let escaped = |c: char| -> String {
        if c.is_ascii() {
            return c.to_string();
        }
        let units: Vec<String> =
            c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")).collect();
        units.concat()
    };
    serde_json::Value::from(text).to_string().chars().map(escaped).collect()
}

/// Reads a text, ours or bare, whose rows `rows` understands; it is told whether the text is ours.
pub(super) fn parse(
    path: &Path,
    bytes: &[u8],
    options: &ReadOptions,
    rows: impl Fn(&Path, &str, bool, Convention) -> Result<Coefficients>,
) -> Result<Shape> {
    let text = text(path, bytes)?;
    let notes = Notes::read(path, text)?;
    let convention = agreed(path, "the file says", notes.convention(), options.convention)?;
    if notes.ours && !text.ends_with('\n') {
        let last = text.lines().count();
        return Err(InputError::new(path, "the file is cut off within this line")
            .at(last, None)
            .into());
    }
    if notes.ours && options.unit.is_some_and(|metres| metres != 1.0) {
        return Err(InputError::new(path, "the file says that its unit is the metre")
            .advise(Advice::LeaveOutUnit)
            .into());
    }
    let coefficients = rows(path, text, notes.ours, convention)?;
    check_lmax(path, &notes, coefficients.lmax())?;
    Ok(Shape {
        coefficients,
        centre: notes.centre.unwrap_or(DVec3::ZERO),
        source: notes.name.zip(notes.hash).map(|(name, hash)| Source { name, hash }),
        truncated_from: notes.truncated_from,
    })
}

fn check_lmax(path: &Path, notes: &Notes, found: usize) -> Result<()> {
    match notes.lmax {
        Some(lmax) if lmax != found => Err(InputError::new(
            path,
            format!("the file announces degree {lmax} and ends with degree {found}"),
        )
        .help("part of it is lost: make it anew")
        .into()),
        _ => Ok(()),
    }
}

/// Returns the convention that a text states.
pub(super) fn convention(path: &Path, bytes: &[u8]) -> Result<Option<Convention>> {
    Ok(Notes::read(path, text(path, bytes)?)?.convention())
}

/// Whether a text begins as ours do.
pub(super) fn is_ours(text: &str) -> bool {
    text.lines().next().is_some_and(is_title)
}

fn is_title(line: &str) -> bool {
    line.starts_with("# harmolux ") && line.ends_with(TITLE)
}

/// Holds what the comment lines say.
#[derive(Default)]
struct Notes {
    ours: bool,
    normalisation: Option<Normalisation>,
    phase: Option<CondonShortley>,
    centre: Option<DVec3>,
    name: Option<String>,
    hash: Option<SourceHash>,
    lmax: Option<usize>,
    truncated_from: Option<usize>,
}

impl Notes {
    fn read(path: &Path, text: &str) -> Result<Self> {
        let mut notes = Self::default();
        let mut lines = text.lines().zip(1..).take_while(|(line, _)| line.starts_with('#'));
        let Some((first, _)) = lines.next() else { return Ok(notes) };
        if !is_title(first) {
            return Ok(notes);
        }
        notes.ours = true;
        for (line, number) in lines {
            if let Some((key, value)) = line[1..].split_once(':') {
                notes
                    .take(key.trim(), value.trim())
                    .map_err(|message| InputError::new(path, message).at(number, None))?;
            }
        }
        notes.check_complete(path)?;
        Ok(notes)
    }

    fn convention(&self) -> Option<Convention> {
        let stated = self.normalisation.zip(self.phase);
        stated.map(|(normalisation, phase)| Convention { normalisation, phase })
    }

    /// Takes one comment; keys of other versions are passed over.
    fn take(&mut self, key: &str, value: &str) -> Result<(), String> {
        let broken = |expected: &str| format!("`{value}` is no {key}: expected {expected}");
        match key {
            NORMALISATION => {
                self.normalisation = Some(value.parse().map_err(|e: Error| e.to_string())?);
            }
            CSPHASE => self.phase = Some(value.parse().map_err(|e: Error| e.to_string())?),
            UNIT if value != "m" => return Err(broken("m (scale the coefficients to metres)")),
            CENTRE => {
                self.centre = Some(point(value).ok_or_else(|| broken("three numbers, metres"))?);
            }
            SOURCE => {
                let name = serde_json::from_str(value).map_err(|_| broken("a name in quotes"))?;
                self.name = Some(name);
            }
            SOURCE_HASH => {
                let hash = SourceHash::parse(value);
                self.hash = Some(hash.ok_or_else(|| broken("fnv1a64: and 16 hexadecimal digits"))?);
            }
            LMAX => self.lmax = Some(value.parse().map_err(|_| broken("a degree"))?),
            TRUNCATED_FROM => {
                self.truncated_from = Some(value.parse().map_err(|_| broken("a degree"))?);
            }
            _ => {}
        }
        Ok(())
    }

    fn check_complete(&self, path: &Path) -> Result<()> {
        let missing = [
            (self.normalisation.is_none(), NORMALISATION, "4pi"),
            (self.phase.is_none(), CSPHASE, "1"),
            (self.centre.is_none(), CENTRE, "0 0 0"),
            (self.lmax.is_none(), LMAX, "32"),
        ];
        match missing.into_iter().find(|(missing, ..)| *missing) {
            Some((_, key, example)) => {
                Err(InputError::new(path, format!("the comments lack `{key}`"))
                    .at(1, None)
                    .advise(Advice::CompleteComments { key, example })
                    .into())
            }
            None => Ok(()),
        }
    }
}

fn point(text: &str) -> Option<DVec3> {
    let numbers: Vec<f64> =
        text.split_whitespace().map(str::parse).collect::<Result<_, _>>().ok()?;
    let point = DVec3::from_array(numbers.try_into().ok()?);
    point.is_finite().then_some(point)
}
