//! NumPy's file of one array (`.npy`, versions 1 to 3): its header, and its numbers as f64.
//!
//! The reader is our own: the header is a literal of Python, which the crates at hand parse by
//! recursion, so that a hostile one can end the process; here it is the one dictionary that NumPy
//! writes, and memory is bound by the size of the file.

use std::path::Path;

use crate::Result;
use crate::error::InputError;
use crate::io::bytes::Cursor;

/// How such a file begins.
pub(in crate::io) const MAGIC: &[u8] = b"\x93NUMPY";

/// The header and its padding end at a multiple of this many bytes.
const ALIGNMENT: usize = 64;

/// An array of numbers.
#[derive(Debug, PartialEq)]
pub(in crate::io) struct Array<'a> {
    pub(in crate::io) shape: Vec<usize>,
    pub(in crate::io) complex: bool,
    fortran: bool,
    /// Bytes of one real number, 4 or 8.
    width: usize,
    little: bool,
    /// The type of its numbers, as the header has it.
    descr: &'a str,
    data: &'a [u8],
}

impl<'a> Array<'a> {
    /// Reads a file.
    pub(in crate::io) fn parse(path: &Path, bytes: &'a [u8]) -> Result<Self> {
        Self::read(bytes).map_err(|message| {
            let help = "write it with `numpy.save`, as float64 or complex128";
            InputError::new(path, message).help(help).into()
        })
    }

    fn read(bytes: &'a [u8]) -> Result<Self, String> {
        let array = Self::announced(bytes)?;
        let parts = if array.complex { 2 } else { 1 };
        let mut axes = array.shape.iter();
        let size = axes.try_fold(array.width * parts, |size, n| size.checked_mul(*n));
        if size != Some(array.data.len()) {
            return Err(format!(
                "an array {:?} of `{}` does not fit the {} bytes that follow its header",
                array.shape,
                array.descr,
                array.data.len()
            ));
        }
        Ok(array)
    }

    /// Reads the header, whatever follows it.
    fn announced(bytes: &'a [u8]) -> Result<Self, String> {
        let (header, data) = split(bytes)?;
        let descr = quoted(field(header, "descr")?)?;
        let (little, complex, width) = element(descr)?;
        let fortran = match field(header, "fortran_order")? {
            f if f.starts_with("False") => false,
            f if f.starts_with("True") => true,
            _ => return Err("the header does not say the order of the axes".to_owned()),
        };
        let shape = shape(field(header, "shape")?)?;
        Ok(Self { shape, complex, fortran, width, little, descr, data })
    }

    /// Returns the element at a place: its real and its imaginary part (0 for real arrays).
    pub(in crate::io) fn at(&self, index: &[usize]) -> (f64, f64) {
        let fold = |place: usize, (i, n): (&usize, &usize)| place * n + i;
        let pairs = index.iter().zip(&self.shape);
        let place = if self.fortran { pairs.rev().fold(0, fold) } else { pairs.fold(0, fold) };
        if self.complex {
            (self.number(2 * place), self.number(2 * place + 1))
        } else {
            (self.number(place), 0.0)
        }
    }

    fn number(&self, at: usize) -> f64 {
        let bytes = self.data.get(at * self.width..(at + 1) * self.width).unwrap_or_default();
        match (<[u8; 8]>::try_from(bytes), <[u8; 4]>::try_from(bytes), self.little) {
            (Ok(b), _, true) => f64::from_le_bytes(b),
            (Ok(b), _, false) => f64::from_be_bytes(b),
            (_, Ok(b), true) => f64::from(f32::from_le_bytes(b)),
            (_, Ok(b), false) => f64::from(f32::from_be_bytes(b)),
            _ => f64::NAN,
        }
    }
}

/// Whether a file that begins so holds complex numbers along one axis, or along one of two.
pub(in crate::io) fn is_complex_list(head: &[u8]) -> bool {
    Array::announced(head).is_ok_and(|array| array.complex && array.shape.len() < 3)
}

/// Whether a file that begins so holds real numbers along two axes.
pub(in crate::io) fn is_table(head: &[u8]) -> bool {
    Array::announced(head).is_ok_and(|array| !array.complex && array.shape.len() == 2)
}

/// Writes rows of `width` numbers each, at least 1, as a two-dimensional array of float64, which
/// `numpy.load` reads.
///
/// ```
/// let bytes = harmolux::io::npy::rows(3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
/// assert!(bytes.starts_with(b"\x93NUMPY"));
/// assert_eq!(bytes.len(), 128 + 6 * 8);
/// ```
pub fn rows(width: usize, numbers: &[f64]) -> Vec<u8> {
    write(&[numbers.len() / width.max(1), width], 1, numbers)
}

/// Writes an array of f64 (`parts` 1) or of complex numbers (`parts` 2, real and imaginary part in
/// turn), the last axis fastest.
pub(in crate::io) fn write(shape: &[usize], parts: usize, numbers: &[f64]) -> Vec<u8> {
    let descr = if parts == 2 { "<c16" } else { "<f8" };
    let axes: Vec<String> = shape.iter().map(ToString::to_string).collect();
    // A tuple of one has its comma.
    let comma = if shape.len() == 1 { "," } else { "" };
    let mut header = format!(
        "{{'descr': '{descr}', 'fortran_order': False, 'shape': ({}{comma}), }}",
        axes.join(", ")
    );
    let start = MAGIC.len() + 4;
    let padded = (start + header.len() + 1).next_multiple_of(ALIGNMENT) - start;
    header.push_str(&" ".repeat(padded - 1 - header.len()));
    header.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    bytes.extend((padded as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(numbers.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// Splits a file into the text of its header and its data.
fn split(bytes: &[u8]) -> Result<(&str, &[u8]), String> {
    let cut = || "the file is cut off within its header".to_owned();
    let rest = bytes.strip_prefix(MAGIC).ok_or("this is no .npy file")?;
    let mut rest = Cursor(rest);
    let version = rest.take(2).ok_or_else(cut)?;
    let length = match version[0] {
        1 => rest.number::<u16>().map(usize::from),
        2 | 3 => rest.number::<u32>().map(|n| n as usize),
        other => return Err(format!("version {other} of the .npy format is not known here")),
    };
    let header = length.and_then(|n| rest.take(n)).ok_or_else(cut)?;
    let header = std::str::from_utf8(header).map_err(|_| "the header is no text".to_owned())?;
    Ok((header, rest.0))
}

/// Returns what follows a key of the header.
fn field<'a>(header: &'a str, key: &str) -> Result<&'a str, String> {
    let missing = || format!("the header lacks `{key}`");
    ['\'', '"']
        .into_iter()
        .find_map(|quote| header.split_once(&format!("{quote}{key}{quote}")))
        .and_then(|(_, rest)| rest.trim_start().strip_prefix(':'))
        .map(str::trim_start)
        .ok_or_else(missing)
}

fn quoted(text: &str) -> Result<&str, String> {
    let unquoted = text.strip_prefix(['\'', '"']).and_then(|rest| rest.split(['\'', '"']).next());
    unquoted.ok_or_else(|| "the array is a record, not numbers".to_owned())
}

/// Reads a type of numbers: whether little-endian, whether complex, bytes of a real number.
fn element(descr: &str) -> Result<(bool, bool, usize), String> {
    let (order, kind) = descr.split_at_checked(1).unwrap_or_default();
    let (complex, width) = match kind {
        "f4" => (false, 4),
        "f8" => (false, 8),
        "c8" => (true, 4),
        "c16" => (true, 8),
        _ => return Err(format!("numbers of type `{descr}` are not read here")),
    };
    match order {
        "<" => Ok((true, complex, width)),
        ">" => Ok((false, complex, width)),
        _ => Err(format!("numbers of type `{descr}` do not say their byte order")),
    }
}

fn shape(text: &str) -> Result<Vec<usize>, String> {
    let inner = text.strip_prefix('(').and_then(|rest| rest.split_once(')')).map(|(t, _)| t);
    let axes = inner.unwrap_or("?").split(',').map(str::trim).filter(|axis| !axis.is_empty());
    let axes: Result<Vec<usize>, _> = axes.map(str::parse).collect();
    axes.map_err(|_| "the header does not say the shape of the array".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(bytes: &[u8]) -> String {
        Array::read(bytes).expect_err("refused")
    }

    fn with_header(header: &str, data: &[u8]) -> Vec<u8> {
        let length = (header.len() as u16).to_le_bytes();
        [MAGIC, &[1, 0], &length, header.as_bytes(), data].concat()
    }

    #[test]
    fn what_is_written_is_read() {
        let bytes = write(&[2, 3], 1, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(bytes.len() % ALIGNMENT, 48);
        let array = Array::read(&bytes).expect("read");
        assert_eq!((array.at(&[1, 0]), array.at(&[0, 2])), ((3.0, 0.0), (2.0, 0.0)));
        let bytes = write(&[2], 2, &[0.0, 1.0, 2.0, 3.0]);
        let array = Array::read(&bytes).expect("read");
        assert_eq!(
            (array.complex, array.shape.as_slice(), array.at(&[1])),
            (true, &[2][..], (2.0, 3.0))
        );
        assert!((0..bytes.len()).all(|end| Array::read(&bytes[..end]).is_err()));
    }

    #[test]
    fn other_orders_of_axes_and_bytes_are_read() {
        let data: Vec<u8> = [0.0_f32, 3.0, 1.0, 4.0, 2.0, 5.0].map(f32::to_be_bytes).concat();
        let header = "{\"shape\": (2,3), \"fortran_order\":True, \"descr\": \">f4\"}";
        let bytes = with_header(header, &data);
        let array = Array::read(&bytes).expect("read");
        assert_eq!(
            (array.at(&[1, 0]).0, array.at(&[0, 2]).0, array.at(&[1, 2]).0),
            (3.0, 2.0, 5.0)
        );
    }

    #[test]
    fn hostile_headers_are_refused() {
        let header = |descr: &str, shape: &str| {
            format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}")
        };
        for (header, expected) in [
            (header("<f8", "(2, 99999999999, 99999999999)"), "does not fit the 8 bytes"),
            (header("<f8", "(1000000000,)"), "does not fit the 8 bytes"),
            (header("<f8", &"(".repeat(50_000)), "does not say the shape"),
            (header("<f8", "(-1,)"), "does not say the shape"),
            (header("|O", "(1,)"), "numbers of type `|O` are not read here"),
            (header("<i8", "(1,)"), "`<i8` are not read here"),
            (header("=f8", "(1,)"), "do not say their byte order"),
            (header("é", "(1,)"), "are not read here"),
            (header("", "(1,)"), "are not read here"),
            ("{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (1,)}".into(), "a record"),
            ("{'descr': '<f8', 'shape': (1,)}".into(), "lacks `fortran_order`"),
            ("{}".into(), "lacks `descr`"),
        ] {
            let message = refusal(&with_header(&header, &[0; 8]));
            assert!(message.contains(expected), "{message}");
        }
        assert!(refusal(b"hello").contains("no .npy file"));
        assert!(refusal(b"\x93NUMPY\x09\x00").contains("version 9"));
        assert!(refusal(b"\x93NUMPY\x02\x00\xff\xff\xff\xff{}").contains("cut off"));
    }
}
