//! The Object File Format as text: OFF and its variants whose vertices carry normals, colours or
//! texture coordinates as well.
//!
//! Vertices and faces stand one a line; what follows the coordinates of a vertex or the corners of
//! a face is passed over.

use glam::DVec3;

use super::parts::{Fan, Parts, thin_face, too_many};
use super::source::{Source, not_finite, number, shown};
use crate::mesh::Mesh;
use crate::{Error, Result};

/// Whether the first word of a file is that of the format, be it a variant that cannot be read.
pub(super) fn is_off(head: &[u8]) -> bool {
    let mut lines = head.split(|&b| b == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.find(|l| !l.is_empty() && l[0] != b'#').unwrap_or(b"");
    let word = first.split(u8::is_ascii_whitespace).next().unwrap_or(b"");
    is_keyword(word)
}

fn is_keyword(word: &[u8]) -> bool {
    let variant = word.strip_suffix(b"OFF");
    variant.is_some_and(|v| v.len() <= 5 && v.iter().all(|b| b"STCN4n".contains(b)))
}

/// Reads the content of an OFF file.
pub(super) fn parse(source: &mut Source) -> Result<Mesh> {
    let [vertices, faces] = counts(source)?;
    check_length(source, vertices, faces)?;
    let mut parts = Parts::default();
    // The file is long enough for its counts: no line takes less than a fifth of what it becomes.
    parts.positions.reserve_exact(vertices as usize);
    for vertex in 0..vertices {
        next(source, vertex, vertices, "vertices")?;
        let position = position(source)?;
        if !position.is_finite() {
            let (message, help) = not_finite(vertex as usize, position);
            return Err(source.fault_here(message, help));
        }
        parts.vertex(source, position)?;
    }
    parts.triangles.reserve_exact(faces as usize);
    for number in 0..faces {
        next(source, number, faces, "faces")?;
        face(source, vertices, &mut parts)?;
    }
    if source.next_telling_line()? {
        let help = "a count in the header is too small; export the file again";
        return Err(source.fault_here("this follows the last face that the header announces", help));
    }
    parts.finish(source)
}

/// Reads the keyword, which may be missing, and the numbers of vertices and faces, on its line or
/// the next.
fn counts(source: &mut Source) -> Result<[u64; 2]> {
    let help = "an OFF file begins with `OFF` and the numbers of vertices, faces and edges, as in \
                `8 12 18`";
    if !source.next_telling_line()? {
        return Err(source.fault("no vertices and no faces", help));
    }
    let keyword = source.words().next().filter(|w| is_keyword(w)).map(<[u8]>::to_vec);
    if let Some(word) = keyword {
        if word.contains(&b'4') || word.contains(&b'n') {
            let message = format!("`{}` has vertices of four or n coordinates", shown(&word));
            return Err(source.fault_here(message, "export the surface with three coordinates"));
        }
        if source.words().nth(1).is_some_and(|w| w.eq_ignore_ascii_case(b"binary")) {
            let help = "export it as text, or as PLY";
            return Err(source.fault_here("this is a binary OFF file, which is not read", help));
        }
        let blanks = source.text().len() - source.text().trim_ascii_start().len();
        source.text_mut().drain(..blanks + word.len());
        if source.words().next().is_none() && !source.next_telling_line()? {
            return Err(source.fault("the file ends before its counts", help));
        }
    }
    let numbers: Vec<Option<u64>> = source.words().take(4).map(number).collect();
    match numbers[..] {
        [Some(vertices), Some(faces)] | [Some(vertices), Some(faces), Some(_)] => {
            Ok([vertices, faces])
        }
        _ => Err(source.fault_here(format!("`{}` are no counts", shown(source.text())), help)),
    }
}

/// Rejects counts that the file is too short for, before anything is allocated by them.
fn check_length(source: &Source, vertices: u64, faces: u64) -> Result<()> {
    if vertices > super::parts::MOST_VERTICES {
        return Err(source.fault_here(too_many(vertices), "divide the file"));
    }
    // `0 0 0` and `3 0 1 2`, the last without its line end.
    let needed = vertices.saturating_mul(6).saturating_add(faces.saturating_mul(8));
    if needed > source.left().saturating_add(1) {
        let message = format!(
            "the header announces {vertices} vertices and {faces} faces, which take {needed} \
             bytes at least, but only {} are left for them",
            source.left()
        );
        let help = "the file is cut short or its header is wrong; export it again";
        return Err(source.fault_here(message, help));
    }
    Ok(())
}

fn next(source: &mut Source, row: u64, count: u64, what: &str) -> Result<()> {
    if source.next_telling_line()? {
        return Ok(());
    }
    let help = "the file is cut short or its header is wrong; export it again";
    Err(source.fault(format!("the file ends after {row} of {count} {what}"), help))
}

fn position(source: &Source) -> Result<DVec3> {
    let mut words = source.words();
    let mut coordinate = || {
        let help = "write three numbers, as in `0.1 0.2 0.3`";
        match words.next() {
            Some(word) => number(word).ok_or_else(|| {
                source.fault_here(format!("`{}` is not a number", shown(word)), help)
            }),
            None => Err(source.fault_here("a vertex with too few coordinates", help)),
        }
    };
    Ok(DVec3::new(coordinate()?, coordinate()?, coordinate()?))
}

fn face(source: &Source, vertices: u64, parts: &mut Parts) -> Result<()> {
    let mut words = source.words();
    let found = words.next().unwrap_or(b"");
    let length = number::<u64>(found).ok_or_else(|| {
        let help = "a face begins with how many corners follow, as in `3 0 1 2`";
        source.fault_here(format!("`{}` is no number of corners", shown(found)), help)
    })?;
    let mut fan = Fan::default();
    for _ in 0..length {
        let Some(word) = words.next() else {
            let help = "write all corners of a face on one line";
            let message = format!("{} of {length} corners", fan.corners());
            return Err(source.fault_here(message, help));
        };
        let vertex = number::<u64>(word).filter(|&v| v < vertices);
        let vertex = vertex.ok_or_else(|| stray(source, word, vertices))?;
        fan.corner(vertex as u32, &mut parts.triangles);
    }
    if fan.corners() < 3 {
        let help = "give a face at least three vertices, as in `3 0 1 2`";
        return Err(source.fault_here(thin_face(fan.corners()), help));
    }
    Ok(())
}

fn stray(source: &Source, word: &[u8], vertices: u64) -> Error {
    let message = format!(
        "vertex {} is not there; the file has {vertices} vertices, numbered from 0",
        shown(word)
    );
    source.fault_here(message, "check the numbers of this face")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const PYRAMID: &str = "OFF # a pyramid\n# of five vertices\n5 5 8\n0 0 0\n1 0 0\n1 1 0\n\
                           0 1 0\n\n0.5 0.5 1\n4 3 2 1 0\n3 0 1 4 255 0 0\n3 1 2 4\n\
                           3 2 3 4 # the last but one\n3 3 0 4\n";

    fn read(text: &str) -> Result<Mesh> {
        parse(&mut Source::of_bytes(Path::new("test.off"), text.as_bytes()))
    }

    fn error_of(text: &str) -> String {
        read(text).unwrap_err().to_string()
    }

    #[test]
    fn empty_files_say_what_is_missing() {
        assert!(error_of("").starts_with("test.off: no vertices and no faces"));
        assert!(error_of("OFF\n").starts_with("test.off: the file ends before its counts"));
        assert!(error_of("OFF 0 0 0").starts_with("test.off: no vertices and no faces"));
    }

    #[test]
    fn polygons_colours_and_comments_are_read() {
        let mesh = read(PYRAMID).expect("readable");
        assert_eq!((mesh.positions().len(), mesh.triangles().len()), (5, 6));
        assert!((mesh.volume() - 1.0 / 3.0).abs() <= 1e-15);
        assert_eq!(read(&PYRAMID.replace("OFF # a pyramid\n", "")).expect("no keyword"), mesh);
        assert_eq!(
            read(&PYRAMID.replace("OFF # a pyramid\n# of five vertices\n5 5 8", "OFF 5 5"))
                .expect("one line"),
            mesh
        );
        let coloured =
            PYRAMID.replace("OFF #", "CNOFF #").replace("0 0 0\n", "0 0 0 1 0 0 0.5 0.5 0.5 1\n");
        assert_eq!(read(&coloured).expect("colours"), mesh);
    }

    #[test]
    fn faults_name_the_line() {
        for (from, to, message) in [
            ("5 5 8", "5 five", "3: `5 five` are no counts"),
            ("5 5 8", "4000000000 5 8", "3: the header announces 4000000000 vertices"),
            ("5 5 8", "5000000000 5 8", "3: 5000000000 vertices, more than"),
            // The first face is taken for a vertex, and so a face is missing.
            ("5 5 8", "6 5 8", " the file ends after 4 of 5 faces"),
            ("5 5 8", "5 4 8", "14: this follows the last face"),
            ("5 5 8", "5 6 8", " the file ends after 5 of 6 faces"),
            ("1 1 0", "1 one 0", "6: `one` is not a number"),
            ("1 1 0", "1 inf 0", "6: vertex 2 (from 0) is at [1, inf, 0]"),
            ("1 1 0", "1 1", "6: a vertex with too few coordinates"),
            ("3 3 0 4", "3 3 0 5", "14: vertex 5 is not there; the file has 5 vertices"),
            ("3 3 0 4", "3 3 0 -1", "14: vertex -1 is not there"),
            ("3 3 0 4", "3 3 0", "14: 2 of 3 corners"),
            ("3 3 0 4", "2 3 0", "14: a face of 2 vertices"),
            ("3 3 0 4", "x 3 0", "14: `x` is no number of corners"),
            ("OFF", "4OFF", "1: `4OFF` has vertices of four"),
            ("OFF #", "OFF BINARY #", "1: this is a binary OFF file"),
        ] {
            let found = error_of(&PYRAMID.replacen(from, to, 1));
            assert!(found.starts_with(&format!("test.off:{message}")), "{to}: {found}");
            assert!(found.contains("\n  help: "), "{found}");
        }
    }
}
