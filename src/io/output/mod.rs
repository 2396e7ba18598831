//! Writing files safely: checked before the long run, written whole at its end, and nothing lost.
//!
//! The rules, for every verb and every kind of file:
//!
//! * **What is complete stays.** A file that is not empty is replaced only by force, whoever wrote
//!   it: a result may have cost a night, and a table may have got rows by hand. Only what a run
//!   goes on with is its own to replace: its checkpoint, the table that grows as its results come,
//!   with its figure, and the pictures that it wrote, which hold the text of their run.
//! * **What is under way lies beside.** `NAME.unfinished.EXT` is held from the beginning of a run
//!   to its end, locked; what an interrupted run has, and a look at one that goes on, are written
//!   there. The complete result takes the place of NAME.EXT at once, and that file goes.
//! * **Two runs never write one output.** The second is refused while the first holds the lock,
//!   which ends with its process, however that ends.
//! * **Ours is what says so inside.** A file `NAME.unfinished.EXT` that nobody has locked and that
//!   is empty or carries our mark ([`Kind`]) is what a run left: the next takes it over when it has
//!   something to write. Another program's is left, and the next name taken, `NAME.unfinished-2.EXT`.
//!   A run that is refused removes nothing.
//! * **A result is kept.** When it cannot take its place, it stays beside it as `NAME.kept-N.EXT`;
//!   when its folder takes no file, it is written to the one above, the current one, or that for
//!   temporary files, and the error says where.

mod claim;
mod destination;
mod held;
mod kept;
mod kind;
mod lock;

use std::io::{self, Read, Seek, Write};
use std::path::Path;

use crate::{Error, Result};

pub use claim::Claim;
use destination::{Destination, Replaces};
use held::Held;
pub use held::remove_empty;
pub use kind::Kind;

/// Names this program and its version, as written into files.
pub const SOFTWARE: &str = concat!("harmolux ", env!("CARGO_PKG_VERSION"));

/// A file that can be read and written anywhere.
pub trait ReadWriteSeek: Read + Write + Seek {}

impl<T: Read + Write + Seek> ReadWriteSeek for T {}

/// Writes the content of a file, again where the first place did not take it.
pub type Fill<'a> = &'a mut dyn FnMut(&mut dyn ReadWriteSeek) -> io::Result<()>;

/// Says how far a result is when it is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// A look at a run that goes on: it lies beside the output, and what fails is tried nowhere
    /// else.
    Preview,
    /// What an interrupted run has: it lies beside the output.
    Unfinished,
    /// The whole result: it takes the place of the output.
    Complete,
}

/// Promises that a file can be written, keeps it to this run, and writes it whole.
///
/// An output that is dropped unused leaves nothing behind and the old file as it was.
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
    to: Destination,
    /// `NAME.unfinished.EXT`.
    under_way: Held,
}

impl Output {
    /// Checks that `path` can be written as this kind of file, and takes it for this run: the
    /// extension fits, the folder exists and takes files, no other run writes it, and what stands
    /// there now is nothing or empty; `force` lets any regular file be replaced.
    ///
    /// # Errors
    /// [`Error::Parameter`] with what to do instead; [`Error::Io`] when the system refuses to write
    /// in the folder.
    pub fn open(path: &Path, kind: &Kind, force: bool) -> Result<Self> {
        Self::opened(path, kind, if force { Replaces::Anything } else { Replaces::Nothing })
    }

    /// As [`Output::open`], for a run that may go on: what this program wrote may stand there too,
    /// until [`Output::check_run`] tells what.
    ///
    /// # Errors
    /// As [`Output::open`].
    pub fn open_again(path: &Path, kind: &Kind, force: bool) -> Result<Self> {
        Self::opened(path, kind, if force { Replaces::Anything } else { Replaces::Own })
    }

    fn opened(path: &Path, kind: &Kind, replaces: Replaces) -> Result<Self> {
        let to = Destination::new(path, kind, replaces)?;
        let under_way = to.hold()?;
        Ok(Self { to, under_way })
    }

    /// Rejects a file that stands there and does not hold the text `run` within its first 64 KiB,
    /// unless the output was forced.
    ///
    /// # Errors
    /// [`Error::Parameter`] when it is of another run; [`Error::Io`] when it cannot be read.
    pub fn check_run(&mut self, run: &str) -> Result<()> {
        if self.to.replaces != Replaces::Anything {
            self.to.replaces = Replaces::Run(run.to_owned());
        }
        self.to.check_present()
    }

    /// Returns the path as it was given.
    pub fn path(&self) -> &Path {
        &self.to.path
    }

    /// Returns where a result goes.
    pub fn path_at(&self, stage: Stage) -> &Path {
        if stage == Stage::Complete { &self.to.path } else { &self.under_way.path }
    }

    /// Writes the whole result, through a temporary file beside it, so that no reader ever sees
    /// half of it.
    ///
    /// # Errors
    /// [`Error::Io`] when the system refuses, or when another file has come to stand there since
    /// [`Output::open`]; the bytes are then kept under the name that the message says, if they
    /// could be written at all. The old file is as it was.
    pub fn write(mut self, bytes: &[u8]) -> Result<()> {
        self.write_at(Stage::Complete, bytes)
    }

    /// Writes a result as far as it is.
    ///
    /// # Errors
    /// As [`Output::write`].
    pub fn write_at(&mut self, stage: Stage, bytes: &[u8]) -> Result<()> {
        self.write_with(stage, &mut |file| file.write_all(bytes))
    }

    /// Writes a result by parts; a look or what is unfinished as often as wanted.
    ///
    /// # Errors
    /// As [`Output::write`].
    pub fn write_with(&mut self, stage: Stage, fill: Fill) -> Result<()> {
        if stage == Stage::Preview {
            let written = self.to.fill(fill).map_err(|e| Error::io(self.path(), "write", e))?;
            self.put_beside(written);
            return Ok(());
        }
        let written = match self.to.fill_surely(fill) {
            Ok(written) => written,
            Err(e) => return Err(self.to.keep_elsewhere(fill, &e).1),
        };
        if stage == Stage::Unfinished {
            self.put_beside(written);
            self.under_way.sync_name();
            return Ok(());
        }
        if let Err(reason) = self.to.check_present() {
            return Err(self.to.keep(written, fill, &reason).1);
        }
        if let Err((written, e)) = written.put(&self.to.target) {
            return Err(self.to.keep(written, fill, &e).1);
        }
        self.under_way.expire();
        Ok(())
    }

    fn put_beside(&mut self, written: Held) {
        if let Err((written, _)) = self.under_way.replace(written) {
            // Another program's file stands there now: this one keeps the name it has.
            self.under_way = written.lasting();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

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
        let name = |e: io::Result<fs::DirEntry>| e.expect("entry").file_name();
        let mut names: Vec<_> =
            entries.map(name).map(|n| n.to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn new_file_is_written_and_nothing_else_is_left() {
        let (folder, path) = folder_with(None);
        let output = open(&path, false).expect("free");
        assert_eq!(names(&folder), ["head.unfinished.txt"]);
        assert_eq!(output.path(), path);
        output.write(OURS).expect("written");
        assert_eq!(fs::read(&path).expect("there"), OURS);
        assert_eq!(names(&folder), ["head.txt"]);
    }

    #[test]
    fn dropped_unused_leaves_the_old_file() {
        let (folder, path) = folder_with(Some(OURS));
        drop(open(&path, true).expect("forced"));
        assert_eq!(fs::read(&path).expect("there"), OURS);
        assert_eq!(names(&folder), ["head.txt"]);
    }

    #[test]
    fn what_is_complete_is_replaced_only_by_force() {
        for content in [OURS, FOREIGN] {
            let (folder, path) = folder_with(Some(content));
            let message = refusal(&path, &Kind::COEFFICIENTS, false);
            assert!(message.starts_with(&path.display().to_string()), "{message}");
            assert!(
                message.ends_with("is there already: choose another name, or have it replaced")
            );
            assert_eq!(fs::read(&path).expect("there"), content);
            open(&path, true).expect("forced").write(b"new").expect("written");
            assert_eq!(fs::read(&path).expect("there"), b"new");
            assert_eq!(names(&folder), ["head.txt"]);
        }
        let (_folder, path) = folder_with(Some(b""));
        open(&path, false).expect("empty").write(b"new").expect("written");
        assert_eq!(fs::read(&path).expect("there"), b"new");
    }

    #[test]
    fn run_that_goes_on_replaces_what_is_its_own() {
        let again = |path: &Path| Output::open_again(path, &Kind::COEFFICIENTS, false);
        let (_folder, path) = folder_with(Some(b"# harmolux 0.0.1 coefficients of run 17\n"));
        let mut output = again(&path).expect("ours");
        let message = output.check_run("run 18").expect_err("of run 17").to_string();
        assert!(message.contains("of another run"), "{message}");
        output.check_run("run 17").expect("the same");
        output.write(b"new").expect("written");
        assert_eq!(fs::read(&path).expect("there"), b"new");
        fs::write(&path, FOREIGN).expect("writable");
        assert!(again(&path).expect_err("foreign").to_string().contains("not written by this"));
        let mut forced = Output::open_again(&path, &Kind::COEFFICIENTS, true).expect("forced");
        forced.check_run("run 17").expect("forced");
    }

    #[test]
    fn what_is_unfinished_lies_beside_until_the_result_is_complete() {
        let (folder, path) = folder_with(Some(OURS));
        let unfinished = folder.path().join("head.unfinished.txt");
        for stage in [Stage::Preview, Stage::Unfinished] {
            let mut output = open(&path, true).expect("forced");
            output.write_at(stage, b"# harmolux 1 half").expect("written");
            assert_eq!(output.path_at(stage), unfinished);
            drop(output);
            assert_eq!(fs::read(&path).expect("there"), OURS);
            assert_eq!(fs::read(&unfinished).expect("there"), b"# harmolux 1 half");
        }
        let output = open(&path, true).expect("forced");
        assert!(unfinished.exists(), "opening removes what an interrupted run has");
        output.write(b"new").expect("written");
        assert_eq!(names(&folder), ["head.txt"]);
    }

    #[test]
    fn second_run_is_refused_until_the_first_ends() {
        let (folder, path) = folder_with(None);
        let mut first = open(&path, false).expect("free");
        let refused = || refusal(&path, &Kind::COEFFICIENTS, true);
        assert!(refused().contains("another run is under way"));
        first.write_at(Stage::Preview, OURS).expect("written");
        assert!(refused().contains("another run is under way"));
        drop(first);
        open(&path, false).expect("free").write(OURS).expect("written");
        assert_eq!(names(&folder), ["head.txt"]);
    }

    #[test]
    fn unfinished_files_of_others_stay_and_another_name_is_taken() {
        let (folder, path) = folder_with(Some(OURS));
        let notes = folder.path().join("head.unfinished.txt");
        fs::write(&notes, b"my notes").expect("writable");
        refusal(&path, &Kind::COEFFICIENTS, false);
        assert_eq!(names(&folder), ["head.txt", "head.unfinished.txt"]);
        let mut output = open(&path, true).expect("forced");
        assert!(refusal(&path, &Kind::COEFFICIENTS, true).contains("another run"));
        output.write_at(Stage::Preview, OURS).expect("written");
        assert!(output.path_at(Stage::Preview).ends_with("head.unfinished-2.txt"));
        output.write(b"new").expect("written");
        assert_eq!(fs::read(&notes).expect("there"), b"my notes");
        assert_eq!(names(&folder), ["head.txt", "head.unfinished.txt"]);
    }

    #[test]
    fn files_that_cannot_say_who_wrote_them_stay() {
        let (folder, path) = folder_with(None);
        let kind = Kind::unmarked("an array", &["txt"]);
        fs::write(folder.path().join("head.unfinished.txt"), b"1").expect("writable");
        Output::open(&path, &kind, false).expect("free").write(b"2").expect("written");
        assert_eq!(names(&folder), ["head.txt", "head.unfinished.txt"]);
    }

    #[test]
    fn csv_is_ours_when_its_header_row_is_the_one_to_be_written() {
        let (folder, _) = folder_with(None);
        let path = folder.path().join("a.csv");
        fs::write(&path, "degree,energy\n0,1\n").expect("writable");
        let claim = |header: &[u8]| Claim::open(&path, &Kind::csv(header.into()), false);
        claim(b"degree,energy\n").expect("ours");
        let message = claim(b"degree,energy,error\n").expect_err("another's").to_string();
        assert!(message.contains("not written by this program as a CSV table"), "{message}");
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
        assert!(message.contains("head.kept-1.txt"), "{message}");
        assert_eq!(names(&folder), ["head.kept-1.txt", "head.txt"]);
        assert_eq!(fs::read(folder.path().join("head.kept-1.txt")).expect("there"), OURS);
        fs::remove_file(&path).expect("removed");
        let output = open(&path, false).expect("free");
        fs::write(&path, FOREIGN).expect("writable");
        output.write(OURS).expect_err("refused");
        assert_eq!(names(&folder), ["head.kept-1.txt", "head.kept-2.txt", "head.txt"]);
    }

    #[test]
    fn result_whose_folder_vanished_is_kept_above_it() {
        let (folder, _) = folder_with(None);
        let inner = folder.path().join("inner");
        fs::create_dir(&inner).expect("made");
        let mut output = open(&inner.join("head.txt"), false).expect("free");
        fs::remove_dir_all(&inner).expect("removed");
        output.write_at(Stage::Preview, OURS).expect_err("nowhere to go");
        assert!(names(&folder).is_empty(), "a look is kept");
        let error = output.write(OURS).expect_err("refused");
        let kept = folder.path().join("head.kept-1.txt");
        assert!(matches!(error, Error::Io { .. }));
        assert!(error.to_string().contains(&format!("kept as {}", kept.display())), "{error}");
        assert_eq!(fs::read(&kept).expect("kept"), OURS);
        assert_eq!(names(&folder), ["head.kept-1.txt"]);
    }

    #[test]
    fn what_nothing_takes_leaves_nothing_behind() {
        let (folder, path) = folder_with(None);
        let mut output = open(&path, false).expect("free");
        let error = output.write_with(Stage::Complete, &mut |file| {
            file.write_all(OURS)?;
            Err(io::Error::from(io::ErrorKind::StorageFull))
        });
        assert!(error.expect_err("full").to_string().contains("could not be kept"));
        drop(output);
        assert!(names(&folder).is_empty());
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
            open(&link, true).expect("forced").write(b"new").expect("written");
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
            open(&path, true).expect("forced").write(OURS).expect("written");
            assert_eq!(mode(&path), 0o640);
            let (plain, ours) = (folder.path().join("plain"), folder.path().join("new.txt"));
            fs::write(&plain, b"").expect("written");
            open(&ours, false).expect("free").write(OURS).expect("written");
            assert_eq!(mode(&ours), mode(&plain));
        }

        #[test]
        fn links_and_devices_under_the_name_of_what_is_unfinished_stay() {
            let (folder, path) = folder_with(None);
            symlink("/dev/null", folder.path().join("head.unfinished.txt")).expect("linked");
            symlink("nothing", folder.path().join("head.unfinished-2.txt")).expect("linked");
            open(&path, false).expect("free").write(OURS).expect("written");
            let all = ["head.txt", "head.unfinished-2.txt", "head.unfinished.txt"];
            assert_eq!(names(&folder), all);
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
