//! Files as scenes name them.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer};

/// Names a file as the scene wrote it and as the machine finds it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileRef {
    /// The path as written.
    pub written: PathBuf,
    /// The path relative to the scene file's folder.
    pub resolved: PathBuf,
}

impl FileRef {
    pub(super) fn resolve(&mut self, folder: &Path) {
        self.resolved = folder.join(&self.written);
    }
}

impl<'de> Deserialize<'de> for FileRef {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let written = String::deserialize(deserializer)?;
        if written.is_empty() {
            return Err(serde::de::Error::custom("must name a file, found an empty string"));
        }
        Ok(Self { written: written.clone().into(), resolved: written.into() })
    }
}
