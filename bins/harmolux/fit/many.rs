//! `harmolux fit` of several meshes: a folder of coefficient files and one table of all fits.

use std::collections::HashMap;
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use harmolux::io::output::{Output, Stage};
use harmolux::io::tables::{Cell, Table};
use harmolux::study::batch;
use harmolux::{Error, Result};
use indicatif::{ProgressBar, ProgressStyle};

use crate::common::exit::Code;
use crate::common::shape_file;
use crate::common::{interrupt, say};
use crate::fit::report::ringing;
use crate::fit::{Fit, Fitted, fit_file, write};

/// Seconds between plain lines.
const PLAIN_EVERY: Duration = Duration::from_secs(5);

/// One mesh, done or refused.
struct Row {
    name: String,
    fitted: Result<Fitted>,
    seconds: f64,
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
    let mut table = columns();
    let mut csv = Output::open(&verb.output.join("fits.csv"), &table.csv_kind()?, verb.force)?;
    let items = outputs(verb)?;
    interrupt::listen();
    let meter = Meter::start(items.len());
    let rows = batch(
        items,
        |(mesh, output)| fit_one(verb, &mesh, &output),
        |row, done| meter.show(row, done),
    );
    meter.finish();
    let rows: Vec<Row> = rows.into_iter().flatten().collect();
    for row in &rows {
        table.push(cells(verb, row));
        if let Ok(Fitted::Mesh(fit)) = &row.fitted
            && let Some(warning) = ringing(verb, fit)
        {
            say::warning(&format!("{}: {warning}", row.name));
        }
    }
    let stage = if rows.len() < verb.meshes.len() { Stage::Unfinished } else { Stage::Complete };
    let written = csv.write_at(stage, &table.to_csv()?);
    if as_json {
        say::data(String::from_utf8_lossy(&table.to_json()?).trim_end());
    } else {
        print(&rows);
    }
    written?;
    if !as_json {
        say::note(&format!("written to {}", verb.output.display()));
    }
    Ok(verdict(&rows, verb.meshes.len()))
}

/// Finds a coefficient file for each mesh that can be written; it is held only while its mesh is
/// fitted, since there may be more than can be open at once.
fn outputs(verb: &Fit) -> Result<Vec<(PathBuf, PathBuf)>> {
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
        drop(shape_file::open(&path, verb.force)?);
        all.push((mesh.clone(), path));
    }
    Ok(all)
}

fn fit_one(verb: &Fit, mesh: &Path, output: &Path) -> Row {
    let started = Instant::now();
    let fitted = shape_file::open(output, verb.force).and_then(|output| {
        let fitted = fit_file(verb, mesh)?;
        write(verb, &fitted, mesh, output)?;
        Ok(fitted)
    });
    Row { name: mesh.display().to_string(), fitted, seconds: started.elapsed().as_secs_f64() }
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
        "error",
    ])
}

fn cells(verb: &Fit, row: &Row) -> Vec<Cell> {
    let mut cells = vec![Cell::from(row.name.clone()), Cell::Whole(verb.degree.into())];
    match &row.fitted {
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
            cells.extend(vec![Cell::Empty; 7]);
        }
        Err(_) => cells.extend(vec![Cell::Empty; 14]),
    }
    cells.push(Cell::Number(row.seconds));
    cells.push(row.fitted.as_ref().err().map(ToString::to_string).into());
    cells
}

fn print(rows: &[Row]) {
    let mut table = say::table(&[
        "mesh",
        "mean radius, m",
        "RMS error",
        "largest",
        "normals",
        "folded",
        "time",
    ]);
    for row in rows {
        let seconds = format!("{:.2} s", row.seconds);
        let cells = match &row.fitted {
            Ok(Fitted::Mesh(fit)) => [
                say::significant(fit.coefficients.mean(), 6),
                say::percent(fit.relative_rms()),
                say::percent(fit.relative_max()),
                format!("{:.2} deg", fit.error.normal_mean.to_degrees()),
                fit.folds.map_or(String::new(), |f| say::percent(f.share)),
                seconds,
            ],
            Ok(Fitted::Points(fit)) => {
                let mean = fit.coefficients.mean();
                let [rms, max] = [fit.rms, fit.max].map(|e| say::percent(e / mean));
                [say::significant(mean, 6), rms, max, String::new(), String::new(), seconds]
            }
            Err(_) => ["not fitted", "", "", "", "", &seconds].map(str::to_owned),
        };
        table.add_row(std::iter::once(row.name.clone()).chain(cells));
    }
    say::data(&table.to_string());
}

/// Says what failed.
fn verdict(rows: &[Row], wanted: usize) -> Code {
    let failed: Vec<&str> =
        rows.iter().filter(|row| row.fitted.is_err()).map(|row| row.name.as_str()).collect();
    if !failed.is_empty() {
        say::note(&format!(
            "error: {} of {wanted} could not be fitted: {}",
            failed.len(),
            failed.join(", ")
        ));
    }
    if rows.len() < wanted {
        return Code::Interrupted;
    }
    if failed.is_empty() { Code::Done } else { Code::BadInput }
}

/// Shows how far it is: a bar on a terminal, a line now and then elsewhere; failures at once.
struct Meter {
    bar: Option<ProgressBar>,
    all: usize,
    spoken: Mutex<Instant>,
}

impl Meter {
    fn start(all: usize) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(all as u64);
            let style = ProgressStyle::with_template(
                "fit [{bar:32}] {pos} of {len}, {per_sec}, about {eta} left  {msg}",
            );
            bar.with_style(
                style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "),
            )
        });
        Self { bar, all, spoken: Mutex::new(Instant::now()) }
    }

    fn show(&self, row: &Row, done: usize) -> ControlFlow<()> {
        let name = &row.name;
        if let Err(error) = &row.fitted {
            match &self.bar {
                Some(bar) => bar.suspend(|| say::error(error)),
                None => say::error(error),
            }
        }
        if let Some(bar) = &self.bar {
            bar.set_message(name.clone());
            bar.inc(1);
        } else if let Ok(mut spoken) = self.spoken.lock()
            && spoken.elapsed() >= PLAIN_EVERY
        {
            *spoken = Instant::now();
            say::note(&format!("{done} of {}, {name}", self.all));
        }
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}
