//! `harmolux illum`: lux at the sensors of a scene.

use std::path::PathBuf;

use clap::Args;
use harmolux::estimators::{
    Ending, SensorEstimator, SensorSettings, Survey, Weighting, illuminance,
};
use harmolux::io::output::Output;
use harmolux::io::scene_file::{IllumEstimator, IllumSpec};
use harmolux::io::tables::{Cell, Table};
use harmolux::math::Randomness;
use harmolux::scene::{Illuminance, Scene, Sensor};
use harmolux::study::SensorGroup;
use harmolux::{Error, Result};

use super::arguments::SceneArguments;
use super::exit::Code;
use super::fit::about;
use super::progress::{self, Meter};
use super::render::{code, load_scene, read_scene, stop};
use super::{interrupt, say};

/// Measure illuminance, lx, at the sensors of a scene
///
/// Each value comes with its 95 % interval and the part that arrives directly; each group of sensors with mean, least, largest and U0 = least / mean.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  harmolux illum room.toml                               a table
  harmolux illum room.toml -o lux.csv                    the same as CSV
  harmolux illum room.toml -D illum.stop.relative_error=0.001")]
pub(crate) struct Illum {
    #[command(flatten)]
    pub(crate) common: SceneArguments,
    /// Write the values of all sensors as CSV
    #[arg(short, long, value_name = "FILE.csv")]
    pub(crate) output: Option<PathBuf>,
}

/// Runs the verb.
pub(crate) fn run(verb: &Illum, as_json: bool) -> Result<Code> {
    let file = read_scene(&verb.common)?;
    let mut table = columns();
    let kind = table.csv_kind()?;
    let output = verb.output.as_deref().map(|path| Output::open(path, &kind, verb.common.force));
    let output = output.transpose()?;
    let loaded = load_scene(&file)?;
    let sensors: Vec<Sensor> =
        loaded.sensors.iter().flat_map(|g| g.sensors.iter().copied()).collect();
    if sensors.is_empty() {
        return Err(Error::Parameter(format!(
            "{}: the scene has no sensors; add [sensors.NAME.points] or [sensors.NAME.grid]",
            verb.common.scene.display()
        )));
    }
    let settings = settings(&file.illum, &loaded.scene, &verb.common);
    interrupt::listen();
    let meter = Meter::start("measuring", "largest 95 % half width");
    let survey = illuminance(&loaded.scene, &sensors, &settings, &|p| meter.show(p))
        .map_err(|e| about(&verb.common.scene, e))?;
    meter.finish();
    fill(&mut table, &loaded.sensors, &survey);
    if let Some(output) = output {
        output.write(&table.to_csv()?)?;
    }
    if as_json {
        say::data(String::from_utf8_lossy(&table.to_json()?).trim_end());
    } else {
        report(&loaded.sensors, &survey);
    }
    let worst = survey.results.iter().map(|r| r.total).filter(|e| e.mean > 0.0);
    let worst = worst.map(|e| e.relative_half_width()).reduce(f64::max);
    Ok(code(survey.ending, settings.stop, worst, "largest 95 % half width"))
}

fn settings(spec: &IllumSpec, scene: &Scene, common: &SceneArguments) -> SensorSettings {
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
    ])
}

/// Pairs sensors and results group by group.
fn grouped<'a>(
    groups: &'a [SensorGroup],
    survey: &'a Survey,
) -> impl Iterator<Item = (&'a SensorGroup, &'a [Illuminance])> {
    let mut start = 0;
    groups.iter().map(move |group| {
        let range = start..start + group.sensors.len();
        start = range.end;
        (group, &survey.results[range])
    })
}

fn fill(table: &mut Table, groups: &[SensorGroup], survey: &Survey) {
    for (group, results) in grouped(groups, survey) {
        for (sensor, r) in group.sensors.iter().zip(results) {
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
            let cells = std::iter::once(Cell::from(group.name.as_str()));
            let cells = cells.chain(numbers.map(Cell::Number)).chain([Cell::Whole(r.spoilt)]);
            table.push(cells);
        }
    }
}

fn report(groups: &[SensorGroup], survey: &Survey) {
    for (group, results) in grouped(groups, survey) {
        if results.is_empty() {
            continue;
        }
        let mut table =
            say::table(&[&group.name, "x m", "y m", "z m", "E lx", "± 95 %", "direct lx"]);
        for (i, (sensor, r)) in group.sensors.iter().zip(results).enumerate() {
            let number = |x: f64| say::significant(x, 4);
            table.add_row([
                (i + 1).to_string(),
                number(sensor.at.x),
                number(sensor.at.y),
                number(sensor.at.z),
                number(r.total.mean),
                say::significant(r.total.half_width(0.05), 2),
                number(r.direct.mean),
            ]);
        }
        say::data(&table.to_string());
        summary(group, results);
    }
    let end = match survey.ending {
        Ending::Interrupted => ", interrupted",
        _ => "",
    };
    say::note(&format!("{} walks in {}{end}", survey.walks, progress::duration(survey.elapsed)));
    if survey.escaped > 0.0 {
        say::warning(&format!("{} of the light left the scene", say::percent(survey.escaped)));
    }
    let spoilt: u64 = survey.results.iter().map(|r| r.spoilt).sum();
    if spoilt > 0 {
        say::warning(&format!(
            "{spoilt} samples were not finite; they are counted here and nowhere else"
        ));
    }
}

fn summary(group: &SensorGroup, results: &[Illuminance]) {
    let values = || results.iter().map(|r| r.total.mean);
    let mean = values().sum::<f64>() / results.len() as f64;
    let (least, largest) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
    let number = |x: f64| say::significant(x, 4);
    let uniformity = if mean > 0.0 { say::significant(least / mean, 3) } else { "-".to_owned() };
    say::data(&format!(
        "{}: mean {} lx, least {} lx, largest {} lx, U0 = {uniformity}\n",
        group.name,
        number(mean),
        number(least),
        number(largest),
    ));
}
