//! The sensors of a scene file: laid out, and which of them are behind an object.

use rayon::prelude::*;

use super::built::Built;
use super::grids;
use super::on_surface::{self, Laid};
use super::solids::{self, Solid};
use super::stage::{LoadingObserver, LoadingStage};
use crate::error::shown;
use crate::io::scene_file::{PointsSpec, SceneFile, SensorSpec, SurfaceLayout};
use crate::scene::{PointLight, Scene, Sensor};
use crate::{Result, memory};

/// The most sensors of one group.
const MAX_SENSORS: f64 = 1e6;

/// Names a set of sensors.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorGroup {
    /// The name in the scene file.
    pub name: String,
    /// The sensors.
    pub sensors: Vec<Sensor>,
    /// For each sensor the object behind whose surface it is: outside the room, or inside the
    /// object. Such a sensor gets no light.
    pub behind: Vec<Option<String>>,
    /// The triangles that join the sensors where they are the vertices of a mesh, else none; they
    /// look to the side of the normals.
    pub faces: Vec<[u32; 3]>,
}

pub(super) fn sensors(
    file: &SceneFile,
    scene: &Scene,
    (built, solids): (&[Built], &[Solid]),
    observer: LoadingObserver,
) -> Result<Vec<SensorGroup>> {
    file.sensors
        .iter()
        .map(|(name, spec)| {
            observer(LoadingStage::LayingOut(name));
            let Laid { sensors, faces } = lay_out(file, scene, built, (name, spec))?;
            let own = match spec {
                SensorSpec::Surface(surface) => Some(surface.place.object()),
                _ => None,
            };
            let behind = |sensor| behind(sensor, own, scene, solids);
            let behind = sensors.par_iter().map(behind).collect();
            Ok(SensorGroup { name: name.clone(), sensors, behind, faces })
        })
        .collect()
}

/// Names the object behind whose surface a sensor is. A sensor on the surface of its `own` object
/// is before it, however small a crease it is in.
pub(super) fn behind(
    sensor: &Sensor,
    own: Option<&str>,
    scene: &Scene,
    solids: &[Solid],
) -> Option<String> {
    // A sensor on a wall is judged by the point that its rays leave from.
    let before = scene.settled(sensor).as_hit().departure(sensor.normal);
    solids::behind(before, own, solids).map(|solid| solid.name().to_owned())
}

/// Rejects a sensor that is where a light is: what it receives is without bounds.
pub(super) fn check_distances(
    file: &SceneFile,
    groups: &[SensorGroup],
    lights: &[PointLight],
) -> Result<()> {
    for group in groups {
        for (i, sensor) in group.sensors.iter().enumerate() {
            let Some(light) = lights.iter().find(|light| light.at == sensor.at) else { continue };
            let message =
                format!("sensor {} of `{}` is where light `{}` is", i + 1, group.name, light.name);
            let help = "its illuminance would be infinite; move one of them".to_owned();
            return Err(file.source.error(&["sensors", &group.name], message, Some(help)));
        }
    }
    Ok(())
}

/// Rejects more sensors than a group may have or memory holds.
fn check_count(file: &SceneFile, [name, what]: [&str; 2], count: f64, help: &str) -> Result<()> {
    if count > MAX_SENSORS {
        let message =
            format!("the {what} `{name}` would have {count:.3e} sensors, more than {MAX_SENSORS}");
        return Err(file.source.error(&["sensors", name, what], message, Some(help.to_owned())));
    }
    // Sensors, and the lists that are made of them.
    let each = 3.0 * size_of::<Sensor>() as f64;
    let group = format_args!("the {what} `{}` of {count} sensors", shown(name));
    memory::ask_each(count as usize, each, group, help)
}

/// Lays out one group of sensors.
fn lay_out(
    file: &SceneFile,
    scene: &Scene,
    built: &[Built],
    (name, spec): (&str, &SensorSpec),
) -> Result<Laid> {
    let check = |what: &str, count: f64, help: &str| check_count(file, [name, what], count, help);
    let fewer = "write a larger `spacing`, or a smaller `count`";
    let plain = |sensors| Laid { sensors, faces: Vec::new() };
    match spec {
        SensorSpec::Points(points) => {
            let PointsSpec { normal, measure, .. } = *points;
            let sensor = |&at| Sensor { measure, ..Sensor::plane(at, normal) };
            Ok(plain(points.at.iter().map(sensor).collect()))
        }
        SensorSpec::Grid(grid) => {
            grids::sensors(grid, file, scene.bounds(), |count| check("grid", count, fewer))
                .map(plain)
        }
        SensorSpec::Line(line) => {
            grids::along(line, |count| check("line", count, fewer)).map(plain)
        }
        SensorSpec::Surface(surface) => {
            let Some(built) = built.iter().find(|b| b.object.name == surface.place.object()) else {
                return Ok(Laid::default());
            };
            if let SurfaceLayout::Even(count) = surface.layout {
                check("surface", f64::from(count), "write a smaller number")?;
            }
            let laid = on_surface::lay_out(surface, file, &built.object, &built.form)?;
            if surface.layout == SurfaceLayout::Vertices {
                let help = "write `points = 1000` instead of `vertices`, or use a coarser mesh";
                check("surface", laid.sensors.len() as f64, help)?;
            }
            Ok(laid)
        }
    }
}
