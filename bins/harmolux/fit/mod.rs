//! `harmolux fit`: meshes and point clouds become coefficients.

mod many;
mod report;
mod rows;

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use harmolux::error::shown_path;
use harmolux::fit::Shape;
use harmolux::fit::{Fit as MeshFit, FitSettings, PointFit, Projection, fit, fit_points};
use harmolux::io::coefficients::{self, SeriesFormat, Tolerance};
use harmolux::io::input::{FilesRead, Input};
use harmolux::io::points::PointOptions;
use harmolux::math::Rotation;
use harmolux::sh::{Coefficients, best_rotation, rotate};
use harmolux::{Error, Result};

use crate::common::about::about;
use crate::common::exit::Code;
use crate::common::flags::{FitHabits, MeshHabits};
use crate::common::folders::is_folder;
use crate::common::idle;
use crate::common::inputs::{MeshRead, holds_points, read_mesh, read_points};
use crate::common::progress::Meter;
use crate::common::shape_file::{self, ShapeFile};
use crate::common::values::tolerance;

/// Turn star-shaped meshes into spherical-harmonic coefficients
///
/// The extension chooses the format: .txt is text as pyshtools reads it (4pi normalisation, no
/// Condon-Shortley phase), .hxc the compact form, see `convert`; metres, z up. Several meshes are
/// fitted into a folder, with one table of all, fits.csv, which grows as they are done: a run that
/// was ended goes on when it is started again; --force begins anew. Points are fitted by least
/// squares, about the origin if it lies within their bounds, else about their mean: x y z a line or
/// columns of these names (.xyz, .pts, .asc, .txt, .csv), PLY without faces, rows of an array
/// (.npy); intensities, colours and normals beside them are passed over.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux fit head.obj -l 32 -o head.txt
  harmolux fit bone.obj -l 64 -o bone.txt --unit mm --up y
  harmolux fit rock.obj -l 16 -o rock.txt --centre 0.1,0,0.2
  harmolux fit ears.obj -l 32 -o ears.txt --not-star outermost
  harmolux fit scan.xyz -l 12 -o scan.txt --lambda 1e-6
  harmolux fit *.obj -l 16 -o fits
  harmolux fit *.obj -l 16 -o fits --table shapes.csv --centre centroid --align-to mean.txt")]
pub(crate) struct Fit {
    /// The meshes (OBJ, PLY, STL, OFF or glTF), closed and star-shaped about some point, or points
    #[arg(required = true, value_name = "MESH")]
    pub(crate) meshes: Vec<PathBuf>,
    /// The truncation degree lmax: (lmax + 1)^2 coefficients
    #[arg(
        short = 'l', long = "degree", value_name = "LMAX",
        value_parser = clap::value_parser!(u32).range(0..=1400)
    )]
    pub(crate) degree: u32,
    /// Where to write the coefficients; of several meshes a folder, made when it is not there
    #[arg(short, long, value_name = "FILE.txt|DIR")]
    pub(crate) output: PathBuf,
    /// How a shape is projected onto the basis [default: conforming; least-squares for points]
    #[arg(long, value_enum)]
    pub(crate) projection: Option<ProjectionName>,
    /// How much finer the grid is than the degree needs, with --projection grid [default: 4]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub(crate) oversampling: Option<u32>,
    /// Damp the Laplacian of a least-squares fit: Tikhonov's factor of l^2 (l+1)^2 [default: 0]
    #[arg(long)]
    pub(crate) lambda: Option<f64>,
    /// Weigh points by their fourth column; one called weight or w counts without this
    #[arg(long)]
    pub(crate) weights: bool,
    /// Turn each shape about its centre by the rotation after which it is nearest to this one, a
    /// coefficient file
    #[arg(long, value_name = "SHAPE")]
    pub(crate) align_to: Option<PathBuf>,
    /// Write the shapes of several meshes into one table, too, a row each; it grows as fits.csv
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) table: Option<PathBuf>,
    /// The columns of that table
    #[arg(
        long, value_name = "LAYOUT", value_enum, default_value_t = TableLayout::Harmolux,
        requires = "table"
    )]
    pub(crate) table_layout: TableLayout,
    /// How far the compact form (.hxc) may be from the fit, RMS: a part of the mean radius, such as
    /// 1e-3, or a length, such as 0.05mm [default: a fifth of the error of the fit]
    #[arg(long, value_name = "TOLERANCE", value_parser = tolerance)]
    pub(crate) tolerance: Option<Tolerance>,
    #[command(flatten)]
    pub(crate) shaping: FitHabits,
    #[command(flatten)]
    pub(crate) habits: MeshHabits,
    /// Replace files that are there already
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProjectionName {
    /// Quadrature on the faces: exact to about 1e-10
    Conforming,
    /// Ray casting on an oversampled Gauss-Legendre grid and FFT
    Grid,
    /// Weighted least squares over points, or the vertices of a mesh
    LeastSquares,
}

/// The layout of a table of shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TableLayout {
    /// name, normalisation (4pi), csphase (1), centre, C0_0_m, C1_0_m, C1_1_m, S1_1_m ...
    Harmolux,
    /// name, shcoeffs_L0M0C ... as aics-shparam has them; the centre has no room
    Aics,
}

/// What was fitted.
#[derive(Debug)]
pub(crate) enum Fitted {
    Mesh(Box<MeshFit>),
    Points(PointFit),
}

/// A fit, and what is said of it.
#[derive(Debug)]
pub(crate) struct Done {
    pub(crate) fitted: Fitted,
    pub(crate) files: FilesRead,
    /// How it was turned, where it was to be aligned.
    pub(crate) turn: Option<Rotation>,
}

/// The shape that others are turned to.
pub(crate) struct Reference {
    pub(crate) shape: Shape,
    pub(crate) files: FilesRead,
}

/// Runs the verb.
pub(crate) fn run(verb: &Fit, as_json: bool) -> Result<Code> {
    let reference = verb.align_to.as_deref().map(reference).transpose()?;
    let reference = reference.as_ref();
    match verb.meshes.as_slice() {
        [mesh] if !is_folder(&verb.output) => run_one(verb, reference, mesh, as_json),
        _ => many::run(verb, reference, as_json),
    }
}

fn reference(path: &Path) -> Result<Reference> {
    let (shape, files) = coefficients::read_as_stated(Input::open(path)?)?;
    Ok(Reference { shape, files })
}

fn run_one(verb: &Fit, reference: Option<&Reference>, mesh: &Path, as_json: bool) -> Result<Code> {
    if verb.table.is_some() {
        let text = "`--table` is for fits into a folder: name one with `-o`, without extension";
        return Err(Error::Parameter(text.to_owned()));
    }
    let started = Instant::now();
    let output = shape_file::open(&verb.output, verb.force)?;
    output.take_tolerance(verb.tolerance)?;
    let meter = Meter::start(&format!("fitting {}", shown_path(mesh)));
    let done = fit_file(verb, reference, mesh)?;
    done.write(verb, output)?;
    drop(meter);
    report::print(verb, &done, started.elapsed(), as_json);
    Ok(Code::Done)
}

/// Fits a mesh or point file, turns the shape as it was asked for, and says what was read.
pub(crate) fn fit_file(verb: &Fit, reference: Option<&Reference>, path: &Path) -> Result<Done> {
    let mut input = Input::open(path)?;
    let (mut fitted, files) = if holds_points(&mut input)? {
        fit_cloud(verb, path, input)
    } else {
        fit_mesh(verb, path, input)
    }?;
    let turn = reference.map(|to| {
        let series = fitted.coefficients_mut();
        let turn = best_rotation(series, &to.shape.coefficients);
        *series = rotate(series, &turn);
        turn
    });
    Ok(Done { fitted, files, turn })
}

fn fit_cloud(verb: &Fit, path: &Path, input: Input) -> Result<(Fitted, FilesRead)> {
    let for_meshes =
        [(verb.shaping.not_star.is_some(), "--not-star"), (verb.habits.repairs.repair, "--repair")];
    idle::refuse(&format!("{}: these are points, not a mesh", shown_path(path)), &for_meshes)?;
    let settings = settings(verb, ProjectionName::LeastSquares)?;
    let (cloud, files) = read_points(input, PointOptions { weights: verb.weights }, &verb.habits)?;
    let fitted = fit_points(&cloud, &settings);
    fitted.map(|f| (Fitted::Points(f), files)).map_err(|e| about(path, e))
}

fn fit_mesh(verb: &Fit, path: &Path, mut input: Input) -> Result<(Fitted, FilesRead)> {
    let length = input.length();
    let series = coefficients::recognise_content(input.ahead()?, length);
    if series.is_some_and(|format| format != SeriesFormat::SpharmPdm) {
        let text = format!(
            "{}: these are coefficients already: `harmolux convert -l` cuts them at a degree",
            path.display()
        );
        return Err(Error::Parameter(text));
    }
    let why = format!("{}: a mesh has no weights", shown_path(path));
    idle::refuse(&why, &[(verb.weights, "--weights")])?;
    let settings = settings(verb, ProjectionName::Conforming)?;
    let MeshRead { mesh, files, .. } = read_mesh(input, &verb.habits)?;
    let fitted = fit(&mesh, &settings);
    fitted.map(|f| (Fitted::Mesh(Box::new(f)), files)).map_err(|e| about(path, e))
}

/// Returns the settings of a fit, by the usual projection unless another is asked for.
fn settings(verb: &Fit, usual: ProjectionName) -> Result<FitSettings> {
    let name = verb.projection.unwrap_or(usual);
    let idle = [
        (name != ProjectionName::Grid && verb.oversampling.is_some(), "--oversampling"),
        (name != ProjectionName::LeastSquares && verb.lambda.is_some(), "--lambda"),
    ];
    idle::refuse("this is for another `--projection` than the one in use", &idle)?;
    let projection = match name {
        ProjectionName::Conforming => Projection::Conforming,
        ProjectionName::Grid => {
            Projection::Grid { oversampling: verb.oversampling.unwrap_or(4) as usize }
        }
        ProjectionName::LeastSquares => {
            Projection::LeastSquares { lambda: verb.lambda.unwrap_or(0.0) }
        }
    };
    Ok(FitSettings { projection, ..verb.shaping.settings(verb.degree as usize) })
}

impl Fitted {
    fn coefficients_mut(&mut self) -> &mut Coefficients {
        match self {
            Self::Mesh(fit) => &mut fit.coefficients,
            Self::Points(fit) => &mut fit.coefficients,
        }
    }
}

impl Done {
    /// Returns the shape as its file has it.
    pub(crate) fn shape(&self) -> Shape {
        let (coefficients, centre) = match &self.fitted {
            Fitted::Mesh(fit) => (fit.coefficients.clone(), fit.centre),
            Fitted::Points(fit) => (fit.coefficients.clone(), fit.centre),
        };
        let source = Some(self.files.file.source());
        Shape { coefficients, centre, source, truncated_from: None }
    }

    /// Writes the coefficients; the compact form, unless told otherwise, to a fifth of the fit's own
    /// error.
    pub(crate) fn write(&self, verb: &Fit, output: ShapeFile) -> Result<()> {
        let rms = match &self.fitted {
            Fitted::Mesh(fit) => fit.error.rms,
            Fitted::Points(fit) => fit.rms,
        };
        output.write_to(&self.shape(), verb.tolerance.unwrap_or(Tolerance::Metres(0.2 * rms)))
    }
}
