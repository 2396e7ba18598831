//! Coefficient text in the second layout of pyshtools ("dov"): a line `l, m, value` for each
//! cosine, one `l, -m, value` for each sine.
//!
//! Ours begins with the comments of `annotated.rs`, which pyshtools skips. A fourth column holds
//! errors, which are not read.

use std::path::Path;

use super::recognise::PLACES;
use super::rows::{Triangle, begins, cells, coefficient, digits, lines};
use super::shtools_text::header_lines;
use super::{ReadOptions, annotated};
use crate::Result;
use crate::error::InputError;
use crate::fit::Shape;
use crate::sh::{Coefficients, Convention};

/// Writes a shape as text with signed orders, 17 significant digits a number.
///
/// # Errors
/// As [`shtools_text::write`](super::shtools_text::write).
pub fn write(shape: &Shape, convention: Convention) -> Result<Vec<u8>> {
    annotated::write(shape, convention, |l, m, (c, s)| {
        let cosine = format!("{l}, {m}, {}\n", digits(c));
        if m == 0 { cosine } else { format!("{cosine}{l}, -{m}, {}\n", digits(s)) }
    })
}

/// Reads text with signed orders: ours, or a bare one of pyshtools in the given convention; degrees
/// from 0 up, orders 0, 1, -1, 2, -2 to -l, none missing. Memory is bound by the size of the text.
///
/// # Errors
/// As [`shtools_text::parse`](super::shtools_text::parse).
pub fn parse(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Shape> {
    annotated::parse(path, bytes, options, rows)
}

/// Returns this layout from the other: the fourth row is `1, -1, value`.
pub(super) fn is_dov(text: &str) -> bool {
    let mut rows = lines(text).skip(header_lines(text));
    let mut starts = |place| rows.next().is_some_and(|(line, _)| begins(line, place));
    PLACES.into_iter().all(&mut starts)
}

fn rows(path: &Path, text: &str, ours: bool, convention: Convention) -> Result<Coefficients> {
    let mut triangle = Triangle::new(convention);
    let mut cosine = None;
    let skipped = if ours { 0 } else { header_lines(text) };
    for (line, number) in lines(text).skip(skipped) {
        take(line, &mut cosine, &mut triangle)
            .map_err(|message| InputError::new(path, message).at(number, None))?;
    }
    let last = text.lines().count();
    if cosine.is_some() {
        let (l, m) = triangle.next();
        let message = format!("the file ends before degree {l}, order -{m}");
        return Err(InputError::new(path, message).at(last, None).help("make it anew").into());
    }
    triangle.finish(path, Some(last))
}

/// Takes one row; the cosine of an order waits for its sine.
fn take(line: &str, cosine: &mut Option<f64>, triangle: &mut Triangle) -> Result<(), String> {
    let (l, m) = triangle.next();
    let sign = if cosine.is_some() { "-" } else { "" };
    let cells = cells(line);
    let (degree, order, value) = match cells.as_slice() {
        [degree, order, value] | [degree, order, value, _] => (degree, order, coefficient(value)?),
        _ => {
            return Err(format!(
                "{} columns, where a row is `l, m, value` (one more may hold an error)",
                cells.len()
            ));
        }
    };
    if (*degree, *order) != (l.to_string().as_str(), format!("{sign}{m}").as_str()) {
        return Err(format!(
            "degree {degree}, order {order} stands here, where degree {l}, order {sign}{m} must \
             come"
        ));
    }
    match (cosine.take(), m) {
        (Some(cosine), _) => triangle.push((cosine, value)),
        (None, 0) => triangle.push((value, 0.0)),
        (None, _) => {
            *cosine = Some(value);
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Error;

    fn read(text: &str) -> Result<Shape> {
        let convention = Some(Convention::default());
        parse(
            Path::new("a.dov"),
            text.as_bytes(),
            &ReadOptions { convention, ..Default::default() },
        )
    }

    fn refusal(text: &str) -> String {
        match read(text) {
            Err(Error::Input(error)) => error.to_string(),
            other => panic!("not an input error: {other:?}"),
        }
    }

    #[test]
    fn ball_and_short_texts() {
        assert_eq!(read("0 0 2.5").expect("a ball").coefficients.mean(), 2.5);
        assert!(refusal("").contains("no coefficients"));
        assert!(refusal("0 0 1\n1 0 1\n1 1 1\n").contains("ends before degree 1, order -1"));
        assert!(refusal("0 0 1\n1 0 1\n").contains("ends before degree 1, order 1"));
    }

    #[test]
    fn what_is_written_is_read_and_recognised() {
        let mut shape = read("0 0 1\n1 0 2\n1 1 3\n1 -1 4\n").expect("read");
        shape.centre.x = 0.5;
        let text = write(&shape, Convention::default()).expect("written");
        let back = parse(Path::new("a.dov"), &text, &ReadOptions::default()).expect("read");
        assert_eq!(back.centre, shape.centre);
        let apart = back.coefficients.sines()[2] - shape.coefficients.sines()[2];
        assert!(apart.abs() <= 1e-15);
        assert!(is_dov(std::str::from_utf8(&text).expect("UTF-8")));
        assert!(!is_dov("0 0 1\n1 0 2\n1 1 3 4\n2 0 1\n"));
    }

    #[test]
    fn broken_rows_are_refused_with_their_line() {
        let start = "0 0 1\n1 0 2 0.1\n";
        for (row, expected) in [
            ("1 -1 3", "degree 1, order -1 stands here, where degree 1, order 1 must come"),
            ("2 0 3", "degree 2, order 0 stands here"),
            ("1 1", "2 columns"),
            ("1 1 nan", "`nan` is not a finite number"),
            ("1 1 1\n1 1 1", "degree 1, order 1 stands here, where degree 1, order -1 must come"),
        ] {
            assert!(refusal(&format!("{start}{row}\n")).contains(expected), "{row}");
        }
    }
}
