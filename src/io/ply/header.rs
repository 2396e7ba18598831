//! The header of a PLY file: the encoding, and the properties of each element.

use std::collections::HashSet;

use crate::Result;
use crate::io::source::{Source, number, shown};

/// Says how the rows are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::io) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// A type of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::io) enum Scalar {
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
pub(in crate::io) enum Shape {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

pub(in crate::io) struct Property {
    pub(in crate::io) name: String,
    pub(in crate::io) shape: Shape,
}

pub(in crate::io) struct Element {
    pub(in crate::io) name: String,
    pub(in crate::io) count: u64,
    pub(in crate::io) properties: Vec<Property>,
    /// Where it is declared.
    pub(in crate::io) line: usize,
}

pub(in crate::io) struct Header {
    pub(in crate::io) encoding: Encoding,
    pub(in crate::io) elements: Vec<Element>,
}

const UNFINISHED: &str =
    "a PLY header ends with the line `end_header`; the file is cut short or no PLY file";

impl Header {
    /// Finds an element by its name.
    pub(in crate::io) fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|e| e.name == name)
    }

    /// Rejects counts that the file is too short for, before anything is allocated by them.
    pub(in crate::io) fn check_length(&self, source: &Source) -> Result<()> {
        let mut left = source.left();
        for element in &self.elements {
            let least = element.least_bytes(self.encoding);
            let needed = least.checked_mul(element.count);
            left = needed.and_then(|needed| left.checked_sub(needed)).ok_or_else(|| {
                let message = format!(
                    "the header announces {} rows of element {}, of {least} bytes each at least, \
                     but only {left} bytes are left for them",
                    element.count, element.name
                );
                let help = "the file is cut short or its header is wrong; export it again";
                source.fault_at(element.line, message, help)
            })?;
        }
        Ok(())
    }

    /// Reads the header, up to the first row.
    pub(in crate::io) fn read(source: &mut Source) -> Result<Self> {
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

    pub(in crate::io) fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// Returns the bytes it takes in a binary file.
    pub(in crate::io) fn bytes(self) -> usize {
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
    fn least_bytes(self) -> u64 {
        match self {
            Self::Scalar(scalar) => scalar.bytes() as u64,
            Self::List { count, .. } => count.bytes() as u64,
        }
    }
}

impl Element {
    /// Returns which of the properties is a number of one of these names.
    pub(in crate::io) fn scalar(&self, names: &[&str]) -> Option<usize> {
        let is =
            |p: &Property| matches!(p.shape, Shape::Scalar(_)) && names.contains(&p.name.as_str());
        self.properties.iter().position(is)
    }

    /// Returns which of the properties are x, y and z.
    pub(in crate::io) fn coordinates(&self, source: &Source) -> Result<[usize; 3]> {
        let coordinate = |name: &str| {
            self.scalar(&[name]).ok_or_else(|| {
                let help = format!("declare it, as in `property double {name}`");
                let message = format!("vertices have no property {name}");
                source.fault_at(self.line, message, help)
            })
        };
        Ok([coordinate("x")?, coordinate("y")?, coordinate("z")?])
    }

    /// Returns which of the properties is a list of whole numbers of one of these names.
    pub(in crate::io) fn whole_list(&self, names: &[&str]) -> Option<usize> {
        let is = |p: &Property| {
            matches!(p.shape, Shape::List { item, .. } if item.is_whole())
                && names.contains(&p.name.as_str())
        };
        self.properties.iter().position(is)
    }

    /// Returns the bytes that a row takes at least.
    pub(in crate::io) fn least_bytes(&self, encoding: Encoding) -> u64 {
        match encoding {
            // A digit and what parts it from the next.
            Encoding::Text => (2 * self.properties.len() as u64).saturating_sub(1),
            _ => self.properties.iter().map(|p| p.shape.least_bytes()).sum(),
        }
    }
}
