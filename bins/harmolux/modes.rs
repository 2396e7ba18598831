//! `harmolux modes`: how shapes vary about their mean.

use std::path::{Path, PathBuf};

use clap::Args;
use harmolux::fit::{Resolution, Shape, tessellate};
use harmolux::io::coefficients::{self, NamedShape, SeriesFormat, WriteOptions};
use harmolux::io::meshes::{self, MeshFormat};
use harmolux::io::output::{Kind, Output};
use harmolux::io::tables::{Cell, Table};
use harmolux::plots::{Axis, Curve, Figure, Style};
use harmolux::sh::{Coefficients, Modes as Found, modes};
use harmolux::{Error, Result};
use serde_json::json;

use crate::common::advice::told;
use crate::common::exit::Code;
use crate::common::flags::SeriesReading;
use crate::common::inputs::{mean_centre, read_shapes};
use crate::common::progress::Meter;
use crate::common::target::write_all;
use crate::common::{folders, paths, plot, say};

/// Find the modes in which shapes vary about their mean
///
/// Principal component analysis of the coefficients in the 4pi normalisation: distances are RMS
/// radial distances, scores and deviations metres. Radii are compared about each shape's own
/// expansion centre, in its own axes; where these are not comparable, fit with --centre centroid and
/// --align-to first. Lower degrees are padded with zeros. The folder gets mean.txt; mode1.txt and so
/// on, the displacement of one standard deviation; scores.csv and explained.csv, each with its
/// figure.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux modes rocks.csv                               the rows of a table, from `fit --table`
  harmolux modes rock-*.txt -o modes
  harmolux modes rocks.csv -o modes --modes 3 --at 2     and meshes two deviations off the mean")]
pub(crate) struct Modes {
    /// The shapes: coefficient files, or tables with a row for each
    #[arg(required = true, value_name = "SHAPE")]
    pub(crate) shapes: Vec<PathBuf>,
    /// A folder for mean, modes, scores and figures, made when it is not there
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// How many modes to give, the largest first
    #[arg(
        long = "modes", value_name = "N", default_value_t = 10,
        value_parser = clap::value_parser!(u32).range(1..)
    )]
    pub(crate) count: u32,
    /// Write a mesh of the mean moved along each mode, both ways, by so many standard deviations
    #[arg(long, value_name = "K", requires = "output", value_parser = deviations)]
    pub(crate) at: Option<f64>,
    /// Plot the explained variance in the terminal
    #[arg(long)]
    pub(crate) plot: bool,
    #[command(flatten)]
    pub(crate) reading: SeriesReading,
    /// Replace files that are there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// Reads a value of the command line.
fn deviations(text: &str) -> std::result::Result<f64, String> {
    let number = text.trim().parse().ok().filter(|k: &f64| *k > 0.0 && k.is_finite());
    number.ok_or_else(|| "write a positive number, such as 2".to_owned())
}

/// Runs the verb.
pub(crate) fn run(verb: &Modes, as_json: bool) -> Result<Code> {
    let meter = Meter::start("reading the shapes");
    let shapes = read_shapes(&verb.shapes, &verb.reading.options())?;
    meter.stage("finding the modes");
    tell_degrees(&shapes);
    let series: Vec<&Coefficients> = shapes.iter().map(|s| &s.shape.coefficients).collect();
    let found = modes(&series, verb.count as usize)?;
    let shape = Shape {
        centre: mean_centre(&shapes, &vec![1.0; shapes.len()]),
        ..Shape::new(found.mean.clone())
    };
    let all = Analysis { shapes, found, mean: shape };
    let mut written = Vec::new();
    if let Some(folder) = &verb.output {
        meter.stage("making figures and meshes");
        written = folders::within(folder, || write(&all.files(verb, folder)?, verb.force))?;
    }
    drop(meter);
    if as_json {
        let mut value = all.value();
        paths::put_all(&mut value, "written", written.iter().map(PathBuf::as_path));
        say::json(&value);
    } else if verb.plot {
        plot::print(&all.explained_figure())?;
    } else {
        all.report();
    }
    if let Some(folder) = verb.output.as_ref().filter(|_| !as_json) {
        say::note(&format!("written to {}", folder.display()));
    }
    Ok(Code::Done)
}

/// Says when shapes are of different degrees.
fn tell_degrees(shapes: &[NamedShape]) {
    let degrees = || shapes.iter().map(|s| s.shape.coefficients.lmax());
    let (Some(least), Some(most)) = (degrees().min(), degrees().max()) else { return };
    if least < most {
        say::note(&format!("degrees {least} to {most}: the lower are padded with zeros"));
    }
}

/// A file to write.
struct File {
    path: PathBuf,
    kind: Kind,
    bytes: Vec<u8>,
}

/// Writes files, once all can be written, and says which.
fn write(files: &[File], force: bool) -> Result<Vec<PathBuf>> {
    let open = |file: &File| Output::open(&file.path, &file.kind, force);
    files.iter().try_for_each(|file| open(file).map(drop))?;
    write_all(files.iter().map(|file| open(file)?.write(&file.bytes)))?;
    Ok(files.iter().map(|file| file.path.clone()).collect())
}

/// The shapes and what was found of them.
struct Analysis {
    shapes: Vec<NamedShape>,
    found: Found,
    mean: Shape,
}

impl Analysis {
    /// Lists the share of the variance that each mode explains, and that of all up to it.
    fn explained(&self) -> Vec<(f64, f64)> {
        let sum = |sum: &mut f64, share: f64| {
            *sum += share;
            Some((share, *sum))
        };
        self.found.modes.iter().map(|mode| mode.explained).scan(0.0, sum).collect()
    }

    fn files(&self, verb: &Modes, folder: &Path) -> Result<Vec<File>> {
        let file = |name: &str, kind, bytes| File { path: folder.join(name), kind, bytes };
        let series = |name: &str, shape: &Shape| {
            let format = SeriesFormat::Text;
            let bytes = coefficients::encode(shape, format, &WriteOptions::default())?;
            Ok::<_, Error>(file(name, format.kind(), bytes))
        };
        let mut files = vec![series("mean.txt", &self.mean)?];
        for (k, mode) in self.found.modes.iter().enumerate() {
            let displacement = Shape::new(mode.displacement.clone());
            files.push(series(&format!("mode{}.txt", k + 1), &displacement)?);
        }
        for (name, table) in [("scores", self.scores()), ("explained", self.explained_table())] {
            files.push(file(&format!("{name}.csv"), table.csv_kind()?, table.to_csv()?));
        }
        let figures =
            [("explained", Some(self.explained_figure())), ("scores", self.scores_figure())];
        for (name, figure) in figures {
            let Some(figure) = figure else { continue };
            files.push(file(&format!("{name}.svg"), Kind::SVG, figure.to_svg()?.into_bytes()));
            files.push(file(&format!("{name}.png"), Kind::PNG, figure.to_png()?));
        }
        let ends = verb.at.map_or(Vec::new(), |at| vec![-at, at]);
        for (k, at) in (0..self.found.modes.len()).flat_map(|k| ends.iter().map(move |at| (k, *at)))
        {
            let name = format!("mode{}_{at:+}.obj", k + 1);
            match self.mesh(k, at) {
                Ok(bytes) => files.push(file(&name, MeshFormat::Obj.kind(), bytes)),
                Err(e) => say::warning(&format!("{name} is left out: {}", told(&e))),
            }
        }
        Ok(files)
    }

    /// Makes a mesh of the mean moved along a mode, to a thousandth of the mean radius.
    fn mesh(&self, mode: usize, deviations: f64) -> Result<Vec<u8>> {
        let moved = self.found.at(mode, deviations);
        let tolerance = 1e-3 * moved.mean().abs();
        let made = tessellate(&moved, self.mean.centre, Resolution::Adaptive { tolerance })?;
        meshes::encode(&made.mesh, MeshFormat::Obj)
    }

    fn scores(&self) -> Table {
        let modes = &self.found.modes;
        let columns = (1..=modes.len()).map(|k| format!("mode{k}_m"));
        let mut table = Table::new(std::iter::once("name".to_owned()).chain(columns));
        for (i, shape) in self.shapes.iter().enumerate() {
            let name = Cell::from(shape.full_name().display().to_string());
            let scores = modes.iter().map(|mode| Cell::Number(mode.scores[i]));
            table.push(std::iter::once(name).chain(scores));
        }
        table
    }

    fn explained_table(&self) -> Table {
        let mut table =
            Table::new(["mode", "deviation_m", "variance_m2", "explained", "cumulative"]);
        for (k, (mode, (share, sum))) in self.found.modes.iter().zip(self.explained()).enumerate() {
            let numbers = [mode.deviation, mode.deviation.powi(2), share, sum];
            table.push(std::iter::once((k + 1).into()).chain(numbers.map(Cell::Number)));
        }
        table
    }

    fn explained_figure(&self) -> Figure {
        let points = |part: fn(&(f64, f64)) -> f64| {
            let shares = self.explained();
            shares.iter().zip(1..).map(|(s, k)| [f64::from(k), 100.0 * part(s)]).collect()
        };
        let curves = vec![
            Curve::new("up to this mode", points(|(_, sum)| *sum)),
            Curve::new("this mode", points(|(share, _)| *share)),
        ];
        let axes = [Axis::linear("mode"), Axis::linear("explained variance, %")];
        Figure::new("Modes of variation", axes, curves)
    }

    /// Draws the scores of the first two modes, where there are two.
    fn scores_figure(&self) -> Option<Figure> {
        let [first, second] = self.found.modes.first_chunk()?;
        let points = first.scores.iter().zip(&second.scores).map(|(x, y)| [*x, *y]).collect();
        let axis = |k: usize, share| {
            Axis::linear(format!("score of mode {k}, m ({} of the variance)", say::percent(share)))
        };
        let axes = [axis(1, first.explained), axis(2, second.explained)];
        let curve = Curve::new("", points).drawn(Style::Points);
        Some(Figure::new("Scores of the shapes", axes, vec![curve]))
    }

    fn value(&self) -> serde_json::Value {
        let modes = self.found.modes.iter().zip(self.explained()).enumerate();
        let mode = |(k, (mode, (share, sum))): (usize, (&harmolux::sh::Mode, (f64, f64)))| {
            json!({
                "mode": k + 1,
                "deviation": mode.deviation,
                "explained": share,
                "cumulative": sum,
                "scores": mode.scores,
            })
        };
        json!({
            "shapes": self.shapes.len(),
            "degree": self.found.mean.lmax(),
            "centre": self.mean.centre.to_array(),
            "mean_radius": self.found.mean.mean(),
            "scatter": self.found.variance.sqrt(),
            "modes": modes.map(mode).collect::<Vec<_>>(),
        })
    }

    fn report(&self) {
        let radius = self.found.mean.mean();
        let mut table = say::table(&[
            "mode",
            "standard deviation, m",
            "of the mean radius",
            "explained",
            "cumulative",
        ]);
        for (k, (mode, (share, sum))) in self.found.modes.iter().zip(self.explained()).enumerate() {
            table.add_row([
                (k + 1).to_string(),
                say::significant(mode.deviation, 4),
                say::percent(mode.deviation / radius),
                say::percent(share),
                say::percent(sum),
            ]);
        }
        say::data(&table.to_string());
        let (count, degree) = (self.shapes.len(), self.found.mean.lmax());
        let scatter = self.found.variance.sqrt();
        let share = say::percent(scatter / radius);
        say::pairs(&[
            ("modes of", format!("{count} shapes, degree {degree}")),
            ("mean radius", format!("{} m", say::significant(radius, 7))),
            ("scatter", format!("{} m, {share}", say::significant(scatter, 4))),
        ]);
    }
}
