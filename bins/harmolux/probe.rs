//! `harmolux probe`: luminance along rays, or illuminance at points, from stdin to stdout.

use std::io::Read;
use std::path::Path;

use clap::Args;
use harmolux::estimators::{illuminance, luminance};
use harmolux::io::rays;
use harmolux::io::tables::{Cell, Table};
use harmolux::math::Ray;
use harmolux::scene::{Measured, Sensor};
use harmolux::{Error, Result};

use super::arguments::SceneArguments;
use super::exit::Code;
use super::fit::about;
use super::illum::{reached, settings};
use super::progress::Meter;
use super::render::{code, load_scene, read_scene};
use super::{illum_report, interrupt, say};

/// Measure luminance, cd/m2, along rays given on stdin, or illuminance, lx, at points
///
/// Each line of stdin is a point and a direction: x y z dx dy dz. Each gives one line on stdout, in the same order: the value and its 95 % half width.
/// All are served by the same walks, so that answers come when the input ends; [illum] of the scene says how and when to stop.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  echo 2 0.25 1.6  0 1 0 | harmolux probe room.toml          what an eye at (2, 0.25, 1.6) sees towards +y
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
    let mut file = read_scene(&verb.common)?;
    // Nobody asks for them here.
    file.sensors.clear();
    let loaded = load_scene(&file)?;
    let asked = read_stdin()?;
    if asked.is_empty() {
        say::note("nothing is asked: stdin holds no line of x y z dx dy dz");
        report(verb, &[], as_json)?;
        return Ok(Code::Done);
    }
    let settings = settings(&file.illum, &loaded.scene, &verb.common);
    interrupt::listen();
    let meter = Meter::start("measuring", "largest 95 % half width");
    let watch = |p: &_| meter.show(p);
    let survey = if verb.illuminance {
        let sensors: Vec<Sensor> =
            asked.iter().map(|&(at, normal)| Sensor::plane(at, normal)).collect();
        illuminance(&loaded.scene, &sensors, &settings, &watch)
    } else {
        let rays: Vec<Ray> = asked.iter().map(|&(at, along)| Ray::new(at, along)).collect();
        luminance(&loaded.scene, &rays, &settings, &watch)
    }
    .map_err(|e| about(&verb.common.scene, e))?;
    meter.finish();
    report(verb, &survey.results, as_json)?;
    illum_report::run(&survey);
    Ok(code(survey.ending, settings.stop, reached(&survey), "largest 95 % half width"))
}

fn report(verb: &Probe, results: &[Measured], as_json: bool) -> Result<()> {
    if as_json {
        let table = table(results, if verb.illuminance { "lx" } else { "cd_m2" });
        say::data(String::from_utf8_lossy(&table.to_json()?).trim_end());
        return Ok(());
    }
    for r in results {
        let half_width = illum_report::half_width(&r.total);
        say::data(&format!("{}\t{half_width}", say::significant(r.total.mean, 7)));
    }
    Ok(())
}

fn read_stdin() -> Result<Vec<(glam::DVec3, glam::DVec3)>> {
    let path = Path::new("stdin");
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text).map_err(|e| Error::io(path, "read", e))?;
    rays::parse(path, &text)
}

fn table(results: &[Measured], unit: &str) -> Table {
    let names = ["value", "half_width_95", "standard_error", "direct"];
    let header = names.map(|name| format!("{name}_{unit}"));
    let mut table = Table::new(header.into_iter().chain(["spoilt_samples".to_owned()]));
    for r in results {
        let numbers =
            [r.total.mean, r.total.half_width(0.05), r.total.standard_error, r.direct.mean];
        table.push(numbers.map(Cell::Number).into_iter().chain([Cell::Whole(r.spoilt)]));
    }
    table
}
