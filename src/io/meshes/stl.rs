//! Stereolithography, as text and as binary.
//!
//! The format has no shared vertices: every facet brings its own three corners. Corners that are
//! equal to the last bit are therefore one vertex here, which is part of reading the format;
//! nothing else is joined or mended. The facets' own normals are passed over: the order of the
//! corners says what is outside.
//!
//! A file is binary when it is as long as the count after its header of 80 bytes says, whatever the
//! header holds: many programs begin it with `solid`. Then the count's bytes tell, none of which is
//! zero in a text.
//!
//! The last two bytes of a binary facet are a colour, or how many bytes of attributes follow it. In
//! a file that is no longer than its facets they are a colour, in a longer one they are believed:
//! attributes must end where the file does, and without any whatever follows is passed over.

use std::iter::Peekable;

use glam::DVec3;

use super::parts::Parts;
use super::welding::Welding;
use crate::io::bytes::{field, number_at};
use crate::io::source::{Source, not_finite, number, shown, unmarked};
use crate::mesh::Mesh;
use crate::{Error, Result};

const HEADER: u64 = 84;
const FACET: u64 = 50;

/// Whether a file of this length that begins so is a binary STL file.
pub(super) fn is_binary(head: &[u8], length: u64) -> bool {
    announced(head).is_some_and(|count| {
        length == length_of(count) || begins_as_text(head) && count.to_le_bytes().contains(&0)
    })
}

/// Whether a file begins as the text form does.
pub(super) fn is_text(head: &[u8]) -> bool {
    begins_as_text(head) && !announced(head).is_some_and(|n| n.to_le_bytes().contains(&0))
}

fn begins_as_text(head: &[u8]) -> bool {
    let head = unmarked(head).trim_ascii_start();
    let keyword = head.get(..5).is_some_and(|k| k.eq_ignore_ascii_case(b"solid"));
    keyword && head.get(5).is_none_or(u8::is_ascii_whitespace)
}

fn length_of(count: u32) -> u64 {
    HEADER + FACET * u64::from(count)
}

/// Returns the number of facets that the header of a binary file announces.
fn announced(head: &[u8]) -> Option<u32> {
    number_at(head, 80)
}

/// Reads the content of an STL file.
pub(super) fn parse(source: &mut Source) -> Result<Mesh> {
    let length = source.length();
    let head = source.ahead()?;
    if is_text(head) && !is_binary(head, length) {
        return parse_text(source);
    }
    let Some(count) = announced(head) else {
        let help = "an STL file begins with `solid`, or with 80 bytes and the number of its facets";
        return Err(source.fault(format!("this is no STL file: it has {length} bytes"), help));
    };
    parse_binary(source, count)
}

fn parse_binary(source: &mut Source, count: u32) -> Result<Mesh> {
    let needed = length_of(count);
    if needed > source.length() {
        let message = format!(
            "the header announces {count} facets, which take {needed} bytes, but the file has {}",
            source.length()
        );
        let help = "the file is cut short or no STL file; export it again";
        return Err(source.fault(message, help));
    }
    source.skip(HEADER)?;
    let mut parts = Parts::default();
    // The file is long enough for its count: a facet takes four times this.
    parts.triangles.reserve_exact(count as usize);
    let mut welding = Welding::default();
    let mut attributes = Attributes { are_there: needed < source.length(), bytes: 0 };
    let mut facet = [0; FACET as usize];
    for number in 0..count {
        if !source.fill(&mut facet)? {
            let message = format!("the file ends after {number} of {count} facets");
            return Err(attributes.or_fault(source, message, "export it again"));
        }
        let mut triangle = [0; 3];
        for (corner, vertex) in triangle.iter_mut().enumerate() {
            let position = position_at(&facet, 12 + 12 * corner);
            if !position.is_finite() {
                let (message, help) = not_finite(corner, position);
                let message = format!("facet {number} (from 0): {message}");
                return Err(attributes.or_fault(source, message, help));
            }
            *vertex = welding.vertex(source, position, &mut parts)?;
        }
        parts.triangles.push(triangle);
        attributes.pass(source, &facet)?;
    }
    if attributes.bytes > 0 && source.left() > 0 {
        return Err(attributes.fault(source));
    }
    parts.finish(source)
}

/// The bytes that follow the facets of a binary file, each its own.
struct Attributes {
    are_there: bool,
    /// How many there were.
    bytes: u64,
}

impl Attributes {
    /// Passes over those of a facet.
    fn pass(&mut self, source: &mut Source, facet: &[u8; FACET as usize]) -> Result<()> {
        let bytes = u64::from(field::<u16>(facet, FACET as usize - 2));
        if !self.are_there || bytes == 0 {
            return Ok(());
        }
        self.bytes += bytes;
        if source.skip(bytes)? { Ok(()) } else { Err(self.fault(source)) }
    }

    /// Rejects the file for what was found, or for its attributes, which may have led there.
    fn or_fault(&self, source: &Source, message: String, help: &str) -> Error {
        if self.bytes == 0 { source.fault(message, help) } else { self.fault(source) }
    }

    fn fault(&self, source: &Source) -> Error {
        let message = format!(
            "the facets and the bytes of attributes that they announce, {} up to here, do not end \
             where the file does",
            self.bytes
        );
        source.fault(message, "export it again, without attributes or colours")
    }
}

fn position_at(facet: &[u8; FACET as usize], at: usize) -> DVec3 {
    let coordinate = |i: usize| f64::from(field::<f32>(facet, at + 4 * i));
    DVec3::new(coordinate(0), coordinate(1), coordinate(2))
}

fn parse_text(source: &mut Source) -> Result<Mesh> {
    let mut text = Text::default();
    while source.next_telling_line()? {
        let mut words = source.words().peekable();
        while let Some(word) = words.next() {
            text.statement(source, word, &mut words)?;
        }
    }
    if text.is_open || text.facet.is_some() {
        let help =
            "the file is cut short: it ends with `endsolid` when it is whole; export it again";
        return Err(source.fault("the solid does not end", help));
    }
    text.parts.finish(source)
}

const STATEMENTS: &str = "a facet is `facet normal 0 0 1`, `outer loop`, three of `vertex 0.1 0.2 \
                          0.3`, `endloop`, `endfacet`";

/// Whether a word begins a statement within a solid. Programs write `end loop` as well.
fn is_keyword(word: &[u8]) -> bool {
    let keywords: [&[u8]; 8] =
        [b"facet", b"outer", b"vertex", b"endloop", b"endfacet", b"endsolid", b"end", b"loop"];
    keywords.iter().any(|k| word.eq_ignore_ascii_case(k))
}

/// What is read of a text.
#[derive(Default)]
struct Text {
    parts: Parts,
    welding: Welding,
    /// The corners of the facet that is open, and how many there are.
    facet: Option<([u32; 3], usize)>,
    is_open: bool,
}

impl Text {
    /// Takes a statement: its first word and, from those behind it on the line, what belongs to it.
    fn statement<'w>(
        &mut self,
        source: &Source,
        word: &[u8],
        rest: &mut Peekable<impl Iterator<Item = &'w [u8]>>,
    ) -> Result<()> {
        let mut keyword = word.to_ascii_lowercase();
        if keyword == b"end" {
            keyword.extend(rest.next().unwrap_or(b"").to_ascii_lowercase());
        }
        match keyword.as_slice() {
            b"solid" => {
                self.is_open = true;
                // Its name ends with the line, unless a facet stands there too.
                let is_shared = source.words().any(|w| w.eq_ignore_ascii_case(b"normal"));
                let is_name = |w: &&[u8]| !is_shared || !w.eq_ignore_ascii_case(b"facet");
                while rest.next_if(is_name).is_some() {}
            }
            b"endsolid" => {
                self.is_open = false;
                rest.for_each(drop);
            }
            b"facet" => {
                self.begin(source)?;
                while rest.next_if(|w| !is_keyword(w)).is_some() {}
            }
            b"vertex" => {
                let position = position_of(source, rest)?;
                let vertex = self.welding.vertex(source, position, &mut self.parts)?;
                self.corner(source, vertex)?;
            }
            b"endfacet" => self.end(source)?,
            b"outer" | b"loop" | b"endloop" => {}
            _ => {
                let message = format!("`{}` is no statement of an STL file", shown(word));
                return Err(source.fault_here(message, STATEMENTS));
            }
        }
        Ok(())
    }

    fn begin(&mut self, source: &Source) -> Result<()> {
        if self.facet.replace(([0; 3], 0)).is_some() {
            return Err(source.fault_here("a facet within a facet", STATEMENTS));
        }
        Ok(())
    }

    fn corner(&mut self, source: &Source, vertex: u32) -> Result<()> {
        match &mut self.facet {
            Some((corners, count @ 0..3)) => {
                corners[*count] = vertex;
                *count += 1;
                Ok(())
            }
            Some(_) => Err(source.fault_here("a facet of more than three vertices", STATEMENTS)),
            None => Err(source.fault_here("a vertex outside of a facet", STATEMENTS)),
        }
    }

    fn end(&mut self, source: &Source) -> Result<()> {
        match self.facet.take() {
            Some((corners, 3)) => {
                self.parts.triangles.push(corners);
                Ok(())
            }
            Some((_, count)) => {
                let message = format!("a facet of {count} vertices");
                Err(source.fault_here(message, STATEMENTS))
            }
            None => Err(source.fault_here("the end of a facet that did not begin", STATEMENTS)),
        }
    }
}

/// Reads the numbers of a vertex, up to the next statement.
fn position_of<'w>(
    source: &Source,
    words: &mut Peekable<impl Iterator<Item = &'w [u8]>>,
) -> Result<DVec3> {
    let help = "write three numbers, as in `vertex 0.1 0.2 0.3`";
    let mut values = [0.0; 3];
    let mut count = 0;
    while let Some(word) = words.next_if(|w| !is_keyword(w)) {
        let value = number(word);
        let Some(value) = value else {
            return Err(source.fault_here(format!("`{}` is not a number", shown(word)), help));
        };
        if let Some(place) = values.get_mut(count) {
            *place = value;
        }
        count += 1;
    }
    let position = DVec3::from_array(values);
    match count {
        3 if position.is_finite() => Ok(position),
        3 => Err(no_place(source, position)),
        _ => Err(source.fault_here(format!("a vertex of {count} coordinates"), help)),
    }
}

fn no_place(source: &Source, position: DVec3) -> Error {
    let help = "write three ordinary numbers; export again if a program wrote this";
    source.fault_here(format!("a vertex at {position}, which is not finite"), help)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::meshes::{MeshFormat, encode, recognise};
    use crate::mesh::{MeshReport, shapes};
    use std::path::Path;

    fn read(bytes: &[u8]) -> Result<Mesh> {
        parse(&mut Source::of_bytes(Path::new("test.stl"), bytes))
    }

    fn error_of(bytes: &[u8]) -> String {
        read(bytes).unwrap_err().to_string()
    }

    const TRIANGLE: &str = "solid a b\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   \
                            VERTEX 1 0 -0\n   vertex 0 1e0 0\n\
                            endloop\nendfacet\nendsolid a b\n";

    #[test]
    fn files_without_facets_say_so() {
        assert!(error_of(b"").starts_with("test.stl: this is no STL file: it has 0 bytes"));
        assert!(error_of(b"solid\nendsolid\n").starts_with("test.stl: no vertices and no faces"));
        assert!(error_of(&[0; 84]).starts_with("test.stl: no vertices and no faces"));
    }

    #[test]
    fn binary_file_is_welded_and_closed() {
        for mesh in [shapes::cube(), shapes::l_shape()] {
            let mut bytes = encode(&mesh, MeshFormat::Stl).expect("f32 holds it");
            // Whatever the header begins with.
            bytes[..5].copy_from_slice(b"solid");
            let back = read(&bytes).expect("readable");
            assert_eq!(back.positions().len(), mesh.positions().len());
            assert!(MeshReport::of(&back).require_closed().is_ok());
            assert_eq!((back.area(), back.volume()), (mesh.area(), mesh.volume()));
        }
    }

    #[test]
    fn text_is_read_and_zeros_of_both_signs_are_one() {
        let mesh = read(TRIANGLE.as_bytes()).expect("readable");
        assert_eq!((mesh.positions().len(), mesh.triangles()), (3, &[[0, 1, 2]][..]));
        let twice = format!("{TRIANGLE}\n{}", TRIANGLE.replace("1e0", "-1"));
        assert_eq!(read(twice.as_bytes()).expect("readable").positions().len(), 4);
    }

    #[test]
    fn text_may_be_written_in_many_ways() {
        let mesh = read(TRIANGLE.as_bytes()).expect("readable");
        for text in [
            format!("\u{feff}{TRIANGLE}"),
            TRIANGLE.replace('\n', "\r"),
            TRIANGLE.replace('\n', "\r\n"),
            TRIANGLE.replace("endloop", "end loop").replace("endfacet", "End  Facet"),
            TRIANGLE.replace("endsolid a b", "end solid").replace("solid a", "solid facet"),
            TRIANGLE.replace('\n', " ").replace("endsolid", "\nendsolid"),
            TRIANGLE.replace("b\n facet", "b\nfacet").replace("\n  ", " ").replace("\nend", " end"),
            TRIANGLE.replace("solid a b\n ", "solid\n").replace("normal 0 0 1", "normal -nan 0"),
        ] {
            assert!(recognise(text.as_bytes(), 300) == Some(MeshFormat::Stl), "{text}");
            assert_eq!(read(text.as_bytes()).expect("readable"), mesh, "{text}");
        }
    }

    /// A cube in binary, `bytes` behind each facet.
    fn with_attributes(colour: u16, bytes: usize) -> Vec<u8> {
        let plain = encode(&shapes::cube(), MeshFormat::Stl).expect("f32 holds it");
        let mut all = plain[..84].to_vec();
        for facet in plain[84..].chunks(50) {
            all.extend(&facet[..48]);
            all.extend(colour.to_le_bytes());
            all.extend(vec![0x7f; bytes]);
        }
        all
    }

    #[test]
    fn colours_and_attributes_are_passed_over() {
        let mesh = read(&with_attributes(0, 0)).expect("readable");
        assert_eq!(mesh.volume(), 1.0);
        for mut bytes in [
            with_attributes(0xffff, 0),
            with_attributes(7, 7),
            with_attributes(300, 300),
            [&with_attributes(0, 0)[..], b"trailing bytes"].concat(),
        ] {
            for start in [&b"harmolux"[..], b"solid a "] {
                bytes[..8].copy_from_slice(start);
                assert_eq!(read(&bytes).expect("readable"), mesh);
            }
            let is_told = recognise(&bytes, bytes.len() as u64) == Some(MeshFormat::Stl);
            assert!(is_told, "begins with solid");
        }
    }

    #[test]
    fn attributes_that_do_not_add_up_are_refused() {
        for bytes in [
            // More than there are, fewer, colours in a file that goes on, and what looks like any.
            with_attributes(8, 7),
            with_attributes(6, 7),
            [&with_attributes(0x7c1f, 0)[..], b"trailing bytes"].concat(),
            [&with_attributes(7, 7)[..], b"trailing bytes"].concat(),
            [&with_attributes(1, 0)[..], &[0; 12]].concat(),
        ] {
            let error = error_of(&bytes);
            assert!(error.contains("do not end where the file does\n  help: export"), "{error}");
        }
    }

    #[test]
    fn faults_of_a_text_name_the_line() {
        for (from, to, message) in [
            ("1e0", "x", "6: `x` is not a number"),
            ("1e0", "nan", "6: a vertex at [0, NaN, 0], which is not finite"),
            ("1e0", "", "6: a vertex of 2 coordinates"),
            ("   vertex 0 0 0\n", "", "7: a facet of 2 vertices"),
            ("endloop", "vertex 3 3 3", "7: a facet of more than three vertices"),
            ("endfacet", "facet", "8: a facet within a facet"),
            (" facet normal 0 0 1\n", "", "3: a vertex outside of a facet"),
            ("endloop", "endlop", "7: `endlop` is no statement of an STL file"),
            ("endsolid a b\n", "", " the solid does not end"),
        ] {
            let found = error_of(TRIANGLE.replacen(from, to, 1).as_bytes());
            assert!(found.starts_with(&format!("test.stl:{message}")), "{to}: {found}");
            assert!(found.contains("\n  help: "), "{found}");
        }
    }

    #[test]
    fn binary_file_that_is_cut_or_lies_is_refused_without_allocating() {
        let mut bytes = encode(&shapes::cube(), MeshFormat::Stl).expect("f32 holds it");
        assert!(
            error_of(&bytes[..200])
                .contains("announces 12 facets, which take 684 bytes, but the file has 200")
        );
        bytes[80..84].copy_from_slice(&[0xff; 4]);
        assert!(error_of(&bytes).contains("announces 4294967295 facets"));
        let mut bytes = encode(&shapes::cube(), MeshFormat::Stl).expect("f32 holds it");
        bytes[84 + 12..84 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        let error = error_of(&bytes);
        assert!(error.contains("facet 0 (from 0): vertex 0 (from 0) is at [NaN"), "{error}");
    }
}
