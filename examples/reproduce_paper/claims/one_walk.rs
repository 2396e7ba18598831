//! One walk serves all points: the number of walks and the values do not depend on how many points
//! are asked for.

use glam::DVec3;
use harmolux::Result;
use harmolux::estimators::{Estimator, Survey};
use harmolux::math::Randomness;
use harmolux::math::stats::median;
use harmolux::scene::Sensor;

use super::figure_2::Planes;
use super::{Claim, Run, Table, Verdict, by_group, digits, grouped, percent};
use crate::timing::{Quartiles, on_one_thread, seconds};

const POINTS: [usize; 4] = [1, 10, 100, 1000];
const ROUNDS: usize = 7;
/// The radius of the discs that count photons, in gaps of the planes.
const DISC: f64 = 0.1;

/// Holds what a number of points takes.
struct Row {
    points: usize,
    survey: Survey,
    seconds: f64,
}

pub(super) fn claims(_: &Run) -> Result<Vec<Claim>> {
    let planes = Planes::load()?;
    let rows =
        on_one_thread(|| POINTS.iter().map(|n| row(&planes, *n)).collect::<Result<Vec<_>>>())?;
    let walks = rows[0].survey.walks;
    let first = rows[0].survey.results[0].total;
    let same = rows.iter().all(|r| r.survey.walks == walks && r.survey.results[0].total == first);
    let cells = |r: &Row| {
        let e = r.survey.results[0].total;
        vec![
            grouped(r.points),
            r.survey.walks.to_string(),
            format!("{:.6} +- {:.6}", e.mean, e.standard_error),
            digits(1e3 * r.seconds, 2),
        ]
    };
    Ok(vec![Claim {
        title: "One walk serves all points",
        paper_words: "The local estimate computes by one ray the illuminance at several points at \
                      once. This is a principal difference from direct simulation and ray tracing.",
        place: "The local estimate, eq. 5",
        paper_number: "one set of walks".to_owned(),
        ours: format!(
            "{walks} walks for {} point and for {}",
            POINTS[0],
            grouped(POINTS[POINTS.len() - 1])
        ),
        error: if same {
            "none: the value of the first point is the same to the bit".to_owned()
        } else {
            "walks or values of the first point differ".to_owned()
        },
        command: by_group("one_walk"),
        verdict: Verdict::of(same),
        notes: vec![
            "Sobolev's planes (Figure 2), points from r = 0 to 3; medians of one thread in turns."
                .to_owned(),
            others(&planes)?,
        ],
        table: Some(Table {
            head: vec!["points", "walks", "E(0), lx, with its standard error", "ms"],
            rows: rows.iter().map(cells).collect(),
        }),
        picture: None,
    }])
}

fn row(planes: &Planes, points: usize) -> Result<Row> {
    let place = |i: usize| DVec3::X * (3.0 * i as f64 / points as f64);
    let sensors: Vec<_> = (0..points).map(|i| Sensor::plane(place(i), DVec3::Z)).collect();
    let run = || planes.measure(&sensors, planes.local(), Randomness::Sobol);
    let mut times = Vec::new();
    for _ in 1..ROUNDS {
        times.push(seconds(run)?.0);
    }
    let (last, survey) = seconds(run)?;
    times.push(last);
    Ok(Row { points, survey, seconds: Quartiles::of(&times).median })
}

/// Compares with the two that the paper names, at the points of Figure 2.
fn others(planes: &Planes) -> Result<String> {
    let error = |estimator, randomness| -> Result<String> {
        let survey = planes.measure(&planes.sensors, estimator, randomness)?;
        let errors = survey.results.iter().map(|r| r.total.relative_error());
        Ok(percent(median(errors).unwrap_or(f64::NAN), 2))
    };
    let random = Randomness::Pseudorandom;
    Ok(format!(
        "With random numbers at the {} points of Figure 2, median relative standard \
         error: local estimate {}; direct simulation, as many walks counted on discs of radius \
         {DISC} m, {}; path tracing, as many paths for each point by itself, {}.",
        planes.sensors.len(),
        error(planes.local(), random)?,
        error(Estimator::Photon { radius: Some(DISC) }, random)?,
        error(Estimator::Path, random)?
    ))
}
