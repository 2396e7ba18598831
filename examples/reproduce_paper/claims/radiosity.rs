//! The local estimate against radiosity at equal accuracy, in Sobolev's problem between discs.

use harmolux::Result;
use harmolux::estimators::{
    Estimator, RadiositySettings, SensorSettings, Stop, Weighting, illuminance,
};
use harmolux::exact::{Plane, SobolevProblem};
use harmolux::io::scene_file::SceneFile;
use harmolux::math::Randomness;
use harmolux::scene::{Scene, Sensor};
use harmolux::study::load;

use super::{Claim, Run, Table, Verdict, data, digits, go_on, largest, percent};
use crate::timing::{Quartiles, on_one_thread, seconds};

const POINTS: &str = "[[0, 0, 0], [0.333333333333, 0, 0], [0.666666666667, 0, 0], [1, 0, 0], \
     [1.333333333333, 0, 0], [1.666666666667, 0, 0], [2, 0, 0], [2.333333333333, 0, 0], \
     [2.666666666667, 0, 0], [3, 0, 0]]";
/// The radius of the discs in the scene, metres.
const RADIUS: f64 = 10.0;
const PATCHES: [usize; 5] = [200, 500, 1000, 2000, 4000];
/// Seeds that the error of a number of walks is taken over.
const SEEDS: u64 = 32;
const CLAIMED: [f64; 2] = [80.0, 90.0];

/// Holds the discs, ten points and their exact illuminances.
struct Discs {
    scene: Scene,
    sensors: Vec<Sensor>,
    exact: Vec<f64>,
}

/// Holds patches and walks of one accuracy.
#[derive(Clone, Copy)]
struct Equal {
    patches: usize,
    error: f64,
    walks: u64,
    /// The error of so many walks, root mean square over seeds of its own.
    local_error: f64,
}

/// Holds what both sides take to one accuracy.
struct Row {
    equal: Equal,
    /// Seconds of each side in each round.
    times: Vec<[f64; 2]>,
}

pub(super) fn claims(run: &Run) -> Result<Vec<Claim>> {
    let discs = Discs::load()?;
    let curve = (0..5).map(|k| {
        let walks = 128 << (2 * k);
        Ok((walks as f64, discs.rms(walks, 1..=SEEDS)?))
    });
    let curve = curve.collect::<Result<Vec<_>>>()?;
    let (patches, rounds) = (&PATCHES[..run.choose(4, 5)], run.choose(5, 15));
    let equal = patches.iter().map(|n| discs.equal(*n, &curve)).collect::<Result<Vec<_>>>()?;
    let rows = on_one_thread(|| {
        equal.into_iter().map(|e| discs.row(e, rounds)).collect::<Result<Vec<_>>>()
    })?;
    let all: Vec<f64> = rows.iter().flat_map(Row::ratios).collect();
    let medians = rows.iter().map(|row| Quartiles::of(&row.ratios().collect::<Vec<_>>()).median);
    let (least, most) = medians.fold((f64::INFINITY, 0.0_f64), |(a, b), m| (a.min(m), b.max(m)));
    let own = Quartiles::of(&all);
    Ok(vec![Claim {
        title: "Radiosity takes 80 to 90 times as long",
        paper_words: "We also implemented the radiosity method for eq. 2. At the same given \
                      accuracy the local estimate converges 80 to 90 times faster on average, on \
                      the example of Sobolev's problem.",
        place: "Accuracy of the local estimate, after Figure 2",
        paper_number: "80 to 90".to_owned(),
        ours: format!("{} to {}, by accuracy", digits(least, 2), digits(most, 2)),
        error: format!(
            "all {} ratios: median {}, quartiles {} to {}",
            all.len(),
            digits(own.median, 2),
            digits(own.first, 2),
            digits(own.third, 2)
        ),
        command: "python3 benches/radiosity.py target/release/harmolux".to_owned(),
        verdict: Verdict::of_number(CLAIMED, [least, most], least > 1.0),
        notes: notes(rounds),
        table: Some(table(&rows)),
        picture: None,
    }])
}

fn notes(rounds: usize) -> Vec<String> {
    vec![format!(
        "Radiosity needs bounded surfaces: discs of radius {RADIUS} in place of the planes, ten \
         points from r = 0 to 3, the largest |dE| / E(0) against the exact solution for discs. The \
         local estimate gets as many walks as have that error, root mean square over {SEEDS} \
         seeds, and turns with radiosity, {rounds} times with new seeds, on one thread. Our \
         radiosity has patches graded towards the source, contour form factors and a final gather \
         at the points; the paper does not describe its own."
    )]
}

fn table(rows: &[Row]) -> Table {
    let ms = |seconds: f64| digits(1e3 * seconds, 3);
    let row = |row: &Row| {
        let side = |i: usize| {
            let times: Vec<f64> = row.times.iter().map(|times| times[i]).collect();
            Quartiles::of(&times).show(ms)
        };
        let ratios: Vec<f64> = row.ratios().collect();
        vec![
            row.equal.patches.to_string(),
            percent(row.equal.error, 2),
            side(0),
            row.equal.walks.to_string(),
            percent(row.equal.local_error, 2),
            side(1),
            Quartiles::of(&ratios).show(|x| digits(x, 3)),
        ]
    };
    Table {
        head: vec![
            "patches",
            "error",
            "radiosity, ms",
            "walks",
            "error, rms",
            "local estimate, ms",
            "ratio",
        ],
        rows: rows.iter().map(row).collect(),
    }
}

impl Row {
    fn ratios(&self) -> impl Iterator<Item = f64> + '_ {
        self.times.iter().map(|[radiosity, local]| radiosity / local)
    }
}

impl Discs {
    fn load() -> Result<Self> {
        let points = [("sensors.radius.points.at", POINTS)];
        let loaded = load(&SceneFile::read(&data("scenes/sobolev_discs.toml"), &points)?)?;
        let sensors: Vec<Sensor> = loaded.sensors.into_iter().flat_map(|g| g.sensors).collect();
        let discs = SobolevProblem::default().discs(RADIUS)?;
        let exact = sensors.iter().map(|s| discs.illuminance(Plane::Lower, s.at.x));
        Ok(Self { exact: exact.collect::<Result<_>>()?, scene: loaded.scene, sensors })
    }

    /// Returns the paper's error, the largest |dE| / E(0).
    fn error(&self, estimator: Estimator, walks: Option<u64>, seed: u64) -> Result<f64> {
        let stop = Stop { walks, ..Stop::default() };
        let settings = SensorSettings { estimator, randomness: Randomness::Sobol, seed, stop };
        let survey = illuminance(&self.scene, &self.sensors, &settings, &go_on)?;
        let pairs = survey.results.iter().zip(&self.exact);
        Ok(largest(pairs.map(|(r, exact)| (r.total.mean - exact).abs() / self.exact[0])))
    }

    fn local(&self, walks: u64, seed: u64) -> Result<f64> {
        self.error(Estimator::Local(Weighting::of(&self.scene)), Some(walks), seed)
    }

    fn rms(&self, walks: u64, seeds: impl Iterator<Item = u64>) -> Result<f64> {
        let errors = seeds.map(|seed| self.local(walks, seed)).collect::<Result<Vec<_>>>()?;
        Ok(rms(&errors))
    }

    /// Finds the walks that are as accurate as so many patches.
    fn equal(&self, patches: usize, curve: &[(f64, f64)]) -> Result<Equal> {
        let radiosity =
            Estimator::Radiosity(RadiositySettings { patches, ..RadiositySettings::default() });
        let error = self.error(radiosity, None, 1)?;
        let mut curve = curve.to_vec();
        // The curve is coarse: the second look has a point near by.
        let near = walks_to(&curve, error);
        let place = curve.partition_point(|(walks, _)| *walks < near as f64);
        curve.insert(place, (near as f64, self.rms(near, 200..200 + SEEDS)?));
        let walks = walks_to(&curve, error);
        let local_error = self.rms(walks, 300..300 + SEEDS)?;
        Ok(Equal { patches, error, walks, local_error })
    }

    /// Times both sides in turns.
    fn row(&self, equal: Equal, rounds: usize) -> Result<Row> {
        let patches = equal.patches;
        let radiosity =
            Estimator::Radiosity(RadiositySettings { patches, ..RadiositySettings::default() });
        let mut times = Vec::new();
        for round in 0..rounds as u64 {
            let (theirs, _) = seconds(|| self.error(radiosity, None, 1))?;
            let (own, _) = seconds(|| self.local(equal.walks, 100 + round))?;
            times.push([theirs, own]);
        }
        Ok(Row { equal, times })
    }
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

/// Returns the walks to an error, by a power law between the points of a curve and past its ends;
/// a multiple of 32.
fn walks_to(curve: &[(f64, f64)], error: f64) -> u64 {
    let place = curve.partition_point(|(_, e)| *e > error).clamp(1, curve.len() - 1);
    let ((w0, e0), (w1, e1)) = (curve[place - 1], curve[place]);
    let walks = w0 * (w1 / w0).powf((error / e0).ln() / (e1 / e0).ln());
    (walks / 32.0).ceil().max(1.0) as u64 * 32
}
