//! The formats of mesh files: their names, extensions, and the mark of a file that this program
//! wrote.

use std::path::Path;

use crate::io::output::Kind;
use crate::{Error, Result};

/// Names a format of mesh files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MeshFormat {
    /// Wavefront OBJ: text, all digits kept.
    Obj,
    /// Stanford PLY: read as text or binary of either byte order, written as little-endian doubles.
    Ply,
    /// Stereolithography: read as text or binary, written as binary; f32, and every face has its
    /// own three vertices.
    Stl,
    /// Object File Format: read only.
    Off,
    /// glTF 2.0, as text (`.gltf`) or binary (`.glb`): read only.
    Gltf,
}

impl MeshFormat {
    /// Lists the formats that can be written.
    pub const fn writable() -> [Self; 3] {
        [Self::Obj, Self::Ply, Self::Stl]
    }

    /// Returns the format by the extension of a file name, upper or lower case; `None` when it is
    /// not one of a mesh.
    ///
    /// ```
    /// use std::path::Path;
    /// use harmolux::io::meshes::MeshFormat;
    /// assert_eq!(MeshFormat::of_extension(Path::new("head.PLY")), Some(MeshFormat::Ply));
    /// assert_eq!(MeshFormat::of_extension(Path::new("head.png")), None);
    /// ```
    pub fn of_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            "off" => Some(Self::Off),
            "gltf" | "glb" => Some(Self::Gltf),
            _ => None,
        }
    }

    /// Returns in which format a mesh is to be written under this name.
    ///
    /// # Errors
    /// [`Error::Parameter`] when the extension is not one of [`MeshFormat::writable`].
    pub fn for_writing(path: &Path) -> Result<Self> {
        let format = Self::of_extension(path).filter(|f| Self::writable().contains(f));
        format.ok_or_else(|| {
            Error::Parameter(format!(
                "{}: meshes are written as .obj, .ply or .stl: name it {}",
                path.display(),
                path.with_extension("ply").display()
            ))
        })
    }

    /// Describes the files of this format that this program writes.
    pub const fn kind(self) -> Kind {
        match self {
            Self::Obj => Kind::new("an OBJ mesh", &["obj"], b"# harmolux "),
            Self::Ply => Kind::new(
                "a PLY mesh",
                &["ply"],
                b"ply\nformat binary_little_endian 1.0\ncomment harmolux ",
            ),
            Self::Stl => Kind::new("an STL mesh", &["stl"], b"harmolux "),
            Self::Off => Kind::new("an OFF mesh", &["off"], b"OFF\n# harmolux "),
            Self::Gltf => Kind::new("a glTF scene", &["glb", "gltf"], b"glTF"),
        }
    }

    /// Returns the name of the format, as in "a PLY file".
    pub const fn name(self) -> &'static str {
        match self {
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Stl => "STL",
            Self::Off => "OFF",
            Self::Gltf => "glTF",
        }
    }
}
