//! The coefficient file of SPHARM-PDM and SlicerSALT (`.coef`): x, y and z of a surface as three
//! series, in text.
//!
//! ```text
//! { 4,{x, y, z},
//! {x, y, z},
//! {x, y, z},
//! {x, y, z}}
//! ```
//!
//! The first number is that of the triples, (n+1)^2 for degree n; they come degree by degree, order
//! 0, then cosine and sine of each order. The basis is orthonormal with the Condon-Shortley phase
//! and without sqrt(2): A sqrt(4 pi/(2l+1)), whatever the order. A radial shape of degree lmax
//! about a centre is exactly such a set of degree lmax + 1 (`sh::positions`). Most sets of
//! SPHARM-PDM are of other surfaces, which are read as meshes. It writes six decimals; we write 17
//! digits.

use std::f64::consts::PI;
use std::path::Path;

use super::rows::{agreed, coefficient, digits, text};
use super::{ReadOptions, SeriesFormat};
use crate::error::{Advice, InputError};
use crate::fit::{Shape, parametric_mesh};
use crate::io::input::{FilesRead, Input};
use crate::mesh::Mesh;
use crate::sh::{Coefficients, RadialPart, positions, radius_of};
use crate::{Error, Result};

/// The residual, by the mean radius, up to which a set is a radial shape whatever its decimals: the
/// rounding of f32.
const RESIDUAL: f64 = 1e-6;

/// How many decimals SPHARM-PDM writes.
const DECIMALS: usize = 6;

/// How many times the residual that its last decimal explains a set may have.
const MARGIN: f64 = 4.0;

/// Writes the surface of a shape, about its centre, in metres; its source has no room.
pub fn write(shape: &Shape) -> Vec<u8> {
    let set = positions(&shape.coefficients, shape.centre);
    let lmax = set[0].lmax();
    let mut triples = Vec::new();
    for l in 0..=lmax {
        for m in 0..=l {
            let k = factor(l);
            let pairs = [0, 1, 2].map(|i| set[i].get(l, m));
            triples.push(triple(pairs.map(|(a, _)| k * a)));
            if m > 0 {
                triples.push(triple(pairs.map(|(_, b)| k * b)));
            }
        }
    }
    format!("{{ {},{}}}", triples.len(), triples.join(",\n")).into_bytes()
}

fn triple(values: [f64; 3]) -> String {
    let [x, y, z] = values.map(digits);
    format!("{{{x}, {y}, {z}}}")
}

fn factor(l: usize) -> f64 {
    (4.0 * PI / (2 * l + 1) as f64).sqrt()
}

/// Reads a set, and finds its radius and centre. Memory is bound by the size of the text.
///
/// # Errors
/// [`Error::Input`]: not UTF-8, braces or numbers that are missing or too many, a number that is
/// not finite, a number of triples that is no square or not the announced one, a set that is no
/// radial shape (with its residual).
pub fn parse(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Shape> {
    let format = SeriesFormat::SpharmPdm;
    agreed(path, "a SPHARM-PDM file is always", format.convention(), options.convention)?;
    let set = parse_set(path, bytes)?;
    let part = radius_of(&set).ok_or_else(|| point(path))?;
    check_radial(path, &part, &set, resolution(text(path, bytes)?))?;
    Ok(Shape { centre: part.centre, ..Shape::new(part.radius) })
}

/// Reads the series of x, y and z, of whatever surface.
///
/// # Errors
/// As [`parse`], but for what is no radial shape.
pub fn parse_set(path: &Path, bytes: &[u8]) -> Result<[Coefficients; 3]> {
    let triples = triples(path, text(path, bytes)?)?;
    let set = series(&triples).map_err(|message| InputError::new(path, message))?;
    if set[0].lmax() == 0 { Err(point(path)) } else { Ok(set) }
}

/// Reads the surface of a set as a mesh, and says what was read.
///
/// # Errors
/// As [`parse_set`] and [`parametric_mesh`].
pub fn read_surface(mut input: Input) -> Result<(Mesh, FilesRead)> {
    let mesh = parametric_mesh(&parse_set(input.path(), &input.rest()?)?)?;
    Ok((mesh, input.finish()?))
}

fn point(path: &Path) -> Error {
    let error = InputError::new(path, "degree 0 is a point, no surface");
    error.help("a ball has degree 1 here").into()
}

/// Whether a text begins as such a file.
pub(super) fn is_spharm_pdm(text: &str) -> bool {
    let count = text.trim_start().strip_prefix('{').map(str::trim_start);
    count.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
}

fn check_radial(
    path: &Path,
    part: &RadialPart,
    set: &[Coefficients; 3],
    resolution: f64,
) -> Result<()> {
    // Each of the 3 n numbers is off by half a unit at most, a third of that squared in the mean,
    // and 1/(4 pi) of it is mean square.
    let rounding = resolution * (set[0].count() as f64 / (16.0 * PI)).sqrt();
    let size = (part.radius.energy() / (4.0 * PI)).sqrt();
    if part.residual <= (RESIDUAL * size).max(MARGIN * rounding) {
        return Ok(());
    }
    let message = format!(
        "this set of x, y and z is no radial shape: its points lie {:.2} % of the radius from \
         where their directions say (RMS)",
        100.0 * part.residual / size
    );
    Err(InputError::new(path, message).advise(Advice::FitSurface).into())
}

/// Finds the unit of the last decimal, from the longest plain decimal fraction; 0, exact, where a
/// number has an exponent or none has the decimals of the original.
fn resolution(text: &str) -> f64 {
    if text.contains(['e', 'E', 'd', 'D']) {
        return 0.0;
    }
    let digits = |rest: &str| rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    let decimals = text.split('.').skip(1).map(digits).max().unwrap_or(0);
    if decimals < DECIMALS {
        return 0.0;
    }
    10.0_f64.powi(-i32::try_from(decimals).unwrap_or(i32::MAX))
}

/// Reads the triples of `{ count,{x, y, z},{x, y, z}}`.
fn triples(path: &Path, text: &str) -> Result<Vec<[f64; 3]>> {
    let wrong = |place: &str, message: String| -> Error {
        // A part of the text knows where it stands by what follows it.
        let before = &text[..text.len() - place.len()];
        InputError::new(path, message).at(1 + before.matches('\n').count(), None).into()
    };
    let body = text.trim_start().strip_prefix('{');
    let (count, mut rest) = body.and_then(|body| body.split_once(',')).ok_or_else(|| {
        wrong(text, "a SPHARM-PDM file begins with `{` and the number of triples".to_owned())
    })?;
    let count: usize = count.trim().parse().map_err(|_| {
        wrong(rest, format!("`{}` is no number of triples", count.trim().escape_default()))
    })?;
    let mut triples = Vec::new();
    loop {
        rest = rest.trim_start();
        let (triple, after) = one(rest).map_err(|message| wrong(rest, message))?;
        triples.push(triple);
        rest = after.trim_start();
        match rest.strip_prefix(',') {
            Some(next) => rest = next,
            None => break,
        }
    }
    if rest.trim_end() != "}" {
        return Err(wrong(
            rest,
            "a `,` and a triple, or the closing `}`, must stand here".to_owned(),
        ));
    }
    if triples.len() != count {
        let message = format!("the file announces {count} triples and has {}", triples.len());
        return Err(InputError::new(path, message).help("part of it is lost: make it anew").into());
    }
    Ok(triples)
}

/// Reads `{x, y, z}`, and gives what follows.
fn one(text: &str) -> Result<([f64; 3], &str), String> {
    let body = text.strip_prefix('{');
    let (body, after) = body.and_then(|body| body.split_once('}')).ok_or(
        "a triple `{x, y, z}` must stand here: the file is cut off, or it is no SPHARM-PDM file",
    )?;
    let numbers: Vec<f64> =
        body.split(',').map(|cell| coefficient(cell.trim())).collect::<Result<_, _>>()?;
    let found = numbers.len();
    let triple =
        numbers.try_into().map_err(|_| format!("{found} numbers, where a triple has 3"))?;
    Ok((triple, after))
}

/// Sorts the triples into three series.
fn series(triples: &[[f64; 3]]) -> Result<[Coefficients; 3], String> {
    let n = triples.len().isqrt();
    if n * n != triples.len() {
        return Err(format!("{} triples are no whole degree: (lmax+1)^2 are", triples.len()));
    }
    let mut set = [(); 3].map(|()| Coefficients::zeros(n - 1));
    for l in 0..n {
        for m in 0..=l {
            let cosine = if m == 0 { l * l } else { l * l + 2 * m - 1 };
            for (i, series) in set.iter_mut().enumerate() {
                let sine = if m == 0 { 0.0 } else { triples[cosine + 1][i] };
                let (a, b) = (triples[cosine][i] / factor(l), sine / factor(l));
                series.set(l, m, a, b);
            }
        }
    }
    if set.iter().any(|series| !series.energy().is_finite()) {
        return Err("the numbers are beyond the range of f64".to_owned());
    }
    Ok(set)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn read(text: &str) -> Result<Shape> {
        parse(Path::new("a.coef"), text.as_bytes(), &ReadOptions::default())
    }

    fn refusal(text: &str) -> String {
        match read(text) {
            Err(Error::Input(error)) => error.to_string(),
            other => panic!("not an input error: {other:?}"),
        }
    }

    /// By hand: x = -sqrt(2) Re(Q_1^1 e^(i phi)), so A_11 of x is -sqrt(2) and its number -sqrt(2)
    /// sqrt(4 pi/3) = -2.894405.
    const BALL: &str = "{ 4,{0.000000, 0.000000, 0.000000},\n{0.000000, 0.000000, 2.046653},\n\
                        {-2.894405, 0.000000, 0.000000},\n{0.000000, -2.894405, 0.000000}}";

    fn bumpy() -> Shape {
        let mut c = Coefficients::zeros(5);
        for l in 0..=5 {
            for m in 0..=l {
                let k = 0.09 / ((l + 1) * (l + 1)) as f64;
                c.set(l, m, k * ((3 * l + m) as f64).cos(), k * ((l + 5 * m) as f64).sin());
            }
        }
        Shape { centre: DVec3::new(0.5, -0.25, 1.0), ..Shape::new(c) }
    }

    #[test]
    fn ball_of_six_decimals_is_read() {
        let shape = read(BALL).expect("a ball");
        assert_eq!(shape.coefficients.lmax(), 0);
        // Half a unit of the sixth decimal, by 2.046653 for a radius of 1.
        assert!((shape.coefficients.mean() - 1.0).abs() <= 5e-7 && shape.centre.length() <= 1e-6);
    }

    #[test]
    fn surface_comes_back_with_its_centre() {
        let shape = bumpy();
        let text = String::from_utf8(write(&shape)).expect("UTF-8");
        assert!(text.starts_with("{ 49,{") && text.ends_with("}}"));
        let back = read(&text).expect("read");
        assert!(back.centre.distance(shape.centre) <= 1e-15);
        let pairs = back.coefficients.cosines().iter().zip(shape.coefficients.cosines());
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() <= 1e-15));
    }

    #[test]
    fn as_many_decimals_as_the_original_writes_are_enough() {
        let text = String::from_utf8(write(&bumpy())).expect("UTF-8");
        let cut = |cell: &str| cell.trim().parse().map(|v: f64| format!("{v:.6}"));
        let short: String = text
            .split_inclusive([',', '{', '}'])
            .map(|part| {
                let (cell, end) = part.split_at(part.len() - 1);
                let cell =
                    if cell.contains('.') { cut(cell).unwrap_or_default() } else { cell.into() };
                cell + end
            })
            .collect();
        let back = read(&short).expect("read");
        assert!((back.coefficients.mean() - bumpy().coefficients.mean()).abs() <= 1e-6);
    }

    #[test]
    fn surface_that_is_not_radial_is_refused_with_its_residual() {
        let stretched = BALL.replacen("-2.894405", "-5.788810", 1);
        let message = refusal(&stretched);
        // The root of 2/9 by 4/3: see the test of `sh::radius_of`.
        assert!(message.contains("its points lie 35.36 % of the radius from"), "{message}");
        assert!(message.contains("and fit that"));
        // An ellipsoid of half axes 2, 1, 1, but for what its faces leave out.
        let input = Input::of_bytes(Path::new("a.coef"), stretched.as_bytes());
        let volume = read_surface(input).expect("a surface").0.volume();
        assert!((volume / (8.0 / 3.0 * PI) - 1.0).abs() <= 1e-3, "{volume}");
    }

    #[test]
    fn broken_files_are_refused() {
        for (text, expected) in [
            ("", "begins with `{`"),
            ("{ 4", "begins with `{`"),
            ("{ x,{0,0,0}}", "`x` is no number of triples"),
            ("{ 1,{0,0,0}}", "degree 0 is a point"),
            ("{ 2,{0,0,0},\n{0,0,1}}", "2 triples are no whole degree"),
            ("{ 99999999999,{0,0,0}}", "announces 99999999999 triples and has 1"),
            ("{ 4,{0,0,0},{0,0,1},{1,0,0},{0,1,0}", "a.coef:1: a `,` and a triple"),
            ("{ 4,{0,0,0},\n{0,0,1},\n{1,0,0},\n{0,1", "a.coef:4: a triple"),
            ("{ 4,{0,0,0},{0,0},{1,0,0},{0,1,0}}", "2 numbers, where a triple has 3"),
            ("{ 4,{0,0,0},{0,0,nan},{1,0,0},{0,1,0}}", "`nan` is not a finite number"),
            ("{ 4,{0,0,0},{0,0,1e308},{1e308,0,0},{0,1e308,0}}", "beyond the range of f64"),
            ("{ 4,{0,0,0},{0,0,1},{1,0,0},{0,1,0}} more", "closing `}`"),
        ] {
            let found = refusal(text);
            assert!(found.contains(expected), "{found}");
        }
        assert!((0..BALL.len()).all(|end| read(&BALL[..end]).is_err()));
    }
}
