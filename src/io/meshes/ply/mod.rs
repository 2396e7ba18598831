//! Stanford PLY, as text and as binary of either byte order: the vertices' x, y, z and the faces,
//! whatever else the file holds, and whatever follows it.
//!
//! The header says what each row of each element holds; rows are read one by one, so that nothing
//! but the mesh is held. Counts are believed only as far as the file is long enough for them.

mod header;
mod rows;
pub(super) mod writer;

use glam::DVec3;

use super::parts::{CUT, Parts, thin_face, too_many};
use super::source::{Source, not_finite, unmarked};
use crate::mesh::Mesh;
use crate::{Error, Result};
use header::{Element, Encoding, Header, Shape};
use rows::Rows;

/// Whether a file begins as PLY does.
pub(super) fn is_ply(head: &[u8]) -> bool {
    let rest = unmarked(head).strip_prefix(b"ply");
    rest.is_some_and(|rest| rest.first().is_none_or(u8::is_ascii_whitespace))
}

/// Reads the content of a PLY file.
///
/// # Errors
/// [`Error::Input`] when the header cannot be used, the file is shorter than its header says, or a
/// vertex or face is none.
pub(super) fn parse(source: &mut Source) -> Result<Mesh> {
    let header = Header::read(source)?;
    let places = Places::of(source, &header)?;
    check_length(source, &header)?;
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
        let element = |name: &str| header.elements.iter().find(|e| e.name == name);
        let missing = |name: &str| {
            let help = "a mesh needs both, as in `element vertex 8` and `element face 12`; export \
                        it with its faces";
            source.fault(format!("the header has no element {name}"), help)
        };
        let vertices = element("vertex").ok_or_else(|| missing("vertex"))?;
        let (faces, strips) = (element("face"), element(STRIPS));
        if faces.or(strips).is_none() {
            return Err(missing("face"));
        }
        let coordinate = |name: &str| {
            let found = vertices.properties.iter().position(|p| p.name == name && p.is_scalar());
            found.ok_or_else(|| {
                let help = format!("declare it, as in `property double {name}`");
                source.fault_at(vertices.line, format!("vertices have no property {name}"), help)
            })
        };
        let list = |element: &Element| {
            let found = element.properties.iter().position(|p| {
                ["vertex_indices", "vertex_index"].contains(&p.name.as_str())
                    && p.is_list_of_whole()
            });
            found.ok_or_else(|| {
                let help = "declare it, as in `property list uchar int vertex_indices`";
                let message = format!("{} have no list of vertices", element.plural());
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
        let coordinates = [coordinate("x")?, coordinate("y")?, coordinate("z")?];
        Ok(Self { vertices: vertices.count, coordinates, corners, strips })
    }
}

/// Rejects counts that the file is too short for, before anything is allocated by them.
fn check_length(source: &Source, header: &Header) -> Result<()> {
    let mut left = source.left();
    for element in &header.elements {
        let least = element.least_bytes(header.encoding);
        let needed = least.checked_mul(element.count);
        left = needed.and_then(|needed| left.checked_sub(needed)).ok_or_else(|| {
            let message = format!(
                "the header announces {} rows of element {}, of {least} bytes each at least, but \
                 only {left} bytes are left for them",
                element.count, element.name
            );
            let help = "the file is cut short or its header is wrong; export it again";
            source.fault_at(element.line, message, help)
        })?;
    }
    Ok(())
}

fn read_vertices(rows: &mut Rows, places: [usize; 3], parts: &mut Parts) -> Result<()> {
    // The file is long enough for its counts: a row takes an eighth of this at least.
    parts.positions.reserve_exact(rows.count() as usize);
    while rows.next_row()? {
        let mut position = DVec3::ZERO;
        for property in 0..rows.properties() {
            if let Shape::List { .. } = rows.shape(property) {
                rows.list(property, |_, _| Ok(()))?;
                continue;
            }
            let value = rows.scalar(property)?;
            for (axis, &place) in places.iter().enumerate() {
                if place == property {
                    position[axis] = value.as_f64();
                }
            }
        }
        rows.end_row()?;
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

fn vertex_of(place: &rows::Place, value: rows::Value, vertices: u64) -> Result<u32> {
    let vertex = value.as_whole().filter(|&v| v >= 0 && (v as u64) < vertices);
    vertex.map(|v| v as u32).ok_or_else(|| stray(place, &value.to_string(), vertices))
}

fn stray(place: &rows::Place, found: &str, vertices: u64) -> Error {
    place.fault(
        format!("vertex {found} is not there; the file has {vertices} vertices, numbered from 0"),
        "check the numbers of this face; if they look like chance, a count or type in the header \
         is wrong",
    )
}

impl Element {
    /// Returns what its rows are called.
    fn plural(&self) -> &'static str {
        if self.name == STRIPS { STRIPS } else { "faces" }
    }

    /// Returns the bytes that a row takes at least.
    fn least_bytes(&self, encoding: Encoding) -> u64 {
        let properties = self.properties.iter();
        match encoding {
            // A digit and what parts it from the next.
            Encoding::Text if self.properties.is_empty() => 0,
            Encoding::Text => 2 * self.properties.len() as u64 - 1,
            _ => properties.map(|p| p.shape.least_bytes()).sum(),
        }
    }
}

#[cfg(test)]
mod tests;
