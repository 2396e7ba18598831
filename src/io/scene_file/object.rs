//! `[objects.NAME.TYPE]`: the shapes of a scene.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

use super::file_ref::FileRef;
use super::placement::{PlacementSpec, Rotation};
use super::source::Entry;
use super::task::DetailSpec;
use super::values::{Above0, Part, Size, choice, number, number_if, table, table_if, whole};
use super::vectors::{direction, point, point_if};
use crate::Result;
use crate::math::Unit;
use crate::mesh::UpAxis;
use crate::surface::{Intersector, StepBisection};

/// Describes a shape and what it is made of.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum ObjectSpec {
    /// An axis-parallel box.
    Box(BoxSpec),
    /// A rectangle.
    Rectangle(RectangleSpec),
    /// A disc.
    Disc(DiscSpec),
    /// A sphere.
    Sphere(SphereSpec),
    /// An infinite plane.
    Plane(PlaneSpec),
    /// A triangle mesh from a file.
    Mesh(MeshSpec),
    /// A star-shaped surface given by spherical-harmonic coefficients.
    Sh(ShSpec),
}

impl ObjectSpec {
    /// Returns the word of the type: "box", "sh".
    pub const fn type_name(&self) -> &'static str {
        match self {
            Self::Box(_) => "box",
            Self::Rectangle(_) => "rectangle",
            Self::Disc(_) => "disc",
            Self::Sphere(_) => "sphere",
            Self::Plane(_) => "plane",
            Self::Mesh(_) => "mesh",
            Self::Sh(_) => "sh",
        }
    }

    /// Returns the name of the material; of a box, the one its faces have unless told otherwise.
    pub fn material(&self) -> &str {
        match self {
            Self::Box(spec) => &spec.material,
            Self::Rectangle(spec) => &spec.material,
            Self::Disc(spec) => &spec.material,
            Self::Sphere(spec) => &spec.material,
            Self::Plane(spec) => &spec.material,
            Self::Mesh(spec) => &spec.material,
            Self::Sh(spec) => &spec.material,
        }
    }

    /// Returns the file of the shape, if it has one.
    pub fn file(&self) -> Option<&FileRef> {
        match self {
            Self::Mesh(spec) => Some(&spec.file),
            Self::Sh(spec) => Some(&spec.file),
            _ => None,
        }
    }

    pub(super) fn check(&self, entry: &Entry) -> Result<()> {
        match self {
            Self::Box(spec) => spec.check(entry),
            Self::Rectangle(spec) => spec.check(entry),
            Self::Sh(spec) => spec.check(entry),
            Self::Disc(_) | Self::Sphere(_) | Self::Plane(_) | Self::Mesh(_) => Ok(()),
        }
    }

    pub(super) fn resolve(&mut self, folder: &Path) {
        match self {
            Self::Mesh(spec) => spec.file.resolve(folder),
            Self::Sh(spec) => spec.file.resolve(folder),
            _ => {}
        }
    }
}

/// Describes an axis-parallel box; its normals point outwards, or into it when `inward`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxSpec {
    /// The smallest coordinates, metres.
    #[serde(deserialize_with = "point")]
    pub min: DVec3,
    /// The largest coordinates, metres; each above that of `min`.
    #[serde(deserialize_with = "point")]
    pub max: DVec3,
    /// Whether the normals point into the box: a room.
    #[serde(default)]
    pub inward: bool,
    /// The material of the faces not named in `faces`.
    pub material: String,
    /// The materials of single faces: `x_min`, `x_max`, `y_min`, `y_max`, `z_min`, `z_max`.
    #[serde(default)]
    pub faces: BTreeMap<BoxFace, String>,
}

impl BoxSpec {
    /// Returns the material of a face.
    pub fn face_material(&self, face: BoxFace) -> &str {
        self.faces.get(&face).unwrap_or(&self.material)
    }

    fn check(&self, entry: &Entry) -> Result<()> {
        if self.min.cmplt(self.max).all() {
            return Ok(());
        }
        let [min, max] = [self.min, self.max].map(|p| p.to_array());
        let message = format!("`max` {max:?} must be above `min` {min:?} in every coordinate");
        Err(entry.error(
            "max",
            message,
            "swap the coordinates, or write a rectangle for a flat box",
        ))
    }
}

/// Names a face of a box by the coordinate that is constant on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BoxFace {
    /// Smallest x.
    XMin,
    /// Largest x.
    XMax,
    /// Smallest y.
    YMin,
    /// Largest y.
    YMax,
    /// Smallest z.
    ZMin,
    /// Largest z.
    ZMax,
}

impl BoxFace {
    /// All six faces, in the order x_min, x_max, y_min, y_max, z_min, z_max.
    pub const ALL: [Self; 6] =
        [Self::XMin, Self::XMax, Self::YMin, Self::YMax, Self::ZMin, Self::ZMax];

    /// Returns the word that names the face in a scene file.
    pub const fn name(self) -> &'static str {
        ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"][self as usize]
    }

    /// Returns the axis along which the face lies outermost: 0, 1, 2 for x, y, z.
    pub const fn axis(self) -> usize {
        self as usize / 2
    }
}

/// Describes a rectangle; its normal is `edge_u` x `edge_v`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RectangleSpec {
    /// The corner where both edges start, metres.
    #[serde(deserialize_with = "point")]
    pub corner: DVec3,
    /// The first edge, metres.
    #[serde(deserialize_with = "point")]
    pub edge_u: DVec3,
    /// The second edge, metres; perpendicular to the first.
    #[serde(deserialize_with = "point")]
    pub edge_v: DVec3,
    /// The material.
    pub material: String,
}

impl RectangleSpec {
    /// The largest cosine between edges that still counts as a right angle: the rounding of
    /// coordinates written with ten digits.
    const RIGHT_ANGLE: f64 = 1e-9;

    fn check(&self, entry: &Entry) -> Result<()> {
        for (key, edge) in [("edge_u", self.edge_u), ("edge_v", self.edge_v)] {
            if edge == DVec3::ZERO {
                let message = format!("`{key}` in {} has length 0", entry.header());
                return Err(entry.error(key, message, "write the vector along the edge, metres"));
            }
        }
        // Normalised first: the product of two short edges underflows.
        let cosine = self.edge_u.normalize_or_zero().dot(self.edge_v.normalize_or_zero());
        if cosine.abs() <= Self::RIGHT_ANGLE {
            return Ok(());
        }
        let angle = cosine.acos().to_degrees();
        let message =
            format!("`edge_v` must be perpendicular to `edge_u`, found {angle:.3} degrees");
        Err(entry.error("edge_v", message, "write a mesh for a parallelogram"))
    }
}

/// Describes a disc.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DiscSpec {
    /// The centre, metres.
    #[serde(deserialize_with = "point")]
    pub centre: DVec3,
    /// The normal, of length 1.
    #[serde(deserialize_with = "direction")]
    pub normal: DVec3,
    /// The radius, metres, above 0.
    #[serde(deserialize_with = "number::<Size, _>")]
    pub radius: f64,
    /// The material.
    pub material: String,
}

/// Describes a sphere; its normal points outwards, or to the centre when `inward`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereSpec {
    /// The centre, metres.
    #[serde(deserialize_with = "point")]
    pub centre: DVec3,
    /// The radius, metres, above 0.
    #[serde(deserialize_with = "number::<Size, _>")]
    pub radius: f64,
    /// Whether the normal points to the centre.
    #[serde(default)]
    pub inward: bool,
    /// The material.
    pub material: String,
}

/// Describes an infinite plane.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneSpec {
    /// Any point of the plane, metres.
    #[serde(deserialize_with = "point")]
    pub point: DVec3,
    /// The normal, of length 1.
    #[serde(deserialize_with = "direction")]
    pub normal: DVec3,
    /// The material.
    pub material: String,
}

/// Describes a triangle mesh.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshSpec {
    /// The mesh file.
    pub file: FileRef,
    /// Where the mesh's own origin goes, metres.
    #[serde(default, deserialize_with = "point")]
    pub at: DVec3,
    /// The magnification, above 0.
    #[serde(default = "one", deserialize_with = "number::<Above0, _>")]
    pub scale: f64,
    /// The rotation.
    #[serde(default, deserialize_with = "table")]
    pub rotate: Rotation,
    /// The unit of the file's numbers.
    #[serde(default, deserialize_with = "choice")]
    pub unit: Unit,
    /// The axis of the file that points up.
    #[serde(default, deserialize_with = "choice")]
    pub up: UpAxis,
    /// Whether normals are interpolated between vertices for shading.
    #[serde(default)]
    pub smooth: bool,
    /// The material.
    pub material: String,
}

impl MeshSpec {
    /// Returns how the mesh is put into the room.
    pub const fn placement(&self) -> PlacementSpec {
        let Self { at, scale, rotate, unit, up, .. } = *self;
        PlacementSpec { at, scale, rotate, unit, up }
    }
}

/// Describes a spherical-harmonic surface: a coefficient file, or a mesh that is fitted on load.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShSpec {
    /// The mesh or coefficient file.
    pub file: FileRef,
    /// The truncation lmax, from 0 to 1400.
    #[serde(deserialize_with = "whole::<0, 1400, _, _>")]
    pub degree: usize,
    /// Where the file's own origin goes, metres; the expansion centre is part of the shape.
    #[serde(default, deserialize_with = "point")]
    pub at: DVec3,
    /// The magnification, above 0.
    #[serde(default = "one", deserialize_with = "number::<Above0, _>")]
    pub scale: f64,
    /// The rotation.
    #[serde(default, deserialize_with = "table")]
    pub rotate: Rotation,
    /// The unit of the file's numbers.
    #[serde(default, deserialize_with = "choice")]
    pub unit: Unit,
    /// The axis of the file that points up.
    #[serde(default, deserialize_with = "choice")]
    pub up: UpAxis,
    /// The expansion centre in the file's own coordinates; chosen on load when left out.
    #[serde(default, deserialize_with = "point_if")]
    pub centre: Option<DVec3>,
    /// How rays are met.
    #[serde(default, deserialize_with = "intersector")]
    pub intersector: Intersector,
    /// The step of `"step-bisection"`, in units of the largest radius, at least 1e-5; there only.
    #[serde(default, deserialize_with = "number_if::<Above0, _>")]
    pub step: Option<f64>,
    /// The tolerance of `"step-bisection"`, in units of the largest radius; there only.
    #[serde(default, deserialize_with = "number_if::<Part, _>")]
    pub tolerance: Option<f64>,
    /// How far a picture may simplify the shape, instead of what `[render]` says.
    #[serde(default, deserialize_with = "table_if")]
    pub detail: Option<DetailSpec>,
    /// The material.
    pub material: String,
}

impl ShSpec {
    /// Returns how the shape is put into the room.
    pub const fn placement(&self) -> PlacementSpec {
        let Self { at, scale, rotate, unit, up, .. } = *self;
        PlacementSpec { at, scale, rotate, unit, up }
    }

    fn check(&self, entry: &Entry) -> Result<()> {
        let settings = [("step", self.step), ("tolerance", self.tolerance)];
        let given = settings.into_iter().find(|(_, value)| value.is_some());
        match given {
            Some((key, _)) if !matches!(self.intersector, Intersector::StepBisection(_)) => {
                let message = format!(
                    "`{key}` means nothing to this intersector, which steps by its own bounds"
                );
                let help = format!("add `intersector = \"step-bisection\"`, or leave `{key}` out");
                Err(entry.error(key, message, &help))
            }
            _ => self.check_step(entry),
        }
    }

    fn check_step(&self, entry: &Entry) -> Result<()> {
        let shortest = StepBisection::SHORTEST_STEP;
        match self.step {
            Some(step) if step < shortest => {
                let message = format!("`step` of {step:e} takes {:.0e} steps a ray", 2.0 / step);
                let help = format!("the shortest step is {shortest:e} largest radii");
                Err(entry.error("step", message, &help))
            }
            _ => Ok(()),
        }
    }
}

/// Reads how rays are met.
fn intersector<'de, D: Deserializer<'de>>(d: D) -> std::result::Result<Intersector, D::Error> {
    let word = String::deserialize(d)?;
    Intersector::named(&word).ok_or_else(|| D::Error::unknown_variant(&word, Intersector::NAMES))
}

const fn one() -> f64 {
    1.0
}
