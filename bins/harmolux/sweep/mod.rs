//! `harmolux sweep`: what each truncation degree costs and buys.

mod lines;
mod pages;
mod report;

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use harmolux::error::shown_path;
use harmolux::fit::Shape;
use harmolux::io::input::FilesRead;
use harmolux::io::scene_file::{ObjectSpec, SceneFile};
use harmolux::study::{Light, LightSettings, Original, Sweep as Swept, SweepLimit, SweepRow};
use harmolux::{Error, Result};

use self::lines::Run;
use crate::common::about::about;
use crate::common::exit::Code;
use crate::common::flags::{FitHabits, MeshHabits, SeriesHabits};
use crate::common::folders::within;
use crate::common::growing::{GrowingTable, KEY, key};
use crate::common::idle;
use crate::common::inputs::files;
use crate::common::progress::Meter;
use crate::common::scenes::read_scene;
use crate::common::subject::Read;
use crate::common::values::{Degrees, degrees, size};

/// Measure what each degree costs and buys, beside the mesh
///
/// For each degree: errors of the shape, bytes as files and as traced, times, and the mesh
/// decimated to as many bytes; with --scene also its picture and illuminances. Writes index.html, a
/// page with all of it that stands for itself, sweep.csv, plots (SVG and PNG), the coefficients and
/// pictures of each degree. A run that was ended goes on when it is started again; --force begins
/// anew.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux sweep head.obj -l 4,8,16,32,64 -o out
  harmolux sweep head.obj -l 2..64 --scene room.toml -o out
  harmolux sweep head.obj -l 2..64 -o out --tolerance rms=0.5%,hausdorff=2mm
  harmolux sweep head.txt -l 2..16 -o out             a series cut at each degree")]
pub(crate) struct Sweep {
    /// The mesh (OBJ, PLY, STL, OFF or glTF), or a coefficient file
    #[arg(value_name = "MESH")]
    pub(crate) shape: PathBuf,
    /// The degrees: 4,8,16 or 2..64
    #[arg(short = 'l', long = "degrees", value_name = "LIST", value_parser = degrees)]
    pub(crate) degrees: Degrees,
    /// The folder to write to; made when it is not there
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Say which degree is enough: limits of rms, max, hausdorff, normal, volume, area, inertia,
    /// relmse, flip or lux, such as rms=0.5%,hausdorff=2mm,normal=3deg; without a unit a share of 1,
    /// metres or degrees; exit code 4 when no degree keeps one
    #[arg(
        long, value_name = "LIMITS", value_delimiter = ',',
        value_parser = |text: &str| text.parse::<SweepLimit>().map_err(|e| e.to_string())
    )]
    pub(crate) tolerance: Vec<SweepLimit>,
    /// Put each degree into this scene, which has the mesh as an SH object, and take its picture
    /// and illuminances
    #[arg(long, value_name = "SCENE.toml")]
    pub(crate) scene: Option<PathBuf>,
    /// Set a key of the scene; may be repeated
    #[arg(short = 'D', value_name = "KEY=VALUE", requires = "scene")]
    pub(crate) define: Vec<String>,
    /// The number of pixels of the pictures [default: the camera's, 200 columns at most]
    #[arg(long, value_name = "WxH", value_parser = size, requires = "scene")]
    pub(crate) size: Option<[u32; 2]>,
    /// The eye rays of each pixel
    #[arg(
        long, value_name = "N", default_value_t = 16, requires = "scene",
        value_parser = clap::value_parser!(u32).range(2..=65_536)
    )]
    pub(crate) samples: u32,
    #[command(flatten)]
    pub(crate) shaping: FitHabits,
    #[command(flatten)]
    pub(crate) habits: MeshHabits,
    #[command(flatten)]
    pub(crate) series: SeriesHabits,
    /// Replace files that are there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// Runs the verb; a folder made for it does not stay behind empty when it fails.
pub(crate) fn run(verb: &Sweep, as_json: bool) -> Result<Code> {
    within(&verb.output, || measure(verb, as_json))
}

fn measure(verb: &Sweep, as_json: bool) -> Result<Code> {
    let meter = Meter::start("reading the shape");
    let scene = verb.scene.as_deref().map(|path| read_scene(path, &verb.define)).transpose()?;
    report::check_limits(verb, scene.as_ref())?;
    let path = verb.output.join("sweep.csv");
    let table = GrowingTable::open(&path, SweepRow::table(&[KEY]), verb.force)?;
    let (original, files) = original(verb)?;
    let said = (&verb.habits, &verb.shaping, &verb.series);
    let in_scene = scene.as_ref().map(scene_key).transpose()?;
    let in_scene = in_scene.map(|scene| (scene, verb.size, verb.samples));
    let key = key(&files, &(said, in_scene));
    let outputs = pages::Outputs::open(verb)?;
    let mut run = Run::new(verb, table, key, &original, scene)?;
    if run.is_complete() {
        meter.stage("reading what is there");
    } else {
        meter.stage("making the shape ready");
        let swept = Swept::new(&original, verb.shaping.settings(0));
        let swept = swept.map_err(|e| about(&verb.shape, e))?;
        run.measure(&swept, &meter)?;
    }
    meter.stage("drawing");
    let (table, rows) = run.finish()?;
    let answers = report::answers(&verb.tolerance, &rows);
    outputs.write(verb, &original, (&table, &rows), &answers)?;
    drop(meter);
    report::print(verb, &table, &rows, &answers, as_json)?;
    Ok(report::code(&answers))
}

/// Reads what is swept.
fn original(verb: &Sweep) -> Result<(Original, FilesRead)> {
    let (read, files) = Read::open(&verb.shape, &verb.series, &verb.habits)?;
    let name = shown_path(&verb.shape);
    Ok(match read {
        Read::Mesh(mesh) => {
            idle::refuse(&format!("{name}: this is a mesh"), &verb.series.given())?;
            (Original::Mesh(mesh, Some(files.file.source())), files)
        }
        Read::Series(shape) => {
            let why = format!("{name}: these are coefficients, not a mesh");
            idle::refuse(&why, &verb.habits.given())?;
            idle::refuse(&why, &verb.shaping.given())?;
            check_degrees(verb, &shape)?;
            (Original::Series(shape), files)
        }
    })
}

fn check_degrees(verb: &Sweep, shape: &Shape) -> Result<()> {
    let highest = shape.coefficients.lmax();
    match verb.degrees.0.last() {
        Some(last) if *last > highest => Err(Error::Parameter(format!(
            "{}: the file has no degree above {highest}: write `-l` with none above it, not {last}",
            verb.shape.display()
        ))),
        _ => Ok(()),
    }
}

/// Returns what tells a scene from another: all that it says, overrides too, and its files.
fn scene_key(scene: &SceneFile) -> Result<String> {
    let mut key = format!("{:?}", scene.source.values(&[]));
    for file in scene.objects.values().filter_map(ObjectSpec::file) {
        let read = files(&file.resolved)?;
        let _ = write!(key, " {}", read.file);
    }
    Ok(key)
}

/// Makes the scene ready, its original looked at.
fn light(verb: &Sweep, scene: SceneFile, original: &Original) -> Result<Light> {
    let settings = LightSettings {
        size: verb.size,
        samples: verb.samples,
        unit: verb.habits.unit,
        up: verb.habits.up,
    };
    let path = verb.scene.as_deref().unwrap_or(&verb.shape);
    Light::new(scene, &verb.shape, original, settings).map_err(|e| about(path, e))
}
