//! A file that is a shape, whichever way: coefficients or a mesh.

use std::path::Path;

use harmolux::Result;
use harmolux::io::coefficients::{self, Shape};
use harmolux::study::Subject;
use harmolux::surface::Mesh;

use super::arguments::{MeshHabits, SeriesHabits};
use super::fit::read_mesh;

/// What a file holds.
pub(crate) enum Read {
    Series(Shape),
    Mesh(Mesh),
}

impl Read {
    /// Reads a file of either kind.
    pub(crate) fn open(path: &Path, series: &SeriesHabits, mesh: &MeshHabits) -> Result<Self> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        let is_series = ["txt", "sh"].iter().any(|e| e.eq_ignore_ascii_case(extension));
        if is_series {
            coefficients::read(path, series.convention()).map(Self::Series)
        } else {
            read_mesh(path, mesh).map(Self::Mesh)
        }
    }

    /// Gives what is compared.
    pub(crate) fn subject(&self) -> Subject<'_> {
        match self {
            Self::Series(shape) => Subject::Series(shape),
            Self::Mesh(mesh) => Subject::Mesh(mesh),
        }
    }
}
