//! The Object File Format as text: OFF and its variants whose vertices carry normals, colours or
//! texture coordinates as well.
//!
//! Vertices and faces stand one a line; what follows the coordinates of a vertex or the corners of
//! a face on its line is passed over, and a row that is not whole goes on on the next line. Plain
//! OFF may also break its lines anywhere: it does where its numbers are as many as coordinates and
//! corners alone take, or a line has more than any vertex could.

use std::iter;
use std::ops::Range;

use glam::DVec3;

use super::parts::{CUT, Parts, thin_face, too_many};
use crate::io::source::{Source, not_finite, number, shown, words};
use crate::mesh::Mesh;
use crate::{Error, Result};

/// Whether the first word of a file is that of the format, be it a variant that cannot be read.
pub(super) fn is_off(word: &[u8]) -> bool {
    keyword(word).is_some()
}

/// Returns the keyword that a word begins with, in capitals; the first count may follow without a
/// blank, as in files of ModelNet.
fn keyword(word: &[u8]) -> Option<Vec<u8>> {
    let digits = word.iter().rev().take_while(|b| b.is_ascii_digit()).count();
    let word = &word[..word.len() - digits];
    // In small letters all of it: `nOFF` is not `NOFF`.
    let word = if word.ends_with(b"off") { word.to_ascii_uppercase() } else { word.to_vec() };
    let variant = word.strip_suffix(b"OFF")?;
    (variant.len() <= 5 && variant.iter().all(|b| b"STCN4n".contains(b))).then_some(word)
}

/// Reads the content of an OFF file.
pub(super) fn parse(source: &mut Source) -> Result<Mesh> {
    let mut reader = Reader::new(source);
    let [vertices, faces] = reader.counts()?;
    reader.check_length(vertices, faces)?;
    reader.choose_layout(vertices, faces)?;
    let mut parts = Parts::default();
    // The file is long enough for its counts: no line takes less than a fifth of what it becomes.
    parts.positions.reserve_exact(vertices as usize);
    for vertex in 0..vertices {
        let cut_short = |reader: &Reader| reader.cut_short(vertex, vertices, "vertices");
        let position = if reader.next_row()? { reader.position()? } else { None };
        let position = position.ok_or_else(|| cut_short(&reader))?;
        if !position.is_finite() {
            let (message, help) = not_finite(vertex as usize, position);
            return Err(reader.source.fault_here(message, help));
        }
        parts.vertex(reader.source, position)?;
    }
    parts.triangles.reserve_exact(faces as usize);
    let mut corners = Vec::new();
    for number in 0..faces {
        if !reader.next_row()? || !reader.face(vertices, &mut corners)? {
            return Err(reader.cut_short(number, faces, "faces"));
        }
        parts.polygon(&corners).map_err(|e| reader.source.fault_here(e.to_string(), CUT))?;
    }
    if reader.next_row()? && reader.next_word()?.is_some() {
        let help = "a count in the header is too small; export the file again";
        let message = "this follows the last face that the header announces";
        return Err(source.fault_here(message, help));
    }
    parts.finish(source)
}

/// What to do about a file that is not whole.
const CUT_SHORT: &str = "the file is cut short or its header is wrong; export it again";

/// Says what an OFF file begins with.
const BEGINNING: &str = "an OFF file begins with `OFF` and the numbers of vertices, faces and \
                         edges, as in `8 12 18`";

/// More words than stand in the line of a vertex: its place, normal, colour and texture coordinates.
const MOST_WORDS: usize = 12;

/// Takes the words of a file in turn.
struct Reader<'r, 'a> {
    source: &'r mut Source<'a>,
    /// How far the line is read.
    read: usize,
    /// Where it ends, or a comment begins.
    end: usize,
    /// Whether vertices have coordinates and nothing more.
    is_plain: bool,
    /// Whether rows begin anywhere in a line.
    is_stream: bool,
}

impl<'r, 'a> Reader<'r, 'a> {
    fn new(source: &'r mut Source<'a>) -> Self {
        Self { source, read: 0, end: 0, is_plain: true, is_stream: false }
    }

    /// Goes on to the next line that has words.
    fn next_line(&mut self) -> Result<bool> {
        let is_there = self.source.next_telling_line()?;
        let text = self.source.text();
        (self.read, self.end) = (0, text.iter().position(|&b| b == b'#').unwrap_or(text.len()));
        Ok(is_there)
    }

    /// Takes the next word of the line.
    fn word_of_line(&mut self) -> Option<Range<usize>> {
        let line = &self.source.text()[..self.end];
        let start = self.read + line[self.read..].iter().position(|b| !b.is_ascii_whitespace())?;
        let length = line[start..].iter().position(u8::is_ascii_whitespace);
        self.read = length.map_or(self.end, |n| start + n);
        Some(start..self.read)
    }

    /// Takes the next word, on this line or a later one.
    fn next_word(&mut self) -> Result<Option<Range<usize>>> {
        loop {
            if let Some(word) = self.word_of_line() {
                return Ok(Some(word));
            }
            if !self.next_line()? {
                return Ok(None);
            }
        }
    }

    fn text(&self, word: Range<usize>) -> &[u8] {
        &self.source.text()[word]
    }

    /// Reads the keyword, which may be missing, and the numbers of vertices, faces and, where it is
    /// there, edges.
    fn counts(&mut self) -> Result<[u64; 2]> {
        if !self.next_line()? {
            return Err(self.source.fault("no vertices and no faces", BEGINNING));
        }
        self.keyword()?;
        let mut counts = [0; 2];
        for count in &mut counts {
            let Some(word) = self.next_word()? else {
                return Err(self.source.fault("the file ends before its counts", BEGINNING));
            };
            *count = number(self.text(word)).ok_or_else(|| self.no_counts())?;
        }
        if !self.edges()? && self.next_line()? {
            // The number of edges may have a line of its own; nothing else that is whole has.
            let word = self.word_of_line().map_or(&b""[..], |word| self.text(word));
            if number::<u64>(word).is_none() || self.word_of_line().is_some() {
                self.read = 0;
            }
        }
        Ok(counts)
    }

    /// Passes over the number of edges; false where it is not on this line.
    fn edges(&mut self) -> Result<bool> {
        let Some(word) = self.word_of_line() else { return Ok(false) };
        number::<u64>(self.text(word)).ok_or_else(|| self.no_counts())?;
        Ok(true)
    }

    fn no_counts(&self) -> Error {
        let message = format!("`{}` are no counts", shown(self.source.text().trim_ascii()));
        self.source.fault_here(message, BEGINNING)
    }

    fn keyword(&mut self) -> Result<()> {
        let Some(word) = self.word_of_line() else { return Ok(()) };
        let start = word.start;
        let Some(keyword) = keyword(self.text(word)) else {
            self.read = 0;
            return Ok(());
        };
        if keyword.contains(&b'4') || keyword.contains(&b'n') {
            let message = format!("`{}` has vertices of four or n coordinates", shown(&keyword));
            let help = "export the surface with three coordinates";
            return Err(self.source.fault_here(message, help));
        }
        if self.source.words().nth(1).is_some_and(|w| w.eq_ignore_ascii_case(b"binary")) {
            let help = "export it as text, or as PLY";
            let message = "this is a binary OFF file, which is not read";
            return Err(self.source.fault_here(message, help));
        }
        self.is_plain = keyword == b"OFF";
        self.read = start + keyword.len();
        Ok(())
    }

    /// Rejects counts that the file is too short for, before anything is allocated by them.
    fn check_length(&self, vertices: u64, faces: u64) -> Result<()> {
        if vertices > super::parts::MOST_VERTICES {
            return Err(self.source.fault_here(too_many(vertices), "divide the file"));
        }
        // `0 0 0` and `3 0 1 2`, the last without its line end.
        let needed = vertices.saturating_mul(6).saturating_add(faces.saturating_mul(8));
        let left = self.source.left().saturating_add((self.end - self.read) as u64);
        if needed > left.saturating_add(2) {
            let message = format!(
                "the header announces {vertices} vertices and {faces} faces, which take {needed} \
                 bytes at least, but only {left} are left for them"
            );
            return Err(self.source.fault_here(message, CUT_SHORT));
        }
        Ok(())
    }

    /// Says whether rows begin anywhere in a line, by what comes next.
    fn choose_layout(&mut self, vertices: u64, faces: u64) -> Result<()> {
        let line = self.source.text()[self.read..self.end].to_vec();
        let left = self.source.left();
        let ahead = self.source.ahead()?;
        let lines = || iter::once(&line[..]).chain(ahead.split(|b| matches!(b, b'\n' | b'\r')));
        // The number of edges may be the first of them, where it is not read.
        let most = usize::from(self.read == 0);
        let edges = if ahead.len() as u64 == left {
            (0..=most).find(|&n| fits(lines().flat_map(words).skip(n), vertices, faces))
        } else {
            let mut counts = lines().map(|line| words(line).count());
            counts.find(|&count| count > 0).is_some_and(|count| count > MOST_WORDS).then_some(0)
        };
        self.is_stream = self.is_plain && edges.is_some();
        if self.is_stream && edges == Some(1) {
            self.edges()?;
        }
        if self.is_stream || self.read == 0 || words(&line).next().is_none() {
            return Ok(());
        }
        Err(self.no_counts())
    }

    /// Goes to where the next row begins; false at the end of the file.
    fn next_row(&mut self) -> Result<bool> {
        // A line of which nothing is read was looked at for the number of edges.
        Ok(self.is_stream || self.read == 0 || self.next_line()?)
    }

    fn cut_short(&self, row: u64, count: u64, what: &str) -> Error {
        self.source.fault(format!("the file ends after {row} of {count} {what}"), CUT_SHORT)
    }

    /// Reads a vertex; `None` where the file ends within.
    fn position(&mut self) -> Result<Option<DVec3>> {
        let mut position = DVec3::ZERO;
        for axis in 0..3 {
            let Some(word) = self.next_word()? else { return Ok(None) };
            position[axis] = number(self.text(word.clone())).ok_or_else(|| {
                let message = format!("`{}` is not a number", shown(self.text(word)));
                self.source.fault_here(message, "write three numbers, as in `0.1 0.2 0.3`")
            })?;
        }
        Ok(Some(position))
    }

    /// Reads the corners of a face; false where the file ends before it.
    fn face(&mut self, vertices: u64, corners: &mut Vec<u32>) -> Result<bool> {
        corners.clear();
        let Some(word) = self.next_word()? else { return Ok(false) };
        let line = self.source.line();
        let length: u64 = number(self.text(word.clone())).ok_or_else(|| {
            let message = format!("`{}` is no number of corners", shown(self.text(word)));
            self.source.fault_here(message, "begin a face with how many vertices it has")
        })?;
        if length < 2 {
            let help = "give a face at least three vertices, as in `3 0 1 2`";
            return Err(self.source.fault_here(thin_face(length), help));
        }
        for corner in 0..length {
            let Some(word) = self.next_word()? else {
                let message = format!("{corner} of {length} corners");
                return Err(self.source.fault_at(line, message, CUT_SHORT));
            };
            let vertex = number::<u64>(self.text(word.clone())).filter(|&v| v < vertices);
            let vertex = vertex.ok_or_else(|| stray(self.source, self.text(word), vertices))?;
            corners.push(vertex as u32);
        }
        Ok(true)
    }
}

/// Whether the words of a file are so many vertices and faces, and nothing more.
fn fits<'w>(mut words: impl Iterator<Item = &'w [u8]>, vertices: u64, faces: u64) -> bool {
    let mut pass = |count| (0..count).all(|_| words.next().is_some());
    if !pass(3 * vertices) {
        return false;
    }
    for _ in 0..faces {
        let length = words.next().and_then(number::<u64>);
        if !length.is_some_and(|length| (0..length).all(|_| words.next().is_some())) {
            return false;
        }
    }
    words.next().is_none()
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
    use crate::io::source::first_words;
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
    fn keyword_may_be_small_or_joined_to_the_first_count() {
        let mesh = read(PYRAMID).expect("readable");
        let bare = PYRAMID.replace("OFF # a pyramid\n# of five vertices\n", "OFF\n");
        for text in [
            bare.replace("OFF\n5", "OFF5"),
            bare.replace("OFF", "off"),
            bare.replace("OFF\n5", "\u{feff}off5"),
            bare.replace('\n', "\r"),
            bare.replace('\n', "\r\n"),
            bare.replace("OFF\n5 5 8", "OFF # one a line\n5\n5 # faces\n\n8"),
            bare.replace("5 5 8", "5 5\n8"),
            bare.replace("5 5 8", "5\n5"),
        ] {
            assert!(is_off(first_words(text.as_bytes()).next().expect("a word")), "{text}");
            assert_eq!(read(&text).expect("readable"), mesh, "{text}");
        }
        for word in ["OFFSET", "off2x", "offer", "on", "XOFF", "8", ""] {
            assert!(!is_off(word.as_bytes()), "{word}");
        }
    }

    #[test]
    fn lines_may_be_broken_anywhere() {
        let text = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
        let mesh = read(text).expect("readable");
        assert_eq!(mesh.volume(), 1.0 / 6.0);
        let words: Vec<&str> = text.split_whitespace().collect();
        for width in 1..=words.len() {
            let lines: Vec<String> = words.chunks(width).map(|line| line.join(" ")).collect();
            assert_eq!(read(&lines.join("\n")).expect("readable"), mesh, "{width}");
        }
        // With colours, which end a line, a row that is not whole goes on.
        let broken = PYRAMID.replace("1 1 0\n", "1\n1 # y\n0\n").replace("4 255", "\n4 255");
        assert_eq!(read(&broken).expect("readable"), read(PYRAMID).expect("readable"));
    }

    #[test]
    fn long_file_may_be_one_line() {
        let count = 20_000;
        let vertices: Vec<String> = (0..count).map(|i| format!("{i} {} 1", i % 7)).collect();
        let faces: Vec<String> = (2..count).map(|i| format!("3 {} {} {i}", i - 2, i - 1)).collect();
        let (vertices, faces) = (vertices.join(" "), faces.join(" "));
        let text = format!("OFF {count} {} 0 {vertices} {faces}", count - 2);
        let mesh = read(&text).expect("readable");
        assert_eq!((mesh.positions().len(), mesh.triangles().len()), (count, count - 2));
        assert_eq!(read(&text.replacen(" 0 ", " 0\n", 1)).expect("two lines"), mesh);
    }

    #[test]
    fn faces_of_two_corners_are_passed_over_and_others_cut() {
        let text = "OFF\n5 2 0\n0 0 0\n4 0 0\n4 4 0\n2 1 0\n0 4 0\n5 1 2 3 4 0\n2 0 1\n";
        let mesh = read(text).expect("readable");
        assert!(mesh.triangles().len() == 3 && (mesh.area() - 10.0).abs() <= 1e-14);
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
            // The vertex takes a number of the next line, and so a line is missing at the end.
            ("1 1 0", "1 1", " the file ends after 4 of 5 faces"),
            ("5 5 8", "5 5 8 0", "3: `5 5 8 0` are no counts"),
            ("3 3 0 4", "3 3 0 5", "14: vertex 5 is not there; the file has 5 vertices"),
            ("3 3 0 4", "3 3 0 -1", "14: vertex -1 is not there"),
            ("3 3 0 4", "3 3 0", "14: 2 of 3 corners"),
            ("3 3 0 4", "1 3", "14: a face of 1 vertex"),
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
