//! Coefficient files: the formats they have, each read and written in a file of its own, and the
//! doors to all of them. docs/reference/files.md says what each format keeps and in which
//! convention its numbers stand.

mod aics_csv;
mod annotated;
mod format;
mod recognise;
mod rows;

pub mod alm_fits;
pub mod alm_npy;
pub mod binary;
pub mod bshc;
pub mod cilm_npy;
pub mod compact;
pub mod dov;
pub mod icgem;
pub mod shadr;
pub mod shape_table;
pub mod shtools_text;
pub mod spharm_pdm;

pub use compact::Tolerance;
pub use format::SeriesFormat;
pub use recognise::{recognise, recognise_content};

use std::path::{Path, PathBuf};

use crate::error::{Advice, InputError};
use crate::fit::Shape;
use crate::io::input::{FilesRead, Input};
use crate::io::meshes;
use crate::sh::Convention;
use crate::{Error, Result};

/// Says what a coefficient file may leave open.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReadOptions {
    /// The format; `None` lets content and extension tell it.
    pub format: Option<SeriesFormat>,
    /// The convention of a file that does not state it; it must not contradict one that does.
    pub convention: Option<Convention>,
    /// The length of the file's unit, metres, where the file does not state it; `None` is the
    /// metre.
    pub unit: Option<f64>,
    /// What is added to the mean radius, metres, where the file holds heights above this radius.
    pub add_radius: Option<f64>,
    /// The row to read of a table that holds several shapes, counted from 1.
    pub row: Option<usize>,
}

/// Reads a coefficient file.
///
/// # Errors
/// [`Error::Io`] when the file cannot be read, else as [`parse`].
pub fn read(path: &Path, options: &ReadOptions) -> Result<Shape> {
    Ok(read_input(Input::open(path)?, options)?.0)
}

/// Reads a coefficient file as [`read`] does, and says what was read.
///
/// # Errors
/// As [`read`].
pub fn read_input(mut input: Input, options: &ReadOptions) -> Result<(Shape, FilesRead)> {
    let (path, name, bytes) = (input.path(), input.name(), input.rest()?);
    let format = options.format.or_else(|| recognise(name, &bytes));
    let shape = parse(path, &bytes, &ReadOptions { format, ..*options })?;
    Ok((shape, input.finish()?))
}

/// Holds a shape and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedShape {
    /// The file.
    pub path: PathBuf,
    /// The name of its row, where the file is a table of many.
    pub row: Option<String>,
    /// The shape.
    pub shape: Shape,
}

impl NamedShape {
    /// Returns the name of the row, or of the file without folders and extension.
    pub fn name(&self) -> String {
        let stem = || self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        self.row.clone().unwrap_or_else(stem)
    }

    /// Returns the name of the row, or the path of the file.
    pub fn full_name(&self) -> PathBuf {
        self.row.as_ref().map_or_else(|| self.path.clone(), PathBuf::from)
    }
}

/// Reads all shapes of a coefficient file: each row of a table, unless one is asked for; else the
/// one that it holds.
///
/// # Errors
/// As [`read`].
pub fn read_all(path: &Path, options: &ReadOptions) -> Result<Vec<NamedShape>> {
    let mut input = Input::open(path)?;
    let (path, bytes) = (input.path(), input.rest()?);
    let format = options.format.or_else(|| recognise(input.name(), &bytes));
    let named = |row, shape| NamedShape { path: path.to_owned(), row, shape };
    let shapes = match format.filter(|format| format.has_rows() && options.row.is_none()) {
        Some(format) => shape_table::parse_all(path, &bytes, format, options)?
            .into_iter()
            .map(|(row, shape)| Ok(named(Some(row), finished(path, shape, options)?)))
            .collect::<Result<_>>()?,
        None => vec![named(None, parse(path, &bytes, &ReadOptions { format, ..*options })?)],
    };
    input.finish()?;
    Ok(shapes)
}

/// Reads a coefficient file of which no more can be said than its name: what must be said of it is
/// said when it is converted.
///
/// # Errors
/// As [`read`].
pub fn read_as_stated(input: Input) -> Result<(Shape, FilesRead)> {
    read_input(input, &ReadOptions::default()).map_err(|e| advise_conversion(e, &|_| false))
}

/// Turns the advice to say more of a file into that to say it when the file is converted, but for
/// what can be said here as well.
pub fn advise_conversion(error: Error, here: &dyn Fn(&Advice) -> bool) -> Error {
    let Error::Input(mut input) = error else { return error };
    let is_of_fit = |advice: &Advice| matches!(advice, Advice::FitSurface | Advice::FitMesh);
    let is_foreign = |advice: &mut Box<Advice>| !is_of_fit(advice) && !here(advice);
    if let Some(advice) = input.advice.take_if(is_foreign) {
        let path = input.path.clone();
        input.advice = Some(Box::new(Advice::Convert { advice, path }));
    }
    Error::Input(input)
}

/// Reads the bytes of a coefficient file; `path` is for messages and, where the content leaves a
/// choice, its extension.
///
/// # Errors
/// [`Error::Input`] when the format is not known, or as the reader of the format says;
/// [`Error::Parameter`] when a row is asked for of a format that has none.
pub fn parse(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Shape> {
    let format = options.format.or_else(|| recognise(path, bytes)).ok_or_else(|| {
        let head = &bytes[..bytes.len().min(1 << 16)];
        if meshes::recognise(head, bytes.len() as u64).is_some() {
            let message = "this is a mesh, where coefficients are wanted";
            return InputError::new(path, message).advise(Advice::FitMesh);
        }
        let names: Vec<_> = SeriesFormat::ALL.iter().map(|format| format.name()).collect();
        let advice = Advice::StateFormat(names.join(", "));
        InputError::new(path, "unrecognised coefficient file").advise(advice)
    })?;
    if options.row.is_some() && !format.has_rows() {
        return Err(Error::Parameter(format!(
            "{}: {} has one shape and no rows",
            path.display(),
            format.noun()
        ))
        .advise(Advice::LeaveOutRow));
    }
    if matches!(format, SeriesFormat::Binary | SeriesFormat::Compact)
        && options.convention.is_some()
    {
        let message = "our own forms have one normalisation and phase, which need not be said";
        return Err(InputError::new(path, message).advise(Advice::LeaveOutConvention).into());
    }
    let shape = match format {
        SeriesFormat::Text => shtools_text::parse(path, bytes, options),
        SeriesFormat::Dov => dov::parse(path, bytes, options),
        SeriesFormat::Bshc => bshc::parse(path, bytes, options),
        SeriesFormat::Npy => cilm_npy::parse(path, bytes, options),
        SeriesFormat::Alm => alm_npy::parse(path, bytes, options),
        SeriesFormat::Fits => alm_fits::parse(path, bytes, options),
        SeriesFormat::SpharmPdm => spharm_pdm::parse(path, bytes, options),
        SeriesFormat::Aics | SeriesFormat::Table => {
            shape_table::parse(path, bytes, format, options)
        }
        SeriesFormat::Shadr => shadr::parse(path, bytes, options),
        SeriesFormat::Icgem => icgem::parse(path, bytes, options),
        SeriesFormat::Binary => binary::parse(path, bytes),
        SeriesFormat::Compact => compact::parse(path, bytes),
    }?;
    finished(path, shape, options)
}

/// Turns a shape as its file has it into what was asked for.
fn finished(path: &Path, shape: Shape, options: &ReadOptions) -> Result<Shape> {
    let shape = in_metres(path, shape, options.unit)?;
    Ok(match options.add_radius {
        Some(radius) => above(shape, radius),
        None => shape,
    })
}

/// Adds a radius to the heights above it.
fn above(mut shape: Shape, radius: f64) -> Shape {
    let mean = shape.coefficients.mean();
    shape.coefficients.set(0, 0, mean + radius, 0.0);
    shape
}

/// Returns in which convention the numbers of a file stand: that of the format, the one it states,
/// else the one that is given; `None` for our own forms, which keep the internal basis.
///
/// # Errors
/// As [`parse`], for what comes before the coefficients.
pub fn convention(
    path: &Path,
    bytes: &[u8],
    format: SeriesFormat,
    options: &ReadOptions,
) -> Result<Option<Convention>> {
    let stated = match format {
        SeriesFormat::Text | SeriesFormat::Dov => annotated::convention(path, bytes)?,
        SeriesFormat::Shadr => shadr::convention(path, bytes)?,
        SeriesFormat::Icgem => icgem::convention(path, bytes)?,
        SeriesFormat::Table => return shape_table::convention(path, bytes, options).map(Some),
        SeriesFormat::Binary | SeriesFormat::Compact => return Ok(None),
        _ => format.convention(),
    };
    Ok(stated.or(options.convention))
}

/// Scales a shape whose file has another unit.
fn in_metres(path: &Path, shape: Shape, unit: Option<f64>) -> Result<Shape> {
    let Some(metres) = unit.filter(|metres| *metres != 1.0) else { return Ok(shape) };
    let coefficients = shape.coefficients.scaled(metres);
    if !coefficients.energy().is_finite() {
        let message = "the coefficients are beyond the range of f64 in metres";
        return Err(InputError::new(path, message).into());
    }
    Ok(Shape { coefficients, centre: metres * shape.centre, ..shape })
}

/// Says what a format leaves open to the writer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WriteOptions {
    /// The convention, where the format has none by definition ([`SeriesFormat::convention`]).
    pub convention: Convention,
    /// How far the radius may be changed by the compact form.
    pub tolerance: Tolerance,
}

impl Default for WriteOptions {
    /// The convention of pyshtools; a thousandth of the mean radius.
    fn default() -> Self {
        Self { convention: Convention::default(), tolerance: Tolerance::OfMeanRadius(1e-3) }
    }
}

/// Writes a shape in a format.
///
/// # Errors
/// [`Error::Numeric`] when the degree is too high for unnormalised coefficients;
/// [`Error::Parameter`] for a convention that the format cannot say, or a tolerance that it cannot
/// hold, or a format that is read only.
pub fn encode(shape: &Shape, format: SeriesFormat, options: &WriteOptions) -> Result<Vec<u8>> {
    let convention = options.convention;
    match format {
        SeriesFormat::Text => shtools_text::write(shape, convention),
        SeriesFormat::Dov => dov::write(shape, convention),
        SeriesFormat::Bshc => bshc::write(shape, convention),
        SeriesFormat::Npy => cilm_npy::write(shape, convention),
        SeriesFormat::Alm => Ok(alm_npy::write(shape)),
        SeriesFormat::SpharmPdm => Ok(spharm_pdm::write(shape)),
        SeriesFormat::Aics | SeriesFormat::Table => shape_table::write(shape, format),
        SeriesFormat::Shadr => shadr::write(shape, convention),
        SeriesFormat::Binary => binary::encode(shape),
        SeriesFormat::Compact => Ok(compact::encode(shape, options.tolerance)?.bytes),
        SeriesFormat::Fits | SeriesFormat::Icgem => Err(format.read_only()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_file_is_reported_with_its_path() {
        let error = read(Path::new("/no/such.txt"), &ReadOptions::default()).expect_err("missing");
        assert!(error.to_string().starts_with("/no/such.txt: cannot read"));
    }
}
