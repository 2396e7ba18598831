//! A file that is a shape, whichever way: coefficients or a mesh.

use std::path::Path;

use harmolux::Result;
use harmolux::error::Advice;
use harmolux::fit::Shape;
use harmolux::io::coefficients;
use harmolux::io::coefficients::ReadOptions;
use harmolux::io::input::{FilesRead, Input};
use harmolux::mesh::Mesh;
use harmolux::study::Subject;

use crate::common::flags::{MeshHabits, SeriesHabits};
use crate::common::inputs::{read_mesh, series_format};

/// What a file holds.
pub(crate) enum Read {
    Series(Shape),
    Mesh(Mesh),
}

impl Read {
    /// Reads a file of either kind.
    pub(crate) fn open(
        path: &Path,
        series: &SeriesHabits,
        mesh: &MeshHabits,
    ) -> Result<(Self, FilesRead)> {
        let mut input = Input::open(path)?;
        let options = ReadOptions { convention: series.convention(), ..ReadOptions::default() };
        let format = series_format(&mut input, &options)?;
        if format.is_none() {
            return read_mesh(input, mesh).map(|read| (Self::Mesh(read.mesh), read.files));
        }
        let shape = coefficients::read_input(input, &ReadOptions { format, ..options });
        // The flags of `SeriesHabits` say the convention here as well.
        let advised = |e| coefficients::advise_conversion(e, &Advice::is_of_convention);
        shape.map(|(shape, files)| (Self::Series(shape), files)).map_err(advised)
    }

    /// Returns what is compared.
    pub(crate) fn subject(&self) -> Subject<'_> {
        match self {
            Self::Series(shape) => Subject::Series(shape),
            Self::Mesh(mesh) => Subject::Mesh(mesh),
        }
    }
}
