//! The table of the International Centre for Global Earth Models (`.gfc`): a header of keywords up
//! to `end_of_head`, then a row `gfc l m C S` for each degree and order, in any order of rows, with
//! what errors they have.
//!
//! Numbers are taken as they stand: `radius` and `earth_gravity_constant` are what a gravity field
//! is made of, and no part of a shape. Degrees 0 and 1 may lack, as they do where heights or a
//! field are about a centre of mass. Terms that change with time are refused but for the static
//! part of `gfct`.

use std::collections::HashMap;
use std::path::Path;

use super::ReadOptions;
use super::rows::{agreed, coefficient, collect, lines, number, text};
use crate::Result;
use crate::error::InputError;
use crate::fit::Shape;
use crate::sh::{CondonShortley, Convention, Normalisation};

const END: &str = "end_of_head";

/// A degree and an order.
type Place = (usize, usize);

/// Reads a table; `path` is for messages. Memory is bound by the size of the text.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) with line: not UTF-8, a header without end, another
/// normalisation than the given one, a row that is none, stands twice or changes with time, rows
/// that lack.
pub fn parse(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Shape> {
    let text = text(path, bytes)?;
    let header = Header::read(path, text)?;
    let convention = agreed(path, "the header says", Some(header.convention), options.convention)?;
    let mut found = HashMap::new();
    let mut lmax = 0;
    for (line, at) in lines(text).filter(|(_, at)| *at > header.lines) {
        let fault = |message| InputError::new(path, message).at(at, None);
        let (place, pair) = row(line).map_err(fault)?;
        lmax = lmax.max(place.0);
        if found.insert(place, pair).is_some() {
            let message =
                format!("degree {}, order {} stands here a second time", place.0, place.1);
            return Err(fault(message).into());
        }
    }
    if let Some((l, m)) = lacking(lmax, &found) {
        let error = InputError::new(path, format!("degree {l}, order {m} is missing"));
        return Err(error.help("part of the table is lost: get it anew").into());
    }
    if found.is_empty() || header.degree.is_some_and(|degree| degree != lmax) {
        let degree = header.degree.unwrap_or(0);
        let message = format!("the header announces degree {degree}, and the rows end with {lmax}");
        return Err(InputError::new(path, message).help("part of it is lost: get it anew").into());
    }
    let value = |l: usize, m: usize| found.get(&(l, m)).copied().unwrap_or_default();
    Ok(Shape::new(collect(path, lmax, convention, value)?))
}

/// Returns the convention that the header states.
pub(super) fn convention(path: &Path, bytes: &[u8]) -> Result<Option<Convention>> {
    Ok(Some(Header::read(path, text(path, bytes)?)?.convention))
}

/// Whether a text begins with such a header.
pub(super) fn is_icgem(head: &str) -> bool {
    head.lines().any(|line| line.trim_start().starts_with(END))
}

/// Finds the first place from degree 2 on that has no row.
fn lacking(lmax: usize, found: &HashMap<Place, (f64, f64)>) -> Option<Place> {
    let places = (2..=lmax).flat_map(|l| (0..=l).map(move |m| (l, m)));
    places.into_iter().find(|place| !found.contains_key(place))
}

/// What the header says of the coefficients.
struct Header {
    convention: Convention,
    degree: Option<usize>,
    lines: usize,
}

impl Header {
    fn read(path: &Path, text: &str) -> Result<Self> {
        let mut header = Self { convention: Convention::default(), degree: None, lines: 0 };
        for (line, at) in text.lines().zip(1..) {
            let mut words = line.split_whitespace();
            let (key, value) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
            header.lines = at;
            if key.starts_with(END) {
                return Ok(header);
            }
            header.take(key, value).map_err(|m| InputError::new(path, m).at(at, None))?;
        }
        let message = format!("the header of an ICGEM table ends with `{END}`, which is not here");
        Err(InputError::new(path, message).into())
    }

    /// Takes what a line says, which may be any remark.
    fn take(&mut self, key: &str, value: &str) -> Result<(), String> {
        match (key, value) {
            ("max_degree", _) => self.degree = Some(number(value, "degree")?),
            ("norm", "unnormalized" | "unnormalised") => {
                let phase = CondonShortley::Without;
                self.convention = Convention { normalisation: Normalisation::Unnormalised, phase };
            }
            ("norm", "fully_normalized" | "fully_normalised") => {}
            ("norm", other) => {
                return Err(format!(
                    "`{other}` is no norm: expected fully_normalized or unnormalized"
                ));
            }
            _ => {}
        }
        Ok(())
    }
}

/// Reads a row: its degree and order, its coefficients.
fn row(line: &str) -> Result<(Place, (f64, f64)), String> {
    let mut words = line.split_whitespace();
    let key = words.next().unwrap_or("");
    if ["trnd", "dot", "acos", "asin"].contains(&key) {
        return Err(format!(
            "`{key}` is a term that changes with time; a shape does not: remove such rows to keep \
             the static part"
        ));
    }
    let (Some(l), Some(m), Some(c), Some(s)) =
        (words.next(), words.next(), words.next(), words.next())
    else {
        return Err(format!("`{line}` is no row `gfc l m C S`"));
    };
    if !["gfc", "gfct"].contains(&key) {
        return Err(format!("`{key}` begins no row: expected gfc"));
    }
    let place = (number(l, "degree")?, number(m, "order")?);
    if place.1 > place.0 {
        return Err(format!("degree {l}, order {m}: the order cannot exceed the degree"));
    }
    Ok((place, (coefficient(c)?, coefficient(s)?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "a model of a stone\nproduct_type topography\nmodelname stone\n\
        radius 1.0\nmax_degree 2\nnorm fully_normalized\nerrors no\nkey L M C S\n\
        end_of_head ==========\ngfc 0 0 1.0D+00 0\ngfc 1 0 0.5e0 0.0\ngfc 2 0 0.1 0 1e-3 0\n\
        gfct 1 1 0.25 -1.25D-01 0 0 20050101\ngfc 2 1 0 0\ngfc 2 2 0 0.5\n";

    fn read(text: &str, convention: Option<Convention>) -> Result<Shape> {
        let options = ReadOptions { convention, ..Default::default() };
        parse(Path::new("a.gfc"), text.as_bytes(), &options)
    }

    #[test]
    fn rows_are_read_in_any_order_and_norm() {
        let c = read(TABLE, None).expect("read").coefficients;
        assert!(is_icgem(TABLE) && c.lmax() == 2 && c.mean() == 1.0);
        assert!((c.get(1, 0).0 - 0.5 * 3.0_f64.sqrt()).abs() <= 1e-15);
        assert!((c.get(1, 1).1 - 0.125 * 6.0_f64.sqrt()).abs() <= 1e-15);
        let plain = read(&TABLE.replace("fully_", "un"), None);
        assert_eq!(plain.expect("read").coefficients.get(1, 0).0, 0.5);
        let centred = "max_degree 2\nend_of_head\ngfc 2 0 1 0\ngfc 2 1 0 0\ngfc 2 2 0 0\n";
        let c = read(centred, Some(Convention::default())).expect("read").coefficients;
        assert_eq!((c.mean(), c.get(1, 1)), (0.0, (0.0, 0.0)));
    }

    #[test]
    fn broken_tables_are_refused() {
        for (old, new, expected) in [
            ("end_of_head", "end", "ends with `end_of_head`"),
            ("fully_normalized", "odd", "a.gfc:6: `odd` is no norm"),
            ("max_degree 2", "max_degree 3", "announces degree 3, and the rows end with 2"),
            ("gfc 2 1 0 0\n", "", "degree 2, order 1 is missing"),
            ("gfc 2 1 0 0", "gfc 2 2 0 0", "a.gfc:15: degree 2, order 2 stands here a second time"),
            ("gfc 2 1 0 0", "gfc 2 3 0 0", "a.gfc:14: degree 2, order 3: the order cannot"),
            ("gfc 2 1 0 0", "trnd 2 1 0 0", "`trnd` is a term that changes with time"),
            ("gfc 2 1 0 0", "fc 2 1 0 0", "`fc` begins no row"),
            ("gfc 2 1 0 0", "gfc 2 1 0", "is no row `gfc l m C S`"),
            ("gfc 2 1 0 0", "gfc 2 1 0 inf", "`inf` is not a finite number"),
            ("gfc 2 0 0.1 0", "gfc 2 0 0.1 1", "S of order 0"),
            ("gfc 2 2 0 0.5", "gfc 99999999 2 0 0.5", "degree 2, order 2 is missing"),
        ] {
            let message =
                read(&TABLE.replacen(old, new, 1), None).expect_err("refused").to_string();
            assert!(message.contains(expected), "{message}");
        }
        let ortho = Convention { normalisation: Normalisation::Orthonormal, ..Default::default() };
        let message = read(TABLE, Some(ortho)).expect_err("refused").to_string();
        assert!(
            message.contains("the header says 4pi, csphase 1; asked for was ortho"),
            "{message}"
        );
        assert!(read("end_of_head\n", None).is_err());
    }
}
