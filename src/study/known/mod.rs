//! What sensors are known to receive, by `[compare]`: written values, or the exact solution of the
//! problem that the scene states.
//!
//! A problem is recognised from the scene as it stands, whatever its sizes and strengths are; a
//! scene that is another problem is refused with what differs.

mod direct;
mod enclosures;
mod facts;
mod furnace;
mod planes;
#[cfg(test)]
mod tests;

use crate::io::scene_file::{CompareSpec, ExactProblem, SceneFile};
use crate::scene::{Measure, Sensor};
use crate::{Error, Result};

use super::sensors::SensorGroup;

/// Says why a scene or a sensor has no exact value.
enum Mismatch {
    /// What in the scene differs from the problem.
    Scene(String),
    /// What is wrong with the sensor, as the end of a sentence about it.
    Sensor(&'static str),
    /// The solution cannot be computed.
    Unsolved(Error),
}

impl From<Error> for Mismatch {
    fn from(error: Error) -> Self {
        Self::Unsolved(error)
    }
}

/// Returns the exact illuminance, lx, of a sensor.
type Solution<'a> = Box<dyn Fn(&Sensor) -> Result<f64, Mismatch> + 'a>;

/// Returns the known illuminances, lx, of a group's sensors; `None` when `[compare]` does not name
/// it. For a sensor behind an object it means nothing.
///
/// # Errors
/// [`crate::Error::Input`] that points at the group in `[compare]`: a number of values that is not
/// that of the sensors, a scene that is not the problem named, sensors that are not where the
/// problem has an answer.
pub fn known_illuminance(file: &SceneFile, group: &SensorGroup) -> Result<Option<Vec<f64>>> {
    let Some(spec) = file.compare.get(&group.name) else { return Ok(None) };
    let fault = |message: String, help: &str| {
        file.source.error(&["compare", &group.name], message, Some(help.to_owned()))
    };
    let problem = match spec {
        CompareSpec::Values(values) if values.len() == group.sensors.len() => {
            return Ok(Some(values.clone()));
        }
        CompareSpec::Values(values) => {
            let (found, sensors) = (values.len(), group.sensors.len());
            let message = format!("{found} values for the {sensors} sensors of `{}`", group.name);
            return Err(fault(message, "write one value for each sensor, in order"));
        }
        CompareSpec::Exact(problem) => *problem,
    };
    let Text { title, needs, places } = text(problem);
    let refuse = |mismatch, sensor: usize| match mismatch {
        Mismatch::Scene(what) => fault(format!("the scene is not {title}: {what}"), needs),
        Mismatch::Sensor(what) => {
            fault(format!("sensor {} of `{}` {what}", sensor + 1, group.name), places)
        }
        Mismatch::Unsolved(error) => {
            fault(format!("{title} has no exact solution here: {error}"), needs)
        }
    };
    let solution = solution(problem, file).map_err(|mismatch| refuse(mismatch, 0))?;
    let value = |i: usize, sensor: &Sensor| {
        if problem != ExactProblem::Furnace && sensor.measure != Measure::Plane {
            return Err(Mismatch::Sensor("measures a cylinder, and only planes are known"));
        }
        // Nothing is known there, and nothing compared.
        if group.behind[i].is_some() { Ok(f64::NAN) } else { solution(sensor) }
    };
    let values = group.sensors.iter().enumerate();
    values.map(|(i, s)| value(i, s).map_err(|m| refuse(m, i))).collect::<Result<_>>().map(Some)
}

fn solution(problem: ExactProblem, file: &SceneFile) -> Result<Solution<'_>, Mismatch> {
    match problem {
        ExactProblem::Sobolev => planes::sobolev(file),
        ExactProblem::Discs => planes::discs(file),
        ExactProblem::Sphere => enclosures::sphere(file),
        ExactProblem::Cap => enclosures::cap(file),
        ExactProblem::Concentric => enclosures::concentric(file),
        ExactProblem::Cube => enclosures::cube(file),
        ExactProblem::Furnace => furnace::furnace(file),
        ExactProblem::Direct => direct::direct(file),
    }
}

/// What is said of a problem.
struct Text {
    title: &'static str,
    /// What the scene needs.
    needs: &'static str,
    /// Where sensors belong.
    places: &'static str,
}

const fn text(problem: ExactProblem) -> Text {
    match problem {
        ExactProblem::Sobolev => Text {
            title: "Sobolev's problem",
            needs: "it needs two planes that face each other, grey Lambert materials that do not \
                    emit, one point light of colour white between them, and nothing else",
            places: "lay all sensors on the planes, their normals like those of the planes",
        },
        ExactProblem::Discs => Text {
            title: "Sobolev's problem between discs",
            needs: "it needs two discs of one radius that face each other, grey Lambert materials \
                    that do not emit, one point light of colour white on their axis between them, \
                    and nothing else",
            places: "lay all sensors in the planes of the discs, their normals like those of the \
                     discs",
        },
        ExactProblem::Sphere => Text {
            title: "the inside of a sphere",
            needs: "it needs one sphere with `inward = true` of a grey Lambert material that may \
                    emit, point lights of colour white, and nothing else",
            places: "lay all sensors on the sphere, their normals towards its centre",
        },
        ExactProblem::Cap => Text {
            title: "a sphere that a disc divides",
            needs: "it needs one sphere with `inward = true`, one disc whose rim is on it, grey \
                    Lambert materials of which at least one emits, and nothing else",
            places: "lay all sensors on the sphere, their normals towards its centre, or on \
                     either side of the disc",
        },
        ExactProblem::Concentric => Text {
            title: "the space between two concentric spheres",
            needs: "it needs a sphere and a larger one with `inward = true` about the same \
                    centre, grey Lambert materials of which at least one emits, and nothing else",
            places: "lay all sensors on the spheres, their normals into the space between them",
        },
        ExactProblem::Cube => Text {
            title: "a cube with a lamp in its middle",
            needs: "it needs one box with `inward = true` of equal edges, one grey Lambert \
                    material on all faces that does not emit, one point light of colour white in \
                    its middle, and nothing else",
            places: "lay all sensors on the faces of the box, their normals into it",
        },
        ExactProblem::Furnace => Text {
            title: "a furnace",
            needs: "it needs one box or sphere with `inward = true` around closed shapes of any \
                    kind, Lambert materials with exitance = C (1 - reflectance), C the same in \
                    all of them, and no other lights; everything then receives C",
            places: "lay all sensors in the room",
        },
        ExactProblem::Direct => Text {
            title: "direct light between black surfaces",
            needs: "it needs boxes and rectangles of Lambert materials of reflectance 0, some of \
                    which may emit, and point lights; at most one box with `inward = true` is the \
                    room around it all",
            places: "lay all sensors in the room where at most one object hides any of the lights",
        },
    }
}
