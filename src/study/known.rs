//! What sensors are known to receive, by `[compare]`: written values, or the exact solution of the scene.

use crate::Result;
use crate::exact::{Plane, SobolevProblem};
use crate::io::scene_file::{
    CompareSpec, DistributionSpec, LightSpec, MaterialSpec, ObjectSpec, PlaneSpec, SceneFile,
};
use crate::math::Rgb;
use crate::scene::Sensor;

use super::load::{self, SensorGroup};

/// How far a sensor may be from a plane, in gaps, and its normal from the plane's.
const ON_PLANE: f64 = 1e-9;

/// Gives the known illuminances, lx, of a group's sensors; `None` when `[compare]` does not name it.
///
/// # Errors
/// [`crate::Error::Input`] that points at the group in `[compare]`: a number of values that is not that of the sensors, a scene that is not the problem
/// named, sensors that are not on its planes.
pub fn known(file: &SceneFile, group: &SensorGroup) -> Result<Option<Vec<f64>>> {
    let Some(spec) = file.compare.get(&group.name) else { return Ok(None) };
    let fault = |message: String, help: &str| {
        file.source.error(&["compare", &group.name], message, Some(help.to_owned()))
    };
    match spec {
        CompareSpec::Values(values) if values.len() == group.sensors.len() => {
            Ok(Some(values.clone()))
        }
        CompareSpec::Values(values) => {
            let (found, sensors) = (values.len(), group.sensors.len());
            let message = format!("{found} values for the {sensors} sensors of `{}`", group.name);
            Err(fault(message, "write one value for each sensor, in order"))
        }
        CompareSpec::Sobolev => {
            let Sobolev { problem, planes, light } = Sobolev::of(file).ok_or_else(|| {
                fault(
                    "the scene is not Sobolev's problem".to_owned(),
                    "it needs two planes that face each other, grey Lambert materials that do not emit, one point light of colour white between them, and nothing else",
                )
            })?;
            let value = |sensor: &Sensor| {
                let along = planes[0].normal;
                let lies = |plane: &PlaneSpec| {
                    (sensor.at - plane.point).dot(along).abs() <= ON_PLANE * problem.gap
                        && sensor.normal.distance(plane.normal) <= ON_PLANE
                };
                let plane = match planes.map(lies) {
                    [true, _] => Plane::Lower,
                    [_, true] => Plane::Upper,
                    _ => {
                        return Err(fault(
                            format!("a sensor of `{}` is not on a plane", group.name),
                            "lay all sensors on the planes, their normals like those of the planes",
                        ));
                    }
                };
                let off = sensor.at - light.at;
                problem.illuminance(plane, off.reject_from_normalized(along).length())
            };
            group.sensors.iter().map(value).collect::<Result<_>>().map(Some)
        }
    }
}

/// Sobolev's problem as a scene states it.
struct Sobolev<'a> {
    problem: SobolevProblem,
    /// The first one counts as the lower.
    planes: [&'a PlaneSpec; 2],
    light: &'a LightSpec,
}

impl<'a> Sobolev<'a> {
    fn of(file: &'a SceneFile) -> Option<Self> {
        let mut objects = file.objects.values();
        let (Some(ObjectSpec::Plane(lower)), Some(ObjectSpec::Plane(upper)), None) =
            (objects.next(), objects.next(), objects.next())
        else {
            return None;
        };
        let mut lights = file.lights.values();
        let (Some(light), None) = (lights.next(), lights.next()) else {
            return None;
        };
        let gap = (upper.point - lower.point).dot(lower.normal);
        let source_height = (light.at - lower.point).dot(lower.normal);
        let opposed = lower.normal.distance(-upper.normal) <= ON_PLANE;
        let white = light.colour == Rgb::WHITE && light.distribution == DistributionSpec::Isotropic;
        (opposed && white && 0.0 < source_height && source_height < gap).then_some(())?;
        let problem = SobolevProblem {
            reflectance: [grey(file, &lower.material)?, grey(file, &upper.material)?],
            source_height,
            gap,
            intensity: load::light("", light).intensity.luminance(),
        };
        Some(Self { problem, planes: [lower, upper], light })
    }
}

/// Gives the reflectance of a grey Lambert material that does not emit.
fn grey(file: &SceneFile, material: &str) -> Option<f64> {
    match file.materials.get(material)? {
        MaterialSpec::Lambert(lambert) => {
            let [r, g, b] = lambert.reflectance.0;
            (r == g && g == b && lambert.exitance.is_black()).then_some(r)
        }
        _ => None,
    }
}
