//! `harmolux probe`: luminance along rays, or illuminance at points, from stdin to stdout.

use std::collections::BTreeMap;
use std::path::Path;

use clap::Args;
use harmolux::error::{InputError, shown};
use harmolux::estimators::{illuminance, luminance};
use harmolux::io::rays;
use harmolux::io::tables::{Cell, Table};
use harmolux::math::Ray;
use harmolux::scene::{Measured, Scene, Sensor};
use harmolux::{Error, Result, memory};

use crate::common::about::about;
use crate::common::exit::Code;
use crate::common::flags::SceneArguments;
use crate::common::progress::Meter;
use crate::common::say;
use crate::common::scenes::{load_scene, read_scene};
use crate::common::surveys::{self, code, reached, settings};

/// Measure luminance along rays, or illuminance at points
///
/// Each line of stdin is a point and a direction: x y z dx dy dz. Each gives one line on stdout, in
/// the same order: the value and its 95 % half width, with a tab between. The value has seven
/// digits, for programs that go on from there; the half width says how many of them are known. With
/// -I, a point outside the room or inside an object measures nothing; its line says NaN and behind
/// what it is. Without any line nothing is measured: that is said on stderr, and the exit code
/// is 0. All are served by the same walks, so that answers come when the input ends; [illum] of the
/// scene says how and when to stop.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  echo 2 0.25 1.6  0 1 0 | harmolux probe room.toml          what an eye at (2, 0.25, 1.6) sees \
                                                             towards +y
  echo 1 1 0  0 0 1 | harmolux probe room.toml -I            lux on the floor at (1, 1)")]
pub(crate) struct Probe {
    #[command(flatten)]
    pub(crate) common: SceneArguments,
    /// Measure illuminance at the points; the directions are the normals
    #[arg(short = 'I')]
    pub(crate) illuminance: bool,
}

/// Runs the verb.
pub(crate) fn run(verb: &Probe, as_json: bool) -> Result<Code> {
    let mut file = read_scene(&verb.common.scene, &verb.common.define)?;
    // Nobody asks for them here.
    file.sensors.clear();
    let meter = Meter::start("reading the scene");
    let loaded = load_scene(&file, None, &meter)?;
    drop(meter);
    let asked = read_stdin()?;
    if asked.is_empty() {
        say::note("no ray was read: stdin holds no line of x y z dx dy dz");
        report(verb, &[], &[], as_json)?;
        return Ok(Code::Done);
    }
    let sensors: Vec<Sensor> =
        asked.iter().map(|&(at, normal)| Sensor::plane(at, normal)).collect();
    if verb.illuminance {
        check_distances(&loaded.scene, &sensors)?;
    }
    let mut behind = loaded.behind(&sensors);
    warn_of_hidden(&behind, verb.illuminance);
    if !verb.illuminance {
        // An eye there sees the back of the surface, which has a luminance.
        behind.fill(None);
    }
    let settings = settings(&file.illum, &loaded.scene, &verb.common);
    let meter = Meter::start("measuring");
    let watch = |p: &_| meter.show(p, "largest 95 % half width");
    let survey = if verb.illuminance {
        let counts: Vec<bool> = behind.iter().map(Option::is_none).collect();
        let sensors = sensors.iter().zip(&counts).filter(|(_, counts)| **counts);
        let sensors: Vec<Sensor> = sensors.map(|(sensor, _)| *sensor).collect();
        let survey = illuminance(&loaded.scene, &sensors, &settings, &watch);
        survey.map(|survey| survey.scattered(&counts))
    } else {
        let rays: Vec<Ray> = asked.iter().map(|&(at, along)| Ray::new(at, along)).collect();
        luminance(&loaded.scene, &rays, &settings, &watch)
    }
    .map_err(|e| about(&verb.common.scene, e))?;
    drop(meter);
    report(verb, &survey.results, &behind, as_json)?;
    surveys::tell(&survey);
    let counts: Vec<bool> = behind.iter().map(Option::is_none).collect();
    let unknown = surveys::unreached(&survey, &counts);
    Ok(match code(survey.ending, settings.stop, reached(&survey), "largest 95 % half width") {
        Code::Done if unknown => Code::NotMet,
        code => code,
    })
}

/// Rejects a point where a light is: what it receives is without bounds.
fn check_distances(scene: &Scene, sensors: &[Sensor]) -> Result<()> {
    for (i, sensor) in sensors.iter().enumerate() {
        if let Some(light) = scene.lights().iter().find(|light| light.at == sensor.at) {
            return Err(Error::Parameter(format!(
                "stdin: point {} is where light `{}` is; its illuminance would be infinite, move \
                 it",
                i + 1,
                light.name
            )));
        }
    }
    Ok(())
}

/// Says behind what points are.
fn warn_of_hidden(behind: &[Option<String>], illuminance: bool) {
    let end = if illuminance { "they measure nothing" } else { "they see it from behind" };
    let mut hidden = BTreeMap::<&str, Vec<usize>>::new();
    for (i, object) in behind.iter().enumerate() {
        if let Some(object) = object {
            hidden.entry(object).or_default().push(i + 1);
        }
    }
    for (object, points) in hidden {
        say::warning(&format!(
            "{} of {} points are outside the room, or inside the object, `{object}` (the first is \
             point {}); {end}",
            points.len(),
            behind.len(),
            points[0]
        ));
    }
}

fn report(
    verb: &Probe,
    results: &[Measured],
    behind: &[Option<String>],
    as_json: bool,
) -> Result<()> {
    if as_json {
        let table = table(results, behind, if verb.illuminance { "lx" } else { "cd_m2" });
        say::raw(String::from_utf8_lossy(&table.to_json()?).trim_end());
        return Ok(());
    }
    for (r, behind) in results.iter().zip(behind) {
        if let Some(object) = behind {
            say::data(&format!("NaN\tbehind {}", shown(object)));
            continue;
        }
        let half_width = surveys::half_width(&r.total);
        say::data(&format!("{}\t{half_width}", say::significant(r.total.mean, 7)));
    }
    Ok(())
}

fn read_stdin() -> Result<Vec<(glam::DVec3, glam::DVec3)>> {
    let path = Path::new("stdin");
    let bytes = memory::read_to_end(path, std::io::stdin())?;
    // Rays, sensors and what is behind them are some twenty times as long.
    memory::ask(20.0 * bytes.len() as f64, "what stdin asks for", |_| "take fewer lines".into())?;
    let text = String::from_utf8(bytes);
    let text = text.map_err(|_| InputError::new(path, "this is not text (UTF-8)"))?;
    rays::parse(path, &text)
}

fn table(results: &[Measured], behind: &[Option<String>], unit: &str) -> Table {
    let names = ["value", "half_width_95", "standard_error", "direct"];
    let header = names.map(|name| format!("{name}_{unit}"));
    let more = ["non_finite_samples", "behind"].map(str::to_owned);
    let mut table = Table::new(header.into_iter().chain(more));
    for (r, behind) in results.iter().zip(behind) {
        let numbers =
            [r.total.mean, r.total.half_width(0.05), r.total.standard_error, r.direct.mean];
        // What is behind an object measures nothing.
        let numbers = numbers.map(|x| Cell::Number(if behind.is_some() { f64::NAN } else { x }));
        table.push(numbers.into_iter().chain([Cell::Whole(r.non_finite), behind.clone().into()]));
    }
    table
}
