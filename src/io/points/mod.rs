//! Point clouds: text, PLY without faces, and arrays of NumPy, told by their content.

mod array;
mod ply;
mod text;

use std::path::Path;

use glam::DVec3;

use crate::Result;
use crate::error::InputError;
use crate::io::input::{FilesRead, Input};
use crate::io::ply::is_ply;
use crate::io::source::Source;
use crate::io::{coefficients, meshes, npy};
use crate::mesh::Points;

/// The most columns that a point has where they have no names: what it carries beside x, y and z is
/// colours, normals and the like. A table of more is none of points.
const MOST_COLUMNS: usize = 32;

/// Says what a point file may leave open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PointOptions {
    /// Whether the points have weights: the column called weight or w, which counts whether this is
    /// said or not, else the fourth.
    pub weights: bool,
}

/// Returns a point file from a mesh by its extension: .xyz, .pts, .asc or .csv.
pub fn is_points(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    ["xyz", "pts", "asc", "csv"].iter().any(|e| e.eq_ignore_ascii_case(extension))
}

/// Whether a file that begins so holds points and says it by a sign that no mesh has: a PLY header
/// without faces, or an array of rows.
pub fn is_marked(head: &[u8]) -> bool {
    ply::is_cloud(head) || array::is_rows(head)
}

/// Whether a file that begins so holds points: it [is marked](is_marked) so, or is text whose first
/// line with more than a comment is a point, their number, or names the columns x, y and z, and
/// nothing says that it is a mesh or coefficients.
pub fn recognise(head: &[u8]) -> bool {
    let length = head.len() as u64;
    is_marked(head)
        || meshes::recognise(head, length).is_none()
            && coefficients::recognise_content(head, length).is_none()
            && text::recognise(head)
}

/// Whether the first line of a text with more than a comment names the columns x, y and z.
pub(in crate::io) fn names_columns(head: &[u8]) -> bool {
    text::names_columns(head)
}

/// Reads a point file.
///
/// # Errors
/// [`crate::Error::Io`] when the file cannot be read; [`crate::Error::Input`] with the place of what is no point.
pub fn read(path: &Path, options: PointOptions) -> Result<Points> {
    Ok(read_input(Input::open(path)?, options)?.0)
}

/// Reads a point file as [`read`] does, and says what was read.
///
/// # Errors
/// As [`read`].
pub fn read_input(input: Input, options: PointOptions) -> Result<(Points, FilesRead)> {
    let mut source = Source::new(input);
    let points = parse_source(&mut source, options)?;
    Ok((points, source.finish()?))
}

/// Reads points from the bytes of a file of any kind; `path` is for messages.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, bytes: &[u8], options: PointOptions) -> Result<Points> {
    parse_source(&mut Source::of_bytes(path, bytes), options)
}

fn parse_source(source: &mut Source, options: PointOptions) -> Result<Points> {
    let head = source.ahead()?;
    let points = if head.starts_with(npy::MAGIC) {
        array::parse(source.path(), &source.rest()?, options)
    } else if is_ply(head) {
        ply::parse(source, options)
    } else {
        text::parse(source, options)
    }?;
    if points.positions.is_empty() {
        return Err(source.fault("no point stands in this file", WANTED));
    }
    Ok(points)
}

const WANTED: &str = "write a point a line: x y z, and what else it has after them";

/// Says that weights are asked for and there are none.
fn no_weights(path: &Path, columns: &str) -> InputError {
    let message = format!("there are no weights here: {columns}");
    InputError::new(path, message).help("call a column weight, or ask for no weights")
}

/// Makes a point and its weight of numbers, or says which of them (0 to 3) cannot be.
fn point(position: [f64; 3], weight: f64) -> Result<(DVec3, f64), (usize, String)> {
    if let Some(i) = position.iter().position(|x| !x.is_finite()) {
        return Err((i, format!("`{}` is not a finite number", position[i])));
    }
    match weight {
        w if !w.is_finite() => Err((3, format!("`{w}` is not a finite number"))),
        w if w < 0.0 => Err((3, format!("the weight {w} is negative: weights are 0 or more"))),
        w => Ok((DVec3::from_array(position), w)),
    }
}
