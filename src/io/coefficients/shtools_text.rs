//! Coefficient text in the layout of pyshtools ("shtools"): a line `l, m, C, S` for each degree and
//! order, as its `shwrite` makes it.
//!
//! Comment lines, which `SHCoeffs.from_file` skips, come first and carry what the layout cannot
//! say: see `annotated.rs`. Files of pyshtools may have one or two header lines before the rows,
//! which are passed over, and two more columns of errors.

use std::path::Path;

use super::rows::{
    Triangle, begins, cells, check_place, coefficient, digits, each_cell, lines, number,
};
use super::{ReadOptions, annotated};
use crate::Result;
use crate::error::InputError;
use crate::fit::Shape;
use crate::sh::{Coefficients, Convention};

/// How many header lines pyshtools writes at most.
const HEADER_LINES: usize = 2;

/// Writes a shape as coefficient text, 17 significant digits a number: [`parse`] brings back what
/// the convention keeps (all bits at m = 0 of Schmidt normalisation, 2 units in the last place
/// elsewhere; unnormalised as far as f64 reaches).
///
/// # Errors
/// [`Error::Numeric`](crate::Error::Numeric) when the degree is too high for unnormalised
/// coefficients.
pub fn write(shape: &Shape, convention: Convention) -> Result<Vec<u8>> {
    annotated::write(shape, convention, |l, m, (c, s)| {
        format!("{l}, {m}, {}, {}\n", digits(c), digits(s))
    })
}

/// Reads coefficient text: ours, or a bare one of pyshtools in the given convention; `path` is for
/// messages.
///
/// Rows run from degree 0 up, order 0 to l, none missing. Separators are commas or blanks. As in
/// pyshtools, S may lack at m = 0, and two more columns hold errors, which are not read. Memory is
/// bound by the size of the text.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) with line and remedy: not UTF-8, no convention or a
/// contradictory one, a row that is missing, out of order, duplicate, of a wrong number of columns,
/// not finite, cut off, or beyond f64; a broken comment line of ours.
pub fn parse(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Shape> {
    annotated::parse(path, bytes, options, rows)
}

/// Reads all rows in the one order they may have.
fn rows(path: &Path, text: &str, ours: bool, convention: Convention) -> Result<Coefficients> {
    let mut triangle = Triangle::new(convention);
    let skipped = if ours { 0 } else { header_lines(text) };
    for (line, number) in lines(text).skip(skipped) {
        row(line, triangle.next())
            .and_then(|pair| triangle.push(pair))
            .map_err(|message| InputError::new(path, message).at(number, None))?;
    }
    triangle.finish(path, Some(text.lines().count()))
}

/// Counts the lines before the row of degree 0 that are no rows: headers, whose meaning is their
/// author's. A first line that looks like a row is one, so that no broken row passes for a header.
pub(super) fn header_lines(text: &str) -> usize {
    let is_row = |line: &str| {
        let mut cells = each_cell(line);
        let whole = cells.by_ref().take(2).filter(|cell| cell.parse::<i64>().is_ok());
        whole.count() == 2 && cells.next().is_some()
    };
    let starts = |line: &str| begins(line, ["0", "0"]);
    let found =
        lines(text).take(HEADER_LINES + 1).position(|(line, _)| is_row(line) || starts(line));
    match found {
        Some(n) if lines(text).nth(n).is_some_and(|(line, _)| starts(line)) => n,
        _ => 0,
    }
}

/// Reads one row, which must be that of degree `l`, order `m`.
fn row(line: &str, (l, m): (usize, usize)) -> Result<(f64, f64), String> {
    let cells = cells(line);
    let (degree, order, c, s) = match cells.as_slice() {
        [degree, order, c] if m == 0 => (degree, order, c, &"0"),
        [degree, order, c, s] | [degree, order, c, s, _, _] => (degree, order, c, s),
        _ => {
            return Err(format!(
                "{} columns, where a row is `l, m, C, S` (two more may hold errors)",
                cells.len()
            ));
        }
    };
    check_place((number(degree, "degree")?, number(order, "order")?), (l, m))?;
    Ok((coefficient(c)?, coefficient(s)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Error;
    use crate::fit::Source;
    use crate::io::output::SOFTWARE;
    use crate::sh::{CondonShortley, Normalisation};
    use glam::DVec3;
    use proptest::prelude::*;

    /// Made by pyshtools 4.14.1; tests/data/README.md says how.
    const PYSHTOOLS: &str = include_str!("../../../tests/data/pyshtools_degree6_4pi.sh");

    const PATH: &str = "shape.txt";

    fn read(text: &str, convention: Option<Convention>) -> Result<Shape> {
        let options = ReadOptions { convention, ..ReadOptions::default() };
        parse(Path::new(PATH), text.as_bytes(), &options)
    }

    fn bare(text: &str) -> Result<Shape> {
        read(text, Some(Convention::default()))
    }

    fn refusal(result: Result<Shape>) -> String {
        match result {
            Err(Error::Input(error)) => error.to_string(),
            other => panic!("not an input error: {other:?}"),
        }
    }

    fn conventions() -> impl Iterator<Item = Convention> {
        Normalisation::ALL.into_iter().flat_map(|normalisation| {
            [CondonShortley::Without, CondonShortley::With]
                .map(|phase| Convention { normalisation, phase })
        })
    }

    fn shape(lmax: usize) -> Shape {
        let mut coefficients = Coefficients::zeros(lmax);
        for l in 0..=lmax {
            for m in 0..=l {
                let x = (7 * l + 3 * m + 1) as f64;
                coefficients.set(l, m, x.sin() / x, x.cos() / x);
            }
        }
        Shape {
            centre: DVec3::new(0.1, -1e-9, 1.0 / 3.0),
            source: Some(Source::new(Path::new("tête \"1\"\n𝛑.obj"), b"v 0 0 0")),
            truncated_from: Some(64),
            ..Shape::new(coefficients)
        }
    }

    fn written(shape: &Shape, convention: Convention) -> String {
        String::from_utf8(write(shape, convention).expect("written")).expect("UTF-8")
    }

    #[test]
    fn degree_zero_alone_is_a_ball() {
        let shape = bare("0 0 2.5").expect("read");
        assert_eq!(shape, bare("\n0,0,2.5,0\r\n# end\n").expect("read"));
        assert_eq!((shape.coefficients.lmax(), shape.coefficients.mean()), (0, 2.5));
        assert_eq!(shape, Shape::new(shape.coefficients.clone()));
    }

    #[test]
    fn file_of_pyshtools_is_read_once_its_convention_is_given() {
        let shape = bare(PYSHTOOLS).expect("read");
        assert_eq!(shape.coefficients.lmax(), 6);
        assert!((shape.coefficients.mean() - 0.09).abs() <= 1e-17);
        let (a, _) = shape.coefficients.get(1, 1);
        assert!((a + 1.493_727_687_542_349_5e-3 * 6.0_f64.sqrt()).abs() <= 1e-17);
        let message = refusal(read(PYSHTOOLS, None));
        assert!(
            message.starts_with("shape.txt: the file does not say how it is normalised\n  help: ")
        );
        assert!(message.contains("state normalisation and phase"));
    }

    #[test]
    fn rows_are_written_to_the_byte_as_pyshtools_writes_them() {
        let shape = bare(PYSHTOOLS).expect("read");
        let schmidt = Convention { normalisation: Normalisation::Schmidt, ..Default::default() };
        let same_rows = |text: &str, reference: &str| {
            let rows = text.lines().filter(|line| !line.starts_with('#'));
            rows.eq(reference.lines())
        };
        // Zonal Schmidt rows pass unchanged, so their bytes must be those that pyshtools writes for
        // the same numbers.
        let zonal = "0, 0, 8.9999999999999997e-02, 0.0000000000000000e+00\n";
        let ball = read(zonal, Some(schmidt)).expect("read");
        assert!(same_rows(&written(&ball, schmidt), zonal));
        // 4pi numbers may move by two units in the last of 17 digits; to 15 digits they are the
        // same text.
        let cut = |line: &str| -> Vec<String> {
            line.split(", ")
                .map(|cell| cell.parse().map_or(String::new(), |v: f64| format!("{v:.14e}")))
                .collect()
        };
        let text = written(&shape, Convention::default());
        let rows: Vec<_> = text.lines().filter(|line| !line.starts_with('#')).map(cut).collect();
        assert_eq!(rows, PYSHTOOLS.lines().map(cut).collect::<Vec<_>>());
    }

    #[test]
    fn comments_carry_everything_and_come_back() {
        let shape = shape(3);
        for convention in conventions() {
            let text = written(&shape, convention);
            assert!(text.starts_with(&format!("# {SOFTWARE} coefficients\n# normalisation: ")));
            assert!(text.is_ascii());
            let back = read(&text, None).expect("read");
            assert_eq!((back.centre, &back.source), (shape.centre, &shape.source));
            assert_eq!(back.truncated_from, Some(64));
            assert_eq!(read(&text, Some(convention)).expect("same convention"), back);
        }
        let plain = Shape::new(Coefficients::zeros(2));
        assert_eq!(read(&written(&plain, Convention::default()), None).expect("read"), plain);
    }

    #[test]
    fn contradicting_convention_is_refused() {
        let text = written(&shape(2), Convention::default());
        let ortho = Convention { normalisation: Normalisation::Orthonormal, ..Default::default() };
        let message = refusal(read(&text, Some(ortho)));
        assert!(message.contains("the file says 4pi, csphase 1; asked for was ortho, csphase 1"));
        assert!(message.contains("state no normalisation"));
    }

    #[test]
    fn broken_rows_are_refused_with_their_line() {
        let start = "0, 0, 1, 0\n1, 0, 1, 0\n";
        for (row, expected) in [
            (
                "2, 0, 1, 0",
                "degree 2, order 0 stands here, where degree 1, order 1 must come first",
            ),
            ("1, 0, 1, 0", "degree 1, order 0 stands here a second time, or out of order"),
            ("1, 2, 1, 0", "degree 1, order 2: the order cannot exceed the degree"),
            ("1, 1, NaN, 0", "`NaN` is not a finite number"),
            ("1, 1, 0, -inf", "`-inf` is not a finite number"),
            ("1, 1, 1e999, 0", "`1e999` is not a finite number"),
            ("1, 1, 1.0D-x, 0", "`1.0D-x` is not a number"),
            ("1, 1, (1+2j), 0", "`(1+2j)` is not a number"),
            ("1, 1, 2", "3 columns, where a row is `l, m, C, S` (two more may hold errors)"),
            ("1, 1, 2, 3, 4", "5 columns, where a row is `l, m, C, S` (two more may hold errors)"),
            ("1, -1, 2, 3", "`-1` is no order: expected a whole number from 0"),
            ("1.5, 1, 2, 3", "`1.5` is no degree: expected a whole number from 0"),
        ] {
            let message = refusal(bare(&format!("{start}{row}\n")));
            assert_eq!(message, format!("shape.txt:3: {expected}"));
        }
        let message = refusal(bare("0, 0, 1, 0.5\n"));
        assert!(message.starts_with("shape.txt:1: S of order 0 is 5e-1"));
    }

    #[test]
    fn text_without_its_end_or_beginning_is_refused() {
        for empty in ["", "\n\n", "# a comment\n"] {
            assert_eq!(refusal(bare(empty)), "shape.txt: there are no coefficients here");
        }
        let message = refusal(bare("0 0 1 0\n1 0 1 0\n1 1 1 0\n2 0 1 0\n"));
        assert!(message.starts_with("shape.txt:4: the file ends before degree 2, order 1"));
        let message = refusal(bare("1 0 1 0\n1 1 1 0\n"));
        assert!(message.contains("where degree 0, order 0 must come first"), "{message}");
        let whole = written(&shape(3), Convention::default());
        let message = refusal(read(whole.trim_end(), None));
        assert!(message.ends_with("the file is cut off within this line"), "{message}");
        let rows: Vec<&str> = whole.lines().collect();
        let message = refusal(read(&(rows[..rows.len() - 4].join("\n") + "\n"), None));
        assert!(message.contains("announces degree 3 and ends with degree 2"), "{message}");
    }

    #[test]
    fn every_cut_of_our_file_is_refused() {
        let whole = written(&shape(2), Convention::default());
        for end in 0..whole.len() {
            let cut = read(&whole[..end], None);
            assert!(cut.is_err(), "cut at {end}");
        }
    }

    #[test]
    fn announced_degree_takes_no_memory() {
        let whole = written(&shape(2), Convention::default());
        let text = whole.replace("# lmax: 2", "# lmax: 99999999999");
        assert!(refusal(read(&text, None)).contains("announces degree 99999999999"));
        let message = refusal(bare("18446744073709551615, 0, 1, 0\n"));
        assert!(message.contains("degree 0, order 0 must come first"), "{message}");
    }

    #[test]
    fn bytes_that_are_no_text_are_refused_with_their_line() {
        let error = parse(Path::new(PATH), b"0 0 1 0\n1 0 \xff\n", &ReadOptions::default());
        assert_eq!(refusal(error), "shape.txt:2: this is not UTF-8 text, so no coefficient text");
    }

    #[test]
    fn broken_comments_of_ours_are_refused_with_their_line() {
        let whole = written(&shape(1), Convention::default());
        for (good, bad, expected) in [
            (
                "normalisation: 4pi",
                "normalisation: full",
                "shape.txt:2: `full` is not a normalisation",
            ),
            ("csphase: 1", "csphase: 0", "shape.txt:3: `0` is not a csphase"),
            ("unit: m", "unit: mm", "shape.txt:4: `mm` is no unit: expected m"),
            ("centre: 0.1", "centre: nan", "shape.txt:5: `nan"),
            ("centre: 0.1", "centre: 1 1", "expected three numbers, metres"),
            ("source: \"", "source: ", "expected a name in quotes"),
            ("fnv1a64:", "md5:", "expected fnv1a64: and 16 hexadecimal digits"),
            ("lmax: 1", "lmax: one", "shape.txt:8: `one` is no lmax: expected a degree"),
            ("# csphase: 1\n", "", "shape.txt:1: the comments lack `csphase`"),
        ] {
            let message = refusal(read(&whole.replacen(good, bad, 1), None));
            assert!(message.contains(expected), "{message}");
        }
        let later = whole.replace("# unit: m", "# unit: m\n# colour: blue\n# a remark");
        assert_eq!(read(&later, None).expect("read"), read(&whole, None).expect("read"));
    }

    #[test]
    fn comments_of_others_mean_nothing() {
        let text = "# normalisation: ortho\n# centre: here\n0 0 1 0\n";
        assert!(read(text, None).is_err());
        assert_eq!(bare(text).expect("read").coefficients.mean(), 1.0);
    }

    #[test]
    fn exponents_of_fortran_are_read() {
        let fortran = bare("0 0 1.0D+00 0\n1 0 -2.5d-01 0.0D0\n1 1 3.D2 4.D-1\n").expect("read");
        assert_eq!(fortran, bare("0 0 1\n1 0 -0.25\n1 1 300 0.4\n").expect("read"));
    }

    #[test]
    fn error_columns_are_passed_over() {
        let with_errors = bare("0 0 1 0 0.1 0\n1 0 2 0 0.1 0\n1 1 3 4 0.1 0.1\n").expect("read");
        assert_eq!(with_errors, bare("0 0 1\n1 0 2\n1 1 3 4\n").expect("read"));
    }

    #[test]
    fn header_lines_of_pyshtools_are_passed_over() {
        let rows = "0 0 1\n1 0 2\n1 1 3 4\n";
        let expected = bare(rows).expect("read");
        for header in ["1738.0, 4902.8, 0, 1\n", "radius\n# note\n\n1.5 2.5 3 4 5\n", "0.0 0.0\n"] {
            assert_eq!(bare(&format!("{header}{rows}")).expect(header), expected);
        }
        // Three are too many, and what looks like a row is no header.
        let message = refusal(bare(&format!("a\nb\nc\n{rows}")));
        assert!(message.starts_with("shape.txt:1: 1 columns"), "{message}");
        let message = refusal(bare(&format!("1 0 2\n{rows}")));
        assert!(message.starts_with("shape.txt:1: degree 1, order 0 stands here"), "{message}");
    }

    #[test]
    fn other_unit_than_the_stated_one_is_refused() {
        let text = written(&shape(1), Convention::default());
        let unit = |metres| ReadOptions { unit: Some(metres), ..ReadOptions::default() };
        assert!(parse(Path::new(PATH), text.as_bytes(), &unit(1.0)).is_ok());
        let message = refusal(parse(Path::new(PATH), text.as_bytes(), &unit(0.001)));
        assert!(message.contains("its unit is the metre") && message.contains("state no unit"));
    }

    #[test]
    fn unnormalised_numbers_end_where_f64_ends() {
        let unnorm =
            Convention { normalisation: Normalisation::Unnormalised, ..Default::default() };
        assert!(write(&shape(150), unnorm).is_ok());
        let message = write(&shape(151), unnorm).expect_err("too high").to_string();
        assert!(message.contains("degree 151") && message.contains("4pi"), "{message}");
        let message = refusal(read("0 0 1\n1 0 1\n1 1 1.7e308 0\n", Some(unnorm)));
        assert!(message.starts_with("shape.txt:3: the unnorm coefficients"), "{message}");
    }

    fn units_apart(a: f64, b: f64) -> u64 {
        a.abs().to_bits().abs_diff(b.abs().to_bits()) + u64::from(a.signum() != b.signum()) * 1000
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            cases: 64,
            rng_seed: prop::test_runner::RngSeed::Fixed(1),
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        #[test]
        fn numbers_come_back_to_two_units_in_the_last_place(
            values in prop::collection::vec((-1.0..1.0, -9.0..3.0), 72)
        ) {
            let mut coefficients = Coefficients::zeros(7);
            let mut numbers = values.iter().map(|(x, e): &(f64, f64)| x * 10.0_f64.powf(*e));
            for (l, m) in (0..=7).flat_map(|l| (0..=l).map(move |m| (l, m))) {
                let (a, b) = (numbers.next(), numbers.next());
                coefficients.set(l, m, a.unwrap_or(0.5), b.unwrap_or(0.5));
            }
            for convention in conventions() {
                let text = written(&Shape::new(coefficients.clone()), convention);
                let back = read(&text, None).expect("read").coefficients;
                for (l, m) in (0..=7).flat_map(|l| (0..=l).map(move |m| (l, m))) {
                    let ((a, b), (a2, b2)) = (coefficients.get(l, m), back.get(l, m));
                    // The factor is 1 or -1 only at m = 0 of schmidt and unnorm: there not a bit
                    // may move.
                    let exact = convention.factor(l, m).expect("in range").abs() == 1.0;
                    let allowed = if exact { 0 } else { 2 };
                    prop_assert!(units_apart(a, a2) <= allowed && units_apart(b, b2) <= allowed);
                }
            }
        }
    }
}
