//! What a sweep prints.

use harmolux::error::shown_path;
use harmolux::io::scene_file::SceneFile;
use harmolux::io::tables::Table;
use harmolux::study::{Column, SweepLimit, SweepRow};
use harmolux::{Error, Result};
use serde_json::{Value, json};

use super::Sweep;
use super::lines::report_name;
use crate::common::exit::Code;
use crate::common::say;

/// Which degree keeps a limit.
pub(super) struct Answer {
    limit: String,
    row: Option<SweepRow>,
    /// What noise makes of it, where that is more than the limit.
    noise: Option<String>,
}

impl Answer {
    /// Returns it as JSON.
    pub(super) fn value(&self) -> Value {
        let of = |column: Column| self.row.as_ref().map(|row| row[column]);
        json!({
            "tolerance": self.limit,
            "degree": self.row.as_ref().and_then(|row| row.degree),
            "bytes": of(Column::BytesF32).map(|bytes| bytes as u64),
            "nanoseconds_per_ray": of(Column::Hit),
        })
    }
}

/// Rejects limits of what the scene does not show, before anything is measured.
pub(super) fn check_limits(verb: &Sweep, scene: Option<&SceneFile>) -> Result<()> {
    let missing = |limit: &SweepLimit| match limit.column {
        Column::RelMse | Column::Flip if scene.is_none_or(|s| s.cameras.is_empty()) => "a camera",
        Column::LuxMax if scene.is_none_or(|s| s.sensors.is_empty()) => "sensors",
        _ => "",
    };
    let found = verb.tolerance.iter().map(|limit| (limit, missing(limit)));
    match found.into_iter().find(|(_, missing)| !missing.is_empty()) {
        Some((limit, missing)) => Err(Error::Parameter(format!(
            "--tolerance {limit}: name a scene with {missing} with `--scene`"
        ))),
        None => Ok(()),
    }
}

/// Finds the smallest degree for each limit.
pub(super) fn answers(limits: &[SweepLimit], rows: &[SweepRow]) -> Vec<Answer> {
    let answer = |limit: &SweepLimit| Answer {
        limit: limit.to_string(),
        row: limit.answer(rows).cloned(),
        noise: limit.noise_above(rows).map(|noise| cell(limit.column, noise)),
    };
    limits.iter().map(answer).collect()
}

/// Says by the exit code whether every limit is kept by a degree.
pub(super) fn code(answers: &[Answer]) -> Code {
    let mut code = Code::Done;
    for answer in answers.iter().filter(|answer| answer.row.is_none()) {
        let why = match &answer.noise {
            None => "no degree keeps this; go on to higher ones".to_owned(),
            Some(noise) => format!(
                "noise alone makes {noise}, so no degree can keep this; raise `--samples`, or for \
                 lux the effort of the scene's `illum.stop`"
            ),
        };
        say::warning(&format!("{}: {why}", answer.limit));
        code = Code::NotMet;
    }
    code
}

/// Returns the table as JSON.
pub(super) fn json(table: &Table) -> Result<Value> {
    let failed = |e| Error::Numeric(format!("the JSON writer failed: {e}"));
    serde_json::to_value(table).map_err(failed)
}

/// Prints the table and the answers.
pub(super) fn print(
    verb: &Sweep,
    table: &Table,
    rows: &[SweepRow],
    answers: &[Answer],
    as_json: bool,
) -> Result<()> {
    if as_json {
        let mut value = json(table)?;
        value["answers"] = answers.iter().map(Answer::value).collect();
        say::raw(&format!("{value:#}"));
        return Ok(());
    }
    say::data(&text(rows));
    for answer in answers {
        let Some(row) = &answer.row else { continue };
        say::data(&format!(
            "{}: {}, {}, {} ns a ray",
            answer.limit,
            report_name(row),
            say::bytes(row[Column::BytesF32] as usize),
            say::significant(row[Column::Hit], 3)
        ));
    }
    let page = verb.output.join("index.html");
    say::note(&format!("written to {}: open {}", shown_path(&verb.output), shown_path(&page)));
    Ok(())
}

/// The columns of the printed table: those of everyday, and of pictures where there are any.
const SHOWN: [(&str, Column); 11] = [
    ("f32", Column::BytesF32),
    ("compact", Column::BytesCompact),
    ("RMS", Column::RelativeRms),
    ("largest", Column::RelativeMax),
    ("Hausdorff, m", Column::HausdorffUpper),
    ("normals 95 %", Column::Normal95),
    ("fit ms", Column::Fit),
    ("ray ns", Column::Hit),
    ("relMSE", Column::RelMse),
    ("FLIP", Column::Flip),
    ("lux", Column::LuxMax),
];

fn text(rows: &[SweepRow]) -> String {
    let known = |column: Column| rows.iter().any(|row| !row[column].is_nan());
    let shown: Vec<_> = SHOWN.into_iter().filter(|(_, column)| known(*column)).collect();
    let header: Vec<&str> =
        std::iter::once("shape").chain(shown.iter().map(|(name, _)| *name)).collect();
    let mut table = say::table(&header);
    for row in rows {
        let cells = shown.iter().map(|(_, column)| cell(*column, row[*column]));
        table.add_row(std::iter::once(report_name(row)).chain(cells));
    }
    table.to_string()
}

fn cell(column: Column, value: f64) -> String {
    match column.unit() {
        _ if value.is_nan() => String::new(),
        "bytes" => say::bytes(value as usize),
        "%" => say::percent(value),
        "ns" | "ms" => format!("{value:.0}"),
        _ => say::significant(value, 3),
    }
}
