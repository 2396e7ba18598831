//! Sensors in: the CSV table that `harmolux illum` writes, a sensor a row, in groups.

use std::collections::HashMap;
use std::path::Path;

use csv::StringRecord;
use glam::DVec3;

use crate::error::InputError;
use crate::io::input::Input;
use crate::io::tables::line_of;
use crate::{Error, Result};

/// Holds the sensors of one name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeasuredGroup {
    /// The name.
    pub name: String,
    /// Where the sensors are, metres.
    pub at: Vec<DVec3>,
    /// The sides they look to; zero where the table does not say it.
    pub normals: Vec<DVec3>,
    /// What each has measured; `None` for one that is behind an object, which does not count.
    pub values: Vec<Option<f64>>,
}

/// Reads a table; `column` names what was measured: `illuminance_lx`, `direct_lx`,
/// `half_width_95_lx`, ...
///
/// # Errors
/// [`Error::Io`] when the file cannot be read, else as [`parse`].
pub fn read(path: &Path, column: &str) -> Result<Vec<MeasuredGroup>> {
    parse(path, &Input::open(path)?.rest()?, column)
}

/// Whether a file that begins so is such a table: its header row has the column `x_m`.
pub fn recognise(head: &[u8]) -> bool {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(head);
    reader.headers().is_ok_and(|header| header.iter().any(|name| name == "x_m"))
}

/// Reads the columns `group`, `x_m`, `y_m`, `z_m`, `normal_x`, `normal_y`, `normal_z`, `behind` and
/// `column` of a CSV table with a header row; others are passed over, and the normals and `behind`
/// may be missing. Groups come in the order of their first sensor. An empty value, as NaN, is NaN.
/// `path` is for messages.
///
/// # Errors
/// [`Error::Input`] with line and remedy: not CSV, a column that lacks, no rows, a place that is no
/// number.
pub fn parse(path: &Path, bytes: &[u8], column: &str) -> Result<Vec<MeasuredGroup>> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
    let header = reader.headers().map_err(|e| broken(path, bytes, &e))?.clone();
    let columns = Columns::of(path, &header, column)?;
    let mut groups: Vec<MeasuredGroup> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    for record in reader.records() {
        let record = record.map_err(|e| broken(path, bytes, &e))?;
        let name = record.get(columns.group).unwrap_or("");
        let place = places.get(name).copied().unwrap_or(groups.len());
        if place == groups.len() {
            places.insert(name.to_owned(), place);
            groups.push(MeasuredGroup { name: name.to_owned(), ..Default::default() });
        }
        let line = line_of(bytes, record.position());
        columns.read((path, line), &header, &record, &mut groups[place])?;
    }
    if groups.is_empty() {
        return Err(InputError::new(path, "the table has no rows").help(WRITE_IT).into());
    }
    Ok(groups)
}

const WRITE_IT: &str = "write the table with `harmolux illum SCENE -o lux.csv`";

fn broken(path: &Path, bytes: &[u8], error: &csv::Error) -> Error {
    let wrong = InputError::new(path, format!("this is no CSV table: {error}")).help(WRITE_IT);
    wrong.at(line_of(bytes, error.position()), None).into()
}

/// Where in a row things stand.
struct Columns {
    group: usize,
    at: [usize; 3],
    normal: Option<[usize; 3]>,
    value: usize,
    behind: Option<usize>,
}

impl Columns {
    fn of(path: &Path, header: &StringRecord, value: &str) -> Result<Self> {
        let find =
            |name: &str| header.iter().position(|h| h.trim_start_matches('\u{feff}') == name);
        let need = |name: &str| {
            find(name).ok_or_else(|| {
                let names: Vec<&str> = header.iter().collect();
                let message =
                    format!("the table has no column `{name}`, only {}", names.join(", "));
                Error::from(InputError::new(path, message).at(1, None).help(WRITE_IT))
            })
        };
        let [nx, ny, nz] = ["normal_x", "normal_y", "normal_z"].map(find);
        Ok(Self {
            group: need("group")?,
            at: [need("x_m")?, need("y_m")?, need("z_m")?],
            normal: nx.zip(ny).zip(nz).map(|((x, y), z)| [x, y, z]),
            value: need(value)?,
            behind: find("behind"),
        })
    }

    /// Adds a row to its group.
    fn read(
        &self,
        (path, line): (&Path, usize),
        header: &StringRecord,
        record: &StringRecord,
        group: &mut MeasuredGroup,
    ) -> Result<()> {
        let number = |column: usize, empty: Option<f64>| {
            let text = record.get(column).unwrap_or("");
            let number = if text.is_empty() { empty } else { text.parse::<f64>().ok() };
            number.ok_or_else(|| {
                let name = header.get(column).unwrap_or("");
                let message = format!("`{text}` in column `{name}` is no number");
                Error::from(InputError::new(path, message).at(line, None).help(WRITE_IT))
            })
        };
        let vector = |[x, y, z]: [usize; 3]| {
            Ok::<_, Error>(DVec3::new(number(x, None)?, number(y, None)?, number(z, None)?))
        };
        let value = number(self.value, Some(f64::NAN))?;
        let behind = self.behind.and_then(|column| record.get(column)).unwrap_or("");
        group.at.push(vector(self.at)?);
        group.normals.push(self.normal.map_or(Ok(DVec3::ZERO), vector)?);
        group.values.push(behind.is_empty().then_some(value));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "group,x_m,y_m,z_m,normal_x,normal_y,normal_z,illuminance_lx,behind\n";

    fn parsed(text: &str) -> Result<Vec<MeasuredGroup>> {
        parse(Path::new("lux.csv"), text.as_bytes(), "illuminance_lx")
    }

    fn refusal(text: &str) -> String {
        parsed(text).expect_err("refused").to_string()
    }

    #[test]
    fn tables_that_are_none_are_refused_with_the_remedy() {
        for (text, words) in [
            (String::new(), "lux.csv:1: the table has no column `group`"),
            ("a,b\n1,2\n".to_owned(), "no column `group`, only a, b"),
            (HEADER.to_owned(), "lux.csv: the table has no rows"),
            (format!("{HEADER}a,1,2\n"), "lux.csv:2: this is no CSV table"),
            (format!("{HEADER}a,1,two,3,0,0,1,5,\n"), "lux.csv:2: `two` in column `y_m`"),
            (format!("{HEADER}a,1,,3,0,0,1,5,\n"), "`` in column `y_m` is no number"),
        ] {
            let message = refusal(&text);
            assert!(message.contains(words) && message.contains("harmolux illum"), "{message}");
        }
        let text = format!("{HEADER}a,1,2,3,0,0,1,5,\n");
        let message = parse(Path::new("x"), text.as_bytes(), "lux").expect_err("refused");
        assert!(message.to_string().contains("no column `lux`"));
        assert!(parse(Path::new("x"), b"group,\xff\n", "lux").is_err());
    }

    #[test]
    fn table_is_told_by_its_header() {
        assert!(recognise(HEADER.as_bytes()) && recognise(b"group, x_m\n"));
        assert!(!recognise(b"") && !recognise(b"degree,power\n") && !recognise(b"\xff,x_m\n"));
    }

    #[test]
    fn groups_keep_their_order_and_hidden_sensors_do_not_count() {
        let rows = "b,1,2,3,0,0,1,5,\na,0,0,0,1,0,0,7,the \"\"head\nb,2,2,3,0,0,1,,\n";
        let groups =
            parsed(&format!("{HEADER}{}", rows.replace("the \"\"head", "head"))).expect("read");
        assert_eq!(groups.iter().map(|g| g.name.as_str()).collect::<Vec<_>>(), ["b", "a"]);
        assert_eq!(groups[0].at, [DVec3::new(1.0, 2.0, 3.0), DVec3::new(2.0, 2.0, 3.0)]);
        assert_eq!((groups[0].normals[1], groups[0].values[0]), (DVec3::Z, Some(5.0)));
        assert!(groups[0].values[1].is_some_and(f64::is_nan));
        assert_eq!(groups[1].values, [None]);
    }

    #[test]
    fn very_many_groups_are_told_apart_in_one_pass() {
        let row = |i: usize| format!("{},1,2,3,0,0,1,5,\n", i % 100_000);
        let rows: String = (0..200_000).map(row).collect();
        let groups = parsed(&format!("{HEADER}{rows}")).expect("read");
        assert_eq!((groups.len(), groups[99_999].at.len()), (100_000, 2));
    }

    #[test]
    fn normals_and_behind_may_be_missing() {
        let text = "group,x_m,y_m,z_m,illuminance_lx\ng,1,2,3,NaN\n";
        let groups = parsed(text).expect("read");
        assert_eq!(groups[0].normals, [DVec3::ZERO]);
        assert!(groups[0].values[0].is_some_and(f64::is_nan));
    }
}
