//! `harmolux info`: what a file holds.

use std::path::PathBuf;

use clap::Args;
use glam::DVec3;
use harmolux::error::{Advice, shown};
use harmolux::fit::Shape;
use harmolux::fit::star;
use harmolux::fit::{mesh_bytes, parametric_mesh, series_bytes};
use harmolux::io::coefficients::{self, ReadOptions, SeriesFormat, spharm_pdm};
use harmolux::io::input::Input;
use harmolux::io::points::{self, PointOptions};
use harmolux::math::Aabb;
use harmolux::mesh::{Mesh, MeshReport};
use harmolux::sh::{Convention, least, positions, range, volume};
use harmolux::{Error, Result};
use serde_json::{Value, json};

use crate::common::advice;
use crate::common::exit::Code;
use crate::common::flags::SeriesReading;
use crate::common::inputs::{holds_points, read_surface, series_format};
use crate::common::say::{self, point};

/// Say what a mesh, coefficient or point file holds
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux info head.obj
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
    if options.format.is_none() && is_cloud(&mut input)? {
        return Ok(show(&points(input)?, as_json));
    }
    let found = match series_format(&mut input, &options)? {
        Some(format) => coefficient_file(input, format, &options)?,
        None => mesh(&read_surface(input)?.0, "triangle mesh"),
    };
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

/// Tells of a file of points.
fn points(input: Input) -> Result<Found> {
    let cloud = points::read_input(input, PointOptions::default())?.0;
    let bounds = Aabb::of_points(cloud.positions.iter().copied());
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
    options: &ReadOptions,
) -> Result<Found> {
    let (path, bytes) = (input.path(), input.rest()?);
    let options = ReadOptions { format: Some(format), ..*options };
    match coefficients::parse(path, &bytes, &options) {
        Ok(shape) => {
            let convention = coefficients::convention(path, &bytes, format, &options)?;
            series(&SeriesFile { format, convention, shape })
        }
        Err(Error::Input(error)) if error.advice.as_deref() == Some(&Advice::FitSurface) => {
            let set = spharm_pdm::parse_set(path, &bytes)?;
            let surface = parametric_mesh(&set)?.scaled(options.unit.unwrap_or(1.0))?;
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
    let (lowest, (lower, most)) = (least(c)?, range(c)?);
    // A radius that is not positive everywhere is of no body, and has no volume.
    let solid = lowest.require_positive(most);
    let volume = solid.is_ok().then(|| volume(c)).transpose()?;
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
        ("volume", volume.map_or("none".to_owned(), |v| format!("{} m3", say::significant(v, 7)))),
    ];
    if let Err(error) = &solid {
        lines.push(("deficiency", format!("no closed surface: {}", advice::told(error))));
    }
    lines.extend(source.as_deref().map(|name| ("source", shown(name))));
    lines.extend(shape.truncated_from.map(|l| ("cut from", format!("degree {l}"))));
    let value = json!({
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
        "volume": volume,
        "source": source,
        "truncated_from": shape.truncated_from,
    });
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
    let star = star_of(mesh, &mut lines);
    for text in &deficiencies {
        lines.push(("deficiency", text.clone()));
    }
    let value = json!({
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
    Found { lines, value, code: Code::Done }
}
