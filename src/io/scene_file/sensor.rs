//! `[sensors.NAME.TYPE]`: where illuminance is asked for.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::{Deserialize, Deserializer};

use super::measure::MeasureName;
use super::object::{BoxFace, ObjectSpec};
use super::object_part::{box_face, object_and_part};
use super::source::Entry;
use super::spacing::Spacing;
use super::suggest::suggest;
use super::surface_sensor::{SurfaceSpec, WrittenSurface};
use super::values::{AtLeast0, Coordinate, Size, number, number_if, whole, word};
use super::vectors::{columns_rows_if, direction, direction_if, point, points};
use crate::scene::Measure;
use crate::{Error, Result};

/// Describes a set of illuminance sensors.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum SensorSpec {
    /// Single points with one normal.
    Points(PointsSpec),
    /// A rectangular grid on a flat thing of the scene, or at a height.
    Grid(GridSpec),
    /// Points along a line.
    Line(LineSpec),
    /// Points all over an object.
    Surface(SurfaceSpec),
}

/// Describes equidistant points of illuminance along a line, both ends among them.
#[derive(Debug, Clone, PartialEq)]
pub struct LineSpec {
    /// Where it begins, metres.
    pub from: DVec3,
    /// Where it ends, metres; somewhere else.
    pub to: DVec3,
    /// The side the points look to, or the axis of the cylinder, of length 1.
    pub normal: DVec3,
    /// What is lit there.
    pub measure: Measure,
    /// How the points are spread.
    pub layout: LineLayout,
}

/// Says how the points of a line are spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LineLayout {
    /// At most so far from each other, metres.
    Spacing(f64),
    /// In this number, at least 2.
    Count(u32),
}

/// Describes points of illuminance.
#[derive(Debug, Clone, PartialEq)]
pub struct PointsSpec {
    /// Where they are, metres; at least one.
    pub at: Vec<DVec3>,
    /// The side they look to, or the axis of the cylinder, of length 1.
    pub normal: DVec3,
    /// What is lit there.
    pub measure: Measure,
}

/// Describes a grid of illuminance sensors in the cell centres of what the border leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct GridSpec {
    /// Where the grid lies and which side it looks to.
    pub place: GridPlace,
    /// The width of the strip left out along the edges, metres, 0 or more.
    pub border: f64,
    /// How the points are spread.
    pub layout: GridLayout,
    /// What is lit there; the normal is the axis of a cylinder.
    pub measure: Measure,
}

/// Says where a grid lies.
#[derive(Debug, Clone, PartialEq)]
pub enum GridPlace {
    /// On a face of a box, looking to the side of the box's normal.
    Face {
        /// The name of the box.
        object: String,
        /// The face.
        face: BoxFace,
    },
    /// On a rectangle, looking to the side of its normal.
    Rectangle {
        /// The name of the rectangle.
        object: String,
    },
    /// Horizontally at this z, metres, looking up.
    Height(f64),
}

/// Says how the points of a grid are spread.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum GridLayout {
    /// By the rule of EN 12464-1: p = 0.2 * 5^(log10 d), at most 10 m.
    #[default]
    En12464,
    /// In cells of at most this size, metres.
    Spacing(f64),
    /// In so many columns and rows.
    Count([u32; 2]),
}

/// What the file says, before places and layouts are understood.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum WrittenSensor {
    /// Single points with one normal.
    Points(WrittenPoints),
    /// A rectangular grid on a flat thing of the scene, or at a height.
    Grid(WrittenGrid),
    /// Points along a line, both ends among them.
    Line(WrittenLine),
    /// Points all over an object.
    Surface(WrittenSurface),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenPoints {
    /// Where they are, metres; a list of one point or more.
    #[serde(deserialize_with = "points")]
    at: Vec<DVec3>,
    /// The side they look to, or the axis of the cylinder.
    #[serde(deserialize_with = "direction")]
    normal: DVec3,
    /// What is lit at a sensor: a plane, a cylinder or half of one.
    #[serde(default, deserialize_with = "word")]
    measure: MeasureName,
    /// Where half a cylinder faces; there only, and perpendicular to the normal.
    #[serde(default, deserialize_with = "direction_if")]
    facing: Option<DVec3>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenLine {
    /// Where the line begins, metres.
    #[serde(deserialize_with = "point")]
    from: DVec3,
    /// Where it ends, metres; a sensor stands at both ends.
    #[serde(deserialize_with = "point")]
    to: DVec3,
    /// The side they look to, or the axis of the cylinder.
    #[serde(deserialize_with = "direction")]
    normal: DVec3,
    /// The largest distance between sensors, metres. Exactly one of this and `count` is given.
    #[serde(default, deserialize_with = "number_if::<Size, _>")]
    spacing: Option<f64>,
    /// The number of sensors, 2 or more.
    #[serde(default, deserialize_with = "several_if")]
    count: Option<u32>,
    /// What is lit at a sensor: a plane, a cylinder or half of one.
    #[serde(default, deserialize_with = "word")]
    measure: MeasureName,
    /// Where half a cylinder faces; there only, and perpendicular to the normal.
    #[serde(default, deserialize_with = "direction_if")]
    facing: Option<DVec3>,
}

/// Reads a whole number from 2, of a key that may be left out.
fn several_if<'de, D: Deserializer<'de>>(d: D) -> Result<Option<u32>, D::Error> {
    whole::<2, { u32::MAX as u64 }, _, _>(d).map(Some)
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenGrid {
    /// The rectangle or face of a box it lies on, such as `"room.z_min"`. Exactly one of this and
    /// `height` is given.
    on: Option<String>,
    /// The height of a horizontal grid in a room, metres; it looks up.
    #[serde(default, deserialize_with = "number_if::<Coordinate, _>")]
    height: Option<f64>,
    /// The width of the strip left out along the edges, metres.
    #[serde(default, deserialize_with = "number::<AtLeast0, _>")]
    border: f64,
    /// The largest size of a cell, metres, or `"en12464"`: by the rule of EN 12464-1, p = 0.2 *
    /// 5^(log10 d) and at most 10 m, as when both this and `count` are left out.
    spacing: Option<Spacing>,
    /// The number of columns and rows.
    #[serde(default, deserialize_with = "columns_rows_if")]
    count: Option<[u32; 2]>,
    /// What is lit at a sensor: a plane, a cylinder or half of one.
    #[serde(default, deserialize_with = "word")]
    measure: MeasureName,
    /// Where half a cylinder faces; there only, and perpendicular to the normal.
    #[serde(default, deserialize_with = "direction_if")]
    facing: Option<DVec3>,
}

impl WrittenSensor {
    pub(super) const fn type_name(&self) -> &'static str {
        match self {
            Self::Points(_) => "points",
            Self::Grid(_) => "grid",
            Self::Line(_) => "line",
            Self::Surface(_) => "surface",
        }
    }

    pub(super) fn check(
        self,
        entry: &Entry,
        objects: &BTreeMap<String, ObjectSpec>,
    ) -> Result<SensorSpec> {
        match self {
            Self::Points(WrittenPoints { at, normal, measure, facing }) => {
                let measure = measure.with(facing, Some(normal), entry)?;
                Ok(SensorSpec::Points(PointsSpec { at, normal, measure }))
            }
            Self::Grid(written) => written.check(entry, objects).map(SensorSpec::Grid),
            Self::Line(written) => written.check(entry).map(SensorSpec::Line),
            Self::Surface(written) => written.check(entry, objects).map(SensorSpec::Surface),
        }
    }
}

impl WrittenLine {
    fn check(self, entry: &Entry) -> Result<LineSpec> {
        let Self { from, to, normal, .. } = self;
        if from == to {
            let message = format!("`from` and `to` in {} are the same point", entry.header());
            return Err(entry.error(entry.culprit("from", "to"), message, "move one of them"));
        }
        let layout = match (self.spacing, self.count) {
            (Some(spacing), None) => LineLayout::Spacing(spacing),
            (None, Some(count)) => LineLayout::Count(count),
            (None, None) => {
                let message = format!("missing key `spacing` or `count` in {}", entry.header());
                return Err(entry.error("", message, "add `spacing = 0.5` (m) or `count = 20`"));
            }
            (Some(_), Some(_)) => return Err(both(entry)),
        };
        let measure = self.measure.with(self.facing, Some(normal), entry)?;
        Ok(LineSpec { from, to, normal, measure, layout })
    }
}

/// Rejects `spacing` and `count` together.
fn both(entry: &Entry) -> Error {
    let message = format!("both `spacing` and `count` in {}", entry.header());
    entry.error(entry.culprit("spacing", "count"), message, "keep one of them")
}

impl WrittenGrid {
    fn check(self, entry: &Entry, objects: &BTreeMap<String, ObjectSpec>) -> Result<GridSpec> {
        let place = self.place(entry, objects)?;
        let layout = self.layout(entry)?;
        check_border(&place, self.border, entry, objects)?;
        let measure = self.measure.with(self.facing, axis(&place, objects), entry)?;
        Ok(GridSpec { place, border: self.border, layout, measure })
    }

    fn place(&self, entry: &Entry, objects: &BTreeMap<String, ObjectSpec>) -> Result<GridPlace> {
        match (&self.on, self.height) {
            (Some(on), None) => surface(on, entry, objects),
            (None, Some(height)) => Ok(GridPlace::Height(height)),
            (None, None) => {
                let message = format!("missing key `on` or `height` in {}", entry.header());
                Err(entry.error("", message, "add `on = \"room.z_min\"` or `height = 0.75`"))
            }
            (Some(_), Some(_)) => {
                let message = format!("both `on` and `height` in {}", entry.header());
                Err(entry.error(entry.culprit("on", "height"), message, "keep one of them"))
            }
        }
    }

    fn layout(&self, entry: &Entry) -> Result<GridLayout> {
        match (&self.spacing, self.count) {
            (None, None) => Ok(GridLayout::default()),
            (Some(spacing), None) => Ok(spacing.0),
            (None, Some(count)) => Ok(GridLayout::Count(count)),
            (Some(_), Some(_)) => Err(both(entry)),
        }
    }
}

/// Understands "object" or "object.face".
fn surface(on: &str, entry: &Entry, objects: &BTreeMap<String, ObjectSpec>) -> Result<GridPlace> {
    let (name, face) = object_and_part(on, objects);
    let object = name.to_owned();
    match objects.get(name) {
        Some(ObjectSpec::Box(_)) => {
            let face = box_face(name, face, entry)?;
            Ok(GridPlace::Face { object, face })
        }
        Some(ObjectSpec::Rectangle(_)) if face.is_none() => Ok(GridPlace::Rectangle { object }),
        Some(other) => Err(no_place(name, other, entry)),
        None => {
            let names: Vec<&String> = objects.keys().collect();
            let help = suggest(name, &names, "objects");
            Err(entry.error("on", format!("unknown object `{name}`"), &help))
        }
    }
}

fn no_place(name: &str, object: &ObjectSpec, entry: &Entry) -> Error {
    let (message, help) = match object {
        ObjectSpec::Rectangle(_) => (
            format!("`{name}` is a rectangle, which has no faces to name"),
            format!("write `on = \"{name}\"`"),
        ),
        other => (
            format!("a grid cannot lie on `{name}`, which is of type `{}`", other.type_name()),
            "name a face of a box or a rectangle, or write `height` instead of `on`".to_owned(),
        ),
    };
    entry.error("on", message, &help)
}

/// Returns the line along which the normals of a grid are, where the description alone tells.
fn axis(place: &GridPlace, objects: &BTreeMap<String, ObjectSpec>) -> Option<DVec3> {
    match place {
        GridPlace::Height(_) => Some(DVec3::Z),
        GridPlace::Face { face, .. } => Some(DVec3::AXES[face.axis()]),
        GridPlace::Rectangle { object } => match objects.get(object)? {
            ObjectSpec::Rectangle(spec) => spec.edge_u.cross(spec.edge_v).try_normalize(),
            _ => None,
        },
    }
}

/// Rejects a border that leaves nothing.
fn check_border(
    place: &GridPlace,
    border: f64,
    entry: &Entry,
    objects: &BTreeMap<String, ObjectSpec>,
) -> Result<()> {
    let Some(width) = narrow_side(place, objects) else { return Ok(()) };
    if 2.0 * border < width {
        return Ok(());
    }
    let message = format!("a border of {border} m leaves nothing of a surface {width} m wide");
    Err(entry.error("border", message, &format!("write less than {}", 0.5 * width)))
}

/// Returns the shorter side of the surface a grid lies on, where the description alone tells.
fn narrow_side(place: &GridPlace, objects: &BTreeMap<String, ObjectSpec>) -> Option<f64> {
    match place {
        GridPlace::Height(_) => None,
        GridPlace::Face { object, face } => {
            let ObjectSpec::Box(spec) = objects.get(object)? else { return None };
            let extent = spec.max - spec.min;
            (0..3).filter(|&axis| axis != face.axis()).map(|axis| extent[axis]).reduce(f64::min)
        }
        GridPlace::Rectangle { object } => {
            let ObjectSpec::Rectangle(spec) = objects.get(object)? else { return None };
            Some(spec.edge_u.length().min(spec.edge_v.length()))
        }
    }
}
