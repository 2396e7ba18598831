//! A table of answers, once for machines and once, from the same cells, for people.

use harmolux::io::tables::{Cell, Table};
use harmolux::{Error, Result};

use crate::common::say;

/// How people read the numbers of a column.
#[derive(Debug, Clone, Copy)]
pub(super) enum Style {
    /// As short as they are: what was asked for.
    Given,
    /// To so many decimals.
    Decimals(usize),
    /// To so many significant digits.
    Significant(usize),
    /// Not at all: the column is for machines.
    Hidden,
}

/// A column: its name for machines, its heading for people.
#[derive(Debug, Clone)]
pub(super) struct Column {
    name: String,
    heading: String,
    style: Style,
}

impl Column {
    pub(super) fn new(name: impl Into<String>, heading: impl Into<String>, style: Style) -> Self {
        Self { name: name.into(), heading: heading.into(), style }
    }
}

/// The answers to a problem.
#[derive(Debug)]
pub(super) struct Sheet {
    columns: Vec<Column>,
    pub(super) table: Table,
    /// What holds for the whole: its key for machines, the value.
    totals: Vec<(&'static str, f64)>,
    /// What there is to say about the answers.
    pub(super) notes: Vec<String>,
}

impl Sheet {
    pub(super) fn new(columns: impl IntoIterator<Item = Column>) -> Self {
        let columns: Vec<Column> = columns.into_iter().collect();
        let table = Table::new(columns.iter().map(|c| c.name.clone()));
        Self { columns, table, totals: Vec::new(), notes: Vec::new() }
    }

    pub(super) fn push(&mut self, row: impl IntoIterator<Item = Cell>) {
        self.table.push(row);
    }

    pub(super) fn total(&mut self, key: &'static str, value: f64) {
        self.totals.push((key, value));
    }

    pub(super) fn note(&mut self, text: impl Into<String>) {
        self.notes.push(text.into());
    }

    /// Rejects answers that no longer fit into a number.
    pub(super) fn check(&self) -> Result<()> {
        let cells = self.table.rows().iter().flatten();
        let numbers = cells.filter_map(|cell| match cell {
            Cell::Number(number) => Some(*number),
            _ => None,
        });
        if numbers.chain(self.totals.iter().map(|(_, value)| *value)).all(f64::is_finite) {
            return Ok(());
        }
        Err(Error::Parameter(
            "an answer is beyond the range of numbers; give lengths and light nearer to 1".into(),
        ))
    }

    /// Returns the table in Markdown.
    pub(super) fn text(&self) -> String {
        let shown = || self.columns.iter().enumerate().filter(|(_, c)| c.style.is_shown());
        let header: Vec<&str> = shown().map(|(_, c)| c.heading.as_str()).collect();
        let mut table = say::table(&header);
        for row in self.table.rows() {
            table.add_row(shown().map(|(i, column)| column.style.write(&row[i])));
        }
        table.to_string()
    }

    /// Returns rows and totals as JSON.
    pub(super) fn json(&self) -> Result<String> {
        if self.totals.is_empty() {
            return Ok(String::from_utf8_lossy(&self.table.to_json()?).trim_end().to_owned());
        }
        let failed = |e| Error::Numeric(format!("the JSON writer failed: {e}"));
        let mut report = serde_json::to_value(&self.table).map_err(failed)?;
        for (key, value) in &self.totals {
            report[*key] = (*value).into();
        }
        serde_json::to_string_pretty(&report).map_err(failed)
    }
}

impl Style {
    const fn is_shown(self) -> bool {
        !matches!(self, Self::Hidden)
    }

    fn write(self, cell: &Cell) -> String {
        match (self, cell) {
            (Self::Decimals(digits), Cell::Number(x)) => format!("{x:.digits$}"),
            (Self::Significant(digits), Cell::Number(x)) => say::significant(*x, digits),
            (_, Cell::Number(x)) => format!("{x}"),
            (_, Cell::Empty) => String::new(),
            (_, cell) => cell.to_string(),
        }
    }
}
