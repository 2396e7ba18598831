//! Stanford PLY, as text and as binary of either byte order: the vertices' x, y, z and the faces,
//! whatever else the file holds, and whatever follows it.
//!
//! The header says what each row of each element holds; rows are read one by one, so that nothing
//! but the mesh is held. Counts are believed only as far as the file is long enough for them.

pub(super) mod writer;

use glam::DVec3;

use super::parts::{CUT, Parts, thin_face, too_many};
use crate::io::ply::{Element, Header, Place, Rows, Shape, Value};
use crate::io::source::{Source, not_finite};
use crate::mesh::Mesh;
use crate::{Error, Result};

/// Reads the content of a PLY file.
///
/// # Errors
/// [`Error::Input`] when the header cannot be used, the file is shorter than its header says, or a
/// vertex or face is none.
pub(super) fn parse(source: &mut Source) -> Result<Mesh> {
    let header = Header::read(source)?;
    let places = Places::of(source, &header)?;
    header.check_length(source)?;
    let mut parts = Parts::default();
    for element in &header.elements {
        let mut rows = Rows::new(source, header.encoding, element);
        match element.name.as_str() {
            "vertex" => read_vertices(&mut rows, places.coordinates, &mut parts)?,
            "face" => read_faces(&mut rows, &places, &mut parts)?,
            STRIPS => read_strips(&mut rows, &places, &mut parts)?,
            _ => rows.pass_over()?,
        }
    }
    parts.finish(source)
}

/// The element whose rows are strips of triangles.
const STRIPS: &str = "tristrips";

/// Where in the rows the things stand that make a mesh.
struct Places {
    vertices: u64,
    /// Of x, y and z in a vertex.
    coordinates: [usize; 3],
    /// Of the list of vertices in a face.
    corners: Option<usize>,
    /// Of the list of vertices in a row of strips.
    strips: Option<usize>,
}

impl Places {
    fn of(source: &Source, header: &Header) -> Result<Self> {
        let missing = |name: &str| {
            let help = "a mesh needs both, as in `element vertex 8` and `element face 12`; export \
                        it with its faces";
            source.fault(format!("the header has no element {name}"), help)
        };
        let vertices = header.element("vertex").ok_or_else(|| missing("vertex"))?;
        let (faces, strips) = (header.element("face"), header.element(STRIPS));
        if faces.or(strips).is_none() {
            return Err(missing("face"));
        }
        let list = |element: &Element| {
            let found = element.whole_list(&["vertex_indices", "vertex_index"]);
            found.ok_or_else(|| {
                let help = "declare it, as in `property list uchar int vertex_indices`";
                let plural = if element.name == STRIPS { STRIPS } else { "faces" };
                let message = format!("{plural} have no list of vertices");
                source.fault_at(element.line, message, help)
            })
        };
        let (corners, strips) = (faces.map(list).transpose()?, strips.map(list).transpose()?);
        if vertices.count > super::parts::MOST_VERTICES {
            return Err(source.fault_at(
                vertices.line,
                too_many(vertices.count),
                "divide the file",
            ));
        }
        let coordinates = vertices.coordinates(source)?;
        Ok(Self { vertices: vertices.count, coordinates, corners, strips })
    }
}

fn read_vertices(rows: &mut Rows, places: [usize; 3], parts: &mut Parts) -> Result<()> {
    // The file is long enough for its counts: a row takes an eighth of this at least.
    parts.positions.reserve_exact(rows.count() as usize);
    let mut values = Vec::new();
    while rows.next_scalars(&mut values)? {
        let position = DVec3::from_array(places.map(|place| values[place]));
        if !position.is_finite() {
            let (message, help) = not_finite(parts.positions.len(), position);
            return Err(rows.fault(message, help));
        }
        parts.vertex(rows.source(), position)?;
    }
    Ok(())
}

fn read_faces(rows: &mut Rows, places: &Places, parts: &mut Parts) -> Result<()> {
    let least = rows.element().least_bytes(rows.encoding()).max(1);
    parts.triangles.reserve_exact(rows.count().min(rows.source().left() / least) as usize);
    let mut corners = Vec::new();
    for_each_list(rows, places.corners, |rows, property| {
        corners.clear();
        rows.list(property, |place, value| {
            corners.push(vertex_of(&place, value, places.vertices)?);
            Ok(())
        })?;
        if corners.len() < 2 {
            let help = "give a face at least three vertices";
            return Err(rows.fault(thin_face(corners.len() as u64), help));
        }
        parts.polygon(&corners).map_err(|e| rows.fault(e.to_string(), CUT))
    })
}

/// Reads strips, one behind the other in a row, each ended by -1: every corner from the third makes
/// a triangle with the two before it, every other one turned.
fn read_strips(rows: &mut Rows, places: &Places, parts: &mut Parts) -> Result<()> {
    for_each_list(rows, places.strips, |rows, property| {
        let (mut last, mut count) = ([0; 2], 0_u64);
        rows.list(property, |place, value| {
            if value.as_whole() == Some(-1) {
                count = 0;
                return Ok(());
            }
            let ([a, b], c) = (last, vertex_of(&place, value, places.vertices)?);
            // Those that name a vertex twice only lead from one part of a strip to the next.
            if count >= 2 && a != b && b != c && c != a {
                parts.triangles.push(if count.is_multiple_of(2) { [a, b, c] } else { [b, a, c] });
            }
            (last, count) = ([b, c], count + 1);
            Ok(())
        })
    })
}

/// Goes through the rows of an element and has one of its lists read, all else passed over.
fn for_each_list(
    rows: &mut Rows,
    place: Option<usize>,
    mut read: impl FnMut(&mut Rows, usize) -> Result<()>,
) -> Result<()> {
    while rows.next_row()? {
        for property in 0..rows.properties() {
            if let Shape::Scalar(_) = rows.shape(property) {
                rows.scalar(property)?;
            } else if Some(property) == place {
                read(rows, property)?;
            } else {
                rows.list(property, |_, _| Ok(()))?;
            }
        }
        rows.end_row()?;
    }
    Ok(())
}

fn vertex_of(place: &Place, value: Value, vertices: u64) -> Result<u32> {
    let vertex = value.as_whole().filter(|&v| v >= 0 && (v as u64) < vertices);
    vertex.map(|v| v as u32).ok_or_else(|| stray(place, &value.to_string(), vertices))
}

fn stray(place: &Place, found: &str, vertices: u64) -> Error {
    place.fault(
        format!("vertex {found} is not there; the file has {vertices} vertices, numbered from 0"),
        "check the numbers of this face; if they look like chance, a count or type in the header \
         is wrong",
    )
}

#[cfg(test)]
mod tests;
