//! `harmolux sweep`: what each truncation degree costs and buys.

use std::path::PathBuf;

use clap::Args;
use harmolux::fit::Shape;
use harmolux::io::input::Input;
use harmolux::io::output::{Output, Stage};
use harmolux::io::tables::{Cell, Table};
use harmolux::study::{SweepRow, sweep, sweep_figure};
use harmolux::{Error, Result};

use crate::common::about::about;
use crate::common::exit::Code;
use crate::common::flags::MeshHabits;
use crate::common::inputs::{MeshRead, read_mesh};
use crate::common::plot::PlotFormat;
use crate::common::say;
use crate::common::shape_file;
use crate::common::target::write_all;
use crate::common::values::{Degrees, degrees};

/// Measure what each truncation degree costs and buys, beside the mesh itself
///
/// For each degree: bytes, RMS and largest radial error, time to fit, time to trace a ray. Writes
/// sweep.csv, the plot of error against bytes as sweep.svg and sweep.png, and the coefficients of
/// each degree.
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
    let mut table = columns();
    let csv = Output::open(&verb.output.join("sweep.csv"), &table.csv_kind()?, verb.force)?;
    let stem = verb.mesh.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let file = |degree: usize| {
        let path = verb.output.join(format!("{stem}-{degree}.txt"));
        shape_file::open(&path, verb.force)
    };
    let plot = |(name, format): (&str, PlotFormat)| {
        Ok((format, Output::open(&verb.output.join(name), &format.kind(), verb.force)?))
    };
    let plots = [("sweep.svg", PlotFormat::Svg), ("sweep.png", PlotFormat::Png)];
    let plots: Vec<(PlotFormat, Output)> = plots.into_iter().map(plot).collect::<Result<_>>()?;
    // Checked now, held only while it is written: there may be more than can be open at once.
    verb.degrees.0.iter().try_for_each(|degree| file(*degree).map(drop))?;
    let MeshRead { mesh, source, .. } = read_mesh(Input::open(&verb.mesh)?, &verb.habits)?;
    let lines = verb.degrees.0.len() + 1;
    let rows = sweep(&mesh, &verb.degrees.0, &|done| say::note(&format!("{done} of {lines}")))
        .map_err(|e| about(&verb.mesh, e))?;
    for row in &rows {
        fill(&mut table, row);
    }
    let fits = rows.iter().filter_map(|row| row.fit.as_ref());
    let shapes = fits.map(|fit| {
        let shape = Shape {
            coefficients: fit.coefficients.clone(),
            centre: fit.centre,
            source: Some(source.clone()),
            truncated_from: None,
        };
        file(fit.coefficients.lmax())?.write(&shape)
    });
    let figure = sweep_figure(&rows);
    let plots = plots.into_iter().map(|(format, o)| format.write(&figure, o, Stage::Complete));
    // What took longest to get first, the pictures last.
    let table_written = std::iter::once_with(|| csv.write(&table.to_csv()?));
    let written = write_all(shapes.chain(table_written).chain(plots));
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
    ])
}

fn fill(table: &mut Table, row: &SweepRow) {
    let mut cells = match &row.fit {
        Some(fit) => vec![
            Cell::from("series"),
            Cell::Whole(fit.coefficients.lmax() as u64),
            Cell::Whole(fit.coefficients.count() as u64),
            Cell::Whole(row.bytes as u64),
            Cell::Number(fit.relative_rms()),
            Cell::Number(fit.relative_max()),
            Cell::Number(1e3 * fit.projection_time.as_secs_f64()),
        ],
        None => vec![
            Cell::from("mesh"),
            Cell::Empty,
            Cell::Empty,
            Cell::Whole(row.bytes as u64),
            Cell::Number(0.0),
            Cell::Number(0.0),
            Cell::Empty,
        ],
    };
    cells.push(Cell::Number(row.nanoseconds_per_ray));
    table.push(cells);
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
        match &row.fit {
            Some(fit) => table.add_row([
                format!("degree {}", fit.coefficients.lmax()),
                fit.coefficients.count().to_string(),
                bytes,
                say::percent(fit.relative_rms()),
                say::percent(fit.relative_max()),
                format!("{:.0}", 1e3 * fit.projection_time.as_secs_f64()),
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
