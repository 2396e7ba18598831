//! `harmolux illum`: lux at the sensors of a scene.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use harmolux::estimators::{
    Ending, GroupSummary, SensorEstimator, SensorSettings, Survey, Weighting, illuminance,
};
use harmolux::io::scene_file::{IllumEstimator, IllumSpec, RequireSpec, SceneFile, SensorSpec};
use harmolux::io::tables::{Cell, Table};
use harmolux::math::Randomness;
use harmolux::scene::{Measured, Scene, Sensor};
use harmolux::study::{Judged, SensorGroup, Verdict, judge, known};
use harmolux::{Error, Result};

use super::arguments::SceneArguments;
use super::exit::Code;
use super::fit::about;
use super::illum_target::IllumTarget;
use super::plot::{self, PlotFormat};
use super::progress::Meter;
use super::render::{code, load_scene, read_scene, stop};
use super::{illum_report, interrupt, say};

/// Measure illuminance, lx, at the sensors of a scene
///
/// Each value comes with its 95 % interval and the part that arrives directly; each group of sensors with mean, least, largest and U0 = least / mean, each
/// with an interval of its own. Sensors that `[compare]` names stand beside what they are known to receive. What `[require]` asks for is judged by those intervals: met, not met or undecided; unless all is met, the exit code is 4.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux illum room.toml                               a table
  harmolux illum room.toml -o lux.csv                    the same as CSV; `harmolux falsecolor lux.csv` draws its grids
  harmolux illum room.toml -o lux.npy                    the same for numpy.load, shape (sensors, 10)
  harmolux illum data/scenes/sobolev.toml -o fig2.svg    the lines of sensors, with error bars, as a plot
  harmolux illum room.toml -D illum.stop.relative_error=0.001")]
pub(crate) struct Illum {
    #[command(flatten)]
    pub(crate) common: SceneArguments,
    /// Write the values of all sensors (.csv, .npy) or a plot of the lines of sensors (.svg, .png); may be repeated
    ///
    /// The array of an .npy file is float64 of shape (sensors, 10), rows as in the table: x, y, z, normal x, y, z, illuminance, 95 % half width, standard error, direct part; the last four are NaN for a sensor behind an object.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
    /// Replace output files that another program wrote
    #[arg(long)]
    pub(crate) force: bool,
    /// Plot the lines of sensors in the terminal
    #[arg(long)]
    pub(crate) plot: bool,
}

/// Runs the verb.
pub(crate) fn run(verb: &Illum, as_json: bool) -> Result<Code> {
    let file = read_scene(&verb.common)?;
    let mut table = columns();
    check_plots(verb, &file)?;
    let targets = verb.output.iter().map(|path| IllumTarget::open(path, &table, verb.force));
    let targets: Vec<IllumTarget> = targets.collect::<Result<_>>()?;
    let loaded = load_scene(&file)?;
    let known: Vec<Option<Vec<f64>>> =
        loaded.sensors.iter().map(|group| known(&file, group)).collect::<Result<_>>()?;
    let sensors: Vec<Sensor> =
        loaded.sensors.iter().flat_map(|g| g.sensors.iter().copied()).collect();
    if sensors.is_empty() {
        return Err(Error::Parameter(format!(
            "{}: the scene has no sensors; add [sensors.NAME.points], [sensors.NAME.line] or [sensors.NAME.grid]",
            verb.common.scene.display()
        )));
    }
    let settings = settings(&file.illum, &loaded.scene, &verb.common);
    interrupt::listen();
    let meter = Meter::start("measuring", "largest 95 % half width");
    let survey = illuminance(&loaded.scene, &sensors, &settings, &|p| meter.show(p))
        .map_err(|e| about(&verb.common.scene, e))?;
    meter.finish();
    let groups = groups(&loaded.sensors, known, &survey, &file.require);
    fill(&mut table, &groups);
    let lines = groups.iter().filter(|group| is_line(&file.sensors[group.name]));
    let figure = illum_report::figure(lines);
    for target in targets {
        target.write(&table, &figure)?;
    }
    if as_json {
        say::data(&illum_report::json(&table, &groups, &survey)?);
    } else if verb.plot {
        plot::print(&figure)?;
    } else {
        groups.iter().for_each(illum_report::group);
    }
    illum_report::run(&survey);
    for path in &verb.output {
        say::note(&format!("written {}", path.display()));
    }
    let code = code(survey.ending, settings.stop, reached(&survey), "largest 95 % half width");
    let met = |group: &Group| group.judged.iter().all(|j| j.verdict == Verdict::Met);
    let all_met = groups.iter().all(|group| met(group) && group.comparisons().all(|c| c.agrees));
    Ok(if code == Code::Done && !all_met { Code::NotMet } else { code })
}

fn is_line(spec: &SensorSpec) -> bool {
    matches!(spec, SensorSpec::Line(_))
}

/// Refuses a plot of a scene without lines of sensors, before anything is computed.
fn check_plots(verb: &Illum, file: &SceneFile) -> Result<()> {
    let asked = verb.plot || verb.output.iter().any(|p| PlotFormat::of_extension(p).is_some());
    if asked && !file.sensors.values().any(is_line) {
        return Err(Error::Parameter(format!(
            "{}: the scene has no line of sensors to plot; add [sensors.NAME.line]",
            verb.common.scene.display()
        )));
    }
    Ok(())
}

/// Gives the error that a survey has reached: none, with a warning, when no light came anywhere.
pub(crate) fn reached(survey: &Survey) -> Option<f64> {
    let worst = survey.worst();
    if worst.is_none() {
        say::warning(
            "no light came to any of them; see whether lamps and sensors are where they should be",
        );
    }
    worst.or((survey.ending == Ending::Error).then_some(0.0))
}

/// A group of sensors with what was measured and required there.
pub(crate) struct Group<'a> {
    pub(crate) name: &'a str,
    pub(crate) sensors: &'a [Sensor],
    pub(crate) results: &'a [Measured],
    /// For each sensor the object behind which it is; these do not count in what follows.
    pub(crate) behind: &'a [Option<String>],
    /// `None` without sensors that count.
    pub(crate) summary: Option<GroupSummary>,
    pub(crate) judged: Vec<Judged>,
    /// What the sensors are known to receive, lx.
    known: Option<Vec<f64>>,
}

/// An illuminance beside the one that is known.
pub(crate) struct Comparison {
    /// The known one, lx.
    pub(crate) exact: f64,
    /// How far the estimate is from it, in standard errors.
    pub(crate) deviation: f64,
    /// Whether that is consistent by the joint test of all sensors of the group.
    pub(crate) agrees: bool,
}

impl Group<'_> {
    /// Compares each sensor with what it is known to receive; nothing where nothing is known.
    pub(crate) fn comparisons(&self) -> impl Iterator<Item = Comparison> {
        let known = self.known.iter().flatten();
        known.zip(self.results).map(|(&exact, result)| Comparison {
            exact,
            deviation: result.total.deviation(exact),
            agrees: result.total.agrees_with(exact, 0.0, self.results.len()),
        })
    }
}

fn groups<'a>(
    groups: &'a [SensorGroup],
    known: Vec<Option<Vec<f64>>>,
    survey: &'a Survey,
    require: &BTreeMap<String, RequireSpec>,
) -> Vec<Group<'a>> {
    let mut start = 0;
    let group = |(group, known): (&'a SensorGroup, Option<Vec<f64>>)| {
        let range = start..start + group.sensors.len();
        start = range.end;
        let replicates = survey.replicates[range.clone()].iter().zip(&group.behind);
        let counting: Vec<_> =
            replicates.filter(|(_, behind)| behind.is_none()).map(|(r, _)| *r).collect();
        let summary = GroupSummary::of(&counting);
        let required = require.get(&group.name).zip(summary.as_ref());
        Group {
            name: &group.name,
            sensors: &group.sensors,
            results: &survey.results[range],
            behind: &group.behind,
            summary,
            judged: required.map_or(Vec::new(), |(require, summary)| judge(require, summary)),
            known,
        }
    };
    groups.iter().zip(known).map(group).collect()
}

/// Settles how illuminance is computed.
pub(crate) fn settings(spec: &IllumSpec, scene: &Scene, common: &SceneArguments) -> SensorSettings {
    SensorSettings {
        estimator: match spec.estimator {
            IllumEstimator::Local => SensorEstimator::Local(Weighting::of(scene)),
            IllumEstimator::Path => SensorEstimator::Path,
        },
        randomness: Randomness::Sobol,
        seed: common.seed.unwrap_or(spec.seed),
        stop: stop(spec.stop, common.quick),
    }
}

fn columns() -> Table {
    Table::new([
        "group",
        "x_m",
        "y_m",
        "z_m",
        "normal_x",
        "normal_y",
        "normal_z",
        "illuminance_lx",
        "half_width_95_lx",
        "standard_error_lx",
        "direct_lx",
        "spoilt_samples",
        "exact_lx",
        "deviation_in_standard_errors",
        "behind",
    ])
}

fn fill(table: &mut Table, groups: &[Group]) {
    for group in groups {
        let mut comparisons = group.comparisons();
        for ((sensor, r), behind) in group.sensors.iter().zip(group.results).zip(group.behind) {
            let [x, y, z] = sensor.at.to_array();
            let [nx, ny, nz] = sensor.normal.to_array();
            let numbers = [
                x,
                y,
                z,
                nx,
                ny,
                nz,
                r.total.mean,
                r.total.half_width(0.05),
                r.total.standard_error,
                r.direct.mean,
            ];
            let cells = std::iter::once(Cell::from(group.name));
            let cells = cells.chain(numbers.map(Cell::Number)).chain([Cell::Whole(r.spoilt)]);
            let comparison = comparisons.next();
            let exact = comparison.as_ref().map(|c| c.exact).into();
            let deviation = comparison.map(|c| c.deviation).into();
            table.push(cells.chain([exact, deviation, behind.clone().into()]));
        }
    }
}
