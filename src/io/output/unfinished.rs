//! Files under way: `NAME.unfinished.EXT` beside `NAME.EXT`, locked by the process that writes it.
//! One that nobody has locked is what a killed run left: the next that writes NAME takes its place.

use std::fmt::Display;
use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use super::Output;
use super::lock::Lock;
use crate::Error;

/// How often a new file may be taken for a leftover in the moment before it is locked; once is
/// rare.
const ATTEMPTS: usize = 8;

/// The most results that are kept of one output.
const MOST_KEPT: usize = 1000;

impl Output {
    /// Makes an empty file beside the target, locked, that vanishes when dropped.
    pub(super) fn temporary(&self) -> io::Result<NamedTempFile> {
        for _ in 0..ATTEMPTS {
            match self.create("unfinished", 0) {
                Ok(file) => match Lock::take(file.as_file(), file.path()) {
                    Lock::Ours | Lock::Unknown => return Ok(file),
                    // It belongs to whoever took it for a leftover, and so does its name.
                    Lock::Another | Lock::Gone => drop(file.keep()),
                },
                Err(e) if e.kind() == ErrorKind::AlreadyExists => {
                    if !remove_leftover(&self.beside("unfinished")) {
                        break;
                    }
                }
                Err(e) => return Err(e),
            }
        }
        // Another process writes the same output just now.
        self.create("unfinished-", 6)
    }

    /// Saves a finished temporary file that cannot take its place, and says where it is.
    pub(super) fn keep(&self, temporary: NamedTempFile, reason: &dyn Display) -> Error {
        let outcome = match self.kept(temporary) {
            Ok(kept) => format!("{reason}; the result is kept as {}", kept.display()),
            Err(e) => format!("{reason}; the result could not be kept either: {e}"),
        };
        Error::io(&self.path, "write", io::Error::other(outcome))
    }

    /// Returns a temporary file the first free name of those for results that are kept.
    fn kept(&self, mut temporary: NamedTempFile) -> io::Result<PathBuf> {
        for number in 1..MOST_KEPT {
            let path = self.beside(&format!("kept-{number}"));
            match temporary.persist_noclobber(&path) {
                Ok(_) => return Ok(path),
                Err(e) if e.error.kind() == ErrorKind::AlreadyExists => temporary = e.file,
                Err(e) => return Err(e.error),
            }
        }
        Err(io::Error::other("too many results are kept already"))
    }

    fn create(&self, word: &str, random: usize) -> io::Result<NamedTempFile> {
        let [prefix, suffix] = self.around(word);
        let mut builder = Builder::new();
        builder.prefix(&prefix).suffix(&suffix).rand_bytes(random);
        // Temporary files are private by default; results are as public as the user's mask lets any
        // new file be.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        builder.tempfile_in(self.folder())
    }

    fn beside(&self, word: &str) -> PathBuf {
        self.folder().join(self.around(word).concat())
    }

    /// Returns what comes before and after the random part of a name beside the target's.
    fn around(&self, word: &str) -> [String; 2] {
        let name = self.target.file_stem().unwrap_or_default().to_string_lossy();
        let extension = self.kind.extensions.first().unwrap_or(&"");
        [format!("{name}.{word}"), format!(".{extension}")]
    }
}

/// Removes a file that no process has locked; tells whether it is gone.
fn remove_leftover(path: &Path) -> bool {
    match OpenOptions::new().read(true).write(true).open(path) {
        Ok(file) => match Lock::take(&file, path) {
            Lock::Ours => fs::remove_file(path).is_ok(),
            Lock::Gone => true,
            Lock::Another | Lock::Unknown => false,
        },
        Err(e) => e.kind() == ErrorKind::NotFound,
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use super::*;
    use crate::io::output::Kind;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("readable");
        let name = |e: io::Result<fs::DirEntry>| e.expect("an entry").file_name();
        let mut names: Vec<String> =
            entries.map(name).map(|n| n.to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn what_a_killed_run_left_is_removed_and_what_a_living_one_writes_is_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("head.txt");
        let open = || Output::open(&path, &Kind::COEFFICIENTS, false).expect("free");
        let left = || File::create(folder.path().join("head.unfinished.txt")).expect("writable");
        drop(left());
        open();
        assert!(names(folder.path()).is_empty());
        let living = left();
        living.lock().expect("free");
        open().write(b"# harmolux 0 ").expect("written under another name");
        assert_eq!(names(folder.path()), ["head.txt", "head.unfinished.txt"]);
        drop(living);
        open();
        assert_eq!(names(folder.path()), ["head.txt"]);
    }

    #[test]
    fn each_result_that_cannot_take_its_place_is_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("head.txt");
        for _ in 0..2 {
            let output = Output::open(&path, &Kind::COEFFICIENTS, false).expect("free");
            fs::write(&path, b"another's").expect("writable");
            output.write(b"# harmolux 0 ").expect_err("another's");
            fs::remove_file(&path).expect("removable");
        }
        assert_eq!(names(folder.path()), ["head.kept-1.txt", "head.kept-2.txt"]);
    }
}
