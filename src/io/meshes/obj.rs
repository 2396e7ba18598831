//! Wavefront OBJ: the statements `v` and `f` of all objects and groups as one mesh.
//!
//! Crate tobj reads the statements. It splits a file at every object, group and material, numbers vertices anew, knows no lines,
//! and takes polylines for faces; so it is handed only the statements that matter, behind one more face that names every vertex
//! in the order of the file. What it refuses is then looked for line by line.

use std::fmt::Write;
use std::path::Path;

use glam::DVec3;

use super::load;
use crate::error::InputError;
use crate::surface::Mesh;
use crate::{Error, Result};

/// Reads an OBJ file: its vertices in their own order, its polygons cut into fans. Objects and groups are joined and share their
/// vertices; normals, texture coordinates, materials, points and lines are passed over.
///
/// # Errors
/// [`Error::Io`] when the file cannot be read; [`Error::Input`], with the line where there is one, when it is a folder, is not
/// UTF-8, has no vertices or no faces, or has a statement that cannot be used: a coordinate that is no finite number, a face of
/// fewer than three vertices, a number of a vertex that is not there.
pub fn read_obj(path: &Path) -> Result<Mesh> {
    parse(path, &load(path)?)
}

/// Reads the content of an OBJ file; `path` is for its errors.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    let statements = Statements::of(path, text_of(path, bytes)?)?;
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_lines: true,
        ignore_points: true,
        ..Default::default()
    };
    let source = statements.for_tobj();
    // No material is ever asked for.
    let materials = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
    let Ok((models, _)) = tobj::load_obj_buf(&mut source.as_bytes(), &options, materials) else {
        return Err(statements.find_fault(path));
    };
    let Some(model) = models.first() else { return Err(statements.find_fault(path)) };
    let positions: Vec<_> = model.mesh.positions.chunks_exact(3).map(DVec3::from_slice).collect();
    if let Some(v) = positions.iter().position(|p| !p.is_finite()) {
        return Err(statements.not_finite(path, v, positions[v]));
    }
    let triangles = model.mesh.indices.chunks_exact(3).skip(statements.extra_triangles());
    Mesh::new(positions, triangles.map(|t| [t[0], t[1], t[2]]).collect())
}

/// One statement: its line, from 1, and its words after the keyword.
struct Statement<'a> {
    line: usize,
    words: Vec<&'a str>,
}

/// The statements of a file that make its mesh.
struct Statements<'a> {
    vertices: Vec<Statement<'a>>,
    faces: Vec<Statement<'a>>,
    /// How many vertices stand before each face; negative numbers count back from there.
    before: Vec<usize>,
}

impl<'a> Statements<'a> {
    fn of(path: &Path, text: &'a str) -> Result<Self> {
        let mut all = Self { vertices: Vec::new(), faces: Vec::new(), before: Vec::new() };
        for (i, line) in text.lines().enumerate() {
            let mut words = line.split('#').next().unwrap_or("").split_whitespace();
            let keyword = words.next();
            let mut statement = || Statement { line: i + 1, words: words.by_ref().collect() };
            match keyword {
                Some("v") => all.vertices.push(statement()),
                Some("f" | "fo") => {
                    all.faces.push(statement());
                    all.before.push(all.vertices.len());
                }
                _ => {}
            }
        }
        all.check(path)?;
        Ok(all)
    }

    /// Refuses what tobj would pass over in silence.
    fn check(&self, path: &Path) -> Result<()> {
        let whole =
            |message: &str, help: &str| Err(InputError::new(path, message).help(help).into());
        if self.vertices.is_empty() && self.faces.is_empty() {
            let help = "an OBJ file has lines such as `v 0.1 0.2 0.3` and `f 1 2 3`; check that this is the right file";
            return whole("no vertices and no faces", help);
        }
        if self.faces.is_empty() {
            let help = "export the surface as triangles or polygons (`f 1 2 3`), not as points, lines or curves";
            return whole("no faces", help);
        }
        if self.vertices.len() > u32::MAX as usize {
            return whole("more than 4294967295 vertices", "divide the file");
        }
        let thin = self.faces.iter().find(|f| f.words.len() < 3);
        thin.map_or(Ok(()), |f| {
            let message = format!("a face of {} vertices", f.words.len());
            Err(InputError::new(path, message)
                .at(f.line, None)
                .help("give a face at least three vertices, as in `f 1 2 3`, on one line")
                .into())
        })
    }

    /// Writes what tobj is to read: a face of all vertices, so that it keeps their numbers, and the statements without colours.
    fn for_tobj(&self) -> String {
        let mut text = String::from("f");
        // Writing into a String cannot fail.
        let mut write = |arguments: std::fmt::Arguments| {
            let _ = text.write_fmt(arguments);
        };
        for number in 1..=self.vertices.len().max(3) {
            write(format_args!(" {number}"));
        }
        let (mut faces, mut before) = (self.faces.iter(), self.before.iter().peekable());
        for i in 0..=self.vertices.len() {
            while before.next_if(|&&b| b == i).is_some() {
                let words = faces.next().map_or(&[][..], |f| &f.words);
                write(format_args!("\nf {}", words.join(" ")));
            }
            if let Some(vertex) = self.vertices.get(i) {
                write(format_args!("\nv {}", coordinates(&vertex.words).join(" ")));
            }
        }
        text
    }

    /// Gives how many triangles the face of all vertices was cut into.
    fn extra_triangles(&self) -> usize {
        self.vertices.len().max(3) - 2
    }

    /// Finds the first statement that cannot be used, after tobj found that there is one.
    fn find_fault(&self, path: &Path) -> Error {
        let vertices = self.vertices.iter().filter_map(|s| Some((s.line, vertex_fault(&s.words)?)));
        let faces = self.faces.iter().zip(&self.before).filter_map(|(s, &before)| {
            let fault = |word: &&str| face_fault(word, before, self.vertices.len());
            Some((s.line, s.words.iter().find_map(fault)?))
        });
        let first = vertices.chain(faces).min_by_key(|(line, _)| *line);
        let (line, (message, help)) = match first {
            Some((line, fault)) => (Some(line), fault),
            None if self.vertices.len() < 3 => {
                (None, (format!("only {} vertices", self.vertices.len()), ENOUGH.to_owned()))
            }
            None => (None, ("a statement that cannot be read".to_owned(), ENOUGH.to_owned())),
        };
        let mut error = InputError::new(path, message).help(help);
        error.line = line;
        error.into()
    }

    fn not_finite(&self, path: &Path, vertex: usize, position: DVec3) -> Error {
        let mut error = InputError::new(
            path,
            format!("vertex {} is at {position}, which is not finite", vertex + 1),
        )
        .help("write three ordinary numbers; export again if a program wrote this");
        error.line = self.vertices.get(vertex).map(|s| s.line);
        error.into()
    }
}

/// What a file needs at least.
const ENOUGH: &str = "give three or more lines such as `v 0.1 0.2 0.3` and faces such as `f 1 2 3`";

/// Keeps x, y, z, and the weight where it is all that follows; drops colours.
fn coordinates<'w, 'a>(words: &'w [&'a str]) -> &'w [&'a str] {
    if words.len() == 4 { words } else { &words[..words.len().min(3)] }
}

/// Says what is wrong with a vertex and what to write instead.
fn vertex_fault(words: &[&str]) -> Option<(String, String)> {
    let help = || "write three numbers, as in `v 0.1 0.2 0.3`".to_owned();
    if words.len() < 3 {
        return Some((format!("a vertex of {} coordinates", words.len()), help()));
    }
    let words = coordinates(words);
    if let Some(word) = words.iter().find(|w| w.parse::<f64>().is_err()) {
        return Some((format!("`{word}` is not a number"), help()));
    }
    let weight = words.get(3).and_then(|w| w.parse::<f64>().ok());
    (weight == Some(0.0)).then(|| {
        (
            "a vertex of weight 0, which is at infinity".to_owned(),
            "leave out the fourth number".to_owned(),
        )
    })
}

/// Says what is wrong with a corner of a face, of `count` vertices `before` of which stand before it.
fn face_fault(word: &str, before: usize, count: usize) -> Option<(String, String)> {
    let numbers: Vec<&str> = word.split('/').collect();
    let readable = |n: &&str| n.is_empty() || n.parse::<isize>().is_ok();
    if numbers.len() > 3 || numbers[0].is_empty() || !numbers.iter().all(readable) {
        let help = "write a corner as the number of a vertex: `7`, `7/1`, `7//2` or `7/1/2`";
        return Some((format!("`{word}` is not a corner of a face"), help.to_owned()));
    }
    let number = numbers[0].parse::<isize>().ok()?;
    let in_range = if number < 0 {
        number.unsigned_abs() <= before
    } else {
        (1..=count).contains(&number.unsigned_abs())
    };
    (!in_range).then(|| {
        let help = format!("number vertices from 1 to {count}, or from -1 back to -{before} here");
        (format!("vertex {number} is not there; the file has {count} vertices"), help)
    })
}

/// Reads bytes as text, without a byte order mark.
fn text_of<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Ok(text.strip_prefix('\u{feff}').unwrap_or(text)),
        Err(error) => {
            let good = &bytes[..error.valid_up_to()];
            let line = good.split(|&b| b == b'\n').count();
            Err(InputError::new(path, format!("byte {:#04x} is not UTF-8 text", bytes[good.len()]))
                .at(line, None)
                .help("save the file as UTF-8 text; a binary file is not OBJ, whatever its name")
                .into())
        }
    }
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
        parse(Path::new("test.obj"), text.as_bytes())
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
        let error = parse(Path::new("test.obj"), b"# a\nv 0 0 \xff\n").unwrap_err().to_string();
        assert!(error.starts_with("test.obj:2: byte 0xff is not UTF-8 text"), "{error}");
    }

    #[test]
    fn objects_are_joined_and_vertices_keep_their_numbers() {
        let cube = read(CUBE).expect("readable");
        assert_eq!((cube.positions().len(), cube.triangles().len()), (8, 12));
        assert_eq!(cube.positions()[4], DVec3::Z);
        assert_eq!(cube.triangles()[..3], [[3, 2, 1], [3, 1, 0], [0, 1, 5]]);
        assert!(crate::surface::MeshReport::of(&cube).require_closed().is_ok());
        assert!((cube.volume() - 1.0).abs() <= 1e-15);
        assert_eq!(read(&format!("\u{feff}{CUBE}")).expect("readable"), cube);
    }

    #[test]
    fn numbers_count_from_either_end() {
        let mesh = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9\nf -4 -3 -2").expect("readable");
        assert_eq!((mesh.positions().len(), mesh.triangles()), (4, &[[0, 1, 2]][..]));
        assert!(error_of("v 0 0 0\nv 1 0 0\nf 1 2 2").starts_with("test.obj: only 2 vertices"));
    }

    proptest! {
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
            match parse(Path::new("test.obj"), &bytes) {
                Ok(mesh) => prop_assert!(mesh.positions().iter().all(|p| p.is_finite())),
                Err(error) => prop_assert!(error.to_string().starts_with("test.obj")),
            }
        }

        #[test]
        fn random_bytes_are_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            prop_assert!(parse(Path::new("test.obj"), &bytes).is_err());
        }
    }
}
