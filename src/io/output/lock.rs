//! Locks on files that end with the process that holds them, however it ends.

use std::fs::{self, File, TryLockError};
use std::path::Path;

/// Says whose a file is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lock {
    /// Ours until the file is closed.
    Ours,
    /// Another process holds it.
    Another,
    /// The file was removed or replaced while we looked.
    Gone,
    /// The file system knows no locks.
    Unknown,
}

impl Lock {
    /// Tries to lock a file that was opened as `path`.
    pub(super) fn take(file: &File, path: &Path) -> Self {
        match file.try_lock() {
            Ok(()) if stands(file, path) => Self::Ours,
            Ok(()) => Self::Gone,
            Err(TryLockError::WouldBlock) => Self::Another,
            Err(TryLockError::Error(_)) => Self::Unknown,
        }
    }
}

/// Whether this very file still stands at `path`.
#[cfg(unix)]
pub(super) fn stands(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let pair = file.metadata().and_then(|opened| Ok((opened, fs::metadata(path)?)));
    pair.is_ok_and(|(a, b)| (a.dev(), a.ino()) == (b.dev(), b.ino()))
}

/// Whether a file stands at `path`: whether it is this one the standard library cannot say here.
#[cfg(not(unix))]
pub(super) fn stands(_file: &File, path: &Path) -> bool {
    fs::metadata(path).is_ok()
}
