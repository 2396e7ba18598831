//! `harmolux info`: what a file holds.

use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;
use harmolux::error::{Advice, shown, shown_path};
use harmolux::fit::star;
use harmolux::fit::{Measures, Shape};
use harmolux::fit::{mesh_bytes, parametric_mesh, series_bytes};
use harmolux::io::coefficients::{self, ReadOptions, SeriesFormat, spharm_pdm};
use harmolux::io::input::Input;
use harmolux::io::points::{self, PointOptions};
use harmolux::math::Aabb;
use harmolux::mesh::{Mesh, MeshReport};
use harmolux::sh::{Convention, extremes, positions, range};
use harmolux::{Error, Result};
use serde_json::{Value, json};

use crate::common::exit::Code;
use crate::common::flags::SeriesReading;
use crate::common::inputs::{holds_points, read_surface, series_format};
use crate::common::progress::Meter;
use crate::common::say::{self, point};
use crate::common::{advice, idle, measures};

/// Say what a mesh, coefficient or point file holds
///
/// Lengths are printed in metres, areas in m2, volumes in m3: `--unit` says what the numbers of the
/// file are in. A body, of coefficients or inside a closed mesh, has its measures: sphericity is
/// the area of the ball of its volume over its own (Wadell); elongation b/a and flatness c/b
/// (Zingg) are of the semi-axes a >= b >= c of the ellipsoid that has its volume and, in ratio, its
/// moments of inertia; roughness is the RMS distance of the surface from that ellipsoid, along rays
/// from the centroid, over the area.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux info head.obj --unit mm
  harmolux info head.txt
  harmolux info topo.sh --normalisation ortho --csphase -1 --unit km
  harmolux info cells.csv --row 7 --unit um")]
pub(crate) struct Info {
    /// A mesh, coefficients or points, of any format that is read here
    pub(crate) file: PathBuf,
    #[command(flatten)]
    pub(crate) reading: SeriesReading,
}

/// Runs the verb.
pub(crate) fn run(verb: &Info, as_json: bool) -> Result<Code> {
    let mut input = Input::open(&verb.file)?;
    let options = verb.reading.options();
    let meter = Meter::start(&format!("measuring {}", shown_path(&verb.file)));
    let found = if options.format.is_none() && is_cloud(&mut input)? {
        points(input, &verb.reading)?
    } else if let Some(format) = series_format(&mut input, &options)? {
        coefficient_file(input, format, &verb.reading)?
    } else {
        refuse_flags_of_series(input.path(), "a mesh", &verb.reading)?;
        let (found, _) = read_surface(input)?;
        // Of a large mesh no copy is made that it does not need.
        let scaled = verb.reading.unit.map(|unit| found.scaled(unit.metres())).transpose()?;
        mesh(&scaled.unwrap_or(found), "triangle mesh")
    };
    drop(meter);
    Ok(show(&found, as_json))
}

fn show(found: &Found, as_json: bool) -> Code {
    if as_json {
        say::json(&found.value);
    } else {
        say::pairs(&found.lines);
    }
    found.code
}

/// Whether a file holds points: by their mark, else where neither content nor extension is that of
/// coefficients (a table by its extension may be of points, too).
fn is_cloud(input: &mut Input) -> Result<bool> {
    let (path, length) = (input.path(), input.length());
    let head = input.ahead()?;
    if points::is_marked(head) {
        return Ok(true);
    }
    let named = SeriesFormat::of_extension(path).is_some() && !points::is_points(path);
    Ok(!named && coefficients::recognise_content(head, length).is_none() && holds_points(input)?)
}

/// Refuses what is said of coefficients where a file holds none.
fn refuse_flags_of_series(path: &Path, kind: &str, reading: &SeriesReading) -> Result<()> {
    let why = format!("{}: this is {kind}, not coefficients of a radius", shown_path(path));
    idle::refuse(&why, &reading.of_series())
}

/// Tells of a file of points.
fn points(input: Input, reading: &SeriesReading) -> Result<Found> {
    refuse_flags_of_series(input.path(), "points", reading)?;
    let cloud = points::read_input(input, PointOptions::default())?.0;
    let bounds = Aabb::of_points(cloud.positions.iter().map(|p| reading.metres() * *p));
    let count = cloud.positions.len();
    let lines = vec![
        ("kind", "points".to_owned()),
        ("size", format!("{count} points")),
        ("bounds", format!("{} to {}", point(bounds.min), point(bounds.max))),
    ];
    let bounds = [bounds.min.to_array(), bounds.max.to_array()];
    let value = json!({ "kind": "points", "points": count, "bounds": bounds });
    Ok(Found { lines, value, code: Code::Done })
}

/// What is said of a file.
struct Found {
    lines: Lines,
    value: Value,
    code: Code,
}

/// Tells of a coefficient file, of one of a parametric surface by its mesh.
fn coefficient_file(
    mut input: Input,
    format: SeriesFormat,
    reading: &SeriesReading,
) -> Result<Found> {
    let (path, bytes) = (input.path(), input.rest()?);
    let options = ReadOptions { format: Some(format), ..reading.options() };
    match coefficients::parse(path, &bytes, &options) {
        Ok(shape) => {
            let convention = coefficients::convention(path, &bytes, format, &options)?;
            series(&SeriesFile { format, convention, shape })
        }
        Err(Error::Input(error)) if error.advice.as_deref() == Some(&Advice::FitSurface) => {
            refuse_flags_of_series(path, "a parametric surface", reading)?;
            let set = spharm_pdm::parse_set(path, &bytes)?;
            let surface = parametric_mesh(&set)?.scaled(reading.metres())?;
            Ok(mesh(
                &surface,
                &format!("parametric surface of degree {}, as a mesh", set[0].lmax()),
            ))
        }
        Err(error) => Err(error),
    }
}

type Lines = Vec<(&'static str, String)>;

/// A coefficient file: its format, the convention it has in itself, and what it holds.
struct SeriesFile {
    format: SeriesFormat,
    convention: Option<Convention>,
    shape: Shape,
}

fn series(file: &SeriesFile) -> Result<Found> {
    let shape = &file.shape;
    let c = &shape.coefficients;
    let (lowest, most) = extremes(c)?;
    let lower = lowest.bound;
    // A radius that is not positive everywhere is of no body, and has no volume.
    let solid = lowest.require_positive(most);
    let body = solid.is_ok().then(|| Measures::of_shape(shape)).transpose()?;
    let set = positions(c, shape.centre);
    let [x, y, z] = [range(&set[0])?, range(&set[1])?, range(&set[2])?];
    let (low, high) = (DVec3::new(x.0, y.0, z.0), DVec3::new(x.1, y.1, z.1));
    let convention = file.convention.map(say::convention);
    let source = shape.source.as_ref().map(|s| s.name.clone());
    let size = say::bytes(series_bytes(c.lmax()));
    let [least, largest] = [lower, most].map(|radius| say::significant(radius, 5));
    let mut lines = vec![
        ("kind", "spherical-harmonic coefficients of a radius, metres".to_owned()),
        ("format", file.format.noun().to_owned()),
        ("convention", convention.unwrap_or_else(|| "our own basis".to_owned())),
        ("degree", format!("{}, {} coefficients, {size} in f32", c.lmax(), c.count())),
        ("centre", point(shape.centre)),
        ("mean radius", format!("{} m", say::significant(c.mean(), 7))),
        ("radius", format!("certainly {least} to {largest} m")),
        ("bounds", format!("certainly within {} to {}", point(low), point(high))),
    ];
    let told = |value: Option<f64>, unit: &str| {
        value.map_or("none".to_owned(), |v| format!("{} {unit}", say::significant(v, 7)))
    };
    let [area, volume] = [body.map(|m| m.area), body.map(|m| m.volume)];
    lines.extend([("area", told(area, "m2")), ("volume", told(volume, "m3"))]);
    lines.extend(body.iter().flat_map(measures::lines));
    if let Err(error) = &solid {
        lines.push(("deficiency", format!("no closed surface: {}", advice::told(error))));
    }
    lines.extend(source.as_deref().map(|name| ("source", shown(name))));
    lines.extend(shape.truncated_from.map(|l| ("cut from", format!("degree {l}"))));
    let mut value = json!({
        "kind": "coefficients",
        "format": file.format.name(),
        "normalisation": file.convention.map(|c| c.normalisation.name()),
        "csphase": file.convention.map(|c| c.phase.csphase()),
        "degree": c.lmax(),
        "coefficients": c.count(),
        "bytes": series_bytes(c.lmax()),
        "centre": shape.centre.to_array(),
        "mean_radius": c.mean(),
        "radius_bounds": [lower, most],
        "bounds": [low.to_array(), high.to_array()],
        "area": area,
        "volume": volume,
        "source": source,
        "truncated_from": shape.truncated_from,
    });
    measures::put(&mut value, body.as_ref());
    let code = if solid.is_ok() { Code::Done } else { Code::BadInput };
    Ok(Found { lines, value, code })
}

/// Describes how the mesh is seen from its origin and from its best centre, if it can be told.
fn star_of(mesh: &Mesh, lines: &mut Lines) -> Value {
    let star =
        star::test(mesh, DVec3::ZERO).and_then(|about| Ok((about, star::best_centre(mesh)?)));
    match star {
        Ok((about, (best, clearance))) => {
            let origin = if about.is_star_shaped() { "star-shaped" } else { "not star-shaped" };
            lines.push((
                "about the origin",
                format!("{origin}, clearance {} m", say::significant(about.clearance, 4)),
            ));
            lines.push((
                "best centre",
                format!("{}, clearance {} m", point(best), say::significant(clearance, 4)),
            ));
            json!({
                "origin_clearance": about.clearance,
                "best_centre": best.to_array(),
                "best_clearance": clearance,
            })
        }
        Err(_) => Value::Null,
    }
}

fn mesh(mesh: &Mesh, kind: &str) -> Found {
    let report = MeshReport::of(mesh);
    let size = [mesh.positions().len(), mesh.triangles().len()];
    let bounds = mesh.bounds();
    let deficiencies = report.deficiencies();
    let mut lines = vec![
        ("kind", kind.to_owned()),
        (
            "size",
            format!(
                "{} vertices, {} faces, {} in f32",
                size[0],
                size[1],
                say::bytes(mesh_bytes(mesh.used_size()))
            ),
        ),
        ("bounds", format!("{} to {}", point(bounds.min), point(bounds.max))),
        ("area", format!("{} m2", say::significant(mesh.area(), 6))),
        ("volume", format!("{} m3", say::significant(mesh.volume(), 6))),
        ("closed", if report.is_closed() { "yes".into() } else { "no".into() }),
        ("components", format!("{}, Euler number {}", report.components, report.euler())),
    ];
    // Of pieces that overlap there may be none, though it is closed.
    let body = report.require_closed().and_then(|()| Measures::of_mesh(mesh)).ok();
    lines.extend(body.iter().flat_map(measures::lines));
    let star = star_of(mesh, &mut lines);
    for text in &deficiencies {
        lines.push(("deficiency", text.clone()));
    }
    let mut value = json!({
        "kind": "mesh",
        "vertices": size[0],
        "faces": size[1],
        "bytes": mesh_bytes(mesh.used_size()),
        "bounds": [bounds.min.to_array(), bounds.max.to_array()],
        "area": mesh.area(),
        "volume": mesh.volume(),
        "closed": report.is_closed(),
        "components": report.components,
        "euler": report.euler(),
        "star": star,
        "deficiencies": deficiencies,
    });
    measures::put(&mut value, body.as_ref());
    Found { lines, value, code: Code::Done }
}
