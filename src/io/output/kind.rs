//! Kinds of files, and how one that this program wrote is known.
//!
//! A file is ours when it begins as its [`Kind`] begins and names this program within its first
//! KiB: the `Software` text of a PNG, the `software` attribute of an EXR or JSON file, the first
//! comment of a coefficient text. A CSV table has no room for a name that other programs would not
//! stumble over: there the very header row that is to be written is the mark. A bare array of
//! numbers has room for nothing: there every file counts as foreign.

use std::borrow::Cow;
use std::io::{self, Read};
use std::path::Path;

/// Is what any version writes into its files, its number following.
const MARK: &str = "harmolux ";

/// How far into a file the mark is looked for, bytes.
const MARKED_WITHIN: u64 = 1024;

/// Describes a kind of file: its extensions, and how to tell one that this program wrote.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kind {
    pub(in crate::io) name: &'static str,
    pub(in crate::io) extensions: &'static [&'static str],
    pub(super) start: Cow<'static, [u8]>,
    pub(super) mark: Mark,
}

/// Names what shows that a file is ours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    /// How it begins, and the name of this program.
    Name,
    /// How it begins.
    Start,
    /// Nothing can.
    Nothing,
}

impl Kind {
    /// A PNG image.
    pub const PNG: Self = Self::new("a PNG image", &["png"], b"\x89PNG\r\n\x1a\n");
    /// An SVG drawing.
    pub const SVG: Self = Self::new("an SVG drawing", &["svg"], b"<svg");
    /// An `OpenEXR` image.
    pub const EXR: Self = Self::new("an EXR image", &["exr"], &[0x76, 0x2f, 0x31, 0x01]);
    /// An array of NumPy, which has no room for a mark.
    pub const NPY: Self = Self::unmarked("an array of NumPy", &["npy"]);
    /// A coefficient text in the layout of pyshtools.
    pub const COEFFICIENTS: Self = Self::new("a coefficient text", &["txt", "sh"], b"# harmolux ");
    /// A page as HTML.
    pub const HTML: Self =
        Self::new("an HTML page", &["html", "htm"], b"<!doctype html>\n<!-- harmolux ");
    /// A table or report as JSON.
    pub const JSON: Self = Self::new("a JSON file", &["json"], b"{");

    /// Describes files that begin with the bytes `start` and hold "harmolux VERSION" within their
    /// first KiB; `name` is a noun with its article ("a PNG image"), `extensions` are lower-case
    /// without dot, the usual one first.
    pub const fn new(
        name: &'static str,
        extensions: &'static [&'static str],
        start: &'static [u8],
    ) -> Self {
        Self { name, extensions, start: Cow::Borrowed(start), mark: Mark::Name }
    }

    /// Describes files that have no room for the name of a program: what stands there is never
    /// taken for ours.
    pub const fn unmarked(name: &'static str, extensions: &'static [&'static str]) -> Self {
        Self { name, extensions, start: Cow::Borrowed(&[]), mark: Mark::Nothing }
    }

    /// Describes files that begin with bytes no other program writes.
    pub const fn signed(
        name: &'static str,
        extensions: &'static [&'static str],
        start: &'static [u8],
    ) -> Self {
        Self { name, extensions, start: Cow::Borrowed(start), mark: Mark::Start }
    }

    /// Describes CSV tables whose header row is the given line, its end included.
    pub fn csv(header: Vec<u8>) -> Self {
        Self {
            name: "a CSV table",
            extensions: &["csv"],
            start: Cow::Owned(header),
            mark: Mark::Start,
        }
    }

    /// Whether this program wrote what `file` holds from here on.
    pub(super) fn wrote(&self, file: impl Read) -> io::Result<bool> {
        let mut head = Vec::new();
        file.take(MARKED_WITHIN.max(self.start.len() as u64)).read_to_end(&mut head)?;
        Ok(self.owns(&head))
    }

    /// Whether a file with these first bytes was written by this program.
    fn owns(&self, head: &[u8]) -> bool {
        let mark = MARK.as_bytes();
        let named = |w: &[u8]| w.starts_with(mark) && w.last().is_some_and(u8::is_ascii_digit);
        let marked = match self.mark {
            Mark::Name => head.windows(mark.len() + 1).any(named),
            Mark::Start => true,
            Mark::Nothing => false,
        };
        marked && head.starts_with(&self.start)
    }

    pub(super) fn fits(&self, path: &Path) -> bool {
        path.extension()
            .and_then(|found| found.to_str())
            .is_some_and(|found| self.extensions.iter().any(|e| e.eq_ignore_ascii_case(found)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mark_counts_only_in_the_first_kilobyte() {
        let near = [b"{".as_slice(), &[b' '; 500], b"\"harmolux 9.9.9\""].concat();
        let far = [b"{".as_slice(), &[b' '; 1020], b"\"harmolux 9.9.9\""].concat();
        assert!(Kind::JSON.owns(&near));
        assert!(!Kind::JSON.owns(&far[..1024]));
        assert!(!Kind::JSON.owns(b"[\"harmolux 9.9.9\"]"));
        assert!(!Kind::JSON.owns(b"{ \"tool\": \"harmolux is not mine\" }"));
    }
}
