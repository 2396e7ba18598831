//! Points as text: x y z and whatever else they have, a point a line.
//!
//! Columns are apart by semicolons, commas, or tabs and spaces; `#` and, at the beginning of a
//! line, `//` start a comment. A first line of names, in a comment or not, says which columns are
//! x, y, z and weight; those of the axes of an image (axis-0, axis-1, axis-2, as napari names them)
//! are x, y, z in this order. Other columns are passed over. A line of one whole number before
//! points says how many they are (.pts).

use std::path::Path;

use glam::DVec3;

use super::{MOST_COLUMNS, PointOptions, WANTED, no_weights, point};
use crate::error::InputError;
use crate::io::decimal::real;
use crate::io::source::Source;
use crate::mesh::Points;
use crate::{Error, Result};

/// What the columns of the coordinates may be called.
const AXES: [[&str; 2]; 3] = [["x", "axis-0"], ["y", "axis-1"], ["z", "axis-2"]];

/// What a column of weights may be called.
const WEIGHT: [&str; 2] = ["weight", "w"];

/// Whether a text that begins so holds points.
pub(super) fn recognise(head: &[u8]) -> bool {
    let mut reader = Reader::new(Path::new(""), PointOptions::default());
    for line in head.split(|b| *b == b'\n' || *b == b'\r') {
        match reader.take(line) {
            Ok(()) if reader.columns.is_some() => return true,
            Ok(()) => {}
            Err(_) => return false,
        }
    }
    false
}

/// Whether a text that begins so names the columns x, y and z.
pub(super) fn names_columns(head: &[u8]) -> bool {
    let lines = head.split(|b| *b == b'\n' || *b == b'\r').enumerate();
    let mut lines = lines.map(|(i, bytes)| Line::new(Path::new(""), i + 1, bytes));
    let first = lines.find(|line| line.as_ref().map_or(true, |line| !line.fields.is_empty()));
    first
        .and_then(Result::ok)
        .is_some_and(|line| line.is_header() && line.header(PointOptions::default()).is_ok())
}

/// Reads points, however many columns they have.
pub(super) fn parse(source: &mut Source, options: PointOptions) -> Result<Points> {
    let mut reader = Reader::new(source.path(), options);
    while source.next_line()? {
        reader.take(source.text())?;
    }
    reader.finish()
}

/// What the lines have told so far.
struct Reader<'a> {
    path: &'a Path,
    options: PointOptions,
    /// How many lines there were.
    lines: usize,
    columns: Option<Columns>,
    /// What a comment before the points calls the columns, if it means them.
    remarked: Option<Columns>,
    /// How many points must stand here, where that is said.
    announced: Option<u64>,
    points: Points,
}

impl<'a> Reader<'a> {
    fn new(path: &'a Path, options: PointOptions) -> Self {
        let points = Points::default();
        Self { path, options, lines: 0, columns: None, remarked: None, announced: None, points }
    }

    /// Takes a line.
    fn take(&mut self, bytes: &[u8]) -> Result<()> {
        self.lines += 1;
        let line = Line::new(self.path, self.lines, bytes)?;
        if line.fields.is_empty() {
            if self.columns.is_none() {
                let names = Line { fields: fields(line.comment), text: line.comment, ..line };
                self.remarked = names.header(self.options).ok().or(self.remarked.take());
            }
            return Ok(());
        }
        if let Some(count) = line.count().filter(|_| self.is_complete()) {
            self.announced = Some(self.announced.unwrap_or(0).saturating_add(count));
            return Ok(());
        }
        let columns = match &self.columns {
            Some(columns) => columns,
            None if line.is_header() => {
                self.columns = Some(line.header(self.options)?);
                return Ok(());
            }
            None => {
                let remarked = self.remarked.take().filter(|c| c.count == line.fields.len());
                let columns = remarked.map_or_else(|| line.plain(self.options), Ok)?;
                self.columns.insert(columns)
            }
        };
        let (position, weight) = line.point(columns)?;
        self.points.positions.push(position);
        self.points.weights.push(weight);
        Ok(())
    }

    /// Whether there are as many points as were announced, none where none were.
    fn is_complete(&self) -> bool {
        self.announced.unwrap_or(0) == self.points.positions.len() as u64
    }

    fn finish(self) -> Result<Points> {
        match self.announced {
            Some(count) if !self.is_complete() => {
                let found = self.points.positions.len();
                let message = format!("{count} points are announced, and {found} are here");
                let help = "part of the file is lost, or its first line is no number of points";
                Err(InputError::new(self.path, message).help(help).into())
            }
            _ => Ok(self.points),
        }
    }
}

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
    comment: &'a str,
    fields: Vec<(usize, &'a str)>,
}

impl<'a> Line<'a> {
    fn new(path: &'a Path, number: usize, bytes: &'a [u8]) -> Result<Self> {
        let text = str::from_utf8(bytes).map_err(|e| {
            let column = String::from_utf8_lossy(&bytes[..e.valid_up_to()]).chars().count() + 1;
            let message = "this is not text (UTF-8)";
            InputError::new(path, message).at(number, Some(column)).help(WANTED)
        })?;
        let text = text.trim_start_matches('\u{feff}');
        let (text, comment) = match text.trim_start().strip_prefix("//") {
            Some(comment) => ("", comment),
            None => text.split_once('#').unwrap_or((text, "")),
        };
        Ok(Self { path, number, text, comment, fields: fields(text) })
    }

    fn error(&self, field: usize, message: String, help: &str) -> Error {
        let column = self.fields.get(field).map(|f| self.text[..f.0].chars().count() + 1);
        InputError::new(self.path, message).at(self.number, column).help(help).into()
    }

    /// Returns the number that stands alone on this line.
    fn count(&self) -> Option<u64> {
        let [(_, count)] = self.fields[..] else { return None };
        count.parse().ok()
    }

    /// Returns a line of names: none of its fields is a number.
    fn is_header(&self) -> bool {
        self.fields.iter().all(|(_, f)| real(f).is_none())
    }

    fn header(&self, options: PointOptions) -> Result<Columns> {
        let place = |names: &[&str]| {
            let is = |f: &&str| names.iter().any(|n| n.eq_ignore_ascii_case(f.trim_matches('"')));
            self.fields.iter().position(|(_, f)| is(f))
        };
        let need = |names: [&str; 2]| {
            place(&names).ok_or_else(|| {
                let found: Vec<&str> = self.fields.iter().map(|f| f.1).collect();
                let message =
                    format!("no column is called {}; there are: {}", names[0], found.join(", "));
                self.error(0, message, "name the columns x, y, z and, if there is one, weight")
            })
        };
        let position = [need(AXES[0])?, need(AXES[1])?, need(AXES[2])?];
        if let Some(fourth) = place(&["axis-3"]) {
            let help = "keep the three columns of space, and call them x, y, z";
            return Err(self.error(fourth, "these are points of four axes".to_owned(), help));
        }
        let weight = place(&WEIGHT);
        if options.weights && weight.is_none() {
            let error = no_weights(self.path, "no column is called weight");
            return Err(error.at(self.number, None).into());
        }
        Ok(Columns { position, weight, count: self.fields.len() })
    }

    fn plain(&self, options: PointOptions) -> Result<Columns> {
        let count = self.fields.len();
        if !(3..=MOST_COLUMNS).contains(&count) {
            return Err(self.error(0, format!("a line of {count} fields is no point"), WANTED));
        }
        if options.weights && count < 4 {
            let error = no_weights(self.path, "the lines have three columns");
            return Err(error.at(self.number, None).into());
        }
        Ok(Columns { position: [0, 1, 2], weight: options.weights.then_some(3), count })
    }

    fn point(&self, columns: &Columns) -> Result<(DVec3, f64)> {
        let count = self.fields.len();
        if count != columns.count {
            let message = format!("{count} fields, where the lines before have {}", columns.count);
            return Err(self.error(0, message, "give each line the same columns"));
        }
        let [x, y, z] = columns.position.map(|i| self.number(i));
        let weight = columns.weight.map_or(Ok(1.0), |i| self.number(i))?;
        point([x?, y?, z?], weight).map_err(|(i, message)| {
            let field = columns.position.iter().copied().chain(columns.weight).nth(i);
            self.error(field.unwrap_or(0), message, WANTED)
        })
    }

    fn number(&self, field: usize) -> Result<f64> {
        let text = self.fields[field].1;
        real(text).filter(|x| x.is_finite()).ok_or_else(|| {
            let help = if text.contains(',') { "write a decimal point, no comma" } else { WANTED };
            self.error(field, format!("`{text}` is not a finite number"), help)
        })
    }
}

/// Cuts a line at semicolons, else at commas, else at white space; two commas have an empty field
/// between them.
fn fields(text: &str) -> Vec<(usize, &str)> {
    let text = text.trim_end();
    let separator = [';', ','].into_iter().find(|c| text.contains(*c));
    let mut found = Vec::new();
    let mut start = 0;
    for (i, c) in text.char_indices().chain([(text.len(), separator.unwrap_or(' '))]) {
        if !separator.map_or_else(|| c.is_whitespace(), |separator| c == separator) {
            continue;
        }
        let field = &text[start..i];
        let value = field.trim();
        if separator.is_some() || !value.is_empty() {
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
        super::super::parse(Path::new("p.xyz"), text.as_bytes(), PointOptions::default())
    }

    fn weighted(text: &str) -> Result<Points> {
        super::super::parse(Path::new("p.xyz"), text.as_bytes(), PointOptions { weights: true })
    }

    fn refusal(text: &str) -> String {
        points(text).expect_err("refused").to_string()
    }

    #[test]
    fn files_without_points_are_refused() {
        for text in ["", "\n \n# nothing\n", "x,y,z\n"] {
            assert!(refusal(text).starts_with("p.xyz: no point stands"), "{text:?}");
        }
        let read = |path| super::super::read(Path::new(path), PointOptions::default());
        assert!(read("/no/such.xyz").is_err());
        assert!(read("/").expect_err("a folder").to_string().contains("folder"));
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
            assert_eq!(weighted(text).expect("points"), expected, "{text}");
        }
        assert!(weighted("1 2 3\n").expect_err("none").to_string().contains("no weights here"));
        assert!(
            weighted("x y z i\n1 2 3 4\n").expect_err("none").to_string().contains("p.xyz:1: ")
        );
        assert_eq!(points("1 2 3\n4 5 6").expect("points").weights, [1.0, 1.0]);
    }

    #[test]
    fn what_stands_beside_the_coordinates_is_passed_over() {
        let expected = [DVec3::new(1.0, -2.0, 0.3), DVec3::new(0.5, 0.0, 1.0)];
        for text in [
            "1 -2 0.3 40\n.5 0 1 17\n",
            "1 -2 0.3 0 0 1\n.5 0 1 nan nan nan\n",
            "2\n1 -2 0.3 -1200 255 0 9\n.5 0 1 7 1 2 3\n",
            "1\n1 -2 0.3\n1\n.5 0 1\n",
            "//X,Y,Z,Rf,Gf,Bf,Nx,Ny,Nz\n1.0D+00,-2,3.0d-1,0,0,0,0,0,1\n.5,0,1,0,0,0,0,0,1\n",
            "# z y X label\n0.3 -2 1 a\n1 0 .5 b\n",
            "# x y z\n1 -2 0.3 0 0 1\n.5 0 1 0 0 1\n",
            "index,axis-0,axis-1,axis-2\n0,1,-2,0.3\n1,.5,0,1\n",
            "\"AXIS-2\";\"axis-1\";\"Axis-0\"\r0.3;-2;1\r1;0;.5\r",
            "//a cloud\n1\t-2\t0.3\ttree\n.5\t0\t1\t-\n",
        ] {
            let found = points(text).expect("points");
            assert_eq!(
                (&found.positions[..], &found.weights[..]),
                (&expected[..], &[1.0; 2][..]),
                "{text}"
            );
        }
        assert_eq!(points("z,W,y,x\n3,5,2,1\n").expect("points").weights, [5.0]);
    }

    #[test]
    fn points_are_told_by_their_first_line() {
        for text in
            ["1 2 3\n", "# a scan\n\n1, 2, 3, 0.5\n", "id;x;y;z\n", "1 2 3", "9\r\n1 2 3 4 5\r\n"]
        {
            assert!(recognise(text.as_bytes()), "{text}");
        }
        for text in ["", "# nothing\n", "1 2\n", "9\n", "a,b,c\n", "v 1 2 3\n", "1 2 x\n"] {
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
            ("x,y,z,w\n1,2,3,-1\n", "p.xyz:2:7: the weight -1 is negative"),
            ("1,5;2;3\n", "p.xyz:1:1: `1,5` is not a finite number\n  help: write a decimal point"),
            ("3\n1 2 3\n", "p.xyz: 3 points are announced, and 1 are here"),
            ("1 2 3\n4\n", "p.xyz:2:1: 1 fields"),
            ("axis-0,axis-1,axis-2,axis-3\n", "p.xyz:1:22: these are points of four axes"),
            ("1 2 3\n1 2 3 4\n", "p.xyz:2:1: 4 fields, where the lines before have 3"),
            ("1,,3\n", "p.xyz:1:3: `` is not"),
            ("a,b,c\n1,2,3\n", "p.xyz:1:1: no column is called x; there are: a, b, c"),
        ] {
            assert!(refusal(text).starts_with(place), "{}", refusal(text));
        }
        let binary = b"1 2 3\n\xff\xfe\0";
        let error = super::super::parse(Path::new("p.xyz"), binary, PointOptions::default());
        let error = error.expect_err("binary");
        assert!(error.to_string().starts_with("p.xyz:2:1: this is not text"), "{error}");
    }
}
