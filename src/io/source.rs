//! A file of a mesh or of points as its reader sees it: a stream of bytes or lines that knows its
//! length and says where a fault is.
//!
//! Nothing here holds more than a buffer and one line, so that what a reader takes is what it makes.

use std::io::{BufRead, Read};
use std::path::Path;

use glam::DVec3;

use crate::error::InputError;
use crate::io::input::{FilesRead, Input};
use crate::{Error, Result, memory};

/// Reads a file from its beginning to its end.
pub(super) struct Source<'a> {
    input: Input<'a>,
    taken: u64,
    /// The number of the line read last, from 1.
    line: usize,
    /// What that line holds, without its end.
    text: Vec<u8>,
    /// Whether it ended with a carriage return alone.
    is_return: bool,
    /// Whether a line feed behind a carriage return is no part of the line's end.
    keeps_feeds: bool,
}

impl<'a> Source<'a> {
    /// Opens a file or a pipe.
    pub(super) fn open(path: &'a Path) -> Result<Self> {
        Input::open(path).map(Self::new)
    }

    /// Takes bytes for the content of a file; `path` is for errors.
    pub(super) fn of_bytes(path: &'a Path, bytes: &'a [u8]) -> Self {
        Self::new(Input::of_bytes(path, bytes))
    }

    /// Takes a file that is open, at its beginning.
    pub(super) fn new(input: Input<'a>) -> Self {
        Self { input, taken: 0, line: 0, text: Vec::new(), is_return: false, keeps_feeds: false }
    }

    /// Reads what is left, and says what was read.
    pub(super) fn finish(self) -> Result<FilesRead> {
        self.input.finish()
    }

    /// Remembers something that the file's user should hear of.
    pub(super) fn remark(&mut self, text: String) {
        self.input.remark(text);
    }

    /// Reads at most the first `most` bytes of a file that this one names.
    pub(super) fn read_beside(&mut self, path: &Path, most: u64) -> Result<Vec<u8>> {
        self.input.read_beside(path, most)
    }

    /// Returns the path of the file.
    pub(super) fn path(&self) -> &'a Path {
        self.input.path()
    }

    /// Returns the name whose extension is that of the content.
    pub(super) fn name(&self) -> &'a Path {
        self.input.name()
    }

    /// Returns the length of the file, bytes.
    pub(super) fn length(&self) -> u64 {
        self.input.length()
    }

    /// Returns how many bytes are left.
    pub(super) fn left(&self) -> u64 {
        self.length().saturating_sub(self.taken)
    }

    /// Shows the bytes that come next, at the beginning of a file 64 KiB or all of them, without
    /// taking them.
    pub(super) fn ahead(&mut self) -> Result<&[u8]> {
        self.input.ahead()
    }

    /// Fills `bytes` with what comes next; false when so much is not left.
    pub(super) fn fill(&mut self, bytes: &mut [u8]) -> Result<bool> {
        match self.input.read_exact(bytes) {
            Ok(()) => {
                self.taken += bytes.len() as u64;
                Ok(true)
            }
            Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Ok(false),
            Err(e) => Err(Error::io(self.path(), "read", e)),
        }
    }

    /// Passes over so many bytes; false when so many are not left.
    pub(super) fn skip(&mut self, count: u64) -> Result<bool> {
        let mut rest = (&mut self.input).take(count);
        let passed = std::io::copy(&mut rest, &mut std::io::sink())
            .map_err(|e| Error::io(self.path(), "read", e))?;
        self.taken += passed;
        Ok(passed == count)
    }

    /// Takes all that is left.
    pub(super) fn rest(&mut self) -> Result<Vec<u8>> {
        let bytes = self.input.rest()?;
        self.taken += bytes.len() as u64;
        Ok(bytes)
    }

    /// Goes on to the next line, which [`Source::text`] then shows; false at the end of the file. A
    /// line ends at a line feed, a carriage return, or both; a mark of UTF-8 before the first is
    /// passed over.
    pub(super) fn next_line(&mut self) -> Result<bool> {
        self.text.clear();
        self.line += 1;
        let is_there = self.append_line()?;
        if self.line == 1 && self.text.starts_with(MARK) {
            self.text.drain(..MARK.len());
        }
        Ok(is_there)
    }

    /// Adds the next line to the one shown.
    pub(super) fn append_line(&mut self) -> Result<bool> {
        let read = memory::read_half_line(&mut self.input, &mut self.text);
        let read = read.map_err(|e| Error::io(self.path(), "read", e))?;
        self.taken += read as u64;
        self.is_return = false;
        match self.text.last() {
            Some(b'\n') if read > 0 => drop(self.text.pop()),
            Some(b'\r') if read > 0 => {
                self.text.pop();
                self.is_return = self.keeps_feeds || self.ahead()?.first() != Some(&b'\n');
                if !self.is_return {
                    self.input.consume(1);
                    self.taken += 1;
                }
            }
            _ => {}
        }
        Ok(read > 0)
    }

    /// Settles that lines end as the one read last did: where that is a carriage return alone, a
    /// line feed behind another one is the first of the bytes that follow.
    pub(super) fn settle_line_ends(&mut self) {
        self.keeps_feeds = self.is_return;
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

    /// Adds the next line where a backslash, but for blanks behind it, ends the one shown; whether
    /// it did.
    pub(super) fn continues(&mut self) -> Result<bool> {
        let text = self.text.trim_ascii_end();
        if text.last() != Some(&b'\\') || text.contains(&b'#') {
            return Ok(false);
        }
        let end = text.len() - 1;
        self.text.truncate(end);
        self.text.push(b' ');
        self.append_line()
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
        InputError::new(self.path(), message).help(help).into()
    }

    /// Rejects a line.
    pub(super) fn fault_at(
        &self,
        line: usize,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Error {
        InputError::new(self.path(), message).at(line, None).help(help).into()
    }

    /// Rejects the line read last.
    pub(super) fn fault_here(&self, message: impl Into<String>, help: impl Into<String>) -> Error {
        self.fault_at(self.line, message, help)
    }
}

/// How a text may say that it is UTF-8.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Returns the beginning of a file without the mark of UTF-8.
pub(super) fn unmarked(head: &[u8]) -> &[u8] {
    head.strip_prefix(MARK).unwrap_or(head)
}

/// Returns the words of the first line that has any, at the beginning of a file.
pub(super) fn first_words(head: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut lines = unmarked(head).split(|b| matches!(b, b'\n' | b'\r'));
    words(lines.find(|line| words(line).next().is_some()).unwrap_or(b""))
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

/// Shows a word in a message.
pub(super) use crate::error::shown_bytes as shown;

/// Says that a vertex (from 0) is not where numbers are.
pub(super) fn not_finite(vertex: usize, position: DVec3) -> (String, &'static str) {
    (
        format!("vertex {vertex} (from 0) is at {position}, which is not finite"),
        "write three ordinary numbers; export again if a program wrote this",
    )
}
