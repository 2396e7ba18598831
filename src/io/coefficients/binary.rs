//! The exact form: every bit of a shape, degree by degree, so that a truncation is a shorter read
//! that is still checked.
//!
//! Little endian; n is the length of the name of the source in bytes, 0 without one.
//!
//! ```text
//! offset   bytes  what
//! 0            8  89 48 58 42 0d 0a 1a 0a: damaged by every transfer that takes the file for text
//! 8            2  version, 1
//! 10           2  flags: 1 = a source is named, 2 = the series was cut
//! 12           4  lmax
//! 16           4  degree of the fit before the cut, else 0
//! 20          24  centre x, y, z, metres
//! 44           8  fingerprint of the source, else 0
//! 52           2  n
//! 54           n  name of the source, UTF-8
//! 54+n         4  CRC-32 of all bytes before
//! ```
//!
//! Then degree l = 0 to lmax, its block at offset 58 + n + 8 l^2 + 4 l: A_l0, A_l1, B_l1, ...,
//! A_ll, B_ll in the basis of docs/how/conventions.md, 8 bytes each, and the CRC-32 of the header's
//! CRC, l (4 bytes) and these numbers. Nothing follows.

use std::io::{ErrorKind, Read};
use std::path::Path;

use glam::DVec3;

use crate::error::InputError;
use crate::fit::{Shape, Source, SourceHash};
use crate::io::bytes::field;
use crate::sh::Coefficients;
use crate::{Error, Result};

/// Begins every file of this form.
pub const MAGIC: [u8; 8] = *b"\x89HXB\r\n\x1a\n";

const VERSION: u16 = 1;
const HAS_SOURCE: u16 = 1;
const IS_CUT: u16 = 2;

/// The bytes of the header before the name.
const FIXED: usize = 54;

/// Writes a shape with all bits of its numbers; [`parse`] brings the same shape back.
///
/// # Errors
/// [`Error::Parameter`] when a degree or the name of the source is longer than its field (2^32 - 1,
/// 65 535 bytes).
pub fn encode(shape: &Shape) -> Result<Vec<u8>> {
    let mut bytes = header(shape)?;
    let seal = crc32fast::hash(&bytes);
    bytes.extend(seal.to_le_bytes());
    for l in 0..=shape.coefficients.lmax() {
        let start = bytes.len();
        for m in 0..=l {
            let (a, b) = shape.coefficients.get(l, m);
            bytes.extend(a.to_le_bytes());
            if m > 0 {
                bytes.extend(b.to_le_bytes());
            }
        }
        let check = block_check(seal, l, &bytes[start..]);
        bytes.extend(check.to_le_bytes());
    }
    Ok(bytes)
}

fn header(shape: &Shape) -> Result<Vec<u8>> {
    let name = shape.source.as_ref().map_or("", |source| source.name.as_str());
    let length = u16::try_from(name.len()).map_err(|_| {
        Error::Parameter(format!("the source's name has {} bytes, more than 65535", name.len()))
    })?;
    let flags = if shape.source.is_some() { HAS_SOURCE } else { 0 }
        | if shape.truncated_from.is_some() { IS_CUT } else { 0 };
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(flags.to_le_bytes());
    bytes.extend(degree_field(shape.coefficients.lmax())?);
    bytes.extend(degree_field(shape.truncated_from.unwrap_or(0))?);
    bytes.extend(shape.centre.to_array().iter().flat_map(|x| x.to_le_bytes()));
    bytes.extend(shape.source.as_ref().map_or(0, |source| source.hash.0).to_le_bytes());
    bytes.extend(length.to_le_bytes());
    bytes.extend(name.as_bytes());
    Ok(bytes)
}

fn degree_field(degree: usize) -> Result<[u8; 4]> {
    u32::try_from(degree)
        .map(u32::to_le_bytes)
        .map_err(|_| Error::Parameter(format!("degree {degree} is more than the form can hold")))
}

/// Chains a block to its header and its degree, so that blocks of other files and other places do
/// not pass.
fn block_check(seal: u32, l: usize, block: &[u8]) -> u32 {
    let mut check = crc32fast::Hasher::new();
    check.update(&seal.to_le_bytes());
    check.update(&(l as u32).to_le_bytes());
    check.update(block);
    check.finalize()
}

/// Reads a whole file of this form; `path` is for messages. Memory is bound by the number of bytes.
///
/// # Errors
/// [`Error::Input`] when the bytes do not begin as this form does, are of another version, cut off,
/// damaged, followed by others, or hold numbers that are not finite.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Shape> {
    let mut rest = bytes;
    let shape = parse_truncated(path, &mut rest, usize::MAX)?;
    if rest.is_empty() {
        return Ok(shape);
    }
    let end = bytes.len() - rest.len();
    Err(InputError::new(path, format!("{} bytes follow the coefficients", rest.len()))
        .help(format!("the file ends after {end} bytes: cut it there, or make it anew"))
        .into())
}

/// Reads degrees 0 to `lmax` (all, when the file has fewer) and nothing beyond them; what was left
/// out is kept in [`Shape::truncated_from`]. Each degree is checked by itself; memory is bound by
/// what has been read.
///
/// # Errors
/// As [`parse`], as far as the file is read; [`Error::Io`] when the reader fails.
pub fn parse_truncated(path: &Path, mut reader: impl Read, lmax: usize) -> Result<Shape> {
    let mut source = Bytes { path, reader: &mut reader };
    let header = Header::read(&mut source)?;
    let last = header.lmax.min(lmax);
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for l in 0..=last {
        let block = source.block(&header, l)?;
        // A_l0 stands alone, pairs of A and B follow.
        let (zonal, pairs) = block.split_at(1);
        a.extend(zonal);
        b.push(0.0);
        for pair in pairs.chunks_exact(2) {
            a.push(pair[0]);
            b.push(pair[1]);
        }
    }
    Ok(Shape {
        coefficients: Coefficients::from_parts(last, a, b)?,
        centre: header.centre,
        source: header.source,
        truncated_from: header.fitted.or((last < header.lmax).then_some(header.lmax)),
    })
}

struct Header {
    lmax: usize,
    fitted: Option<usize>,
    centre: DVec3,
    source: Option<Source>,
    seal: u32,
}

impl Header {
    fn read<R: Read>(bytes: &mut Bytes<R>) -> Result<Self> {
        let mut all = bytes.take(FIXED, "its header")?;
        check_start(bytes.path, &all)?;
        let length = usize::from(field::<u16>(&all, 52));
        all.extend(bytes.take(length + 4, "its header")?);
        let (content, check) = all.split_at(FIXED + length);
        let seal = field::<u32>(check, 0);
        if crc32fast::hash(content) != seal {
            return Err(bytes.broken("the header is damaged"));
        }
        let name = std::str::from_utf8(&content[FIXED..])
            .map_err(|_| bytes.broken("the name of the source is not UTF-8"))?;
        let flags = field::<u16>(content, 10);
        let centre = DVec3::from_array([20, 28, 36].map(|at| field::<f64>(content, at)));
        if !centre.is_finite() {
            return Err(bytes.broken("the centre is not finite"));
        }
        let hash = SourceHash(field::<u64>(content, 44));
        let degree = |at| field::<u32>(content, at) as usize;
        Ok(Self {
            lmax: degree(12),
            fitted: (flags & IS_CUT != 0).then(|| degree(16)),
            centre,
            source: (flags & HAS_SOURCE != 0).then(|| Source { name: name.to_owned(), hash }),
            seal,
        })
    }
}

fn check_start(path: &Path, bytes: &[u8]) -> Result<()> {
    if !bytes.starts_with(&MAGIC) {
        return Err(InputError::new(path, "this is no binary coefficient file").into());
    }
    match field::<u16>(bytes, 8) {
        VERSION => Ok(()),
        version => Err(InputError::new(
            path,
            format!("version {version} of the binary form; known here is {VERSION}"),
        )
        .help("read it with a newer harmolux")
        .into()),
    }
}

/// Takes bytes from a reader, and says what is wrong in terms of the file.
struct Bytes<'a, R> {
    path: &'a Path,
    reader: &'a mut R,
}

impl<R: Read> Bytes<'_, R> {
    /// Takes `count` bytes; an announced count takes memory only as the bytes come.
    fn take(&mut self, count: usize, what: &str) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let read = self.reader.by_ref().take(count as u64).read_to_end(&mut bytes);
        match read {
            Ok(found) if found == count => Ok(bytes),
            Err(e) if e.kind() != ErrorKind::UnexpectedEof => Err(Error::io(self.path, "read", e)),
            _ => Err(self.broken(&format!("the file is cut off within {what}"))),
        }
    }

    /// Takes the numbers of degree l.
    fn block(&mut self, header: &Header, l: usize) -> Result<Vec<f64>> {
        let what = format!("degree {l} of {}", header.lmax);
        let bytes = self.take(8 * (2 * l + 1) + 4, &what)?;
        let (numbers, check) = bytes.split_at(bytes.len() - 4);
        if block_check(header.seal, l, numbers) != field::<u32>(check, 0) {
            return Err(self.broken(&format!("{what} is damaged")));
        }
        let values: Vec<f64> =
            numbers.chunks_exact(8).map(|bytes| field::<f64>(bytes, 0)).collect();
        if values.iter().all(|value| value.is_finite()) {
            Ok(values)
        } else {
            Err(self.broken(&format!("{what} holds a number that is not finite")))
        }
    }

    fn broken(&self, message: &str) -> Error {
        InputError::new(self.path, message).help("copy or make the file anew").into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATH: &str = "shape.hxb";

    fn shape(lmax: usize) -> Shape {
        let mut coefficients = Coefficients::zeros(lmax);
        for (l, m) in (0..=lmax).flat_map(|l| (0..=l).map(move |m| (l, m))) {
            let x = (7 * l + 3 * m + 1) as f64;
            coefficients.set(l, m, x.sin() / x, x.cos() / x);
        }
        Shape {
            centre: DVec3::new(0.1, -1e-300, 1.0 / 3.0),
            source: Some(Source::new(Path::new("tête.obj"), b"v 0 0 0")),
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

    /// Puts right the checks of a file after `change` to its header.
    fn resealed(shape: &Shape, change: impl Fn(&mut Vec<u8>)) -> Vec<u8> {
        let mut bytes = header(shape).expect("short name");
        change(&mut bytes);
        let seal = crc32fast::hash(&bytes);
        bytes.extend(seal.to_le_bytes());
        bytes
    }

    #[test]
    fn every_bit_comes_back() {
        for lmax in 0..=64 {
            let mut shape = shape(lmax);
            shape.truncated_from = (lmax % 3 == 0).then_some(lmax + 7);
            if lmax % 2 == 0 {
                shape.source = None;
            }
            let bytes = encode(&shape).expect("encoded");
            assert_eq!(read(&bytes).expect("read"), shape);
            let name = shape.source.as_ref().map_or(0, |s| s.name.len());
            assert_eq!(bytes.len(), 58 + name + 8 * (lmax + 1).pow(2) + 4 * (lmax + 1));
        }
    }

    #[test]
    fn truncation_is_a_shorter_read() {
        let (shape, path) = (shape(16), Path::new(PATH));
        let bytes = encode(&shape).expect("encoded");
        let start = 58 + "tête.obj".len();
        for l in 0..=16 {
            let mut rest = bytes.as_slice();
            let cut = parse_truncated(path, &mut rest, l).expect("read");
            assert_eq!(cut, shape.truncated(l));
            assert_eq!(bytes.len() - rest.len(), start + 8 * (l + 1).pow(2) + 4 * (l + 1));
        }
        // Damage beyond is not seen, damage within is.
        let mut non_finite = bytes;
        let last = non_finite.len() - 9;
        non_finite[last] ^= 1;
        assert!(parse_truncated(path, non_finite.as_slice(), 15).is_ok());
        let message = refusal(parse_truncated(path, non_finite.as_slice(), 99));
        assert!(
            message.starts_with("shape.hxb: degree 16 of 16 is damaged\n  help: "),
            "{message}"
        );
    }

    #[test]
    fn every_cut_and_every_flipped_bit_is_refused() {
        let bytes = encode(&shape(3)).expect("encoded");
        for end in 0..bytes.len() {
            let message = refusal(read(&bytes[..end]));
            assert!(message.contains("cut off within"), "{message}");
            for bit in 0..8 {
                let mut non_finite = bytes.clone();
                non_finite[end] ^= 1 << bit;
                assert!(matches!(read(&non_finite), Err(Error::Input(_))), "byte {end}, bit {bit}");
            }
        }
        let longer = [bytes.as_slice(), &[0]].concat();
        assert!(refusal(read(&longer)).contains("1 bytes follow the coefficients"));
    }

    #[test]
    fn blocks_of_other_places_and_files_do_not_pass() {
        let mut other = shape(2);
        let bytes = encode(&other).expect("encoded");
        other.centre.x += 1.0;
        let moved = encode(&other).expect("encoded");
        let start = bytes.len() - 40 - 4;
        let mixed = [&bytes[..start], &moved[start..]].concat();
        assert!(refusal(read(&mixed)).contains("degree 2 of 2 is damaged"));
    }

    #[test]
    fn other_files_and_versions_are_named() {
        assert!(refusal(read(&[b'#'; 100])).contains("this is no binary coefficient file"));
        let newer = resealed(&shape(0), |bytes| bytes[8] = 2);
        assert!(refusal(read(&newer)).contains("version 2 of the binary form; known here is 1"));
        let infinite =
            resealed(&shape(0), |b| b[20..28].copy_from_slice(&f64::INFINITY.to_le_bytes()));
        assert!(refusal(read(&infinite)).contains("the centre is not finite"));
        let name = resealed(&shape(0), |bytes| bytes[54] = 0xff);
        assert!(refusal(read(&name)).contains("not UTF-8"));
        let mut nan = Shape::new(Coefficients::zeros(0));
        nan.coefficients.set(0, 0, f64::NAN, 0.0);
        let bytes = encode(&nan).expect("encoded");
        assert!(refusal(read(&bytes)).contains("degree 0 of 0 holds a number that is not finite"));
    }

    #[test]
    fn announced_degree_takes_no_memory() {
        let vast = resealed(&shape(0), |b| b[12..16].copy_from_slice(&u32::MAX.to_le_bytes()));
        assert!(refusal(read(&vast)).contains("cut off within degree 0 of 4294967295"));
    }

    #[test]
    fn names_longer_than_their_field_are_refused() {
        let mut shape = shape(0);
        shape.source = Some(Source::new(Path::new(&"n".repeat(65_536)), b""));
        assert!(matches!(encode(&shape), Err(Error::Parameter(_))));
    }
}
