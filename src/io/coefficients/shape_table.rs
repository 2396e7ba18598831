//! Tables of shapes as CSV, a row a shape, in two layouts: ours, and that of aics-shparam.
//!
//! Ours has the columns `name`, `normalisation`, `csphase`, `centre_x_m`, `centre_y_m`,
//! `centre_z_m` and then, degree by degree, order by order, `C2_1_m` and (but for order 0) `S2_1_m`.
//! Each row says its own convention; 4pi without phase is written, in which the distance of two
//! rows is the RMS radial distance of the shapes. The other layout is in `aics_csv`. In both other
//! columns are passed over; `name`, or else the first that holds no coefficient, names the row.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use csv::StringRecord;
use glam::DVec3;

use super::rows::{agreed, coefficient, collect};
use super::{ReadOptions, SeriesFormat, aics_csv};
use crate::error::{Advice, InputError};
use crate::fit::Shape;
use crate::io::output::SOFTWARE;
use crate::io::tables::{Cell, Table, line_of};
use crate::sh::{Convention, Normalisation, places as places_of_series};
use crate::{Error, Result};

/// The first columns of our layout.
const FIRST: [&str; 6] =
    ["name", "normalisation", "csphase", "centre_x_m", "centre_y_m", "centre_z_m"];

/// Degree, order, and whether it is a sine.
pub(super) type Place = (usize, usize, bool);

/// Returns the names of the columns of a table of this layout and degree; the first is `name`.
pub fn columns(format: SeriesFormat, lmax: usize) -> Vec<String> {
    let first = if format == SeriesFormat::Aics { &FIRST[..1] } else { &FIRST };
    let coefficients = places(format, lmax).into_iter().map(|place| column(format, place));
    first.iter().map(|&name| name.to_owned()).chain(coefficients).collect()
}

/// Returns the row of a shape in such a table, higher degrees left out; every number with all its
/// digits.
///
/// # Errors
/// [`Error::Numeric`] as [`Convention::export`]: never, for the normalisation that is written.
pub fn row(format: SeriesFormat, lmax: usize, name: &str, shape: &Shape) -> Result<Vec<Cell>> {
    let mut row = vec![Cell::from(name)];
    let convention = format.convention().unwrap_or_default();
    if format != SeriesFormat::Aics {
        let phase = convention.phase.csphase().to_string();
        row.extend([convention.normalisation.name().into(), phase.into()]);
        row.extend(shape.centre.to_array().map(Cell::Number));
    }
    for (l, m, sine) in places(format, lmax) {
        let pair = if m > l {
            (0.0, 0.0)
        } else {
            convention.export(l, m, shape.coefficients.get(l, m))?
        };
        row.push(Cell::Number(if sine { pair.1 } else { pair.0 }));
    }
    Ok(row)
}

/// Writes a table of one row, which is named after the source. The first column of aics-shparam's
/// layout is named after this program.
///
/// # Errors
/// As [`row`].
pub fn write(shape: &Shape, format: SeriesFormat) -> Result<Vec<u8>> {
    let lmax = shape.coefficients.lmax();
    let mut header = columns(format, lmax);
    if format == SeriesFormat::Aics {
        SOFTWARE.clone_into(&mut header[0]);
    }
    let source = shape.source.as_ref().map_or("", |source| &source.name);
    let mut table = Table::new(header);
    table.push(row(format, lmax, source, shape)?);
    table.to_csv()
}

/// Reads one row of a table: the only one, or the one that is asked for. Memory is bound by the
/// size of the table.
///
/// # Errors
/// [`Error::Input`] with the line: no UTF-8, rows of different lengths, no such columns or those of
/// several shapes, a column that is missing, double, or not 0 where m > l, several rows of which
/// none is named, a row that is not there, a cell that is no finite number, a normalisation that is
/// not said.
pub fn parse(
    path: &Path,
    bytes: &[u8],
    format: SeriesFormat,
    options: &ReadOptions,
) -> Result<Shape> {
    let mut reader = csv::Reader::from_reader(bytes);
    let header = Header::read(path, bytes, format, options, &mut reader)?;
    let record = choose((path, bytes), &mut reader, options.row)?;
    Ok(header.shape(&record, options.row.unwrap_or(1))?.1)
}

/// Reads all rows of a table, each with its name; one without is called by its number.
///
/// # Errors
/// As [`parse`].
pub fn parse_all(
    path: &Path,
    bytes: &[u8],
    format: SeriesFormat,
    options: &ReadOptions,
) -> Result<Vec<(String, Shape)>> {
    let mut reader = csv::Reader::from_reader(bytes);
    let header = Header::read(path, bytes, format, options, &mut reader)?;
    let rows = reader
        .records()
        .enumerate()
        .map(|(i, record)| header.shape(&record.map_err(|e| broken(path, bytes, &e))?, i + 1));
    let rows: Vec<_> = rows.collect::<Result<_>>()?;
    if rows.is_empty() {
        return Err(InputError::new(path, "the table has no rows").into());
    }
    Ok(rows)
}

/// Returns the convention of the row of our layout that [`parse`] reads.
pub(super) fn convention(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Convention> {
    let mut reader = csv::Reader::from_reader(bytes);
    let header = Header::read(path, bytes, SeriesFormat::Table, options, &mut reader)?;
    header.convention(&choose((path, bytes), &mut reader, options.row)?)
}

/// Whether a text begins with the header of our layout.
pub(super) fn is_table(text: &str) -> bool {
    text.lines().next().is_some_and(|header| header.split(',').any(|name| name == "C0_0_m"))
}

fn places(format: SeriesFormat, lmax: usize) -> Vec<Place> {
    if format == SeriesFormat::Aics {
        return aics_csv::places(lmax);
    }
    places_of_series(lmax).collect()
}

fn column(format: SeriesFormat, place: Place) -> String {
    if format == SeriesFormat::Aics {
        return aics_csv::column(place);
    }
    let (l, m, sine) = place;
    format!("{}{l}_{m}_m", if sine { 'S' } else { 'C' })
}

/// Reads the name of a column of our layout.
fn own_place(name: &str) -> Option<(&str, Option<Place>)> {
    let text = name.strip_suffix("_m")?;
    let sine = text.starts_with('S');
    let (l, m) = text.strip_prefix(['C', 'S'])?.split_once('_')?;
    Some(("", Some((l.parse().ok()?, m.parse().ok()?, sine))))
}

/// What the header of a table says, and what the reader was told of it.
struct Header<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    format: SeriesFormat,
    told: Option<Convention>,
    names: StringRecord,
    /// The column that names the rows.
    name: Option<usize>,
    columns: BTreeMap<Place, usize>,
    lmax: usize,
}

impl<'a> Header<'a> {
    fn read(
        path: &'a Path,
        bytes: &'a [u8],
        format: SeriesFormat,
        options: &ReadOptions,
        reader: &mut csv::Reader<&[u8]>,
    ) -> Result<Self> {
        super::rows::ended(path, bytes)?;
        if format == SeriesFormat::Table && options.unit.is_some_and(|metres| metres != 1.0) {
            let message = "the columns say that their unit is the metre";
            return Err(InputError::new(path, message).advise(Advice::LeaveOutUnit).into());
        }
        let names = reader.headers().map_err(|e| broken(path, bytes, &e))?.clone();
        let wrong = |message: String| InputError::new(path, message).at(1, None);
        let columns = places_of(format, &names).map_err(wrong)?;
        let lmax = degree(format, &columns).map_err(wrong)?;
        let told = options.convention;
        let name = name_column(&names, &columns);
        let header = Self { path, bytes, format, told, names, name, columns, lmax };
        header.check_centre().map_err(|message| InputError::new(path, message).at(1, None))?;
        Ok(header)
    }

    /// Reads a row, `number` from 1, and its name.
    fn shape(&self, record: &StringRecord, number: usize) -> Result<(String, Shape)> {
        let line = line_of(self.bytes, record.position());
        let values = self.values(record, number, line)?;
        let value =
            |l: usize, m: usize, sine: bool| values.get(&(l, m, sine)).copied().unwrap_or(0.0);
        let pair = |l: usize, m: usize| (value(l, m, false), value(l, m, true));
        let convention = self.convention(record);
        let series = convention.and_then(|found| collect(self.path, self.lmax, found, pair));
        let centre = self.centre(record, number, line)?;
        let shape = Shape { centre, ..Shape::new(series.map_err(|e| on_line(e, line))?) };
        let name = self.name.and_then(|i| record.get(i)).unwrap_or_default().trim();
        let name = if name.is_empty() { format!("row {number}") } else { name.to_owned() };
        Ok((name, shape))
    }

    fn values(
        &self,
        record: &StringRecord,
        number: usize,
        line: usize,
    ) -> Result<BTreeMap<Place, f64>> {
        let value = |(&place, &column): (&Place, &usize)| {
            let value = self.number(record, column, number, line)?;
            if place.1 > place.0 && value != 0.0 {
                let (l, m, _) = place;
                let message = format!(
                    "degree {l}, order {m} is {value:e}: the order cannot exceed the degree"
                );
                return Err(InputError::new(self.path, message).at(line, None).into());
            }
            Ok((place, value))
        };
        self.columns.iter().map(value).collect()
    }

    /// Reads the number in a column, or says where what else stands.
    fn number(
        &self,
        record: &StringRecord,
        column: usize,
        number: usize,
        line: usize,
    ) -> Result<f64> {
        coefficient(record.get(column).unwrap_or_default().trim()).map_err(|message| {
            let name = self.names.get(column).unwrap_or_default();
            let message = format!("row {number}, column `{name}`: {message}");
            InputError::new(self.path, message).at(line, None).into()
        })
    }

    fn place_of(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|found| found.trim() == name)
    }

    fn convention(&self, record: &StringRecord) -> Result<Convention> {
        if let fixed @ Some(_) = self.format.convention() {
            return agreed(self.path, "a table of aics-shparam is always", fixed, self.told);
        }
        let cell = |name| Some(record.get(self.place_of(name)?)?.trim()).filter(|c| !c.is_empty());
        let wrong = |e: Error| InputError::new(self.path, e.to_string());
        let said = cell(FIRST[1]).map(str::parse::<Normalisation>).transpose().map_err(wrong)?;
        let phase = cell(FIRST[2]).map(str::parse).transpose().map_err(wrong)?;
        // What a row does not say, it is to be told.
        let phase = phase.or(self.told.map(|told| told.phase));
        let stated = said.zip(phase);
        let stated = stated.map(|(normalisation, phase)| Convention { normalisation, phase });
        agreed(self.path, "the row says", stated, self.told)
    }

    /// Makes sure that there are all columns of the centre, or none.
    fn check_centre(&self) -> Result<(), String> {
        let lacks =
            |name: &&str| self.format == SeriesFormat::Table && self.place_of(name).is_none();
        let missing: Vec<&str> = FIRST[3..].iter().copied().filter(lacks).collect();
        match missing.first() {
            Some(name) if missing.len() < 3 => Err(format!("the column `{name}` is missing")),
            _ => Ok(()),
        }
    }

    /// Reads the centre; the origin where there are no columns of one.
    fn centre(&self, record: &StringRecord, number: usize, line: usize) -> Result<DVec3> {
        if self.format == SeriesFormat::Aics {
            return Ok(DVec3::ZERO);
        }
        let mut centre = DVec3::ZERO;
        for (axis, name) in FIRST[3..].iter().enumerate() {
            if let Some(column) = self.place_of(name) {
                centre[axis] = self.number(record, column, number, line)?;
            }
        }
        Ok(centre)
    }
}

/// Says on which line an error is.
fn on_line(error: Error, line: usize) -> Error {
    let Error::Input(mut input) = error else { return error };
    input.line = input.line.or(Some(line));
    Error::Input(input)
}

/// Finds the columns of coefficients.
fn places_of(
    format: SeriesFormat,
    header: &StringRecord,
) -> Result<BTreeMap<Place, usize>, String> {
    let place = if format == SeriesFormat::Aics { aics_csv::place } else { own_place };
    let mut columns = BTreeMap::new();
    let mut prefixes = BTreeSet::new();
    for (i, name) in header.iter().enumerate() {
        let Some((prefix, place)) = place(name.trim()) else { continue };
        let place = place.ok_or_else(|| format!("`{name}` is no column of coefficients"))?;
        prefixes.insert(prefix.to_owned());
        if columns.insert(place, i).is_some() && prefixes.len() == 1 {
            return Err(format!("the column `{name}` stands here twice"));
        }
    }
    if prefixes.len() > 1 {
        let names = prefixes.iter().map(|p| format!("`{p}{}`", column(format, (0, 0, false))));
        return Err(format!(
            "the columns of several shapes stand here ({}): keep those of one",
            names.collect::<Vec<_>>().join(", ")
        ));
    }
    Ok(columns)
}

/// Finds the column `name`, or else the first that says nothing else.
fn name_column(header: &StringRecord, columns: &BTreeMap<Place, usize>) -> Option<usize> {
    let used: BTreeSet<usize> = columns.values().copied().collect();
    let is_free = |i: &usize| !used.contains(i) && !FIRST[1..].contains(&header[*i].trim());
    let named = header.iter().position(|name| name.trim() == FIRST[0]);
    named.or_else(|| (0..header.len()).find(is_free))
}

/// Finds lmax, and checks that every coefficient has its column (a sine of order 0 need not).
fn degree(format: SeriesFormat, columns: &BTreeMap<Place, usize>) -> Result<usize, String> {
    let (&(lmax, ..), _) = columns.last_key_value().ok_or_else(|| {
        let first = column(format, (0, 0, false));
        format!("this is no table of shapes: none has the column `{first}`")
    })?;
    // The columns that are there bound this search, whatever degree one of them names.
    match places_of_series(lmax).find(|place| !columns.contains_key(place)) {
        Some(place) => Err(format!("the column `{}` is missing", column(format, place))),
        None => Ok(lmax),
    }
}

/// Reads the row that is asked for, or the only one.
fn choose(
    (path, bytes): (&Path, &[u8]),
    reader: &mut csv::Reader<&[u8]>,
    number: Option<usize>,
) -> Result<StringRecord> {
    let mut chosen = None;
    let mut count = 0;
    for record in reader.records() {
        let record = record.map_err(|e| broken(path, bytes, &e))?;
        count += 1;
        if number.is_none_or(|number| number == count) {
            chosen = Some(record);
        }
    }
    let wrong = |message: String| InputError::new(path, message);
    match (chosen, number) {
        (Some(_), None) if count > 1 => {
            Err(wrong(format!("the table has {count} rows, each a shape"))
                .advise(Advice::ChooseRow)
                .into())
        }
        (Some(row), _) => Ok(row),
        (None, Some(number)) => {
            Err(wrong(format!("there is no row {number}: the table has {count}")).into())
        }
        (None, None) => Err(wrong("the table has no rows".to_owned()).into()),
    }
}

fn broken(path: &Path, bytes: &[u8], error: &csv::Error) -> Error {
    let message = match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("{len} cells, where the header has {expected_len}")
        }
        csv::ErrorKind::Utf8 { .. } => "this is not UTF-8 text, so no table".to_owned(),
        _ => error.to_string(),
    };
    let mut input = InputError::new(path, message);
    input.line = Some(line_of(bytes, error.position()));
    input.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sh::{Coefficients, CondonShortley};

    const TABLE: SeriesFormat = SeriesFormat::Table;

    fn read(text: &str, options: &ReadOptions) -> Result<Vec<(String, Shape)>> {
        parse_all(Path::new("a.csv"), text.as_bytes(), TABLE, options)
    }

    fn sample(k: f64) -> Shape {
        let mut c = Coefficients::zeros(2);
        c.set(0, 0, k, 0.0);
        c.set(1, 1, 0.1 * k, -0.2);
        c.set(2, 2, 1.0 / 3.0, 0.7 / k);
        Shape { centre: DVec3::new(1.0, -2.0, 1.0 / k), ..Shape::new(c) }
    }

    #[test]
    fn rows_written_in_both_layouts_are_read() {
        for format in [TABLE, SeriesFormat::Aics] {
            let mut table = Table::new(columns(format, 2));
            for (name, k) in [("a, \"b\"", 3.0), ("", 7.0)] {
                table.push(row(format, 2, name, &sample(k)).expect("fits"));
            }
            let bytes = table.to_csv().expect("written");
            let options = ReadOptions::default();
            let rows = parse_all(Path::new("a.csv"), &bytes, format, &options).expect("read");
            assert_eq!([&*rows[0].0, &*rows[1].0], ["a, \"b\"", "row 2"]);
            for ((_, found), k) in rows.iter().zip([3.0, 7.0]) {
                let (a, b) = (&found.coefficients, &sample(k).coefficients);
                // Two roundings there, two back.
                let close = |(x, y): (&f64, &f64)| (x - y).abs() <= 4.0 * f64::EPSILON * y.abs();
                assert!(a.cosines().iter().zip(b.cosines()).all(close));
                assert!(a.sines().iter().zip(b.sines()).all(close));
                let has_centre = format == TABLE;
                assert_eq!(found.centre, if has_centre { sample(k).centre } else { DVec3::ZERO });
            }
        }
    }

    #[test]
    fn numbers_of_both_layouts_are_those_worked_out_by_hand() {
        // r = 1 + 0.3 x - 0.5 y + 0.2 z over the unit sphere: 4pi-normalised functions of degree 1
        // are sqrt(3) times x, y, z; aics-shparam counts the longitude from -x, which turns x and y.
        let mut c = Coefficients::zeros(1);
        c.set(0, 0, 1.0, 0.0);
        // Q_1^0 = z; Q_1^1 cos phi = -x / sqrt 2.
        c.set(1, 0, 0.2, 0.0);
        c.set(1, 1, -0.3 * 2.0_f64.sqrt(), 0.5 * 2.0_f64.sqrt());
        let shape = Shape::new(c);
        let [x, y, z] = [0.3, -0.5, 0.2].map(|v| v / 3.0_f64.sqrt());
        let numbers = |format| {
            let cells = row(format, 1, "a", &shape).expect("fits");
            cells.iter().filter_map(Cell::number).collect::<Vec<_>>()
        };
        for (format, expected) in [
            (TABLE, vec![0.0, 0.0, 0.0, 1.0, z, x, y]),
            (SeriesFormat::Aics, vec![1.0, 0.0, z, -x, 0.0, 0.0, 0.0, -y]),
        ] {
            let found = numbers(format);
            assert_eq!(found.len(), expected.len(), "{format}");
            let near = found.iter().zip(&expected).all(|(a, b)| (a - b).abs() <= 1e-15);
            assert!(near, "{format}: {found:?}");
        }
        assert_eq!(columns(TABLE, 1)[6..], ["C0_0_m", "C1_0_m", "C1_1_m", "S1_1_m"]);
        let aics = columns(SeriesFormat::Aics, 1);
        assert_eq!(aics[..4], ["name", "shcoeffs_L0M0C", "shcoeffs_L0M1C", "shcoeffs_L1M0C"]);
        assert_eq!(aics[5], "shcoeffs_L0M0S");
    }

    #[test]
    fn each_row_says_its_convention() {
        let text = "C0_0_m,note,normalisation,csphase\n1,a,4pi,1\n3.5449077018110318,b,ortho,-1\n";
        let rows = read(text, &ReadOptions::default()).expect("read");
        assert_eq!((&*rows[0].0, &*rows[1].0), ("a", "b"));
        let second = ReadOptions { row: Some(2), ..ReadOptions::default() };
        let said = convention(Path::new("a.csv"), text.as_bytes(), &second).expect("said");
        assert_eq!((said.normalisation.name(), said.phase.csphase()), ("ortho", -1));
        assert!((rows[1].1.coefficients.mean() - 1.0).abs() <= 1e-15);
        // What says how a row is meant is not its name.
        let nameless = read("normalisation,csphase,C0_0_m\n4pi,1,1\n", &ReadOptions::default());
        assert_eq!(nameless.expect("read")[0].0, "row 1");
        let bare = "C0_0_m\n1\n";
        let error = read(bare, &ReadOptions::default()).expect_err("not said").to_string();
        assert!(error.starts_with("a.csv:2: the file does not say how"), "{error}");
        let convention = Some(Convention::default());
        let told = ReadOptions { convention, ..ReadOptions::default() };
        assert_eq!(read(bare, &told).expect("told")[0].0, "row 1");
        // Half said is not said; the other half may be told.
        let half = "index,name,normalisation,C0_0_m,C1_0_m,C1_1_m,S1_1_m\n0,a,4pi,1,0,0.1,0\n";
        let error = read(half, &ReadOptions::default()).expect_err("no phase").to_string();
        assert!(error.starts_with("a.csv:2: the file does not say how"), "{error}");
        let turned = |phase| {
            let convention = Some(Convention { phase, ..Convention::default() });
            read(half, &ReadOptions { convention, ..ReadOptions::default() }).expect("told")
        };
        let [plain, turned] = [CondonShortley::Without, CondonShortley::With].map(turned);
        assert_eq!(plain[0].0, "a");
        let order_1 = |rows: &[(String, Shape)]| rows[0].1.coefficients.get(1, 1).0;
        assert!((order_1(&plain) + order_1(&turned)).abs() <= 1e-16 && order_1(&plain) != 0.0);
    }

    #[test]
    fn faults_are_told_with_row_and_column() {
        let header = "name,normalisation,csphase,centre_x_m,centre_y_m,centre_z_m,\
                      C0_0_m,C1_0_m,C1_1_m,S1_1_m\n";
        let good = "a,4pi,1,0,0,0,1,0,0,0\n";
        for (text, expected) in [
            (
                format!("{header}{good}b,4pi,1,0,0,0,1,x,0,0\n"),
                "a.csv:3: row 2, column `C1_0_m`: `x` is",
            ),
            (
                format!("{header}{good}b,4pi,1,0,0,0,1,0,inf,0\n"),
                "a.csv:3: row 2, column `C1_1_m`: `inf`",
            ),
            (
                format!("{header}b,4pi,1,,0,0,1,0,0,0\n"),
                "a.csv:2: row 1, column `centre_x_m`: `` is",
            ),
            (format!("{header}b,full,1,0,0,0,1,0,0,0\n"), "a.csv:2: `full` is not a normalisation"),
            (format!("{header}{good}b,4pi,1,0\n"), "a.csv:3: 4 cells, where the header has 10"),
            (format!("{header}{good}b,4pi,1,0\n").replace('\n', "\r\n"), "a.csv:3: 4 cells"),
            (format!("{header}{good}b,4pi,1,0"), "a.csv:3: the last line has no end"),
            (
                "centre_x_m,centre_z_m,C0_0_m\n0,0,1\n".to_owned(),
                "a.csv:1: the column `centre_y_m`",
            ),
            (
                format!("{header}{good}b,4pi,1,0,0,0,1,x,0,0\n").replace('\n', "\r\n"),
                "a.csv:3: row 2",
            ),
            (header.to_owned(), "the table has no rows"),
            ("C0_0_m,C1_0_m\n1,2\n".to_owned(), "the column `C1_1_m` is missing"),
            ("C0_0_m,C0_0_m\n1,2\n".to_owned(), "stands here twice"),
        ] {
            let error = read(&text, &ReadOptions::default()).expect_err("broken").to_string();
            assert!(error.contains(expected), "{error}");
        }
        let unit = ReadOptions { unit: Some(1e-3), ..ReadOptions::default() };
        assert!(read(&format!("{header}{good}"), &unit).is_err());
    }
}
