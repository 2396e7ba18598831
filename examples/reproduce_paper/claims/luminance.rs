//! The double local estimate: luminance at a point in a direction, against exact values and path
//! tracing.

use glam::{DVec2, DVec3};
use harmolux::Result;
use harmolux::estimators::{Estimator, SensorSettings, Stop, Survey, Weighting, luminance};
use harmolux::exact::Plane;
use harmolux::io::scene_file::SceneFile;
use harmolux::math::stats::Estimate;
use harmolux::math::{Randomness, Ray};
use harmolux::scene::{Measured, Scene};
use harmolux::study::{camera, load};

use super::figure_2::Planes;
use super::{Claim, Run, Table, Verdict, data, digits, go_on, largest};

/// From where the planes are looked at.
const EYES: [DVec3; 2] = [DVec3::new(2.4, -1.8, 0.42), DVec3::new(-1.0, 1.0, 0.6)];
const RADII: [f64; 5] = [0.0, 0.5, 1.0, 2.0, 3.0];
const PROBE: &str = "echo 2.4 -1.8 0.42 -1.4 1.8 -0.42 | harmolux probe data/scenes/sobolev.toml";
/// Rays across the picture of glossy bodies, a side.
const SIDE: u32 = 4;

/// Holds a ray and the exact luminance along it, cd/m2.
struct View {
    place: String,
    ray: Ray,
    exact: f64,
}

pub(super) fn claims(run: &Run) -> Result<Vec<Claim>> {
    let planes = Planes::load()?;
    let views = views(&planes)?;
    let rays: Vec<Ray> = views.iter().map(|view| view.ray).collect();
    let walks = run.choose(1 << 13, 1 << 17);
    let local = measure(&planes.scene, &rays, planes.local(), walks)?;
    let path = measure(&planes.scene, &rays, Estimator::Path, walks)?;
    Ok(vec![directly(run, &views, &local)?, only_method(&views, &local, &path)])
}

/// Returns for each point of the planes the views from all eyes.
fn views(planes: &Planes) -> Result<Vec<View>> {
    let mut views = Vec::new();
    for (name, plane, z) in [("lower", Plane::Lower, 0.0), ("upper", Plane::Upper, 1.0)] {
        for radius in RADII {
            let exact = planes.exact.luminance(plane, radius)?;
            for from in EYES {
                let direction = (DVec3::new(radius, 0.0, z) - from).normalize();
                let place = format!("{name}, {radius}");
                views.push(View { place, ray: Ray::new(from, direction), exact });
            }
        }
    }
    Ok(views)
}

fn measure(scene: &Scene, rays: &[Ray], estimator: Estimator, walks: u64) -> Result<Survey> {
    let stop = Stop { walks: Some(walks), ..Stop::default() };
    let settings = SensorSettings { estimator, randomness: Randomness::Sobol, seed: 1, stop };
    luminance(scene, rays, &settings, &go_on)
}

/// Returns the largest deviation in standard errors, and whether all agree together.
fn judge(views: &[View], survey: &Survey) -> (f64, bool) {
    let pairs = || survey.results.iter().map(|r| r.total).zip(views);
    let deviation = largest(pairs().map(|(e, view)| e.deviation(view.exact).abs()));
    (deviation, pairs().all(|(e, view)| e.agrees_with(view.exact, 0.0, views.len())))
}

fn directly(run: &Run, views: &[View], local: &Survey) -> Result<Claim> {
    let (deviation, agrees) = judge(views, local);
    let relative = largest(local.results.iter().map(|r| r.total.relative_error()));
    let glossy = glossy(run)?;
    let shown = |e: Estimate| format!("{:.6} +- {:.6}", e.mean, e.standard_error);
    let row = |(views, results): (&[View], &[Measured])| {
        let mut row = vec![views[0].place.clone()];
        row.extend(results.iter().map(|result| shown(result.total)));
        row.push(format!("{:.6}", views[0].exact));
        row.push(format!("{:+.2}", results[0].total.deviation(views[0].exact)));
        row
    };
    let rows = views.chunks(EYES.len()).zip(local.results.chunks(EYES.len()));
    Ok(Claim {
        title: "The double local estimate gives luminance",
        paper_words: "The double local estimate allows to compute the luminance at a given point \
                      in a given direction directly.",
        place: "The double local estimate, eq. 11; conclusion",
        paper_number: "no number".to_owned(),
        ours: format!(
            "{} luminances, the largest deviation from the exact ones {} standard errors",
            views.len(),
            digits(deviation, 2)
        ),
        error: format!("largest relative standard error {:.3} %", 100.0 * relative),
        command: PROBE.to_owned(),
        verdict: Verdict::of(agrees && glossy.agrees),
        notes: vec![
            format!(
                "Sobolev's planes from two eyes: L = rho E(r) / pi from everywhere, {} walks. The \
                 deviation, in standard errors, is that of the first eye.",
                local.walks
            ),
            glossy.text,
        ],
        table: Some(Table {
            head: vec!["plane, r in m", "L, cd/m2, eye 1", "L, eye 2", "exact", "deviation"],
            rows: rows.map(row).collect(),
        }),
        picture: None,
    })
}

struct Glossy {
    text: String,
    agrees: bool,
}

/// Holds rays into a scene whose surfaces reflect otherwise in each direction to path tracing.
fn glossy(run: &Run) -> Result<Glossy> {
    let file = SceneFile::read(&data("scenes/glossy.toml"), &[])?;
    let (scene, camera) = (load(&file)?.scene, camera(&file)?);
    let size = camera.resolution();
    let place = |k: u32, i: usize| (f64::from(k) + 0.5) * f64::from(size[i]) / f64::from(SIDE);
    let cells = (0..SIDE * SIDE).map(|i| DVec2::new(place(i % SIDE, 0), place(i / SIDE, 1)));
    let rays: Vec<Ray> = cells.filter_map(|film| camera.ray(film)).collect();
    let walks = run.choose(1 << 12, 1 << 16);
    let local = measure(&scene, &rays, Estimator::Local(Weighting::of(&scene)), walks)?;
    let path = measure(&scene, &rays, Estimator::Path, 4 * walks)?;
    let totals =
        |survey: &Survey| -> Vec<Estimate> { survey.results.iter().map(|r| r.total).collect() };
    let pairs: Vec<_> = totals(&local).into_iter().zip(totals(&path)).collect();
    let z = |(a, b): &(Estimate, Estimate)| {
        (a.mean - b.mean).abs() / a.standard_error.hypot(b.standard_error)
    };
    // A lamp that is seen straight has no error.
    let noisy = pairs.iter().filter(|(a, b)| a.standard_error.hypot(b.standard_error) > 0.0);
    let agree =
        |(a, b): &(Estimate, Estimate)| a.agrees_with(b.mean, b.standard_error, pairs.len());
    let text = format!(
        "Glossy bodies and a mirror (data/scenes/glossy.toml), {} rays of its camera, against path \
         tracing: the largest difference is {} standard errors.",
        pairs.len(),
        digits(largest(noisy.map(z)), 2)
    );
    Ok(Glossy { text, agrees: pairs.iter().all(agree) })
}

fn only_method(views: &[View], local: &Survey, path: &Survey) -> Claim {
    let (deviation, agrees) = judge(views, path);
    let sum = |survey: &Survey| -> f64 {
        survey.results.iter().map(|r| r.total.relative_error().powi(2)).sum()
    };
    Claim {
        title: "No other method computes luminance",
        paper_words: "To this day we know no method and no program that computes luminance \
                      directly. The double local estimate is the only one.",
        place: "The double local estimate",
        paper_number: "no other".to_owned(),
        ours: format!(
            "path tracing finds the same {} luminances, largest deviation {} standard errors",
            views.len(),
            digits(deviation, 2)
        ),
        error: format!(
            "its variance is {} times that of the double local estimate, walk for path",
            digits(sum(path) / sum(local), 2)
        ),
        command: format!("{PROBE} -D illum.estimator=path"),
        verdict: Verdict::of(!agrees),
        notes: vec![
            "Path tracing solves the same equation for a point and a direction (Kajiya 1986), and \
             programs computed luminance by rays backwards before 2012 (Radiance, 1985 on)."
                .to_owned(),
        ],
        table: None,
        picture: None,
    }
}
