//! `harmolux sweep`: what each truncation degree costs and buys.

use std::path::PathBuf;

use clap::Args;
use harmolux::fit::{Fit, Shape};
use harmolux::io::input::{FilesRead, Input};
use harmolux::io::output::{Output, Stage};
use harmolux::io::tables::{Cell, Table};
use harmolux::study::{SweepRow, SweptSeries, sweep_degree, sweep_figure, sweep_mesh};
use harmolux::{Error, Result};

use crate::common::about::about;
use crate::common::exit::Code;
use crate::common::flags::MeshHabits;
use crate::common::growing::{GrowingTable, KEY, key};
use crate::common::inputs::{MeshRead, read_mesh};
use crate::common::plot::PlotFormat;
use crate::common::progress::Meter;
use crate::common::shape_file;
use crate::common::target::write_all;
use crate::common::values::{Degrees, degrees};
use crate::common::{interrupt, say};

/// Measure what each truncation degree costs and buys, beside the mesh itself
///
/// For each degree: bytes, RMS and largest radial error, time to fit, time to trace a ray. Writes
/// sweep.csv, the plot of error against bytes as sweep.svg and sweep.png, and the coefficients of
/// each degree. A run that was ended goes on when it is started again; --force begins anew.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux sweep head.obj -l 4,8,16,32,64 -o out
  harmolux sweep head.obj -l 2..16 -o out --json")]
pub(crate) struct Sweep {
    /// The mesh (OBJ, PLY, STL, OFF or glTF)
    pub(crate) mesh: PathBuf,
    /// The degrees: 4,8,16 or 2..64
    #[arg(short = 'l', long = "degrees", value_name = "LIST", value_parser = degrees)]
    pub(crate) degrees: Degrees,
    /// The folder to write to; made when it is not there
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) habits: MeshHabits,
    /// Replace files that are there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// Runs the verb; a folder made for it does not stay behind empty when it fails.
pub(crate) fn run(verb: &Sweep, as_json: bool) -> Result<Code> {
    let is_new = !verb.output.exists();
    std::fs::create_dir_all(&verb.output).map_err(|e| Error::io(&verb.output, "create", e))?;
    let done = measure(verb, as_json);
    if done.is_err() && is_new {
        // Removes an empty folder only.
        let _ = std::fs::remove_dir(&verb.output);
    }
    done
}

fn measure(verb: &Sweep, as_json: bool) -> Result<Code> {
    let meter = Meter::start("reading the mesh");
    let mut table = GrowingTable::open(&verb.output.join("sweep.csv"), columns(), verb.force)?;
    let MeshRead { mesh, files, .. } = read_mesh(Input::open(&verb.mesh)?, &verb.habits)?;
    let key = key(&files, &verb.habits);
    let lines = lines(verb, &key, &mut table)?;
    let plots = plots(verb)?;
    table.begin()?;
    let all = lines.len();
    let mut rows = Vec::new();
    for (i, line) in lines.into_iter().enumerate() {
        meter.stage(&format!("line {} of {all}", i + 1));
        rows.push(match line {
            Line::Done(row) => row,
            Line::Series(degree, path) => {
                let file = shape_file::open(&path, verb.force)?;
                let (fit, row) = sweep_degree(&mesh, degree).map_err(|e| about(&verb.mesh, e))?;
                keep(&table, cells(&row, &key), || file.write(&shape(fit, &files)))?
            }
            Line::Mesh => {
                let row = sweep_mesh(&mesh).map_err(|e| about(&verb.mesh, e))?;
                keep(&table, cells(&row, &key), || Ok(()))?
            }
        });
        say::note(&format!("{} of {all}", i + 1));
    }
    meter.stage("drawing the figure");
    let whole = interrupt::writing();
    let table = table.finish(rows)?;
    let rows: Vec<SweepRow> = table.rows().iter().filter_map(|cells| swept(cells)).collect();
    let figure = sweep_figure(&rows);
    let plots = plots.into_iter().map(|(format, o)| format.write(&figure, o, Stage::Complete));
    let written = write_all(plots);
    drop(whole);
    drop(meter);
    if as_json {
        say::raw(String::from_utf8_lossy(&table.to_json()?).trim_end());
    } else {
        report(&rows);
    }
    written?;
    if !as_json {
        say::note(&format!("written to {}", verb.output.display()));
    }
    Ok(Code::Done)
}

/// Opens the figure, as a drawing and as a picture; a run that goes on draws it anew.
fn plots(verb: &Sweep) -> Result<Vec<(PlotFormat, Output)>> {
    let plots = [("sweep.svg", PlotFormat::Svg), ("sweep.png", PlotFormat::Png)];
    let open = |(name, format): (&str, PlotFormat)| {
        Ok((format, Output::open_again(&verb.output.join(name), &format.kind(), verb.force)?))
    };
    plots.into_iter().map(open).collect()
}

/// What a line of the sweep needs.
enum Line {
    /// Nothing: it is there.
    Done(Vec<Cell>),
    /// A fit, and the file it goes to, which is held only then: there may be more than can be open
    /// at once.
    Series(usize, PathBuf),
    Mesh,
}

/// Looks which lines an earlier run has done, and whether the files of the others can be written.
fn lines(verb: &Sweep, key: &str, table: &mut GrowingTable) -> Result<Vec<Line>> {
    let key = || Ok(key.to_owned());
    let stem = verb.mesh.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut lines = Vec::new();
    for &degree in &verb.degrees.0 {
        let first = [Cell::from("series"), Cell::from(degree)];
        let path = verb.output.join(format!("{stem}-{degree}.txt"));
        let done = table.done(&first, key)?.filter(|_| path.is_file());
        lines.push(if let Some(row) = done {
            Line::Done(row)
        } else {
            table.leave_out(&first);
            drop(shape_file::open(&path, verb.force)?);
            Line::Series(degree, path)
        });
    }
    lines.push(table.done(&["mesh".into()], key)?.map_or(Line::Mesh, Line::Done));
    Ok(lines)
}

/// Writes what a line brought: its row, and the coefficients.
fn keep(
    table: &GrowingTable,
    row: Vec<Cell>,
    write: impl FnOnce() -> Result<()>,
) -> Result<Vec<Cell>> {
    table.append_with(&row, write)??;
    Ok(row)
}

fn shape(fit: Fit, files: &FilesRead) -> Shape {
    let Fit { coefficients, centre, .. } = fit;
    Shape { coefficients, centre, source: Some(files.file.source()), truncated_from: None }
}

fn columns() -> Table {
    Table::new([
        "shape",
        "degree",
        "coefficients",
        "bytes",
        "relative_rms",
        "relative_max",
        "fit_ms",
        "ns_per_ray",
        KEY,
    ])
}

fn cells(row: &SweepRow, key: &str) -> Vec<Cell> {
    let mut cells = match &row.series {
        Some(series) => vec![
            Cell::from("series"),
            Cell::from(series.degree),
            Cell::from((series.degree + 1).pow(2)),
            Cell::from(row.bytes),
            Cell::Number(series.relative_rms),
            Cell::Number(series.relative_max),
            Cell::Number(series.fit_ms),
        ],
        None => vec![
            Cell::from("mesh"),
            Cell::Empty,
            Cell::Empty,
            Cell::from(row.bytes),
            Cell::Number(0.0),
            Cell::Number(0.0),
            Cell::Empty,
        ],
    };
    cells.extend([Cell::Number(row.nanoseconds_per_ray), Cell::from(key)]);
    cells
}

/// Reads what [`cells`] wrote.
fn swept(cells: &[Cell]) -> Option<SweepRow> {
    let number = |column: usize| cells.get(column).and_then(Cell::number);
    let series = number(1).map(|degree| {
        let [relative_rms, relative_max, fit_ms] = [4, 5, 6].map(number);
        Some(SweptSeries {
            degree: degree as usize,
            relative_rms: relative_rms?,
            relative_max: relative_max?,
            fit_ms: fit_ms?,
        })
    });
    let series = series.map_or(Some(None), |series| series.map(Some))?;
    Some(SweepRow { series, bytes: number(3)? as usize, nanoseconds_per_ray: number(7)? })
}

fn report(rows: &[SweepRow]) {
    let mut table = say::table(&[
        "shape",
        "coefficients",
        "bytes",
        "RMS error",
        "largest",
        "fit ms",
        "ns per ray",
    ]);
    for row in rows {
        let speed = format!("{:.0}", row.nanoseconds_per_ray);
        let bytes = say::bytes(row.bytes);
        match &row.series {
            Some(series) => table.add_row([
                format!("degree {}", series.degree),
                (series.degree + 1).pow(2).to_string(),
                bytes,
                say::percent(series.relative_rms),
                say::percent(series.relative_max),
                format!("{:.0}", series.fit_ms),
                speed,
            ]),
            None => table.add_row([
                "mesh".into(),
                String::new(),
                bytes,
                String::new(),
                String::new(),
                String::new(),
                speed,
            ]),
        };
    }
    say::data(&table.to_string());
}
