//! The time of a picture with the head as harmonics, over that with the head as a mesh.

use std::path::{Path, PathBuf};

use harmolux::estimators::{Estimator, ImageSettings, Stop, Weighting, render};
use harmolux::fit::Shape;
use harmolux::io::coefficients::shtools_text;
use harmolux::io::scene_file::SceneFile;
use harmolux::math::Randomness;
use harmolux::scene::Filter;
use harmolux::sh::Convention;
use harmolux::study::{camera, load};
use harmolux::{Error, Result};

use super::figure_3::SCENE;
use super::{Claim, Run, Table, Verdict, by_group, data, digits, go_on};
use crate::timing::{Quartiles, on_one_thread, seconds};

/// Eye rays to a pixel, of 32 walks each.
const WALKS: u64 = 256;
const CLAIMED: f64 = 1.4;
/// By how much a ratio may differ from the claimed one and still be it.
const NEAR: f64 = 0.1;

/// Holds the seconds to load and to render a scene.
type Times = [f64; 2];
/// Picks what is counted of them.
type Part = fn(Times) -> f64;

/// Holds the times of both sides, series first, round by round.
struct Measured {
    /// The coefficients read from a file.
    stored: Vec<[Times; 2]>,
    /// The mesh read, and fitted.
    fitted: Vec<[Times; 2]>,
    /// Rays met by steps and bisection, in a small picture.
    march: Vec<[Times; 2]>,
}

const WHOLE: Part = |[load, render]| load + render;
const PICTURE: Part = |[_, render]| render;

pub(super) fn claims(run: &Run) -> Result<Vec<Claim>> {
    let rounds = run.choose(5, 15);
    let size = run.choose([160, 120], [320, 240]);
    let small = [size[0] / 4, size[1] / 4];
    let measured = measure(run, size, small, rounds)?;
    let ratio = ratios(&measured.stored, WHOLE);
    Ok(vec![Claim {
        title: "Harmonics take 40 % more time than a mesh",
        paper_words: "The time of computation with spherical harmonics grew by 40 %.",
        place: "Implementation, Figure 3",
        paper_number: "1.40 times".to_owned(),
        ours: format!("{} times", digits(ratio.median, 3)),
        error: format!(
            "median of {rounds} runs in turns, quartiles {} to {}",
            digits(ratio.first, 3),
            digits(ratio.third, 3)
        ),
        command: by_group("time"),
        verdict: Verdict::of_number(
            [CLAIMED - NEAR, CLAIMED + NEAR],
            [ratio.first, ratio.third],
            ratio.first > 1.0,
        ),
        notes: vec![format!(
            "The room of Figure 3 at {} x {} pixels, {WALKS} walks a pixel on both sides, one \
             thread. A whole run reads the mesh, or the coefficients, and prepares it for rays; \
             with the series fitted first it reads the mesh on both sides. The last row has the \
             paper's way to meet a ray: steps of a hundredth of the largest radius on the series \
             itself, then bisection; {} x {} pixels.",
            size[0], size[1], small[0], small[1]
        )],
        table: Some(table(&measured)),
        picture: None,
    }])
}

fn measure(run: &Run, size: [u32; 2], small: [u32; 2], rounds: usize) -> Result<Measured> {
    let folder = tempfile::tempdir().map_err(|e| Error::Parameter(format!("no folder: {e}")))?;
    let stored = scene(&Version::Stored(&store(run, folder.path())?))?;
    let (fitted, march) = (scene(&Version::Fitted)?, scene(&Version::March)?);
    let mesh = scene(&Version::Mesh)?;
    on_one_thread(|| {
        Ok(Measured {
            stored: alternate([&stored, &mesh], size, rounds)?,
            fitted: alternate([&fitted, &mesh], size, rounds / 2)?,
            march: alternate([&march, &mesh], small, rounds / 2)?,
        })
    })
}

fn table(measured: &Measured) -> Table {
    let row = |what: &str, rounds: &[[Times; 2]], time: Part| {
        let seconds = |side: usize| {
            let times: Vec<f64> = rounds.iter().map(|round| time(round[side])).collect();
            digits(Quartiles::of(&times).median, 3)
        };
        let ratio = ratios(rounds, time).show(|x| digits(x, 3));
        vec![what.to_owned(), rounds.len().to_string(), seconds(0), seconds(1), ratio]
    };
    Table {
        head: vec!["what", "runs", "series, s", "mesh, s", "ratio (quartiles)"],
        rows: vec![
            row("whole run, both read from files", &measured.stored, WHOLE),
            row("the picture alone", &measured.stored, PICTURE),
            row("whole run, series fitted first", &measured.fitted, WHOLE),
            row("the picture, steps and bisection", &measured.march, PICTURE),
        ],
    }
}

fn ratios(rounds: &[[Times; 2]], time: Part) -> Quartiles {
    let ratios: Vec<f64> = rounds.iter().map(|[a, b]| time(*a) / time(*b)).collect();
    Quartiles::of(&ratios)
}

/// Names how the head is given.
enum Version<'a> {
    /// As a file of coefficients.
    Stored(&'a Path),
    /// As the mesh, to be fitted.
    Fitted,
    /// The same, met by steps and bisection.
    March,
    Mesh,
}

/// Writes the head as coefficients, and returns where.
fn store(run: &Run, folder: &Path) -> Result<PathBuf> {
    let fit = &run.head;
    let shape = Shape { centre: fit.centre, ..Shape::new(fit.coefficients.clone()) };
    let path = folder.join("head.txt");
    std::fs::write(&path, shtools_text::write(&shape, Convention::default())?)
        .map_err(|error| Error::Parameter(format!("{}: {error}", path.display())))?;
    Ok(path)
}

/// Returns the scene of Figure 3 with the head in one of its forms.
fn scene(version: &Version) -> Result<SceneFile> {
    let path = data(SCENE);
    let text = std::fs::read_to_string(&path)
        .map_err(|error| Error::Parameter(format!("{}: {error}", path.display())))?;
    match version {
        Version::Fitted => SceneFile::parse(&path, &text, &[]),
        Version::Stored(head) => {
            let head = format!("'{}'", head.display());
            SceneFile::parse(&path, &text, &[("objects.head.sh.file", &head)])
        }
        Version::March => {
            let march = [("objects.head.sh.intersector", "\"step-bisection\"")];
            SceneFile::parse(&path, &text, &march)
        }
        Version::Mesh => {
            let text = text.replace("[objects.head.sh]", "[objects.head.mesh]");
            SceneFile::parse(&path, &text.replace("\ndegree = 32\n", "\n"), &[])
        }
    }
}

fn alternate(files: [&SceneFile; 2], size: [u32; 2], rounds: usize) -> Result<Vec<[Times; 2]>> {
    let round = |_| Ok([time(files[0], size)?, time(files[1], size)?]);
    // The first round fills caches and is not counted.
    (0..=rounds).map(round).skip(1).collect()
}

fn time(file: &SceneFile, size: [u32; 2]) -> Result<Times> {
    let (loading, scene) = seconds(|| Ok(load(file)?.scene))?;
    let camera = camera(file)?.with_resolution(size);
    let settings = ImageSettings {
        estimator: Estimator::Local(Weighting::of(&scene)),
        randomness: Randomness::Sobol,
        seed: 1,
        stop: Stop { walks: Some(WALKS), ..Stop::default() },
        filter: Filter::Box,
    };
    let (rendering, _) = seconds(|| render(&scene, &camera, &settings, &go_on))?;
    Ok([loading, rendering])
}
