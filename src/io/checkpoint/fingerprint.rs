//! What must be the same for a run to go on, in the words of the scene file.

use std::collections::BTreeMap;
use std::path::Path;

use super::super::output::SOFTWARE;
use super::super::scene_file::SceneFile;
use crate::Result;
use crate::io::input::FilesRead;

/// Says all that must be the same for a run to go on: names and values, in order.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Fingerprint {
    pub(super) fields: Vec<(String, String)>,
}

impl Fingerprint {
    /// Takes the program's version.
    pub fn new() -> Self {
        Self::default().with("program", SOFTWARE)
    }

    /// Adds a field.
    pub fn with(mut self, name: &str, value: impl Into<String>) -> Self {
        self.fields.push((name.to_owned(), value.into()));
        self
    }

    /// Adds what a scene says of the camera that takes the picture, of detail, materials, lights
    /// and objects. Comments, layout, sensors, other cameras, the number of pixels and stop rules
    /// may change.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when no camera is chosen.
    pub fn with_scene(mut self, scene: &SceneFile) -> Result<Self> {
        let camera = scene.camera()?.0;
        self = self.with("the camera", camera);
        let parts: [&[&str]; 5] = [
            &["cameras", camera],
            &["render", "detail"],
            &["materials"],
            &["lights"],
            &["objects"],
        ];
        for (key, value) in parts.iter().flat_map(|part| scene.source.values(part)) {
            if !(key.starts_with("cameras.") && key.ends_with(".resolution")) {
                self = self.with(&key, value);
            }
        }
        Ok(self)
    }

    /// Adds what was read for each object when the scene was loaded: its file, and the files that
    /// this names, by their places beside it.
    pub fn with_files(mut self, objects: &BTreeMap<String, FilesRead>) -> Self {
        for (object, FilesRead { file, beside, .. }) in objects {
            self = self.with(&format!("the file of objects.{object}"), file.to_string());
            let folder = file.path().parent().unwrap_or(Path::new(""));
            for other in beside {
                let place = other.path().strip_prefix(folder).unwrap_or(other.path());
                let name = format!("the file `{}` of objects.{object}", place.display());
                self = self.with(&name, other.to_string());
            }
        }
        self
    }

    /// Says what differs from `other`, the present one; `None` when they agree.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let value = |all: &Self, name: &str| {
            all.fields.iter().find(|(n, _)| n == name).map(|(_, value)| value.clone())
        };
        let names = self.fields.iter().chain(&other.fields).map(|(name, _)| name);
        for name in names {
            match (value(self, name), value(other, name)) {
                (Some(then), Some(now)) if then == now => {}
                (Some(then), Some(now)) => return Some(format!("{name} was `{then}`, is `{now}`")),
                (Some(then), None) => return Some(format!("{name} was `{then}`, is not there")),
                (None, Some(now)) => return Some(format!("{name} was not there, is `{now}`")),
                (None, None) => {}
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::input::Input;

    const ROOM: &str = "format = 1
[materials.grey.lambert]
reflectance = 0.5
[materials.dust.mixture]
of = { grey = 0.5, black = 0.5 }
[materials.black.lambert]
reflectance = [0, 0, 0]
[objects.ball.sphere]
centre = [2, 3, 1]
radius = 0.7
material = \"grey\"
[cameras.main.perspective]
from = [2, 0.3, 1.5]
to = [2, 3, 1]
fov = 60
resolution = [12, 8]
[cameras.other.panorama]
from = [2, 2, 2]
resolution = [12, 6]
[render]
camera = \"main\"
";

    fn of(text: &str, overrides: &[(&str, &str)]) -> Fingerprint {
        let scene = SceneFile::parse(Path::new("room.toml"), text, overrides).expect("valid");
        Fingerprint::new().with_scene(&scene).expect("a camera")
    }

    #[test]
    fn differences_are_told_as_the_scene_file_has_them() {
        for (key, value, says) in [
            (
                "materials.grey.lambert.reflectance",
                "0.6",
                "materials.grey.lambert.reflectance was `0.5`, is `0.6`",
            ),
            (
                "materials.dust.mixture.of",
                "{ grey = 0.6, black = 0.4 }",
                "materials.dust.mixture.of.black was `0.5`, is `0.4`",
            ),
            (
                "materials.black.lambert.reflectance",
                "[0, 0, 0.1]",
                "materials.black.lambert.reflectance was `[0, 0, 0]`, is `[0, 0, 0.1]`",
            ),
            (
                "materials.black.lambert.exitance",
                "3",
                "materials.black.lambert.exitance was not there, is `3`",
            ),
            (
                "objects.ball.sphere.material",
                "black",
                "objects.ball.sphere.material was `\"grey\"`, is `\"black\"`",
            ),
            (
                "cameras.main.perspective.fov",
                "50",
                "cameras.main.perspective.fov was `60`, is `50`",
            ),
            ("render.camera", "other", "the camera was `main`, is `other`"),
            ("render.detail", "{ pixels = 0.5 }", "render.detail.pixels was not there, is `0.5`"),
        ] {
            let said = of(ROOM, &[]).difference(&of(ROOM, &[(key, value)]));
            assert_eq!(said.as_deref(), Some(says));
        }
    }

    #[test]
    fn files_are_told_by_object_and_place() {
        let of = |file: &[u8], beside: &[u8]| {
            let read = |path: &str, bytes: &[u8]| {
                Input::of_bytes(Path::new(path), bytes).finish().expect("in memory").file
            };
            let beside = vec![read("shapes/parts/m.bin", beside)];
            let file = read("shapes/m.gltf", file);
            let read = FilesRead { file, beside, remarks: Vec::new() };
            Fingerprint::new().with_files(&BTreeMap::from([("head".to_owned(), read)]))
        };
        let first = of(b"{}", b"");
        assert_eq!(first.difference(&of(b"{}", b"")), None);
        let said = first.difference(&of(b"{ }", b"")).expect("differs");
        assert!(said.starts_with("the file of objects.head was `2 bytes, fnv1a64:"), "{said}");
        let said = first.difference(&of(b"{}", b"foobar")).expect("differs");
        let expected = "the file `parts/m.bin` of objects.head was `0 bytes, \
                        fnv1a64:cbf29ce484222325`, is `6 bytes, fnv1a64:85944171f73967e8`";
        assert_eq!(said, expected);
    }

    #[test]
    fn layout_other_cameras_and_the_number_of_pixels_may_change() {
        let moved = ROOM
            .replace("reflectance = 0.5", "reflectance = 0.50  # as measured")
            .replace("[0, 0, 0]", "[\n  0.0, 0.0,\n  0.0,\n]")
            .replace("centre = [2, 3, 1]\nradius = 0.7", "radius = 7e-1\ncentre = [2, 3, 1.0]");
        let changes = [
            ("cameras.main.perspective.resolution", "[24, 16]"),
            ("cameras.other.panorama.from", "[1, 1, 1]"),
            ("render.stop.walks", "64"),
        ];
        assert_eq!(of(ROOM, &[]).difference(&of(&moved, &changes)), None);
    }
}
