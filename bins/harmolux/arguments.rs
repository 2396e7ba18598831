//! The command line: the verbs, each described in its own file, and what several of them have in common.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use glam::DVec3;
use harmolux::io::coefficients::{ReadOptions, SeriesFormat};
use harmolux::sh::{CondonShortley, Convention, Normalisation};

use super::repairs::Repairs;
use super::{check, convert, fit, illum, info, render, sweep};

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
  harmolux check data/head.obj                           closed, oriented, star-shaped?
  harmolux fit data/head.obj -l 32 -o head.txt           a mesh becomes 1089 coefficients
  harmolux info head.txt                                 what a file holds
  harmolux convert head.txt head.bshc                    coefficients in another format
  harmolux sweep data/head.obj -l 4,8,16,32,64 -o out    what each degree costs and buys

Exit codes: 0 done, 1 failed, 2 wrong command line, 3 bad input, 4 requirement or target error not met, 130 interrupted (after saving).";

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    Render(render::Render),
    Illum(illum::Illum),
    Check(check::Check),
    Fit(fit::Fit),
    Info(info::Info),
    Convert(convert::Convert),
    Sweep(sweep::Sweep),
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

/// How the numbers of a mesh file are meant
#[derive(Debug, Args)]
pub(crate) struct MeshHabits {
    /// The unit of the mesh file
    #[arg(long, value_enum, default_value_t)]
    pub(crate) unit: UnitName,
    /// The axis of the mesh file that points up
    #[arg(long, value_enum, default_value_t)]
    pub(crate) up: UpName,
    #[command(flatten)]
    pub(crate) repairs: Repairs,
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub(crate) enum UnitName {
    Km,
    #[default]
    M,
    Cm,
    Mm,
    Um,
    In,
}

impl UnitName {
    /// Gives the length of the unit, metres.
    pub(crate) const fn metres(self) -> f64 {
        match self {
            Self::Km => 1000.0,
            Self::M => 1.0,
            Self::Cm => 0.01,
            Self::Mm => 0.001,
            Self::Um => 1e-6,
            Self::In => 0.0254,
        }
    }
}

#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub(crate) enum UpName {
    X,
    Y,
    #[default]
    Z,
}

/// How a coefficient file that does not say it is meant
#[derive(Debug, Args)]
pub(crate) struct SeriesHabits {
    /// The normalisation of a coefficient file that does not state it: 4pi, ortho, schmidt or unnorm
    #[arg(long)]
    pub(crate) normalisation: Option<Normalisation>,
    /// The phase of a coefficient file that does not state it: 1 without, -1 with Condon-Shortley
    #[arg(long, allow_hyphen_values = true, requires = "normalisation")]
    pub(crate) csphase: Option<CondonShortley>,
}

impl SeriesHabits {
    /// Gives the convention that was stated, if any.
    pub(crate) fn convention(&self) -> Option<Convention> {
        let phase = self.csphase.unwrap_or_default();
        self.normalisation.map(|normalisation| Convention { normalisation, phase })
    }
}

/// How a coefficient file is to be read
#[derive(Debug, Args)]
pub(crate) struct SeriesReading {
    /// The format of the coefficient file [default: told by its content]
    #[arg(long, value_name = "FORMAT", value_parser = formats())]
    pub(crate) from: Option<SeriesFormat>,
    #[command(flatten)]
    pub(crate) habits: SeriesHabits,
    /// The unit of a coefficient file that does not state it [default: m]
    #[arg(long, value_enum)]
    pub(crate) unit: Option<UnitName>,
    /// The row of a table that holds several shapes, counted from 1
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) row: Option<u32>,
}

impl SeriesReading {
    /// Gives what is said of the file.
    pub(crate) fn options(&self) -> ReadOptions {
        ReadOptions {
            format: self.from,
            convention: self.habits.convention(),
            unit: self.unit.map(UnitName::metres),
            row: self.row.map(|row| row as usize),
        }
    }
}

/// Reads the name of a format of coefficients.
pub(crate) fn formats() -> impl TypedValueParser<Value = SeriesFormat> {
    let names = SeriesFormat::ALL.map(SeriesFormat::name);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<SeriesFormat>())
}

/// A list of truncation degrees, ascending.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Degrees(pub(crate) Vec<usize>);

/// Reads a value of the command line.
pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let parts = text.split_once(['x', 'X']).map(|(w, h)| (w.parse(), h.parse()));
    match parts {
        Some((Ok(w), Ok(h))) if (1..=65_536).contains(&w) && (1..=65_536).contains(&h) => {
            Ok([w, h])
        }
        _ => Err("write width x height in pixels, each from 1 to 65536, such as 320x240".into()),
    }
}

/// Reads a value of the command line.
pub(crate) fn point(text: &str) -> Result<DVec3, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) if [x, y, z].iter().all(|v| v.is_finite()) => Ok(DVec3::new(x, y, z)),
        _ => Err("write three numbers, such as 0.1,0,-0.2".into()),
    }
}

/// Reads a value of the command line.
pub(crate) fn degrees(text: &str) -> Result<Degrees, String> {
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
