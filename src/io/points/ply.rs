//! Points of a PLY file without faces, text or binary of either byte order: x, y, z of its
//! vertices, their weight where they have one, whatever else they hold.

use std::io::{BufRead, Read};
use std::path::Path;

use super::{PointOptions, no_weights, point};
use crate::error::{InputError, shown_bytes};
use crate::io::decimal::real;
use crate::memory::MAX_LINE;
use crate::mesh::Points;
use crate::{Error, Result};

/// How a text may say that it is UTF-8.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Whether a file that begins so is PLY.
pub(super) fn is_ply(head: &[u8]) -> bool {
    let head = head.strip_prefix(MARK).unwrap_or(head);
    head.strip_prefix(b"ply").is_some_and(|rest| rest.first().is_some_and(u8::is_ascii_whitespace))
}

/// Whether a file that begins so is PLY with vertices and without faces or strips.
pub(super) fn is_cloud(head: &[u8]) -> bool {
    let header = is_ply(head).then(|| Header::read(Path::new(""), &mut &*head).ok()).flatten();
    header.is_some_and(|header| {
        let rows = |name: &str| header.elements.iter().any(|e| e.name == name && e.count > 0);
        rows("vertex") && !rows("face") && !rows("tristrips")
    })
}

/// Reads the vertices; what comes after them is not looked at.
pub(super) fn parse(path: &Path, from: &mut impl BufRead, options: PointOptions) -> Result<Points> {
    let header = Header::read(path, from)?;
    let Header { encoding, end, lines, .. } = header;
    let mut rows = Rows { path, from, encoding, end, line: lines };
    // What has no properties has no rows.
    for element in header.elements.iter().filter(|e| !e.properties.is_empty()) {
        if element.name == "vertex" {
            return vertices(&mut rows, element, options);
        }
        let mut row = Vec::new();
        for number in 0..element.count {
            rows.next(element, number, &mut row)?;
        }
    }
    Err(InputError::new(path, "the header has no element vertex").help(DECLARE).into())
}

const DECLARE: &str = "points are vertices with x, y and z, as in `property float x`";

fn vertices(
    rows: &mut Rows<'_, impl BufRead>,
    element: &Element,
    options: PointOptions,
) -> Result<Points> {
    let place = |names: &[&str]| {
        let is = |p: &Property| p.list.is_none() && names.contains(&p.name.as_str());
        element.properties.iter().position(is)
    };
    let need = |name: &str| {
        place(&[name]).ok_or_else(|| {
            let message = format!("vertices have no property {name}");
            Error::from(InputError::new(rows.path, message).help(DECLARE))
        })
    };
    let coordinates = [need("x")?, need("y")?, need("z")?];
    let weight = place(&["weight", "w"]);
    if options.weights && weight.is_none() {
        return Err(no_weights(rows.path, "vertices have no property weight").into());
    }
    let (mut points, mut row) = (Points::default(), Vec::new());
    for number in 0..element.count {
        rows.next(element, number, &mut row)?;
        let made = point(coordinates.map(|i| row[i]), weight.map_or(1.0, |i| row[i]));
        let (position, weight) = made.map_err(|(_, message)| rows.fault(number, message))?;
        points.positions.push(position);
        points.weights.push(weight);
    }
    Ok(points)
}

/// How the rows are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Text,
    Little,
    Big,
}

/// A type of numbers: its bytes, whether it is real, whether it has a sign.
#[derive(Debug, Clone, Copy)]
struct Scalar {
    bytes: usize,
    real: bool,
    signed: bool,
}

struct Property {
    name: String,
    scalar: Scalar,
    /// The type of the count, where it is a list.
    list: Option<Scalar>,
}

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
    /// With what lines end.
    end: u8,
    /// How many lines it takes.
    lines: usize,
}

impl Header {
    /// Reads the header, whose lines end as its first does.
    fn read(path: &Path, from: &mut impl BufRead) -> Result<Self> {
        if from.fill_buf().map_err(|e| Error::io(path, "read", e))?.starts_with(MARK) {
            from.consume(MARK.len());
        }
        let head = from.fill_buf().map_err(|e| Error::io(path, "read", e))?;
        let end =
            if head.starts_with(b"ply\r") && !head.starts_with(b"ply\r\n") { b'\r' } else { b'\n' };
        let mut header = Self { encoding: Encoding::Text, elements: Vec::new(), end, lines: 0 };
        loop {
            let line = line(path, from, end)?;
            header.lines += 1;
            if line.is_empty() {
                let message = "the header of this PLY file does not end";
                return Err(InputError::new(path, message).help("it is cut short").into());
            }
            let text = String::from_utf8_lossy(&line);
            let words: Vec<&str> = text.split_ascii_whitespace().collect();
            if words == ["end_header"] {
                return Ok(header);
            }
            header.take(&words).ok_or_else(|| {
                let message =
                    format!("`{}` is no statement of a PLY header", shown_bytes(line.trim_ascii()));
                InputError::new(path, message).at(header.lines, None)
            })?;
        }
    }

    /// Takes a statement; `None` for what is none.
    fn take(&mut self, words: &[&str]) -> Option<()> {
        match *words {
            [] | ["ply" | "comment" | "obj_info", ..] => {}
            ["format", "ascii", "1.0"] => self.encoding = Encoding::Text,
            ["format", "binary_little_endian", "1.0"] => self.encoding = Encoding::Little,
            ["format", "binary_big_endian", "1.0"] => self.encoding = Encoding::Big,
            ["element", name, count] => {
                let (name, count) = (name.to_owned(), count.parse().ok()?);
                self.elements.push(Element { name, count, properties: Vec::new() });
            }
            ["property", "list", count, item, name] => {
                let list = Scalar::named(count).filter(|s| !s.real)?;
                self.property(name, Scalar::named(item)?, Some(list))?;
            }
            ["property", scalar, name] => self.property(name, Scalar::named(scalar)?, None)?,
            _ => return None,
        }
        Some(())
    }

    fn property(&mut self, name: &str, scalar: Scalar, list: Option<Scalar>) -> Option<()> {
        let name = name.to_owned();
        self.elements.last_mut()?.properties.push(Property { name, scalar, list });
        Some(())
    }
}

impl Scalar {
    fn named(word: &str) -> Option<Self> {
        let (bytes, real, signed) = match word {
            "char" | "int8" => (1, false, true),
            "uchar" | "uint8" => (1, false, false),
            "short" | "int16" => (2, false, true),
            "ushort" | "uint16" => (2, false, false),
            "int" | "int32" => (4, false, true),
            "uint" | "uint32" => (4, false, false),
            "float" | "float32" => (4, true, true),
            "double" | "float64" => (8, true, true),
            _ => return None,
        };
        Some(Self { bytes, real, signed })
    }

    /// Makes a number of its bytes, the least significant first.
    fn number(self, mut bytes: [u8; 8]) -> f64 {
        if self.real && self.bytes == 4 {
            let [a, b, c, d, ..] = bytes;
            return f64::from(f32::from_le_bytes([a, b, c, d]));
        }
        if self.real {
            return f64::from_le_bytes(bytes);
        }
        if self.signed && bytes[self.bytes - 1] >= 0x80 {
            bytes[self.bytes..].fill(0xff);
        }
        i64::from_le_bytes(bytes) as f64
    }
}

/// The rows of the elements, one after the other.
struct Rows<'a, B> {
    path: &'a Path,
    from: &'a mut B,
    encoding: Encoding,
    end: u8,
    /// How many lines are read.
    line: usize,
}

impl<B: BufRead> Rows<'_, B> {
    /// Reads a row: a number for each property, for a list how many it has.
    fn next(&mut self, element: &Element, number: u64, row: &mut Vec<f64>) -> Result<()> {
        row.clear();
        if self.encoding == Encoding::Text {
            self.text(element, number, row)
        } else {
            self.binary(element, number, row)
        }
    }

    fn text(&mut self, element: &Element, number: u64, row: &mut Vec<f64>) -> Result<()> {
        let line = loop {
            let line = line(self.path, self.from, self.end)?;
            self.line += 1;
            if line.is_empty() {
                return Err(self.cut(element, number));
            }
            if !line.trim_ascii().is_empty() {
                break line;
            }
        };
        let text = String::from_utf8_lossy(&line);
        let mut words = text.split_ascii_whitespace();
        for property in &element.properties {
            let value = words.next().and_then(real);
            let listed = property.list.and(value).unwrap_or(0.0).max(0.0) as usize;
            let whole = listed == 0 || words.nth(listed - 1).is_some();
            let value = value.filter(|_| whole).ok_or_else(|| {
                let message =
                    format!("this row of element {} has no {}", element.name, property.name);
                self.fault(number, message)
            })?;
            row.push(value);
        }
        Ok(())
    }

    fn binary(&mut self, element: &Element, number: u64, row: &mut Vec<f64>) -> Result<()> {
        for property in &element.properties {
            let scalar = property.list.unwrap_or(property.scalar);
            let mut bytes = [0; 8];
            let part = &mut bytes[..scalar.bytes];
            self.from.read_exact(part).map_err(|_| self.cut(element, number))?;
            if self.encoding == Encoding::Big {
                part.reverse();
            }
            let value = scalar.number(bytes);
            if property.list.is_some() {
                let length = property.scalar.bytes as u64 * value.max(0.0) as u64;
                let mut items = self.from.by_ref().take(length);
                let passed = std::io::copy(&mut items, &mut std::io::sink());
                if passed.ok() != Some(length) {
                    return Err(self.cut(element, number));
                }
            }
            row.push(value);
        }
        Ok(())
    }

    /// Returns the error that the file ends before a row.
    fn cut(&self, element: &Element, number: u64) -> Error {
        let (name, count) = (&element.name, element.count);
        let message =
            format!("the file ends in row {number} (from 0) of {count} of element {name}");
        InputError::new(self.path, message).help("part of it is lost: get it anew").into()
    }

    fn fault(&self, number: u64, message: String) -> Error {
        match self.encoding {
            Encoding::Text => InputError::new(self.path, message).at(self.line, None).into(),
            _ => InputError::new(self.path, format!("vertex {number} (from 0): {message}")).into(),
        }
    }
}

/// Reads up to the end of a line, which is kept; nothing at the end of the file.
fn line(path: &Path, from: &mut impl BufRead, end: u8) -> Result<Vec<u8>> {
    let mut line = Vec::new();
    let read = from.take(MAX_LINE as u64).read_until(end, &mut line);
    if read.map_err(|e| Error::io(path, "read", e))? == MAX_LINE {
        return Err(InputError::new(path, "a line of this PLY file does not end").into());
    }
    Ok(line)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn read(bytes: &[u8], weights: bool) -> Result<Points> {
        super::super::parse(Path::new("p.ply"), bytes, PointOptions { weights })
    }

    fn refusal(bytes: &[u8]) -> String {
        read(bytes, false).expect_err("refused").to_string()
    }

    const HEADER: &str = "ply\nformat ascii 1.0\ncomment a scan\nelement camera 1\n\
        property list uchar float at\nelement vertex 2\nproperty float z\nproperty uchar red\n\
        property double x\nproperty list uint8 int16 seen\nproperty float y\n\
        property float weight\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n";
    const ROWS: &str = "2 0.5 0.5\n3 255 1 2 7 8 2 0.5\n\n6 0 4 0 5 0\n";

    #[test]
    fn vertices_of_text_and_of_either_order_of_bytes_are_the_points() {
        let text = format!("{HEADER}{ROWS}");
        let expected = Points {
            positions: vec![DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)],
            weights: vec![0.5, 0.0],
        };
        assert!(is_cloud(text.as_bytes()));
        assert_eq!(read(text.as_bytes(), true).expect("points"), expected);
        assert_eq!(read(format!("\u{feff}{text}").as_bytes(), true).expect("points"), expected);
        assert_eq!(read(text.replace('\n', "\r").as_bytes(), true).expect("points"), expected);
        assert_eq!(read(text.replace('\n', "\r\n").as_bytes(), true).expect("points"), expected);
        for big in [false, true] {
            let mut bytes = Vec::new();
            let mut put = |mut part: Vec<u8>| {
                if big {
                    part.reverse();
                }
                bytes.extend(part);
            };
            let real = |x: f32| x.to_le_bytes().to_vec();
            [vec![2], real(0.5), real(0.5)].into_iter().for_each(&mut put);
            for [x, y, z, w] in [[1.0_f32, 2.0, 3.0, 0.5], [4.0, 5.0, 6.0, 0.0]] {
                let x = f64::from(x).to_le_bytes().to_vec();
                let row = [real(z), vec![255], x, vec![1], vec![1, 2], real(y), real(w)];
                row.into_iter().for_each(&mut put);
            }
            let format = if big { "binary_big_endian" } else { "binary_little_endian" };
            let whole = [HEADER.replace("ascii", format).as_bytes(), &bytes].concat();
            assert_eq!(read(&whole, false).expect("points"), expected);
            assert!((0..whole.len()).all(|end| read(&whole[..end], false).is_err()));
        }
    }

    #[test]
    fn numbers_of_every_type_are_read() {
        for (name, bytes, value) in [
            ("char", vec![0xfe], -2.0),
            ("uchar", vec![0xfe], 254.0),
            ("int16", vec![0xfe, 0xff], -2.0),
            ("ushort", vec![1, 2], 513.0),
            ("int", vec![0xfe, 0xff, 0xff, 0xff], -2.0),
            ("uint32", vec![0, 0, 0, 0x80], 2_147_483_648.0),
            ("float", vec![0, 0, 0x80, 0xbf], -1.0),
            ("double", vec![0, 0, 0, 0, 0, 0, 0xf0, 0x3f], 1.0),
        ] {
            let header = format!(
                "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty {name} x\n\
                 property uchar y\nproperty uchar z\nend_header\n"
            );
            let all = [header.as_bytes(), &bytes, &[0, 0]].concat();
            assert_eq!(read(&all, false).expect("a point").positions[0].x, value, "{name}");
        }
    }

    #[test]
    fn what_is_no_cloud_is_refused() {
        let text = format!("{HEADER}{ROWS}");
        assert!(!is_cloud(text.replace("face 0", "face 1").as_bytes()));
        assert!(!is_cloud(b"plywood") && !is_cloud(b"ply\nelement vertex 1\n"));
        for (old, new, expected) in [
            ("double x", "double u", "vertices have no property x"),
            ("vertex 2", "vertices 2", "no element vertex"),
            ("float z", "quad z", "p.ply:7: `property quad z` is no statement"),
            ("end_header", "", "is no statement of a PLY header"),
            ("6 0 4 0 5 0", "6 0 4", "p.ply:19: this row of element vertex has no seen"),
            ("6 0 4 0 5 0", "6 0 inf 0 5 0", "p.ply:19: `inf` is not a finite number"),
            ("5 0\n", "5 -1\n", "the weight -1 is negative"),
            ("vertex 2", "vertex 99999999999", "ends in row 2 (from 0) of 99999999999"),
            ("vertex 2", "vertex 0", "no point stands"),
        ] {
            let message = refusal(text.replacen(old, new, 1).as_bytes());
            assert!(message.contains(expected), "{message}");
        }
        let bare = text.replace("weight", "w8");
        assert!(
            read(bare.as_bytes(), true).expect_err("refused").to_string().contains("no weights")
        );
        let endless =
            "ply\nformat binary_big_endian 1.0\nelement a 18446744073709551615\nend_header\n";
        assert!(refusal(endless.as_bytes()).contains("no element vertex"));
    }
}
