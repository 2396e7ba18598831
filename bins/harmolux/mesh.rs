//! `harmolux mesh`: coefficients become a mesh.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use harmolux::Result;
use harmolux::error::shown_path;
use harmolux::fit::{Resolution, Shape, Tessellation, tessellate};
use harmolux::io::coefficients;
use harmolux::io::meshes::{MeshFormat, encode};
use harmolux::io::output::Output;
use harmolux::sh::volume;
use serde_json::{Value, json};

use crate::common::about::about;
use crate::common::exit::Code;
use crate::common::flags::SeriesReading;
use crate::common::progress::{self, Meter};
use crate::common::values::{length, size};
use crate::common::{folders, paths, say};

/// Turn coefficients into a mesh
///
/// The mesh is closed, its faces look outward, and its vertices are on the surface. Without a
/// choice it is refined until the surface is within a thousandth of the mean radius of the faces.
/// Each row of a table of shapes becomes an OBJ mesh in a folder.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux mesh head.txt -o head.ply                      to a thousandth of the mean radius
  harmolux mesh head.txt -o head.stl --tolerance 0.1mm
  harmolux mesh head.txt -o head.obj --resolution 64      81 920 faces of nearly one size
  harmolux mesh head.txt -o head.obj --lat-long 90x180 -l 16
  harmolux mesh rocks.csv -o rocks                        rocks/NAME.obj for each row")]
pub(crate) struct Mesh {
    /// Coefficients, or a table with a row for each shape
    pub(crate) shape: PathBuf,
    /// Where to write the mesh: .obj, .ply or .stl; of each row of a table a folder, made when it is
    /// not there
    #[arg(short, long, value_name = "FILE|DIR")]
    pub(crate) output: PathBuf,
    /// Cut each edge of an icosahedron into N: 20 N^2 faces
    #[arg(
        long, value_name = "N", group = "how", value_parser = clap::value_parser!(u32).range(1..)
    )]
    pub(crate) resolution: Option<u32>,
    /// N bands from pole to pole, M azimuths around
    #[arg(long, value_name = "NxM", group = "how", value_parser = size)]
    pub(crate) lat_long: Option<[u32; 2]>,
    /// How far the surface may be from the faces: a length (0.1mm), or a share of the mean radius
    /// (1e-3)
    #[arg(long, value_name = "ERROR", group = "how", value_parser = tolerance)]
    pub(crate) tolerance: Option<Tolerance>,
    /// Cut the series at this degree first
    #[arg(
        short = 'l', long = "degree", value_name = "LMAX",
        value_parser = clap::value_parser!(u32).range(0..=1400)
    )]
    pub(crate) degree: Option<u32>,
    #[command(flatten)]
    pub(crate) reading: SeriesReading,
    /// Replace a file that is there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// How far the surface may be from the faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Tolerance {
    /// A length, metres.
    Length(f64),
    /// A share of the mean radius.
    Relative(f64),
}

/// What is reached when nothing is asked for.
const DEFAULT: Tolerance = Tolerance::Relative(1e-3);

/// Reads a value of the command line: with a unit a length, without one a share.
fn tolerance(text: &str) -> std::result::Result<Tolerance, String> {
    let value = length(text).map_err(|_| {
        "write a positive length with its unit, such as 0.1mm, or a share of the mean radius, \
         such as 1e-3"
    })?;
    let has_unit = text.ends_with(|c: char| c.is_ascii_alphabetic());
    Ok(if has_unit { Tolerance::Length(value) } else { Tolerance::Relative(value) })
}

impl Tolerance {
    fn metres(self, mean_radius: f64) -> f64 {
        match self {
            Self::Length(metres) => metres,
            // A radius that is negative or zero in the mean is refused where it is met, not here.
            Self::Relative(share) => (share * mean_radius.abs()).max(f64::MIN_POSITIVE),
        }
    }
}

/// What a series became.
struct Made {
    tessellation: Tessellation,
    volume: f64,
    mean_radius: f64,
}

/// Runs the verb.
pub(crate) fn run(verb: &Mesh, as_json: bool) -> Result<Code> {
    let started = Instant::now();
    if folders::is_folder(&verb.output) {
        folders::within(&verb.output, || make_all(verb, as_json))?;
    } else {
        make_one(verb, as_json)?;
    }
    if !as_json {
        say::note(&format!("written in {}", progress::duration(started.elapsed())));
    }
    Ok(Code::Done)
}

fn make_one(verb: &Mesh, as_json: bool) -> Result<()> {
    let format = MeshFormat::for_writing(&verb.output)?;
    let output = Output::open(&verb.output, &format.kind(), verb.force)?;
    let shape = coefficients::read(&verb.shape, &verb.reading.options())?;
    let meter = Meter::start("making the mesh");
    let made = make(verb, &shape, &verb.shape)?;
    output.write(&encode(&made.tessellation.mesh, format)?)?;
    drop(meter);
    if as_json {
        say::json(&value(&made, &verb.output));
    } else {
        report(verb, &made);
    }
    Ok(())
}

/// Makes a mesh of each row; when one fails, those before it stand.
fn make_all(verb: &Mesh, as_json: bool) -> Result<()> {
    let shapes = coefficients::read_all(&verb.shape, &verb.reading.options())?;
    let files = folders::files(&verb.output, &shapes, "obj")?;
    let open = |path: &Path| Output::open(path, &MeshFormat::Obj.kind(), verb.force);
    files.iter().try_for_each(|path| open(path).map(drop))?;
    let meter = Meter::start("making the meshes");
    let mut table = say::table(&["shape", "vertices", "faces", "chord error, m", "volume, m3"]);
    let mut values = Vec::new();
    for (i, (shape, path)) in shapes.iter().zip(&files).enumerate() {
        let (output, name) = (open(path)?, shape.full_name());
        let made = make(verb, &shape.shape, &name)?;
        let Tessellation { mesh, chord_error } = &made.tessellation;
        output.write(&encode(mesh, MeshFormat::Obj)?)?;
        table.add_row([
            shown_path(&name),
            mesh.positions().len().to_string(),
            mesh.triangles().len().to_string(),
            say::significant(chord_error.measured, 3),
            say::significant(mesh.volume(), 7),
        ]);
        values.push(value(&made, path));
        meter.count(i + 1, shapes.len(), &shown_path(&name));
    }
    drop(meter);
    if as_json {
        let mut value = json!({ "meshes": values });
        paths::put(&mut value, "written", &verb.output);
        say::json(&value);
    } else {
        say::data(&table.to_string());
    }
    Ok(())
}

fn make(verb: &Mesh, shape: &Shape, name: &Path) -> Result<Made> {
    let shape = verb.degree.map_or(shape.clone(), |l| shape.truncated(l as usize));
    let f = &shape.coefficients;
    let mean_radius = f.mean();
    let tessellation =
        tessellate(f, shape.centre, resolution(verb, mean_radius)).map_err(|e| about(name, e))?;
    Ok(Made { tessellation, volume: volume(f)?, mean_radius })
}

fn resolution(verb: &Mesh, mean_radius: f64) -> Resolution {
    if let Some(n) = verb.resolution {
        return Resolution::Icosphere { frequency: n as usize };
    }
    if let Some([bands, azimuths]) = verb.lat_long {
        return Resolution::LatLong { bands: bands as usize, azimuths: azimuths as usize };
    }
    Resolution::Adaptive { tolerance: verb.tolerance.unwrap_or(DEFAULT).metres(mean_radius) }
}

fn value(Made { tessellation: made, volume, .. }: &Made, written: &Path) -> Value {
    let mut value = json!({
        "vertices": made.mesh.positions().len(),
        "faces": made.mesh.triangles().len(),
        "chord_error": made.chord_error.measured,
        "chord_error_bound": made.chord_error.bound,
        "volume": made.mesh.volume(),
        "series_volume": volume,
    });
    paths::put(&mut value, "written", written);
    value
}

fn report(verb: &Mesh, Made { tessellation: made, volume, mean_radius }: &Made) {
    let error = made.chord_error;
    let bound = error.bound.map_or(String::new(), |bound| {
        format!(", certainly not above {} m", say::significant(bound, 3))
    });
    let inside = made.mesh.volume();
    say::pairs(&[
        ("vertices", made.mesh.positions().len().to_string()),
        ("faces", made.mesh.triangles().len().to_string()),
        (
            "chord error",
            format!(
                "{} m at the samples of each face, {} of the mean radius{bound}",
                say::significant(error.measured, 3),
                say::percent(error.measured / mean_radius)
            ),
        ),
        (
            "volume",
            format!(
                "{} m3, that of the series times {}",
                say::significant(inside, 7),
                say::significant(inside / volume, 7)
            ),
        ),
        ("written", verb.output.display().to_string()),
    ]);
}
