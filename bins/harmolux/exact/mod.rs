//! `harmolux exact`: problems whose answer is known, as tables.

mod cie171;
mod cube;
mod enclosures;
mod form_factor;
mod sheet;
mod sobolev;

use std::path::PathBuf;

use clap::{Args, Subcommand};
use harmolux::Result;
use harmolux::io::output::Output;
use sheet::Sheet;

use crate::common::exit::Code;
use crate::common::say;

/// Compute problems of light whose answer is known
///
/// Each problem without options is a standard case. Lengths are metres, flux lm, intensity cd;
/// surfaces reflect by Lambert's law.
#[derive(Debug, Args)]
#[command(
    subcommand_value_name = "PROBLEM",
    subcommand_help_heading = "Problems",
    disable_help_subcommand = true,
    after_help = "Examples:
  harmolux exact sobolev                                                   two infinite planes
  harmolux exact sobolev --reflectance 0.8,0.3 --height 0.7 --plane both   each its own
  harmolux exact sobolev --radius 2 -r 0,1,2                               discs in their place
  harmolux exact cube --reflectance 0.5,0.8 --at 0,0                       one point of two cubes
  harmolux exact cie171-5.3 -o area.csv                                    a case of CIE 171
  harmolux exact form-factor perpendicular --common 4 --from 4 --to 3      floor and wall"
)]
pub(crate) struct Exact {
    #[command(subcommand)]
    pub(crate) problem: Problem,
    /// Write the table (.csv)
    #[arg(short, long, global = true, value_name = "FILE.csv", display_order = 800)]
    pub(crate) output: Option<PathBuf>,
    /// Replace an output file that is there already
    #[arg(long, global = true, display_order = 801)]
    pub(crate) force: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Problem {
    Sobolev(sobolev::Sobolev),
    Sphere(enclosures::Sphere),
    Cap(enclosures::Cap),
    Concentric(enclosures::Concentric),
    Planes(enclosures::Planes),
    Room(enclosures::Room),
    Cube(cube::CubeRoom),
    FormFactor(form_factor::FormFactor),
    /// CIE 171, case 5.2: a Lambertian point source of 1000 cd, 3 m over a plane of 4 x 4 m
    ///
    /// E = I0 h^2/(h^2 + x^2 + y^2)^2, at points counted from the foot of the source.
    #[command(name = "cie171-5.2")]
    PointSource,
    /// CIE 171, case 5.3: a source of 1 x 1 m and 1000 cd/m2 in the ceiling of a black room
    ///
    /// The room has 4 x 4 x 3 m; A to F are on the wall y = 0, G to N on the floor. The figures of
    /// the report stand beside the exact values.
    #[command(name = "cie171-5.3")]
    AreaSource,
    #[command(name = "cie171-5.4")]
    FluxConservation(cie171::FluxConservation),
    #[command(name = "cie171-5.5")]
    Glass(cie171::Glass),
    /// CIE 171, case 5.6: light reflected by the floor of a room of 4 x 4 x 3 m
    ///
    /// E/(E_hz rho) in percent, where the floor alone is lit, by E_hz, and reflects; A to E are on
    /// the wall y = 0, G to N on the ceiling.
    #[command(name = "cie171-5.6")]
    Reflection,
    /// CIE 171, case 5.7: light reflected by the wall y = 4 past a black box
    ///
    /// E/(E_v rho) in percent, where that wall alone is lit, by E_v, and reflects; A to F are on
    /// the wall y = 0, G to K on the floor.
    #[command(name = "cie171-5.7")]
    Obstruction,
    #[command(name = "cie171-5.8")]
    Interreflection(cube::Interreflection),
}

impl Problem {
    fn solve(&self) -> Result<Sheet> {
        match self {
            Self::Sobolev(problem) => problem.solve(),
            Self::Sphere(problem) => problem.solve(),
            Self::Cap(problem) => problem.solve(),
            Self::Concentric(problem) => problem.solve(),
            Self::Planes(problem) => problem.solve(),
            Self::Room(problem) => problem.solve(),
            Self::Cube(problem) => problem.solve(),
            Self::FormFactor(problem) => problem.solve(),
            Self::PointSource => Ok(cie171::point_source()),
            Self::AreaSource => Ok(cie171::area_source()),
            Self::FluxConservation(problem) => problem.solve(),
            Self::Glass(problem) => problem.solve(),
            Self::Reflection => Ok(cie171::reflection()),
            Self::Obstruction => Ok(cie171::obstruction()),
            Self::Interreflection(problem) => problem.solve(),
        }
    }
}

/// Runs the verb.
pub(crate) fn run(verb: &Exact, as_json: bool) -> Result<Code> {
    let sheet = verb.problem.solve()?;
    sheet.check()?;
    if let Some(path) = &verb.output {
        let output = Output::open(path, &sheet.table.csv_kind()?, verb.force)?;
        output.write(&sheet.table.to_csv()?)?;
    }
    if as_json {
        say::raw(&sheet.json()?);
    } else {
        say::data(&sheet.text());
    }
    for note in &sheet.notes {
        say::note(note);
    }
    if let Some(path) = &verb.output {
        say::note(&format!("written {}", path.display()));
    }
    Ok(Code::Done)
}
