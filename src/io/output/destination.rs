//! Where an output goes: its name, what may be replaced there, and the names beside it.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

use super::held::{Attempt, Held};
use super::{Fill, Kind};
use crate::error::Advice;
use crate::{Error, Result};

/// The most files that may lie beside an output under names of one kind.
pub(super) const MOST_BESIDE: usize = 1000;

/// How far into a file the text of its run is looked for, bytes.
const RUN_WITHIN: u64 = 1 << 16;

/// Says what an output may replace, besides an empty file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Replaces {
    Nothing,
    /// What this program wrote.
    Own,
    /// What this program wrote and what holds this text.
    Run(String),
    Anything,
}

/// The place of an output.
#[derive(Debug)]
pub(super) struct Destination {
    /// The path as given, for messages.
    pub(super) path: PathBuf,
    /// The path behind links, so that a link stays one.
    pub(super) target: PathBuf,
    pub(super) kind: Kind,
    pub(super) replaces: Replaces,
}

impl Destination {
    /// Checks name, folder, and what stands there.
    pub(super) fn new(path: &Path, kind: &Kind, replaces: Replaces) -> Result<Self> {
        if !kind.fits(path) {
            return Err(Error::Parameter(format!(
                "{}: {} needs the extension .{}: name it {}",
                path.display(),
                kind.name,
                kind.extensions.join(" or ."),
                path.with_extension(kind.extensions.first().unwrap_or(&"")).display()
            )));
        }
        let target = behind_links(path)?;
        let to = Self { path: path.to_owned(), target, kind: kind.clone(), replaces };
        let folder = to.folder();
        if !folder.is_dir() {
            return Err(Error::Parameter(format!(
                "{}: there is no folder {}: create it, or name a file elsewhere",
                path.display(),
                folder.display()
            )));
        }
        to.check_present()?;
        Ok(to)
    }

    pub(super) fn folder(&self) -> &Path {
        match self.target.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        }
    }

    /// Returns `NAME.WORD.EXT` in the folder of `NAME.EXT`; the number is part of the word from the
    /// second on.
    pub(super) fn beside(&self, word: &str, number: usize) -> PathBuf {
        let number = if number > 1 { format!("-{number}") } else { String::new() };
        self.target.with_file_name(self.name(&format!("{word}{number}")))
    }

    /// Returns the name of the output with a word before its extension.
    pub(super) fn name(&self, word: &str) -> OsString {
        let mut name = self.target.file_stem().unwrap_or_default().to_owned();
        name.push(format!(".{word}."));
        name.push(self.target.extension().unwrap_or_default());
        name
    }

    /// Rejects what may not be replaced.
    pub(super) fn check_present(&self) -> Result<()> {
        let refuse = |why: &str| Err(Error::Parameter(format!("{}: {why}", self.path.display())));
        let present = match fs::metadata(&self.target) {
            Ok(present) => present,
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(()),
            Err(e) => return Err(Error::io(&self.path, "read", e)),
        };
        if !present.is_file() {
            return refuse("this is not a regular file: choose another name");
        }
        if present.permissions().readonly() {
            return refuse(
                "the file that stands there is read-only: allow writing, or choose another name",
            );
        }
        if present.len() == 0 {
            return Ok(());
        }
        let found = self.objection().map_err(|e| Error::io(&self.path, "read", e))?;
        found.map_or(Ok(()), |why| refuse(&why).map_err(|e| e.advise(Advice::Overwrite)))
    }

    /// Says why the file that stands there may not be replaced.
    fn objection(&self) -> io::Result<Option<String>> {
        let foreign = || Some(format!("it was not written by this program as {}", self.kind.name));
        Ok(match &self.replaces {
            Replaces::Nothing => Some("this file is there already".to_owned()),
            Replaces::Own | Replaces::Run(_) if !self.kind.wrote(File::open(&self.target)?)? => {
                foreign()
            }
            Replaces::Anything | Replaces::Own => None,
            Replaces::Run(run) => {
                let mut head = Vec::new();
                File::open(&self.target)?.take(RUN_WITHIN).read_to_end(&mut head)?;
                let is_same = head.windows(run.len()).any(|part| part == run.as_bytes());
                (!is_same).then(|| "it is of another run".to_owned())
            }
        })
    }

    /// Takes `NAME.unfinished.EXT` for this run alone, as its mark and as the place of what is
    /// unfinished.
    pub(super) fn hold(&self) -> Result<Held> {
        for number in 1..MOST_BESIDE {
            let attempt = Held::take(self.beside("unfinished", number), Some(&self.kind));
            match attempt.map_err(|e| self.refused(&e))? {
                Attempt::Held(held) => return Ok(held),
                Attempt::Another => return Err(self.taken()),
                Attempt::Foreign => {}
            }
        }
        Err(self.refused(&crowded()))
    }

    /// Says that another run writes this output.
    pub(super) fn taken(&self) -> Error {
        Error::Parameter(format!(
            "{}: another run is under way that writes this file, or it is named twice: wait until \
             that run ends, or choose another name",
            self.path.display()
        ))
    }

    /// Says that the folder takes no file.
    pub(super) fn refused(&self, e: &io::Error) -> Error {
        let advice = format!("{e}; name a file in a folder that takes files");
        Error::io(&self.path, "write", io::Error::new(e.kind(), advice))
    }

    /// Writes a file of its own beside the output, whole; it vanishes when dropped.
    pub(super) fn fill(&self, fill: Fill) -> io::Result<Held> {
        let mut temporary = self.temporary()?;
        fill(&mut temporary.file)?;
        if let Ok(present) = fs::metadata(&self.target) {
            temporary.file.set_permissions(present.permissions())?;
        }
        Ok(temporary)
    }

    /// As [`Destination::fill`], and brings the file to the disk.
    pub(super) fn fill_surely(&self, fill: Fill) -> io::Result<Held> {
        let written = self.fill(fill)?;
        written.file.sync_all()?;
        Ok(written)
    }

    /// Makes an empty file under the first name that is free.
    fn temporary(&self) -> io::Result<Held> {
        for number in 1..MOST_BESIDE {
            let path = self.beside("unfinished", number);
            let mut attempt = Held::take(path.clone(), Some(&self.kind))?;
            if let Attempt::Held(left) = attempt {
                if left.is_empty() {
                    return Ok(left.passing());
                }
                // What a killed run left makes room; its content may have other names.
                drop(left.passing());
                attempt = Held::take(path, Some(&self.kind))?;
                if let Attempt::Held(made) = attempt {
                    return Ok(made.passing());
                }
            }
        }
        Err(crowded())
    }
}

pub(super) fn crowded() -> io::Error {
    io::Error::other("too many files of this name are there already")
}

/// Follows links, so that what they point to is checked and replaced, not the link.
fn behind_links(path: &Path) -> Result<PathBuf> {
    if !path.is_symlink() {
        return Ok(path.to_owned());
    }
    fs::canonicalize(path).map_err(|_| {
        Error::Parameter(format!(
            "{}: this is a link to nothing: remove it, or choose another name",
            path.display()
        ))
    })
}
