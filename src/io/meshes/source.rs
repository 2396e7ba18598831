//! A mesh file as its reader sees it: a stream of bytes or lines that knows its length and says
//! where a fault is.
//!
//! Nothing here holds more than a buffer and one line, so that what a reader takes is the mesh it
//! makes.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Cursor, Read};
use std::path::Path;

use glam::DVec3;

use crate::error::InputError;
use crate::{Error, Result, memory};

/// How much of a file is seen at once, bytes: what tells its format is within.
const BUFFER: usize = 1 << 16;

/// Reads a file from its beginning to its end.
pub(super) struct Source<'a> {
    path: &'a Path,
    reader: Box<dyn BufRead + 'a>,
    length: u64,
    taken: u64,
    /// The number of the line read last, from 1.
    line: usize,
    /// What that line holds, without its end.
    text: Vec<u8>,
}

impl<'a> Source<'a> {
    /// Opens a file. What is no regular file (a pipe) is read into memory, since its length is not
    /// known before.
    pub(super) fn open(path: &'a Path) -> Result<Self> {
        if path.is_dir() {
            let help = "name a file in it";
            let error = InputError::new(path, "this is a folder, not a mesh file").help(help);
            return Err(error.into());
        }
        let refused = |e| Error::io(path, "read", e);
        let file = File::open(path).map_err(refused)?;
        let known = fs::metadata(path).map_err(refused)?;
        if known.is_file() {
            let reader = Box::new(BufReader::with_capacity(BUFFER, file));
            return Ok(Self::new(path, reader, known.len()));
        }
        let mut bytes = Vec::new();
        { file }.read_to_end(&mut bytes).map_err(refused)?;
        let length = bytes.len() as u64;
        Ok(Self::new(path, Box::new(Cursor::new(bytes)), length))
    }

    /// Takes bytes for the content of a file; `path` is for errors.
    pub(super) fn of_bytes(path: &'a Path, bytes: &'a [u8]) -> Self {
        Self::new(path, Box::new(bytes), bytes.len() as u64)
    }

    fn new(path: &'a Path, reader: Box<dyn BufRead + 'a>, length: u64) -> Self {
        Self { path, reader, length, taken: 0, line: 0, text: Vec::new() }
    }

    /// Returns the path of the file.
    pub(super) fn path(&self) -> &'a Path {
        self.path
    }

    /// Returns the length of the file, bytes.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Returns how many bytes are left.
    pub(super) fn left(&self) -> u64 {
        self.length.saturating_sub(self.taken)
    }

    /// Shows the bytes that come next, at the beginning of a file 64 KiB or all of them, without
    /// taking them.
    pub(super) fn ahead(&mut self) -> Result<&[u8]> {
        self.reader.fill_buf().map_err(|e| Error::io(self.path, "read", e))
    }

    /// Fills `bytes` with what comes next; false when so much is not left.
    pub(super) fn fill(&mut self, bytes: &mut [u8]) -> Result<bool> {
        match self.reader.read_exact(bytes) {
            Ok(()) => {
                self.taken += bytes.len() as u64;
                Ok(true)
            }
            Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Ok(false),
            Err(e) => Err(Error::io(self.path, "read", e)),
        }
    }

    /// Passes over so many bytes; false when so many are not left.
    pub(super) fn skip(&mut self, count: u64) -> Result<bool> {
        let mut rest = (&mut self.reader).take(count);
        let passed = std::io::copy(&mut rest, &mut std::io::sink())
            .map_err(|e| Error::io(self.path, "read", e))?;
        self.taken += passed;
        Ok(passed == count)
    }

    /// Takes all that is left.
    pub(super) fn rest(&mut self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.reader.read_to_end(&mut bytes).map_err(|e| Error::io(self.path, "read", e))?;
        self.taken += bytes.len() as u64;
        Ok(bytes)
    }

    /// Goes on to the next line, which [`Source::text`] then shows; false at the end of the file.
    pub(super) fn next_line(&mut self) -> Result<bool> {
        self.text.clear();
        self.line += 1;
        self.append_line()
    }

    /// Adds the next line to the one shown.
    pub(super) fn append_line(&mut self) -> Result<bool> {
        let read = memory::read_line(&mut self.reader, &mut self.text);
        let read = read.map_err(|e| Error::io(self.path, "read", e))?;
        self.taken += read as u64;
        if self.text.last() == Some(&b'\n') {
            self.text.pop();
        }
        if self.text.last() == Some(&b'\r') {
            self.text.pop();
        }
        Ok(read > 0)
    }

    /// Goes on to the next line that has more than blanks and, after a `#`, comments.
    pub(super) fn next_telling_line(&mut self) -> Result<bool> {
        while self.next_line()? {
            if self.words().next().is_some() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Shows the line read last, without its end.
    pub(super) fn text(&self) -> &[u8] {
        &self.text
    }

    /// Changes the line read last.
    pub(super) fn text_mut(&mut self) -> &mut Vec<u8> {
        &mut self.text
    }

    /// Returns the number of the line read last, from 1.
    pub(super) fn line(&self) -> usize {
        self.line
    }

    /// Counts a line that was appended to the one before it.
    pub(super) fn count_lines(&mut self, more: usize) {
        self.line += more;
    }

    /// Returns the words of the line read last, up to a `#`.
    pub(super) fn words(&self) -> impl Iterator<Item = &[u8]> {
        words(&self.text)
    }

    /// Rejects the file as a whole.
    pub(super) fn fault(&self, message: impl Into<String>, help: impl Into<String>) -> Error {
        InputError::new(self.path, message).help(help).into()
    }

    /// Rejects a line.
    pub(super) fn fault_at(
        &self,
        line: usize,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Error {
        InputError::new(self.path, message).at(line, None).help(help).into()
    }

    /// Rejects the line read last.
    pub(super) fn fault_here(&self, message: impl Into<String>, help: impl Into<String>) -> Error {
        self.fault_at(self.line, message, help)
    }
}

/// Returns the words of a line, up to a `#`.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let end = line.iter().position(|&b| b == b'#').unwrap_or(line.len());
    line[..end].split(u8::is_ascii_whitespace).filter(|w| !w.is_empty())
}

/// Reads a number; `None` for anything else. Infinities and NaN are numbers here.
pub(super) fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Shows a word in a message: as text, and not much of it.
pub(super) fn shown(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(&word[..word.len().min(4 * LONGEST)]);
    let mut short: String =
        text.chars().take(LONGEST).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if text.chars().count() > LONGEST {
        short.push_str("...");
    }
    short
}

/// Says that a vertex (from 0) is not where numbers are.
pub(super) fn not_finite(vertex: usize, position: DVec3) -> (String, &'static str) {
    (
        format!("vertex {vertex} (from 0) is at {position}, which is not finite"),
        "write three ordinary numbers; export again if a program wrote this",
    )
}
