//! The array of pyshtools in NumPy's file: real numbers of shape (2, lmax+1, lmax+1), cosines
//! first, then `[l, m]`; zero where m > l. It says no convention.
//!
//! Complex numbers of this shape are those of a complex function, f_lm first, then f_l(-m). It is
//! real where f_l(-m) = (-1)^m conj(f_lm), and then C = sqrt(2) Re f_lm and S = -sqrt(2) Im f_lm for
//! m > 0, in the three normalisations that are orthogonal to equal norms for either sign of m.

use std::f64::consts::SQRT_2;
use std::path::Path;

use super::ReadOptions;
use super::rows::{agreed, collect};
use crate::Result;
use crate::error::InputError;
use crate::fit::Shape;
use crate::io::npy::{self, Array};
use crate::sh::{Convention, Normalisation};

/// Writes the coefficients of a shape; its centre and source have no room.
///
/// # Errors
/// [`Error::Numeric`](crate::Error::Numeric) when the degree is too high for unnormalised
/// coefficients.
pub fn write(shape: &Shape, convention: Convention) -> Result<Vec<u8>> {
    let c = &shape.coefficients;
    let n = c.lmax() + 1;
    let mut numbers = vec![0.0; 2 * n * n];
    for l in 0..n {
        for m in 0..=l {
            let (cosine, sine) = convention.export(l, m, c.get(l, m))?;
            numbers[l * n + m] = cosine;
            numbers[(n + l) * n + m] = sine;
        }
    }
    Ok(npy::write(&[2, n, n], 1, &numbers))
}

/// Reads an array in the given convention. Memory is bound by the size of the file.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input): no convention, a broken header, another shape or type, a
/// number that is not finite or beyond f64, one that is not 0 where m > l or as sine of order 0.
pub fn parse(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Shape> {
    let array = Array::parse(path, bytes)?;
    let wrong = |message: String, help: &str| Err(InputError::new(path, message).help(help).into());
    let n = match *array.shape.as_slice() {
        [2, l, m] if l == m && l > 0 => l,
        _ => {
            let message = format!("an array of shape {:?} holds no coefficients", array.shape);
            return wrong(
                message,
                "pyshtools writes (2, lmax+1, lmax+1), healpy one axis of complex numbers",
            );
        }
    };
    let convention = agreed(path, "the file says", None, options.convention)?;
    let above = |(l, m): (usize, usize)| (0..2).any(|i| array.at(&[i, l, m]) != (0.0, 0.0));
    let mut upper = (0..n).flat_map(|l| (l + 1..n).map(move |m| (l, m)));
    if let Some((l, m)) = upper.find(|place| above(*place)) {
        let message = format!("degree {l}, order {m} is not 0: the order cannot exceed the degree");
        return wrong(message, "the axes may be swapped: they are cosine or sine, degree, order");
    }
    if array.complex {
        if let Err(message) = check_real(&array, n, convention.normalisation) {
            return wrong(message, "make them real with `SHCoeffs.convert(kind='real')`");
        }
        let value = |l: usize, m: usize| match (m, array.at(&[0, l, m])) {
            (0, (re, _)) => (re, 0.0),
            (_, (re, im)) => (SQRT_2 * re, -SQRT_2 * im),
        };
        return Ok(Shape::new(collect(path, n - 1, convention, value)?));
    }
    let value = |l: usize, m: usize| (array.at(&[0, l, m]).0, array.at(&[1, l, m]).0);
    Ok(Shape::new(collect(path, n - 1, convention, value)?))
}

/// How far the coefficients of a real function may be from it, by the largest: the rounding of f32.
const ROUNDING: f64 = 1e-6;

/// Makes sure that complex coefficients up to below degree `n` are those of a real function.
fn check_real(array: &Array, n: usize, normalisation: Normalisation) -> Result<(), String> {
    if normalisation == Normalisation::Unnormalised {
        return Err("complex coefficients are read in 4pi, ortho or schmidt normalisation".into());
    }
    let places = || (0..n).flat_map(|l| (0..=l).map(move |m| (l, m)));
    let size = |(re, im): (f64, f64)| re.hypot(im);
    let largest = places().map(|(l, m)| size(array.at(&[0, l, m]))).fold(0.0, f64::max);
    let off = |&(l, m): &(usize, usize)| {
        let (re, im) = array.at(&[0, l, m]);
        // At m = 0 there is one number, which is its own mirror image.
        let mirrored = if m == 0 { (re, im) } else { array.at(&[1, l, m]) };
        let sign = if m % 2 == 0 { 1.0 } else { -1.0 };
        let apart = size((mirrored.0 - sign * re, mirrored.1 + sign * im));
        apart.is_nan() || apart > ROUNDING * largest
    };
    match places().find(off) {
        Some((l, m)) => Err(format!(
            "these are the coefficients of a complex function, and a radius is real: degree {l}, \
             orders {m} and -{m} are not conjugate"
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(shape: &[usize], parts: usize, numbers: &[f64]) -> Result<Shape> {
        let options = ReadOptions { convention: Some(Convention::default()), ..Default::default() };
        parse(Path::new("a.npy"), &npy::write(shape, parts, numbers), &options)
    }

    #[test]
    fn ball_is_two_numbers() {
        let ball = read(&[2, 1, 1], 1, &[2.5, 0.0]).expect("a ball");
        assert_eq!(ball.coefficients.mean(), 2.5);
        let bytes = write(&ball, Convention::default()).expect("written");
        assert_eq!(bytes, npy::write(&[2, 1, 1], 1, &[2.5, 0.0]));
        assert!(parse(Path::new("a.npy"), &bytes, &ReadOptions::default()).is_err());
    }

    #[test]
    fn complex_numbers_of_a_real_function_are_made_real() {
        // f_10 = 4, f_11 = 2 + 3i, f_1(-1) = -(2 - 3i).
        let first = [1.0, 0.0, 0.0, 0.0, 4.0, 0.0, 2.0, 3.0];
        let second = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -2.0, 3.0];
        let complex = read(&[2, 2, 2], 2, &[first, second].concat()).expect("real");
        let (c, s) = (2.0 * SQRT_2, -3.0 * SQRT_2);
        let real = read(&[2, 2, 2], 1, &[1.0, 0.0, 4.0, c, 0.0, 0.0, 0.0, s]).expect("real");
        assert_eq!(complex, real);
        let bytes = npy::write(&[2, 2, 2], 2, &[first, second].concat());
        let convention =
            Convention { normalisation: Normalisation::Unnormalised, ..Default::default() };
        let options = ReadOptions { convention: Some(convention), ..Default::default() };
        let message = parse(Path::new("a.npy"), &bytes, &options).expect_err("refused").to_string();
        assert!(message.contains("in 4pi, ortho or schmidt"), "{message}");
    }

    #[test]
    fn false_arrays_are_refused() {
        for (shape, parts, numbers, expected) in [
            (vec![0], 1, vec![], "an array of shape [0]"),
            (vec![2, 0, 0], 1, vec![], "an array of shape [2, 0, 0]"),
            (vec![1, 1, 1], 1, vec![1.0], "an array of shape [1, 1, 1]"),
            (vec![2, 1, 1], 2, vec![1.0; 4], "a complex function"),
            (vec![2, 1, 1], 2, vec![f64::NAN, 0.0, 0.0, 0.0], "a complex function"),
            (
                vec![2, 2, 2],
                2,
                vec![
                    1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 3.0,
                ],
                "degree 1, orders 1 and -1 are not conjugate",
            ),
            (vec![2, 1, 1], 1, vec![f64::NAN, 0.0], "not a finite number"),
            (vec![2, 1, 1], 1, vec![1.0, 1.0], "S of order 0"),
            (
                vec![2, 2, 2],
                1,
                vec![1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                "degree 0, order 1 is not 0",
            ),
        ] {
            let message = read(&shape, parts, &numbers).expect_err("refused").to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
