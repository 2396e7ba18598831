//! The table of aics-shparam: a column `shcoeffs_L2M1C` for each degree, order and cosine or sine
//! (S), a row for each shape. `shape_table` reads and writes it; this is what is its own.
//!
//! The numbers are those of pyshtools' `SHExpandDH`, 4pi without phase, over a longitude that the
//! package counts from -x (`pi + arctan2(y, x)`): a turn by pi, which is the sign (-1)^m, so that
//! in our axes they are 4pi **with** the phase. The unit is that of the image, mostly a voxel.
//! Columns with m > l exist and hold 0; the centre has no room.

use super::shape_table::Place;

/// Begins the name of a column, after a prefix of the author's (`NUC_`).
const NAME: &str = "shcoeffs_L";

/// Lists the coefficients in the order of the columns.
pub(super) fn places(lmax: usize) -> Vec<Place> {
    let orders = |sine| move |l| (0..=lmax).map(move |m| (l, m, sine));
    [false, true].into_iter().flat_map(|sine| (0..=lmax).flat_map(orders(sine))).collect()
}

/// Returns the name of a column.
pub(super) fn column((l, m, sine): Place) -> String {
    format!("{NAME}{l}M{m}{}", if sine { 'S' } else { 'C' })
}

/// Reads the name of a column: the author's prefix, and the coefficient if it is one; `None` for a
/// column of anything else.
pub(super) fn place(name: &str) -> Option<(&str, Option<Place>)> {
    let (prefix, text) = name.split_once(NAME)?;
    Some((prefix, coefficient(text)))
}

/// Reads `2M1C`.
fn coefficient(text: &str) -> Option<Place> {
    let (text, sine) = match text.strip_suffix('C') {
        Some(text) => (text, false),
        None => (text.strip_suffix('S')?, true),
    };
    let (l, m) = text.split_once('M')?;
    Some((l.parse().ok()?, m.parse().ok()?, sine))
}

/// Whether a text begins with the header of such a table.
pub(super) fn is_aics(text: &str) -> bool {
    text.lines().next().is_some_and(|header| header.contains("shcoeffs_L0M0C"))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::fit::{Shape, Source};
    use crate::io::coefficients::{ReadOptions, SeriesFormat, shape_table};
    use crate::sh::Coefficients;
    use crate::{Error, Result};

    fn read(text: &str, row: Option<usize>) -> Result<Shape> {
        let options = ReadOptions { row, ..Default::default() };
        shape_table::parse(Path::new("a.csv"), text.as_bytes(), SeriesFormat::Aics, &options)
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
        let shape = Shape { source, ..Shape::new(c.clone()) };
        let text = shape_table::write(&shape, SeriesFormat::Aics).expect("written");
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
            (String::new(), "none has the column `shcoeffs_L0M0C`"),
            (HEADER.to_owned(), "the table has no rows"),
            (format!("{HEADER}a,1,0,0\n"), "a.csv:2: 4 cells, where the header has 5"),
            (
                format!("{HEADER}a,1,0,,0\n"),
                "a.csv:2: row 1, column `shcoeffs_L1M1C`: `` is not a number",
            ),
            (
                format!("{HEADER}a,1,0,nan,0\n"),
                "a.csv:2: row 1, column `shcoeffs_L1M1C`: `nan` is not a finite number",
            ),
            (with("shcoeffs_L0M0C,shcoeffs_L1M0C", "1,1"), "`shcoeffs_L1M1C` is missing"),
            (with("shcoeffs_L0M0C,shcoeffs_L99999999999M0C", "1,1"), "`shcoeffs_L1M0C` is missing"),
            (with("shcoeffs_L0M0C,shcoeffs_L0M0C", "1,1"), "stands here twice"),
            (with("shcoeffs_L0M0C,shcoeffs_L0M0X", "1,1"), "`shcoeffs_L0M0X` is no column"),
            (with("shcoeffs_L0M0C,shcoeffs_L0M1C", "1,1"), "the order cannot exceed the degree"),
            (with("shcoeffs_L0M0C,shcoeffs_L0M0S", "1,1"), "S of order 0"),
            (
                with("A_shcoeffs_L0M0C,B_shcoeffs_L0M0C", "1,1"),
                "of several shapes stand here (`A_shcoeffs_L0M0C`, `B_",
            ),
        ] {
            let message = refusal(&text);
            assert!(message.contains(expected), "{message}");
        }
    }
}
