//! Files that this process has locked; the lock ends with the process, however that ends.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::Kind;
use super::lock::{Lock, stands};

/// How often a file may be replaced in the moment between opening and locking it; once is rare.
const ATTEMPTS: usize = 8;

/// The names under which files were taken that are held.
static TAKEN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes the files that are held for outputs and empty: for a process that ends where it is, and
/// drops nothing.
pub fn remove_empty() {
    let taken = TAKEN.lock().unwrap_or_else(PoisonError::into_inner);
    for path in taken.iter() {
        if fs::metadata(path).is_ok_and(|data| data.is_file() && data.len() == 0) {
            // What stays does no harm.
            let _ = fs::remove_file(path);
        }
    }
}

/// A file that is locked until it is dropped, and that is removed then if it is empty or passing.
#[derive(Debug)]
pub(super) struct Held {
    pub(super) path: PathBuf,
    pub(super) file: File,
    /// The name it was taken by.
    taken: PathBuf,
    is_passing: bool,
}

/// Says what came of taking a file.
pub(super) enum Attempt {
    Held(Held),
    /// Another process has it, or another output of this one.
    Another,
    /// It is not ours.
    Foreign,
}

impl Held {
    /// Takes what stands at a path, or an empty file that is made: one of the given kind that this
    /// program wrote, or, without a kind, any regular file. Its content stays.
    pub(super) fn take(path: PathBuf, kind: Option<&Kind>) -> io::Result<Attempt> {
        for _ in 0..ATTEMPTS {
            let (file, is_new) = match opened(&path)? {
                Opened::File { file, is_new } => (file, is_new),
                // What is to be taken whatever it is: the caller says why that cannot be.
                Opened::Refused(e) if kind.is_none() => return Err(e),
                Opened::Foreign | Opened::Refused(_) => return Ok(Attempt::Foreign),
                Opened::Changing => continue,
            };
            match Lock::take(&file, &path) {
                Lock::Ours => {}
                // Where nothing can be locked, what is there may be another's.
                Lock::Unknown if is_new || kind.is_none() => {}
                Lock::Unknown => return Ok(Attempt::Foreign),
                Lock::Another => return Ok(Attempt::Another),
                Lock::Gone => continue,
            }
            let is_empty = file.metadata()?.len() == 0;
            if !is_empty && !kind.map_or(Ok(true), |kind| kind.wrote(&file))? {
                return Ok(Attempt::Foreign);
            }
            return Ok(Attempt::Held(Self::new(path, file)));
        }
        Ok(Attempt::Another)
    }

    /// Makes a new file.
    pub(super) fn create(path: PathBuf) -> io::Result<Self> {
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(&path)?;
        // Its name is new: nobody waits for it.
        let _ = file.try_lock();
        Ok(Self::new(path, file))
    }

    fn new(path: PathBuf, file: File) -> Self {
        TAKEN.lock().unwrap_or_else(PoisonError::into_inner).push(path.clone());
        Self { taken: path.clone(), path, file, is_passing: false }
    }

    /// Lets the file vanish with this value.
    pub(super) fn passing(mut self) -> Self {
        self.expire();
        self
    }

    /// As [`Held::passing`].
    pub(super) fn expire(&mut self) {
        self.is_passing = true;
    }

    /// Lets the file stay, unless it is empty.
    pub(super) fn lasting(mut self) -> Self {
        self.is_passing = false;
        self
    }

    pub(super) fn is_empty(&self) -> bool {
        self.file.metadata().is_ok_and(|data| data.len() == 0)
    }

    /// Puts `next` in the place of this file; gives it back when something else has come to stand
    /// there, or the system refuses.
    pub(super) fn replace(&mut self, mut next: Self) -> Result<(), (Self, io::Error)> {
        if fs::symlink_metadata(&self.path).is_ok() && !stands(&self.file, &self.path) {
            let error = io::Error::other("another file has come to stand there");
            return Err((next, error));
        }
        if let Err(error) = fs::rename(&next.path, &self.path) {
            return Err((next, error));
        }
        // What is dropped is the file that was replaced.
        std::mem::swap(&mut self.file, &mut next.file);
        Ok(())
    }

    /// Renames the file, in place of what stands there; gives it back when the system refuses.
    pub(super) fn put(mut self, target: &Path) -> Result<(), (Self, io::Error)> {
        match fs::rename(&self.path, target) {
            Ok(()) => {
                target.clone_into(&mut self.path);
                self.sync_name();
                drop(self.lasting());
                Ok(())
            }
            Err(error) => Err((self, error)),
        }
    }

    /// Renames the file to a name that is free.
    pub(super) fn put_new(&mut self, target: PathBuf) -> io::Result<()> {
        match fs::hard_link(&self.path, &target) {
            Ok(()) => fs::remove_file(&self.path)?,
            Err(e) if e.kind() == ErrorKind::AlreadyExists => return Err(e),
            // Not every file system has links.
            Err(_) => fs::rename(&self.path, &target)?,
        }
        self.path = target;
        self.sync_name();
        self.is_passing = false;
        Ok(())
    }

    /// Brings the name of the file to the disk: without that a crash of the machine may bring back
    /// the old one. Not every system can, and the file itself is there in any case.
    pub(super) fn sync_name(&self) {
        let folder = self.path.parent().filter(|folder| *folder != Path::new(""));
        let _ = File::open(folder.unwrap_or(Path::new("."))).and_then(|folder| folder.sync_all());
    }

    /// Removes the file, if it still stands there.
    pub(super) fn remove(&self) -> io::Result<()> {
        if stands(&self.file, &self.path) { fs::remove_file(&self.path) } else { Ok(()) }
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        if self.is_passing || self.is_empty() {
            // What stays does no harm.
            let _ = self.remove();
        }
        let mut taken = TAKEN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(place) = taken.iter().rposition(|path| *path == self.taken) {
            taken.swap_remove(place);
        }
    }
}

enum Opened {
    File {
        file: File,
        is_new: bool,
    },
    Foreign,
    /// The system does not let it be opened.
    Refused(io::Error),
    Changing,
}

/// Opens a regular file to read and write it, or makes one.
fn opened(path: &Path) -> io::Result<Opened> {
    let mut options = OpenOptions::new();
    options.read(true).write(true);
    match fs::symlink_metadata(path) {
        Ok(data) if !data.is_file() => Ok(Opened::Foreign),
        Ok(_) => Ok(match options.open(path) {
            Ok(file) => Opened::File { file, is_new: false },
            Err(e) if e.kind() == ErrorKind::NotFound => Opened::Changing,
            Err(e) => Opened::Refused(e),
        }),
        Err(e) if e.kind() == ErrorKind::NotFound => match options.create_new(true).open(path) {
            Ok(file) => Ok(Opened::File { file, is_new: true }),
            Err(e) if e.kind() == ErrorKind::AlreadyExists => Ok(Opened::Changing),
            Err(e) => Err(e),
        },
        Err(e) => Err(e),
    }
}
