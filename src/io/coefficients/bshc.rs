//! The binary "bshc" of Curtin University, as pyshtools reads and writes it: 64-bit floats of the
//! little-endian kind, the lowest and the highest degree first, then all cosines and then all
//! sines, degree by degree, order 0 to l in each. It says no convention.

use std::path::Path;

use super::ReadOptions;
use super::rows::{agreed, collect};
use crate::Result;
use crate::error::InputError;
use crate::fit::Shape;
use crate::io::bytes::number_at;
use crate::sh::Convention;

/// Bytes of a number.
const NUMBER: usize = 8;

/// Writes the coefficients of a shape; its centre and source have no room.
///
/// # Errors
/// [`Error::Numeric`](crate::Error::Numeric) when the degree is too high for unnormalised
/// coefficients.
pub fn write(shape: &Shape, convention: Convention) -> Result<Vec<u8>> {
    let c = &shape.coefficients;
    let mut numbers = vec![0.0, c.lmax() as f64];
    let mut sines = Vec::new();
    for l in 0..=c.lmax() {
        for m in 0..=l {
            let (cosine, sine) = convention.export(l, m, c.get(l, m))?;
            numbers.push(cosine);
            sines.push(sine);
        }
    }
    Ok(numbers.iter().chain(&sines).flat_map(|value| value.to_le_bytes()).collect())
}

/// Reads a file in the given convention. Memory is bound by the size of the file, whatever degree
/// it announces.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input): no convention, a size that does not fit the announced
/// degree, degrees that do not start at 0, a number that is not finite or beyond f64, a sine of
/// order 0.
pub fn parse(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Shape> {
    let convention = agreed(path, "the file says", None, options.convention)?;
    let lmax =
        degree(bytes, bytes.len() as u64).map_err(|message| InputError::new(path, message))?;
    let triangle = (lmax + 1) * (lmax + 2) / 2;
    let value = |l: usize, m: usize| {
        let at = 2 + l * (l + 1) / 2 + m;
        (number(bytes, at), number(bytes, at + triangle))
    };
    Ok(Shape::new(collect(path, lmax, convention, value)?))
}

/// Whether a file of this size that begins so is such a file: two whole numbers, and the size they
/// announce.
pub(super) fn is_bshc(head: &[u8], size: u64) -> bool {
    degree(head, size).is_ok()
}

/// Reads the highest degree, and checks that the file has its size.
fn degree(head: &[u8], size: u64) -> Result<usize, String> {
    if head.len() < 2 * NUMBER {
        return Err(format!("{size} bytes are too few for a bshc file"));
    }
    let (first, last) = (number(head, 0), number(head, 1));
    if first != 0.0 || !(0.0..=1e6).contains(&last) || last.fract() != 0.0 {
        return Err(format!(
            "the file announces degrees {first:?} to {last:?}: a radius has all degrees from 0 to \
             a whole number"
        ));
    }
    let count = (last as u64 + 1) * (last as u64 + 2);
    let expected = (count + 2) * NUMBER as u64;
    if size != expected {
        return Err(format!(
            "degree {last} takes {expected} bytes, the file has {size}: part of it is lost, or it \
             is no bshc file"
        ));
    }
    Ok(last as usize)
}

/// Returns the number at a place, counted in numbers; NaN past the end.
fn number(bytes: &[u8], at: usize) -> f64 {
    number_at(bytes, at * NUMBER).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sh::Coefficients;

    fn file(numbers: &[f64]) -> Vec<u8> {
        numbers.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    fn read(bytes: &[u8]) -> Result<Shape> {
        let convention = Some(Convention::default());
        parse(Path::new("a.bshc"), bytes, &ReadOptions { convention, ..Default::default() })
    }

    #[test]
    fn ball_is_four_numbers() {
        let ball = file(&[0.0, 0.0, 2.5, 0.0]);
        assert_eq!(read(&ball).expect("a ball").coefficients.mean(), 2.5);
        let mut c = Coefficients::zeros(0);
        c.set(0, 0, 2.5, 0.0);
        assert_eq!(write(&Shape::new(c), Convention::default()).expect("written"), ball);
        assert!(parse(Path::new("a.bshc"), &ball, &ReadOptions::default()).is_err());
    }

    #[test]
    fn false_files_are_refused() {
        for (numbers, expected) in [
            (vec![], "0 bytes are too few"),
            (vec![0.0, 1.0, 1.0], "degree 1 takes 64 bytes, the file has 24"),
            (vec![0.0, 1e9, 1.0], "announces degrees 0.0 to 1000000000.0"),
            (vec![0.0, 1e6, 1.0], "degree 1000000 takes 8000024000032 bytes"),
            (vec![1.0, 1.0, 1.0, 1.0], "announces degrees 1.0 to 1.0"),
            (vec![0.0, 0.5, 1.0, 0.0], "announces degrees 0.0 to 0.5"),
            (vec![0.0, f64::NAN, 1.0, 0.0], "announces degrees 0.0 to NaN"),
            (vec![0.0, 0.0, f64::INFINITY, 0.0], "`inf` (degree 0, order 0) is not a finite"),
            (vec![0.0, 0.0, 1.0, 1.0], "S of order 0 is 1e0 at degree 0"),
        ] {
            let message = read(&file(&numbers)).expect_err("refused").to_string();
            assert!(message.contains(expected), "{message}");
        }
        let whole = file(&[0.0, 0.0, 2.5, 0.0]);
        assert!((0..whole.len()).all(|end| read(&whole[..end]).is_err()));
    }
}
