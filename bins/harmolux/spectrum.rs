//! `harmolux spectrum`: how much of a shape each degree carries.

use std::path::PathBuf;

use clap::Args;
use harmolux::Result;
use harmolux::error::shown;
use harmolux::io::coefficients::NamedShape;
use harmolux::io::output::Stage;
use harmolux::io::tables::{Cell, Table};
use harmolux::plots::{Axis, Curve, Figure};
use harmolux::sh;

use crate::common::exit::Code;
use crate::common::flags::SeriesReading;
use crate::common::inputs::read_shapes;
use crate::common::target::{Target, write_all};
use crate::common::{plot, say};

/// Show the power per degree of shapes
///
/// The power of degree l is the mean of f_l^2 over the sphere, what pyshtools calls power per
/// degree. What remains above l is the RMS error of cutting the series there. Several shapes are
/// plotted over each other.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux spectrum head.txt
  harmolux spectrum head.txt --plot
  harmolux spectrum head.txt rock.txt -o spectra.svg
  harmolux spectrum *.txt -o spectra.csv")]
pub(crate) struct Spectrum {
    /// Coefficient files, or tables with a row for each shape
    #[arg(required = true, value_name = "SHAPE")]
    pub(crate) shapes: Vec<PathBuf>,
    /// Write a table (.csv) or a plot (.svg, .png); may be repeated
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
    /// Plot in the terminal
    #[arg(long)]
    pub(crate) plot: bool,
    #[command(flatten)]
    pub(crate) reading: SeriesReading,
    /// Replace files that are there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// A shape by its name.
struct Named {
    name: String,
    spectrum: sh::Spectrum,
}

/// Runs the verb.
pub(crate) fn run(verb: &Spectrum, as_json: bool) -> Result<Code> {
    let mut table = Table::new(["shape", "degree", "power_m2", "amplitude_m", "remainder_m"]);
    let targets = verb.output.iter().map(|path| Target::open(path, &table, verb.force));
    let targets: Vec<Target> = targets.collect::<Result<_>>()?;
    let shapes = named(&read_shapes(&verb.shapes, &verb.reading.options())?);
    for shape in &shapes {
        shape.fill(&mut table);
    }
    let figure = figure(&shapes);
    let write = |target: Target| target.write(&table, &figure, Stage::Complete);
    let written = write_all(targets.into_iter().map(write));
    if as_json {
        say::raw(String::from_utf8_lossy(&table.to_json()?).trim_end());
    } else if verb.plot {
        plot::print(&figure)?;
    } else {
        report(&shapes);
    }
    written?;
    for path in &verb.output {
        say::note(&format!("written {}", path.display()));
    }
    Ok(Code::Done)
}

impl Named {
    fn fill(&self, table: &mut Table) {
        for degree in self.spectrum.degrees() {
            table.push([
                Cell::from(self.name.as_str()),
                Cell::from(degree.degree),
                Cell::from(degree.power),
                Cell::from(degree.amplitude),
                Cell::from(degree.remainder),
            ]);
        }
    }
}

/// Takes the spectra; shapes are called by their whole path where their names are the same.
fn named(shapes: &[NamedShape]) -> Vec<Named> {
    let names: Vec<String> = shapes.iter().map(NamedShape::name).collect();
    let name = |shape: &NamedShape, name: &String| {
        let is_double = names.iter().filter(|other| *other == name).count() > 1;
        if is_double { shape.full_name().display().to_string() } else { name.clone() }
    };
    let spectrum = |shape: &NamedShape| sh::Spectrum::of(&shape.shape.coefficients);
    let one = |(s, n)| Named { name: name(s, n), spectrum: spectrum(s) };
    shapes.iter().zip(&names).map(one).collect()
}

fn figure(shapes: &[Named]) -> Figure {
    let curve = |shape: &Named| {
        let points = shape.spectrum.degrees().iter().skip(1);
        Curve::new(&shape.name, points.map(|d| [d.degree as f64, d.power]).collect())
    };
    let axes = [Axis::logarithmic("degree l"), Axis::logarithmic("power, m\u{b2}")];
    Figure::new("Power per degree", axes, shapes.iter().map(curve).collect())
}

fn report(shapes: &[Named]) {
    if let [shape] = shapes {
        return report_one(shape);
    }
    let names: Vec<String> = shapes.iter().map(|shape| shown(&shape.name)).collect();
    let header: Vec<&str> =
        std::iter::once("degree").chain(names.iter().map(String::as_str)).collect();
    let mut table = say::table(&header);
    let highest = shapes.iter().map(|s| s.spectrum.degrees().len()).max().unwrap_or(0);
    for l in 0..highest {
        let power = |shape: &Named| {
            shape.spectrum.degrees().get(l).map_or(String::new(), |d| format!("{:.4e}", d.power))
        };
        table.add_row(std::iter::once(l.to_string()).chain(shapes.iter().map(power)));
    }
    say::data(&table.to_string());
    say::note("power per degree, m2");
}

fn report_one(shape: &Named) {
    let mut table =
        say::table(&["degree", "power, m2", "amplitude, m", "remains above, m", "of the mean"]);
    let mean = shape.spectrum.degrees().first().map_or(f64::NAN, |d| d.amplitude);
    for degree in shape.spectrum.degrees() {
        table.add_row([
            degree.degree.to_string(),
            format!("{:.4e}", degree.power),
            say::significant(degree.amplitude, 4),
            say::significant(degree.remainder, 4),
            say::percent(degree.remainder / mean),
        ]);
    }
    say::data(&table.to_string());
}
