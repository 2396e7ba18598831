//! `harmolux evaluate`: radius, place and normal of a shape in given directions.

use std::path::{Path, PathBuf};

use clap::Args;
use harmolux::error::shown_path;
use harmolux::fit::{LatLong, SurfacePoint, surface_points};
use harmolux::io::input::Input;
use harmolux::io::output::{Kind, Output};
use harmolux::io::tables::{Cell, Table};
use harmolux::io::{coefficients, directions, npy};
use harmolux::plots::{FalseColour, ScaleOptions};
use harmolux::{Error, Result, memory};

use crate::common::exit::Code;
use crate::common::flags::SeriesReading;
use crate::common::plot::{PlotFormat, unknown_output};
use crate::common::progress::Meter;
use crate::common::say::{self, significant};
use crate::common::shape_file::warn_of_no_surface;
use crate::common::target::write_all;
use crate::common::values::{grid, numbers};

/// Evaluate a shape at latitudes and longitudes
///
/// Directions are seen from the expansion centre: latitude from the plane z = 0 towards +z,
/// longitude from +x towards +y, degrees. A table has the radius, the place in the axes of the file
/// (centre and radius along the direction), both in metres, and the outward unit normal. The radii
/// of a grid are also an array for NumPy, float64 [NLAT, NLON] from north to south, and a map in
/// false colour, a pixel a node: north up, longitude 0 at the left.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux evaluate head.txt --at 0,0 --at 45,-120
  harmolux evaluate head.txt --points landmarks.csv -o surface.csv
  harmolux evaluate head.txt --grid 181x360 -o radius.npy -o map.png
  harmolux evaluate cells.csv --row 7 --unit um --grid 91x180 -o cell.csv")]
pub(crate) struct Evaluate {
    /// Coefficients
    pub(crate) shape: PathBuf,
    #[command(flatten)]
    pub(crate) places: Places,
    /// Write a table (.csv) or, of a grid, an array (.npy) or a map (.png, .svg); may be repeated
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: SeriesReading,
    /// Replace files that are there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// Where the shape is evaluated
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
pub(crate) struct Places {
    /// In this direction, degrees; may be repeated, or several with semicolons between them
    #[arg(
        long, value_name = "LAT,LON", value_parser = lat_long, value_delimiter = ';',
        allow_hyphen_values = true
    )]
    pub(crate) at: Vec<LatLong>,
    /// In the directions of a table with columns called latitude and longitude, or the first two
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) points: Option<PathBuf>,
    /// On NLAT latitudes from 90 to -90 degrees, both poles included, and NLON longitudes from 0
    #[arg(long, value_name = "NLATxNLON", value_parser = grid)]
    pub(crate) grid: Option<[usize; 2]>,
}

/// Reads a value of the command line.
fn lat_long(text: &str) -> std::result::Result<LatLong, String> {
    let [latitude, longitude] = numbers(text)
        .map_err(|_| "write latitude and longitude in degrees, such as 45,-120".to_owned())?;
    LatLong::new(latitude, longitude).map_err(|e| e.to_string())
}

impl Places {
    fn directions(&self) -> Result<Vec<LatLong>> {
        match (&self.points, self.grid) {
            (Some(path), _) => directions::parse(path, &Input::open(path)?.rest()?),
            (None, Some([latitudes, longitudes])) => LatLong::grid(latitudes, longitudes),
            (None, None) => Ok(self.at.clone()),
        }
    }
}

/// The columns of the table.
const COLUMNS: [&str; 9] = [
    "latitude_degrees",
    "longitude_degrees",
    "radius_m",
    "x_m",
    "y_m",
    "z_m",
    "normal_x",
    "normal_y",
    "normal_z",
];

/// What a row of the table and its text take, bytes.
const ROW: usize = 600;

/// A file to write.
enum Target {
    Table(Output),
    Array(Output, [usize; 2]),
    Map(PlotFormat, Output, [usize; 2]),
}

impl Target {
    fn open(path: &Path, verb: &Evaluate) -> Result<Self> {
        let open = |kind: &Kind| Output::open(path, kind, verb.force);
        let has = |wanted| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(wanted));
        if has("csv") {
            return open(&Table::new(COLUMNS).csv_kind()?).map(Self::Table);
        }
        let grid = || {
            verb.places.grid.ok_or_else(|| {
                let path = path.display();
                Error::Parameter(format!(
                    "{path}: an array or a map is of a grid: give `--grid NLATxNLON`, or name a \
                     table, .csv"
                ))
            })
        };
        if has("npy") {
            return Ok(Self::Array(open(&Kind::NPY)?, grid()?));
        }
        match PlotFormat::of_extension(path) {
            Some(format) => Ok(Self::Map(format, open(&format.kind())?, grid()?)),
            None => Err(unknown_output(path, ".csv, .npy, .png or .svg")),
        }
    }

    fn write(self, points: &[SurfacePoint]) -> Result<()> {
        let radii = || points.iter().map(|point| point.radius).collect::<Vec<f64>>();
        match self {
            Self::Table(output) => output.write(&table(points)?.to_csv()?),
            Self::Array(output, [_, width]) => output.write(&npy::rows(width, &radii())),
            Self::Map(PlotFormat::Png, output, size) => {
                output.write(&map(size, radii())?.to_png()?)
            }
            Self::Map(PlotFormat::Svg, output, size) => {
                output.write(map(size, radii())?.to_svg()?.as_bytes())
            }
        }
    }
}

/// Runs the verb.
pub(crate) fn run(verb: &Evaluate, as_json: bool) -> Result<Code> {
    let targets = verb.output.iter().map(|path| Target::open(path, verb));
    let targets: Vec<Target> = targets.collect::<Result<_>>()?;
    let meter = Meter::start(&format!("evaluating {}", shown_path(&verb.shape)));
    let shape = coefficients::read(&verb.shape, &verb.reading.options())?;
    let points = surface_points(&shape, &verb.places.directions()?)?;
    warn_of_no_surface(&verb.shape, &shape)?;
    let written = write_all(targets.into_iter().map(|target| target.write(&points)));
    drop(meter);
    if as_json {
        say::raw(String::from_utf8_lossy(&table(&points)?.to_json()?).trim_end());
    } else if verb.output.is_empty() {
        print(&points);
    } else {
        report(&points);
    }
    written?;
    for path in &verb.output {
        say::note(&format!("written {}", path.display()));
    }
    Ok(Code::Done)
}

fn table(points: &[SurfacePoint]) -> Result<Table> {
    let advice = "evaluate fewer, or write an array, .npy";
    let count = points.len();
    memory::ask_each(count, ROW as f64, format_args!("a table of {count} points"), advice)?;
    let mut table = Table::new(COLUMNS);
    for point in points {
        table.push(row(point).map(Cell::Number));
    }
    Ok(table)
}

fn row(SurfacePoint { at, radius, position, normal }: &SurfacePoint) -> [f64; 9] {
    let ([x, y, z], [u, v, w]) = (position.to_array(), normal.to_array());
    [at.latitude(), at.longitude(), *radius, x, y, z, u, v, w]
}

/// Draws the radii of a grid.
fn map([height, width]: [usize; 2], values: Vec<f64>) -> Result<FalseColour> {
    let scale = ScaleOptions::default().tight().fitted(&values, 1.0)?;
    let (unit, lines) = ("m".to_owned(), true);
    Ok(FalseColour { width, height, values, scale, unit, lines, extremes: true, endless: false })
}

fn print(points: &[SurfacePoint]) {
    let header = ["latitude", "longitude", "radius, m", "x, m", "y, m", "z, m", "normal"];
    let mut table = say::table(&header);
    for point in points {
        let [latitude, longitude, radius, x, y, z, u, v, w] = row(point);
        let lengths = [radius, x, y, z].map(|length| significant(length, 7));
        let normal = format!("{u:.6} {v:.6} {w:.6}");
        let angles = [latitude, longitude].map(|angle| angle.to_string());
        table.add_row(angles.into_iter().chain(lengths).chain([normal]));
    }
    say::data(&table.to_string());
}

/// Says what the radii come to.
fn report(points: &[SurfacePoint]) {
    let by_radius = |a: &&SurfacePoint, b: &&SurfacePoint| a.radius.total_cmp(&b.radius);
    let told = |point: Option<&SurfacePoint>| {
        point.map_or(String::new(), |SurfacePoint { at, radius, .. }| {
            let [a, b] = [at.latitude(), at.longitude()];
            format!("{} m at latitude {a}, longitude {b}", significant(*radius, 7))
        })
    };
    say::pairs(&[
        ("points", points.len().to_string()),
        ("least radius", told(points.iter().min_by(by_radius))),
        ("largest radius", told(points.iter().max_by(by_radius))),
    ]);
}
