//! Where the illuminance of a surface goes: a PLY file with false colours.

use std::path::Path;

use harmolux::io::meshes::{MeshFormat, SurfaceSamples};
use harmolux::io::output::{Output, Stage};
use harmolux::io::scene_file::{SceneFile, SensorSpec};
use harmolux::plots::Palette;
use harmolux::{Error, Result};

use crate::common::say;
use crate::illum::{Group, Illum};

/// The colour of sensors that are behind an object.
const BEHIND: [u8; 3] = [128; 3];

/// A file to write, and the group that goes there.
pub(crate) struct MapTarget {
    group: String,
    output: Output,
}

/// Whether a file is to be a map.
pub(crate) fn is_map(path: &Path) -> bool {
    MeshFormat::of_extension(path) == Some(MeshFormat::Ply)
}

impl MapTarget {
    /// Opens a file for the only group of kind surface, or for the one that the file is named
    /// after.
    pub(crate) fn open(path: &Path, file: &SceneFile, verb: &Illum) -> Result<Self> {
        let surfaces = file.sensors.iter().filter(|(_, s)| matches!(s, SensorSpec::Surface(_)));
        let names: Vec<&String> = surfaces.map(|(name, _)| name).collect();
        let named =
            names.iter().find(|name| path.file_stem().is_some_and(|stem| stem == name.as_str()));
        let group = match (names.as_slice(), named) {
            (_, Some(name)) | ([name], None) => (*name).clone(),
            ([], None) => {
                return Err(Error::Parameter(format!(
                    "{}: the scene has no sensors of kind surface to write as PLY; add \
                     [sensors.NAME.surface], or name a .csv file",
                    verb.common.scene.display()
                )));
            }
            (several, None) => {
                let list: Vec<String> =
                    several.iter().map(|name| format!("-o {name}.ply")).collect();
                return Err(Error::Parameter(format!(
                    "{}: a PLY file holds one group of sensors of kind surface, and the scene has \
                     {}; name each file after its group: {}",
                    path.display(),
                    several.len(),
                    list.join(" ")
                )));
            }
        };
        let output = Output::open(path, &MeshFormat::Ply.kind(), verb.force)?;
        Ok(Self { group, output })
    }

    /// Returns where it goes.
    pub(crate) fn path_at(&self, stage: Stage) -> &Path {
        self.output.path_at(stage)
    }

    /// Writes the group: position, normal, illuminance, half width and false colour of each sensor,
    /// viridis from 0 to the largest illuminance.
    pub(crate) fn write(self, groups: &[Group], stage: Stage) -> Result<()> {
        let Some(group) = groups.iter().find(|group| group.name == self.group) else {
            return Ok(());
        };
        let counting = group.results.iter().zip(group.behind).filter(|(_, b)| b.is_none());
        let largest = counting.map(|(r, _)| r.total.mean).fold(0.0, f64::max);
        let scale = format!("viridis from 0 to {} lx", say::significant(largest, 4));
        let colour =
            |value: f64| Palette::Viridis.colour(if largest > 0.0 { value / largest } else { 0.0 });
        let colours = group.results.iter().zip(group.behind);
        let colours =
            colours.map(|(r, behind)| if behind.is_some() { BEHIND } else { colour(r.total.mean) });
        let samples = SurfaceSamples {
            comment: format!("illuminance and half_width (95 %) in lx; colours: {scale}"),
            positions: group.sensors.iter().map(|s| s.at).collect(),
            normals: group.sensors.iter().map(|s| s.normal).collect(),
            values: vec![
                ("illuminance", group.results.iter().map(|r| r.total.mean).collect()),
                ("half_width", group.results.iter().map(|r| r.total.half_width(0.05)).collect()),
            ],
            colours: colours.collect(),
            faces: group.faces,
        };
        let mut output = self.output;
        output.write_at(stage, &samples.encode_ply()?)?;
        say::note(&format!("{}: {scale}", output.path_at(stage).display()));
        Ok(())
    }
}
