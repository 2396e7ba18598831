//! `harmolux illum`: lux at the sensors of a scene.

mod map;
mod report;
mod target;

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use harmolux::estimators::{
    Ending, Estimator, GroupSummary, SensorSettings, Stop, Survey, illuminance,
};
use harmolux::io::scene_file::{IllumEstimator, RequireSpec, SceneFile, SensorSpec, StopSpec};
use harmolux::io::tables::{Cell, Table};
use harmolux::scene::{Measured, Sensor};
use harmolux::study::{Judged, Loaded, SensorGroup, Verdict, judge, known_illuminance};
use harmolux::{Error, Result};

use self::target::IllumTarget;
use crate::common::about::about;
use crate::common::exit::Code;
use crate::common::flags::{SceneArguments, choices};
use crate::common::plot::{self, PlotFormat};
use crate::common::progress::Meter;
use crate::common::say;
use crate::common::scenes::{load_scene, read_scene, stop};
use crate::common::surveys::{self, code, reached, settings};
use crate::common::target::write_all;

/// Measure illuminance, lx, at the sensors of a scene
///
/// Each value comes with its 95 % interval and the part that arrives directly; each group of
/// sensors with mean, least, largest and U0 = least / mean, each with an interval of its own.
/// Sensors that `[compare]` names stand beside what they are known to receive. What `[require]`
/// asks for is judged by those intervals: met, not met or undecided; unless all is met, the exit
/// code is 4.
///
/// The run ends when `[illum.stop]` says so: at a relative_error (the largest relative half width
/// of the 95 % intervals), a time, or a number of walks, which is rounded up to a multiple of 32.
/// Without it, at one per cent or after 262144 walks.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux illum room.toml                               a table
  harmolux illum room.toml -o lux.csv                    the same as CSV; `harmolux falsecolor \
                                                         lux.csv` draws its grids
  harmolux illum room.toml -o lux.npy                    the same for numpy.load, shape (sensors, \
                                                         10)
  harmolux illum data/scenes/sobolev.toml -o fig2.svg    the lines of sensors, with error bars, as \
                                                         a plot
  harmolux illum room.toml --estimator radiosity         the same lux by another method
  harmolux illum room.toml -o head.ply                   sensors of kind surface as a coloured \
                                                         point cloud or mesh
  harmolux illum room.toml -D illum.stop.relative_error=0.001")]
pub(crate) struct Illum {
    #[command(flatten)]
    pub(crate) common: SceneArguments,
    /// Write the values of all sensors (.csv, .npy), a plot of the lines of sensors (.svg, .png) or
    /// a group of kind surface in false colours (.ply, named after the group where there are
    /// several); may be repeated
    ///
    /// The array of an .npy file is float64 of shape (sensors, 10), rows as in the table: x, y, z,
    /// normal x, y, z, illuminance, 95 % half width, standard error, direct part; the last four are
    /// NaN for a sensor behind an object.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
    /// Replace output files that are there already
    #[arg(long)]
    pub(crate) force: bool,
    /// Plot the lines of sensors in the terminal, above the table
    #[arg(long)]
    pub(crate) plot: bool,
    /// Take this estimator in place of the scene's
    #[arg(long, value_name = "NAME", value_parser = choices::<IllumEstimator>())]
    pub(crate) estimator: Option<IllumEstimator>,
}

/// Runs the verb.
pub(crate) fn run(verb: &Illum, as_json: bool) -> Result<Code> {
    if verb.plot && as_json {
        return Err(Error::Parameter(
            "--plot draws for people and --json writes for machines; take one of them".into(),
        ));
    }
    let mut file = read_scene(&verb.common.scene, &verb.common.define)?;
    file.illum.estimator = verb.estimator.unwrap_or(file.illum.estimator);
    let mut table = columns();
    check_plots(verb, &file)?;
    let targets = verb.output.iter().map(|path| IllumTarget::open(path, &table, &file, verb));
    let targets: Vec<IllumTarget> = targets.collect::<Result<_>>()?;
    let meter = Meter::start("reading the scene");
    let loaded = load_scene(&file, None, &meter)?;
    let known = loaded.sensors.iter().map(|group| known_illuminance(&file, group));
    let known: Vec<Option<Vec<f64>>> = known.collect::<Result<_>>()?;
    let settings = settings(&file.illum, &loaded.scene, &verb.common);
    // Those behind an object are left out: they measure nothing, and decide nothing.
    let counts: Vec<bool> =
        loaded.sensors.iter().flat_map(|g| g.behind.iter().map(Option::is_none)).collect();
    let survey = measure(verb, &loaded, &settings, &counts, &meter)?;
    let counted = matches!(settings.estimator, Estimator::Photon { .. });
    let groups = groups(&loaded.sensors, known, &survey, &file.require, counted);
    fill(&mut table, &groups);
    let lines = groups.iter().filter(|group| is_line(&file.sensors[group.name]));
    let figure = report::figure(lines);
    let stage = surveys::stage(&survey);
    let paths: Vec<PathBuf> = targets.iter().map(|t| t.path_at(stage).to_owned()).collect();
    let write = |target: IllumTarget| target.write((&table, &figure, &groups), stage);
    let written = write_all(targets.into_iter().map(write));
    drop(meter);
    if as_json {
        say::raw(&report::json(&table, &groups, &survey)?);
    } else {
        if verb.plot {
            plot::print(&figure)?;
        }
        groups.iter().for_each(report::group);
    }
    surveys::tell(&survey);
    written?;
    for path in &paths {
        say::note(&format!("written {}", path.display()));
    }
    Ok(outcome(&survey, settings.stop, &counts, &groups))
}

/// Measures at the sensors that count.
fn measure(
    verb: &Illum,
    loaded: &Loaded,
    settings: &SensorSettings,
    counts: &[bool],
    meter: &Meter,
) -> Result<Survey> {
    let sensors = loaded.sensors.iter().flat_map(|g| g.sensors.iter().copied());
    let sensors: Vec<Sensor> =
        sensors.zip(counts).filter(|(_, counts)| **counts).map(|(s, _)| s).collect();
    if counts.is_empty() {
        return Err(Error::Parameter(format!(
            "{}: the scene has no sensors; add [sensors.NAME.points], [sensors.NAME.line], \
             [sensors.NAME.grid] or [sensors.NAME.surface]",
            verb.common.scene.display()
        )));
    }
    let mut settings = *settings;
    let is_radiosity = matches!(settings.estimator, Estimator::Radiosity(_));
    if settings.stop == Stop::default() && !is_radiosity {
        settings.stop = unasked(verb.common.quick);
    }
    meter.stage("measuring");
    let watch = |p: &_| meter.show(p, "largest 95 % half width");
    let survey = illuminance(&loaded.scene, &sensors, &settings, &watch)
        .map_err(|e| about(&verb.common.scene, e))?;
    meter.stage("writing");
    Ok(survey.scattered(counts))
}

/// Says how the run ended, for the exit code.
fn outcome(survey: &Survey, asked: Stop, counts: &[bool], groups: &[Group]) -> Code {
    let (unknown, cut_short) = (surveys::unreached(survey, counts), surveys::cut_short(survey));
    let code = match code(survey.ending, asked, reached(survey), "largest 95 % half width") {
        Code::Done if unknown || cut_short => Code::NotMet,
        code => code,
    };
    let met = |group: &Group| group.judged.iter().all(|j| j.verdict == Verdict::Met);
    let all_met = groups
        .iter()
        .all(|group| met(group) && group.comparisons().flatten().all(|c| c.agrees != Some(false)));
    if code == Code::Done && !all_met { Code::NotMet } else { code }
}

/// Says when a run ends of which nothing is said: at one per cent, or after 2^18 walks.
fn unasked(quick: bool) -> Stop {
    let spec = StopSpec { relative_error: Some(0.01), time: None, walks: Some(1 << 18) };
    stop(spec, quick).into()
}

fn is_line(spec: &SensorSpec) -> bool {
    matches!(spec, SensorSpec::Line(_))
}

/// Rejects a plot of a scene without lines of sensors, before anything is computed.
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

/// A group of sensors with what was measured and required there.
pub(crate) struct Group<'a> {
    pub(crate) name: &'a str,
    pub(crate) sensors: &'a [Sensor],
    pub(crate) results: &'a [Measured],
    /// For each sensor the object behind which it is; these do not count in what follows.
    pub(crate) behind: &'a [Option<String>],
    /// The triangles that join the sensors, if any.
    pub(crate) faces: &'a [[u32; 3]],
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
    /// Whether that is consistent by the joint test of all sensors of the group; `None` when no
    /// error is known.
    pub(crate) agrees: Option<bool>,
}

impl Group<'_> {
    /// Compares each sensor with what it is known to receive, `None` for one that is behind an
    /// object; nothing where nothing is known.
    pub(crate) fn comparisons(&self) -> impl Iterator<Item = Option<Comparison>> {
        let known = self.known.iter().flatten();
        known.zip(self.results).zip(self.behind).map(|((&exact, result), behind)| {
            behind.is_none().then(|| Comparison {
                exact,
                deviation: result.total.deviation(exact),
                agrees: (!result.total.standard_error.is_nan())
                    .then(|| result.total.agrees_with(exact, 0.0, self.results.len())),
            })
        })
    }
}

fn groups<'a>(
    groups: &'a [SensorGroup],
    known: Vec<Option<Vec<f64>>>,
    survey: &'a Survey,
    require: &BTreeMap<String, RequireSpec>,
    counted: bool,
) -> Vec<Group<'a>> {
    let mut start = 0;
    // No estimate but that of photons finds what mirrors throw from point lights onto a sensor;
    // radiosity that was cut short has light left to pass on.
    let cut_short = survey.radiosity.is_some() && survey.ending != Ending::Converged;
    let missing = cut_short || survey.caustic > 0.0 && !counted;
    let group = |(group, known): (&'a SensorGroup, Option<Vec<f64>>)| {
        let range = start..start + group.sensors.len();
        start = range.end;
        let counting = range.clone().zip(&group.behind).filter(|(_, behind)| behind.is_none());
        // Where the time was too short for some, nothing is known of the group.
        let counting: Vec<usize> = counting.map(|(i, _)| i).collect();
        let known_all = counting.iter().all(|i| !survey.results[*i].total.mean.is_nan());
        let counting = counting.into_iter().filter(|_| known_all);
        let summary = if survey.radiosity.is_some() {
            let values: Vec<_> = counting.map(|i| survey.results[i].total.mean).collect();
            GroupSummary::without_errors(&values)
        } else {
            GroupSummary::of(&counting.map(|i| survey.replicates[i]).collect::<Vec<_>>())
        };
        let required = require.get(&group.name);
        // Where no photon was counted, that is no proof of darkness.
        let is_dark = |i: usize| survey.results[i].total.mean == 0.0;
        let missing = missing || counted && range.clone().any(is_dark);
        Group {
            name: &group.name,
            sensors: &group.sensors,
            results: &survey.results[range],
            behind: &group.behind,
            faces: &group.faces,
            summary,
            judged: required.map_or(Vec::new(), |r| judge(r, summary.as_ref(), missing)),
            known,
        }
    };
    groups.iter().zip(known).map(group).collect()
}

fn columns() -> Table {
    let known = ["non_finite_samples", "exact_lx", "deviation_in_standard_errors", "behind"];
    Table::new(["group"].into_iter().chain(target::COLUMNS).chain(known))
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
            let cells = cells.chain(numbers.map(Cell::Number)).chain([Cell::Whole(r.non_finite)]);
            let comparison = comparisons.next().flatten();
            let exact = comparison.as_ref().map(|c| c.exact).into();
            let deviation = comparison.map(|c| c.deviation).into();
            table.push(cells.chain([exact, deviation, behind.clone().into()]));
        }
    }
}
