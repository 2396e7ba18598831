//! Stanford PLY, as text and as binary of either byte order: the vertices' x, y, z and the faces,
//! whatever else the file holds.
//!
//! The header says what each row of each element holds; rows are read one by one, so that nothing
//! but the mesh is held. Counts are believed only as far as the file is long enough for them.

mod header;
mod rows;
pub(super) mod writer;

use glam::DVec3;

use super::parts::{Fan, Parts, thin_face, too_many};
use super::source::{Source, not_finite};
use crate::mesh::Mesh;
use crate::{Error, Result};
use header::{Element, Encoding, Header, Shape};
use rows::Rows;

/// Reads the content of a PLY file.
///
/// # Errors
/// [`Error::Input`] when the header cannot be used, the file is shorter or longer than its header
/// says, or a vertex or face is none.
pub(super) fn parse(source: &mut Source) -> Result<Mesh> {
    let header = Header::read(source)?;
    let places = Places::of(source, &header)?;
    check_length(source, &header)?;
    let mut parts = Parts::default();
    for element in &header.elements {
        let mut rows = Rows::new(source, header.encoding, element);
        match element.name.as_str() {
            "vertex" => read_vertices(&mut rows, places.coordinates, &mut parts)?,
            "face" => read_faces(&mut rows, places.corners, places.vertices, &mut parts)?,
            _ => rows.pass_over()?,
        }
    }
    check_end(source, header.encoding)?;
    parts.finish(source)
}

/// Where in the rows the things stand that make a mesh.
struct Places {
    vertices: u64,
    /// Of x, y and z in a vertex.
    coordinates: [usize; 3],
    /// Of the list of vertices in a face.
    corners: usize,
}

impl Places {
    fn of(source: &Source, header: &Header) -> Result<Self> {
        let element = |name: &str| {
            header.elements.iter().find(|e| e.name == name).ok_or_else(|| {
                let help = "a mesh needs both, as in `element vertex 8` and `element face 12`; \
                            export it with its faces";
                source.fault(format!("the header has no element {name}"), help)
            })
        };
        let (vertices, faces) = (element("vertex")?, element("face")?);
        let coordinate = |name: &str| {
            let found = vertices.properties.iter().position(|p| p.name == name && p.is_scalar());
            found.ok_or_else(|| {
                let help = format!("declare it, as in `property double {name}`");
                source.fault_at(vertices.line, format!("vertices have no property {name}"), help)
            })
        };
        let corners = faces.properties.iter().position(|p| {
            ["vertex_indices", "vertex_index"].contains(&p.name.as_str()) && p.is_list_of_whole()
        });
        let corners = corners.ok_or_else(|| {
            let help = "declare it, as in `property list uchar int vertex_indices`";
            source.fault_at(faces.line, "faces have no list of vertices", help)
        })?;
        if vertices.count > super::parts::MOST_VERTICES {
            return Err(source.fault_at(
                vertices.line,
                too_many(vertices.count),
                "divide the file",
            ));
        }
        let coordinates = [coordinate("x")?, coordinate("y")?, coordinate("z")?];
        Ok(Self { vertices: vertices.count, coordinates, corners })
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

fn read_faces(rows: &mut Rows, place: usize, vertices: u64, parts: &mut Parts) -> Result<()> {
    let least = rows.element().least_bytes(rows.encoding()).max(1);
    parts.triangles.reserve_exact(rows.count().min(rows.source().left() / least) as usize);
    while rows.next_row()? {
        for property in 0..rows.properties() {
            if let Shape::Scalar(_) = rows.shape(property) {
                rows.scalar(property)?;
            } else if property == place {
                read_corners(rows, property, vertices, parts)?;
            } else {
                rows.list(property, |_, _| Ok(()))?;
            }
        }
        rows.end_row()?;
    }
    Ok(())
}

fn read_corners(rows: &mut Rows, property: usize, vertices: u64, parts: &mut Parts) -> Result<()> {
    let mut fan = Fan::default();
    rows.list(property, |place, value| {
        let vertex = value.as_whole().filter(|&v| v >= 0 && (v as u64) < vertices);
        let vertex = vertex.ok_or_else(|| stray(&place, &value.to_string(), vertices))?;
        fan.corner(vertex as u32, &mut parts.triangles);
        Ok(())
    })?;
    if fan.corners() < 3 {
        return Err(rows.fault(thin_face(fan.corners()), "give a face at least three vertices"));
    }
    Ok(())
}

fn stray(place: &rows::Place, found: &str, vertices: u64) -> Error {
    place.fault(
        format!("vertex {found} is not there; the file has {vertices} vertices, numbered from 0"),
        "check the numbers of this face; if they look like chance, a count or type in the header \
         is wrong",
    )
}

/// Rejects what follows the last row: the header is wrong about the counts.
fn check_end(source: &mut Source, encoding: Encoding) -> Result<()> {
    let help = "a count in the header is too small; export the file again";
    if encoding == Encoding::Text {
        if source.next_telling_line()? {
            let message = "this follows the last row that the header announces";
            return Err(source.fault_here(message, help));
        }
        return Ok(());
    }
    let left = source.left();
    // A last line end is what some programs write behind the bytes.
    if left > 2 || !source.ahead()?.iter().all(u8::is_ascii_whitespace) {
        let message = format!("{left} bytes follow the last row that the header announces");
        return Err(source.fault(message, help));
    }
    Ok(())
}

impl Element {
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
