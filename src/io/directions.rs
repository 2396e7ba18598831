//! Directions as a CSV table: latitudes and longitudes in degrees, a direction a row.

use std::path::Path;

use csv::StringRecord;

use crate::error::InputError;
use crate::fit::LatLong;
use crate::io::decimal::real;
use crate::io::tables::line_of;
use crate::{Error, Result};

/// What the columns may be called.
const NAMES: [&[&str]; 2] = [
    &["latitude_degrees", "latitude", "lat"],
    &["longitude_degrees", "longitude", "lon", "long", "lng"],
];

const WANTED: &str = "write `latitude,longitude` in the first line, and a pair of degrees in each \
                      that follows";

/// Reads the columns of latitude and longitude, by their names or, without a line of names, the
/// first two; others are passed over, and so are lines that begin with `#`. `path` is for messages.
///
/// # Errors
/// [`Error::Input`] with the line: no CSV, no such columns, no directions, what is no number, or no
/// latitude.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<LatLong>> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = csv::ReaderBuilder::new();
    reader.has_headers(false).trim(csv::Trim::All).comment(Some(b'#'));
    let mut columns = None;
    let mut directions = Vec::new();
    for record in reader.from_reader(bytes).records() {
        let record = record.map_err(|e| {
            fault(path, line_of(bytes, e.position()), format!("this is no CSV table: {e}"))
        })?;
        let line = line_of(bytes, record.position());
        let is_header = record.iter().all(|field| real(field).is_none());
        match columns {
            None if is_header => {
                columns = Some(named(&record).map_err(|text| fault(path, line, text))?);
            }
            _ => {
                let columns = *columns.get_or_insert([0, 1]);
                let row = direction(&record, columns).map_err(|text| fault(path, line, text))?;
                directions.push(row);
            }
        }
    }
    if directions.is_empty() {
        return Err(InputError::new(path, "no direction stands in this file").help(WANTED).into());
    }
    Ok(directions)
}

fn fault(path: &Path, line: usize, message: String) -> Error {
    InputError::new(path, message).at(line, None).help(WANTED).into()
}

/// Finds the columns by their names.
fn named(header: &StringRecord) -> Result<[usize; 2], String> {
    let place = |names: &[&str]| {
        let is = |field: &str| names.iter().any(|name| name.eq_ignore_ascii_case(field));
        header.iter().position(is).ok_or_else(|| {
            let found: Vec<&str> = header.iter().collect();
            format!("no column is called {}; there are: {}", names[1], found.join(", "))
        })
    };
    Ok([place(NAMES[0])?, place(NAMES[1])?])
}

fn direction(record: &StringRecord, columns: [usize; 2]) -> Result<LatLong, String> {
    let number = |column: usize| {
        let text = record.get(column).ok_or("a row needs a latitude and a longitude")?;
        real(text).ok_or_else(|| format!("`{text}` is no number"))
    };
    LatLong::new(number(columns[0])?, number(columns[1])?).map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<(f64, f64)>> {
        let all = parse(Path::new("d.csv"), text.as_bytes())?;
        Ok(all.iter().map(|at| (at.latitude(), at.longitude())).collect())
    }

    #[test]
    fn columns_are_found_by_name_or_are_the_first_two() {
        let expected = [(10.0, 20.0), (-90.0, 400.0)];
        for text in [
            "10,20\n-90,400\n",
            "\u{feff}# degrees\nlat,lon\n10,20\n-90,400",
            "name,Longitude,radius_m,LATITUDE\na,20,7,10\nb,400,,-90\n",
            "latitude_degrees, longitude_degrees, radius_m\n10, 20, 1\n-9e1, 4D2, 1\n",
        ] {
            assert_eq!(read(text).expect("directions"), expected, "{text}");
        }
    }

    #[test]
    fn what_is_no_direction_is_told_with_its_line() {
        for (text, words) in [
            ("", "d.csv: no direction stands in this file"),
            ("lat,lon\n", "no direction stands"),
            ("lat,lon\n1,2\n91,0\n", "d.csv:3: a latitude is from -90 to 90 degrees, not 91"),
            ("1,nan\n", "d.csv:1: a longitude is a finite number"),
            ("lat,lon\n1,2\n1\n", "d.csv:3: this is no CSV table"),
            ("1\n", "d.csv:1: a row needs a latitude and a longitude"),
            ("1,x\n", "d.csv:1: `x` is no number"),
            ("lat,radius\n1,2\n", "d.csv:1: no column is called longitude; there are: lat, radius"),
            ("1;2\n", "d.csv:1: no column is called latitude; there are: 1;2"),
        ] {
            let message = read(text).expect_err("refused").to_string();
            assert!(message.contains(words), "{text}: {message}");
        }
        assert!(parse(Path::new("d.csv"), b"lat,lon\n\xff,1\n").is_err());
    }
}
