//! The "spherical harmonics ASCII data record" (SHADR) of NASA's Planetary Data System: a header
//! line of eight numbers (reference radius, GM, its error, degree, order, normalisation state,
//! reference longitude and latitude), then lines `l, m, C, S` with two errors, which are not read.
//!
//! State 1 is 4pi, 0 is unnormalised, both without the Condon-Shortley phase as everywhere in
//! geodesy; any other state must be said. The coefficients are taken as they are, lengths in the
//! unit that is said (the archive has metres and kilometres); a gravity field, which is a ratio, or
//! a height above the reference radius is no radius, and nothing here multiplies by that radius or
//! adds it.

use std::path::Path;

use super::ReadOptions;
use super::rows::{Triangle, agreed, cells, check_place, coefficient, digits, lines, number, text};
use crate::error::{Advice, InputError};
use crate::fit::Shape;
use crate::io::decimal;
use crate::io::output::SOFTWARE;
use crate::sh::{CondonShortley, Convention, Normalisation};
use crate::{Error, Result};

/// Writes a shape: metres, its mean radius as reference radius, no GM, no errors; centre and source
/// have no room. Fields have the widths of the record's definition.
///
/// # Errors
/// [`Error::Parameter`] for a convention that the header cannot say (it knows 4pi and unnorm,
/// csphase 1); [`Error::Numeric`] when the degree is too high for unnormalised coefficients.
pub fn write(shape: &Shape, convention: Convention) -> Result<Vec<u8>> {
    let state = state(convention)?;
    let c = &shape.coefficients;
    let (lmax, zero) = (c.lmax(), real(0.0));
    let radius = real(c.mean());
    let mut lines = vec![format!(
        "{radius},{zero},{zero},{lmax:>5},{lmax:>5},{state:>5},{zero},{zero}, {SOFTWARE} radius \
         in metres\r\n"
    )];
    for l in 0..=lmax {
        for m in 0..=l {
            let (cosine, sine) = convention.export(l, m, c.get(l, m))?;
            let [cosine, sine] = [cosine, sine].map(real);
            lines.push(format!("{l:>5},{m:>5},{cosine},{sine},{zero},{zero}\r\n"));
        }
    }
    Ok(lines.concat().into_bytes())
}

fn state(convention: Convention) -> Result<u8> {
    match (convention.normalisation, convention.phase) {
        (Normalisation::FourPi, CondonShortley::Without) => Ok(1),
        (Normalisation::Unnormalised, CondonShortley::Without) => Ok(0),
        (normalisation, phase) => Err(Error::Parameter(format!(
            "a SHADR table cannot say {normalisation}, csphase {}: write 4pi or unnorm, csphase 1",
            phase.csphase()
        ))),
    }
}

/// Writes a number in Fortran's E23.16, or one wider where the exponent has three digits.
fn real(value: f64) -> String {
    format!("{:>23}", digits(value).replace('e', "E"))
}

/// Reads a table; `path` is for messages. Memory is bound by the size of the text.
///
/// # Errors
/// [`Error::Input`] with line: not UTF-8, a header that is none, a normalisation that is not said
/// or contradicts the given one, rows as in [`shtools_text::parse`](super::shtools_text::parse),
/// another degree than the announced one.
pub fn parse(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Shape> {
    let text = text(path, bytes)?;
    super::rows::ended(path, bytes)?;
    let mut lines = lines(text);
    let (first, at) = lines.next().unwrap_or(("", 1));
    let header = Header::read(first).ok_or_else(|| {
        let message = "a SHADR table begins with eight numbers: radius, GM, error, degree, order, \
                       normalisation, longitude, latitude";
        InputError::new(path, message).at(at, None).advise(Advice::ReadAsText)
    })?;
    let convention = agreed(path, "the header says", header.convention(), options.convention)?;
    let mut triangle = Triangle::new(convention);
    for (line, at) in lines {
        row(line, triangle.next())
            .and_then(|pair| triangle.push(pair))
            .map_err(|message| InputError::new(path, message).at(at, None))?;
    }
    let coefficients = triangle.finish(path, Some(text.lines().count()))?;
    let found = coefficients.lmax();
    if (header.degree, header.order) != (found, found) {
        let message = format!(
            "the header announces degree {}, order {}; the table ends with degree {found}",
            header.degree, header.order
        );
        return Err(InputError::new(path, message).help("part of it is lost: get it anew").into());
    }
    Ok(Shape::new(coefficients))
}

/// Returns the convention that the header states.
pub(super) fn convention(path: &Path, bytes: &[u8]) -> Result<Option<Convention>> {
    let first = lines(text(path, bytes)?).next();
    Ok(first.and_then(|(line, _)| Header::read(line)).and_then(|header| header.convention()))
}

/// Whether a text begins with such a header.
pub(super) fn is_shadr(text: &str) -> bool {
    lines(text).next().is_some_and(|(line, _)| Header::read(line).is_some())
}

/// What the header says of the coefficients.
struct Header {
    degree: usize,
    order: usize,
    state: usize,
}

impl Header {
    fn read(line: &str) -> Option<Self> {
        let cells: Vec<&str> = line.split(',').map(str::trim).take(8).collect();
        let [radius, gm, error, degree, order, state, longitude, latitude] = *cells else {
            return None;
        };
        let reals = [radius, gm, error, longitude, latitude]
            .into_iter()
            .all(|text| decimal::real(text).is_some());
        let whole = |text: &str| text.parse().ok();
        reals.then_some(())?;
        Some(Self { degree: whole(degree)?, order: whole(order)?, state: whole(state)? })
    }

    fn convention(&self) -> Option<Convention> {
        let normalisation = match self.state {
            0 => Normalisation::Unnormalised,
            1 => Normalisation::FourPi,
            _ => return None,
        };
        Some(Convention { normalisation, phase: CondonShortley::Without })
    }
}

fn row(line: &str, place: (usize, usize)) -> Result<(f64, f64), String> {
    let cells = cells(line);
    let ([degree, order, c, s] | [degree, order, c, s, _, _]) = cells.as_slice() else {
        let found = cells.len();
        return Err(format!("{found} columns, where a row is `l, m, C, S` and two errors"));
    };
    check_place((number(degree, "degree")?, number(order, "order")?), place)?;
    Ok((coefficient(c)?, coefficient(s)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str =
        " 1.0000000000000000E+00, 0.0E+00, 0.0E+00,    1,    1,    1, 0.0E+00, 0.0E+00\r\n";
    const ROWS: &str =
        "    0,    0, 2.5E+00, 0.0E+00, 0.0E+00, 0.0E+00\r\n1,0,0.5D0,0\r\n1,1,0.25,-0.125,0,0\r\n";

    fn read(text: &str, convention: Option<Convention>) -> Result<Shape> {
        let options = ReadOptions { convention, ..Default::default() };
        parse(Path::new("a.tab"), text.as_bytes(), &options)
    }

    fn refusal(text: &str) -> String {
        match read(text, None) {
            Err(Error::Input(error)) => error.to_string(),
            other => panic!("not an input error: {other:?}"),
        }
    }

    #[test]
    fn header_says_the_normalisation() {
        let table = format!("{HEADER}{ROWS}");
        let shape = read(&table, None).expect("read");
        assert_eq!(shape.coefficients.mean(), 2.5);
        assert!((shape.coefficients.get(1, 0).0 - 0.5 * 3.0_f64.sqrt()).abs() <= 1e-15);
        let plain = read(&table.replace("1,    1,    1,", "1,    1,    0,"), None).expect("read");
        assert_eq!(plain.coefficients.get(1, 0).0, 0.5);
        let other = table.replace("1,    1,    1,", "1,    1,    2,");
        assert!(refusal(&other).contains("does not say how it is normalised"));
        assert_eq!(read(&other, Some(Convention::default())).expect("said"), shape);
        let schmidt = Convention { normalisation: Normalisation::Schmidt, ..Default::default() };
        let message = read(&table, Some(schmidt)).expect_err("contradiction").to_string();
        assert!(message.contains("the header says 4pi, csphase 1; asked for was schmidt"));
    }

    #[test]
    fn what_is_written_is_read() {
        let shape = read(&format!("{HEADER}{ROWS}"), None).expect("read");
        for normalisation in [Normalisation::FourPi, Normalisation::Unnormalised] {
            let convention = Convention { normalisation, ..Default::default() };
            let text =
                String::from_utf8(write(&shape, convention).expect("written")).expect("UTF-8");
            assert!(is_shadr(&text) && text.starts_with(' '));
            let widths: Vec<usize> = text.lines().map(str::len).collect();
            // The record's definition: 137 bytes of header before the pad, 107 of a row.
            assert!(text.lines().next().is_some_and(|l| l[..138].ends_with(',')));
            assert_eq!(widths[1..], [107, 107, 107]);
            let back = read(&text, None).expect("read");
            let pairs = back.coefficients.sines().iter().zip(shape.coefficients.sines());
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() <= 1e-16));
        }
        let ortho = Convention { normalisation: Normalisation::Orthonormal, ..Default::default() };
        assert!(
            write(&shape, ortho).expect_err("refused").to_string().contains("cannot say ortho")
        );
    }

    #[test]
    fn broken_tables_are_refused() {
        for (text, expected) in [
            (String::new(), "a.tab:1: a SHADR table begins with eight numbers"),
            (ROWS.to_owned(), "read a table without header as text"),
            (HEADER.to_owned(), "there are no coefficients here"),
            (
                format!("{HEADER}0,0,1,0\r\n"),
                "announces degree 1, order 1; the table ends with degree 0",
            ),
            (
                format!("{HEADER}1,0,1,0\r\n"),
                "a.tab:2: degree 1, order 0 stands here, where degree 0",
            ),
            (format!("{HEADER}{ROWS}1,1,1,0\r\n"), "a second time"),
            (format!("{HEADER}{ROWS}2,3,1,0\r\n"), "the order cannot exceed the degree"),
            (format!("{HEADER}{ROWS}2,0,1,0\r\n"), "ends before degree 2, order 1"),
            (format!("{HEADER}0,0,inf,0\r\n"), "`inf` is not a finite number"),
            (format!("{HEADER}0,0\r\n"), "2 columns"),
            (
                HEADER.replace("    1,    1,", "999999999,999999999,") + ROWS,
                "announces degree 999999999",
            ),
        ] {
            let message = refusal(&text);
            assert!(message.contains(expected), "{message}");
        }
    }
}
