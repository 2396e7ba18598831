//! Point clouds as text: x y z and, where there is one, a weight, a point a line.
//!
//! Columns are apart by commas, semicolons, tabs or spaces; `#` starts a comment. A first line of
//! names says which columns are x, y, z and weight; others are passed over.

use std::io::BufRead;
use std::path::Path;

use glam::DVec3;

use crate::error::InputError;
use crate::io::input::{FilesRead, Input};
use crate::io::{coefficients, meshes};
use crate::mesh::Points;
use crate::{Error, Result, memory};

/// Returns a point file from a mesh by its extension: .xyz or .csv.
pub fn is_points(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    ["xyz", "csv"].iter().any(|e| e.eq_ignore_ascii_case(extension))
}

/// Whether a file that begins so holds points: its first line with more than a comment is a point,
/// or names the columns x, y and z, and nothing says that it is a mesh or coefficients.
pub fn recognise(head: &[u8]) -> bool {
    let length = head.len() as u64;
    if meshes::recognise(head, length).is_some()
        || coefficients::recognise_content(head, length).is_some()
    {
        return false;
    }
    first_line(head).is_some_and(|line| {
        if line.is_header() {
            return line.header().is_ok();
        }
        line.plain().and_then(|columns| line.point(&columns)).is_ok()
    })
}

/// Whether the first line of a file with more than a comment names the columns x, y and z.
pub(in crate::io) fn names_columns(head: &[u8]) -> bool {
    first_line(head).is_some_and(|line| line.is_header() && line.header().is_ok())
}

/// Returns the first line with more than a comment, if it is text.
fn first_line(head: &[u8]) -> Option<Line<'_>> {
    let mut lines = head.split(|b| *b == b'\n').map(|bytes| Line::new(Path::new(""), 1, bytes));
    let first = lines.find(|line| line.as_ref().map_or(true, |line| !line.fields.is_empty()));
    first.and_then(Result::ok)
}

/// Reads a point file.
///
/// # Errors
/// [`Error::Io`] when the file cannot be read; [`Error::Input`] with line and column of what is no
/// point.
pub fn read(path: &Path) -> Result<Points> {
    Ok(read_input(Input::open(path)?)?.0)
}

/// Reads a point file as [`read`] does, and says what was read.
///
/// # Errors
/// As [`read`].
pub fn read_input(mut input: Input) -> Result<(Points, FilesRead)> {
    let points = parse(input.path(), &mut input)?;
    Ok((points, input.finish()?))
}

/// Reads points from text; `path` is for messages.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, mut text: impl BufRead) -> Result<Points> {
    let mut points = Points::default();
    let mut columns: Option<Columns> = None;
    let (mut bytes, mut number) = (Vec::new(), 0);
    loop {
        bytes.clear();
        if memory::read_line(&mut text, &mut bytes).map_err(|e| Error::io(path, "read", e))? == 0 {
            break;
        }
        number += 1;
        let line = Line::new(path, number, &bytes)?;
        if line.fields.is_empty() {
            continue;
        }
        let layout = match &columns {
            Some(layout) => layout,
            None if line.is_header() => {
                columns = Some(line.header()?);
                continue;
            }
            None => columns.insert(line.plain()?),
        };
        let (position, weight) = line.point(layout)?;
        points.positions.push(position);
        points.weights.push(weight);
    }
    if points.positions.is_empty() {
        return Err(InputError::new(path, "no point stands in this file").help(WANTED).into());
    }
    Ok(points)
}

const WANTED: &str = "write a point a line: x y z, or x y z weight";

/// Where in a line the numbers are.
struct Columns {
    position: [usize; 3],
    weight: Option<usize>,
    /// How many fields each line has.
    count: usize,
}

/// One line without its comment, cut in fields with the byte where each starts.
struct Line<'a> {
    path: &'a Path,
    number: usize,
    text: &'a str,
    fields: Vec<(usize, &'a str)>,
}

impl<'a> Line<'a> {
    fn new(path: &'a Path, number: usize, bytes: &'a [u8]) -> Result<Self> {
        let text = str::from_utf8(bytes).map_err(|e| {
            let column = String::from_utf8_lossy(&bytes[..e.valid_up_to()]).chars().count() + 1;
            let message = "this is not text (UTF-8)";
            InputError::new(path, message).at(number, Some(column)).help(WANTED)
        })?;
        let text = text.trim_start_matches('\u{feff}').split('#').next().unwrap_or("");
        Ok(Self { path, number, text, fields: fields(text) })
    }

    fn error(&self, field: usize, message: String, help: &str) -> Error {
        let column = self.fields.get(field).map(|f| self.text[..f.0].chars().count() + 1);
        InputError::new(self.path, message).at(self.number, column).help(help).into()
    }

    /// Returns a line of names: none of its fields is a number.
    fn is_header(&self) -> bool {
        self.fields.iter().all(|(_, f)| f.parse::<f64>().is_err())
    }

    fn header(&self) -> Result<Columns> {
        let place = |names: &[&str]| {
            let is = |f: &&str| names.iter().any(|n| n.eq_ignore_ascii_case(f.trim_matches('"')));
            self.fields.iter().position(|(_, f)| is(f))
        };
        let need = |name: &str| {
            place(&[name]).ok_or_else(|| {
                let found: Vec<&str> = self.fields.iter().map(|f| f.1).collect();
                let message =
                    format!("no column is called {name}; there are: {}", found.join(", "));
                self.error(0, message, "name the columns x, y, z and, if there is one, weight")
            })
        };
        let position = [need("x")?, need("y")?, need("z")?];
        Ok(Columns { position, weight: place(&["weight", "w"]), count: self.fields.len() })
    }

    fn plain(&self) -> Result<Columns> {
        let count = self.fields.len();
        if count != 3 && count != 4 {
            return Err(self.error(0, format!("a line of {count} fields is no point"), WANTED));
        }
        Ok(Columns { position: [0, 1, 2], weight: (count == 4).then_some(3), count })
    }

    fn point(&self, columns: &Columns) -> Result<(DVec3, f64)> {
        let count = self.fields.len();
        if count != columns.count {
            let message = format!("{count} fields, where the lines before have {}", columns.count);
            return Err(self.error(0, message, "give each line the same columns"));
        }
        let [x, y, z] = columns.position.map(|i| self.number(i));
        let weight = columns.weight.map_or(Ok(1.0), |i| match self.number(i)? {
            w if w >= 0.0 => Ok(w),
            w => Err(self.error(i, format!("the weight {w} is negative"), "weights are 0 or more")),
        });
        Ok((DVec3::new(x?, y?, z?), weight?))
    }

    fn number(&self, field: usize) -> Result<f64> {
        let text = self.fields[field].1;
        text.parse()
            .ok()
            .filter(|x: &f64| x.is_finite())
            .ok_or_else(|| self.error(field, format!("`{text}` is not a finite number"), WANTED))
    }
}

/// Cuts a line at commas, semicolons and white space; two commas have an empty field between them.
fn fields(text: &str) -> Vec<(usize, &str)> {
    let text = text.trim_end();
    let strict = text.contains([',', ';']);
    let mut found = Vec::new();
    let mut start = 0;
    for (i, c) in text.char_indices().chain([(text.len(), ',')]) {
        let ends = if strict { c == ',' || c == ';' } else { c == ',' || c.is_whitespace() };
        if !ends {
            continue;
        }
        let field = &text[start..i];
        let value = field.trim();
        if strict || !value.is_empty() {
            let lead = field.len() - field.trim_start().len();
            found.push((start + lead, value));
        }
        start = i + c.len_utf8();
    }
    if text.trim().is_empty() { Vec::new() } else { found }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(text: &str) -> Result<Points> {
        parse(Path::new("p.xyz"), text.as_bytes())
    }

    fn refusal(text: &str) -> String {
        points(text).expect_err("refused").to_string()
    }

    #[test]
    fn files_without_points_are_refused() {
        for text in ["", "\n \n# nothing\n", "x,y,z\n"] {
            assert!(refusal(text).starts_with("p.xyz: no point stands"), "{text:?}");
        }
        assert!(read(Path::new("/no/such.xyz")).is_err());
        assert!(read(Path::new("/")).expect_err("a folder").to_string().contains("folder"));
    }

    #[test]
    fn plain_and_named_columns_say_the_same() {
        let expected = Points {
            positions: vec![DVec3::new(1.0, -2.0, 3e-1), DVec3::new(0.5, 0.0, 1.0)],
            weights: vec![2.0, 0.0],
        };
        for text in [
            "1 -2 0.3 2\n0.5\t0  1 0",
            "# cloud\r\n1, -2, 3e-1, 2 # first\r\n\r\n.5,0,1,0\r\n",
            "\u{feff}id;\"z\";Y;x;w\na;0.3;-2;1;2\nb;1;0;.5;0\n",
        ] {
            assert_eq!(points(text).expect("points"), expected, "{text}");
        }
        assert_eq!(points("1 2 3\n4 5 6").expect("points").weights, [1.0, 1.0]);
    }

    #[test]
    fn points_are_told_by_their_first_line() {
        for text in ["1 2 3\n", "# a scan\n\n1, 2, 3, 0.5\n", "id;x;y;z\n", "1 2 3"] {
            assert!(recognise(text.as_bytes()), "{text}");
        }
        for text in ["", "# nothing\n", "1 2\n", "1 2 3 4 5\n", "a,b,c\n", "v 1 2 3\n", "1 2 x\n"] {
            assert!(!recognise(text.as_bytes()), "{text}");
        }
        assert!(!recognise(b"\xff 1 2 3\n"));
    }

    #[test]
    fn line_of_very_many_numbers_is_read_in_one_pass() {
        let line = "1 ".repeat(1_000_000);
        assert!(refusal(&line).starts_with("p.xyz:1:1: a line of 1000000 fields is no point"));
        let commas = "\u{e9},".repeat(1_000_000);
        assert!(refusal(&commas).starts_with("p.xyz:1:1: no column is called x"));
    }

    #[test]
    fn what_is_no_point_is_located() {
        for (text, place) in [
            ("1 2\n", "p.xyz:1:1: a line of 2 fields"),
            ("1 2 3\n1 2 x\n", "p.xyz:2:5: `x` is not a finite number"),
            ("1 2 nan\n", "p.xyz:1:5: `nan`"),
            ("1,2,inf\n", "p.xyz:1:5: `inf`"),
            ("1,2,3,-1\n", "p.xyz:1:7: the weight -1 is negative"),
            ("1 2 3\n1 2 3 4\n", "p.xyz:2:1: 4 fields, where the lines before have 3"),
            ("1,,3\n", "p.xyz:1:3: `` is not"),
            ("a,b,c\n1,2,3\n", "p.xyz:1:1: no column is called x; there are: a, b, c"),
        ] {
            assert!(refusal(text).starts_with(place), "{}", refusal(text));
        }
        let error = parse(Path::new("p.xyz"), &b"1 2 3\n\xff\xfe\0"[..]).expect_err("binary");
        assert!(error.to_string().starts_with("p.xyz:2:1: this is not text"), "{error}");
    }
}
