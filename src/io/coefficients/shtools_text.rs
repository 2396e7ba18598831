//! Coefficient text in the layout of pyshtools: a line `l, m, C, S` for each degree and order, as its `shwrite` makes it.
//!
//! Comment lines, which `SHCoeffs.from_file` skips, come first and carry what the layout cannot say:
//!
//! ```text
//! # harmolux 0.1.0 coefficients
//! # normalisation: 4pi
//! # csphase: 1
//! # unit: m
//! # centre: 0.0 0.0 0.0
//! # source: "head.obj"
//! # source-hash: fnv1a64:85944171f73967e8
//! # lmax: 32
//! # truncated-from: 64
//! 0, 0, 8.9999999999999997e-02, 0.0000000000000000e+00
//! ```
//!
//! `source`, `source-hash` and `truncated-from` may lack. A text that does not begin with the first of these lines is a bare one: its
//! comments mean nothing to us, its centre is the origin, its unit the metre, and its convention must be given.

use std::path::Path;
use std::str::FromStr;

use glam::DVec3;

use super::{Shape, Source, SourceHash};
use crate::error::InputError;
use crate::io::output::SOFTWARE;
use crate::sh::{Coefficients, CondonShortley, Convention, Normalisation};
use crate::{Error, Result};

/// Ends the first line of our files.
const TITLE: &str = "coefficients";

/// Names the keys of the comment lines.
const NORMALISATION: &str = "normalisation";
const CSPHASE: &str = "csphase";
const UNIT: &str = "unit";
const CENTRE: &str = "centre";
const SOURCE: &str = "source";
const SOURCE_HASH: &str = "source-hash";
const LMAX: &str = "lmax";
const TRUNCATED_FROM: &str = "truncated-from";

/// Writes a shape as coefficient text, 17 significant digits a number: [`parse`] brings back what the convention keeps (all bits at
/// m = 0 of Schmidt normalisation, 2 units in the last place elsewhere; unnormalised as far as f64 reaches).
///
/// # Errors
/// [`Error::Numeric`] when the degree is too high for unnormalised coefficients.
pub fn write(shape: &Shape, convention: Convention) -> Result<Vec<u8>> {
    let mut lines = header(shape, convention);
    for l in 0..=shape.coefficients.lmax() {
        for m in 0..=l {
            let (c, s) = convention.export(l, m, shape.coefficients.get(l, m))?;
            lines.push(format!("{l}, {m}, {}, {}\n", digits(c), digits(s)));
        }
    }
    Ok(lines.concat().into_bytes())
}

fn header(shape: &Shape, convention: Convention) -> Vec<String> {
    let DVec3 { x, y, z } = shape.centre;
    let mut lines = vec![format!("# {SOFTWARE} {TITLE}\n")];
    let mut line = |key: &str, value: &str| lines.push(format!("# {key}: {value}\n"));
    line(NORMALISATION, convention.normalisation.name());
    line(CSPHASE, &convention.phase.csphase().to_string());
    line(UNIT, "m");
    line(CENTRE, &format!("{x:?} {y:?} {z:?}"));
    if let Some(source) = &shape.source {
        line(SOURCE, &quoted(&source.name));
        line(SOURCE_HASH, &source.hash.to_string());
    }
    line(LMAX, &shape.coefficients.lmax().to_string());
    if let Some(degree) = shape.truncated_from {
        line(TRUNCATED_FROM, &degree.to_string());
    }
    lines
}

/// Writes 17 significant digits with a signed exponent of at least two digits, as C, Fortran and Python do.
fn digits(value: f64) -> String {
    let text = format!("{value:.16e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let (sign, exponent) = exponent.strip_prefix('-').map_or(('+', exponent), |e| ('-', e));
    format!("{mantissa}e{sign}{exponent:0>2}")
}

/// Quotes a text as a JSON string in pure ASCII: a name with a line break stays on its line, and pyshtools decodes by the system's
/// encoding, whichever that is.
fn quoted(text: &str) -> String {
    let escaped = |c: char| -> String {
        if c.is_ascii() {
            return c.to_string();
        }
        let units: Vec<String> =
            c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")).collect();
        units.concat()
    };
    serde_json::Value::from(text).to_string().chars().map(escaped).collect()
}

/// Reads coefficient text: ours, or a bare one of pyshtools in the given `convention`; `path` is for messages.
///
/// Rows run from degree 0 up, order 0 to l, none missing. Separators are commas or blanks. As in pyshtools, S may lack at m = 0, and
/// two more columns hold errors, which are not read. Memory is bound by the size of the text.
///
/// # Errors
/// [`Error::Input`] with line and remedy: not UTF-8, no convention or a contradictory one, a row that is missing, out of order,
/// duplicate, of a wrong number of columns, not finite, cut off, or beyond f64; a broken comment line of ours.
pub fn parse(path: &Path, bytes: &[u8], convention: Option<Convention>) -> Result<Shape> {
    let text = std::str::from_utf8(bytes).map_err(|e| {
        let line = bytes[..e.valid_up_to()].split(|b| *b == b'\n').count();
        InputError::new(path, "this is not UTF-8 text, so no coefficient text").at(line, None)
    })?;
    let notes = Notes::read(path, text)?;
    let convention = agreed(path, &notes, convention)?;
    if notes.ours && !text.ends_with('\n') {
        let last = text.lines().count();
        return Err(InputError::new(path, "the file is cut off within this line")
            .at(last, None)
            .into());
    }
    let coefficients = rows(path, text, convention)?;
    check_lmax(path, &notes, coefficients.lmax())?;
    Ok(Shape {
        coefficients,
        centre: notes.centre.unwrap_or(DVec3::ZERO),
        source: notes.name.zip(notes.hash).map(|(name, hash)| Source { name, hash }),
        truncated_from: notes.truncated_from,
    })
}

/// Chooses between the convention that the file states and the one that the caller gives.
fn agreed(path: &Path, notes: &Notes, given: Option<Convention>) -> Result<Convention> {
    let stated = notes
        .normalisation
        .zip(notes.phase)
        .map(|(normalisation, phase)| Convention { normalisation, phase });
    match (stated, given) {
        (Some(stated), Some(given)) if stated != given => Err(InputError::new(
            path,
            format!(
                "the file says {}, csphase {}; asked for was {}, csphase {}",
                stated.normalisation,
                stated.phase.csphase(),
                given.normalisation,
                given.phase.csphase()
            ),
        )
        .help("leave out `--normalisation` and `--csphase`")
        .into()),
        (Some(convention), _) | (None, Some(convention)) => Ok(convention),
        (None, None) => Err(InputError::new(path, "the file does not say how it is normalised")
            .help(
                "say it with `--normalisation 4pi|ortho|schmidt|unnorm` and `--csphase 1|-1` \
                 (pyshtools writes 4pi and 1 unless told otherwise)",
            )
            .into()),
    }
}

fn check_lmax(path: &Path, notes: &Notes, found: usize) -> Result<()> {
    match notes.lmax {
        Some(lmax) if lmax != found => Err(InputError::new(
            path,
            format!("the file announces degree {lmax} and ends with degree {found}"),
        )
        .help("part of it is lost: make it anew")
        .into()),
        _ => Ok(()),
    }
}

/// Holds what the comment lines say.
#[derive(Default)]
struct Notes {
    ours: bool,
    normalisation: Option<Normalisation>,
    phase: Option<CondonShortley>,
    centre: Option<DVec3>,
    name: Option<String>,
    hash: Option<SourceHash>,
    lmax: Option<usize>,
    truncated_from: Option<usize>,
}

impl Notes {
    fn read(path: &Path, text: &str) -> Result<Self> {
        let mut notes = Self::default();
        let mut lines = text.lines().zip(1..).take_while(|(line, _)| line.starts_with('#'));
        let Some((first, _)) = lines.next() else { return Ok(notes) };
        if !(first.starts_with("# harmolux ") && first.ends_with(TITLE)) {
            return Ok(notes);
        }
        notes.ours = true;
        for (line, number) in lines {
            if let Some((key, value)) = line[1..].split_once(':') {
                notes
                    .take(key.trim(), value.trim())
                    .map_err(|message| InputError::new(path, message).at(number, None))?;
            }
        }
        notes.check_complete(path)?;
        Ok(notes)
    }

    /// Takes one comment; keys of other versions are passed over.
    fn take(&mut self, key: &str, value: &str) -> Result<(), String> {
        let broken = |expected: &str| format!("`{value}` is no {key}: expected {expected}");
        match key {
            NORMALISATION => {
                self.normalisation = Some(value.parse().map_err(|e: Error| e.to_string())?);
            }
            CSPHASE => self.phase = Some(value.parse().map_err(|e: Error| e.to_string())?),
            UNIT if value != "m" => return Err(broken("m (scale the coefficients to metres)")),
            CENTRE => {
                self.centre = Some(point(value).ok_or_else(|| broken("three numbers, metres"))?);
            }
            SOURCE => {
                let name = serde_json::from_str(value).map_err(|_| broken("a name in quotes"))?;
                self.name = Some(name);
            }
            SOURCE_HASH => {
                let hash = SourceHash::parse(value);
                self.hash = Some(hash.ok_or_else(|| broken("fnv1a64: and 16 hexadecimal digits"))?);
            }
            LMAX => self.lmax = Some(value.parse().map_err(|_| broken("a degree"))?),
            TRUNCATED_FROM => {
                self.truncated_from = Some(value.parse().map_err(|_| broken("a degree"))?);
            }
            _ => {}
        }
        Ok(())
    }

    fn check_complete(&self, path: &Path) -> Result<()> {
        let missing = [
            (self.normalisation.is_none(), NORMALISATION, "4pi"),
            (self.phase.is_none(), CSPHASE, "1"),
            (self.centre.is_none(), CENTRE, "0 0 0"),
            (self.lmax.is_none(), LMAX, "32"),
        ];
        match missing.into_iter().find(|(missing, ..)| *missing) {
            Some((_, key, example)) => {
                Err(InputError::new(path, format!("the comments lack `{key}`"))
                    .at(1, None)
                    .help(format!(
                        "add a line as `# {key}: {example}`, or remove all comments and give \
                     `--normalisation 4pi|ortho|schmidt|unnorm` and `--csphase 1|-1`"
                    ))
                    .into())
            }
            None => Ok(()),
        }
    }
}

fn point(text: &str) -> Option<DVec3> {
    let numbers: Vec<f64> =
        text.split_whitespace().map(str::parse).collect::<Result<_, _>>().ok()?;
    let point = DVec3::from_array(numbers.try_into().ok()?);
    point.is_finite().then_some(point)
}

/// Reads all rows in the one order they may have.
fn rows(path: &Path, text: &str, convention: Convention) -> Result<Coefficients> {
    let (mut a, mut b) = (Vec::new(), Vec::new());
    let (mut l, mut m) = (0, 0);
    for (line, number) in text.lines().zip(1..) {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let (cosine, sine) = row(line, l, m)
            .and_then(|cs| convention.import(l, m, cs).map_err(|e| e.to_string()))
            .map_err(|message| InputError::new(path, message).at(number, None))?;
        a.push(cosine);
        b.push(sine);
        (l, m) = if m < l { (l, m + 1) } else { (l + 1, 0) };
    }
    if (l, m) == (0, 0) {
        return Err(InputError::new(path, "there are no coefficients here").into());
    }
    if m > 0 {
        let message =
            format!("the file ends before degree {l}, order {m}: a degree has all orders 0 to {l}");
        return Err(InputError::new(path, message)
            .at(text.lines().count(), None)
            .help(format!("remove the rows of degree {l}, or make the file anew"))
            .into());
    }
    Coefficients::from_parts(l - 1, a, b)
}

/// Reads one row, which must be that of degree `l`, order `m`.
fn row(line: &str, l: usize, m: usize) -> Result<(f64, f64), String> {
    let cells: Vec<&str> = line.split([',', ' ', '\t']).filter(|cell| !cell.is_empty()).collect();
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
    let (c, s) = (coefficient(c)?, coefficient(s)?);
    if m == 0 && s != 0.0 {
        return Err(format!("S of order 0 is {s:e}: it must be 0, since sin(0) is"));
    }
    Ok((c, s))
}

fn check_place(found: (usize, usize), expected: (usize, usize)) -> Result<(), String> {
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

fn number(text: &str, what: &str) -> Result<usize, String> {
    usize::from_str(text)
        .map_err(|_| format!("`{text}` is no {what}: expected a whole number from 0"))
}

fn coefficient(text: &str) -> Result<f64, String> {
    match f64::from_str(text) {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!("`{text}` is not a finite number")),
        Err(_) => Err(format!("`{text}` is not a number")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Made by pyshtools 4.14.1; tests/data/README.md says how.
    const PYSHTOOLS: &str = include_str!("../../../tests/data/pyshtools_degree6_4pi.sh");

    const PATH: &str = "shape.txt";

    fn read(text: &str, convention: Option<Convention>) -> Result<Shape> {
        parse(Path::new(PATH), text.as_bytes(), convention)
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
        assert!(
            message.contains("`--normalisation 4pi|ortho|schmidt|unnorm` and `--csphase 1|-1`")
        );
    }

    #[test]
    fn rows_are_written_to_the_byte_as_pyshtools_writes_them() {
        let shape = bare(PYSHTOOLS).expect("read");
        let schmidt = Convention { normalisation: Normalisation::Schmidt, ..Default::default() };
        let same_rows = |text: &str, reference: &str| {
            let rows = text.lines().filter(|line| !line.starts_with('#'));
            rows.eq(reference.lines())
        };
        // Zonal Schmidt rows pass unchanged, so their bytes must be those that pyshtools writes for the same numbers.
        let zonal = "0, 0, 8.9999999999999997e-02, 0.0000000000000000e+00\n";
        let ball = read(zonal, Some(schmidt)).expect("read");
        assert!(same_rows(&written(&ball, schmidt), zonal));
        // 4pi numbers may move by two units in the last of 17 digits; to 15 digits they are the same text.
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
        assert!(message.contains("leave out `--normalisation`"));
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
            ("1, 1, 1.0D-3, 0", "`1.0D-3` is not a number"),
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
        let error = parse(Path::new(PATH), b"0 0 1 0\n1 0 \xff\n", None);
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
    fn error_columns_are_passed_over() {
        let with_errors = bare("0 0 1 0 0.1 0\n1 0 2 0 0.1 0\n1 1 3 4 0.1 0.1\n").expect("read");
        assert_eq!(with_errors, bare("0 0 1\n1 0 2\n1 1 3 4\n").expect("read"));
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
        #![proptest_config(ProptestConfig::with_cases(64))]
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
                    // The factor is 1 or -1 only at m = 0 of schmidt and unnorm: there not a bit may move.
                    let exact = convention.factor(l, m).expect("in range").abs() == 1.0;
                    let allowed = if exact { 0 } else { 2 };
                    prop_assert!(units_apart(a, a2) <= allowed && units_apart(b, b2) <= allowed);
                }
            }
        }
    }
}
