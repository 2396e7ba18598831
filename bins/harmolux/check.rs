//! `harmolux check`: whether a mesh can be fitted, and if not, where and why.

use std::path::PathBuf;

use clap::Args;
use glam::DVec3;
use harmolux::Result;
use harmolux::error::Advice;
use harmolux::fit::SelfIntersections;
use harmolux::fit::star::{Fold, Folds, StarReport};
use harmolux::fit::{Check as Findings, CheckSettings, FAULTLESS_COLOUR, FaceFault, StarCheck};
use harmolux::io::input::Input;
use harmolux::io::meshes::{self, MeshColours, MeshFormat};
use harmolux::io::output::Output;
use harmolux::mesh::{Mesh, RepairReport};
use serde_json::{Value, json};

use crate::common::about::about;
use crate::common::advice::in_flags;
use crate::common::exit::Code;
use crate::common::flags::MeshHabits;
use crate::common::inputs::{MeshRead, read_mesh};
use crate::common::progress::Meter;
use crate::common::target::write_all;
use crate::common::values::point;
use crate::common::{paths, say};

/// Say whether a mesh can be fitted, and if not, where and why
///
/// It must be closed, manifold, oriented and star-shaped. The exit code is 0 when it is all that, 4
/// when not. A mesh that is star-shaped about any centre will do, unless one is named.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux check head.obj
  harmolux check ear.ply --bad bad.ply                  what is wrong, in colours
  harmolux check scan.stl --repair -o mended.ply        join, drop, turn; then check
  harmolux check rock.off --centre 0.1,0,0.2 --json

Colours of the faces:
  red      turns away from the centre
  blue     crosses another face
  violet   has an edge of three faces, or of two that disagree about the outside
  orange   is at the boundary
  yellow   has no area or repeats another
  grey     is sound")]
pub(crate) struct Check {
    /// The mesh (OBJ, PLY, STL, OFF or glTF)
    pub(crate) mesh: PathBuf,
    /// Where to write the repaired mesh, metres, z up
    #[arg(short, long, value_name = "FILE", requires = "repair")]
    pub(crate) output: Option<PathBuf>,
    /// Where to write the mesh with its bad faces coloured
    #[arg(long, value_name = "FILE.ply")]
    pub(crate) bad: Option<PathBuf>,
    /// The centre about which it is to be star-shaped, metres [default: any]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub(crate) centre: Option<DVec3>,
    /// Do not look for faces that cross: saves time on meshes of millions of faces
    #[arg(long)]
    pub(crate) skip_crossings: bool,
    #[command(flatten)]
    pub(crate) habits: MeshHabits,
    /// Replace files that are there already
    #[arg(long)]
    pub(crate) force: bool,
}

/// Runs the verb.
pub(crate) fn run(verb: &Check, as_json: bool) -> Result<Code> {
    let open = |path: &PathBuf, format: MeshFormat| -> Result<_> {
        Ok((Output::open(path, &format.kind(), verb.force)?, format))
    };
    let repaired =
        verb.output.as_ref().map(|p| open(p, MeshFormat::for_writing(p)?)).transpose()?;
    let bad = verb.bad.as_ref().map(|p| open(p, MeshFormat::Ply)).transpose()?;
    let meter = Meter::start("reading the mesh");
    let MeshRead { mesh, repair, .. } = read_mesh(Input::open(&verb.mesh)?, &verb.habits)?;
    meter.stage("checking the mesh");
    let settings = CheckSettings { centre: verb.centre, crossings: !verb.skip_crossings };
    let found = Findings::of(&mesh, &settings).map_err(|e| about(&verb.mesh, e))?;
    let repaired = repaired.map(|(output, format)| output.write(&meshes::encode(&mesh, format)?));
    let bad = bad.map(|(output, _)| output.write(&coloured(&mesh, &found)?));
    let written = write_all(repaired.into_iter().chain(bad));
    drop(meter);
    if as_json {
        say::json(&value(&found, repair.as_ref(), verb));
    } else {
        say::pairs(&lines(&found, verb));
    }
    written?;
    Ok(if found.is_sound() { Code::Done } else { Code::NotMet })
}

fn coloured(mesh: &Mesh, found: &Findings) -> Result<Vec<u8>> {
    let faults = found.faults(mesh);
    let colours: Vec<[u8; 3]> =
        faults.iter().map(|f| f.map_or(FAULTLESS_COLOUR, FaceFault::colour)).collect();
    meshes::encode_ply(mesh, Some(MeshColours::OfFaces(&colours)))
}

type Lines = Vec<(&'static str, String)>;

fn lines(found: &Findings, verb: &Check) -> Lines {
    let report = &found.report;
    let yes = |is: bool| if is { "yes" } else { "no" }.to_owned();
    let genus = report.genus().map_or(String::new(), |g| format!(", genus {g}"));
    let mut lines = vec![
        ("size", format!("{} vertices, {} faces", report.vertices, report.faces)),
        ("closed", yes(report.is_closed())),
        ("manifold", yes(report.is_manifold())),
        ("oriented", oriented(found)),
        ("pieces", format!("{}, Euler number {}{genus}", report.components, report.euler())),
    ];
    if let Some(longest) = &report.longest_loop {
        let loops = match report.boundary_loops {
            1 => "1 loop,".to_owned(),
            n => format!("{n} loops, the longest"),
        };
        let text = format!(
            "{loops} of {} edges, {} m, about {}",
            longest.edges,
            say::significant(longest.length, 4),
            place(longest.middle)
        );
        lines.push(("boundary", text));
    }
    if let Some(crossings) = &found.crossings {
        lines.push(("crossings", crossing(crossings)));
    }
    match &found.star {
        Some(star) => star_lines(star, &mut lines),
        None => lines.push(("star-shaped", "cannot be said".to_owned())),
    }
    lines.extend(report.deficiencies().into_iter().map(|text| ("deficiency", text)));
    lines.extend(advice(found).map(|advice| ("help", in_flags(&advice))));
    let files = verb.output.iter().chain(&verb.bad);
    lines.extend(files.map(|path| ("written", path.display().to_string())));
    lines
}

/// Returns what may make the mesh one that can be fitted.
fn advice(found: &Findings) -> Option<Advice> {
    let is_star_shaped = found.star.as_ref().is_some_and(|s| s.judged.is_star_shaped());
    let pieces =
        (found.report.components > 1 && !is_star_shaped).then_some(Advice::KeepLargestPiece);
    found.report.advice().or(pieces)
}

fn oriented(found: &Findings) -> String {
    let report = &found.report;
    match (report.is_oriented(), report.is_closed(), report.is_inside_out()) {
        (false, ..) => "no",
        (_, false, _) => "yes, but what is outside an open mesh does not tell",
        (_, _, true) => "yes, but inwards",
        _ => "yes, outwards",
    }
    .to_owned()
}

fn crossing(found: &SelfIntersections) -> String {
    let Some(first) = found.examples.first() else { return "none".to_owned() };
    let pairs = |n| if n == 1 { "pair of faces crosses" } else { "pairs of faces cross" };
    let [a, b] = first.faces;
    format!(
        "{} {}, the first {a} and {b} at {}",
        found.pairs,
        pairs(found.pairs),
        place(first.point)
    )
}

fn star_lines(star: &StarCheck, lines: &mut Lines) {
    let judged = &star.judged;
    let verdict = if judged.is_star_shaped() { "yes" } else { "no" };
    lines.push(("star-shaped", format!("{verdict}, {}", seen(judged))));
    lines.push(("from the origin", seen(&star.origin)));
    let (best, clearance) = star.best;
    lines.push((
        "best centre",
        format!("{}, clearance {} m", place(best), say::significant(clearance, 4)),
    ));
    if let Some(folds) = &star.folds {
        fold_lines(judged, folds, lines);
    }
}

fn seen(report: &StarReport) -> String {
    let clearance = say::significant(report.clearance.abs(), 4);
    if report.is_star_shaped() {
        return format!("about {}, which every face clears by {clearance} m", place(report.about));
    }
    if report.clearance > 0.0 {
        let count = say::significant(report.covering.round(), 1);
        return format!(
            "about {}, around which go {count} surfaces, one within the other",
            place(report.about)
        );
    }
    format!(
        "about {}, which lies {clearance} m behind face {}",
        place(report.about),
        report.worst_face
    )
}

fn fold_lines(judged: &StarReport, folds: &Folds, lines: &mut Lines) {
    let percent = |share: f64| say::percent(share);
    lines.push((
        "turned faces",
        format!(
            "{} in {} patches, {} of the area",
            judged.turned_faces,
            folds.patches.len(),
            percent(judged.turned_area)
        ),
    ));
    let mut text = format!("{} of all meet the mesh twice or from behind", percent(folds.share));
    if folds.unmet > 0.0 {
        text = format!("{text}, {} meet nothing", percent(folds.unmet));
    }
    lines.push(("directions", format!("{text} (within {})", percent(folds.error))));
    for patch in folds.patches.iter().take(SHOWN) {
        lines.push(("patch", fold(patch)));
    }
}

/// How many patches, and faces of each, are shown.
const SHOWN: usize = 3;

fn fold(patch: &Fold) -> String {
    let first: Vec<String> = patch.faces.iter().take(SHOWN).map(u32::to_string).collect();
    let more = if patch.faces.len() > SHOWN { ", ..." } else { "" };
    format!(
        "{} ({}{more}) about {}, {} of the sphere",
        match patch.faces.len() {
            1 => "1 face".to_owned(),
            n => format!("{n} faces"),
        },
        first.join(", "),
        place(patch.middle),
        say::percent(patch.solid_angle)
    )
}

fn place(p: DVec3) -> String {
    // What is nothing but rounding beside the largest coordinate is shown as nothing.
    let least = 1e-12 * p.abs().max_element();
    let [x, y, z] =
        p.to_array().map(|v| say::significant(if v.abs() <= least { 0.0 } else { v }, 4));
    format!("({x}, {y}, {z}) m")
}

fn value(found: &Findings, repair: Option<&RepairReport>, verb: &Check) -> Value {
    let report = &found.report;
    let mut value = json!({
        "sound": found.is_sound(),
        "vertices": report.vertices,
        "faces": report.faces,
        "closed": report.is_closed(),
        "manifold": report.is_manifold(),
        "oriented": report.is_oriented(),
        "inside_out": report.is_inside_out(),
        "components": report.components,
        "euler": report.euler(),
        "genus": report.genus(),
        "boundary_edges": report.boundary,
        "boundary_loops": report.boundary_loops,
        "longest_loop": report.longest_loop.map(|l| json!({
            "edges": l.edges, "length": l.length, "middle": l.middle.to_array()
        })),
        "non_manifold_edges": report.non_manifold,
        "inconsistent_edges": report.inconsistent,
        "pinched_vertices": report.pinched,
        "zero_area_faces": report.degenerate,
        "duplicate_faces": report.duplicate,
        "unused_vertices": report.unused_vertices,
        "non_finite_vertices": report.non_finite,
        "crossings": found.crossings.as_ref().map(|c| json!({
            "pairs": c.pairs,
            "faces": c.faces,
            "first": c.examples.first().map(|e| json!({
                "faces": e.faces, "point": e.point.to_array()
            })),
        })),
        "star": found.star.as_ref().map(star_value),
        "deficiencies": report.deficiencies(),
        "repair": repair.map(repair_value),
    });
    let written = verb.output.iter().chain(&verb.bad);
    paths::put_all(&mut value, "written", written.map(PathBuf::as_path));
    value
}

fn star_value(star: &StarCheck) -> Value {
    let judged = &star.judged;
    let centre =
        |(at, clearance): (DVec3, f64)| json!({ "at": at.to_array(), "clearance": clearance });
    json!({
        "star_shaped": judged.is_star_shaped(),
        "about": judged.about.to_array(),
        "clearance": judged.clearance,
        "worst_face": judged.worst_face,
        "origin_clearance": star.origin.clearance,
        "best_centre": centre(star.best),
        "preferred_centre": centre(star.preferred),
        "turned_faces": judged.turned_faces,
        "turned_area": judged.turned_area,
        "folds": star.folds.as_ref().map(|folds| json!({
            "share": folds.share,
            "unmet": folds.unmet,
            "error": folds.error,
            "patches": folds.patches.iter().map(|p| json!({
                "faces": p.faces,
                "area": p.area,
                "solid_angle": p.solid_angle,
                "middle": p.middle.to_array(),
            })).collect::<Vec<_>>(),
        })),
    })
}

fn repair_value(done: &RepairReport) -> Value {
    json!({
        "welded_vertices": done.welded,
        "zero_area_faces": done.zero_area,
        "duplicate_faces": done.duplicate,
        "turned_faces": done.turned,
        "dropped_pieces": done.pieces,
        "filled_holes": done.filled,
        "unused_vertices": done.unused,
    })
}
