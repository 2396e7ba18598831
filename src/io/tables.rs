//! Tables as CSV and as JSON: a header, rows of texts and numbers, every number with all its
//! digits.

use std::fmt;
use std::path::Path;

use serde::ser::{Serialize, SerializeMap, SerializeSeq, Serializer};

use super::output::{Kind, SOFTWARE};
use crate::error::InputError;
use crate::{Error, Result};

/// Holds one cell of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A text.
    Text(String),
    /// A number, written with as many digits as bring it back to the last bit; NaN and infinities
    /// are `null` in JSON.
    Number(f64),
    /// A whole number: a degree, a count.
    Whole(u64),
    /// Nothing: an empty field in CSV, `null` in JSON.
    Empty,
}

impl Cell {
    /// Returns the number that it holds.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Whole(number) => Some(*number as f64),
            Self::Text(_) | Self::Empty => None,
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<usize> for Cell {
    fn from(number: usize) -> Self {
        Self::Whole(number as u64)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Empty, Into::into)
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            // Unlike Display, Debug turns to exponents where plain digits would be hundreds.
            Self::Number(number) => write!(f, "{number:?}"),
            Self::Whole(number) => write!(f, "{number}"),
            Self::Empty => Ok(()),
        }
    }
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Text(text) => serializer.serialize_str(text),
            Self::Number(number) => serializer.serialize_f64(*number),
            Self::Whole(number) => serializer.serialize_u64(*number),
            Self::Empty => serializer.serialize_none(),
        }
    }
}

/// Holds a header and rows of as many cells.
///
/// ```
/// use harmolux::io::tables::Table;
///
/// let mut table = Table::new(["degree", "energy"]);
/// table.push([0_usize.into(), 0.1.into()]);
/// assert_eq!(table.to_csv()?, b"degree,energy\n0,0.1\n");
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    header: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// Starts a table without rows. Column names carry the unit where there is one
    /// (`illuminance_lx`) and differ from each other.
    ///
    /// # Panics
    /// Without columns, or when two have one name: a programmer's error.
    pub fn new<S: Into<String>>(header: impl IntoIterator<Item = S>) -> Self {
        let header: Vec<String> = header.into_iter().map(Into::into).collect();
        let mut names = header.clone();
        names.sort();
        names.dedup();
        assert!(!names.is_empty() && names.len() == header.len(), "columns need distinct names");
        Self { header, rows: Vec::new() }
    }

    /// Adds a row.
    ///
    /// # Panics
    /// When the number of cells is not that of the columns: a programmer's error.
    pub fn push(&mut self, row: impl IntoIterator<Item = Cell>) {
        let row: Vec<Cell> = row.into_iter().collect();
        assert_eq!(row.len(), self.header.len(), "a row needs one cell for each column");
        self.rows.push(row);
    }

    /// Returns the column names.
    pub fn header(&self) -> &[String] {
        &self.header
    }

    /// Returns the rows.
    pub fn rows(&self) -> &[Vec<Cell>] {
        &self.rows
    }

    /// Describes the CSV file of this table for [`Output::open`](super::output::Output::open): one
    /// with the same header row is ours.
    ///
    /// # Errors
    /// As [`Table::to_csv`].
    pub fn csv_kind(&self) -> Result<Kind> {
        let empty = Self { header: self.header.clone(), rows: Vec::new() };
        Ok(Kind::csv(empty.to_csv()?))
    }

    /// Writes header and rows as CSV (RFC 4180 quoting, line feeds, a point as decimal sign).
    ///
    /// # Errors
    /// [`Error::Numeric`] with the writer's complaint; none is known.
    pub fn to_csv(&self) -> Result<Vec<u8>> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&self.header).map_err(|e| failed(&e))?;
        for row in &self.rows {
            writer.write_record(row.iter().map(Cell::to_string)).map_err(|e| failed(&e))?;
        }
        writer.into_inner().map_err(|e| failed(&e.error()))
    }

    /// Writes one row of such a table as its line of CSV.
    ///
    /// # Errors
    /// As [`Table::to_csv`].
    pub fn csv_line(row: &[Cell]) -> Result<Vec<u8>> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(row.iter().map(Cell::to_string)).map_err(|e| failed(&e))?;
        writer.into_inner().map_err(|e| failed(&e.error()))
    }

    /// Adds the rows of a CSV file of such a table; the columns named `texts` hold texts, the
    /// others numbers. A last line without its end was cut off and is left out. `path` is for
    /// errors.
    ///
    /// # Errors
    /// [`Error::Input`] for a line that is no such row; then no row is added.
    pub fn add_csv(&mut self, path: &Path, bytes: &[u8], texts: &[&str]) -> Result<()> {
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        let mut reader = csv::Reader::from_reader(&bytes[..whole]);
        let header = self.header.clone();
        let cell = |(name, text): (&String, &str)| match text {
            "" => Cell::Empty,
            text if texts.contains(&name.as_str()) => text.into(),
            text => text
                .parse()
                .map(Cell::Whole)
                .or_else(|_| text.parse().map(Cell::Number))
                .unwrap_or_else(|_| text.into()),
        };
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|e| no_row(path, bytes, header.len(), &e))?;
            rows.push(header.iter().zip(&record).map(cell).collect());
        }
        self.rows.append(&mut rows);
        Ok(())
    }

    /// Leaves out rows.
    pub fn retain(&mut self, keep: impl FnMut(&Vec<Cell>) -> bool) {
        self.rows.retain(keep);
    }

    /// Writes `{"software": ..., "rows": [{column: value, ...}, ...]}`, columns in their order.
    ///
    /// # Errors
    /// [`Error::Numeric`] with the writer's complaint; none is known.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        let mut bytes = serde_json::to_vec_pretty(self)
            .map_err(|e| Error::Numeric(format!("the JSON writer failed: {e}")))?;
        bytes.push(b'\n');
        Ok(bytes)
    }
}

fn no_row(path: &Path, bytes: &[u8], columns: usize, e: &csv::Error) -> Error {
    let why = format!("this is no row of {columns} columns in UTF-8");
    InputError::new(path, why).at(line_of(bytes, e.position()), None).into()
}

/// Returns the line of a record of CSV, from 1. Its reader counts a line at its line feed, which it
/// takes with the next record where a carriage return comes before.
pub(crate) fn line_of(bytes: &[u8], position: Option<&csv::Position>) -> usize {
    let Some(position) = position else { return 1 };
    let at = position.byte() as usize;
    let is_between = at > 0 && bytes.get(at - 1..=at) == Some(b"\r\n".as_slice());
    position.line() as usize + usize::from(is_between)
}

fn failed(e: &dyn fmt::Display) -> Error {
    Error::Numeric(format!("the CSV writer failed: {e}"))
}

impl Serialize for Table {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(2))?;
        map.serialize_entry("software", SOFTWARE)?;
        map.serialize_entry("rows", &Rows(self))?;
        map.end()
    }
}

struct Rows<'a>(&'a Table);

impl Serialize for Rows<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut rows = serializer.serialize_seq(Some(self.0.rows.len()))?;
        for row in &self.0.rows {
            rows.serialize_element(&Row(&self.0.header, row))?;
        }
        rows.end()
    }
}

struct Row<'a>(&'a [String], &'a [Cell]);

impl Serialize for Row<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().zip(self.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::output::Output;

    fn table() -> Table {
        let mut table = Table::new(["zone", "degree", "energy"]);
        table.push(["a \"b\", c".into(), 7_usize.into(), (1.0 / 3.0).into()]);
        table.push([Cell::Empty, 8_usize.into(), 1e300.into()]);
        table.push(["é".into(), 9_usize.into(), f64::NAN.into()]);
        table
    }

    #[test]
    fn table_without_rows_is_its_header() {
        let empty = Table::new(["degree"]);
        assert_eq!(empty.to_csv().expect("written"), b"degree\n");
        let json: serde_json::Value =
            serde_json::from_slice(&empty.to_json().expect("written")).expect("JSON");
        assert_eq!(json["rows"], serde_json::json!([]));
    }

    #[test]
    fn csv_quotes_what_must_be_quoted_and_keeps_every_digit() {
        let csv = String::from_utf8(table().to_csv().expect("written")).expect("UTF-8");
        assert_eq!(
            csv,
            "zone,degree,energy\n\"a \"\"b\"\", c\",7,0.3333333333333333\n,8,1e300\né,9,NaN\n"
        );
    }

    #[test]
    fn csv_comes_back_to_the_last_bit_without_what_was_cut_off() {
        let table = table();
        let mut csv = table.to_csv().expect("written");
        csv.extend(Table::csv_line(&table.rows()[0]).expect("written"));
        csv.extend(b"cut,7,0.33");
        let mut read = Table::new(["zone", "degree", "energy"]);
        let path = Path::new("t.csv");
        read.add_csv(path, &csv, &["zone"]).expect("rows");
        assert_eq!(read.rows().len(), 4);
        assert_eq!(read.rows()[3], table.rows()[0]);
        assert_eq!(format!("{:?}", &read.rows()[..3]), format!("{:?}", table.rows()));
    }

    #[test]
    fn line_that_is_no_row_is_told_and_nothing_is_taken() {
        for bad in [&b"1,2"[..], b"1,2,3,4", b"\xe9,2,3"] {
            let csv = [b"zone,degree,energy\n1,2,3\n", bad, b"\n1,2,3\n"].concat();
            let mut read = Table::new(["zone", "degree", "energy"]);
            let error = read.add_csv(Path::new("t.csv"), &csv, &["zone"]).expect_err("no row");
            assert_eq!(error.to_string(), "t.csv:3: this is no row of 3 columns in UTF-8");
            assert!(read.rows().is_empty());
        }
    }

    #[test]
    fn json_has_the_same_rows_with_columns_in_order() {
        let bytes = table().to_json().expect("written");
        let json: serde_json::Value = serde_json::from_slice(&bytes).expect("JSON");
        assert_eq!(json["software"], SOFTWARE);
        assert_eq!(json["rows"][0]["zone"], "a \"b\", c");
        assert_eq!(json["rows"][0]["energy"].as_f64(), Some(1.0 / 3.0));
        assert_eq!(json["rows"][1]["zone"], serde_json::Value::Null);
        assert_eq!(json["rows"][2]["energy"], serde_json::Value::Null);
        let text = String::from_utf8(bytes).expect("UTF-8");
        let place = |name: &str| text.find(name).expect("there");
        assert!(place("zone") < place("degree") && place("degree") < place("energy"));
    }

    #[test]
    fn both_files_are_known_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let table = table();
        let files = [
            ("t.csv", table.csv_kind().expect("a kind"), table.to_csv().expect("written")),
            ("t.json", Kind::JSON, table.to_json().expect("written")),
        ];
        for (name, kind, bytes) in files {
            for _ in 0..2 {
                let output = Output::open_again(&folder.path().join(name), &kind, false);
                output.expect("free, then ours").write(&bytes).expect("written");
            }
        }
    }

    #[test]
    #[should_panic(expected = "one cell for each column")]
    fn short_row_is_a_programming_error() {
        Table::new(["a", "b"]).push([Cell::Empty]);
    }
}
