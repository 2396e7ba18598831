//! Continuous normals: the largest turn of the normal between neighbouring hits of a scan line.

use std::f64::consts::TAU;

use glam::DVec3;
use harmolux::math::Ray;
use harmolux::math::stats::median;
use harmolux::surface::{Intersector, MeshSurface, ShSurface, Surface};
use harmolux::{Error, Result};

use super::{Claim, Run, Table, Verdict, by_group, digits, grouped};

/// Hits once around the head, each ten times as many.
const COUNTS: [u32; 4] = [1_000, 10_000, 100_000, 1_000_000];
/// A continuous normal turns by a tenth where the step is a tenth; by how much more it may.
const SLACK: f64 = 2.0;

/// Holds what a scan line of so many hits shows, degrees.
struct Row {
    count: u32,
    series: f64,
    mesh: f64,
    /// The median angle between the two normals.
    apart: f64,
}

pub(super) fn claims(run: &Run) -> Result<Vec<Claim>> {
    let series = ShSurface::new(&run.head.coefficients, Intersector::default())?;
    let mesh = MeshSurface::new(run.mesh.translated(-run.head.centre))?;
    let counts = &COUNTS[..run.choose(3, 4)];
    let rows = counts.iter().map(|n| row(&series, &mesh, *n)).collect::<Result<Vec<_>>>()?;
    // The coarsest line does not resolve the series yet.
    let [.., before, last] = &rows[..] else { unreachable!("three rows or four") };
    let steps = f64::from(last.count) / f64::from(before.count);
    let falls = |from: f64, to: f64| to <= SLACK * from / steps;
    let continuous = falls(before.series, last.series);
    let cells = |r: &Row| {
        let shown = |x: f64| digits(x, 3);
        vec![grouped(r.count as usize), shown(r.series), shown(r.mesh), shown(r.apart)]
    };
    Ok(vec![Claim {
        title: "Continuous normals",
        paper_words: "From the view of photometry an essential advantage of this approach is the \
                      continuous reproduction of normals without approximation.",
        place: "Spectral representation of three-dimensional objects",
        paper_number: "continuous".to_owned(),
        ours: format!(
            "largest turn between neighbours {} degrees; the mesh {}",
            digits(last.series, 2),
            digits(last.mesh, 2)
        ),
        error: format!("at {} hits around the head", grouped(last.count as usize)),
        command: by_group("normals"),
        verdict: Verdict::of(continuous && !falls(before.mesh, last.mesh)),
        notes: vec![format!(
            "Rays from the centre in the plane through nose and nape, so that no edge hides \
             another part. Confirmed where the turn falls with the step for the series (to {SLACK} \
             times a tenth or less) and not for the flat faces. Continuous is not yet right: the \
             series has the normals of its own degree, which differ from those of the faces by the \
             angle in the last column."
        )],
        table: Some(Table {
            head: vec![
                "hits",
                "series: largest turn, degrees",
                "mesh: largest turn, degrees",
                "median angle between both, degrees",
            ],
            rows: rows.iter().map(cells).collect(),
        }),
        picture: None,
    }])
}

fn row(series: &ShSurface, mesh: &MeshSurface, count: u32) -> Result<Row> {
    let (of_series, of_mesh) = (scan(series, count)?, scan(mesh, count)?);
    let apart = of_series.iter().zip(&of_mesh).map(|(a, b)| angle(*a, *b));
    let apart = median(apart).unwrap_or(f64::NAN);
    Ok(Row { count, series: turn(&of_series), mesh: turn(&of_mesh), apart })
}

/// Returns the normals once around, in the plane x = 0.
fn scan(surface: &dyn Surface, count: u32) -> Result<Vec<DVec3>> {
    let normal = |i: u32| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(count)).sin_cos();
        let hit = surface.hit(&Ray::new(DVec3::ZERO, DVec3::new(0.0, cos, sin)));
        let hit = hit.ok_or_else(|| Error::Numeric(format!("ray {i} leaves the head unseen")))?;
        Ok(surface.refine(&hit).normal)
    };
    (0..count).map(normal).collect()
}

/// Returns the largest angle between neighbours, degrees.
fn turn(normals: &[DVec3]) -> f64 {
    let pairs = normals.iter().zip(normals.iter().cycle().skip(1));
    pairs.map(|(a, b)| angle(*a, *b)).fold(0.0, f64::max)
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}
