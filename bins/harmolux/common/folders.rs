//! Folders that a verb fills with a file for each of many shapes.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use harmolux::io::coefficients::NamedShape;
use harmolux::{Error, Result};

/// Whether the output is meant as a folder: it is one, or its name has no extension.
pub(crate) fn is_folder(output: &Path) -> bool {
    output.is_dir() || output.extension().is_none()
}

/// Makes a folder for what is done in it; one that was made for it does not stay behind empty when
/// that fails.
pub(crate) fn within<T>(folder: &Path, work: impl FnOnce() -> Result<T>) -> Result<T> {
    let is_new = !folder.exists();
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "create", e))?;
    let done = work();
    if done.is_err() && is_new {
        // Removes an empty folder only.
        let _ = std::fs::remove_dir(folder);
    }
    done
}

/// Returns the file of each shape in a folder: its name without folders, with this extension.
pub(crate) fn files(folder: &Path, shapes: &[NamedShape], extension: &str) -> Result<Vec<PathBuf>> {
    let file = |shape: &NamedShape| {
        let name = shape.name();
        let name = Path::new(&name).file_name().unwrap_or("shape".as_ref()).to_string_lossy();
        folder.join(format!("{name}.{extension}"))
    };
    let files: Vec<PathBuf> = shapes.iter().map(file).collect();
    let sources: Vec<PathBuf> = shapes.iter().map(NamedShape::full_name).collect();
    require_apart(&sources, &files, "write")?;
    Ok(files)
}

/// Makes sure that no two of what is given would be written to one file; `verb` says what is to be
/// done elsewhere.
pub(crate) fn require_apart(sources: &[PathBuf], files: &[PathBuf], verb: &str) -> Result<()> {
    let mut taken: HashMap<&Path, &Path> = HashMap::new();
    for (source, file) in sources.iter().zip(files) {
        if let Some(other) = taken.insert(file, source) {
            return Err(Error::Parameter(format!(
                "{} and {} would both be written to {}: {verb} them into different folders",
                other.display(),
                source.display(),
                file.display()
            )));
        }
    }
    Ok(())
}
