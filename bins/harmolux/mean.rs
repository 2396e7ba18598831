//! `harmolux mean`: the mean of shapes.

use std::path::PathBuf;

use clap::Args;
use harmolux::error::shown_path;
use harmolux::fit::Shape;
use harmolux::io::coefficients::NamedShape;
use harmolux::sh::{Coefficients, Spectrum, difference, scatter, weighted_mean};
use harmolux::{Error, Result};
use serde_json::json;

use crate::common::exit::Code;
use crate::common::flags::SeriesReading;
use crate::common::inputs::{mean_centre, read_shapes};
use crate::common::{paths, say, shape_file};

/// Average shapes
///
/// Says how far each is from the mean. Radii are averaged about each shape's own expansion centre,
/// in its own axes; recentre and align the shapes first where these are not comparable. Lower
/// degrees are padded with zeros.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux mean rock-*.txt -o mean.txt
  harmolux mean rocks.csv -o mean.txt                    the rows of a table
  harmolux mean young.txt old.txt -o between.txt --weights 3,1")]
pub(crate) struct Mean {
    /// The shapes: coefficient files, or tables with a row for each
    #[arg(required = true)]
    pub(crate) shapes: Vec<PathBuf>,
    /// Where to write the mean shape
    #[arg(short, long, value_name = "FILE.txt")]
    pub(crate) output: PathBuf,
    /// A positive weight for each shape, of any sum
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub(crate) weights: Option<Vec<f64>>,
    #[command(flatten)]
    pub(crate) reading: SeriesReading,
    /// Replace a file that is there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// Runs the verb.
pub(crate) fn run(verb: &Mean, as_json: bool) -> Result<Code> {
    let output = shape_file::open(&verb.output, verb.force)?;
    let shapes = read_shapes(&verb.shapes, &verb.reading.options())?;
    let weights = weights(verb, shapes.len())?;
    let series = shapes.iter().map(|s| &s.shape.coefficients);
    let members: Vec<(&Coefficients, f64)> = series.zip(weights.iter().copied()).collect();
    let mean =
        Shape { centre: mean_centre(&shapes, &weights), ..Shape::new(weighted_mean(&members)?) };
    let distances: Vec<f64> =
        members.iter().map(|(f, _)| distance(f, &mean.coefficients)).collect();
    output.write(&mean)?;
    let radius = mean.coefficients.mean();
    let only: Vec<&Coefficients> = members.iter().map(|(f, _)| *f).collect();
    let scatter =
        (verb.weights.is_none() && only.len() > 1).then(|| scatter(&only, &mean.coefficients));
    if as_json {
        let row = |(shape, rms): (&NamedShape, &f64)| {
            let mut row = json!({ "rms": rms });
            paths::put(&mut row, "shape", &shape.full_name());
            row
        };
        let mut value = json!({
            "shapes": shapes.len(),
            "degree": mean.coefficients.lmax(),
            "centre": mean.centre.to_array(),
            "mean_radius": radius,
            "scatter": scatter,
            "distances": shapes.iter().zip(&distances).map(row).collect::<Vec<_>>(),
        });
        paths::put(&mut value, "written", &verb.output);
        say::json(&value);
        return Ok(Code::Done);
    }
    let mut table = say::table(&["shape", "RMS distance, m", "of the mean radius"]);
    for (shape, d) in shapes.iter().zip(&distances) {
        table.add_row([
            shown_path(&shape.full_name()),
            say::significant(*d, 4),
            say::percent(d / radius),
        ]);
    }
    say::data(&table.to_string());
    let scattered = |s| format!("{} m, {}", say::significant(s, 4), say::percent(s / radius));
    say::pairs(&[
        ("mean of", format!("{} shapes, degree {}", shapes.len(), mean.coefficients.lmax())),
        ("mean radius", format!("{} m", say::significant(radius, 7))),
        ("scatter", scatter.map_or("needs two shapes of equal weight".into(), scattered)),
        ("written", verb.output.display().to_string()),
    ]);
    Ok(Code::Done)
}

fn weights(verb: &Mean, count: usize) -> Result<Vec<f64>> {
    match &verb.weights {
        Some(weights) if weights.len() != count => Err(Error::Parameter(format!(
            "{count} shapes need {count} weights, found {}",
            weights.len()
        ))),
        Some(weights) => Ok(weights.clone()),
        None => Ok(vec![1.0; count]),
    }
}

/// Returns the radial RMS distance of two series.
fn distance(a: &Coefficients, b: &Coefficients) -> f64 {
    let powers = Spectrum::of(&difference(a, b));
    powers.degrees().iter().map(|d| d.power).sum::<f64>().sqrt()
}
