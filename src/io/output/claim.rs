//! Files that one run writes again and again.

use std::fs::File;
use std::io::Seek;
use std::path::Path;

use super::destination::{Destination, Replaces};
use super::held::{Attempt, Held};
use super::{Fill, Kind};
use crate::{Error, Result};

/// Keeps a file to this run, which may write it as often as it wants: no other process gets a claim
/// until this one is dropped or the run ends, however it ends. Until the first write what stood
/// there before stands there, or an empty file, which vanishes with the claim; a killed run leaves
/// it.
///
/// When the file cannot be written in its place, the claim moves to where the bytes could be kept,
/// and goes on there: what fails is told once, and one copy is kept.
#[derive(Debug)]
pub struct Claim {
    to: Destination,
    /// What stands there, and after it where the claim has moved.
    held: Vec<Held>,
}

impl Claim {
    /// Takes a file for this run alone: the extension fits, the folder takes files, and what stands
    /// there is nothing, empty, or of this kind and written by this program; `force` lets any
    /// regular file be replaced.
    ///
    /// # Errors
    /// [`Error::Parameter`] when another run has it, or with what to do instead; [`Error::Io`] when
    /// the system refuses to make or open it.
    pub fn open(path: &Path, kind: &Kind, force: bool) -> Result<Self> {
        let replaces = if force { Replaces::Anything } else { Replaces::Own };
        let to = Destination::new(path, kind, replaces)?;
        match Held::take(to.target.clone(), None).map_err(|e| to.refused(&e))? {
            Attempt::Held(held) => Ok(Self { to, held: vec![held] }),
            Attempt::Another | Attempt::Foreign => Err(to.taken()),
        }
    }

    /// Returns the path as it was given, or where the file is since it was moved.
    pub fn path(&self) -> &Path {
        &self.to.path
    }

    /// Returns what stands there, to read it from its beginning.
    ///
    /// # Errors
    /// [`Error::Io`] when the system refuses.
    pub fn file(&self) -> Result<File> {
        let file = self.held.last().map(|held| held.file.try_clone());
        let file = file.unwrap_or_else(|| File::open(&self.to.target));
        let begun = file.and_then(|mut file| file.rewind().map(|()| file));
        begun.map_err(|e| Error::io(self.path(), "read", e))
    }

    /// Writes the file whole or not at all, and keeps it.
    ///
    /// # Errors
    /// [`Error::Io`] when the system refuses, or when another file has come to stand there: the
    /// message says where the bytes were kept, and so does [`Claim::path`] from then on.
    pub fn write_with(&mut self, fill: Fill) -> Result<()> {
        let (kept, error) = match self.to.fill_surely(fill) {
            Err(e) => self.to.keep_elsewhere(fill, &e),
            Ok(written) => match self.put(written) {
                Ok(()) => return Ok(()),
                Err((written, e)) => self.to.keep(written, fill, &e),
            },
        };
        if let Some(kept) = kept {
            self.to.path.clone_from(&kept.path);
            self.to.target.clone_from(&kept.path);
            self.held.push(kept);
        }
        Err(error)
    }

    fn put(&mut self, written: Held) -> std::result::Result<(), (Held, std::io::Error)> {
        let Some(held) = self.held.last_mut() else { return written.put(&self.to.target) };
        held.replace(written)?;
        held.sync_name();
        Ok(())
    }

    /// Removes the file, if it still stands there, and all that was kept of it.
    ///
    /// # Errors
    /// [`Error::Io`] when the system refuses.
    pub fn remove(self) -> Result<()> {
        let mut done = Ok(());
        for held in &self.held {
            done = done.and(held.remove().map_err(|e| Error::io(&held.path, "remove", e)));
        }
        done
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use tempfile::{TempDir, tempdir};

    use super::*;

    const OURS: &[u8] = b"# harmolux 0 ";

    fn desk() -> (TempDir, PathBuf) {
        let folder = tempdir().expect("a folder");
        let path = folder.path().join("head.txt");
        (folder, path)
    }

    fn open(path: &Path) -> Result<Claim> {
        Claim::open(path, &Kind::COEFFICIENTS, false)
    }

    fn write(claim: &mut Claim) -> Result<()> {
        claim.write_with(&mut |file| file.write_all(OURS))
    }

    #[test]
    fn claimed_file_is_refused_before_and_after_it_is_written() {
        let (folder, path) = desk();
        let mut claim = open(&path).expect("free");
        for _ in 0..3 {
            let message = open(&path).expect_err("claimed").to_string();
            assert!(message.contains("another run is under way"), "{message}");
            write(&mut claim).expect("written");
        }
        drop(claim);
        assert_eq!(fs::read(&path).expect("stays"), OURS);
        open(&path).expect("free again").remove().expect("removed");
        assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 0);
    }

    #[test]
    fn nothing_is_left_of_a_claim_that_wrote_nothing() {
        let (folder, path) = desk();
        drop(open(&path).expect("free"));
        fs::write(&path, b"").expect("as a killed run leaves it");
        drop(open(&path).expect("free"));
        assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 0);
    }

    #[test]
    fn foreign_file_is_refused_and_one_that_comes_later_makes_one_copy() {
        let (folder, path) = desk();
        let mut claim = open(&path).expect("free");
        write(&mut claim).expect("written");
        fs::remove_file(&path).expect("removed");
        fs::write(&path, b"another's").expect("written");
        let message = write(&mut claim).expect_err("another's").to_string();
        let kept = folder.path().join("head.kept-1.txt");
        assert!(message.contains("kept as") && claim.path() == kept, "{message}");
        for _ in 0..3 {
            write(&mut claim).expect("the copy is its own");
        }
        assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 2);
        assert_eq!(fs::read(&kept).expect("kept"), OURS);
        claim.remove().expect("removed");
        assert!(!kept.exists());
        assert_eq!(fs::read(&path).expect("stays"), b"another's");
        assert!(open(&path).expect_err("another's").to_string().contains("not written by this"));
    }

    #[test]
    fn claim_of_a_folder_that_vanished_goes_on_above_it() {
        let folder = tempdir().expect("a folder");
        let inner = folder.path().join("inner");
        fs::create_dir(&inner).expect("made");
        let mut claim = open(&inner.join("head.txt")).expect("free");
        write(&mut claim).expect("written");
        fs::remove_dir_all(&inner).expect("removed");
        write(&mut claim).expect_err("told");
        write(&mut claim).expect("goes on");
        assert_eq!(claim.path(), folder.path().join("head.kept-1.txt"));
        assert_eq!(fs::read(claim.path()).expect("kept"), OURS);
    }
}
