//! A table that grows on disk row by row as results come, so that a run that was ended, in whatever
//! way, goes on where it was when it is started again.

use std::collections::HashSet;
use std::fmt::{Debug, Write as _};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use harmolux::error::Advice;
use harmolux::fit::SourceHash;
use harmolux::io::input::FilesRead;
use harmolux::io::output::{Claim, SOFTWARE};
use harmolux::io::tables::{Cell, Table};
use harmolux::{Error, Result};

use crate::common::{interrupt, say};

/// The last column: what a row follows from.
pub(crate) const KEY: &str = "key";

/// The columns that hold texts.
const TEXTS: [&str; 6] = ["name", "shape", "normalisation", "warning", "error", KEY];

/// The table, and its file, which belongs to this run.
pub(crate) struct GrowingTable {
    claim: Claim,
    table: Table,
    force: bool,
    /// Whether there was a table.
    stood: bool,
    /// Whether the file is to stay: it has rows, or had more than a header.
    stays: AtomicBool,
}

impl GrowingTable {
    /// Opens a CSV file and takes the rows that stand there; none with `force`, which begins anew.
    pub(crate) fn open(path: &Path, columns: Table, force: bool) -> Result<Self> {
        let claim = Claim::open(path, &columns.csv_kind()?, force)?;
        let mut table = columns;
        let header = table.to_csv()?.len();
        let bytes = content(&claim)?;
        if !force {
            table.add_csv(path, &bytes, &TEXTS).map_err(|e| e.advise(Advice::Overwrite))?;
        }
        let (stood, stays) = (!bytes.is_empty(), AtomicBool::new(bytes.len() > header));
        Ok(Self { claim, table, force, stood, stays })
    }

    /// Whether an earlier run began this table: the files beside it are of that run.
    pub(crate) fn goes_on(&self) -> bool {
        !self.force && self.stood
    }

    /// Finds the row that is to have these first cells and this key, if it is there.
    ///
    /// # Errors
    /// [`Error::Parameter`] when a row of these cells follows from something else: it is not
    /// replaced. One that holds an error is.
    pub(crate) fn done(
        &self,
        first: &[Cell],
        key: impl FnOnce() -> Result<String>,
    ) -> Result<Option<Vec<Cell>>> {
        let Some(row) = self.table.rows().iter().find(|row| row.starts_with(first)) else {
            return Ok(None);
        };
        if self.cell(row, "error").is_some_and(|error| *error != Cell::Empty) {
            return Ok(None);
        }
        if row.last() == Some(&key()?.into()) {
            return Ok(Some(row.clone()));
        }
        let names: Vec<String> = first.iter().map(Cell::to_string).collect();
        Err(Error::Parameter(format!(
            "{}: the row of {} is of another run: its mesh or the settings were others",
            self.claim.path().display(),
            names.join(" ").trim()
        ))
        .advise(Advice::Overwrite))
    }

    /// Returns a cell of a row by the name of its column.
    pub(crate) fn cell<'a>(&self, row: &'a [Cell], column: &str) -> Option<&'a Cell> {
        row.get(self.table.header().iter().position(|name| name == column)?)
    }

    /// Leaves out the rows with these first cells, which are made anew.
    pub(crate) fn leave_out(&mut self, first: &[Cell]) {
        self.table.retain(|row| !row.starts_with(first));
    }

    /// Writes what is there before the first row is added.
    pub(crate) fn begin(&mut self) -> Result<()> {
        let csv = self.table.to_csv()?;
        let _whole = interrupt::writing();
        let same = !self.force && content(&self.claim)? == csv;
        if same { Ok(()) } else { self.claim.write_with(&mut |file| file.write_all(&csv)) }
    }

    /// Adds a row to the file and writes what it tells of, and is not interrupted between the two.
    ///
    /// A killed run may have done only the first. It is the row, which without the file does not
    /// count as done; with `force` the file, for an old one may stand there.
    pub(crate) fn append_with<T>(
        &self,
        row: &[Cell],
        write: impl FnOnce() -> Result<T>,
    ) -> Result<Result<T>> {
        let _whole = interrupt::writing();
        if !self.force {
            return self.append(row).map(|()| write());
        }
        let written = write();
        if written.is_ok() {
            self.append(row)?;
        }
        Ok(written)
    }

    /// Adds a row to the file, and waits until the disk has it; for who keeps the run from being
    /// interrupted.
    pub(crate) fn append(&self, row: &[Cell]) -> Result<()> {
        let line = Table::csv_line(row)?;
        self.stays.store(true, Ordering::Relaxed);
        let mut file = self.claim.file()?;
        let mut append = || {
            file.seek(SeekFrom::End(0))?;
            file.write_all(&line)?;
            file.sync_data()
        };
        append().map_err(|e: io::Error| Error::io(self.claim.path(), "write", e))
    }

    /// Writes the rows of this run in their order, and behind them what else stood there; gives
    /// those of this run.
    pub(crate) fn finish(mut self, rows: Vec<Vec<Cell>>) -> Result<Table> {
        let mut own = Table::new(self.table.header().to_vec());
        for row in rows {
            own.push(row);
        }
        let mut all = own.clone();
        let text = |row: &Vec<Cell>| format!("{row:?}");
        let made: HashSet<String> = own.rows().iter().map(text).collect();
        for row in self.table.rows().iter().filter(|row| !made.contains(&text(row))) {
            all.push(row.iter().cloned());
        }
        let kept = all.rows().len() - own.rows().len();
        if kept > 0 {
            let path = self.claim.path().display();
            say::note(&format!("{path} keeps {kept} rows of an earlier run; `--force` drops them"));
        }
        let csv = all.to_csv()?;
        *self.stays.get_mut() = true;
        self.claim.write_with(&mut |file| file.write_all(&csv))?;
        Ok(own)
    }
}

impl Drop for GrowingTable {
    /// Leaves no table without a row.
    fn drop(&mut self) {
        if !*self.stays.get_mut() {
            // What is empty goes with the claim; what stays does no harm.
            let _ = self.claim.file().map(|file| file.set_len(0));
        }
    }
}

/// Reads what stands there.
fn content(claim: &Claim) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = claim.file()?.read_to_end(&mut bytes);
    read.map(|_| bytes).map_err(|e| Error::io(claim.path(), "read", e))
}

/// Returns what a result follows from as one word: the program's version, what was read of the file
/// and of those it names, and the settings.
pub(crate) fn key(read: &FilesRead, settings: &dyn Debug) -> String {
    let FilesRead { file, beside, .. } = read;
    let mut text = format!("{SOFTWARE} {settings:?} {file}");
    for file in beside {
        let _ = write!(text, " {file}");
    }
    SourceHash::of(text.as_bytes()).to_string()
}
