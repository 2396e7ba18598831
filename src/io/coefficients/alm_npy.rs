//! The complex a_lm of healpy and ducc0 in NumPy's file: one axis, order by order (m = 0 with l =
//! 0..lmax, m = 1 with l = 1..lmax, ...), orthonormal with the Condon-Shortley phase: f = sum_l
//! a_l0 Y_l0 + 2 Re sum_{m>0} a_lm Y_lm, so that a_lm = (A_lm - i B_lm)/(2 - d) sqrt(4 pi/(2l + 1))
//! with d = 1 at m = 0, else 0.

use std::f64::consts::PI;
use std::path::Path;

use super::rows::agreed;
use super::{ReadOptions, SeriesFormat};
use crate::Result;
use crate::error::InputError;
use crate::fit::Shape;
use crate::io::npy::{self, Array};
use crate::sh::Coefficients;

/// How far an imaginary part at m = 0 may be from 0, by the largest number: what rotations in
/// double precision leave behind.
const ROUNDING: f64 = 1e-12;

/// Returns what A_lm and -B_lm are multiplied with.
fn factor(l: usize, m: usize) -> f64 {
    let scale = (4.0 * PI / (2 * l + 1) as f64).sqrt();
    if m == 0 { scale } else { 0.5 * scale }
}

/// Writes the a_lm of a shape; its centre and source have no room.
pub fn write(shape: &Shape) -> Vec<u8> {
    let c = &shape.coefficients;
    let mut numbers = Vec::new();
    for m in 0..=c.lmax() {
        for l in m..=c.lmax() {
            let (a, b) = c.get(l, m);
            numbers.extend([a * factor(l, m), if m == 0 { 0.0 } else { -b * factor(l, m) }]);
        }
    }
    npy::write(&[numbers.len() / 2], 2, &numbers)
}

/// Reads a_lm. Memory is bound by the size of the file.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input): a broken header, another shape or type, a number of a_lm
/// that is no full triangle, a number that is not finite, an imaginary part at m = 0.
pub fn parse(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Shape> {
    let format = SeriesFormat::Alm;
    agreed(path, "a_lm are always", format.convention(), options.convention)?;
    let array = Array::parse(path, bytes)?;
    let wrong = |message: String| InputError::new(path, message);
    // ducc0 leads with an axis of components.
    let (last, leading) = array.shape.split_last().unwrap_or((&0, &[]));
    if !array.complex || leading.iter().any(|n| *n != 1) {
        let message = format!("an array of shape {:?} holds no a_lm", array.shape);
        return Err(wrong(message).help("they are complex numbers along one axis").into());
    }
    let lmax = degree(*last).ok_or_else(|| {
        wrong(format!("{last} a_lm are no triangle of (lmax+1)(lmax+2)/2"))
            .help("all orders up to lmax must be there (mmax = lmax)")
    })?;
    let mut index = vec![0; array.shape.len()];
    let mut values = Vec::with_capacity(*last);
    for i in 0..*last {
        index[leading.len()] = i;
        values.push(array.at(&index));
    }
    series(&values, lmax).map(Shape::new).map_err(|message| wrong(message).into())
}

/// Finds lmax from the number of a_lm.
pub(super) fn degree(count: usize) -> Option<usize> {
    let lmax = (2 * count).isqrt().checked_sub(1)?;
    (count > 0 && (lmax + 1) * (lmax + 2) / 2 == count).then_some(lmax)
}

pub(super) fn series(values: &[(f64, f64)], lmax: usize) -> Result<Coefficients, String> {
    if let Some(i) = values.iter().position(|(re, im)| !(re.is_finite() && im.is_finite())) {
        return Err(format!("number {i} of the a_lm is not finite"));
    }
    let largest = values.iter().fold(0.0_f64, |max, (re, im)| max.max(re.abs()).max(im.abs()));
    let mut c = Coefficients::zeros(lmax);
    for m in 0..=lmax {
        for l in m..=lmax {
            let (re, im) = values[m * (2 * lmax + 1 - m) / 2 + l];
            if m == 0 && im.abs() > ROUNDING * largest {
                return Err(format!(
                    "the imaginary part of degree {l}, order 0 is {im:e}: a real radius has none"
                ));
            }
            let (a, b) = (re / factor(l, m), -im / factor(l, m));
            if !(a.is_finite() && b.is_finite()) {
                return Err(format!("degree {l}, order {m} is beyond the range of f64"));
            }
            c.set(l, m, a, b);
        }
    }
    Ok(c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sh::{Convention, Normalisation};

    fn read(shape: &[usize], parts: usize, numbers: &[f64]) -> Result<Shape> {
        parse(Path::new("a.npy"), &npy::write(shape, parts, numbers), &ReadOptions::default())
    }

    #[test]
    fn ball_is_one_number() {
        let ball = read(&[1], 2, &[(4.0 * PI).sqrt(), 0.0]).expect("a ball");
        assert_eq!(ball.coefficients.mean(), 1.0);
        assert_eq!(write(&ball), npy::write(&[1], 2, &[(4.0 * PI).sqrt(), 0.0]));
        let one_row = read(&[1, 1], 2, &[(4.0 * PI).sqrt(), 0.0]).expect("ducc0's shape");
        assert_eq!(one_row, ball);
    }

    #[test]
    fn orders_come_one_after_another() {
        let mut c = Coefficients::zeros(2);
        for (i, (l, m)) in [(0, 0), (1, 0), (2, 0), (1, 1), (2, 1), (2, 2)].into_iter().enumerate()
        {
            c.set(l, m, i as f64 + 1.0, if m == 0 { 0.0 } else { -(i as f64) });
        }
        let bytes = write(&Shape::new(c.clone()));
        let back = parse(Path::new("a.npy"), &bytes, &ReadOptions::default()).expect("read");
        let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-14);
        assert!(apart(back.coefficients.cosines(), c.cosines()));
        assert!(apart(back.coefficients.sines(), c.sines()));
        let array = Array::parse(Path::new("a.npy"), &bytes).expect("read");
        let expected = (4.0 * PI / 3.0).sqrt() / 2.0;
        assert!((array.at(&[3]).0 - 4.0 * expected).abs() <= 1e-14);
        assert!((array.at(&[3]).1 - 3.0 * expected).abs() <= 1e-14);
    }

    #[test]
    fn false_arrays_are_refused() {
        for (shape, parts, numbers, expected) in [
            (vec![0], 2, vec![], "0 a_lm are no triangle"),
            (vec![2], 2, vec![1.0; 4], "2 a_lm are no triangle"),
            (vec![], 2, vec![1.0, 0.0], "0 a_lm are no triangle"),
            (vec![1], 1, vec![1.0], "holds no a_lm"),
            (vec![2, 1], 2, vec![1.0; 4], "holds no a_lm"),
            (vec![1], 2, vec![1.0, 0.1], "the imaginary part of degree 0, order 0 is 1e-1"),
            (vec![1], 2, vec![f64::INFINITY, 0.0], "number 0 of the a_lm is not finite"),
        ] {
            let message = read(&shape, parts, &numbers).expect_err("refused").to_string();
            assert!(message.contains(expected), "{message}");
        }
        let convention = Convention { normalisation: Normalisation::Schmidt, ..Default::default() };
        let options = ReadOptions { convention: Some(convention), ..Default::default() };
        let message = parse(Path::new("a.npy"), b"", &options).expect_err("refused").to_string();
        assert!(message.contains("a_lm are always ortho, csphase -1; asked for was schmidt"));
    }
}
