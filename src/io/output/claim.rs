//! Files that belong to one run from its beginning on.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::Path;

use super::lock::{Lock, stands};
use super::{Output, ReadWriteSeek};
use crate::{Error, Result};

/// How often a file may be replaced in the moment between opening and locking it; once is rare.
const ATTEMPTS: usize = 8;

/// Keeps an output to this run, which may write it as often as it wants: no other process gets a
/// claim until this one is dropped or the run ends, however it ends. Until the first write what
/// stood there before stands there, or an empty file, which vanishes with the claim; a killed run
/// leaves it.
///
/// Where a file system knows no locks, nothing is kept from anybody.
#[derive(Debug)]
pub struct Claim {
    output: Output,
    /// What stands there now, locked.
    file: File,
}

impl Output {
    /// Takes the file for this run alone.
    ///
    /// # Errors
    /// [`Error::Parameter`] when another run has it; [`Error::Io`] when the system refuses to make
    /// or open it.
    pub fn claim(self) -> Result<Claim> {
        match self.locked(true)? {
            Some(file) => Ok(Claim { output: self, file }),
            None => Err(self.taken()),
        }
    }

    /// Rejects a file that another run has claimed.
    ///
    /// # Errors
    /// As [`Output::claim`].
    pub fn check_unclaimed(&self) -> Result<()> {
        self.locked(false).map(drop)
    }

    /// Locks what stands there, or an empty file if one is to be made.
    fn locked(&self, make: bool) -> Result<Option<File>> {
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(make).truncate(false);
        for _ in 0..ATTEMPTS {
            let file = match options.open(&self.target) {
                Err(e) if e.kind() == ErrorKind::NotFound && !make => return Ok(None),
                opened => opened.map_err(|e| Error::io(&self.path, "write", e))?,
            };
            match Lock::take(&file, &self.target) {
                Lock::Ours | Lock::Unknown => return Ok(Some(file)),
                Lock::Another => break,
                Lock::Gone => {}
            }
        }
        Err(self.taken())
    }

    fn taken(&self) -> Error {
        Error::Parameter(format!(
            "{}: another run is under way that writes this file: wait until it ends, or choose \
             another name",
            self.path.display()
        ))
    }
}

impl Claim {
    /// Returns the path as it was given.
    pub fn path(&self) -> &Path {
        self.output.path()
    }

    /// Writes the file as [`Output::write_with`] does, and keeps it.
    ///
    /// # Errors
    /// As [`Output::write`].
    pub fn write_with(
        &mut self,
        fill: &mut dyn FnMut(&mut dyn ReadWriteSeek) -> io::Result<()>,
    ) -> Result<()> {
        self.file = self.output.put(fill)?;
        Ok(())
    }

    /// Removes the file, if it still stands there.
    ///
    /// # Errors
    /// [`Error::Io`] when the system refuses.
    pub fn remove(self) -> Result<()> {
        match fs::remove_file(&self.output.target) {
            Err(e) if e.kind() != ErrorKind::NotFound => Err(Error::io(self.path(), "remove", e)),
            _ => Ok(()),
        }
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        let empty = self.file.metadata().is_ok_and(|data| data.len() == 0);
        if empty && stands(&self.file, &self.output.target) {
            // What stays is empty and does no harm.
            let _ = fs::remove_file(&self.output.target);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use tempfile::{TempDir, tempdir};

    use super::*;
    use crate::io::output::Kind;

    fn desk() -> (TempDir, PathBuf) {
        let folder = tempdir().expect("a folder");
        let path = folder.path().join("head.txt");
        (folder, path)
    }

    fn open(path: &Path) -> Output {
        Output::open(path, &Kind::COEFFICIENTS, false).expect("free or ours")
    }

    #[test]
    fn claimed_file_is_refused_before_and_after_it_is_written() {
        let (_folder, path) = desk();
        open(&path).check_unclaimed().expect("nothing there");
        assert!(!path.exists(), "checking made a file");
        let mut claim = open(&path).claim().expect("free");
        for _ in 0..3 {
            for refusal in [open(&path).claim().map(drop), open(&path).check_unclaimed()] {
                let message = refusal.expect_err("claimed").to_string();
                assert!(message.contains("another run is under way"), "{message}");
            }
            claim.write_with(&mut |file| file.write_all(b"# harmolux 0 ")).expect("written");
        }
        drop(claim);
        assert_eq!(fs::read(&path).expect("stays"), b"# harmolux 0 ");
        open(&path).claim().expect("free again").remove().expect("removed");
        assert!(!path.exists());
    }

    #[test]
    fn nothing_is_left_of_a_claim_that_wrote_nothing() {
        let (folder, path) = desk();
        drop(open(&path).claim().expect("free"));
        fs::write(&path, b"").expect("as a killed run leaves it");
        drop(open(&path).claim().expect("free"));
        assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 0);
    }
}
