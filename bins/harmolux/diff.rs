//! `harmolux diff`: how far two shapes are from each other.

use std::path::PathBuf;

use clap::Args;
use glam::DVec3;
use harmolux::error::shown_path;
use harmolux::io::meshes::{MeshColours, MeshFormat, encode_ply};
use harmolux::io::output::Output;
use harmolux::io::tables::{Cell, Table};
use harmolux::study::{
    CompareSettings, Comparison, DistanceMap, FarthestPoint, Hausdorff, Limit, Pair,
};
use harmolux::{Error, Result};
use serde_json::{Value, json};

use crate::common::advice;
use crate::common::exit::Code;
use crate::common::flags::{MeshHabits, SeriesHabits};
use crate::common::progress::Meter;
use crate::common::subject::Read;
use crate::common::target::write_all;
use crate::common::values::{length, point};
use crate::common::{idle, paths, say};

/// Measure how far two shapes or meshes are from each other
///
/// The Hausdorff distance, and how far either is from the other, are intervals that certainly hold
/// them, for the smooth surface of coefficients too; a smaller --width never gives a wider one.
/// Exit code 4 when one that was asked for could not be had. The radial difference exists about one
/// centre only; normals are compared at nearest points.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux diff head.txt head.obj                     what the fit lost
  harmolux diff left.txt right.txt --json
  harmolux diff head.txt head.obj --map where.ply     the difference as colours
  harmolux diff new.obj old.obj --tolerance 0.1mm     exit code 4 when they are farther apart")]
pub(crate) struct Diff {
    /// The first shape: coefficients or a mesh
    pub(crate) a: PathBuf,
    /// The second shape: coefficients or a mesh
    pub(crate) b: PathBuf,
    /// Exit with code 4 unless the Hausdorff distance is certainly not above this, such as 0.1mm
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    pub(crate) tolerance: Option<f64>,
    /// How wide the intervals of the distances may be [default: a thousandth of the size, as
    /// far as seconds allow, or a quarter of the tolerance]
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    pub(crate) width: Option<f64>,
    /// The centre about which the radii of two meshes are compared, metres [default: 0,0,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub(crate) centre: Option<DVec3>,
    /// Write the numbers as a table
    #[arg(short, long, value_name = "FILE.csv")]
    pub(crate) output: Option<PathBuf>,
    /// Write the first shape coloured by its distance from the second: blue where that is inside
    /// it, red where it is outside
    #[arg(long, value_name = "FILE.ply")]
    pub(crate) map: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) mesh: MeshHabits,
    #[command(flatten)]
    pub(crate) series: SeriesHabits,
    /// Replace files that are there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// Runs the verb.
pub(crate) fn run(verb: &Diff, as_json: bool) -> Result<Code> {
    let mut table = Table::new(["a", "b", "quantity", "value", "unit"]);
    let kind = table.csv_kind()?;
    let output = verb.output.as_ref().map(|path| Output::open(path, &kind, verb.force));
    let output = output.transpose()?;
    let map = verb.map.as_ref().map(|path| Output::open(path, &MeshFormat::Ply.kind(), verb.force));
    let map = map.transpose()?;
    let meter = Meter::start("reading the shapes");
    let [a, b] = [&verb.a, &verb.b].map(|path| Read::open(path, &verb.series, &verb.mesh));
    let ((a, _), (b, _)) = (a?, b?);
    refuse_idle_flags(verb, [&a, &b])?;
    let settings = CompareSettings {
        width: verb.width.or(verb.tolerance.map(|t| 0.25 * t)),
        centre: verb.centre.unwrap_or_default(),
    };
    meter.stage("comparing the shapes");
    let ready = Pair::new(a.subject(), b.subject(), &settings);
    let pair = ready.map_err(|e| about_both(verb, e))?;
    let found = pair.compare().map_err(|e| about_both(verb, e))?;
    let met = verb.tolerance.map(|tolerance| found.hausdorff.upper <= tolerance);
    fill(&mut table, verb, &found);
    let csv = output.map(|output| output.write(&table.to_csv()?));
    let map = map.map(|output| write_map(output, &pair.distance_map()?));
    let written = write_all(csv.into_iter().chain(map));
    drop(meter);
    if as_json {
        say::json(&value(verb, &found, met));
    } else {
        report(&found);
    }
    written?;
    Ok(judge(verb, &found.hausdorff, met))
}

/// Refuses what is said of meshes where there are none, or of series.
fn refuse_idle_flags(verb: &Diff, both: [&Read; 2]) -> Result<()> {
    let is_series = both.map(|read| matches!(read, Read::Series(_)));
    let refuse = |why: &str, flags: &[(bool, &str)]| {
        let (a, b) = (shown_path(&verb.a), shown_path(&verb.b));
        idle::refuse(&format!("{a} and {b}: {why}"), flags)
    };
    match is_series {
        [false, false] => refuse("there are no coefficients here", &verb.series.given()),
        [true, true] => refuse("there is no mesh here", &verb.mesh.given()),
        _ => Ok(()),
    }?;
    if is_series.contains(&true) {
        let centre = [(verb.centre.is_some(), "--centre")];
        refuse("radii are compared about the centre of the series", &centre)?;
    }
    Ok(())
}

fn judge(verb: &Diff, hausdorff: &Hausdorff, met: Option<bool>) -> Code {
    let mut code = Code::Done;
    if let (Some(tolerance), Some(false)) = (verb.tolerance, met) {
        let certainly = if hausdorff.lower > tolerance { "above" } else { "not certainly within" };
        say::warning(&format!(
            "the Hausdorff distance, {}, is {certainly} the tolerance of {} m",
            interval(hausdorff.lower, hausdorff.upper),
            say::significant(tolerance, 4)
        ));
        code = Code::NotMet;
    }
    let Some(limit) = hausdorff.limit() else { return code };
    let widest = hausdorff.one_sided.map(|p| p.upper - p.lower).into_iter().fold(0.0, f64::max);
    let [widest, width] = [widest, hausdorff.width].map(|x| say::significant(x, 2));
    // A width that stands for the tolerance alone has served when that is decided.
    let is_open = met == Some(false) && verb.tolerance.is_some_and(|t| hausdorff.lower <= t);
    if verb.width.is_some() || is_open {
        let why = why_wide(limit);
        say::warning(&format!("an interval is {widest} m wide, and may be {width} m: {why}"));
        code = Code::NotMet;
    } else if verb.tolerance.is_none() {
        say::note(&format!("an interval is {widest} m wide; `--width {width}` takes its time"));
    }
    code
}

/// Says why an interval is too wide, and how to go on.
fn why_wide(limit: Limit) -> String {
    match limit {
        Limit::Points(most) => {
            format!("it takes more than the {most} points that are looked at; widen --width")
        }
        Limit::Memory => {
            "it takes more memory than is free; allow more by --max-memory or widen --width".into()
        }
        _ => "numbers have no more digits; widen --width".into(),
    }
}

/// Writes the map and says what its colours mean.
fn write_map(output: Output, map: &DistanceMap) -> Result<()> {
    let (colours, end) = map.colours();
    let path = output.path().display().to_string();
    output.write(&encode_ply(&map.mesh, Some(MeshColours::OfVertices(&colours)))?)?;
    let end = say::significant(end, 3);
    say::note(&format!(
        "{path}: blue -{end} m (b is inside a), white 0, red +{end} m (b is outside a); the \
         strength grows with the square root"
    ));
    Ok(())
}

fn about_both(verb: &Diff, error: Error) -> Error {
    let names = format!("{} and {}", verb.a.display(), verb.b.display());
    error.map(|error| match error {
        Error::Geometry(text) => Error::Geometry(format!("{names}: {text}")),
        Error::Parameter(text) => Error::Parameter(format!("{names}: {text}")),
        other => other,
    })
}

/// Lists every number with its name and unit.
fn numbers(found: &Comparison) -> Vec<(&'static str, Option<f64>, &'static str)> {
    let radial = found.radial.as_ref().ok();
    let h = &found.hausdorff;
    vec![
        ("hausdorff_lower", Some(h.lower), "m"),
        ("hausdorff_upper", Some(h.upper), "m"),
        ("a_from_b_lower", Some(h.one_sided[0].lower), "m"),
        ("a_from_b_upper", Some(h.one_sided[0].upper), "m"),
        ("b_from_a_lower", Some(h.one_sided[1].lower), "m"),
        ("b_from_a_upper", Some(h.one_sided[1].upper), "m"),
        ("width", Some(h.width), "m"),
        ("radial_rms", radial.map(|r| r.rms), "m"),
        ("radial_max", radial.map(|r| r.max), "m"),
        ("mean_radius_a", radial.map(|r| r.mean_radii[0]), "m"),
        ("mean_radius_b", radial.map(|r| r.mean_radii[1]), "m"),
        ("normal_angle_mean", Some(found.normals.mean.to_degrees()), "deg"),
        ("normal_angle_95", Some(found.normals.percentile_95.to_degrees()), "deg"),
        ("volume_a", found.volumes[0], "m3"),
        ("volume_b", found.volumes[1], "m3"),
        ("area_a", Some(found.areas[0]), "m2"),
        ("area_b", Some(found.areas[1]), "m2"),
    ]
}

fn fill(table: &mut Table, verb: &Diff, found: &Comparison) {
    let [a, b] = [&verb.a, &verb.b].map(|path| path.display().to_string());
    for (name, value, unit) in numbers(found) {
        table.push([
            a.clone().into(),
            b.clone().into(),
            name.into(),
            Cell::from(value),
            unit.into(),
        ]);
    }
}

fn value(verb: &Diff, found: &Comparison, met: Option<bool>) -> Value {
    let mut value = json!({
        "a_farthest_at": found.hausdorff.one_sided[0].at.to_array(),
        "b_farthest_at": found.hausdorff.one_sided[1].at.to_array(),
        "normal_samples": found.normals.samples,
        "no_radial_because": found.radial.as_ref().err().map(advice::told),
        "width_met": found.hausdorff.limit().is_none(),
        "within_tolerance": met,
    });
    paths::put(&mut value, "a", &verb.a);
    paths::put(&mut value, "b", &verb.b);
    for (name, number, unit) in numbers(found) {
        value[format!("{name}_{unit}")] = json!(number);
    }
    value
}

fn report(found: &Comparison) {
    let h = &found.hausdorff;
    let place = |i: usize| {
        let [x, y, z] = h.one_sided[i].at.to_array().map(|v| say::significant(v, 3));
        let FarthestPoint { lower, upper, .. } = h.one_sided[i];
        format!("{}, at ({x}, {y}, {z})", interval(lower, upper))
    };
    let mut lines = vec![
        ("Hausdorff distance", interval(h.lower, h.upper)),
        ("a is from b up to", place(0)),
        ("b is from a up to", place(1)),
    ];
    match &found.radial {
        Ok(r) => {
            let relative = |x: f64| say::percent(x / r.mean_radii[0]);
            lines.push((
                "radial RMS",
                format!("{} m, {}", say::significant(r.rms, 4), relative(r.rms)),
            ));
            lines.push((
                "radial largest",
                format!("{} m, {}", say::significant(r.max, 4), relative(r.max)),
            ));
        }
        Err(reason) => lines.push(("radial", format!("none: {}", advice::told(reason)))),
    }
    let degrees = |angle: f64| format!("{} deg", say::significant(angle.to_degrees(), 3));
    let normals = &found.normals;
    lines.push((
        "normals differ by",
        format!(
            "{} in the mean, 95 % below {}",
            degrees(normals.mean),
            degrees(normals.percentile_95)
        ),
    ));
    lines.push(("volume", two(found.volumes, "m3")));
    lines.push(("area", two(found.areas.map(Some), "m2")));
    say::pairs(&lines);
}

fn interval(lower: f64, upper: f64) -> String {
    let [lower, upper] = [lower, upper].map(|x| say::significant(x, 4));
    format!("{lower} to {upper} m")
}

/// Writes two values and their ratio.
fn two(values: [Option<f64>; 2], unit: &str) -> String {
    let text = |v: Option<f64>| v.map_or("none (open)".into(), |v| say::significant(v, 6));
    let ratio = match values {
        [Some(a), Some(b)] => format!(", ratio {}", say::significant(b / a, 6)),
        _ => String::new(),
    };
    format!("{} and {} {unit}{ratio}", text(values[0]), text(values[1]))
}
