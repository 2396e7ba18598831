//! `harmolux info`: what a file holds.

use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;
use harmolux::Result;
use harmolux::io::coefficients::{self, Shape};
use harmolux::io::meshes;
use harmolux::sh::{Bounds, volume};
use harmolux::study::{mesh_bytes, series_bytes};
use harmolux::surface::{MeshReport, star};
use serde_json::{Value, json};

use super::arguments::SeriesHabits;
use super::exit::Code;
use super::say;

/// Say what a mesh or coefficient file holds
#[derive(Debug, Args)]
pub(crate) struct Info {
    /// A mesh (OBJ, PLY, STL, OFF or glTF) or coefficients (pyshtools text)
    pub(crate) file: PathBuf,
    #[command(flatten)]
    pub(crate) habits: SeriesHabits,
}

/// Runs the verb.
pub(crate) fn run(verb: &Info, as_json: bool) -> Result<Code> {
    let extension = verb.file.extension().and_then(|e| e.to_str()).unwrap_or("");
    let is_series = ["txt", "sh"].iter().any(|e| e.eq_ignore_ascii_case(extension));
    let (lines, value) = if is_series {
        series(&coefficients::read(&verb.file, verb.habits.convention())?)?
    } else {
        mesh(&verb.file)?
    };
    if as_json {
        say::data(&value.to_string());
    } else {
        say::pairs(&lines);
    }
    Ok(Code::Done)
}

type Lines = Vec<(&'static str, String)>;

fn series(shape: &Shape) -> Result<(Lines, Value)> {
    let c = &shape.coefficients;
    let bounds = Bounds::of(c)?;
    let volume = volume(c)?;
    let source = shape.source.as_ref().map(|s| s.name.clone());
    let mut lines = vec![
        ("kind", "spherical-harmonic coefficients of a radius, metres".to_owned()),
        (
            "degree",
            format!(
                "{}, {} coefficients, {} in f32",
                c.lmax(),
                c.count(),
                say::bytes(series_bytes(c.lmax()))
            ),
        ),
        ("centre", point(shape.centre)),
        ("mean radius", format!("{} m", say::significant(c.mean(), 7))),
        (
            "radius",
            format!(
                "certainly {} to {} m",
                say::significant(bounds.min, 5),
                say::significant(bounds.max, 5)
            ),
        ),
        ("volume", format!("{} m3", say::significant(volume, 7))),
    ];
    if let Some(name) = &source {
        lines.push(("source", name.clone()));
    }
    let value = json!({
        "kind": "coefficients",
        "degree": c.lmax(),
        "coefficients": c.count(),
        "bytes": series_bytes(c.lmax()),
        "centre": shape.centre.to_array(),
        "mean_radius": c.mean(),
        "radius_bounds": [bounds.min, bounds.max],
        "volume": volume,
        "source": source,
    });
    Ok((lines, value))
}

fn mesh(path: &Path) -> Result<(Lines, Value)> {
    let mesh = meshes::read(path)?;
    let report = MeshReport::of(&mesh);
    let size = [mesh.positions().len(), mesh.triangles().len()];
    let bounds = mesh.bounds();
    let deficiencies = report.deficiencies();
    let mut lines = vec![
        ("kind", "triangle mesh".to_owned()),
        (
            "size",
            format!(
                "{} vertices, {} faces, {} in f32",
                size[0],
                size[1],
                say::bytes(mesh_bytes(size))
            ),
        ),
        ("bounds", format!("{} to {}", point(bounds.min), point(bounds.max))),
        ("area", format!("{} m2", say::significant(mesh.area(), 6))),
        ("volume", format!("{} m3", say::significant(mesh.volume(), 6))),
        ("closed", if report.is_closed() { "yes".into() } else { "no".into() }),
        ("components", format!("{}, Euler number {}", report.components, report.euler())),
    ];
    let star =
        star::test(&mesh, DVec3::ZERO).and_then(|about| Ok((about, star::best_centre(&mesh)?)));
    let star = match star {
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
                "origin_clearance": about.clearance, "best_centre": best.to_array(), "best_clearance": clearance
            })
        }
        Err(_) => Value::Null,
    };
    for text in &deficiencies {
        lines.push(("deficiency", text.clone()));
    }
    let value = json!({
        "kind": "mesh",
        "vertices": size[0],
        "faces": size[1],
        "bytes": mesh_bytes(size),
        "bounds": [bounds.min.to_array(), bounds.max.to_array()],
        "area": mesh.area(),
        "volume": mesh.volume(),
        "closed": report.is_closed(),
        "components": report.components,
        "euler": report.euler(),
        "star": star,
        "deficiencies": deficiencies,
    });
    Ok((lines, value))
}

fn point(p: DVec3) -> String {
    let [x, y, z] = p.to_array().map(|v| say::significant(v, 4));
    format!("({x}, {y}, {z}) m")
}
