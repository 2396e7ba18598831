//! Spectra in: a CSV table of the power of each degree, as `harmolux spectrum` writes it.

use std::path::Path;

use crate::error::InputError;
use crate::io::tables::line_of;
use crate::sh::MAX_DEGREE;
use crate::{Error, Result};

/// Whether a file that begins so is such a table: its header row has the columns.
pub fn recognise(head: &[u8]) -> bool {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(head);
    reader.headers().is_ok_and(|header| columns(Path::new(""), header).is_ok())
}

/// Reads the columns `degree` and `power` (or `power_m2`) of a CSV table with a header row; other
/// columns are passed over. `path` is for messages.
///
/// The power P_l is the mean of f_l^2 over the sphere, in m2. Degrees ascend without gaps and may
/// start above 0: `result[l]` is the power of degree l, 0 below the first.
///
/// # Errors
/// [`Error::Input`] with line and remedy: not UTF-8 or not CSV, a column that lacks, no rows, a
/// degree that is no number, out of order or above [`MAX_DEGREE`], a power that is negative or not
/// finite.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<f64>> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
    let columns = columns(path, reader.headers().map_err(|e| broken(path, bytes, &e))?)?;
    let mut powers: Vec<f64> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| broken(path, bytes, &e))?;
        let line = line_of(bytes, record.position());
        let wrong = |message: String| InputError::new(path, message).at(line, None);
        let [degree, power] = columns.map(|i| record.get(i).unwrap_or(""));
        let degree = degree
            .parse()
            .ok()
            .filter(|l| *l <= MAX_DEGREE)
            .ok_or_else(|| wrong(format!("`{degree}` is no degree from 0 to {MAX_DEGREE}")))?;
        if powers.is_empty() {
            powers.resize(degree, 0.0);
        }
        if degree != powers.len() {
            let message =
                format!("degree {degree} stands here, where degree {} must come", powers.len());
            return Err(wrong(message)
                .help("list every degree of one shape once, in ascending order")
                .into());
        }
        let number: f64 =
            power.parse().ok().filter(|p: &f64| p.is_finite() && *p >= 0.0).ok_or_else(|| {
                wrong(format!("`{power}` is no power: it must be a number, 0 or more"))
            })?;
        powers.push(number);
    }
    if powers.is_empty() {
        return Err(InputError::new(path, "there are no degrees here").into());
    }
    Ok(powers)
}

/// Finds the columns of degree and power.
fn columns(path: &Path, header: &csv::StringRecord) -> Result<[usize; 2]> {
    let find = |names: &[&str]| {
        let named = |h: &str| names.iter().any(|name| h.eq_ignore_ascii_case(name));
        header.iter().position(named).ok_or_else(|| {
            let message = format!("the header row has no column `{}`", names.join("` or `"));
            InputError::new(path, message)
                .at(1, None)
                .help("a spectrum is a CSV table that begins as `degree,power`")
        })
    };
    Ok([find(&["degree"])?, find(&["power", "power_m2"])?])
}

/// Returns where the table is broken.
fn broken(path: &Path, bytes: &[u8], error: &csv::Error) -> Error {
    let message = match error.kind() {
        csv::ErrorKind::Utf8 { .. } => "this is not UTF-8 text".to_owned(),
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("{len} cells, where the header row has {expected_len}")
        }
        _ => format!("this is no CSV table: {error}"),
    };
    InputError::new(path, message).at(line_of(bytes, error.position()), None).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &[u8]) -> Result<Vec<f64>> {
        parse(Path::new("s.csv"), text)
    }

    #[test]
    fn broken_tables_are_refused_with_their_line() {
        for (text, says) in [
            (&b""[..], "s.csv:1: the header row has no column `degree`"),
            (b"degree,variance\n1,2\n", "no column `power`"),
            (b"degree,power\n", "s.csv: there are no degrees here"),
            (
                b"degree,power\n0,1\n2,1\n",
                "s.csv:3: degree 2 stands here, where degree 1 must come",
            ),
            (b"degree,power\n0,1\n0,1\n", "s.csv:3: degree 0"),
            (b"degree,power\n0,-1\n", "s.csv:2: `-1` is no power"),
            (b"degree,power\n0,nan\n", "s.csv:2: `nan` is no power"),
            (b"degree,power\n0\n", "s.csv:2: 1 cells, where the header row has 2"),
            (b"degree,power\n4000000000,1\n", "s.csv:2: `4000000000` is no degree"),
            (b"degree,power\n1.5,1\n", "s.csv:2: `1.5` is no degree"),
            (b"degree,power\n1,\xff\n", "UTF-8"),
        ] {
            let error = read(text).expect_err("broken").to_string();
            assert!(error.contains(says), "{error}");
        }
    }

    #[test]
    fn table_is_told_by_its_header() {
        assert!(recognise(b"Power, degree\n") && recognise(b"shape,degree,power_m2\nhead,0,4\n"));
        assert!(!recognise(b"") && !recognise(b"0, 0, 1\n1, 0, 1\n") && !recognise(b"degree\n"));
    }

    #[test]
    fn columns_are_found_by_name_and_low_degrees_are_zero() {
        let powers = read(b"Power, degree,share\r\n0.5,2,1\r\n1e-3,3,0\r\n").expect("valid");
        assert_eq!(powers, [0.0, 0.0, 0.5, 1e-3]);
        assert_eq!(read(b"shape,degree,power_m2\nhead,0,4\n").expect("ours"), [4.0]);
    }
}
