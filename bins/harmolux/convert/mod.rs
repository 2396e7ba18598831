//! `harmolux convert`: coefficients from one format to another; meshes are in `convert_mesh.rs`.

mod mesh;

use std::path::PathBuf;

use clap::Args;
use harmolux::error::{InputError, shown};
use harmolux::fit::Shape;
use harmolux::io::coefficients;
use harmolux::io::coefficients::{ReadOptions, SeriesFormat, Tolerance, WriteOptions};
use harmolux::io::input::Input;
use harmolux::io::output::Output;
use harmolux::sh::{CondonShortley, Convention, Normalisation};
use harmolux::{Error, Result};
use serde_json::json;

use crate::common::exit::Code;
use crate::common::flags::{SeriesReading, formats};
use crate::common::inputs::series_format;
use crate::common::paths;
use crate::common::say::{self, point};
use crate::common::shape_file::{take_tolerance, warn_of_no_surface};
use crate::common::values::tolerance;

/// Convert coefficients, or a mesh, between formats
///
/// The format of the input is told by its content, that of the output by its extension (.npy is the
/// array of pyshtools; say `--to alm` for healpy and ducc0). Numbers are written in metres with all
/// their digits. A mesh becomes a mesh (.obj, .ply or .stl); `harmolux fit` and `harmolux mesh` go
/// between the two.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux convert head.txt head.bshc                    for pyshtools: 4pi, csphase 1
  harmolux convert head.txt alm.npy --to alm             for healpy and ducc0
  harmolux convert head.txt head.hxc --tolerance 1e-3    compact, to a thousandth of the mean radius
  harmolux convert skull.coef skull.txt --unit mm        a radial set of SPHARM-PDM
  harmolux convert cells.csv c.txt --row 7 --unit um     one cell of aics-shparam
  harmolux convert topo.bshc topo.txt --normalisation ortho --csphase -1
  harmolux convert head.stl head.ply --unit mm           a mesh, millimetres to metres")]
pub(crate) struct Convert {
    /// The coefficients, or the mesh, to read
    pub(crate) input: PathBuf,
    /// The file to write
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) reading: SeriesReading,
    /// The format to write [default: told by the extension]
    #[arg(long, value_name = "FORMAT", value_parser = formats())]
    pub(crate) to: Option<SeriesFormat>,
    /// The normalisation to write, where the format leaves it open: 4pi, ortho, schmidt or unnorm
    /// [default: 4pi]
    #[arg(long, value_name = "NORMALISATION")]
    pub(crate) to_normalisation: Option<Normalisation>,
    /// The phase to write, where the format leaves it open: 1 without, -1 with Condon-Shortley
    /// [default: 1]
    #[arg(long, value_name = "CSPHASE", allow_hyphen_values = true)]
    pub(crate) to_csphase: Option<CondonShortley>,
    /// Cut the series at this degree
    #[arg(short = 'l', long = "degree", value_name = "LMAX")]
    pub(crate) degree: Option<usize>,
    /// How far the compact form (.hxc) may be from the shape, RMS: a part of the mean radius, or a
    /// length such as 0.05mm [default: 1e-3]
    #[arg(long, value_name = "TOLERANCE", value_parser = tolerance)]
    pub(crate) tolerance: Option<Tolerance>,
    /// Replace a file that is there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// Runs the verb.
pub(crate) fn run(verb: &Convert, as_json: bool) -> Result<Code> {
    if let Some(done) = mesh::run(verb, as_json) {
        return done;
    }
    let format = format(verb)?;
    let convention = convention(verb, format)?;
    take_tolerance(format, verb.tolerance)?;
    let output = Output::open(&verb.output, &format.kind(), verb.force)?;
    let read = read(verb)?;
    let shape = changed(&read.shape, verb);
    let tolerance = verb.tolerance.unwrap_or(WriteOptions::default().tolerance);
    let options = WriteOptions { convention, tolerance };
    let bytes = coefficients::encode(&shape, format, &options)?;
    output.write(&bytes)?;
    warn_of_no_surface(&verb.output, &shape)?;
    let lost = lost(&shape, format);
    report(verb, &lost, format, convention);
    if as_json {
        let mut value = json!({
            "from": read.format.name(),
            "from_degree": read.shape.coefficients.lmax(),
            "to": format.name(),
            "degree": shape.coefficients.lmax(),
            "coefficients": shape.coefficients.count(),
            "bytes": bytes.len(),
            "normalisation": convention.normalisation.name(),
            "csphase": convention.phase.csphase(),
            "centre": shape.centre.to_array(),
            "lost": lost.iter().map(|(name, _)| name).collect::<Vec<_>>(),
        });
        paths::put(&mut value, "read", &verb.input);
        paths::put(&mut value, "written", &verb.output);
        say::json(&value);
    } else {
        let described = |path: &PathBuf, format: SeriesFormat, lmax: usize| {
            format!("{}, {} of degree {lmax}", path.display(), format.noun())
        };
        let lmax = shape.coefficients.lmax();
        say::pairs(&[
            ("read", described(&verb.input, read.format, read.shape.coefficients.lmax())),
            ("written", described(&verb.output, format, lmax)),
            ("convention", say::convention(convention)),
            ("size", say::bytes(bytes.len())),
        ]);
    }
    Ok(Code::Done)
}

/// What was read.
struct Read {
    format: SeriesFormat,
    shape: Shape,
}

fn read(verb: &Convert) -> Result<Read> {
    let options = verb.reading.options();
    let mut input = Input::open(&verb.input)?;
    let format = series_format(&mut input, &options)?.ok_or_else(|| {
        let help = "`harmolux fit` makes coefficients of a mesh; `--from` says the format of a \
                    coefficient file";
        let message = "unrecognised coefficient file";
        Error::from(InputError::new(&verb.input, message).help(help))
    })?;
    let options = ReadOptions { format: Some(format), ..options };
    let shape = coefficients::read_input(input, &options)?.0;
    Ok(Read { format, shape })
}

/// Chooses the format to write.
fn format(verb: &Convert) -> Result<SeriesFormat> {
    let format = verb.to.or_else(|| SeriesFormat::of_extension(&verb.output)).ok_or_else(|| {
        let written = SeriesFormat::ALL.into_iter().filter(|format| format.is_written());
        let names = written.map(SeriesFormat::name).collect::<Vec<_>>().join(", ");
        Error::Parameter(format!(
            "{}: this extension is of no coefficient format: say it with `--to`: {names}",
            verb.output.display()
        ))
    })?;
    format.require_written()?;
    Ok(format)
}

/// Chooses the convention to write, which some formats have by definition.
fn convention(verb: &Convert, format: SeriesFormat) -> Result<Convention> {
    let given = Convention {
        normalisation: verb.to_normalisation.unwrap_or_default(),
        phase: verb.to_csphase.unwrap_or_default(),
    };
    let Some(fixed) = format.convention() else { return Ok(given) };
    let contradicts = verb.to_normalisation.is_some_and(|n| n != fixed.normalisation)
        || verb.to_csphase.is_some_and(|phase| phase != fixed.phase);
    if contradicts {
        return Err(Error::Parameter(format!(
            "{} is always {}: leave out `--to-normalisation` and `--to-csphase`",
            format.noun(),
            say::convention(fixed)
        )));
    }
    Ok(fixed)
}

/// Changes the shape as asked, one step after the other, each said.
fn changed(shape: &Shape, verb: &Convert) -> Shape {
    let mut shape = shape.clone();
    if let Some(lmax) = verb.degree {
        let from = shape.coefficients.lmax();
        if lmax < from {
            say::note(&format!("cut from degree {from} to {lmax}"));
        } else {
            say::note(&format!("the series ends at degree {from}: nothing to cut at {lmax}"));
        }
        shape = shape.truncated(lmax);
    }
    shape
}

/// Lists what the shape has and the format has no room for.
fn lost(shape: &Shape, format: SeriesFormat) -> Vec<(&'static str, String)> {
    let mut lost = Vec::new();
    if shape.centre != glam::DVec3::ZERO && !format.keeps_centre() {
        lost.push(("centre", format!("the centre {}", point(shape.centre))));
    }
    if let Some(source) = shape.source.as_ref().filter(|_| !format.keeps_source()) {
        lost.push((
            "source",
            format!("the name and fingerprint of the source {}", shown(&source.name)),
        ));
    }
    if let Some(degree) = shape.truncated_from.filter(|_| !format.keeps_source()) {
        lost.push(("truncated_from", format!("the degree of the fit, {degree}")));
    }
    lost
}

/// Says on stderr what the file does not.
fn report(verb: &Convert, lost: &[(&str, String)], format: SeriesFormat, convention: Convention) {
    let name = verb.output.display();
    for (_, what) in lost {
        say::note(&format!("{name} has no room for {what}"));
    }
    if !format.says_convention() {
        say::note(&format!(
            "{name} does not say its convention: tell who reads it {}",
            say::convention(convention)
        ));
    }
}
