//! `harmolux fit`: a mesh becomes coefficients.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use glam::DVec3;
use harmolux::io::coefficients::{Shape, Source, shtools_text};
use harmolux::io::meshes;
use harmolux::io::output::{Kind, Output};
use harmolux::sh::Convention;
use harmolux::study::{FitSettings, Projection, fit, mesh_bytes, series_bytes};
use harmolux::surface::{Mesh, RepairReport, UpAxis};
use harmolux::{Error, Result};
use serde_json::json;

use super::arguments::{MeshHabits, UpName, point};
use super::exit::Code;
use super::{progress, say};

/// Turn a star-shaped mesh into spherical-harmonic coefficients
///
/// The file is text as pyshtools reads it (4pi normalisation, no Condon-Shortley phase), metres, z up.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux fit head.obj -l 32 -o head.txt
  harmolux fit bone.obj -l 64 -o bone.txt --unit mm --up y
  harmolux fit rock.obj -l 16 -o rock.txt --centre 0.1,0,0.2")]
pub(crate) struct Fit {
    /// The mesh (OBJ): closed, and star-shaped about some point
    pub(crate) mesh: PathBuf,
    /// The truncation degree lmax: (lmax + 1)^2 coefficients
    #[arg(short = 'l', long = "degree", value_name = "LMAX", value_parser = clap::value_parser!(u32).range(0..=1400))]
    pub(crate) degree: u32,
    /// Where to write the coefficients
    #[arg(short, long, value_name = "FILE.txt")]
    pub(crate) output: PathBuf,
    /// How the mesh is projected onto the basis
    #[arg(long, value_enum, default_value_t)]
    pub(crate) projection: ProjectionName,
    /// How much finer the grid is than the degree needs (with --projection grid)
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub(crate) oversampling: u32,
    /// The expansion centre, metres [default: the origin if the mesh is star-shaped about it, else the best centre]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub(crate) centre: Option<DVec3>,
    #[command(flatten)]
    pub(crate) habits: MeshHabits,
    /// Replace a file that another program wrote
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub(crate) enum ProjectionName {
    /// Quadrature on the faces: exact to about 1e-10
    #[default]
    Conforming,
    /// Ray casting on an oversampled Gauss-Legendre grid and FFT
    Grid,
}

/// Runs the verb.
pub(crate) fn run(verb: &Fit, as_json: bool) -> Result<Code> {
    let started = Instant::now();
    let output = Output::open(&verb.output, &Kind::COEFFICIENTS, verb.force)?;
    let mesh = read_mesh(&verb.mesh, &verb.habits)?;
    let projection = match verb.projection {
        ProjectionName::Conforming => Projection::Conforming,
        ProjectionName::Grid => Projection::Grid { oversampling: verb.oversampling as usize },
    };
    let settings = FitSettings { lmax: verb.degree as usize, projection, centre: verb.centre };
    let fit = fit(&mesh, &settings).map_err(|e| about(&verb.mesh, e))?;
    let shape = Shape {
        coefficients: fit.coefficients.clone(),
        centre: fit.centre,
        source: Some(source(&verb.mesh)?),
        truncated_from: None,
    };
    output.write(&shtools_text::write(&shape, Convention::default())?)?;
    let lmax = fit.coefficients.lmax();
    if as_json {
        say::data(
            &json!({
                "degree": lmax,
                "coefficients": fit.coefficients.count(),
                "bytes": series_bytes(lmax),
                "mesh_bytes": mesh_bytes(fit.mesh_size),
                "centre": fit.centre.to_array(),
                "clearance": fit.clearance,
                "mean_radius": fit.coefficients.mean(),
                "rms": fit.error.rms,
                "max": fit.error.max,
                "projection_seconds": fit.projection_time.as_secs_f64(),
                "seconds": started.elapsed().as_secs_f64(),
                "written": verb.output,
            })
            .to_string(),
        );
        return Ok(Code::Done);
    }
    let [x, y, z] = fit.centre.to_array().map(|v| say::significant(v, 4));
    say::pairs(&[
        ("degree", format!("{lmax}, {} coefficients", fit.coefficients.count())),
        (
            "storage",
            format!(
                "{} in f32 against {} of the mesh ({} vertices, {} faces)",
                say::bytes(series_bytes(lmax)),
                say::bytes(mesh_bytes(fit.mesh_size)),
                fit.mesh_size[0],
                fit.mesh_size[1]
            ),
        ),
        (
            "centre",
            format!(
                "({x}, {y}, {z}) m, every face clears it by {} m",
                say::significant(fit.clearance, 3)
            ),
        ),
        ("mean radius", format!("{} m", say::significant(fit.coefficients.mean(), 7))),
        (
            "RMS error",
            format!(
                "{} m, {}",
                say::significant(fit.error.rms, 3),
                say::percent(fit.relative_rms())
            ),
        ),
        (
            "largest error",
            format!(
                "{} m, {}",
                say::significant(fit.error.max, 3),
                say::percent(fit.relative_max())
            ),
        ),
        (
            "time",
            format!(
                "{} in all, projection {:.0} ms",
                progress::duration(started.elapsed()),
                1e3 * fit.projection_time.as_secs_f64()
            ),
        ),
        ("written", verb.output.display().to_string()),
    ]);
    Ok(Code::Done)
}

/// Reads a mesh, turns it to metres, z up, and repairs it if asked to.
pub(crate) fn read_mesh(path: &Path, habits: &MeshHabits) -> Result<Mesh> {
    Ok(read_and_repair(path, habits)?.0)
}

/// As [`read_mesh`], with what was repaired.
pub(crate) fn read_and_repair(
    path: &Path,
    habits: &MeshHabits,
) -> Result<(Mesh, Option<RepairReport>)> {
    let mesh = meshes::read(path)?;
    let up = match habits.up {
        UpName::X => UpAxis::X,
        UpName::Y => UpAxis::Y,
        UpName::Z => UpAxis::Z,
    };
    habits.repairs.apply(path, mesh.with_up(up).scaled(habits.unit.metres())?)
}

/// Names a file by its name and content.
pub(crate) fn source(path: &Path) -> Result<Source> {
    let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
    Ok(Source::new(path, &bytes))
}

/// Puts the file before what is wrong with what it holds.
pub(crate) fn about(path: &Path, error: Error) -> Error {
    let name = path.display();
    match error {
        Error::Geometry(text) => Error::Geometry(format!("{name}: {text}")),
        Error::Parameter(text) => Error::Parameter(format!("{name}: {text}")),
        Error::Numeric(text) => Error::Numeric(format!("{name}: {text}")),
        other => other,
    }
}
