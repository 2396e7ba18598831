//! The header of a PLY file: the encoding, and the properties of each element.

use std::collections::HashSet;

use crate::Result;
use crate::io::meshes::source::{Source, number, shown};

/// Says how the rows are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// A type of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

/// What a property holds in each row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

pub(super) struct Property {
    pub(super) name: String,
    pub(super) shape: Shape,
}

pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    /// Where it is declared.
    pub(super) line: usize,
}

pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
}

const UNFINISHED: &str =
    "a PLY header ends with the line `end_header`; the file is cut short or no PLY file";

impl Header {
    /// Reads the header, up to the first row.
    pub(super) fn read(source: &mut Source) -> Result<Self> {
        let is_ply = source.next_line()? && source.text().trim_ascii_end() == b"ply";
        if !is_ply {
            let help = "a PLY file begins with the line `ply`; check that this is the right file";
            return Err(source.fault("this is no PLY file", help));
        }
        source.settle_line_ends();
        let mut encoding = None;
        let mut elements = Vec::new();
        while source.next_line()? {
            let words: Vec<&[u8]> =
                source.text().split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).collect();
            match words[..] {
                [] | [b"comment" | b"obj_info", ..] => {}
                [b"format", ref format @ ..] => encoding = Some(encoding_of(source, format)?),
                [b"element", name, count] => elements.push(element(source, name, count)?),
                [b"property", ref property @ ..] => {
                    let property = self::property(source, property)?;
                    let Some(element) = elements.last_mut() else {
                        let help =
                            "declare an element before its properties, as in `element vertex 8`";
                        return Err(source.fault_here("a property of no element", help));
                    };
                    element.properties.push(property);
                }
                [b"end_header"] => return finish(source, encoding, elements),
                [word, ..] => {
                    let message = format!("`{}` is no statement of a PLY header", shown(word));
                    return Err(source.fault_here(message, UNFINISHED));
                }
            }
        }
        Err(source.fault("the header does not end", UNFINISHED))
    }
}

fn finish(source: &Source, encoding: Option<Encoding>, elements: Vec<Element>) -> Result<Header> {
    let encoding = encoding.ok_or_else(|| {
        source.fault(
            "the header has no format",
            "add the line `format ascii 1.0` or what the rows are",
        )
    })?;
    let mut names = HashSet::new();
    if let Some(element) = elements.iter().find(|e| !names.insert(e.name.as_str())) {
        let message = format!("element {} is declared twice", element.name);
        return Err(source.fault_at(element.line, message, "give each element one declaration"));
    }
    Ok(Header { encoding, elements })
}

fn encoding_of(source: &Source, words: &[&[u8]]) -> Result<Encoding> {
    match words {
        [b"ascii", b"1.0"] => Ok(Encoding::Text),
        [b"binary_little_endian", b"1.0"] => Ok(Encoding::LittleEndian),
        [b"binary_big_endian", b"1.0"] => Ok(Encoding::BigEndian),
        _ => {
            let message = format!("`{}` is not a known format", shown(&words.join(&b' ')));
            let help = "write `ascii 1.0`, `binary_little_endian 1.0` or `binary_big_endian 1.0`";
            Err(source.fault_here(message, help))
        }
    }
}

fn element(source: &Source, name: &[u8], count: &[u8]) -> Result<Element> {
    let count = number(count).ok_or_else(|| {
        let message = format!("`{}` is no number of rows", shown(count));
        source.fault_here(message, "write a whole number, as in `element vertex 8`")
    })?;
    let name = String::from_utf8_lossy(name).into_owned();
    Ok(Element { name, count, properties: Vec::new(), line: source.line() })
}

fn property(source: &Source, words: &[&[u8]]) -> Result<Property> {
    let (shape, name) = match *words {
        [b"list", count, item, name] => {
            let count = Scalar::named(count).filter(|s| s.is_whole());
            let item = Scalar::named(item);
            (count.zip(item).map(|(count, item)| Shape::List { count, item }), name)
        }
        [scalar, name] => (Scalar::named(scalar).map(Shape::Scalar), name),
        _ => (None, &b""[..]),
    };
    let shape = shape.ok_or_else(|| {
        let message = format!("`{}` is no property", shown(&words.join(&b' ')));
        let help = "write a type and a name, as in `float x` or `list uchar int vertex_indices`";
        source.fault_here(message, help)
    })?;
    Ok(Property { name: String::from_utf8_lossy(name).into_owned(), shape })
}

impl Scalar {
    fn named(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// Returns the bytes it takes in a binary file.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

impl Shape {
    /// Returns the bytes it takes at least in a binary file.
    pub(super) fn least_bytes(self) -> u64 {
        match self {
            Self::Scalar(scalar) => scalar.bytes() as u64,
            Self::List { count, .. } => count.bytes() as u64,
        }
    }
}

impl Property {
    pub(super) fn is_scalar(&self) -> bool {
        matches!(self.shape, Shape::Scalar(_))
    }

    pub(super) fn is_list_of_whole(&self) -> bool {
        matches!(self.shape, Shape::List { item, .. } if item.is_whole())
    }
}
