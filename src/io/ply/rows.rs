//! The rows of one element of a PLY file, value by value, text and binary alike.

use std::fmt;
use std::path::Path;

use super::header::{Element, Encoding, Scalar, Shape};
use crate::error::InputError;
use crate::io::bytes::field;
use crate::io::decimal::real;
use crate::io::source::{Source, number, shown};
use crate::{Error, Result};

/// One number of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::io) enum Value {
    Whole(i64),
    Real(f64),
}

impl Value {
    pub(in crate::io) fn as_f64(self) -> f64 {
        match self {
            Self::Whole(n) => n as f64,
            Self::Real(x) => x,
        }
    }

    pub(in crate::io) fn as_whole(self) -> Option<i64> {
        match self {
            Self::Whole(n) => Some(n),
            Self::Real(_) => None,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(n) => n.fmt(f),
            Self::Real(x) => x.fmt(f),
        }
    }
}

/// Says where a row is: its line in a text, its number in binary.
#[derive(Debug, Clone, Copy)]
pub(in crate::io) struct Place<'a> {
    path: &'a Path,
    line: Option<usize>,
    element: &'a str,
    row: u64,
}

impl Place<'_> {
    pub(in crate::io) fn fault(
        &self,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Error {
        let message = message.into();
        let error = match self.line {
            Some(line) => InputError::new(self.path, message).at(line, None),
            None => InputError::new(
                self.path,
                format!("{} {} (from 0): {message}", self.element, self.row),
            ),
        };
        error.help(help).into()
    }
}

/// Goes through the rows of an element.
pub(in crate::io) struct Rows<'r, 'a> {
    source: &'r mut Source<'a>,
    encoding: Encoding,
    element: &'r Element,
    /// The number of the next row.
    next: u64,
    /// How far the line of a text is read.
    read: usize,
}

impl<'r, 'a> Rows<'r, 'a> {
    pub(in crate::io) fn new(
        source: &'r mut Source<'a>,
        encoding: Encoding,
        element: &'r Element,
    ) -> Self {
        Self { source, encoding, element, next: 0, read: 0 }
    }

    pub(in crate::io) fn source(&self) -> &Source<'a> {
        self.source
    }

    pub(in crate::io) fn encoding(&self) -> Encoding {
        self.encoding
    }

    pub(in crate::io) fn element(&self) -> &'r Element {
        self.element
    }

    pub(in crate::io) fn count(&self) -> u64 {
        self.element.count
    }

    pub(in crate::io) fn properties(&self) -> usize {
        self.element.properties.len()
    }

    pub(in crate::io) fn shape(&self, property: usize) -> Shape {
        self.element.properties[property].shape
    }

    /// Goes to the next row; false after the last one.
    pub(in crate::io) fn next_row(&mut self) -> Result<bool> {
        // Rows of nothing take no bytes, however many there are.
        if self.next == self.element.count || self.element.properties.is_empty() {
            return Ok(false);
        }
        if self.encoding == Encoding::Text {
            self.read = 0;
            if !self.source.next_telling_line()? {
                return Err(self.cut_short());
            }
        }
        self.next += 1;
        Ok(true)
    }

    /// Rejects values that the header does not know.
    pub(in crate::io) fn end_row(&mut self) -> Result<()> {
        if self.encoding == Encoding::Text
            && let Some(word) = self.word()
        {
            let message = format!("`{}` is more than a {} holds", shown(word), self.element.name);
            let help = "write one row on each line, as the properties in the header say";
            return Err(self.place().fault(message, help));
        }
        Ok(())
    }

    /// Reads the next row, which `values` then holds: NaN for a list. False after the last one.
    pub(in crate::io) fn next_scalars(&mut self, values: &mut Vec<f64>) -> Result<bool> {
        values.clear();
        if !self.next_row()? {
            return Ok(false);
        }
        for property in 0..self.properties() {
            self.list(property, |_, _| Ok(()))?;
            values.push(self.scalar(property)?.as_f64());
        }
        self.end_row()?;
        Ok(true)
    }

    /// Passes over all rows.
    pub(in crate::io) fn pass_over(&mut self) -> Result<()> {
        let mut values = Vec::new();
        while self.next_scalars(&mut values)? {}
        Ok(())
    }

    /// Reads the value of a scalar property: each property in its turn. A list has none.
    pub(in crate::io) fn scalar(&mut self, property: usize) -> Result<Value> {
        match self.shape(property) {
            Shape::Scalar(scalar) => self.value(scalar),
            Shape::List { .. } => Ok(Value::Real(f64::NAN)),
        }
    }

    /// Reads a list and shows each of its values. A scalar has none.
    pub(in crate::io) fn list(
        &mut self,
        property: usize,
        mut see: impl FnMut(Place, Value) -> Result<()>,
    ) -> Result<()> {
        let Shape::List { count, item } = self.shape(property) else { return Ok(()) };
        let found = self.value(count)?;
        let Some(length) = found.as_whole().filter(|&n| n >= 0) else {
            let help = "a list begins with how many values follow";
            return Err(self.place().fault(format!("{found} is no length of a list"), help));
        };
        for _ in 0..length {
            let value = self.value(item)?;
            see(self.place(), value)?;
        }
        Ok(())
    }

    /// Rejects the row.
    pub(in crate::io) fn fault(
        &self,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Error {
        self.place().fault(message, help)
    }

    fn place(&self) -> Place<'r>
    where
        'a: 'r,
    {
        let line = (self.encoding == Encoding::Text).then(|| self.source.line());
        let row = self.next.saturating_sub(1);
        Place { path: self.source.path(), line, element: &self.element.name, row }
    }

    fn cut_short(&self) -> Error {
        let message = format!(
            "the file ends after {} of the {} rows of element {}",
            self.next.saturating_sub(u64::from(self.encoding != Encoding::Text)),
            self.element.count,
            self.element.name
        );
        self.source.fault(message, "the file is cut short or its header is wrong; export it again")
    }

    fn value(&mut self, scalar: Scalar) -> Result<Value> {
        if self.encoding == Encoding::Text {
            return self.text_value(scalar);
        }
        let mut raw = [0; 8];
        let bytes = &mut raw[..scalar.bytes()];
        if !self.source.fill(bytes)? {
            return Err(self.cut_short());
        }
        if self.encoding == Encoding::BigEndian {
            bytes.reverse();
        }
        Ok(decode(scalar, raw))
    }

    fn text_value(&mut self, scalar: Scalar) -> Result<Value> {
        let place = self.place();
        let Some(word) = self.word() else {
            let message = format!("a {} with too few values", place.element);
            let help = "write one row on each line, as the properties in the header say";
            return Err(place.fault(message, help));
        };
        let value = if scalar.is_whole() {
            number(word).map(Value::Whole)
        } else {
            std::str::from_utf8(word).ok().and_then(real).map(Value::Real)
        };
        value.ok_or_else(|| {
            let kind = if scalar.is_whole() { "whole number" } else { "number" };
            place.fault(format!("`{}` is no {kind}", shown(word)), "write what the header says")
        })
    }

    /// Takes the next word of the line.
    fn word(&mut self) -> Option<&[u8]> {
        let line = self.source.text();
        let start = self.read + line[self.read..].iter().position(|b| !b.is_ascii_whitespace())?;
        let length = line[start..].iter().position(u8::is_ascii_whitespace);
        self.read = length.map_or(line.len(), |n| start + n);
        Some(&self.source.text()[start..self.read])
    }
}

/// Reads a number from its bytes, the least significant first.
fn decode(scalar: Scalar, raw: [u8; 8]) -> Value {
    match scalar {
        Scalar::I8 => Value::Whole(field::<i8>(&raw, 0).into()),
        Scalar::U8 => Value::Whole(field::<u8>(&raw, 0).into()),
        Scalar::I16 => Value::Whole(field::<i16>(&raw, 0).into()),
        Scalar::U16 => Value::Whole(field::<u16>(&raw, 0).into()),
        Scalar::I32 => Value::Whole(field::<i32>(&raw, 0).into()),
        Scalar::U32 => Value::Whole(field::<u32>(&raw, 0).into()),
        Scalar::F32 => Value::Real(field::<f32>(&raw, 0).into()),
        Scalar::F64 => Value::Real(field::<f64>(&raw, 0)),
    }
}
