//! Writes PLY files in little-endian binary, of whatever elements.

use std::fmt::Write;

use crate::io::output::SOFTWARE;

/// Describes an element of a file.
pub(in crate::io::meshes) struct Element<'a> {
    pub(in crate::io::meshes) name: &'static str,
    pub(in crate::io::meshes) count: usize,
    /// The type and the name of each property.
    pub(in crate::io::meshes) properties: Vec<[&'a str; 2]>,
    /// Adds the bytes of the row of this number.
    pub(in crate::io::meshes) row: &'a dyn Fn(usize, &mut Vec<u8>),
}

pub(in crate::io::meshes) const POSITION: [[&str; 2]; 3] =
    [["double", "x"], ["double", "y"], ["double", "z"]];
pub(in crate::io::meshes) const COLOUR: [[&str; 2]; 3] =
    [["uchar", "red"], ["uchar", "green"], ["uchar", "blue"]];
/// The corners of a triangle, which [`put_triangle`] writes.
pub(in crate::io::meshes) const CORNERS: [&str; 2] = [LIST, "vertex_indices"];
const LIST: &str = "list uchar uint";

/// Returns the bytes of a file; the comment is a line or empty.
pub(in crate::io::meshes) fn encode(comment: &str, elements: &[Element]) -> Vec<u8> {
    let mut text = format!("ply\nformat binary_little_endian 1.0\ncomment {SOFTWARE}\n");
    // Writing into a String cannot fail.
    if !comment.is_empty() {
        let _ = writeln!(text, "comment {comment}");
    }
    let mut size = 0;
    for element in elements {
        let _ = writeln!(text, "element {} {}", element.name, element.count);
        for [kind, name] in &element.properties {
            let _ = writeln!(text, "property {kind} {name}");
            size += element.count * width(kind);
        }
    }
    text += "end_header\n";
    let mut bytes = text.into_bytes();
    bytes.reserve_exact(size);
    for element in elements {
        (0..element.count).for_each(|i| (element.row)(i, &mut bytes));
    }
    bytes
}

/// Returns how many bytes a property takes, a list as one of a triangle.
fn width(kind: &str) -> usize {
    match kind {
        "double" => 8,
        "float" => 4,
        LIST => 13,
        _ => 1,
    }
}

/// Adds a list of three corners.
pub(in crate::io::meshes) fn put_triangle(triangle: [u32; 3], bytes: &mut Vec<u8>) {
    bytes.push(3);
    bytes.extend(triangle.iter().flat_map(|v| v.to_le_bytes()));
}
