//! The scene format (TOML, design section 6): text in, a plain and fully checked description out.
//!
//! Every thing is `[kind.NAME.type]`, so a path is also the key of an override. Reading goes: TOML
//! -> tree with spans -> overrides put into the tree -> types checked -> serde -> checks between
//! keys and between things. Turning the description into objects is left to the room that loads
//! scenes; through [`Source::error`] it too can point at a key.

mod camera;
mod compare;
mod diagnostics;
mod file_ref;
mod light;
mod material;
mod measure;
mod object;
mod object_part;
mod overrides;
mod placement;
mod references;
mod require;
mod sensor;
mod source;
mod spacing;
mod suggest;
mod surface_sensor;
mod task;
#[cfg(test)]
mod tests;
mod types;
mod values;
mod vectors;

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use toml::de::{DeTable, Deserializer, ValueDeserializer};

pub use camera::{CameraSpec, FisheyeSpec, OrthographicSpec, PanoramaSpec, PerspectiveSpec};
pub use compare::{CompareSpec, ExactProblem};
pub use file_ref::FileRef;
pub use light::{DistributionSpec, LightSpec, Strength};
pub use material::{CoatedSpec, LambertSpec, MaterialSpec, MetalSpec, MirrorSpec, MixtureSpec};
pub use object::{
    BoxFace, BoxSpec, DiscSpec, MeshSpec, ObjectSpec, PlaneSpec, RectangleSpec, ShSpec, SphereSpec,
};
pub use overrides::split_override;
pub use placement::{PlacementSpec, Rotation};
pub use require::{Limit, Quantity, RequireSpec};
pub use sensor::{GridLayout, GridPlace, GridSpec, LineLayout, LineSpec, PointsSpec, SensorSpec};
pub use source::Source;
pub use surface_sensor::{SurfaceLayout, SurfacePlace, SurfaceSpec};
pub use task::{DetailSpec, IllumEstimator, IllumSpec, RenderEstimator, RenderSpec, StopSpec};

use crate::error::InputError;
use crate::io::input::Input;
use crate::{Error, Result};
use light::WrittenLight;
use sensor::WrittenSensor;
use source::Entry;

/// Describes a scene: every value is in its range and every name that is referred to exists. Things
/// are sorted by name.
#[derive(Debug, Clone)]
pub struct SceneFile {
    /// How surfaces reflect and emit.
    pub materials: BTreeMap<String, MaterialSpec>,
    /// The shapes.
    pub objects: BTreeMap<String, ObjectSpec>,
    /// The lights that are no surface.
    pub lights: BTreeMap<String, LightSpec>,
    /// Where pictures are taken from.
    pub cameras: BTreeMap<String, CameraSpec>,
    /// Where illuminance is asked for.
    pub sensors: BTreeMap<String, SensorSpec>,
    /// How a picture is made.
    pub render: RenderSpec,
    /// How illuminance is computed.
    pub illum: IllumSpec,
    /// What groups of sensors must show.
    pub require: BTreeMap<String, RequireSpec>,
    /// What groups of sensors are known to receive.
    pub compare: BTreeMap<String, CompareSpec>,
    /// Where everything was written.
    pub source: Source,
}

impl SceneFile {
    /// Reads a scene file; `overrides` are pairs of key path and value, see [`SceneFile::parse`].
    ///
    /// # Errors
    /// [`Error::Io`] when the file cannot be read, and those of [`SceneFile::parse`].
    pub fn read(path: &Path, overrides: &[(&str, &str)]) -> Result<Self> {
        match String::from_utf8(Input::open(path)?.rest()?) {
            Ok(text) => Self::parse(path, &text, overrides),
            Err(error) => Err(not_utf8(path, &error)),
        }
    }

    /// Parses the text of a scene file that stands (or would stand) at `path`, to whose folder its
    /// file paths are relative.
    ///
    /// An override replaces or adds the value at a key path such as `lights.lamp.point.intensity`;
    /// a value that is not TOML is a string without quotes. A whole new thing takes one override:
    /// `lights.spare.point={ at = [1, 1, 1], flux = 500 }`.
    ///
    /// ```
    /// use harmolux::io::scene_file::SceneFile;
    ///
    /// let text = "format = 1\n[lights.lamp.point]\nat = [0, 0, 2]\nintensity = 100";
    /// let overrides = [("lights.lamp.point.intensity", "250")];
    /// let scene = SceneFile::parse("room.toml".as_ref(), text, &overrides)?;
    /// assert_eq!(scene.lights.len(), 1);
    /// # Ok::<(), harmolux::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Input`] with line and column when the text is not a valid scene;
    /// [`Error::Parameter`] that names `-D key` when an override is malformed or what it says is
    /// not valid.
    pub fn parse(path: &Path, text: &str, overrides: &[(&str, &str)]) -> Result<Self> {
        let overrides = overrides::parse_all(overrides, text.len())?;
        let mut source = Source::new(path, text, &overrides);
        let mut tree =
            DeTable::parse(text).map_err(|error| diagnostics::syntax(&error, &source))?;
        for one in overrides {
            one.apply(tree.get_mut(), &types::KINDS)?;
        }
        check_format(tree.get_ref(), &source)?;
        source.index(&tree);
        types::check(tree.get_ref(), &source)?;
        let document = Document::deserialize(Deserializer::from(tree));
        document.map_err(|error| diagnostics::structure(&error, &source))?.check(source)
    }

    /// Returns the camera of `[render]`, or the only one.
    ///
    /// # Errors
    /// [`Error::Input`] when there is none, or several and `[render]` names none.
    pub fn camera(&self) -> Result<(&str, &CameraSpec)> {
        let chosen = match &self.render.camera {
            Some(name) => self.cameras.get_key_value(name),
            None if self.cameras.len() == 1 => self.cameras.first_key_value(),
            None => None,
        };
        chosen.map(|(name, camera)| (name.as_str(), camera)).ok_or_else(|| self.no_camera())
    }

    fn no_camera(&self) -> Error {
        let names: Vec<&String> = self.cameras.keys().collect();
        let (message, help) = match names.first() {
            None => ("the scene has no camera", "add [cameras.main.perspective]".to_owned()),
            Some(first) => (
                "the scene has several cameras and [render] names none",
                format!("add `camera = \"{first}\"`; the cameras are {}", suggest::list(&names)),
            ),
        };
        self.source.error(&["render"], message, Some(help))
    }
}

fn not_utf8(path: &Path, error: &std::string::FromUtf8Error) -> Error {
    let good = String::from_utf8_lossy(&error.as_bytes()[..error.utf8_error().valid_up_to()]);
    let (line, column) = source::line_column(&good, good.len());
    InputError::new(path, "not UTF-8 text")
        .at(line, Some(column))
        .help("a scene is a text file; save it as UTF-8")
        .into()
}

/// Rejects another format before anything else: all that follows may mean something else there.
fn check_format(root: &DeTable, source: &Source) -> Result<()> {
    let Some(value) = root.get("format") else { return Ok(()) };
    match f64::deserialize(ValueDeserializer::from(value.clone())) {
        Ok(number) if number != 1.0 => {
            let message = format!("format {number} is not known");
            let help = "this version reads format 1; write `format = 1`, or use the version the \
                        scene was made for";
            Err(source.error_at(&value.span(), message, Some(help.to_owned())))
        }
        _ => Ok(()),
    }
}

/// The file as serde reads it: every value in its range, nothing compared with anything else yet.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    #[serde(rename = "format", deserialize_with = "values::whole::<1, 1, _, _>")]
    _format: u32,
    #[serde(default)]
    materials: BTreeMap<String, MaterialSpec>,
    #[serde(default)]
    objects: BTreeMap<String, ObjectSpec>,
    #[serde(default)]
    lights: BTreeMap<String, WrittenLight>,
    #[serde(default)]
    cameras: BTreeMap<String, CameraSpec>,
    #[serde(default)]
    sensors: BTreeMap<String, WrittenSensor>,
    #[serde(default, deserialize_with = "values::table")]
    render: RenderSpec,
    #[serde(default, deserialize_with = "values::table")]
    illum: IllumSpec,
    #[serde(default, deserialize_with = "values::tables")]
    require: BTreeMap<String, RequireSpec>,
    #[serde(default)]
    compare: BTreeMap<String, CompareSpec>,
}

impl Document {
    /// Compares keys and things with each other and finds the files.
    fn check(mut self, source: Source) -> Result<SceneFile> {
        references::check_mixtures(&self.materials, &source)?;
        for (name, material) in &self.materials {
            let path = ["materials", name, material.type_name()];
            material.check(&Entry { source: &source, path })?;
        }
        self.check_objects(&source)?;
        for (name, camera) in &self.cameras {
            camera
                .check(&Entry { source: &source, path: ["cameras", name, camera.type_name()] })?;
        }
        if let Some(camera) = &self.render.camera {
            references::check(camera, &self.cameras, "camera", &["render", "camera"], &source)?;
        }
        let lights = checked(self.lights, |name, light| {
            let path = ["lights", name, light.type_name()];
            light.check(&Entry { source: &source, path })
        })?;
        let sensors = checked(self.sensors, |name, sensor| {
            let path = ["sensors", name, sensor.type_name()];
            sensor.check(&Entry { source: &source, path }, &self.objects)
        })?;
        let Self { materials, objects, cameras, render, illum, require, compare, .. } = self;
        require::check(&require, &sensors, &source)?;
        compare::check(&compare, &sensors, &source)?;
        Ok(SceneFile {
            materials,
            objects,
            lights,
            cameras,
            sensors,
            render,
            illum,
            require,
            compare,
            source,
        })
    }

    fn check_objects(&mut self, source: &Source) -> Result<()> {
        for (name, object) in &mut self.objects {
            object.check(&Entry { source, path: ["objects", name, object.type_name()] })?;
            references::check_materials(name, object, &self.materials, source)?;
            object.resolve(source.folder());
        }
        Ok(())
    }
}

/// Checks each thing of a kind.
fn checked<T, U>(
    things: BTreeMap<String, T>,
    check: impl Fn(&str, T) -> Result<U>,
) -> Result<BTreeMap<String, U>> {
    things.into_iter().map(|(name, thing)| check(&name, thing).map(|spec| (name, spec))).collect()
}
