//! `harmolux fit` of several meshes: a folder of coefficient files and one table of all fits.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use harmolux::error::shown;
use harmolux::io::input::FilesRead;
use harmolux::io::tables::{Cell, Table};
use harmolux::study::batch;
use harmolux::{Error, Result};

use crate::common::exit::Code;
use crate::common::growing::{GrowingTable, KEY, key};
use crate::common::inputs::files;
use crate::common::progress::Meter;
use crate::common::shape_file;
use crate::common::{interrupt, say};
use crate::fit::report::warnings;
use crate::fit::{Fit, Fitted, ProjectionName, fit_file, settings, write};

/// One mesh, done or refused.
struct Row {
    cells: Vec<Cell>,
    error: Option<Error>,
    warnings: Vec<String>,
}

impl Row {
    fn name(&self) -> String {
        self.cells.first().map_or(String::new(), Cell::to_string)
    }
}

/// Runs the verb; a folder made for it does not stay behind empty when it is refused.
pub(crate) fn run(verb: &Fit, as_json: bool) -> Result<Code> {
    let is_new = !verb.output.exists();
    std::fs::create_dir_all(&verb.output).map_err(|e| Error::io(&verb.output, "create", e))?;
    let done = fit_all(verb, as_json);
    if done.is_err() && is_new {
        // Removes an empty folder only.
        let _ = std::fs::remove_dir(&verb.output);
    }
    done
}

fn fit_all(verb: &Fit, as_json: bool) -> Result<Code> {
    let all = verb.meshes.len();
    let meter = Meter::start(&format!("0 of {all}"));
    let mut table = GrowingTable::open(&verb.output.join("fits.csv"), columns(), verb.force)?;
    let tasks = tasks(verb, &mut table)?;
    table.begin()?;
    let results = batch(
        tasks,
        |task| task.finish(verb, &table),
        |result, done| match result {
            Ok(row) => {
                row.error.iter().for_each(say::error);
                meter.count(done, all, &row.name());
                ControlFlow::Continue(())
            }
            Err(_) => ControlFlow::Break(()),
        },
    );
    drop(meter);
    let rows: Vec<Row> = results.into_iter().flatten().collect::<Result<_>>()?;
    for (row, warning) in rows.iter().flat_map(|row| row.warnings.iter().map(move |w| (row, w))) {
        say::warning(&format!("{}: {warning}", row.name()));
    }
    let failed = rows.iter().filter(|row| row.error.is_some()).map(Row::name).collect::<Vec<_>>();
    let whole = interrupt::writing();
    let table = table.finish(rows.into_iter().map(|row| row.cells).collect())?;
    drop(whole);
    if as_json {
        say::raw(String::from_utf8_lossy(&table.to_json()?).trim_end());
    } else {
        print(&table);
        say::note(&format!("written to {}", verb.output.display()));
    }
    Ok(verdict(&failed, all))
}

/// A mesh and what is to be done about it.
enum Task {
    /// Nothing: it has its row and its file.
    Done(Vec<Cell>),
    /// It is fitted, and written to a file that is held only then: there may be more than can be
    /// open at once.
    Fit(PathBuf, PathBuf),
}

/// Looks which meshes an earlier run has done, and whether the files of the others can be written.
fn tasks(verb: &Fit, table: &mut GrowingTable) -> Result<Vec<Task>> {
    let mut taken: HashMap<PathBuf, &Path> = HashMap::new();
    let mut all = Vec::new();
    for mesh in &verb.meshes {
        let mut name = mesh.file_stem().unwrap_or_default().to_owned();
        name.push(".txt");
        let path = verb.output.join(name);
        if let Some(other) = taken.insert(path.clone(), mesh) {
            return Err(Error::Parameter(format!(
                "{} and {} would both be written to {}: fit them into different folders",
                other.display(),
                mesh.display(),
                path.display()
            )));
        }
        let first = [name_of(mesh)];
        let key = || Ok(key_of(verb, &files(mesh)?));
        let done = table.done(&first, key)?.filter(|_| path.is_file());
        all.push(if let Some(row) = done {
            Task::Done(row)
        } else {
            table.leave_out(&first);
            drop(shape_file::open(&path, verb.force)?);
            Task::Fit(mesh.clone(), path)
        });
    }
    Ok(all)
}

fn name_of(mesh: &Path) -> Cell {
    mesh.display().to_string().into()
}

/// Returns what a fit follows from.
fn key_of(verb: &Fit, read: &FilesRead) -> String {
    let settings = settings(verb, ProjectionName::Conforming);
    key(read, &(settings, verb.projection.is_some(), verb.weights, &verb.habits))
}

impl Task {
    /// Fits, and writes the row and the coefficients. What goes wrong with one mesh is its row's.
    fn finish(self, verb: &Fit, table: &GrowingTable) -> Result<Row> {
        let (mesh, output) = match self {
            Self::Done(cells) => return Ok(Row { cells, error: None, warnings: Vec::new() }),
            Self::Fit(mesh, output) => (mesh, output),
        };
        let started = Instant::now();
        let fit = || Ok((shape_file::open(&output, verb.force)?, fit_file(verb, &mesh)?));
        let fitted = fit();
        let seconds = started.elapsed().as_secs_f64();
        let cells = |fitted: std::result::Result<&(Fitted, FilesRead), &Error>| {
            cells(verb, &mesh, fitted, seconds)
        };
        let row = cells(fitted.as_ref().map(|(_, fitted)| fitted));
        let written = table.append_with(&row, || {
            let (output, (fitted, files)) = fitted?;
            write(verb, &fitted, files.file.source(), output)?;
            Ok(warnings(verb, &fitted))
        })?;
        Ok(match written {
            Ok(warnings) => Row { cells: row, error: None, warnings },
            Err(error) => {
                let cells = cells(Err(&error));
                Row { cells, error: Some(error), warnings: Vec::new() }
            }
        })
    }
}

fn columns() -> Table {
    Table::new([
        "name",
        "degree",
        "centre_x",
        "centre_y",
        "centre_z",
        "clearance",
        "mean_radius",
        "rms",
        "max",
        "normal_mean_degrees",
        "normal_95_degrees",
        "volume",
        "mesh_volume",
        "area",
        "mesh_area",
        "folded_share",
        "seconds",
        "warning",
        "error",
        KEY,
    ])
}

fn cells(
    verb: &Fit,
    mesh: &Path,
    fitted: std::result::Result<&(Fitted, FilesRead), &Error>,
    seconds: f64,
) -> Vec<Cell> {
    let mut cells = vec![name_of(mesh), Cell::Whole(verb.degree.into())];
    match fitted {
        Ok((Fitted::Mesh(fit), _)) => {
            let error = &fit.error;
            cells.extend(fit.centre.to_array().map(Cell::Number));
            let numbers = [
                fit.clearance,
                fit.coefficients.mean(),
                error.rms,
                error.max,
                error.normal_mean.to_degrees(),
                error.normal_95.to_degrees(),
                error.volume[1],
                error.volume[0],
                error.area[1],
                error.area[0],
                fit.folds.map_or(0.0, |f| f.share),
            ];
            cells.extend(numbers.map(Cell::Number));
        }
        Ok((Fitted::Points(fit), _)) => {
            cells.extend(fit.centre.to_array().map(Cell::Number));
            cells.push(Cell::Empty);
            cells.extend([fit.coefficients.mean(), fit.rms, fit.max].map(Cell::Number));
            cells.extend(vec![Cell::Empty; 7]);
        }
        Err(_) => cells.extend(vec![Cell::Empty; 14]),
    }
    cells.push(Cell::Number(seconds));
    let said = fitted.ok().map(|(fitted, _)| warnings(verb, fitted).join("; "));
    cells.push(said.filter(|text| !text.is_empty()).into());
    cells.push(fitted.err().map(ToString::to_string).into());
    cells.push(fitted.ok().map(|(_, read)| key_of(verb, read)).into());
    cells
}

fn print(fits: &Table) {
    let mut table = say::table(&[
        "mesh",
        "mean radius, m",
        "RMS error",
        "largest",
        "normals",
        "folded",
        "time",
    ]);
    let place = |name: &str| fits.header().iter().position(|column| column == name);
    let columns = ["mean_radius", "rms", "max", "normal_mean_degrees", "folded_share", "seconds"];
    for row in fits.rows() {
        let number = |name: &str| place(name).and_then(|column| row[column].number());
        let [mean, rms, max, normals, folded, seconds] = columns.map(number);
        let cell =
            |value: Option<f64>, text: &dyn Fn(f64) -> String| value.map_or(String::new(), text);
        let relative =
            |error: Option<f64>| cell(error.zip(mean).map(|(e, m)| e / m), &say::percent);
        table.add_row([
            shown(&row[0].to_string()),
            mean.map_or("not fitted".to_owned(), |mean| say::significant(mean, 6)),
            relative(rms),
            relative(max),
            cell(normals, &|degrees| format!("{degrees:.2} deg")),
            cell(folded.filter(|share| *share > 0.0), &say::percent),
            cell(seconds, &|seconds| format!("{seconds:.2} s")),
        ]);
    }
    say::data(&table.to_string());
}

/// Says what failed.
fn verdict(failed: &[String], wanted: usize) -> Code {
    if failed.is_empty() {
        return Code::Done;
    }
    say::note(&format!(
        "error: {} of {wanted} could not be fitted: {}",
        failed.len(),
        failed.join(", ")
    ));
    Code::BadInput
}
