//! `measure` and `facing` of sensors: what the illuminance is that of.

use glam::DVec3;
use serde::Deserialize;

use super::source::Entry;
use crate::Result;
use crate::scene::Measure;

/// Names what is lit at a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum MeasureName {
    /// A plane.
    #[default]
    Plane,
    /// The side of a cylinder about the normal.
    Cylindrical,
    /// The side of half a cylinder.
    Semicylindrical,
}

/// How far `facing` may be from perpendicular to the axis, as a cosine.
const SQUARE: f64 = 1e-6;

impl MeasureName {
    /// Takes the name and where half a cylinder faces together; `axis` is the normal of the
    /// sensors, where it is known.
    pub(super) fn with(
        self,
        facing: Option<DVec3>,
        axis: Option<DVec3>,
        entry: &Entry,
    ) -> Result<Measure> {
        match (self, facing) {
            (Self::Plane, None) => Ok(Measure::Plane),
            (Self::Cylindrical, None) => Ok(Measure::Cylinder),
            (Self::Semicylindrical, Some(facing)) => {
                let cos = axis.map_or(0.0, |axis| axis.dot(facing));
                if cos.abs() > SQUARE {
                    let message = format!(
                        "`facing` in {} must be perpendicular to the axis, which is the normal",
                        entry.header()
                    );
                    let help = "write a horizontal direction for a normal that is vertical";
                    return Err(entry.error("facing", message, help));
                }
                Ok(Measure::SemiCylinder { facing })
            }
            (Self::Semicylindrical, None) => {
                let message = format!("missing key `facing` in {}", entry.header());
                Err(entry.error(
                    "",
                    message,
                    "add `facing = [1, 0, 0]`, where half a cylinder faces",
                ))
            }
            (Self::Plane | Self::Cylindrical, Some(_)) => {
                let message = format!("`facing` in {} has no meaning", entry.header());
                Err(entry.error(
                    "facing",
                    message,
                    "leave it out, or write `measure = \"semicylindrical\"`",
                ))
            }
        }
    }
}
