//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use glam::DVec3;

/// Spherical-harmonic shapes, and light in rooms by Monte Carlo local estimates.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, arg_required_else_help = true, after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) verb: Verb,
    /// Use this many threads instead of one per core; results do not depend on it
    #[arg(short = 'j', long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Print the result as JSON on stdout
    #[arg(long, global = true)]
    pub(crate) json: bool,
}

const EXAMPLES: &str = "\
Examples:
  harmolux render data/scenes/head_room.toml             a picture: head_room.png and head_room.exr
  harmolux illum data/scenes/head_room.toml              lux at the scene's sensors, each with its interval
  harmolux fit data/head.obj -l 32 -o head.txt           a mesh becomes 1089 coefficients
  harmolux info head.txt                                 what a file holds
  harmolux sweep data/head.obj -l 4,8,16,32,64 -o out    what each degree costs and buys

Exit codes: 0 done, 1 failed, 2 wrong command line, 3 bad input, 4 target error not met, 130 interrupted (after saving).";

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    Render(Render),
    Illum(Illum),
    Fit(Fit),
    Info(Info),
    Sweep(Sweep),
}

/// What verbs that run a scene have in common
#[derive(Debug, Args)]
pub(crate) struct SceneArguments {
    /// The scene file (TOML)
    pub(crate) scene: PathBuf,
    /// Set a key of the scene, such as lights.lamp.point.intensity=250; may be repeated
    #[arg(short = 'D', value_name = "KEY=VALUE")]
    pub(crate) define: Vec<String>,
    /// The seed: the same seed gives the same bytes
    #[arg(long)]
    pub(crate) seed: Option<u64>,
    /// A fast look: a tenth of the walks (and a quarter of the pixels)
    #[arg(long)]
    pub(crate) quick: bool,
    /// Replace output files that another program wrote
    #[arg(long)]
    pub(crate) force: bool,
}

/// Render the luminance, cd/m2, that a camera sees
///
/// Writes a PNG to look at and an EXR with the measured values: R, G, B, luminance Y and its standard error stderr.Y.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux render room.toml                          room.png and room.exr, here
  harmolux render room.toml -o out/a.png --quick     only a small PNG, fast
  harmolux render room.toml -D render.stop.time=30s  stop after half a minute
  harmolux render room.toml -D render.estimator=path the reference estimator")]
pub(crate) struct Render {
    #[command(flatten)]
    pub(crate) common: SceneArguments,
    /// Where to write: FILE.png or FILE.exr; may be repeated [default: the scene's name, both kinds, in this folder]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
    /// The number of pixels, such as 320x240
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(crate) size: Option<[u32; 2]>,
}

/// Measure illuminance, lx, at the sensors of a scene
///
/// Each value comes with its 95 % interval and the part that arrives directly; each group of sensors with mean, least, largest and U0 = least / mean.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux illum room.toml                               a table
  harmolux illum room.toml -o lux.csv                    the same as CSV
  harmolux illum room.toml -D illum.stop.relative_error=0.001")]
pub(crate) struct Illum {
    #[command(flatten)]
    pub(crate) common: SceneArguments,
    /// Write the values of all sensors as CSV
    #[arg(short, long, value_name = "FILE.csv")]
    pub(crate) output: Option<PathBuf>,
}

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

/// How the numbers of a mesh file are meant
#[derive(Debug, Args)]
pub(crate) struct MeshHabits {
    /// The unit of the mesh file
    #[arg(long, value_enum, default_value_t)]
    pub(crate) unit: UnitName,
    /// The axis of the mesh file that points up
    #[arg(long, value_enum, default_value_t)]
    pub(crate) up: UpName,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub(crate) enum ProjectionName {
    /// Quadrature on the faces: exact to about 1e-10
    #[default]
    Conforming,
    /// Ray casting on an oversampled Gauss-Legendre grid and FFT
    Grid,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub(crate) enum UnitName {
    #[default]
    M,
    Cm,
    Mm,
    In,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub(crate) enum UpName {
    X,
    Y,
    #[default]
    Z,
}

/// Say what a mesh or coefficient file holds
#[derive(Debug, Args)]
pub(crate) struct Info {
    /// A mesh (OBJ) or coefficients (pyshtools text)
    pub(crate) file: PathBuf,
    /// The normalisation of a coefficient file that does not state it: 4pi, ortho, schmidt or unnorm
    #[arg(long)]
    pub(crate) normalisation: Option<harmolux::sh::Normalisation>,
    /// The phase of a coefficient file that does not state it: 1 without, -1 with Condon-Shortley
    #[arg(long, allow_hyphen_values = true, requires = "normalisation")]
    pub(crate) csphase: Option<harmolux::sh::CondonShortley>,
}

/// Measure what each truncation degree costs and buys, beside the mesh itself
///
/// For each degree: bytes, RMS and largest radial error, time to fit, time to trace a ray. Writes sweep.csv and the coefficients of each degree.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux sweep head.obj -l 4,8,16,32,64 -o out
  harmolux sweep head.obj -l 2..16 -o out --json")]
pub(crate) struct Sweep {
    /// The mesh (OBJ)
    pub(crate) mesh: PathBuf,
    /// The degrees: 4,8,16 or 2..64
    #[arg(short = 'l', long = "degrees", value_name = "LIST", value_parser = degrees)]
    pub(crate) degrees: Degrees,
    /// The folder to write to; made when it is not there
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) habits: MeshHabits,
    /// Replace files that another program wrote
    #[arg(long)]
    pub(crate) force: bool,
}

/// A list of truncation degrees, ascending.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Degrees(pub(crate) Vec<usize>);

fn size(text: &str) -> Result<[u32; 2], String> {
    let parts = text.split_once(['x', 'X']).map(|(w, h)| (w.parse(), h.parse()));
    match parts {
        Some((Ok(w), Ok(h))) if (1..=65_536).contains(&w) && (1..=65_536).contains(&h) => {
            Ok([w, h])
        }
        _ => Err("write width x height in pixels, each from 1 to 65536, such as 320x240".into()),
    }
}

fn point(text: &str) -> Result<DVec3, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) if [x, y, z].iter().all(|v| v.is_finite()) => Ok(DVec3::new(x, y, z)),
        _ => Err("write three numbers, such as 0.1,0,-0.2".into()),
    }
}

fn degrees(text: &str) -> Result<Degrees, String> {
    let wrong =
        || "write degrees such as 4,8,16 or a range such as 2..64, none above 1400".to_owned();
    let degree =
        |part: &str| part.trim().parse::<usize>().ok().filter(|l| *l <= 1400).ok_or_else(wrong);
    let mut list = Vec::new();
    for part in text.split(',') {
        match part.split_once("..") {
            Some((first, last)) => list.extend(degree(first)?..=degree(last)?),
            None => list.push(degree(part)?),
        }
    }
    list.sort_unstable();
    list.dedup();
    if list.is_empty() { Err(wrong()) } else { Ok(Degrees(list)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn command_line_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn lists_sizes_and_points_are_read() {
        assert_eq!(degrees("8,4,8"), Ok(Degrees(vec![4, 8])));
        assert_eq!(degrees("2..5"), Ok(Degrees(vec![2, 3, 4, 5])));
        assert!(degrees("").is_err() && degrees("5..2").is_err() && degrees("9999").is_err());
        assert_eq!(size("320x240"), Ok([320, 240]));
        assert!(size("0x3").is_err() && size("320").is_err());
        assert_eq!(point("1, -2,0.5"), Ok(DVec3::new(1.0, -2.0, 0.5)));
        assert!(point("1,2").is_err() && point("1,2,nan").is_err());
    }
}
