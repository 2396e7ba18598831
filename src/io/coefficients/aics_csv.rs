//! The table of aics-shparam: CSV, a column `shcoeffs_L2M1C` for each degree, order and cosine or
//! sine (S), a row for each shape.
//!
//! The numbers are those of pyshtools' `SHExpandDH`, 4pi without phase, over a longitude that the
//! package counts from -x (`pi + arctan2(y, x)`): a turn by pi, which is the sign (-1)^m, so that
//! in our axes they are 4pi **with** the phase. The unit is that of the image, mostly a voxel.
//! Columns with m > l exist and hold 0.

use std::collections::BTreeMap;
use std::path::Path;

use super::rows::{agreed, coefficient, collect};
use super::{ReadOptions, SeriesFormat};
use crate::error::{Advice, InputError};
use crate::fit::Shape;
use crate::io::output::SOFTWARE;
use crate::sh::Convention;
use crate::{Error, Result};

/// Begins the name of a column, after a prefix of the author's (`NUC_`).
const NAME: &str = "shcoeffs_L";

/// Writes a table of one row, every number with all its digits. The first column is named after
/// this program and holds the name of the source; the centre has no room.
///
/// # Errors
/// [`Error::Numeric`] as [`Convention::export`]: never, for the normalisation of this format.
pub fn write(shape: &Shape) -> Result<Vec<u8>> {
    let c = &shape.coefficients;
    let convention = convention();
    let source = shape.source.as_ref().map_or("", |source| &source.name);
    let (mut header, mut row) = (vec![SOFTWARE.to_owned()], vec![source.to_owned()]);
    for sine in [false, true] {
        for l in 0..=c.lmax() {
            for m in 0..=c.lmax() {
                let pair = if m > l { (0.0, 0.0) } else { convention.export(l, m, c.get(l, m))? };
                header.push(format!("{NAME}{l}M{m}{}", if sine { 'S' } else { 'C' }));
                row.push(format!("{:?}", if sine { pair.1 } else { pair.0 }));
            }
        }
    }
    let mut writer = csv::Writer::from_writer(Vec::new());
    let written = writer.write_record(&header).and_then(|()| writer.write_record(&row));
    let wrong =
        |e: &dyn std::fmt::Display| Error::Numeric(format!("the table cannot be made: {e}"));
    written.map_err(|e| wrong(&e))?;
    writer.into_inner().map_err(|e| wrong(&e))
}

fn convention() -> Convention {
    SeriesFormat::Aics.convention().unwrap_or_default()
}

/// Reads one row of a table: the only one, or the one that is asked for. Memory is bound by the
/// size of the table.
///
/// # Errors
/// [`Error::Input`] with the line: no UTF-8, rows of different lengths, no such columns or those of
/// several shapes, a column that is missing, double, or not 0 where m > l, several rows of which
/// none is named, a row that is not there, a cell that is no finite number.
pub fn parse(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Shape> {
    let wrong = |message: String| InputError::new(path, message);
    agreed(path, "a table of aics-shparam is always", Some(convention()), options.convention)?;
    super::rows::ended(path, bytes)?;
    let mut reader = csv::Reader::from_reader(bytes);
    let header = reader.headers().map_err(|e| broken(path, &e))?.clone();
    let columns = columns(&header).map_err(|message| wrong(message).at(1, None))?;
    let lmax = degree(&columns).map_err(|message| wrong(message).at(1, None))?;
    let row = choose(path, &mut reader, options.row)?;
    let line = row.position().map_or(0, csv::Position::line) as usize;
    let mut values = BTreeMap::new();
    for (place, column) in columns {
        let cell = row.get(column).unwrap_or_default().trim();
        let value = coefficient(cell).map_err(|message| wrong(message).at(line, None))?;
        if place.1 > place.0 && value != 0.0 {
            let (l, m, _) = place;
            let message =
                format!("degree {l}, order {m} is {value:e}: the order cannot exceed the degree");
            return Err(wrong(message).at(line, None).into());
        }
        values.insert(place, value);
    }
    let value = |l: usize, m: usize, sine: bool| values.get(&(l, m, sine)).copied().unwrap_or(0.0);
    let pair = |l: usize, m: usize| (value(l, m, false), value(l, m, true));
    Ok(Shape::new(collect(path, lmax, convention(), pair)?))
}

/// Whether a text begins with the header of such a table.
pub(super) fn is_aics(text: &str) -> bool {
    text.lines().next().is_some_and(|header| header.contains("shcoeffs_L0M0C"))
}

/// Degree, order, and whether it is a sine.
type Place = (usize, usize, bool);

/// Finds the columns of coefficients.
fn columns(header: &csv::StringRecord) -> Result<BTreeMap<Place, usize>, String> {
    let mut columns = BTreeMap::new();
    let mut prefixes = std::collections::BTreeSet::new();
    for (i, name) in header.iter().enumerate() {
        let Some((prefix, place)) = name.trim().split_once(NAME) else { continue };
        let place =
            self::place(place).ok_or_else(|| format!("`{name}` is no column of coefficients"))?;
        prefixes.insert(prefix.to_owned());
        if columns.insert(place, i).is_some() && prefixes.len() == 1 {
            return Err(format!("the column `{name}` stands here twice"));
        }
    }
    if prefixes.len() > 1 {
        let names: Vec<_> = prefixes.iter().map(|p| format!("`{p}{NAME}...`")).collect();
        return Err(format!(
            "the columns of several shapes stand here ({}): keep those of one",
            names.join(", ")
        ));
    }
    Ok(columns)
}

/// Reads `2M1C`.
fn place(text: &str) -> Option<Place> {
    let (text, sine) = match text.strip_suffix('C') {
        Some(text) => (text, false),
        None => (text.strip_suffix('S')?, true),
    };
    let (l, m) = text.split_once('M')?;
    Some((l.parse().ok()?, m.parse().ok()?, sine))
}

/// Finds lmax, and checks that every coefficient has its column (a sine of order 0 need not).
fn degree(columns: &BTreeMap<Place, usize>) -> Result<usize, String> {
    let (&(lmax, ..), _) = columns.last_key_value().ok_or(
        "there are no columns `shcoeffs_L0M0C` and so on: this is no table of aics-shparam",
    )?;
    // The columns that are there bound this search, whatever degree one of them names.
    for l in 0..=lmax {
        for m in 0..=l {
            for sine in [false, true] {
                if !(columns.contains_key(&(l, m, sine)) || sine && m == 0) {
                    let which = if sine { 'S' } else { 'C' };
                    return Err(format!("the column `{NAME}{l}M{m}{which}` is missing"));
                }
            }
        }
    }
    Ok(lmax)
}

/// Reads the row that is asked for, or the only one.
fn choose(
    path: &Path,
    reader: &mut csv::Reader<&[u8]>,
    number: Option<usize>,
) -> Result<csv::StringRecord> {
    let mut chosen = None;
    let mut count = 0;
    for record in reader.records() {
        let record = record.map_err(|e| broken(path, &e))?;
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

fn broken(path: &Path, error: &csv::Error) -> Error {
    let message = match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("{len} cells, where the header has {expected_len}")
        }
        csv::ErrorKind::Utf8 { .. } => "this is not UTF-8 text, so no table".to_owned(),
        _ => error.to_string(),
    };
    let mut input = InputError::new(path, message);
    input.line = error.position().map(|position| position.line() as usize);
    input.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::Source;
    use crate::sh::Coefficients;

    fn read(text: &str, row: Option<usize>) -> Result<Shape> {
        let options = ReadOptions { row, ..Default::default() };
        parse(Path::new("a.csv"), text.as_bytes(), &options)
    }

    fn refusal(text: &str) -> String {
        match read(text, None) {
            Err(Error::Input(error)) => error.to_string(),
            other => panic!("not an input error: {other:?}"),
        }
    }

    const HEADER: &str = "CellId,shcoeffs_L0M0C,shcoeffs_L1M0C,shcoeffs_L1M1C,shcoeffs_L1M1S\n";

    #[test]
    fn ball_needs_one_column() {
        let shape = read("shcoeffs_L0M0C\n2.5\n", None).expect("a ball");
        assert_eq!((shape.coefficients.lmax(), shape.coefficients.mean()), (0, 2.5));
    }

    #[test]
    fn longitude_is_counted_from_minus_x() {
        // r = 1 + 0.3 sqrt(3) sin(theta) cos(longitude) bulges where the longitude is 0: towards
        // -x.
        let shape = read(&format!("{HEADER}7,1,0,0.3,0\n"), None).expect("read");
        let f = crate::sh::Series::new(&shape.coefficients).expect("evaluable");
        let expected = 1.0 + 0.3 * 3.0_f64.sqrt();
        assert!((f.value(glam::DVec3::NEG_X) - expected).abs() <= 1e-15);
    }

    #[test]
    fn what_is_written_is_read() {
        let mut c = Coefficients::zeros(2);
        c.set(0, 0, 1.0, 0.0);
        c.set(2, 1, 0.1, -0.2);
        let source = Some(Source::new(Path::new("a, \"b\".obj"), b""));
        let text = write(&Shape { source, ..Shape::new(c.clone()) }).expect("written");
        let text = String::from_utf8(text).expect("UTF-8");
        assert!(text.starts_with("harmolux ") && is_aics(&text));
        assert_eq!(text.lines().next().map(|l| l.split(',').count()), Some(19));
        let back = read(&text, None).expect("read").coefficients;
        let pairs =
            back.cosines().iter().chain(back.sines()).zip(c.cosines().iter().chain(c.sines()));
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() <= 1e-16));
    }

    #[test]
    fn one_row_of_several_is_read_when_named() {
        let table = format!("{HEADER}a,1,0,0,0\nb,2,0,0,0\n");
        assert_eq!(read(&table, Some(2)).expect("read").coefficients.mean(), 2.0);
        let message = refusal(&table);
        assert!(message.contains("the table has 2 rows") && message.contains("choose one"));
        let message = read(&table, Some(3)).expect_err("no row").to_string();
        assert!(message.contains("there is no row 3: the table has 2"));
    }

    #[test]
    fn broken_tables_are_refused() {
        let with = |columns: &str, row: &str| format!("{columns}\n{row}\n");
        for (text, expected) in [
            (String::new(), "this is no table of aics-shparam"),
            (HEADER.to_owned(), "the table has no rows"),
            (format!("{HEADER}a,1,0,0\n"), "a.csv:2: 4 cells, where the header has 5"),
            (format!("{HEADER}a,1,0,,0\n"), "a.csv:2: `` is not a number"),
            (format!("{HEADER}a,1,0,nan,0\n"), "a.csv:2: `nan` is not a finite number"),
            (with("shcoeffs_L0M0C,shcoeffs_L1M0C", "1,1"), "`shcoeffs_L1M1C` is missing"),
            (with("shcoeffs_L0M0C,shcoeffs_L99999999999M0C", "1,1"), "`shcoeffs_L1M0C` is missing"),
            (with("shcoeffs_L0M0C,shcoeffs_L0M0C", "1,1"), "stands here twice"),
            (with("shcoeffs_L0M0C,shcoeffs_L0M0X", "1,1"), "`shcoeffs_L0M0X` is no column"),
            (with("shcoeffs_L0M0C,shcoeffs_L0M1C", "1,1"), "the order cannot exceed the degree"),
            (with("shcoeffs_L0M0C,shcoeffs_L0M0S", "1,1"), "S of order 0"),
            (
                with("A_shcoeffs_L0M0C,B_shcoeffs_L0M0C", "1,1"),
                "of several shapes stand here (`A_shcoeffs_L...`, `B_",
            ),
        ] {
            let message = refusal(&text);
            assert!(message.contains(expected), "{message}");
        }
    }
}
