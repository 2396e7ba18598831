//! What the readers of coefficient files have in common: the order of degrees and orders, numbers
//! as text, the convention.

use std::path::Path;
use std::str::FromStr;

use crate::error::{Advice, InputError};
use crate::io::decimal::real;
use crate::sh::{Coefficients, Convention};
use crate::{Error, Result};

/// Collects coefficients of one convention, degree by degree, order 0 to l in each: the one order
/// that most files have.
#[derive(Debug)]
pub(super) struct Triangle {
    convention: Convention,
    next: (usize, usize),
    a: Vec<f64>,
    b: Vec<f64>,
}

impl Triangle {
    pub(super) const fn new(convention: Convention) -> Self {
        Self { convention, next: (0, 0), a: Vec::new(), b: Vec::new() }
    }

    /// Returns the degree and order that must come next.
    pub(super) const fn next(&self) -> (usize, usize) {
        self.next
    }

    /// Takes the coefficients that come next, or says why they cannot be.
    pub(super) fn push(&mut self, (c, s): (f64, f64)) -> Result<(), String> {
        let (l, m) = self.next;
        if let Some(bad) = [c, s].iter().find(|v| !v.is_finite()) {
            return Err(format!("`{bad}` (degree {l}, order {m}) is not a finite number"));
        }
        if m == 0 && s != 0.0 {
            return Err(format!(
                "S of order 0 is {s:e} at degree {l}: it must be 0, since sin(0) is"
            ));
        }
        let (a, b) = self.convention.import(l, m, (c, s)).map_err(|e| e.to_string())?;
        self.a.push(a);
        self.b.push(b);
        self.next = if m < l { (l, m + 1) } else { (l + 1, 0) };
        Ok(())
    }

    /// Closes the series after its last whole degree; `last` is the line on which it ended, where
    /// there are lines.
    pub(super) fn finish(self, path: &Path, last: Option<usize>) -> Result<Coefficients> {
        let (l, m) = self.next;
        if (l, m) == (0, 0) {
            return Err(InputError::new(path, "there are no coefficients here").into());
        }
        if m == 0 {
            return Coefficients::from_parts(l - 1, self.a, self.b);
        }
        let message =
            format!("the file ends before degree {l}, order {m}: a degree has all orders 0 to {l}");
        let mut error = InputError::new(path, message)
            .help(format!("remove the rows of degree {l}, or make the file anew"));
        error.line = last;
        Err(error.into())
    }
}

/// Collects (cosine, sine) coefficients that can be asked for in any order.
pub(super) fn collect(
    path: &Path,
    lmax: usize,
    convention: Convention,
    value: impl Fn(usize, usize) -> (f64, f64),
) -> Result<Coefficients> {
    let mut triangle = Triangle::new(convention);
    for l in 0..=lmax {
        for m in 0..=l {
            triangle.push(value(l, m)).map_err(|message| InputError::new(path, message))?;
        }
    }
    triangle.finish(path, None)
}

/// Chooses between the convention that the file has and the one that the caller gives; `subject`
/// says whose it is ("the file says").
pub(super) fn agreed(
    path: &Path,
    subject: &str,
    stated: Option<Convention>,
    given: Option<Convention>,
) -> Result<Convention> {
    match (stated, given) {
        (Some(stated), Some(given)) if stated != given => Err(InputError::new(
            path,
            format!(
                "{subject} {}, csphase {}; asked for was {}, csphase {}",
                stated.normalisation,
                stated.phase.csphase(),
                given.normalisation,
                given.phase.csphase()
            ),
        )
        .advise(Advice::LeaveOutConvention)
        .into()),
        (Some(convention), _) | (None, Some(convention)) => Ok(convention),
        (None, None) => Err(InputError::new(path, "the file does not say how it is normalised")
            .advise(Advice::StateConvention)
            .into()),
    }
}

/// Reads bytes as text, or says on which line that ends.
pub(super) fn text<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a str> {
    std::str::from_utf8(bytes).map_err(|e| {
        let line = bytes[..e.valid_up_to()].split(|b| *b == b'\n').count();
        let error = InputError::new(path, "this is not UTF-8 text, so no coefficient text");
        Error::from(error.at(line, None))
    })
}

/// Lists the lines that hold something, trimmed, with their numbers; comments begin with `#`.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (&str, usize)> + Clone {
    let lines = text.lines().map(str::trim).zip(1..);
    lines.filter(|(line, _)| !line.is_empty() && !line.starts_with('#'))
}

/// Splits a row at commas and blanks.
pub(super) fn cells(line: &str) -> Vec<&str> {
    each_cell(line).collect()
}

/// Goes through the cells of a row, of which one that is no row may have millions.
pub(super) fn each_cell(line: &str) -> impl Iterator<Item = &str> {
    line.split([',', ' ', '\t']).filter(|cell| !cell.is_empty())
}

/// Whether a row begins with these two cells.
pub(super) fn begins(line: &str, place: [&str; 2]) -> bool {
    each_cell(line).take(2).eq(place)
}

/// Checks that a row stands where it must.
pub(super) fn check_place(found: (usize, usize), expected: (usize, usize)) -> Result<(), String> {
    let ((degree, order), (l, m)) = (found, expected);
    let place = format!("degree {degree}, order {order}");
    if order > degree {
        Err(format!("{place}: the order cannot exceed the degree"))
    } else if found < expected {
        Err(format!("{place} stands here a second time, or out of order"))
    } else if found > expected {
        Err(format!("{place} stands here, where degree {l}, order {m} must come first"))
    } else {
        Ok(())
    }
}

/// Reads a degree or an order.
pub(super) fn number(text: &str, what: &str) -> Result<usize, String> {
    usize::from_str(text)
        .map_err(|_| format!("`{text}` is no {what}: expected a whole number from 0"))
}

/// Reads a coefficient, with the exponents of Fortran, too.
pub(super) fn coefficient(text: &str) -> Result<f64, String> {
    match real(text) {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(format!("`{text}` is not a finite number")),
        None => Err(format!("`{text}` is not a number")),
    }
}

/// Writes 17 significant digits with a signed exponent of at least two digits, as C, Fortran and
/// Python do.
pub(super) fn digits(value: f64) -> String {
    let text = format!("{value:.16e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let (sign, exponent) = exponent.strip_prefix('-').map_or(('+', exponent), |e| ('-', e));
    format!("{mantissa}e{sign}{exponent:0>2}")
}

/// Asks for a table whose last line is ended: of one that is cut within a number nothing else would
/// tell.
pub(super) fn ended(path: &Path, bytes: &[u8]) -> Result<()> {
    if bytes.is_empty() || bytes.ends_with(b"\n") {
        return Ok(());
    }
    let line = bytes.split(|b| *b == b'\n').count();
    Err(InputError::new(path, "the last line has no end: the file may be cut off within it")
        .at(line, None)
        .help("if it is whole, end it with a line break; else get it anew")
        .into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_those_of_python() {
        for (value, expected) in [
            (0.0, "0.0000000000000000e+00"),
            (-1.5, "-1.5000000000000000e+00"),
            (0.09, "8.9999999999999997e-02"),
            (1e300, "1.0000000000000001e+300"),
            (5e-324, "4.9406564584124654e-324"),
        ] {
            assert_eq!(digits(value), expected);
        }
    }

    #[test]
    fn triangle_takes_whole_degrees_only() {
        let path = Path::new("a");
        let mut triangle = Triangle::new(Convention::default());
        assert!(triangle.push((f64::NAN, 0.0)).is_err() && triangle.push((1.0, 0.5)).is_err());
        triangle.push((1.0, 0.0)).expect("a mean");
        assert_eq!(triangle.next(), (1, 0));
        triangle.push((0.5, 0.0)).expect("degree 1");
        let message = triangle.finish(path, Some(7)).expect_err("cut").to_string();
        assert!(message.starts_with("a:7: the file ends before degree 1, order 1"), "{message}");
        let flat =
            collect(path, 2, Convention::default(), |l, _| (f64::from(u8::from(l == 0)), 0.0));
        assert_eq!(flat.expect("a ball").mean(), 1.0);
    }
}
