//! The table of all shapes of a batch of fits, which grows beside that of the fits.

use std::path::Path;

use harmolux::Result;
use harmolux::fit::Shape;
use harmolux::io::coefficients::{self, ReadOptions, SeriesFormat, shape_table};
use harmolux::io::tables::{Cell, Table};

use crate::common::growing::{GrowingTable, KEY};
use crate::fit::{Fit, TableLayout};

/// The table, and what its rows are like. A row has the name of its coefficient file, without
/// extension, and the key of its fit.
pub(crate) struct ShapeRows {
    table: GrowingTable,
    format: SeriesFormat,
    lmax: usize,
}

impl ShapeRows {
    /// Opens the table that is asked for, and takes the rows that stand there.
    pub(crate) fn open(verb: &Fit) -> Result<Option<Self>> {
        let Some(path) = &verb.table else { return Ok(None) };
        let format = match verb.table_layout {
            TableLayout::Harmolux => SeriesFormat::Table,
            TableLayout::Aics => SeriesFormat::Aics,
        };
        let lmax = verb.degree as usize;
        let mut columns = shape_table::columns(format, lmax);
        columns.push(KEY.to_owned());
        let table = GrowingTable::open(path, Table::new(columns), verb.force)?;
        Ok(Some(Self { table, format, lmax }))
    }

    /// Finds the row of a coefficient file, as [`GrowingTable::done`].
    pub(crate) fn done(
        &self,
        file: &Path,
        key: impl FnOnce() -> Result<String>,
    ) -> Result<Option<Vec<Cell>>> {
        self.table.done(&[name(file).into()], key)
    }

    /// Leaves out the row of a coefficient file that is made anew.
    pub(crate) fn leave_out(&mut self, file: &Path) {
        self.table.leave_out(&[name(file).into()]);
    }

    /// Writes what is there before the first row is added.
    pub(crate) fn begin(&mut self) -> Result<()> {
        self.table.begin()
    }

    /// Adds the shape of a coefficient file, for who keeps the run from being interrupted.
    pub(crate) fn add(&self, file: &Path, shape: &Shape, key: Option<&Cell>) -> Result<Vec<Cell>> {
        let mut row = shape_table::row(self.format, self.lmax, &name(file), shape)?;
        row.push(key.cloned().unwrap_or(Cell::Empty));
        self.table.append(&row)?;
        Ok(row)
    }

    /// Adds what a coefficient file of an earlier run holds.
    pub(crate) fn add_file(&self, file: &Path, key: Option<&Cell>) -> Result<Vec<Cell>> {
        let shape = coefficients::read(file, &ReadOptions::default())?;
        let _whole = crate::common::interrupt::writing();
        self.add(file, &shape, key)
    }

    /// Writes the rows in their order, and behind them what else stood there.
    pub(crate) fn finish(self, rows: Vec<Vec<Cell>>) -> Result<()> {
        self.table.finish(rows).map(drop)
    }
}

fn name(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
