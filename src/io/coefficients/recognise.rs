//! Which format a file has: told by its content, where that leaves a choice by its extension.

use std::path::Path;

use super::{
    SeriesFormat, aics_csv, alm_fits, binary, bshc, compact, dov, icgem, shadr, shape_table,
    spharm_pdm,
};
use crate::io::{meshes, npy, points};

/// How much of a text is looked at, bytes.
const HEAD: usize = 4096;

/// Degree and order of the first rows, with signed orders all of them, of others the first three.
pub(super) const PLACES: [[&str; 2]; 4] = [["0", "0"], ["1", "0"], ["1", "1"], ["1", "-1"]];

/// Returns the format of a coefficient file from its content and, for a text or for bytes without a
/// sign of their own, its extension; `None` when neither is that of a coefficient file.
pub fn recognise(path: &Path, bytes: &[u8]) -> Option<SeriesFormat> {
    recognise_content(bytes, bytes.len() as u64).or_else(|| SeriesFormat::of_extension(path))
}

/// Returns the format by the beginning of a file, 64 KiB or all of it, and its length; `None` when
/// that says nothing. What bears the sign of a mesh is none: rows of numbers say less.
pub fn recognise_content(head: &[u8], length: u64) -> Option<SeriesFormat> {
    if head.starts_with(&binary::MAGIC) {
        return Some(SeriesFormat::Binary);
    }
    if head.starts_with(&compact::MAGIC) {
        return Some(SeriesFormat::Compact);
    }
    if head.starts_with(npy::MAGIC) {
        return Some(array(head));
    }
    if head.starts_with(alm_fits::MAGIC) {
        return Some(SeriesFormat::Fits);
    }
    if bshc::is_bshc(head, length) {
        return Some(SeriesFormat::Bshc);
    }
    if meshes::recognise(head, length).is_some() {
        return None;
    }
    text(head)
}

/// Returns complex numbers from real ones.
fn array(head: &[u8]) -> SeriesFormat {
    if npy::is_complex_list(head) { SeriesFormat::Alm } else { SeriesFormat::Npy }
}

/// Returns the texts apart by how they begin.
fn text(bytes: &[u8]) -> Option<SeriesFormat> {
    // A table of shapes has its whole header in one line, longer than what tells the others.
    let line = bytes.split(|b| *b == b'\n').next().unwrap_or(bytes);
    let head = bytes.get(..HEAD.max(line.len()).min(bytes.len())).unwrap_or(bytes);
    let whole = bytes.utf8_chunks().next().map_or("", |chunk| chunk.valid());
    let valid = head.utf8_chunks().next().map_or("", |chunk| chunk.valid());
    let head = valid.strip_prefix('\u{feff}').unwrap_or(valid);
    if whole.contains('\0') {
        return None;
    }
    if icgem::is_icgem(whole) {
        Some(SeriesFormat::Icgem)
    } else if spharm_pdm::is_spharm_pdm(head) {
        Some(SeriesFormat::SpharmPdm)
    } else if aics_csv::is_aics(head) {
        Some(SeriesFormat::Aics)
    } else if shape_table::is_table(head) {
        Some(SeriesFormat::Table)
    } else if points::names_columns(bytes) {
        None
    } else if shadr::is_shadr(head) {
        Some(SeriesFormat::Shadr)
    } else if dov::is_dov(head) {
        Some(SeriesFormat::Dov)
    } else {
        is_text(head).then_some(SeriesFormat::Text)
    }
}

/// Returns a coefficient text by our title, or by its rows `0, 0, C`, `1, 0, C` and, if there is
/// one more, `1, 1, C`.
fn is_text(head: &str) -> bool {
    use super::rows::{begins, lines};
    let mut rows = lines(head).skip(super::shtools_text::header_lines(head));
    let mut starts = |place| rows.next().is_some_and(|(line, _)| begins(line, place));
    let [first, second, third, _] = PLACES;
    super::annotated::is_ours(head)
        || starts(first)
            && starts(second)
            && rows.next().is_none_or(|(line, _)| begins(line, third))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::Shape;
    use crate::io::coefficients::{WriteOptions, encode};
    use crate::sh::Coefficients;

    #[test]
    fn every_format_is_told_by_its_content() {
        let mut c = Coefficients::zeros(3);
        c.set(0, 0, 1.0, 0.0);
        for format in SeriesFormat::ALL.into_iter().filter(|f| f.is_written()) {
            let bytes = encode(&Shape::new(c.clone()), format, &WriteOptions::default())
                .expect("fits every format");
            assert_eq!(recognise(Path::new("a"), &bytes), Some(format), "{format}");
        }
    }

    #[test]
    fn bare_texts_are_told_by_their_rows() {
        for (text, expected) in [
            ("0 0 1\n1 0 1\n1 1 1 1\n", Some(SeriesFormat::Text)),
            ("1738.0, 4.9\n0,0,1,0\n1,0,1,0\n", Some(SeriesFormat::Text)),
            ("0 0 1\n1 0 1\n1 1 1\n1 -1 1\n", Some(SeriesFormat::Dov)),
            ("{ 4,{0,0,0}", Some(SeriesFormat::SpharmPdm)),
            ("1 2 3\nradius 1.0\nend_of_head ==\ngfc 0 0 1 0\n", Some(SeriesFormat::Icgem)),
            ("SIMPLE  =                    T", Some(SeriesFormat::Fits)),
            ("v 0 0 0\n", None),
            ("OFF\n3 1 0\n", None),
            ("{\"asset\": {}}", None),
            ("", None),
            ("hello", None),
        ] {
            assert_eq!(recognise(Path::new("a"), text.as_bytes()), expected, "{text}");
        }
        assert_eq!(recognise(Path::new("a.txt"), b"hello"), Some(SeriesFormat::Text));
        assert_eq!(recognise(Path::new("a.bshc"), b"\0\0"), Some(SeriesFormat::Bshc));
    }
}
