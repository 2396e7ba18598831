//! Wavefront OBJ: the statements `v` and `f` of all objects and groups as one mesh.
//!
//! Crate tobj parses them. It names neither line nor word of a fault, accepts coordinates that are
//! not finite, faces of two corners and vertex 0, knows neither continued lines nor comments behind
//! a statement, makes a mesh of each object and numbers vertices by their first use. So each
//! statement is checked before it is passed on, and a polygon of all vertices in order comes first.

use std::io::Read;
use std::iter;
use std::path::Path;

use glam::DVec3;

use super::parts::{CUT, MOST_VERTICES, Parts, thin_face, too_many};
use crate::error::shown_path;
use crate::io::source::{Source, number, shown};
use crate::mesh::Mesh;
use crate::{Error, Result, memory};

/// Reads an OBJ file: its vertices in their own order, its polygons cut into triangles. Objects and
/// groups are joined and share their vertices; normals, texture coordinates, materials, points,
/// lines and faces of two vertices are passed over.
///
/// # Errors
/// [`Error::Io`] when the file cannot be read; [`Error::Input`], with the line where there is one,
/// when it is a folder, has no vertices or no faces, or has a statement that cannot be used: text
/// that is not UTF-8, a coordinate that is no finite number, a face of fewer than two vertices, a
/// number of a vertex that is not there.
pub fn read_obj(path: &Path) -> Result<Mesh> {
    parse(&mut Source::open(path)?)
}

/// Reads the content of an OBJ file.
pub(super) fn parse(source: &mut Source) -> Result<Mesh> {
    let mut statements = Statements::default();
    while source.next_line()? {
        let mut more = 0;
        while source.continues()? {
            more += 1;
        }
        match source.words().next() {
            Some(b"v") => statements.vertex(source)?,
            Some(b"f" | b"fo") => statements.face(source)?,
            _ => {}
        }
        source.count_lines(more);
    }
    statements.finish(source)
}

/// Whether a file that begins with this word is OBJ.
pub(super) fn is_statement(word: &[u8]) -> bool {
    let known: [&[u8]; 9] = [b"v", b"vn", b"vt", b"f", b"o", b"g", b"s", b"mtllib", b"usemtl"];
    known.contains(&word)
}

/// A corner that names a vertex of which the file had not told yet.
struct Forward {
    number: i64,
    line: usize,
    /// How many vertices stand before it.
    before: i64,
}

/// Holds what is passed on to tobj.
#[derive(Default)]
struct Statements {
    text: Vec<u8>,
    vertices: usize,
    /// The corners that name a vertex beyond all seen or named before, in the order of the file.
    forward: Vec<Forward>,
}

/// The memory that tobj takes for each number at most: where capacities have just doubled.
const MAX_BYTES_PER_NUMBER: f64 = 100.0;
/// What a file needs at least.
const ENOUGH: &str = "an OBJ file has lines such as `v 0.1 0.2 0.3` and `f 1 2 3`; check that \
                      this is the right file";
/// How a vertex is written.
const VERTEX: &str = "write three numbers, as in `v 0.1 0.2 0.3`";
/// How a corner is written.
const CORNER: &str = "write a corner as the number of a vertex: `7`, `7/1`, `7//2` or `7/1/2`";

impl Statements {
    /// Writes a statement.
    fn pass(&mut self, keyword: u8, words: impl Iterator<Item = impl AsRef<[u8]>>) {
        self.text.push(keyword);
        for word in words {
            self.text.push(b' ');
            self.text.extend_from_slice(word.as_ref());
        }
        self.text.push(b'\n');
    }

    fn vertex(&mut self, source: &Source) -> Result<()> {
        // Three coordinates, then a weight where it is all that follows, or colours, which are
        // passed over.
        let mut values = [0.0, 0.0, 0.0, 1.0];
        let count = source.words().count() - 1;
        if count < 3 {
            return Err(source.fault_here(format!("a vertex of {count} coordinates"), VERTEX));
        }
        let known = if count == 4 { 4 } else { 3 };
        for (value, word) in values[..known].iter_mut().zip(source.words().skip(1)) {
            *value = number(word).ok_or_else(|| unusable(source, word, "a number", VERTEX))?;
        }
        let [x, y, z, weight] = values;
        if weight == 0.0 {
            let message = "a vertex of weight 0, which is at infinity";
            return Err(source.fault_here(message, "leave out the fourth number"));
        }
        let position = DVec3::new(x, y, z) / weight;
        self.vertices += 1;
        if !position.is_finite() {
            let message = format!("vertex {} is at {position}, which is not finite", self.vertices);
            let help = "write three ordinary numbers; export again if a program wrote this";
            return Err(source.fault_here(message, help));
        }
        if self.vertices as u64 > MOST_VERTICES {
            return Err(source.fault(too_many(MOST_VERTICES + 1), "divide the file"));
        }
        self.pass(b'v', source.words().skip(1).take(known));
        Ok(())
    }

    fn face(&mut self, source: &Source) -> Result<()> {
        let mut corners = 0;
        for word in source.words().skip(1) {
            self.corner(source, word)?;
            corners += 1;
        }
        if corners < 2 {
            let help = "give a face at least three vertices, as in `f 1 2 3`, on one line";
            return Err(source.fault_here(thin_face(corners), help));
        }
        self.pass(b'f', source.words().skip(1));
        Ok(())
    }

    /// Checks the vertex that a corner such as `7`, `7/1`, `7//2` or `-1/1/2` names.
    fn corner(&mut self, source: &Source, word: &[u8]) -> Result<()> {
        let named = vertex_of_corner(word)
            .ok_or_else(|| unusable(source, word, "a corner of a face", CORNER))?;
        let before = self.vertices as i64;
        if named == 0 || named < -before {
            let message =
                format!("vertex {named} is not there; {before} vertices stand before this line");
            let help = format!("number vertices from 1, or from -1 back to -{before} here");
            return Err(source.fault_here(message, help));
        }
        if named > self.forward.last().map_or(0, |f| f.number).max(before) {
            self.forward.push(Forward { number: named, line: source.line(), before });
        }
        Ok(())
    }

    fn finish(self, source: &mut Source) -> Result<Mesh> {
        let count = self.vertices;
        let stray = self.forward.iter().find(|f| f.number > count as i64);
        if let Some(&Forward { number, line, before }) = stray {
            let message = format!("vertex {number} is not there; the file has {count} vertices");
            let help =
                format!("number vertices from 1 to {count}, or from -1 back to -{before} here");
            return Err(source.fault_at(line, message, help));
        }
        if count == 0 {
            return Err(source.fault("no vertices and no faces", ENOUGH));
        }
        self.parts(source)?.finish(source)
    }

    /// Has tobj parse the statements, all vertices in their order first: a polygon of 1, 1, 1, 2, 3
    /// and so on.
    fn parts(mut self, source: &Source) -> Result<Parts> {
        let statements = std::mem::take(&mut self.text);
        self.pass(b'f', [1, 1].into_iter().chain(1..=self.vertices).map(|v| v.to_string()));
        let numbers = statements.split(|&byte| byte == b' ').count();
        let name = format!("parsing {}", shown_path(source.path()));
        memory::ask(numbers as f64 * MAX_BYTES_PER_NUMBER, name, |_| {
            "export it as PLY, which takes the memory of the mesh alone".to_owned()
        })?;
        let mut text = self.text.chain(&statements[..]);
        let no_materials = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
        let (models, _) =
            tobj::load_obj_buf(&mut text, &tobj::LoadOptions::default(), no_materials)
                .map_err(|e| source.fault(e.to_string(), ENOUGH))?;
        let mesh = models.into_iter().next().map(|model| model.mesh).unwrap_or_default();
        let positions = mesh.positions.as_chunks().0;
        let mut parts = Parts::of(positions.iter().map(|&p| DVec3::from_array(p)).collect());
        let mut corners = mesh.indices.get(2 + self.vertices..).unwrap_or_default();
        // None are listed where all are three.
        let arities = mesh.face_arities.iter().skip(1).map(|&n| n as usize);
        let triangles = if mesh.face_arities.is_empty() { corners.len() / 3 } else { 0 };
        // A face has two triangles fewer than corners.
        let count = corners.len().saturating_sub(2 * (arities.len() + triangles));
        parts.triangles.reserve_exact(count);
        for arity in arities.chain(iter::repeat_n(3, triangles)) {
            let (face, rest) = corners.split_at(arity.min(corners.len()));
            parts.polygon(face).map_err(|e| source.fault(e.to_string(), CUT))?;
            corners = rest;
        }
        Ok(parts)
    }
}

/// Reads `7`, `7/1`, `7//2` or `7/1/2`: the first number.
fn vertex_of_corner(word: &[u8]) -> Option<i64> {
    let mut numbers = word.split(|&b| b == b'/');
    let vertex = number(numbers.next()?)?;
    let is_other = |other: &[u8]| other.is_empty() || number::<i64>(other).is_some();
    (numbers.by_ref().take(2).all(is_other) && numbers.next().is_none()).then_some(vertex)
}

/// Rejects a word that is not what was expected, or no text.
fn unusable(source: &Source, word: &[u8], expected: &str, help: &str) -> Error {
    let Err(error) = std::str::from_utf8(word) else {
        return source.fault_here(format!("`{}` is not {expected}", shown(word)), help);
    };
    let help = "save the file as UTF-8 text; a binary file is not OBJ, whatever its name";
    let message = format!("byte {:#04x} is not UTF-8 text", word[error.valid_up_to()]);
    source.fault_here(message, help)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CUBE: &str = "# a cube of two objects\nmtllib none.mtl\no lower\nv 0 0 0\nv 1 0 0\n\
                        v 1 1 0\nv 0 1 0\nv 0 0 1 0.5 0.5 0.5\nv 1 0 1\nv 1 1 1\nv 0 1 1\nvt 0 0\n\
                        vn 0 0 1\nusemtl red\nf 4/1/1 3/1/1 2/1/1 1/1/1\nf 1 2 6 5 # a side\n\
                        f 2//1 3//1 7//1 6//1\no upper\ng top\nf -1 -5 -8 -4\nf 3 4 8 7\r\ns off\n\
                        l 1 2 3\np 1\nusemtl blue\nf 5/1 6/1 7/1 8/1\n";

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
            ("f 1", "a face of 1 vertex"),
            ("f", "a face of 0 vertices"),
            ("f 1 2 /3", "`/3` is not a corner of a face"),
            ("f 1 2 3/a", "`3/a` is not a corner of a face"),
            ("f 1 2 3/1/1/1", "`3/1/1/1` is not a corner of a face"),
            // As tobj would read otherwise.
            ("f 1 2 3/1/1/", "`3/1/1/` is not a corner of a face"),
            ("f 1 2\u{a0}3 1", "`2\u{a0}3` is not a corner of a face"),
            ("v 0 0\u{a0}0 1", "`0\u{a0}0` is not a number"),
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
        // Blanks may follow it, and a comment is not continued: `# C:\\models\\`.
        for text in [text.replace('\\', "\\ \t"), format!("# a\\b\\\n{text}")] {
            assert_eq!(read(&text).expect("readable").triangles(), [[0, 1, 2]], "{text}");
        }
        assert!(error_of("v 0 0 0 \\").starts_with("test.obj: no faces"));
    }

    #[test]
    fn lines_may_end_with_returns_alone() {
        let cube = read(CUBE).expect("readable");
        assert_eq!(read(&CUBE.replace("\r\n", "\n").replace('\n', "\r")).expect("CR"), cube);
        assert_eq!(read(&CUBE.replace("\r\n", "\n").replace('\n', "\r\n")).expect("both"), cube);
        let error = error_of(&"v 0 0 0\nv 1 0 0\nv 0 1 x\n".replace('\n', "\r"));
        assert!(error.starts_with("test.obj:3: `x` is not a number"), "{error}");
    }

    #[test]
    fn faces_of_two_corners_are_passed_over_and_told() {
        let text = format!("{CUBE}f 1 2\nf 3/1 4/1\n");
        let mut source = Source::of_bytes(Path::new("test.obj"), text.as_bytes());
        assert_eq!(parse(&mut source).expect("readable"), read(CUBE).expect("readable"));
        let remarks = source.finish().expect("read").remarks;
        assert_eq!(remarks, ["2 faces of two vertices passed over"]);
        assert!(error_of("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n").starts_with("test.obj: no faces"));
    }

    #[test]
    fn polygons_that_are_not_convex_are_cut_before_and_behind_their_vertices() {
        let vertices = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nv 0 0 9\n";
        for text in [
            format!("{vertices}f 2 3 4 5 1\nf 1 2 6\n"),
            format!("f 2 3 4 5 1\nf 1 2 6\n{vertices}"),
        ] {
            let mesh = read(&text).expect("readable");
            assert_eq!(mesh.triangles().len(), 4);
            // Half of 4 (4 + 1) + 4 (1 + 4), none of it twice.
            assert!((mesh.area() - 10.0 - 18.0).abs() <= 1e-14, "{:?}", mesh.triangles());
        }
    }

    #[test]
    fn faces_may_stand_before_their_vertices_and_weights_divide() {
        let mesh = read("f 1 2 3\nv 0 0 0\nv 2 0 0 2\nv 0 1 0 .5 .5 .5\n").expect("readable");
        assert_eq!(mesh.positions(), [DVec3::ZERO, DVec3::X, DVec3::Y]);
        let error = error_of("f 1 2 3\nf 2 4 5\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
        assert!(error.starts_with("test.obj:2: vertex 4 is not there; the file has 3"), "{error}");
    }

    #[test]
    fn vertices_keep_their_order_whatever_uses_them_first() {
        let mesh = read("v 9 0 0\nv 1 0 0\nf 5 3 2 4\nv 0 1 0\nv 0 0 1\nv 7 0 0\nf -1 -4 -2")
            .expect("readable");
        assert_eq!(mesh.positions(), [9. * DVec3::X, DVec3::X, DVec3::Y, DVec3::Z, 7. * DVec3::X]);
        assert_eq!(mesh.triangles(), [[4, 2, 1], [4, 1, 3], [4, 1, 3]]);
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            rng_seed: prop::test_runner::RngSeed::Fixed(1),
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        #[test]
        fn no_bytes_make_it_panic(
            changes in prop::collection::vec(
                (any::<prop::sample::Index>(), any::<u8>(), 0..4_u8),
                0..12,
            )
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
