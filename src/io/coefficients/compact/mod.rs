//! The compact form: a shape to a tolerance, in as few bytes as that takes.
//!
//! The coefficients of an orthonormal basis are rounded to multiples of one step, which the writer
//! chooses for the tolerance, and these whole numbers are entropy-coded under a model of the
//! spectrum. `docs/how/compact.md` has the mathematics and what it costs and buys.
//!
//! ```text
//! bytes  what
//! 4      48 58 43 ("HXC") and the version, 1
//! 1      flags: 1 = a source is named, 2 = the series was cut, 4 = the centre is not the origin
//! 1..    lmax
//! 1..    degree of the fit before the cut           (flag 2)
//! 24     centre x, y, z, metres, f64 little endian  (flag 4)
//! 8      fingerprint of the source, little endian   (flag 1)
//! 1..    length of the name of the source, and the name in UTF-8 (flag 1)
//! 2      the law of expected magnitudes (`compact/model.rs`):
//!        mirrors | tail << 3 | decay << 5, level
//! 2      the step: the upper 16 bits of an f32, little endian, metres
//! 1..    A_00 in steps, as 2q or, below 0, -2q - 1
//! ..     the other numbers (`compact/stream.rs`), and zeros up to one byte for 64 coefficients
//! 4      CRC-32 of all bytes before, little endian
//! ```
//!
//! "1.." is a number of 7 bits a byte, the last ones first, the highest bit set on all bytes but
//! the last.

mod model;
mod quantise;
mod stream;

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;

use self::model::{Law, Place};
use crate::error::InputError;
use crate::fit::{Shape, Source, SourceHash};
use crate::io::bytes::{Cursor, Number, field, push_number, unzigzag, zigzag};
use crate::sh::Coefficients;
use crate::{Error, Result};

/// Begins every file of this form.
pub const MAGIC: [u8; 3] = *b"HXC";

const VERSION: u8 = 1;
const HAS_SOURCE: u8 = 1;
const IS_CUT: u8 = 2;
const HAS_CENTRE: u8 = 4;

/// The bytes of the checksum.
const CHECK: usize = 4;

/// Each byte of a file vouches for this many coefficients at most, so that no file announces more
/// than memory holds.
const COEFFICIENTS_PER_BYTE: usize = 64;

/// Says how far the stored radius may be from the given one: the root of the mean square over the
/// sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tolerance {
    /// Metres. A fifth of the truncation error of a fit is `Metres(0.2 * fit.error.rms)`.
    Metres(f64),
    /// As a part of the mean radius.
    OfMeanRadius(f64),
}

impl Tolerance {
    fn metres(self, shape: &Shape) -> Result<f64> {
        let (given, metres) = match self {
            Self::Metres(x) => (x, x),
            Self::OfMeanRadius(x) => (x, x * shape.coefficients.mean().abs()),
        };
        if metres.is_finite() && metres > 0.0 {
            Ok(metres)
        } else if given.is_finite() && given > 0.0 {
            Err(Error::Parameter("the mean radius is 0: give the tolerance in metres".into()))
        } else {
            Err(Error::Parameter(format!("a tolerance of {given}: it must be a positive number")))
        }
    }
}

/// Holds a compact file and what was measured of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Compact {
    /// The file.
    pub bytes: Vec<u8>,
    /// The root of the mean square over the sphere of what [`parse`] gives less what was given,
    /// metres.
    pub rms: f64,
    /// The step between stored values of orthonormal coefficients of mean square 1, metres.
    pub step: f64,
    /// The bytes of the file before the coefficients past degree 0.
    pub header: usize,
}

impl Compact {
    /// Returns the bytes that hold the coefficients past degree 0.
    pub const fn body(&self) -> usize {
        self.bytes.len() - self.header - CHECK
    }
}

/// Writes a shape in as few bytes as the tolerance allows, and decodes them to measure the error.
///
/// The centre, and what is known of the source, are kept exactly; leave out [`Shape::source`] to
/// save its bytes.
///
/// ```
/// use std::path::Path;
/// use harmolux::fit::Shape;
/// use harmolux::io::coefficients::compact::{self, Tolerance};
/// use harmolux::sh::Coefficients;
///
/// let mut coefficients = Coefficients::zeros(2);
/// coefficients.set(0, 0, 0.1, 0.0);
/// coefficients.set(2, 1, 0.02, 0.03);
/// let file = compact::encode(&Shape::new(coefficients), Tolerance::OfMeanRadius(1e-3))?;
/// assert!(file.rms <= 1e-4 && file.bytes.len() <= 32);
/// let shape = compact::parse(Path::new("body.hxc"), &file.bytes)?;
/// assert!((shape.coefficients.get(2, 1).1 - 0.03).abs() <= 1e-3);
/// # Ok::<(), harmolux::Error>(())
/// ```
///
/// # Errors
/// [`Error::Parameter`] for a tolerance that is not positive, or finer than the form can hold
/// (2^-50 of the largest coefficient, or radii beyond f32); [`Error::Numeric`] should the decoded
/// shape miss the tolerance.
pub fn encode(shape: &Shape, tolerance: Tolerance) -> Result<Compact> {
    let metres = tolerance.metres(shape)?;
    let lmax = shape.coefficients.lmax();
    // The last digits of the tolerance are left to the rounding of sums.
    let choice = quantise::choose(&orthonormal(&shape.coefficients), lmax, metres * (1.0 - 1e-9))
        .ok_or_else(|| {
        Error::Parameter(format!(
            "a tolerance of {metres:e} m is beyond what the compact form holds: use the binary form"
        ))
    })?;
    let mut bytes = header(shape);
    bytes.extend(choice.law.to_bytes());
    bytes.extend(choice.step.to_le_bytes());
    push_number(&mut bytes, zigzag(choice.numbers[0]));
    let header = bytes.len();
    bytes.extend(stream::write(&choice.numbers, lmax, choice.law)?);
    let least = (lmax + 1).pow(2).div_ceil(COEFFICIENTS_PER_BYTE).saturating_sub(CHECK);
    bytes.resize(bytes.len().max(least), 0);
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    let decoded = parse(Path::new("what was just encoded"), &bytes)?;
    let rms = distance(&decoded.coefficients, &shape.coefficients)?;
    if rms <= metres {
        Ok(Compact { bytes, rms, step: quantise::step(choice.step), header })
    } else {
        Err(Error::Numeric(format!("the compact form misses {metres:e} m by {:e} m", rms - metres)))
    }
}

/// Writes what comes before the law.
fn header(shape: &Shape) -> Vec<u8> {
    let flag = |set: bool, bit: u8| if set { bit } else { 0 };
    let mut bytes = MAGIC.to_vec();
    bytes.push(VERSION);
    bytes.push(
        flag(shape.source.is_some(), HAS_SOURCE)
            | flag(shape.truncated_from.is_some(), IS_CUT)
            | flag(shape.centre != DVec3::ZERO, HAS_CENTRE),
    );
    push_number(&mut bytes, shape.coefficients.lmax() as u64);
    if let Some(degree) = shape.truncated_from {
        push_number(&mut bytes, degree as u64);
    }
    if shape.centre != DVec3::ZERO {
        bytes.extend(shape.centre.to_array().iter().flat_map(|x| x.to_le_bytes()));
    }
    if let Some(source) = &shape.source {
        bytes.extend(source.hash.0.to_le_bytes());
        push_number(&mut bytes, source.name.len() as u64);
        bytes.extend(source.name.as_bytes());
    }
    bytes
}

/// Returns what coefficients of mean square 1 are multiplied with to become A_lm and B_lm.
fn norm(place: Place) -> f64 {
    let doubled = if place.m == 0 { 1.0 } else { 2.0 };
    (doubled * (2 * place.l + 1) as f64).sqrt()
}

/// Lists the orthonormal coefficients in the order of [`Place::index`].
fn orthonormal(coefficients: &Coefficients) -> Vec<f64> {
    let value = |place: Place| {
        let (a, b) = coefficients.get(place.l, place.m);
        if place.sine { b } else { a }
    };
    let others = Place::all(coefficients.lmax()).map(|place| value(place) / norm(place));
    std::iter::once(coefficients.mean()).chain(others).collect()
}

/// Returns the root mean square over the sphere of the difference.
fn distance(a: &Coefficients, b: &Coefficients) -> Result<f64> {
    let minus = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
    let cosines = minus(a.cosines(), b.cosines());
    let difference = Coefficients::from_parts(a.lmax(), cosines, minus(a.sines(), b.sines()))?;
    Ok((difference.energy() / (4.0 * PI)).sqrt())
}

/// Reads a file of this form; `path` is for messages. The same bytes give the same bits on every
/// machine, and memory is bound by their number.
///
/// # Errors
/// [`Error::Input`] when the bytes do not begin as this form does, are of another version, cut off,
/// damaged, or announce more coefficients than they can hold.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Shape> {
    check_start(path, bytes)?;
    let broken = |message: &str| Error::from(remade(path, message));
    let start = MAGIC.len() + 1;
    let (content, check) =
        bytes[start..].split_last_chunk::<CHECK>().ok_or_else(|| broken("the file is cut off"))?;
    if crc32fast::hash(&bytes[..start + content.len()]) != field::<u32>(check, 0) {
        return Err(broken("the file is damaged or cut off: its checksum does not fit"));
    }
    read_content(content, bytes.len()).map_err(|message| broken(&message))
}

fn remade(path: &Path, message: &str) -> InputError {
    InputError::new(path, message).help("copy or make the file anew")
}

fn check_start(path: &Path, bytes: &[u8]) -> Result<()> {
    if !bytes.starts_with(&MAGIC) {
        return Err(InputError::new(path, "this is no compact coefficient file").into());
    }
    match bytes.get(MAGIC.len()) {
        Some(&VERSION) => Ok(()),
        Some(version) => Err(InputError::new(
            path,
            format!("version {version} of the compact form; known here is {VERSION}"),
        )
        .help("read it with a newer harmolux")
        .into()),
        None => Err(remade(path, "the file is cut off").into()),
    }
}

/// Reads what lies between the version and the checksum; `size` is that of the whole file.
fn read_content(content: &[u8], size: usize) -> Result<Shape, String> {
    let mut fields = Fields(Cursor(content));
    let flags: u8 = fields.take()?;
    if flags > HAS_SOURCE | IS_CUT | HAS_CENTRE {
        return Err(format!("the flags {flags:#x} are not known"));
    }
    let lmax = fields.degree()?;
    let plausible = lmax
        .checked_add(1)
        .and_then(|n| n.checked_mul(n))
        .is_some_and(|count| count.div_ceil(COEFFICIENTS_PER_BYTE) <= size);
    if !plausible {
        return Err(format!("{size} bytes cannot hold degree {lmax}"));
    }
    let truncated_from = if flags & IS_CUT == 0 { None } else { Some(fields.degree()?) };
    let centre = if flags & HAS_CENTRE == 0 { DVec3::ZERO } else { fields.centre()? };
    let source = if flags & HAS_SOURCE == 0 { None } else { Some(fields.source()?) };
    let coefficients = fields.coefficients(lmax)?;
    Ok(Shape { coefficients, centre, source, truncated_from })
}

/// Holds what is yet to be read.
struct Fields<'a>(Cursor<'a>);

impl Fields<'_> {
    fn take<T: Number>(&mut self) -> Result<T, String> {
        self.0.number().ok_or_else(|| "the header is cut off".to_owned())
    }

    fn number(&mut self) -> Result<u64, String> {
        let mut number = 0;
        for shift in (0..63).step_by(7) {
            let byte: u8 = self.take()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err("a number of the header does not end".into())
    }

    fn degree(&mut self) -> Result<usize, String> {
        let number = self.number()?;
        usize::try_from(number).map_err(|_| format!("degree {number} is beyond all memory"))
    }

    fn centre(&mut self) -> Result<DVec3, String> {
        let centre = [self.take()?, self.take()?, self.take()?];
        let centre = DVec3::from_array(centre);
        if centre.is_finite() { Ok(centre) } else { Err("the centre is not finite".into()) }
    }

    fn source(&mut self) -> Result<Source, String> {
        let hash = SourceHash(self.take()?);
        let length = self.degree()?;
        let name = self.0.take(length).ok_or("the name is cut off")?;
        let name = std::str::from_utf8(name).map_err(|_| "the name of the source is not UTF-8")?;
        Ok(Source { name: name.to_owned(), hash })
    }

    fn coefficients(&mut self, lmax: usize) -> Result<Coefficients, String> {
        let law = Law::from_bytes([self.take()?, self.take()?]);
        let number = self.take()?;
        if !quantise::is_step(number) {
            return Err("the step is not a positive number".into());
        }
        let step = quantise::step(number);
        let mean = unzigzag(self.number()?);
        let numbers = stream::read(self.0.0, lmax, law).ok_or("the coefficients make no sense")?;
        let mut pairs = Coefficients::zeros(lmax);
        pairs.set(0, 0, mean as f64 * step, 0.0);
        for (place, number) in Place::all(lmax).zip(numbers) {
            let value = number as f64 * step * norm(place);
            let (a, b) = pairs.get(place.l, place.m);
            let (a, b) = if place.sine { (a, value) } else { (value, b) };
            pairs.set(place.l, place.m, a, b);
        }
        Ok(pairs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATH: &str = "shape.hxc";

    /// A shape of falling spectrum with all orders, about a centre and of a known source.
    fn shape(lmax: usize) -> Shape {
        let mut coefficients = Coefficients::zeros(lmax);
        for place in Place::all(lmax).filter(|place| !place.sine) {
            let x = (7 * place.l + 3 * place.m + 1) as f64;
            let size = 0.02 / (place.l * place.l) as f64;
            coefficients.set(place.l, place.m, size * (x * x).sin(), size * (x * x).cos());
        }
        coefficients.set(0, 0, 0.1, 0.0);
        Shape {
            centre: DVec3::new(0.1, -1e-300, 1.0 / 3.0),
            source: Some(Source::new(Path::new("tête.obj"), b"v 0 0 0")),
            truncated_from: Some(300),
            ..Shape::new(coefficients)
        }
    }

    fn read(bytes: &[u8]) -> Result<Shape> {
        parse(Path::new(PATH), bytes)
    }

    fn refusal(result: Result<Shape>) -> String {
        match result {
            Err(Error::Input(error)) => error.to_string(),
            other => panic!("not an input error: {other:?}"),
        }
    }

    /// Puts a right checksum behind bytes.
    fn sealed(content: &[u8]) -> Vec<u8> {
        [content, &crc32fast::hash(content).to_le_bytes()].concat()
    }

    #[test]
    fn tolerance_is_met_at_every_degree() {
        for lmax in (0..=8).chain([13, 33]) {
            let shape = shape(lmax);
            for tolerance in [1e-2, 1e-6, 1e-13] {
                let file = encode(&shape, Tolerance::OfMeanRadius(tolerance)).expect("encoded");
                assert!(file.rms <= tolerance * 0.1, "{lmax} {tolerance}");
                let back = read(&file.bytes).expect("read");
                let rms = distance(&back.coefficients, &shape.coefficients).expect("finite");
                assert_eq!((rms, back.coefficients.lmax()), (file.rms, lmax));
                let same = Shape { coefficients: shape.coefficients.clone(), ..back };
                assert_eq!(same, shape);
            }
        }
    }

    #[test]
    fn shapes_of_any_size_and_sign_are_kept() {
        for scale in [1e-30, -1e-3, 1e6, 1e30] {
            let shape = Shape::new(shape(8).coefficients.scaled(scale));
            let file = encode(&shape, Tolerance::OfMeanRadius(1e-3)).expect("encoded");
            let back = read(&file.bytes).expect("read").coefficients;
            let rms = distance(&back, &shape.coefficients).expect("finite");
            assert!(rms <= 1e-4 * scale.abs(), "{scale}");
        }
        for scale in [1e-300, 1e300] {
            let shape = Shape::new(shape(2).coefficients.scaled(scale));
            let error = encode(&shape, Tolerance::OfMeanRadius(1e-3)).expect_err("beyond f32");
            assert!(error.to_string().contains("use the binary form"), "{error}");
        }
    }

    #[test]
    fn ball_takes_its_header() {
        let mut ball = Shape::new(Coefficients::zeros(8));
        ball.coefficients.set(0, 0, 2.0, 0.0);
        let file = encode(&ball, Tolerance::Metres(1e-6)).expect("encoded");
        assert!(file.bytes.len() <= 20 && file.body() <= 2, "{}", file.bytes.len());
        // Each byte vouches for 64 coefficients: 129^2 of them take 261 bytes even when they are
        // nothing.
        let padded = Shape::new(ball.coefficients.truncated(128));
        let file = encode(&padded, Tolerance::Metres(1e-6)).expect("encoded");
        assert_eq!(file.bytes.len(), 261);
        assert!(read(&file.bytes).is_ok());
        let nothing = Shape::new(Coefficients::zeros(3));
        let file = encode(&nothing, Tolerance::Metres(1e-6)).expect("encoded");
        assert_eq!(read(&file.bytes).expect("read"), nothing);
    }

    #[test]
    fn mirror_symmetry_halves_the_file() {
        let whole = shape(24);
        let mut half = whole.clone();
        for place in Place::all(24).filter(|place| !place.sine) {
            let (a, b) = whole.coefficients.get(place.l, place.m);
            let (a, b) = if place.m % 2 == 0 { (a, 0.0) } else { (0.0, b) };
            half.coefficients.set(place.l, place.m, a, b);
        }
        let body =
            |shape: &Shape| encode(shape, Tolerance::OfMeanRadius(1e-5)).expect("encoded").body();
        let (whole, half) = (body(&whole), body(&half));
        assert!(100 * half <= 55 * whole, "{half} of {whole}");
    }

    #[test]
    fn every_cut_and_every_flipped_bit_is_refused() {
        let bytes = encode(&shape(5), Tolerance::OfMeanRadius(1e-3)).expect("encoded").bytes;
        for end in 0..bytes.len() {
            assert!(matches!(read(&bytes[..end]), Err(Error::Input(_))), "cut at {end}");
            for bit in 0..8 {
                let mut non_finite = bytes.clone();
                non_finite[end] ^= 1 << bit;
                assert!(matches!(read(&non_finite), Err(Error::Input(_))), "byte {end}, bit {bit}");
            }
        }
        assert!(
            refusal(read(&[bytes.as_slice(), &[0]].concat())).contains("its checksum does not fit")
        );
    }

    #[test]
    fn files_with_right_checksum_and_wrong_content_are_refused() {
        let (ball, law) = ([b'H', b'X', b'C', 1], [0, 0, 0x80, 0x3f]);
        let file = |header: &[u8], rest: &[u8]| sealed(&[&ball, header, rest].concat());
        assert_eq!(
            read(&file(&[0, 0], &[&law[..], &[2]].concat())).expect("a ball").coefficients.mean(),
            1.0
        );
        for (header, rest, expected) in [
            (&[8, 0][..], &law[..], "the flags 0x8 are not known"),
            (&[0, 0xc0, 0x84, 0x3d], &law, "bytes cannot hold degree 1000000"),
            (
                &[0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f],
                &law,
                "cannot hold degree 92233",
            ),
            (&[0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1], &law, "does not end"),
            (&[0, 0], &[0, 0, 0, 0, 2], "the step is not a positive number"),
            (&[0, 0], &[0, 0, 0x80, 0x7f, 2], "the step is not a positive number"),
            (&[0, 0], &[0, 0, 0x80, 0xbf, 2], "the step is not a positive number"),
            (&[0, 0], &law, "the header is cut off"),
            (&[1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 200], &law, "the name is cut off"),
            (&[1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 1, 0xff], &law, "not UTF-8"),
        ] {
            let message = refusal(read(&file(header, rest)));
            assert!(message.contains(expected), "{message}");
        }
        let infinite = [&[4, 0][..], &f64::INFINITY.to_le_bytes(), &[0; 16]].concat();
        assert!(refusal(read(&file(&infinite, &law))).contains("the centre is not finite"));
    }

    #[test]
    fn other_files_and_versions_are_named() {
        assert!(refusal(read(b"# harmolux")).contains("this is no compact coefficient file"));
        assert!(
            refusal(read(b"HXC\x02...."))
                .contains("version 2 of the compact form; known here is 1")
        );
        assert!(refusal(read(b"HXC")).contains("the file is cut off"));
        assert!(refusal(read(b"HXC\x01")).contains("the file is cut off"));
    }

    #[test]
    fn tolerances_without_sense_are_refused() {
        let shape = shape(2);
        for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            for tolerance in [Tolerance::Metres(tolerance), Tolerance::OfMeanRadius(tolerance)] {
                assert!(matches!(encode(&shape, tolerance), Err(Error::Parameter(_))));
            }
        }
        let error = encode(&shape, Tolerance::OfMeanRadius(1e-17)).expect_err("too fine");
        assert!(error.to_string().contains("use the binary form"), "{error}");
        let nothing = Shape::new(Coefficients::zeros(0));
        let error = encode(&nothing, Tolerance::OfMeanRadius(0.1)).expect_err("no mean");
        assert!(error.to_string().contains("give the tolerance in metres"), "{error}");
    }

    #[test]
    fn bytes_are_the_same_for_ever() {
        // A changed model could not read the files that there are: it must become version 2.
        let bytes = encode(&Shape::new(shape(6).coefficients), Tolerance::OfMeanRadius(1e-3))
            .expect("encoded")
            .bytes;
        let hex = bytes.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().concat();
        let expected = "485843010006ff265338881fd0b4f4eff9756b9bb37c27b0\
                        a742cf6f87868612e69d2249f8580c977e4681a36f";
        assert_eq!(hex, expected);
    }
}
