//! Writing files safely: checked before the long run, written whole at its end, replacing only what
//! is ours.
//!
//! What is being written is locked by its process, as is what a run has claimed; the lock ends with
//! the process, however that ends.

mod claim;
mod kind;
mod lock;
mod unfinished;

use std::fs::{self, File};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::Advice;
use crate::{Error, Result};

pub use claim::Claim;
pub use kind::Kind;
use kind::{MARKED_WITHIN, Mark};

/// Names this program and its version, as written into files.
pub const SOFTWARE: &str = concat!("harmolux ", env!("CARGO_PKG_VERSION"));

/// A file that can be read and written anywhere.
pub trait ReadWriteSeek: Read + Write + Seek {}

impl<T: Read + Write + Seek> ReadWriteSeek for T {}

/// Promises that a file can be written, and writes it whole.
///
/// Opening leaves nothing behind and changes nothing: an output that is dropped unused, or a run
/// that ends early, leaves the old file as it was. Only what a killed run left of this very output,
/// `NAME.unfinished.EXT`, is removed.
///
/// ```
/// use harmolux::io::output::{Kind, Output};
///
/// let folder = tempfile::tempdir().expect("a folder");
/// let output = Output::open(&folder.path().join("report.json"), &Kind::JSON, false)?;
/// // ... the long run ...
/// output.write(b"{}")?;
/// # Ok::<(), harmolux::Error>(())
/// ```
#[derive(Debug)]
pub struct Output {
    /// The path as given, for messages.
    path: PathBuf,
    /// The path behind links, so that a link stays one.
    target: PathBuf,
    kind: Kind,
    force: bool,
}

impl Output {
    /// Checks that `path` can be written as this kind of file: the extension fits, the folder
    /// exists and takes files, and what stands there now is nothing, empty, or written by this
    /// program; `force` lets a foreign file be replaced.
    ///
    /// # Errors
    /// [`Error::Parameter`] with what to do instead; [`Error::Io`] when the system refuses to write
    /// in the folder.
    pub fn open(path: &Path, kind: &Kind, force: bool) -> Result<Self> {
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
        let output = Self { path: path.to_owned(), target, kind: kind.clone(), force };
        output.check_folder()?;
        output.check_present()?;
        Ok(output)
    }

    /// Returns the path as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the file whole, through a temporary one beside it, so that no reader ever sees half
    /// of it.
    ///
    /// # Errors
    /// [`Error::Io`] when the system refuses, or when a foreign file has come to stand there since
    /// [`Output::open`]; the bytes are then kept under the name that the message says, if they
    /// could be written at all. The old file is as it was.
    pub fn write(self, bytes: &[u8]) -> Result<()> {
        self.write_with(&mut |file| file.write_all(bytes))
    }

    /// Writes the file as [`Output::write`] does, by parts and as often as wanted.
    ///
    /// # Errors
    /// As [`Output::write`].
    pub fn write_with(
        &self,
        fill: &mut dyn FnMut(&mut dyn ReadWriteSeek) -> io::Result<()>,
    ) -> Result<()> {
        self.put(fill).map(drop)
    }

    /// Writes the file and gives it, locked.
    fn put(&self, fill: &mut dyn FnMut(&mut dyn ReadWriteSeek) -> io::Result<()>) -> Result<File> {
        let temporary = self.fill(fill).map_err(|e| Error::io(&self.path, "write", e))?;
        if let Err(reason) = self.check_present() {
            return Err(self.keep(temporary, &reason));
        }
        match temporary.persist(&self.target) {
            Ok(file) => Ok(file),
            Err(refused) => Err(self.keep(refused.file, &refused.error)),
        }
    }

    fn folder(&self) -> &Path {
        match self.target.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        }
    }

    fn check_folder(&self) -> Result<()> {
        let folder = self.folder();
        if !folder.is_dir() {
            return Err(Error::Parameter(format!(
                "{}: there is no folder {}: create it, or name a file elsewhere",
                self.path.display(),
                folder.display()
            )));
        }
        // Only trying tells: permission bits know nothing of full disks, read-only mounts and
        // access lists.
        self.temporary().map(drop).map_err(|e| {
            let advice = format!("{e}; name a file in a folder that takes files");
            Error::io(&self.path, "write", io::Error::new(e.kind(), advice))
        })
    }

    fn check_present(&self) -> Result<()> {
        let refuse = |why: &str| Err(Error::Parameter(format!("{}: {why}", self.path.display())));
        let present = match fs::metadata(&self.target) {
            Ok(present) => present,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
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
        if self.force || self.kind.owns(&self.head()?) || present.len() == 0 {
            return Ok(());
        }
        let name = self.kind.name;
        let why = match self.kind.mark {
            Mark::Nothing => format!("{name} cannot say whether this program wrote it"),
            _ => format!("the file that stands there was not written by this program as {name}"),
        };
        refuse(&why).map_err(|e| e.advise(Advice::Overwrite))
    }

    fn head(&self) -> Result<Vec<u8>> {
        let mut head = Vec::new();
        let read = |head: &mut Vec<u8>| {
            let within = MARKED_WITHIN.max(self.kind.start.len() as u64);
            fs::File::open(&self.target)?.take(within).read_to_end(head)
        };
        read(&mut head).map_err(|e| Error::io(&self.path, "read", e))?;
        Ok(head)
    }

    fn fill(
        &self,
        fill: &mut dyn FnMut(&mut dyn ReadWriteSeek) -> io::Result<()>,
    ) -> io::Result<NamedTempFile> {
        let mut temporary = self.temporary()?;
        fill(&mut temporary)?;
        if let Ok(present) = fs::metadata(&self.target) {
            temporary.as_file().set_permissions(present.permissions())?;
        }
        temporary.as_file().sync_all()?;
        Ok(temporary)
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::{TempDir, tempdir};

    const OURS: &[u8] = b"# harmolux 0.0.1 coefficients\n0, 0, 1, 0\n";
    const FOREIGN: &[u8] = b"# my notes about harmolux 0.0.1\n";

    fn folder_with(content: Option<&[u8]>) -> (TempDir, PathBuf) {
        let folder = tempdir().expect("a folder");
        let path = folder.path().join("head.txt");
        if let Some(content) = content {
            fs::write(&path, content).expect("writable");
        }
        (folder, path)
    }

    fn open(path: &Path, force: bool) -> Result<Output> {
        Output::open(path, &Kind::COEFFICIENTS, force)
    }

    fn refusal(path: &Path, kind: &Kind, force: bool) -> String {
        Output::open(path, kind, force).expect_err("refused").to_string()
    }

    fn names(folder: &TempDir) -> Vec<String> {
        let entries = fs::read_dir(folder.path()).expect("readable");
        entries.map(|e| e.expect("entry").file_name().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn file_without_room_for_a_name_is_never_ours() {
        let (folder, path) = folder_with(Some(OURS));
        let kind = Kind::unmarked("an array", &["txt"]);
        assert!(refusal(&path, &kind, false).contains("an array cannot say whether this program"));
        Output::open(&path, &kind, true).expect("forced").write(b"1").expect("written");
        assert_eq!(fs::read(folder.path().join("head.txt")).expect("readable"), b"1");
    }

    #[test]
    fn new_file_is_written_and_nothing_else_is_left() {
        let (folder, path) = folder_with(None);
        let output = open(&path, false).expect("free");
        assert!(names(&folder).is_empty() && output.path() == path);
        output.write(OURS).expect("written");
        assert_eq!(fs::read(&path).expect("there"), OURS);
        assert_eq!(names(&folder), ["head.txt"]);
    }

    #[test]
    fn dropped_unused_leaves_the_old_file() {
        let (folder, path) = folder_with(Some(OURS));
        drop(open(&path, true).expect("ours"));
        assert_eq!(fs::read(&path).expect("there"), OURS);
        assert_eq!(names(&folder), ["head.txt"]);
    }

    #[test]
    fn own_and_empty_files_are_replaced() {
        for content in [OURS, b""] {
            let (_folder, path) = folder_with(Some(content));
            open(&path, false).expect("ours").write(b"new").expect("written");
            assert_eq!(fs::read(&path).expect("there"), b"new");
        }
    }

    #[test]
    fn foreign_file_needs_force() {
        let (_folder, path) = folder_with(Some(FOREIGN));
        let message = refusal(&path, &Kind::COEFFICIENTS, false);
        assert!(message.starts_with(&path.display().to_string()), "{message}");
        assert!(message.ends_with("choose another name, or have it replaced"));
        assert_eq!(fs::read(&path).expect("there"), FOREIGN);
        open(&path, true).expect("forced").write(b"new").expect("written");
        assert_eq!(fs::read(&path).expect("there"), b"new");
    }

    #[test]
    fn csv_is_ours_when_its_header_row_is_the_one_to_be_written() {
        let folder = tempdir().expect("a folder");
        let path = folder.path().join("spectrum.csv");
        fs::write(&path, "degree,energy\n0,1\n").expect("writable");
        assert!(Output::open(&path, &Kind::csv(b"degree,energy\n".into()), false).is_ok());
        let message = refusal(&path, &Kind::csv(b"degree,energy,error\n".into()), false);
        assert!(message.contains("have it replaced"), "{message}");
    }

    #[test]
    fn wrong_or_missing_extension_is_refused_with_a_name() {
        let (folder, _) = folder_with(None);
        let message = refusal(&folder.path().join("view.jpg"), &Kind::PNG, false);
        assert!(message.contains("a PNG image needs the extension .png: name it"), "{message}");
        assert!(message.ends_with("view.png"), "{message}");
        assert!(
            refusal(&folder.path().join("head"), &Kind::COEFFICIENTS, true).contains(".txt or .sh")
        );
        assert!(Output::open(&folder.path().join("VIEW.PNG"), &Kind::PNG, false).is_ok());
    }

    #[test]
    fn missing_folder_is_refused() {
        let (folder, _) = folder_with(None);
        let message = refusal(&folder.path().join("no/such/view.png"), &Kind::PNG, true);
        assert!(
            message.contains("there is no folder") && message.contains("create it"),
            "{message}"
        );
    }

    #[test]
    fn folder_in_the_place_of_the_file_is_refused() {
        let (_folder, path) = folder_with(None);
        fs::create_dir(&path).expect("made");
        assert!(refusal(&path, &Kind::COEFFICIENTS, true).contains("not a regular file"));
    }

    #[test]
    fn read_only_file_is_refused_even_with_force() {
        let (_folder, path) = folder_with(Some(OURS));
        let mut permissions = fs::metadata(&path).expect("there").permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).expect("set");
        assert!(refusal(&path, &Kind::COEFFICIENTS, true).contains("read-only"));
    }

    #[test]
    fn foreign_file_that_appears_during_the_run_stays_and_so_does_the_result() {
        let (folder, path) = folder_with(None);
        let output = open(&path, false).expect("free");
        fs::write(&path, FOREIGN).expect("writable");
        let message = output.write(OURS).expect_err("refused").to_string();
        assert!(message.contains("the result is kept as"), "{message}");
        assert_eq!(fs::read(&path).expect("there"), FOREIGN);
        let kept = names(&folder).into_iter().find(|n| n != "head.txt").expect("kept");
        assert!(message.contains(&kept) && kept.starts_with("head.kept-"));
        assert_eq!(fs::read(folder.path().join(kept)).expect("there"), OURS);
    }

    #[test]
    fn folder_that_vanishes_during_the_run_is_reported() {
        let (folder, path) = folder_with(None);
        let output = open(&path, false).expect("free");
        folder.close().expect("removed");
        assert!(matches!(output.write(OURS), Err(Error::Io { .. })));
    }

    #[cfg(unix)]
    mod unix {
        use super::*;
        use std::os::unix::fs::{PermissionsExt, symlink};

        #[test]
        fn read_only_folder_is_refused_before_the_run() {
            let (folder, path) = folder_with(None);
            fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).expect("set");
            // The superuser may write anywhere: then there is nothing to test.
            if fs::write(folder.path().join("probe"), b"").is_err() {
                let message = refusal(&path, &Kind::COEFFICIENTS, true);
                assert!(message.contains("cannot write") && message.contains("name a file in"));
            }
            fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).expect("set");
        }

        #[test]
        fn link_stays_a_link_and_its_file_is_checked() {
            let (folder, path) = folder_with(Some(OURS));
            let link = folder.path().join("link.txt");
            symlink(&path, &link).expect("linked");
            open(&link, false).expect("ours").write(b"new").expect("written");
            assert!(link.is_symlink() && fs::read(&path).expect("there") == b"new");
            assert!(open(&link, false).is_err());
            fs::remove_file(&path).expect("removed");
            assert!(refusal(&link, &Kind::COEFFICIENTS, false).contains("a link to nothing"));
        }

        #[test]
        fn permissions_are_those_of_the_old_file_or_of_any_new_one() {
            let (folder, path) = folder_with(Some(OURS));
            let mode = |p: &Path| fs::metadata(p).expect("there").permissions().mode() & 0o777;
            fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).expect("set");
            open(&path, false).expect("ours").write(OURS).expect("written");
            assert_eq!(mode(&path), 0o640);
            let (plain, ours) = (folder.path().join("plain"), folder.path().join("new.txt"));
            fs::write(&plain, b"").expect("written");
            open(&ours, false).expect("free").write(OURS).expect("written");
            assert_eq!(mode(&ours), mode(&plain));
        }

        #[test]
        fn device_is_never_replaced() {
            let folder = tempdir().expect("a folder");
            let link = folder.path().join("null.txt");
            symlink("/dev/null", &link).expect("linked");
            assert!(refusal(&link, &Kind::COEFFICIENTS, true).contains("not a regular file"));
        }
    }
}
