//! Wavefront OBJ: the statements `v` and `f` of all objects and groups as one mesh.
//!
//! Read line by line, so that nothing but the mesh itself is held and a fault has a line. Crate
//! tobj, which splits a file at every object, group and material and numbers vertices anew, is what
//! this reader is tested against (tests/meshes.rs).

use std::path::Path;

use glam::DVec3;

use super::parts::{Fan, MOST_VERTICES, Parts, thin_face};
use super::source::{Source, number, shown, words};
use crate::mesh::Mesh;
use crate::{Error, Result};

/// Reads an OBJ file: its vertices in their own order, its polygons cut into fans. Objects and
/// groups are joined and share their vertices; normals, texture coordinates, materials, points and
/// lines are passed over.
///
/// # Errors
/// [`Error::Io`] when the file cannot be read; [`Error::Input`], with the line where there is one,
/// when it is a folder, has no vertices or no faces, or has a statement that cannot be used: text
/// that is not UTF-8, a coordinate that is no finite number, a face of fewer than three vertices, a
/// number of a vertex that is not there.
pub fn read_obj(path: &Path) -> Result<Mesh> {
    parse(&mut Source::open(path)?)
}

/// Reads the content of an OBJ file.
pub(super) fn parse(source: &mut Source) -> Result<Mesh> {
    let mut reader = Reader::default();
    while source.next_line()? {
        if source.line() == 1 && source.text().starts_with(b"\xef\xbb\xbf") {
            source.text_mut().drain(..3);
        }
        let more = join_continued(source)?;
        match source.words().next() {
            Some(b"v") => reader.vertex(source)?,
            Some(b"f" | b"fo") => reader.face(source)?,
            _ => {}
        }
        source.count_lines(more);
    }
    reader.finish(source)
}

/// Joins the lines that a backslash at their end continues, and gives how many were added.
fn join_continued(source: &mut Source) -> Result<usize> {
    let mut more = 0;
    while source.text().last() == Some(&b'\\') {
        source.text_mut().pop();
        source.text_mut().push(b' ');
        if !source.append_line()? {
            break;
        }
        more += 1;
    }
    Ok(more)
}

/// A corner that names a vertex of which the file had not told yet.
struct Forward {
    number: i64,
    line: usize,
    /// How many vertices stand before it.
    before: usize,
}

#[derive(Default)]
struct Reader {
    parts: Parts,
    /// The corners that name a vertex beyond all seen or named before, in the order of the file.
    forward: Vec<Forward>,
}

/// What a file needs at least.
const ENOUGH: &str = "an OBJ file has lines such as `v 0.1 0.2 0.3` and `f 1 2 3`; check that \
                      this is the right file";
/// How a vertex is written.
const VERTEX: &str = "write three numbers, as in `v 0.1 0.2 0.3`";

impl Reader {
    fn vertex(&mut self, source: &Source) -> Result<()> {
        // Three coordinates, then a weight where it is all that follows, or colours, which are
        // passed over.
        let mut values = [0.0, 0.0, 0.0, 1.0];
        let count = words(source.text()).count() - 1;
        if count < 3 {
            return Err(source.fault_here(format!("a vertex of {count} coordinates"), VERTEX));
        }
        let known = if count == 4 { 4 } else { 3 };
        for (value, word) in values[..known].iter_mut().zip(source.words().skip(1)) {
            *value = number(word).ok_or_else(|| no_number(source, word))?;
        }
        let [x, y, z, weight] = values;
        if weight == 0.0 {
            let message = "a vertex of weight 0, which is at infinity";
            return Err(source.fault_here(message, "leave out the fourth number"));
        }
        let position = if known == 4 { DVec3::new(x, y, z) / weight } else { DVec3::new(x, y, z) };
        if !position.is_finite() {
            let vertex = self.parts.positions.len() + 1;
            let message = format!("vertex {vertex} is at {position}, which is not finite");
            let help = "write three ordinary numbers; export again if a program wrote this";
            return Err(source.fault_here(message, help));
        }
        self.parts.vertex(source, position)
    }

    fn face(&mut self, source: &Source) -> Result<()> {
        let mut fan = Fan::default();
        for word in source.words().skip(1) {
            let vertex = self.corner(source, word)?;
            fan.corner(vertex, &mut self.parts.triangles);
        }
        if fan.corners() < 3 {
            let help = "give a face at least three vertices, as in `f 1 2 3`, on one line";
            return Err(source.fault_here(thin_face(fan.corners()), help));
        }
        Ok(())
    }

    /// Returns the vertex, from 0, that a corner such as `7`, `7/1`, `7//2` or `-1/1/2` names.
    fn corner(&mut self, source: &Source, word: &[u8]) -> Result<u32> {
        let before = self.parts.positions.len();
        let Some(named) = vertex_of_corner(word) else {
            let help = "write a corner as the number of a vertex: `7`, `7/1`, `7//2` or `7/1/2`";
            return Err(readable(source, word).err().unwrap_or_else(|| {
                source.fault_here(format!("`{}` is not a corner of a face", shown(word)), help)
            }));
        };
        // A vertex count never exceeds 32 bits, an index from the end fits in i64.
        let index = if named < 0 { named.saturating_add(before as i64) } else { named - 1 };
        if index < 0 {
            let message =
                format!("vertex {named} is not there; {before} vertices stand before this line");
            let help = format!("number vertices from 1, or from -1 back to -{before} here");
            return Err(source.fault_here(message, help));
        }
        let beyond = self.forward.last().map_or(0, |f| f.number).max(before as i64);
        if named > beyond {
            self.forward.push(Forward { number: named, line: source.line(), before });
        }
        // What does not fit is beyond every count: it is refused at the end.
        Ok(u32::try_from(index).unwrap_or(u32::MAX))
    }

    fn finish(self, source: &Source) -> Result<Mesh> {
        let count = self.parts.positions.len();
        if let Some(stray) = self.forward.iter().find(|f| f.number > count as i64) {
            let message =
                format!("vertex {} is not there; the file has {count} vertices", stray.number);
            let help = format!(
                "number vertices from 1 to {count}, or from -1 back to -{} here",
                stray.before
            );
            return Err(source.fault_at(stray.line, message, help));
        }
        if count == 0 && self.parts.triangles.is_empty() {
            return Err(source.fault("no vertices and no faces", ENOUGH));
        }
        debug_assert!(count as u64 <= MOST_VERTICES);
        self.parts.finish(source)
    }
}

/// Reads `7`, `7/1`, `7//2` or `7/1/2`: the first number.
fn vertex_of_corner(word: &[u8]) -> Option<i64> {
    let mut numbers = word.split(|&b| b == b'/');
    let vertex = number(numbers.next()?)?;
    let mut others = 0;
    for other in numbers {
        others += 1;
        if others > 2 || !(other.is_empty() || number::<i64>(other).is_some()) {
            return None;
        }
    }
    Some(vertex)
}

fn no_number(source: &Source, word: &[u8]) -> Error {
    let message = || source.fault_here(format!("`{}` is not a number", shown(word)), VERTEX);
    readable(source, word).err().unwrap_or_else(message)
}

/// Rejects what is no text.
fn readable(source: &Source, word: &[u8]) -> Result<()> {
    std::str::from_utf8(word).map(drop).map_err(|e| {
        let help = "save the file as UTF-8 text; a binary file is not OBJ, whatever its name";
        let message = format!("byte {:#04x} is not UTF-8 text", word[e.valid_up_to()]);
        source.fault_here(message, help)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CUBE: &str = "# a cube of two objects\nmtllib none.mtl\no lower\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n\
        v 0 0 1 0.5 0.5 0.5\nv 1 0 1\nv 1 1 1\nv 0 1 1\nvt 0 0\nvn 0 0 1\nusemtl red\nf 4/1/1 3/1/1 2/1/1 1/1/1\n\
        f 1 2 6 5 # a side\nf 2//1 3//1 7//1 6//1\no upper\ng top\nf -1 -5 -8 -4\nf 3 4 8 7\r\ns off\nl 1 2 3\np 1\n\
        usemtl blue\nf 5/1 6/1 7/1 8/1\n";

    fn read(text: &str) -> Result<Mesh> {
        parse(&mut Source::of_bytes(Path::new("test.obj"), text.as_bytes()))
    }

    fn error_of(text: &str) -> String {
        read(text).unwrap_err().to_string()
    }

    #[test]
    fn empty_files_say_what_is_missing() {
        for text in ["", "\n\n", "# nothing", "o name\nvn 0 0 1"] {
            assert!(error_of(text).starts_with("test.obj: no vertices and no faces\n  help: "));
        }
        assert!(error_of("v 0 0 0\nv 1 0 0\nl 1 2").starts_with("test.obj: no faces"));
        assert!(error_of("f 1 2 3").starts_with("test.obj:1: vertex 1 is not there"));
    }

    #[test]
    fn errors_name_the_line() {
        let with =
            |line: &str| error_of(&format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n\n{line}\nf 1 2 3\n"));
        for (line, message) in [
            ("v 0 x 0", "`x` is not a number"),
            ("v 0 0", "a vertex of 2 coordinates"),
            ("v 0 0 0 0", "a vertex of weight 0, which is at infinity"),
            ("v 0 nan 0", "vertex 4 is at [0, NaN, 0], which is not finite"),
            ("v 1e999 0 0", "vertex 4 is at [inf, 0, 0], which is not finite"),
            ("f 1 2 9", "vertex 9 is not there; the file has 3 vertices"),
            ("f 1 2 0", "vertex 0 is not there"),
            ("f 1 2 -4", "vertex -4 is not there"),
            ("f 1 2 99999999999999999999", "`99999999999999999999` is not a corner"),
            ("f 1 2 -9223372036854775808", "vertex -9223372036854775808 is not there"),
            ("f 1 2 9223372036854775807", "vertex 9223372036854775807 is not there"),
            ("f 1 2", "a face of 2 vertices"),
            ("f", "a face of 0 vertices"),
            ("f 1 2 /3", "`/3` is not a corner of a face"),
            ("f 1 2 3/a", "`3/a` is not a corner of a face"),
            ("f 1 2 3/1/1/1", "`3/1/1/1` is not a corner of a face"),
        ] {
            let found = with(line);
            assert!(found.starts_with(&format!("test.obj:5: {message}")), "{line}: {found}");
            assert!(found.contains("\n  help: "), "{found}");
        }
        assert!(error_of("v 0 0 0\nv 1 0 0\nf 1 2 1\nf 1 2 3").starts_with("test.obj:4: vertex 3"));
    }

    #[test]
    fn text_that_is_not_utf8_is_located() {
        let mut source = Source::of_bytes(Path::new("test.obj"), b"# a\nv 0 0 \xff\n");
        let error = parse(&mut source).unwrap_err().to_string();
        assert!(error.starts_with("test.obj:2: byte 0xff is not UTF-8 text"), "{error}");
    }

    #[test]
    fn objects_are_joined_and_vertices_keep_their_numbers() {
        let cube = read(CUBE).expect("readable");
        assert_eq!((cube.positions().len(), cube.triangles().len()), (8, 12));
        assert_eq!(cube.positions()[4], DVec3::Z);
        assert_eq!(cube.triangles()[..3], [[3, 2, 1], [3, 1, 0], [0, 1, 5]]);
        assert!(crate::mesh::MeshReport::of(&cube).require_closed().is_ok());
        assert!((cube.volume() - 1.0).abs() <= 1e-15);
        assert_eq!(read(&format!("\u{feff}{CUBE}")).expect("readable"), cube);
    }

    #[test]
    fn numbers_count_from_either_end() {
        let mesh = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\nf -4 -3 -2").expect("readable");
        assert_eq!((mesh.positions().len(), mesh.triangles()), (4, &[[0, 1, 2]][..]));
        assert!(error_of("v 0 0 0\nv 1 0 0\nf 1 2 2").starts_with("test.obj: only 2 vertices"));
    }

    #[test]
    fn lines_are_continued_by_a_backslash_and_counted_on() {
        let text = "v 0 0 0\nv 1 \\\n 0 0\r\nv 0 1 0\nf 1 \\\r\n2 \\\n3\n";
        assert_eq!(read(text).expect("readable").triangles(), [[0, 1, 2]]);
        assert!(error_of(&format!("{text}f 1 2 x\n")).starts_with("test.obj:8: `x`"));
    }

    #[test]
    fn faces_may_stand_before_their_vertices_and_weights_divide() {
        let mesh = read("f 1 2 3\nv 0 0 0\nv 2 0 0 2\nv 0 1 0 .5 .5 .5\n").expect("readable");
        assert_eq!(mesh.positions(), [DVec3::ZERO, DVec3::X, DVec3::Y]);
        let error = error_of("f 1 2 3\nf 2 4 5\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
        assert!(error.starts_with("test.obj:2: vertex 4 is not there; the file has 3"), "{error}");
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: prop::test_runner::RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn no_bytes_make_it_panic(
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4_u8), 0..12)
        ) {
            let mut bytes = CUBE.as_bytes().to_vec();
            let telling = b" -/.0199eE#\n\\vfnlinf\xff";
            for (place, byte, what) in changes {
                let i = place.index(bytes.len());
                match what {
                    0 => bytes[i] = byte,
                    1 => bytes[i] = telling[usize::from(byte) % telling.len()],
                    2 => bytes.insert(i, telling[usize::from(byte) % telling.len()]),
                    _ => drop(bytes.remove(i)),
                }
            }
            match parse(&mut Source::of_bytes(Path::new("test.obj"), &bytes)) {
                Ok(mesh) => prop_assert!(mesh.positions().iter().all(|p| p.is_finite())),
                Err(error) => prop_assert!(error.to_string().starts_with("test.obj")),
            }
        }

        #[test]
        fn random_bytes_are_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            prop_assert!(parse(&mut Source::of_bytes(Path::new("test.obj"), &bytes)).is_err());
        }
    }
}
