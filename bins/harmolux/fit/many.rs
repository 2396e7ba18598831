//! `harmolux fit` of several meshes: a folder of coefficient files, one table of all fits, and one of
//! all shapes where it is asked for.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use harmolux::error::shown;
use harmolux::fit::Measures;
use harmolux::io::input::FilesRead;
use harmolux::io::tables::{Cell, Table};
use harmolux::math::EulerAngles;
use harmolux::study::batch;
use harmolux::{Error, Result};

use crate::common::exit::Code;
use crate::common::growing::{GrowingTable, KEY, key};
use crate::common::inputs::files;
use crate::common::progress::Meter;
use crate::common::shape_file;
use crate::common::{folders, interrupt, measures, say};
use crate::fit::report::warnings;
use crate::fit::rows::ShapeRows;
use crate::fit::{Done, Fit, Fitted, ProjectionName, Reference, fit_file, settings};

/// One mesh, done or refused.
struct Row {
    cells: Vec<Cell>,
    /// The shape in the table of all, where there is one.
    shape: Option<Vec<Cell>>,
    error: Option<Error>,
    warnings: Vec<String>,
}

impl Row {
    fn name(&self) -> String {
        self.cells.first().map_or(String::new(), Cell::to_string)
    }
}

/// Runs the verb.
pub(crate) fn run(verb: &Fit, reference: Option<&Reference>, as_json: bool) -> Result<Code> {
    folders::within(&verb.output, || fit_all(&Batch { verb, reference }, as_json))
}

/// What is asked for.
struct Batch<'a> {
    verb: &'a Fit,
    reference: Option<&'a Reference>,
}

fn fit_all(asked: &Batch, as_json: bool) -> Result<Code> {
    let verb = asked.verb;
    let all = verb.meshes.len();
    let meter = Meter::start(&format!("0 of {all}"));
    let mut table = GrowingTable::open(&verb.output.join("fits.csv"), columns(verb), verb.force)?;
    let mut shapes = ShapeRows::open(verb)?;
    let tasks = tasks(asked, &mut table, shapes.as_mut())?;
    table.begin()?;
    shapes.as_mut().map_or(Ok(()), ShapeRows::begin)?;
    let results = batch(
        tasks,
        |task| task.finish(asked, &table, shapes.as_ref()),
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
    let mut rows: Vec<Row> = results.into_iter().flatten().collect::<Result<_>>()?;
    for (row, warning) in rows.iter().flat_map(|row| row.warnings.iter().map(move |w| (row, w))) {
        say::warning(&format!("{}: {warning}", row.name()));
    }
    let failed = rows.iter().filter(|row| row.error.is_some()).map(Row::name).collect::<Vec<_>>();
    let whole = interrupt::writing();
    if let Some(shapes) = shapes {
        shapes.finish(rows.iter_mut().filter_map(|row| row.shape.take()).collect())?;
    }
    let table = table.finish(rows.into_iter().map(|row| row.cells).collect())?;
    drop(whole);
    if as_json {
        say::raw(String::from_utf8_lossy(&table.to_json()?).trim_end());
    } else {
        print(&table);
        let also = verb.table.as_ref().map(|table| format!(" and {}", table.display()));
        say::note(&format!("written to {}{}", verb.output.display(), also.unwrap_or_default()));
    }
    Ok(verdict(&failed, all))
}

/// A mesh and what is to be done about it.
enum Task {
    /// It has its row and its file, and its row in the table of shapes, or not yet.
    Done(Vec<Cell>, PathBuf, Option<Vec<Cell>>),
    /// It is fitted, and written to a file that is held only then: there may be more than can be
    /// open at once.
    Fit(PathBuf, PathBuf),
}

/// Looks which meshes an earlier run has done, and whether the files of the others can be written.
fn tasks(
    asked: &Batch,
    table: &mut GrowingTable,
    mut shapes: Option<&mut ShapeRows>,
) -> Result<Vec<Task>> {
    let verb = asked.verb;
    let file = |mesh: &PathBuf| {
        let mut name = mesh.file_stem().unwrap_or_default().to_owned();
        name.push(".txt");
        verb.output.join(name)
    };
    let paths: Vec<PathBuf> = verb.meshes.iter().map(file).collect();
    folders::require_apart(&verb.meshes, &paths, "fit")?;
    let mut all = Vec::new();
    for (mesh, path) in verb.meshes.iter().zip(paths) {
        let first = [name_of(mesh)];
        let key = || asked.key_of(&files(mesh)?);
        let done = table.done(&first, key)?.filter(|_| path.is_file());
        let shape = shapes.as_ref().map(|shapes| shapes.done(&path, key)).transpose()?.flatten();
        all.push(if let Some(row) = done {
            Task::Done(row, path, shape)
        } else {
            table.leave_out(&first);
            if let Some(shapes) = shapes.as_deref_mut() {
                shapes.leave_out(&path);
            }
            shape_file::open(&path, verb.force)?.take_tolerance(verb.tolerance)?;
            Task::Fit(mesh.clone(), path)
        });
    }
    Ok(all)
}

fn name_of(mesh: &Path) -> Cell {
    mesh.display().to_string().into()
}

impl Batch<'_> {
    /// Returns what a fit follows from.
    fn key_of(&self, read: &FilesRead) -> Result<String> {
        let verb = self.verb;
        let settings = settings(verb, ProjectionName::Conforming)?;
        let reference = self.reference.map(|reference| reference.files.file.to_string());
        let special = (verb.projection.is_some(), verb.weights, reference);
        Ok(key(read, &(settings, special, &verb.habits)))
    }
}

impl Task {
    /// Fits, and writes the rows and the coefficients. What goes wrong with one mesh is its row's.
    fn finish(
        self,
        asked: &Batch,
        table: &GrowingTable,
        shapes: Option<&ShapeRows>,
    ) -> Result<Row> {
        let (mesh, path) = match self {
            Self::Done(cells, path, shape) => {
                let missing = shapes.filter(|_| shape.is_none());
                let shape = match missing {
                    Some(shapes) => Some(shapes.add_file(&path, cells.last())?),
                    None => shape,
                };
                return Ok(Row { cells, shape, error: None, warnings: Vec::new() });
            }
            Self::Fit(mesh, path) => (mesh, path),
        };
        let verb = asked.verb;
        let started = Instant::now();
        let open = || shape_file::open(&path, verb.force);
        let fit = || Ok((open()?, fit_file(verb, asked.reference, &mesh)?));
        let fitted = fit();
        let seconds = started.elapsed().as_secs_f64();
        let cells =
            |fitted: std::result::Result<&Done, &Error>| cells(asked, &mesh, fitted, seconds);
        let row = cells(fitted.as_ref().map(|(_, done)| done));
        let written = table.append_with(&row, || {
            let (output, done) = fitted?;
            done.write(verb, output)?;
            let add = |shapes: &ShapeRows| shapes.add(&path, &done.shape(), row.last());
            Ok((warnings(verb, &done.fitted), shapes.map(add).transpose()?))
        })?;
        Ok(match written {
            Ok((warnings, shape)) => Row { cells: row, shape, error: None, warnings },
            Err(error) => {
                let cells = cells(Err(&error));
                Row { cells, shape: None, error: Some(error), warnings: Vec::new() }
            }
        })
    }
}

/// The columns of the rotation by which shapes are aligned, which stand before the time.
const TURN: [&str; 3] = ["alpha_degrees", "beta_degrees", "gamma_degrees"];

fn columns(verb: &Fit) -> Table {
    let errors = [
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
    ];
    let turn = if verb.align_to.is_some() { &TURN[..] } else { &[] };
    Table::new(
        [&errors[..], &measures::COLUMNS, turn, &["seconds", "warning", "error", KEY]].concat(),
    )
}

fn cells(
    asked: &Batch,
    mesh: &Path,
    fitted: std::result::Result<&Done, &Error>,
    seconds: f64,
) -> Vec<Cell> {
    let verb = asked.verb;
    let mut cells = vec![name_of(mesh), Cell::Whole(verb.degree.into())];
    let body = fitted.ok().and_then(|done| Measures::of_shape(&done.shape()).ok());
    match fitted.map(|done| &done.fitted) {
        Ok(Fitted::Mesh(fit)) => {
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
        Ok(Fitted::Points(fit)) => {
            cells.extend(fit.centre.to_array().map(Cell::Number));
            cells.push(Cell::Empty);
            cells.extend([fit.coefficients.mean(), fit.rms, fit.max].map(Cell::Number));
            let [volume, area] = [body.map(|m| m.volume), body.map(|m| m.area)].map(Cell::from);
            let none = Cell::Empty;
            cells.extend([
                none.clone(),
                none.clone(),
                volume,
                none.clone(),
                area,
                none.clone(),
                none,
            ]);
        }
        Err(_) => cells.extend(vec![Cell::Empty; 14]),
    }
    cells.extend(measures::cells(body.as_ref()));
    if asked.reference.is_some() {
        let turn = fitted.ok().and_then(|done| done.turn).map(|turn| turn.euler());
        let angles = |e: EulerAngles| [e.alpha, e.beta, e.gamma].map(f64::to_degrees);
        let turn = turn.map_or([const { Cell::Empty }; 3], |turn| angles(turn).map(Cell::Number));
        cells.extend(turn);
    }
    cells.push(Cell::Number(seconds));
    let said = fitted.ok().map(|done| warnings(verb, &done.fitted).join("; "));
    cells.push(said.filter(|text| !text.is_empty()).into());
    cells.push(fitted.err().map(ToString::to_string).into());
    cells.push(fitted.ok().and_then(|done| asked.key_of(&done.files).ok()).into());
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
