//! Results that cannot take their place: kept under `NAME.kept-N.EXT` beside it, else in another
//! folder.

use std::fmt::Display;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use super::Fill;
use super::destination::{Destination, MOST_BESIDE, crowded};
use super::held::Held;
use crate::Error;

/// A result under another name, or none where nothing took it, and what to say of it.
pub(super) type Kept = (Option<Held>, Error);

impl Destination {
    /// Keeps a written file that cannot take its place.
    pub(super) fn keep(&self, mut written: Held, fill: Fill, reason: &dyn Display) -> Kept {
        for number in 1..MOST_BESIDE {
            let path = self.target.with_file_name(self.kept_name(number));
            match written.put_new(path) {
                Ok(()) => return self.kept(Some(written), reason),
                Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
                Err(_) => break,
            }
        }
        self.keep_elsewhere(fill, reason)
    }

    /// Writes a result that the folder does not take to the first that does: the one above, the
    /// current one, that for temporary files.
    pub(super) fn keep_elsewhere(&self, fill: Fill, reason: &dyn Display) -> Kept {
        let above = std::path::absolute(self.folder()).ok();
        let above = above.and_then(|folder| folder.parent().map(Path::to_owned));
        let folders = [above, std::env::current_dir().ok(), Some(std::env::temp_dir())];
        let mut folders = folders.into_iter().flatten();
        let kept = folders.find_map(|folder| self.write_in(&folder, fill).ok());
        self.kept(kept, reason)
    }

    fn write_in(&self, folder: &Path, fill: Fill) -> io::Result<Held> {
        for number in 1..MOST_BESIDE {
            match Held::create(folder.join(self.kept_name(number))) {
                Ok(made) => {
                    let mut made = made.passing();
                    fill(&mut made.file)?;
                    made.file.sync_all()?;
                    return Ok(made.lasting());
                }
                Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
                Err(e) => return Err(e),
            }
        }
        Err(crowded())
    }

    fn kept_name(&self, number: usize) -> PathBuf {
        self.name(&format!("kept-{number}")).into()
    }

    fn kept(&self, kept: Option<Held>, reason: &dyn Display) -> Kept {
        let outcome = match &kept {
            Some(kept) => format!("{reason}; the result is kept as {}", kept.path.display()),
            None => format!("{reason}; the result could not be kept in any other folder either"),
        };
        (kept, Error::io(&self.path, "write", io::Error::other(outcome)))
    }
}
