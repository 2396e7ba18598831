//! Errors that name the file they are about.

use std::path::Path;

use harmolux::Error;

/// Puts the file before what is wrong with what it holds.
pub(crate) fn about(path: &Path, error: Error) -> Error {
    let name = path.display();
    error.map(|error| match error {
        Error::Geometry(text) => Error::Geometry(format!("{name}: {text}")),
        Error::Parameter(text) => Error::Parameter(format!("{name}: {text}")),
        Error::Numeric(text) => Error::Numeric(format!("{name}: {text}")),
        other => other,
    })
}
