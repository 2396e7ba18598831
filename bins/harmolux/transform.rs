//! `harmolux transform`: a shape becomes another one.

use std::path::PathBuf;

use clap::Args;
use glam::{DMat3, DQuat, DVec3};
use harmolux::Result;
use harmolux::fit::Shape;
use harmolux::fit::{NewCentre, Reshaped, Steps, Turn, reshape};
use harmolux::io::coefficients;
use harmolux::math::{EulerAngles, Rotation};
use harmolux::sh::{Alignment, Axis, Filter, InertiaSymmetry, Recentred};
use serde_json::{Value, json};

use crate::common::about::about;
use crate::common::exit::Code;
use crate::common::flags::{SeriesReading, choices};
use crate::common::values::{numbers, point};
use crate::common::{paths, say, shape_file};

/// Turn, mirror, align, scale, cut or recentre a shape
///
/// What is asked for is done in the order of the options below; run it twice for another order.
/// Mirror, turns and scale are about the origin of the shape's axes and take the expansion centre
/// along.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux transform head.txt -o turned.txt --axis 0,0,1 --angle 90
  harmolux transform head.txt -o small.txt -l 16 --scale 0.5
  harmolux transform head.txt -o twin.txt --mirror x
  harmolux transform rock.txt -o standard.txt --recentre centroid --align --to-origin")]
pub(crate) struct Transform {
    /// The shape: a coefficient file
    pub(crate) shape: PathBuf,
    /// Where to write the new shape
    #[arg(short, long, value_name = "FILE.txt")]
    pub(crate) output: PathBuf,
    /// Cut the series at this degree; with --recentre, expand it up to there
    #[arg(
        short = 'l', long = "degree", value_name = "LMAX",
        value_parser = clap::value_parser!(u32).range(0..=1400)
    )]
    pub(crate) degree: Option<u32>,
    /// Expand the surface, which stays where it is, about another centre: a point in the shape's
    /// axes, metres, or the word centroid
    #[arg(
        long, value_name = "X,Y,Z|centroid", value_parser = new_centre,
        allow_hyphen_values = true
    )]
    pub(crate) recentre: Option<NewCentre>,
    /// Damp the degrees against ringing: lanczos, or heat=TIME (0.001 softens about 3 degrees of
    /// arc)
    #[arg(long, value_name = "lanczos|heat=TIME")]
    pub(crate) filter: Option<Filter>,
    /// Mirror at the plane normal to this axis
    #[arg(long, value_parser = choices::<Axis>())]
    pub(crate) mirror: Option<Axis>,
    #[command(flatten)]
    pub(crate) turn: Turning,
    /// Multiply all lengths
    #[arg(long, value_name = "FACTOR")]
    pub(crate) scale: Option<f64>,
    /// Move the expansion centre to the origin
    #[arg(long)]
    pub(crate) to_origin: bool,
    #[command(flatten)]
    pub(crate) reading: SeriesReading,
    /// Replace a file that is there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// One way of turning a shape
#[derive(Debug, Args)]
pub(crate) struct Turning {
    /// Turn about this axis, by the rule of the right hand
    #[arg(
        long, value_name = "X,Y,Z", group = "turning", requires = "angle", value_parser = point,
        allow_hyphen_values = true
    )]
    axis: Option<DVec3>,
    /// By how many degrees
    #[arg(long, value_name = "DEGREES", requires = "axis", allow_hyphen_values = true)]
    angle: Option<f64>,
    /// Turn by GAMMA about z, then by BETA about y, then by ALPHA about z, axes fixed in space,
    /// degrees
    #[arg(
        long, value_name = "ALPHA,BETA,GAMMA", group = "turning", value_parser = euler,
        allow_hyphen_values = true
    )]
    euler: Option<Rotation>,
    /// Turn by a quaternion of any length, the real part last
    #[arg(
        long, value_name = "X,Y,Z,W", group = "turning", value_parser = quaternion,
        allow_hyphen_values = true
    )]
    quaternion: Option<Rotation>,
    /// Turn by a rotation matrix: nine numbers, row by row
    #[arg(
        long, value_name = "XX,XY,...,ZZ", group = "turning", value_parser = matrix,
        allow_hyphen_values = true
    )]
    matrix: Option<Rotation>,
    /// Turn the principal axes of inertia to x (longest), y, z (shortest), the long tails to the
    /// positive sides
    #[arg(long, group = "turning")]
    align: bool,
}

impl Turning {
    fn chosen(&self) -> Result<Option<Turn>> {
        if self.align {
            return Ok(Some(Turn::Align));
        }
        let about = match (self.axis, self.angle) {
            (Some(axis), Some(angle)) => Some(Rotation::about(axis, angle.to_radians())?),
            _ => None,
        };
        Ok(about.or(self.euler).or(self.quaternion).or(self.matrix).map(Turn::By))
    }
}

fn euler(text: &str) -> Result<Rotation, String> {
    let [alpha, beta, gamma] = numbers::<3>(text)?.map(f64::to_radians);
    Rotation::from_euler(EulerAngles { alpha, beta, gamma }).map_err(|e| e.to_string())
}

fn quaternion(text: &str) -> Result<Rotation, String> {
    Rotation::from_quaternion(DQuat::from_array(numbers(text)?)).map_err(|e| e.to_string())
}

fn matrix(text: &str) -> Result<Rotation, String> {
    let rows = DMat3::from_cols_array(&numbers(text)?);
    Rotation::from_matrix(rows.transpose()).map_err(|e| e.to_string())
}

fn new_centre(text: &str) -> Result<NewCentre, String> {
    if text == "centroid" {
        return Ok(NewCentre::Centroid);
    }
    point(text).map(NewCentre::Point).map_err(|e| format!("{e}, or centroid"))
}

/// Runs the verb.
pub(crate) fn run(verb: &Transform, as_json: bool) -> Result<Code> {
    let output = shape_file::open(&verb.output, verb.force)?;
    let shape = coefficients::read(&verb.shape, &verb.reading.options())?;
    let steps = Steps {
        degree: verb.degree.map(|l| l as usize),
        centre: verb.recentre,
        filter: verb.filter,
        mirror: verb.mirror,
        turn: verb.turn.chosen()?,
        scale: verb.scale,
        to_origin: verb.to_origin,
    };
    let done = reshape(&shape, &steps).map_err(|e| about(&verb.shape, e))?;
    output.write(&done.shape)?;
    shape_file::warn_of_no_surface(&verb.output, &done.shape)?;
    if as_json {
        say::json(&value(verb, &done));
    } else {
        say::pairs(&lines(verb, &shape, &done));
    }
    Ok(Code::Done)
}

fn value(verb: &Transform, done: &Reshaped) -> Value {
    let mut value = json!({
        "degree": done.shape.coefficients.lmax(),
        "centre": done.shape.centre.to_array(),
        "mean_radius": done.shape.coefficients.mean(),
        "recentred": done.recentred.as_ref().map(|r| json!({
            "rms": r.rms, "max": r.max, "quadrature": r.quadrature
        })),
        "rotation": done.rotation.map(|r| r.matrix().transpose().to_cols_array_2d()),
        "aligned": done.alignment.as_ref().map(|a| json!({
            "moments": a.moments, "axes": axes_fixed(a.top)
        })),
    });
    paths::put(&mut value, "written", &verb.output);
    value
}

fn lines(verb: &Transform, before: &Shape, done: &Reshaped) -> Vec<(&'static str, String)> {
    let shape = &done.shape;
    let (lmax, old) = (shape.coefficients.lmax(), before.coefficients.lmax());
    let from = if lmax == old { String::new() } else { format!(", from {old}") };
    let mut lines = vec![
        ("degree", format!("{lmax}{from}")),
        ("centre", format!("{} m", vector(shape.centre))),
        ("mean radius", format!("{} m", say::significant(shape.coefficients.mean(), 7))),
    ];
    lines.extend(done.recentred.as_ref().map(|r| ("recentred", recentred(r))));
    lines.extend(done.alignment.as_ref().map(|a| ("aligned", aligned(a))));
    lines.extend(done.rotation.as_ref().map(|r| ("turned", say::turn(r))));
    lines.push(("written", verb.output.display().to_string()));
    lines
}

fn recentred(r: &Recentred) -> String {
    let mean = r.coefficients.mean();
    format!(
        "off the surface by {} m RMS, {}, {} m at most; raise the degree for less",
        say::significant(r.rms, 3),
        say::percent(r.rms / mean),
        say::significant(r.max, 3)
    )
}

fn aligned(a: &Alignment) -> String {
    let [x, y, z] = a.moments.map(|m| say::significant(m, 5));
    format!("moments of inertia {x}, {y}, {z} m5 about x, y, z; they fix {}", axes_fixed(a.top))
}

fn axes_fixed(top: InertiaSymmetry) -> &'static str {
    match top {
        InertiaSymmetry::Asymmetric => "three axes",
        InertiaSymmetry::Symmetric => "one axis",
        InertiaSymmetry::Spherical => "no axis",
    }
}

fn vector(p: DVec3) -> String {
    let [x, y, z] = p.to_array().map(|v| say::significant(v, 4));
    format!("({x}, {y}, {z})")
}
