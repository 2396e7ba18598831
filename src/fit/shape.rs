//! A shape as its file holds it: the series of its radius, and what accompanies that.

use std::fmt;
use std::path::Path;

use glam::DVec3;

use crate::sh::Coefficients;

/// Holds a star-shaped surface as its file does: the radius, metres, as a series about a centre,
/// and where it comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// The series of the radius, metres.
    pub coefficients: Coefficients,
    /// The expansion centre in the axes of the source, metres.
    pub centre: DVec3,
    /// The file that was expanded, when known.
    pub source: Option<Source>,
    /// The degree of the fit, when the series was cut below it afterwards.
    pub truncated_from: Option<usize>,
}

impl Shape {
    /// Wraps a series about the origin of unknown source.
    pub const fn new(coefficients: Coefficients) -> Self {
        Self { coefficients, centre: DVec3::ZERO, source: None, truncated_from: None }
    }

    /// Cuts the series at `lmax`, and remembers the degree of the fit.
    pub fn truncated(&self, lmax: usize) -> Self {
        let degree = self.coefficients.lmax();
        if lmax >= degree {
            return self.clone();
        }
        Self {
            coefficients: self.coefficients.truncated(lmax),
            truncated_from: Some(self.truncated_from.unwrap_or(degree)),
            ..self.clone()
        }
    }
}

/// Names a file by its name and content.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// The file name, without folders.
    pub name: String,
    /// The fingerprint of its bytes.
    pub hash: SourceHash,
}

impl Source {
    /// Takes the file name of `path` and the fingerprint of `bytes`.
    pub fn new(path: &Path, bytes: &[u8]) -> Self {
        Self::of_file(path, SourceHash::of(bytes))
    }

    /// Takes the file name of `path`, and the fingerprint of what the file holds.
    pub(crate) fn of_file(path: &Path, hash: SourceHash) -> Self {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Self { name, hash }
    }
}

/// Fingerprints bytes by 64-bit FNV-1a (RFC 9923): tells whether a file has changed, not whether
/// someone meant harm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SourceHash(pub(crate) u64);

impl SourceHash {
    /// Computes the fingerprint.
    pub fn of(bytes: &[u8]) -> Self {
        Self(0xcbf2_9ce4_8422_2325).followed_by(bytes)
    }

    /// Returns the fingerprint of what this one is of and of the bytes that follow it.
    pub(crate) fn followed_by(self, bytes: &[u8]) -> Self {
        Self(bytes.iter().fold(self.0, |hash, byte| {
            (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
        }))
    }

    /// Reads what Display writes; `None` for anything else.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let digits = text.strip_prefix("fnv1a64:").filter(|d| d.len() == 16)?;
        u64::from_str_radix(digits, 16).ok().map(Self)
    }
}

impl fmt::Display for SourceHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fnv1a64:{:016x}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fingerprint_is_that_of_the_published_test_vectors() {
        assert_eq!(SourceHash::of(b"").to_string(), "fnv1a64:cbf29ce484222325");
        assert_eq!(SourceHash::of(b"foobar").to_string(), "fnv1a64:85944171f73967e8");
        assert_eq!(SourceHash::of(b"foo").followed_by(b"bar"), SourceHash::of(b"foobar"));
        assert_eq!(SourceHash::parse("fnv1a64:85944171f73967e8"), Some(SourceHash::of(b"foobar")));
        assert_eq!(SourceHash::parse("fnv1a64:85944171"), None);
        assert_eq!(SourceHash::parse("85944171f73967e8"), None);
    }

    #[test]
    fn cut_shape_remembers_the_first_degree() {
        let shape = Shape::new(Coefficients::zeros(8));
        assert_eq!(shape.truncated(9), shape);
        let cut = shape.truncated(6).truncated(4);
        assert_eq!((cut.coefficients.lmax(), cut.truncated_from), (4, Some(8)));
    }
}
