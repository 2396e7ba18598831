//! Meshes as the bytes of a file: OBJ and PLY without loss, STL in the f32 that it has.

use std::io::Write;

use glam::DVec3;

use super::MeshFormat;
use super::ply::writer::{self, COLOUR, CORNERS, Element, POSITION, put_triangle};
use crate::io::output::SOFTWARE;
use crate::mesh::Mesh;
use crate::{Error, Result};

/// Colours a mesh by red, green and blue from 0 to 255.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshColours<'a> {
    /// One for each vertex.
    OfVertices(&'a [[u8; 3]]),
    /// One for each face.
    OfFaces(&'a [[u8; 3]]),
}

/// Returns the bytes of a mesh file: OBJ with all digits, PLY as little-endian doubles, STL in
/// binary.
///
/// STL keeps positions in f32 and no vertex twice; what it lost is gone when it is read again.
///
/// # Errors
/// [`Error::Parameter`] for a format that is not written here, and for a coordinate that the f32 of
/// an STL file cannot hold.
///
/// ```
/// use glam::DVec3;
/// use harmolux::io::meshes::{MeshFormat, encode};
/// use harmolux::mesh::Mesh;
/// let mesh = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]])?;
/// let text = String::from_utf8(encode(&mesh, MeshFormat::Obj)?).expect("text");
/// assert!(text.ends_with("v 0.0 1.0 0.0\nf 1 2 3\n"));
/// # Ok::<(), harmolux::Error>(())
/// ```
pub fn encode(mesh: &Mesh, format: MeshFormat) -> Result<Vec<u8>> {
    match format {
        MeshFormat::Obj => Ok(obj(mesh)),
        MeshFormat::Ply => encode_ply(mesh, None),
        MeshFormat::Stl => stl(mesh),
        MeshFormat::Off | MeshFormat::Gltf => Err(Error::Parameter(format!(
            "meshes are not written as {}; write OBJ, PLY or STL",
            format.name()
        ))),
    }
}

/// Returns the bytes of a PLY file, coloured or not.
///
/// # Errors
/// [`Error::Parameter`] when there are not as many colours as vertices or faces.
pub fn encode_ply(mesh: &Mesh, colours: Option<MeshColours>) -> Result<Vec<u8>> {
    let (of_vertices, of_faces) = match colours {
        None => (None, None),
        Some(MeshColours::OfVertices(colours)) => (Some(colours), None),
        Some(MeshColours::OfFaces(colours)) => (None, Some(colours)),
    };
    check_number(of_vertices, mesh.positions().len(), "vertices")?;
    check_number(of_faces, mesh.triangles().len(), "faces")?;
    let coloured = |colours: Option<_>| colours.map_or(&[][..], |_| &COLOUR);
    let vertices = Element {
        name: "vertex",
        count: mesh.positions().len(),
        properties: [&POSITION, coloured(of_vertices)].concat(),
        row: &|i, bytes| {
            bytes.extend(mesh.positions()[i].to_array().iter().flat_map(|x| x.to_le_bytes()));
            bytes.extend(of_vertices.iter().flat_map(|colours| colours[i]));
        },
    };
    let faces = Element {
        name: "face",
        count: mesh.triangles().len(),
        properties: [&[CORNERS], coloured(of_faces)].concat(),
        row: &|i, bytes| {
            put_triangle(mesh.triangles()[i], bytes);
            bytes.extend(of_faces.iter().flat_map(|colours| colours[i]));
        },
    };
    Ok(writer::encode("", &[vertices, faces]))
}

fn check_number(colours: Option<&[[u8; 3]]>, wanted: usize, what: &str) -> Result<()> {
    match colours {
        Some(colours) if colours.len() != wanted => Err(Error::Parameter(format!(
            "{} colours for {wanted} {what}; give one for each",
            colours.len()
        ))),
        _ => Ok(()),
    }
}

fn obj(mesh: &Mesh) -> Vec<u8> {
    let mut text = format!("# {SOFTWARE}\n").into_bytes();
    for DVec3 { x, y, z } in mesh.positions() {
        // Unlike Display, Debug turns to exponents where plain digits would be hundreds. Writing
        // into a Vec cannot fail.
        let _ = writeln!(text, "v {x:?} {y:?} {z:?}");
    }
    for triangle in mesh.triangles() {
        let [a, b, c] = triangle.map(|v| u64::from(v) + 1);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}

fn stl(mesh: &Mesh) -> Result<Vec<u8>> {
    const HEADER: usize = 80;
    let count = u32::try_from(mesh.triangles().len()).map_err(|_| {
        Error::Parameter("STL counts to 4294967295 faces only; write PLY".to_owned())
    })?;
    let mut bytes = SOFTWARE.as_bytes().to_vec();
    bytes.reserve_exact(HEADER + 4 + 50 * mesh.triangles().len());
    bytes.resize(HEADER, 0);
    bytes.extend(count.to_le_bytes());
    for face in 0..mesh.triangles().len() {
        let corners = mesh.corners(face).map(|p: DVec3| p.as_vec3());
        if !corners.iter().all(|p| p.is_finite()) {
            return Err(Error::Parameter(format!(
                "face {face} (from 0) has a coordinate that the f32 of STL cannot hold; write PLY \
                 or OBJ"
            )));
        }
        let normal = mesh.normal(face).unwrap_or(DVec3::ZERO).as_vec3();
        for vector in [normal, corners[0], corners[1], corners[2]] {
            bytes.extend(vector.to_array().iter().flat_map(|x| x.to_le_bytes()));
        }
        bytes.extend([0, 0]);
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn empty_mesh_has_a_header() {
        let empty = Mesh::default();
        assert_eq!(
            encode(&empty, MeshFormat::Obj).expect("OBJ"),
            format!("# {SOFTWARE}\n").into_bytes()
        );
        assert_eq!(encode(&empty, MeshFormat::Stl).expect("STL").len(), 84);
        assert!(encode(&empty, MeshFormat::Ply).expect("PLY").ends_with(b"end_header\n"));
    }

    #[test]
    fn formats_that_are_only_read_are_refused() {
        for format in [MeshFormat::Off, MeshFormat::Gltf] {
            let error = encode(&shapes::cube(), format).unwrap_err().to_string();
            assert!(error.contains("write OBJ, PLY or STL"), "{error}");
        }
    }

    #[test]
    fn each_byte_is_where_the_format_wants_it() {
        let cube = shapes::cube();
        let stl = encode(&cube, MeshFormat::Stl).expect("STL");
        assert_eq!((stl.len(), &stl[80..84]), (84 + 12 * 50, &[12, 0, 0, 0][..]));
        // The first face of the cube is in the plane x = 0 and looks to -x.
        assert_eq!(stl[84..88], (-1.0_f32).to_le_bytes());
        let colours = [[1, 2, 3]; 12];
        let ply = encode_ply(&cube, Some(MeshColours::OfFaces(&colours))).expect("PLY");
        assert_eq!(ply[ply.len() - 16..], [3, 4, 0, 0, 0, 7, 0, 0, 0, 6, 0, 0, 0, 1, 2, 3]);
        let wrong = encode_ply(&cube, Some(MeshColours::OfVertices(&colours))).unwrap_err();
        assert!(wrong.to_string().starts_with("12 colours for 8 vertices"), "{wrong}");
    }

    #[test]
    fn what_f32_cannot_hold_is_refused() {
        let huge = shapes::cube().scaled(1e39).expect("positive");
        let error = encode(&huge, MeshFormat::Stl).unwrap_err().to_string();
        assert!(error.contains("the f32 of STL cannot hold; write PLY or OBJ"), "{error}");
    }
}
