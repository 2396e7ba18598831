//! A table that grows on disk row by row as results come, so that a run that was ended, in whatever
//! way, goes on where it was when it is started again.

use std::collections::HashSet;
use std::fmt::Debug;
use std::fs::OpenOptions;
use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use harmolux::error::Advice;
use harmolux::fit::{Source, SourceHash};
use harmolux::io::output::Claim;
use harmolux::io::tables::{Cell, Table};
use harmolux::{Error, Result};

/// The last column: what a row follows from.
pub(crate) const KEY: &str = "key";

/// The columns that hold texts.
const TEXTS: [&str; 4] = ["name", "shape", "error", KEY];

/// The table, and its file, which belongs to this run.
pub(crate) struct GrowingTable {
    claim: Claim,
    table: Table,
    force: bool,
    /// Whether the file has rows.
    has_rows: AtomicBool,
}

impl GrowingTable {
    /// Opens a CSV file and takes the rows that stand there; none with `force`, which begins anew.
    pub(crate) fn open(path: &Path, columns: Table, force: bool) -> Result<Self> {
        let claim = Claim::open(path, &columns.csv_kind()?, force)?;
        let mut table = columns;
        let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
        if !force {
            table.add_csv(&bytes, &TEXTS);
        }
        let has_rows = !table.rows().is_empty() || (force && !bytes.is_empty());
        Ok(Self { claim, table, force, has_rows: AtomicBool::new(has_rows) })
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
        let path = self.claim.path();
        let same = !self.force && std::fs::read(path).is_ok_and(|bytes| bytes == csv);
        if same { Ok(()) } else { self.claim.write_with(&mut |file| file.write_all(&csv)) }
    }

    /// Adds a row to the file, and waits until the disk has it.
    pub(crate) fn append(&self, row: &[Cell]) -> Result<()> {
        let path = self.claim.path();
        let line = Table::csv_line(row)?;
        let append = || {
            let mut file = OpenOptions::new().append(true).open(path)?;
            file.write_all(&line)?;
            file.sync_data()
        };
        self.has_rows.store(true, Ordering::Relaxed);
        append().map_err(|e| Error::io(path, "write", e))
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
        let csv = all.to_csv()?;
        *self.has_rows.get_mut() = true;
        self.claim.write_with(&mut |file| file.write_all(&csv))?;
        Ok(own)
    }
}

impl Drop for GrowingTable {
    /// Leaves no table without a row.
    fn drop(&mut self) {
        if !*self.has_rows.get_mut() {
            // What is empty goes with the claim; what stays does no harm.
            let _ = OpenOptions::new().write(true).truncate(true).open(self.claim.path());
        }
    }
}

/// Returns what a result follows from as one word: the content of the file and the settings.
pub(crate) fn key(source: &Source, settings: &dyn Debug) -> String {
    SourceHash::of(format!("{} {settings:?}", source.hash).as_bytes()).to_string()
}
