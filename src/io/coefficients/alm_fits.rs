//! The complex a_lm of healpy and HEALPix in FITS: the first binary table, with the columns index =
//! l^2 + l + m + 1, real and imag, m from 0 on; the a_lm are those of `alm_npy.rs`.

use std::path::Path;

use super::alm_npy::{degree, series};
use super::rows::agreed;
use super::{ReadOptions, SeriesFormat};
use crate::Result;
use crate::error::InputError;
use crate::fit::Shape;

/// Bytes of a block, and of a card of a header.
const BLOCK: usize = 2880;
const CARD: usize = 80;

/// How such a file begins.
pub(super) const MAGIC: &[u8] = b"SIMPLE  =";

/// Reads a_lm. Memory is bound by the size of the file.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input): no binary table or none of a_lm, a file that is cut off,
/// a_lm that are no full triangle, stand twice or are not finite, an imaginary part at m = 0.
pub fn parse(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Shape> {
    let format = SeriesFormat::Fits;
    agreed(path, "a_lm are always", format.convention(), options.convention)?;
    let (values, lmax) = read(bytes).map_err(|message| {
        let help = "healpy writes such a file with `write_alm`, with all orders up to lmax";
        InputError::new(path, message).help(help)
    })?;
    let series = series(&values, lmax);
    series.map(Shape::new).map_err(|message| InputError::new(path, message).into())
}

/// Reads all a_lm, order by order, and their degree.
fn read(bytes: &[u8]) -> Result<(Vec<(f64, f64)>, usize), String> {
    let table = Table::find(bytes)?;
    let columns = ["index", "real", "imag"].map(|name| table.column(name));
    let [index, real, imag] = columns;
    let (index, real, imag) = (index?, real?, imag?);
    let lmax = degree(table.rows)
        .ok_or_else(|| format!("{} a_lm are no triangle of (lmax+1)(lmax+2)/2", table.rows))?;
    let mut values = vec![None; table.rows];
    for row in table.data.chunks_exact(table.width) {
        let [index, re, im] = [&index, &real, &imag].map(|column| column.of(row));
        let (l, m) = place(index).filter(|(l, _)| *l <= lmax).ok_or_else(|| {
            format!("{index} is the index of no a_lm up to degree {lmax}, order 0 to l")
        })?;
        let value = &mut values[m * (2 * lmax + 1 - m) / 2 + l];
        if value.replace((re, im)).is_some() {
            return Err(format!("degree {l}, order {m} stands here twice"));
        }
    }
    // As many as there are places, none twice: all are there.
    Ok((values.into_iter().flatten().collect(), lmax))
}

/// Returns degree and order of an index from 1 on.
fn place(index: f64) -> Option<(usize, usize)> {
    let above = (1.0..1e15).contains(&index).then(|| index as usize - 1)?;
    let l = above.isqrt();
    above.checked_sub(l * l + l).map(|m| (l, m))
}

/// A binary table.
struct Table<'a> {
    header: Header<'a>,
    rows: usize,
    width: usize,
    data: &'a [u8],
}

impl<'a> Table<'a> {
    /// Finds the first of a file.
    fn find(bytes: &'a [u8]) -> Result<Self, String> {
        let mut rest = bytes;
        loop {
            let (header, data) = Header::read(rest)?;
            let size = header.data()?;
            let cut = || "the file is cut off within its table".to_owned();
            if header.text("XTENSION").is_some_and(|kind| kind == "BINTABLE") {
                let [width, rows] = ["NAXIS1", "NAXIS2"].map(|key| header.whole(key));
                let (width, rows) = (width?, rows?);
                let size = width.checked_mul(rows).filter(|size| *size > 0);
                let data = size.and_then(|size| data.get(..size)).ok_or_else(cut)?;
                return Ok(Self { header, rows, width, data });
            }
            rest =
                data.get(size..).filter(|rest| !rest.is_empty()).ok_or("there is no table here")?;
        }
    }

    /// Finds a column by its name.
    fn column(&self, name: &str) -> Result<Column, String> {
        let mut at = 0;
        for i in 1..=self.header.whole("TFIELDS")?.min(999) {
            let form = self.header.text(&format!("TFORM{i}")).unwrap_or("");
            let of_form =
                || format!("column {i} of the form `{}` is not read here", form.escape_debug());
            let split = form.find(|c: char| !c.is_ascii_digit()).ok_or_else(of_form)?;
            let repeat: usize =
                if split == 0 { 1 } else { form[..split].parse().map_err(|_| of_form())? };
            let kind = form.as_bytes()[split];
            let bytes = kind_bytes(kind).ok_or_else(of_form)?;
            let called = self.header.text(&format!("TTYPE{i}")).unwrap_or("");
            if called.eq_ignore_ascii_case(name) {
                let is_scaled = ["TSCAL", "TZERO"]
                    .iter()
                    .any(|key| self.header.text(&format!("{key}{i}")).is_some());
                return if repeat == 1 && !is_scaled && at + bytes <= self.width {
                    Ok(Column { at, kind })
                } else {
                    Err(of_form())
                };
            }
            at += repeat.saturating_mul(bytes).min(self.width);
        }
        Err(format!("the table has no column {name}"))
    }
}

/// Returns the bytes of a kind of numbers.
fn kind_bytes(kind: u8) -> Option<usize> {
    match kind {
        b'B' | b'A' | b'L' => Some(1),
        b'I' => Some(2),
        b'J' | b'E' => Some(4),
        b'K' | b'D' => Some(8),
        _ => None,
    }
}

/// A column of one number a row: where it begins, and its kind.
struct Column {
    at: usize,
    kind: u8,
}

impl Column {
    /// Returns the number of a row, which is as long as the columns are.
    fn of(&self, row: &[u8]) -> f64 {
        let part = &row[self.at..];
        match self.kind {
            b'I' => part.first_chunk().map_or(f64::NAN, |b| f64::from(i16::from_be_bytes(*b))),
            b'J' => part.first_chunk().map_or(f64::NAN, |b| f64::from(i32::from_be_bytes(*b))),
            b'K' => part.first_chunk().map_or(f64::NAN, |b| i64::from_be_bytes(*b) as f64),
            b'E' => part.first_chunk().map_or(f64::NAN, |b| f64::from(f32::from_be_bytes(*b))),
            b'D' => part.first_chunk().map_or(f64::NAN, |b| f64::from_be_bytes(*b)),
            _ => f64::NAN,
        }
    }
}

/// The cards of a header.
struct Header<'a>(&'a [u8]);

impl<'a> Header<'a> {
    /// Reads a header, and gives what follows its last block.
    fn read(bytes: &'a [u8]) -> Result<(Self, &'a [u8]), String> {
        let end = bytes.chunks_exact(CARD).position(|card| card.trim_ascii_end() == b"END");
        let end = end.ok_or("the file is cut off within a header, or it is no FITS file")?;
        let blocks = ((end + 1) * CARD).next_multiple_of(BLOCK).min(bytes.len());
        Ok((Self(&bytes[..end * CARD]), &bytes[blocks..]))
    }

    /// Returns the value of a card, without quotes and comment.
    fn text(&self, key: &str) -> Option<&'a str> {
        let is = |card: &&[u8]| card[..8].trim_ascii_end() == key.as_bytes() && card[8] == b'=';
        let card = self.0.chunks_exact(CARD).find(is)?;
        let value = str::from_utf8(&card[9..]).ok()?.trim_start();
        match value.strip_prefix('\'') {
            Some(quoted) => quoted.split('\'').next().map(str::trim),
            None => value.split('/').next().map(str::trim),
        }
    }

    fn whole(&self, key: &str) -> Result<usize, String> {
        let value = self.text(key).and_then(|text| text.parse().ok());
        value.ok_or_else(|| format!("a header has no whole number {key}"))
    }

    /// Returns the bytes of the data behind the header, in whole blocks.
    fn data(&self) -> Result<usize, String> {
        let axes = self.whole("NAXIS")?.min(999);
        // Real numbers have a minus sign there.
        let bits = self.text("BITPIX").and_then(|bits| bits.parse::<i16>().ok()).unwrap_or(8);
        let mut size = if axes == 0 { 0 } else { usize::from(bits.unsigned_abs() / 8) };
        for axis in 1..=axes {
            size = size.saturating_mul(self.whole(&format!("NAXIS{axis}"))?);
        }
        let size = size.saturating_add(self.whole("PCOUNT").unwrap_or(0));
        size.checked_next_multiple_of(BLOCK).ok_or_else(|| "a header announces too much".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::coefficients::alm_npy;
    use crate::sh::Coefficients;

    /// Makes a file as healpy does: an empty first part, then the table.
    fn file(cards: &[&str], rows: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let first = ["SIMPLE  =                    T / standard", "BITPIX  = 8", "NAXIS   = 0"];
        for header in [&first[..], cards] {
            bytes.extend(header.iter().flat_map(|card| format!("{card:<80}").into_bytes()));
            bytes.extend(format!("{:<80}", "END").into_bytes());
            bytes.resize(bytes.len().next_multiple_of(BLOCK), b' ');
        }
        bytes.extend(rows);
        bytes.resize(bytes.len().next_multiple_of(BLOCK), 0);
        bytes
    }

    fn cards(rows: usize) -> Vec<String> {
        [
            "XTENSION= 'BINTABLE'           / binary table extension",
            "BITPIX  =                    8",
            "NAXIS   =                    2",
            "NAXIS1  =                   20 / length of dimension 1",
            &format!("NAXIS2  = {rows:>20}"),
            "PCOUNT  =                    0",
            "TFIELDS =                    3",
            "TTYPE1  = 'index   '",
            "TFORM1  = '1J      '",
            "TTYPE2  = 'real    '",
            "TFORM2  = 'D       '",
            "TTYPE3  = 'imag    '",
            "TFORM3  = '1D      '",
        ]
        .map(str::to_owned)
        .to_vec()
    }

    /// Degree 2, the row of each a_lm by its index.
    fn rows() -> Vec<u8> {
        let places = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];
        let row = |(l, m): (i32, i32)| {
            let (re, im) = (f64::from(10 * l + m) + 1.0, f64::from(-m));
            let index = l * l + l + m + 1;
            [&index.to_be_bytes()[..], &re.to_be_bytes(), &im.to_be_bytes()].concat()
        };
        places.map(row).concat()
    }

    fn made(change: impl Fn(&str) -> String, rows: &[u8]) -> Vec<u8> {
        let cards: Vec<String> = cards(6).iter().map(|card| change(card)).collect();
        file(&cards.iter().map(String::as_str).collect::<Vec<_>>(), rows)
    }

    fn parsed(bytes: &[u8]) -> Result<Coefficients> {
        parse(Path::new("a.fits"), bytes, &ReadOptions::default()).map(|shape| shape.coefficients)
    }

    #[test]
    fn a_lm_are_those_of_the_array() {
        let c = parsed(&made(str::to_owned, &rows())).expect("read");
        // Order by order, as healpy holds them.
        let numbers = [1.0, 0.0, 11.0, 0.0, 21.0, 0.0, 12.0, -1.0, 22.0, -1.0, 23.0, -2.0];
        let array = crate::io::npy::write(&[6], 2, &numbers);
        let same = alm_npy::parse(Path::new("a.npy"), &array, &ReadOptions::default());
        assert_eq!(c, same.expect("read").coefficients);
        // The rows may come in any order, and the file without its padding.
        let turned: Vec<u8> = rows().chunks(20).rev().flatten().copied().collect();
        let mut bytes = made(str::to_owned, &turned);
        assert_eq!(parsed(&bytes).expect("read"), c);
        bytes.truncate(2 * BLOCK + 120);
        assert_eq!(parsed(&bytes).expect("read"), c);
        assert!((0..bytes.len()).all(|end| parsed(&bytes[..end]).is_err()));
    }

    #[test]
    fn table_behind_a_picture_of_real_numbers_is_found() {
        let table = made(str::to_owned, &rows());
        let picture = ["SIMPLE  = T", "BITPIX  = -64", "NAXIS   = 1", "NAXIS1  = 400"];
        let bytes = file(&picture, &[0; 0])[BLOCK..].to_vec();
        let bytes = [&bytes[..], &[0; 2 * BLOCK], &table[BLOCK..]].concat();
        assert_eq!(parsed(&bytes).expect("read"), parsed(&table).expect("read"));
    }

    #[test]
    fn header_of_any_numbers_is_read_or_refused() {
        let changed = |key: &str, value: &str| {
            let card = format!("{key:<8}= {value}");
            let is = |old: &str| old[..8].trim_end() == key;
            made(|old| if is(old) { card.clone() } else { old.to_owned() }, &rows())
        };
        for number in ["0", "-1", "", "1.5", "99999999999", "18446744073709551615"] {
            for key in ["BITPIX", "NAXIS", "PCOUNT"] {
                drop(parsed(&changed(key, number)));
            }
            for key in ["NAXIS1", "NAXIS2", "TFIELDS"] {
                // The columns that are needed come first, however many follow.
                let is_enough = key == "TFIELDS" && number.len() > 4;
                assert_eq!(parsed(&changed(key, number)).is_ok(), is_enough, "{key} {number}");
            }
            for key in ["TFORM1", "TFORM2", "TFORM3"] {
                for form in [format!("'{number}J'"), format!("'{number}D"), number.to_owned()] {
                    drop(parsed(&changed(key, &form)));
                }
            }
        }
        // An index that is no number.
        let mut rows = rows();
        rows[..4].copy_from_slice(&f32::NAN.to_be_bytes());
        let message = parsed(&made(|card| card.replace("1J", "1E"), &rows)).expect_err("refused");
        assert!(message.to_string().contains("NaN is the index of no a_lm"), "{message}");
    }

    #[test]
    fn tables_of_other_things_are_refused() {
        for (old, new, expected) in [
            ("BINTABLE", "IMAGE", "there is no table"),
            ("'real    '", "'value'", "the table has no column real"),
            ("TFORM2  = 'D", "TFORM2  = 'C", "column 2 of the form `C`"),
            ("TFORM1  = '1J", "TFORM1  = '2J", "column 1 of the form `2J`"),
            ("6", "5", "5 a_lm are no triangle"),
            ("6", "99999999999999", "cut off within its table"),
            ("PCOUNT  =                    0", "TZERO1  = 5", "column 1 of the form"),
        ] {
            let message = parsed(&made(|card| card.replacen(old, new, 1), &rows()));
            let message = message.expect_err("refused").to_string();
            assert!(message.contains(expected), "{message}");
        }
        for (at, index, expected) in [
            (0, 3, "stands here twice"),
            (0, 2, "the index of no a_lm"),
            (0, 0, "0 is the index of no a_lm"),
            (0, i32::MIN, "-2147483648 is the index of no a_lm"),
            (3, 13, "13 is the index"),
        ] {
            let mut rows = rows();
            rows[20 * at..20 * at + 4].copy_from_slice(&i32::to_be_bytes(index));
            let message = parsed(&made(str::to_owned, &rows)).expect_err("refused").to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
