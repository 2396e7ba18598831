//! `[sensors.NAME.surface]`: illuminance all over an object, or a part of it.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer};

use super::measure::MeasureName;
use super::object::{BoxFace, ObjectSpec};
use super::object_part::{box_face, object_and_part};
use super::source::Entry;
use super::suggest::suggest;
use super::values::{whole, word};
use crate::scene::Measure;
use crate::{Error, Result};

/// Describes sensors spread over a surface, on the side its normals point to.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceSpec {
    /// What they are on.
    pub place: SurfacePlace,
    /// How they are spread.
    pub layout: SurfaceLayout,
    /// What is lit there; the normal is the axis of a cylinder. Never half a cylinder, which would
    /// have to face one way on every side.
    pub measure: Measure,
}

/// Says what sensors are spread over; never an infinite plane.
#[derive(Debug, Clone, PartialEq)]
pub enum SurfacePlace {
    /// All of an object, by its name.
    Object(String),
    /// A face of a box.
    Face {
        /// The name of the box.
        object: String,
        /// The face.
        face: BoxFace,
    },
}

/// Says how sensors are spread over a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceLayout {
    /// So many, evenly by area: 1 to 1 000 000.
    Even(u32),
    /// One at each vertex of a mesh.
    Vertices,
    /// One at each vertex of a geodesic sphere that is laid over an SH body or a sphere: the
    /// smallest with so many at least.
    Geodesic(u32),
}

impl SurfacePlace {
    /// Returns the name of the object.
    pub fn object(&self) -> &str {
        match self {
            Self::Object(object) | Self::Face { object, .. } => object,
        }
    }
}

/// The most sensors on a surface.
const MOST: u64 = 1_000_000;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenSurface {
    /// The object, or the face of a box, such as `"room.z_min"`; no infinite plane.
    on: String,
    /// The number of sensors, evenly by area, from 1 to 1 000 000; with `vertices` on an `sh` or
    /// `sphere` object that of the vertices at least. Exactly one of this and `vertices` is given for
    /// a mesh.
    #[serde(default, deserialize_with = "points_if")]
    points: Option<u32>,
    /// Whether they are the vertices of a mesh, or of a geodesic sphere laid over an `sh` or
    /// `sphere` object.
    #[serde(default)]
    vertices: bool,
    /// What is lit at a sensor: a plane, or a cylinder about the normal.
    #[serde(default, deserialize_with = "word")]
    measure: MeasureName,
}

fn points_if<'de, D: Deserializer<'de>>(d: D) -> Result<Option<u32>, D::Error> {
    whole::<1, MOST, _, _>(d).map(Some)
}

impl WrittenSurface {
    pub(super) fn check(
        self,
        entry: &Entry,
        objects: &BTreeMap<String, ObjectSpec>,
    ) -> Result<SurfaceSpec> {
        if self.measure == MeasureName::Semicylindrical {
            let message = "half a cylinder faces one way, and a surface looks to many".to_owned();
            let help = "write `plane` or `cylindrical`, or measure at points";
            return Err(entry.error("measure", message, help));
        }
        let measure = self.measure.with(None, None, entry)?;
        let place = place(&self.on, entry, objects)?;
        let layout = match objects.get(place.object()) {
            Some(object) if self.vertices => self.vertices_of(object, entry)?,
            _ => match self.points {
                Some(points) => SurfaceLayout::Even(points),
                None => return Err(missing_points(entry)),
            },
        };
        Ok(SurfaceSpec { place, layout, measure })
    }

    fn vertices_of(&self, object: &ObjectSpec, entry: &Entry) -> Result<SurfaceLayout> {
        match (object, self.points) {
            (ObjectSpec::Mesh(_), None) => Ok(SurfaceLayout::Vertices),
            (ObjectSpec::Mesh(_), Some(_)) => {
                let message = format!(
                    "`points` in {} has no meaning: a mesh has the vertices it has",
                    entry.header()
                );
                Err(entry.error("points", message, "leave it out, or leave out `vertices`"))
            }
            (ObjectSpec::Sh(_) | ObjectSpec::Sphere(_), Some(points)) => {
                Ok(SurfaceLayout::Geodesic(points))
            }
            (ObjectSpec::Sh(_) | ObjectSpec::Sphere(_), None) => {
                let message = format!("missing key `points` in {}", entry.header());
                let help = "add `points = 1000`: the vertices are those of a geodesic sphere with \
                            so many at least";
                Err(entry.error("", message, help))
            }
            (other, _) => {
                let message = format!(
                    "`{}` is of type `{}`, which has no vertices to measure at",
                    self.on,
                    other.type_name()
                );
                let help = "write `points = 1000` instead";
                Err(entry.error("vertices", message, help))
            }
        }
    }
}

fn missing_points(entry: &Entry) -> Error {
    let message = format!("missing key `points` or `vertices` in {}", entry.header());
    entry.error("", message, "add `points = 1000`, or `vertices = true` for a mesh")
}

/// Understands "object" or "box.face".
fn place(on: &str, entry: &Entry, objects: &BTreeMap<String, ObjectSpec>) -> Result<SurfacePlace> {
    let (name, part) = object_and_part(on, objects);
    let object = name.to_owned();
    match (objects.get(name), part) {
        (Some(ObjectSpec::Plane(_)), _) => {
            let message = format!("`{name}` is an infinite plane, which cannot be covered");
            let help =
                "write a rectangle instead of the plane, or lay a grid of sensors at a `height`";
            Err(entry.error("on", message, help))
        }
        (Some(ObjectSpec::Box(_)), Some(_)) => {
            Ok(SurfacePlace::Face { object, face: box_face(name, part, entry)? })
        }
        (Some(_), None) => Ok(SurfacePlace::Object(object)),
        (Some(other), Some(part)) => {
            let message =
                format!("`{name}` is of type `{}` and has no part `{part}`", other.type_name());
            Err(entry.error("on", message, &format!("write `on = \"{name}\"`")))
        }
        (None, _) => {
            let names: Vec<&String> = objects.keys().collect();
            let help = suggest(name, &names, "objects");
            Err(entry.error("on", format!("unknown object `{name}`"), &help))
        }
    }
}
