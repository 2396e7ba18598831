//! Figure 2: the local estimate with 2000 walks against the exact solution of Sobolev's problem.

use harmolux::Result;
use harmolux::estimators::{Estimator, SensorSettings, Stop, Survey, Weighting, illuminance};
use harmolux::exact::{Plane, SobolevProblem};
use harmolux::io::scene_file::SceneFile;
use harmolux::math::Randomness;
use harmolux::plots::{Axis, Curve, Figure, Style};
use harmolux::scene::{Scene, Sensor};
use harmolux::study::load;

use super::{Claim, Run, Verdict, data, digits, go_on, largest, percent};
use crate::figures::Picture;
use crate::timing::{Quartiles, on_one_thread, seconds};

/// The walks of the paper.
pub(crate) const WALKS: u64 = 2000;
const COMMAND: &str = "harmolux illum data/scenes/sobolev.toml -o figure_2.svg";
/// What the eye takes for one curve: of the height of the figure.
const INDISTINGUISHABLE: f64 = 0.01;
const ROUNDS: usize = 15;

/// Holds Sobolev's planes as the scene file has them.
pub(crate) struct Planes {
    pub(crate) scene: Scene,
    pub(crate) sensors: Vec<Sensor>,
    pub(crate) exact: SobolevProblem,
}

impl Planes {
    pub(crate) fn load() -> Result<Self> {
        let loaded = load(&SceneFile::read(&data("scenes/sobolev.toml"), &[])?)?;
        let sensors = loaded.sensors.into_iter().flat_map(|group| group.sensors).collect();
        Ok(Self { scene: loaded.scene, sensors, exact: SobolevProblem::default() })
    }

    /// Returns the exact illuminance of a sensor.
    pub(crate) fn at(&self, sensor: &Sensor) -> Result<f64> {
        self.exact.illuminance(Plane::Lower, sensor.at.x)
    }

    pub(crate) fn measure(
        &self,
        sensors: &[Sensor],
        estimator: Estimator,
        randomness: Randomness,
    ) -> Result<Survey> {
        let stop = Stop { walks: Some(WALKS), ..Stop::default() };
        let settings = SensorSettings { estimator, randomness, seed: 1, stop };
        illuminance(&self.scene, sensors, &settings, &go_on)
    }

    pub(crate) fn local(&self) -> Estimator {
        Estimator::Local(Weighting::of(&self.scene))
    }
}

pub(super) fn claims(_: &Run) -> Result<Vec<Claim>> {
    let planes = Planes::load()?;
    let survey = planes.measure(&planes.sensors, planes.local(), Randomness::Sobol)?;
    let random = planes.measure(&planes.sensors, planes.local(), Randomness::Pseudorandom)?;
    Ok(vec![curve(&planes, &survey, &random)?, time(&planes)?])
}

/// How far a survey is from the exact curve.
struct Distance {
    /// The largest |dE| / E(0).
    of_height: f64,
    /// The largest deviation in standard errors.
    deviation: f64,
    /// Whether all values together agree with the exact ones.
    agrees: bool,
}

fn distance(planes: &Planes, survey: &Survey) -> Result<Distance> {
    let exact: Vec<f64> = planes.sensors.iter().map(|s| planes.at(s)).collect::<Result<_>>()?;
    let pairs = || survey.results.iter().map(|r| r.total).zip(&exact);
    Ok(Distance {
        of_height: largest(pairs().map(|(e, x)| (e.mean - x).abs() / exact[0])),
        deviation: largest(pairs().map(|(e, x)| e.deviation(*x).abs())),
        agrees: pairs().all(|(e, x)| e.agrees_with(*x, 0.0, exact.len())),
    })
}

fn curve(planes: &Planes, survey: &Survey, random: &Survey) -> Result<Claim> {
    let (own, plain) = (distance(planes, survey)?, distance(planes, random)?);
    let relative = largest(survey.results.iter().map(|r| r.total.relative_half_width()));
    Ok(Claim {
        title: "Figure 2: 2000 walks lie on the exact curve",
        paper_words: "Figure 2 compares the illuminance that we obtained by the local estimate \
                      with the exact solution of Sobolev's problem (7). We used 2000 rays.",
        place: "Accuracy of the local estimate; h1 = h2 = 0.5, both reflectances 0.5",
        paper_number: "one curve to the eye".to_owned(),
        ours: format!("largest |dE| / E(0) {}", percent(own.of_height, 2)),
        error: format!(
            "largest deviation from the exact value {} standard errors of {} points together",
            digits(own.deviation, 2),
            planes.sensors.len()
        ),
        command: COMMAND.to_owned(),
        verdict: Verdict::of(own.agrees && own.of_height <= INDISTINGUISHABLE),
        notes: vec![format!(
            "{} walks (a multiple of 32, the replicates), scrambled Sobol points, seed 1; the \
             widest 95 % interval is {} of its value. Plain random numbers, which the paper has: \
             largest |dE| / E(0) {}, {} standard errors. Confirmed where all points together agree \
             with the exact values (false-alarm rate 1e-3) and lie within {} of E(0).",
            survey.walks,
            percent(relative, 2),
            percent(plain.of_height, 2),
            digits(plain.deviation, 2),
            percent(INDISTINGUISHABLE, 1)
        )],
        table: None,
        picture: Some(picture(planes, survey)?),
    })
}

fn picture(planes: &Planes, survey: &Survey) -> Result<Picture> {
    let exact = (0..=240).map(|i| f64::from(i) / 80.0);
    let exact = exact.map(|r| Ok([r, planes.exact.illuminance(Plane::Lower, r)?]));
    let results = survey.results.iter().map(|r| r.total);
    let points = planes.sensors.iter().zip(results.clone()).map(|(s, e)| [s.at.x, e.mean]);
    let errors = results.map(|e| [e.half_width(0.05); 2]).collect();
    let curves = vec![
        Curve::new("exact, eq. 7 corrected", exact.collect::<Result<_>>()?).drawn(Style::Line),
        Curve::new(format!("local estimate, {} walks", survey.walks), points.collect())
            .drawn(Style::Points)
            .with_errors(errors),
    ];
    let axes = [Axis::linear("r, m"), Axis::linear("illuminance, lx")];
    let bytes = Figure::new("Figure 2: Sobolev's problem", axes, curves).to_svg()?.into_bytes();
    let caption = "Figure 2 again: the local estimate on the exact curve, with 95 % intervals";
    Ok(Picture { name: "figure_2.svg", caption: caption.to_owned(), bytes })
}

fn time(planes: &Planes) -> Result<Claim> {
    let times = on_one_thread(|| {
        let once = |_| {
            let run = || planes.measure(&planes.sensors, planes.local(), Randomness::Sobol);
            Ok(seconds(run)?.0)
        };
        (0..ROUNDS).map(once).collect::<Result<Vec<f64>>>()
    })?;
    let times = Quartiles::of(&times);
    Ok(Claim {
        title: "Figure 2 takes less than a second",
        paper_words: "The time was less than 1 second on a computer with the processor AMD Athlon \
                      64 X2 5200.",
        place: "Accuracy of the local estimate",
        paper_number: "< 1 s".to_owned(),
        ours: format!("{} ms", digits(1e3 * times.median, 2)),
        error: format!(
            "median of {ROUNDS} runs on one thread, quartiles {} to {} ms",
            digits(1e3 * times.first, 2),
            digits(1e3 * times.third, 2)
        ),
        command: COMMAND.to_owned(),
        verdict: Verdict::of(times.third < 1.0),
        notes: vec!["The walks and all points, without the reading of files.".to_owned()],
        table: None,
        picture: None,
    })
}
