//! Points with normals, numbers and colours as a PLY file: a point cloud, or a mesh whose vertices
//! they are.

use glam::DVec3;

use super::ply::writer::{self, COLOUR, CORNERS, Element, POSITION, put_triangle};
use crate::{Error, Result};

/// Holds samples of a surface; every list but the faces has an entry for each position.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SurfaceSamples<'a> {
    /// Said in the header of the file, if it is not empty; no line breaks.
    pub comment: String,
    /// Where they are, metres.
    pub positions: Vec<DVec3>,
    /// The unit normals.
    pub normals: Vec<DVec3>,
    /// What was found there, by the name of each property: letters, digits and `_`.
    pub values: Vec<(&'a str, Vec<f64>)>,
    /// Red, green and blue, 0 to 255.
    pub colours: Vec<[u8; 3]>,
    /// The triangles that join them; none makes a point cloud.
    pub faces: &'a [[u32; 3]],
}

impl SurfaceSamples<'_> {
    /// Returns the bytes of a PLY file: positions as doubles, normals and values as floats, in
    /// little-endian binary.
    ///
    /// # Errors
    /// [`Error::Parameter`] when a list has another length than the positions, a name or the
    /// comment is none, or a face names a sample that is not there.
    pub fn encode_ply(&self) -> Result<Vec<u8>> {
        self.check()?;
        let floats =
            ["nx", "ny", "nz"].into_iter().chain(self.values.iter().map(|(name, _)| *name));
        let floats: Vec<_> = floats.map(|name| ["float", name]).collect();
        let vertices = Element {
            name: "vertex",
            count: self.positions.len(),
            properties: [&POSITION, &floats[..], &COLOUR].concat(),
            row: &|i, bytes| self.row(i, bytes),
        };
        let faces = Element {
            name: "face",
            count: self.faces.len(),
            properties: vec![CORNERS],
            row: &|i, bytes| put_triangle(self.faces[i], bytes),
        };
        let elements = [vertices, faces];
        let cloud = self.faces.is_empty();
        Ok(writer::encode(&self.comment, if cloud { &elements[..1] } else { &elements }))
    }

    fn row(&self, i: usize, bytes: &mut Vec<u8>) {
        bytes.extend(self.positions[i].to_array().iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend(self.normals[i].as_vec3().to_array().iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend(self.values.iter().flat_map(|(_, v)| (v[i] as f32).to_le_bytes()));
        bytes.extend(self.colours[i]);
    }

    fn check(&self) -> Result<()> {
        let count = self.positions.len();
        let lengths = [("normals", self.normals.len()), ("colours", self.colours.len())];
        let lengths = lengths.into_iter().chain(self.values.iter().map(|(n, v)| (*n, v.len())));
        if let Some((what, found)) = lengths.into_iter().find(|(_, found)| *found != count) {
            return Err(Error::Parameter(format!(
                "{found} {what} for {count} samples; give one for each"
            )));
        }
        let plain =
            |n: &str| !n.is_empty() && n.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if let Some((name, _)) = self.values.iter().find(|(name, _)| !plain(name)) {
            return Err(Error::Parameter(format!(
                "`{name}` is no name of a PLY property; write letters, digits and `_`"
            )));
        }
        if self.comment.contains(char::is_control) {
            return Err(Error::Parameter("a comment of a PLY file is one line".to_owned()));
        }
        if let Some(stray) = self.faces.iter().flatten().find(|v| **v as usize >= count) {
            return Err(Error::Parameter(format!(
                "a face names sample {stray}, but there are {count}, numbered from 0"
            )));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::meshes::parse;

    fn triangle(faces: &[[u32; 3]]) -> SurfaceSamples<'_> {
        SurfaceSamples {
            comment: "three points".to_owned(),
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            normals: vec![DVec3::Z; 3],
            values: vec![("illuminance", vec![1.0, 2.0, 3.0])],
            colours: vec![[1, 2, 3]; 3],
            faces,
        }
    }

    #[test]
    fn mesh_is_read_again_and_cloud_has_no_faces() {
        let bytes = triangle(&[[0, 1, 2]]).encode_ply().expect("whole");
        let mesh = parse("map.ply".as_ref(), &bytes).expect("a mesh");
        assert_eq!((mesh.positions().len(), mesh.triangles()), (3, &[[0, 1, 2]][..]));
        let cloud = triangle(&[]).encode_ply().expect("whole");
        assert!(!String::from_utf8_lossy(&cloud).contains("face"));
        // After the header each row: 3 doubles, 3 floats, 1 float, 3 bytes.
        assert_eq!(&cloud[cloud.len() - 7..], [&3.0_f32.to_le_bytes()[..], &[1, 2, 3]].concat());
        assert_eq!(
            bytes.len() - cloud.len(),
            13 + "element face 1\nproperty list uchar uint vertex_indices\n".len()
        );
        assert!(cloud.starts_with(b"ply\nformat binary_little_endian 1.0\ncomment harmolux "));
    }

    #[test]
    fn what_does_not_fit_together_is_refused() {
        let message =
            |samples: SurfaceSamples| samples.encode_ply().expect_err("wrong").to_string();
        let short = SurfaceSamples { normals: vec![DVec3::Z], ..triangle(&[]) };
        assert!(message(short).contains("1 normals for 3 samples"));
        let short = SurfaceSamples { values: vec![("lux", vec![])], ..triangle(&[]) };
        assert!(message(short).contains("0 lux for 3 samples"));
        let odd = SurfaceSamples { values: vec![("E lx", vec![0.0; 3])], ..triangle(&[]) };
        assert!(message(odd).contains("no name"));
        assert!(message(triangle(&[[0, 1, 3]])).contains("names sample 3"));
        let lines = SurfaceSamples { comment: "a\nend_header".to_owned(), ..triangle(&[]) };
        assert!(message(lines).contains("one line"));
    }
}
