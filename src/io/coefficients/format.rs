//! The formats of coefficient files: their names, extensions and conventions. Each is read and
//! written in a file of its own.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use super::{binary, compact};
use crate::io::output::Kind;
use crate::sh::{CondonShortley, Convention, Normalisation};
use crate::{Error, Result};

/// Names a format of coefficient files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SeriesFormat {
    /// The text of pyshtools ("shtools"): `l, m, C, S`; ours says its convention in comments.
    Text,
    /// The text of pyshtools ("dov"): `l, m, value`, sines at negative orders.
    Dov,
    /// The binary of Curtin University that pyshtools reads: degrees, then all cosines, then all
    /// sines.
    Bshc,
    /// The array of pyshtools, (2, lmax+1, lmax+1), in NumPy's file.
    Npy,
    /// The complex a_lm of healpy and ducc0, order by order, in NumPy's file.
    Alm,
    /// The complex a_lm of healpy in FITS. It is read only.
    Fits,
    /// The x, y, z set of SPHARM-PDM and SlicerSALT.
    SpharmPdm,
    /// The table of aics-shparam: a column for each coefficient, a row for each shape.
    Aics,
    /// Our table: a column for each coefficient, a row for each shape.
    Table,
    /// The ASCII data record of NASA's Planetary Data System.
    Shadr,
    /// The table of the International Centre for Global Earth Models. It is read only.
    Icgem,
    /// Our binary form.
    Binary,
    /// Our compact form.
    Compact,
}

impl SeriesFormat {
    /// Lists all.
    pub const ALL: [Self; 13] = [
        Self::Text,
        Self::Dov,
        Self::Bshc,
        Self::Npy,
        Self::Alm,
        Self::Fits,
        Self::SpharmPdm,
        Self::Aics,
        Self::Table,
        Self::Shadr,
        Self::Icgem,
        Self::Binary,
        Self::Compact,
    ];

    /// Returns the name used on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Dov => "dov",
            Self::Bshc => "bshc",
            Self::Npy => "npy",
            Self::Alm => "alm",
            Self::Fits => "fits",
            Self::SpharmPdm => "spharm-pdm",
            Self::Aics => "aics",
            Self::Table => "table",
            Self::Shadr => "shadr",
            Self::Icgem => "icgem",
            Self::Binary => "binary",
            Self::Compact => "compact",
        }
    }

    /// Returns a noun for messages, with its article.
    pub const fn noun(self) -> &'static str {
        match self {
            Self::Text => "a coefficient text",
            Self::Dov => "a coefficient text with signed orders",
            Self::Bshc => "a bshc file",
            Self::Npy => "an array of coefficients",
            Self::Alm => "an array of complex a_lm",
            Self::Fits => "a FITS table of complex a_lm",
            Self::SpharmPdm => "a SPHARM-PDM file",
            Self::Aics => "an aics-shparam table",
            Self::Table => "a table of shapes",
            Self::Shadr => "a SHADR table",
            Self::Icgem => "an ICGEM table",
            Self::Binary => "a binary coefficient file",
            Self::Compact => "a compact coefficient file",
        }
    }

    /// Lists the extensions, lower-case, without dot, the usual one first.
    pub const fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Text => &["txt", "sh"],
            Self::Dov => &["dov"],
            Self::Bshc => &["bshc"],
            Self::Npy | Self::Alm => &["npy"],
            Self::Fits => &["fits"],
            Self::SpharmPdm => &["coef"],
            Self::Aics | Self::Table => &["csv"],
            Self::Shadr => &["tab", "sha"],
            Self::Icgem => &["gfc"],
            Self::Binary => &["hxb"],
            Self::Compact => &["hxc"],
        }
    }

    /// Finds the format that an extension stands for; `.npy` stands for the array of pyshtools.
    pub fn of_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        Self::ALL.into_iter().find(|format| format.extensions().contains(&extension.as_str()))
    }

    /// Describes the file to write: what it may be called, and which file may be replaced.
    pub const fn kind(self) -> Kind {
        match self {
            Self::Text => Kind::COEFFICIENTS,
            Self::Dov => Kind::new(self.noun(), self.extensions(), b"# harmolux "),
            Self::Aics => Kind::new(self.noun(), self.extensions(), b"harmolux "),
            Self::Shadr => Kind::new(self.noun(), self.extensions(), b" "),
            Self::Binary => Kind::signed(self.noun(), self.extensions(), &binary::MAGIC),
            Self::Compact => Kind::signed(self.noun(), self.extensions(), &compact::MAGIC),
            _ => Kind::unmarked(self.noun(), self.extensions()),
        }
    }

    /// Returns the one convention that the format has by its definition; `None` where the file or
    /// the reader must say it.
    pub const fn convention(self) -> Option<Convention> {
        let orthonormal =
            Convention { normalisation: Normalisation::Orthonormal, phase: CondonShortley::With };
        match self {
            Self::Alm | Self::Fits | Self::SpharmPdm => Some(orthonormal),
            // The table's longitude is counted from -x: the turn by pi is the sign (-1)^m.
            Self::Aics => Some(Convention {
                normalisation: Normalisation::FourPi,
                phase: CondonShortley::With,
            }),
            _ => None,
        }
    }
}

impl SeriesFormat {
    /// Whether a file of this format has room for the centre of the shape.
    pub const fn keeps_centre(self) -> bool {
        matches!(self, Self::SpharmPdm | Self::Table) || self.keeps_source()
    }

    /// Whether a file of this format has room for the source of the shape and the degree it was cut
    /// from.
    pub const fn keeps_source(self) -> bool {
        matches!(self, Self::Text | Self::Dov | Self::Binary | Self::Compact)
    }

    /// Whether a file of this format holds many shapes, a row each.
    pub const fn has_rows(self) -> bool {
        matches!(self, Self::Aics | Self::Table)
    }

    /// Whether files of this format are written, not only read.
    pub const fn is_written(self) -> bool {
        !matches!(self, Self::Fits | Self::Icgem)
    }

    /// Makes sure that files of this format are written.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a format that is read only.
    pub fn require_written(self) -> Result<()> {
        if self.is_written() { Ok(()) } else { Err(self.read_only()) }
    }

    /// Returns the error that files of this format are not written.
    pub(super) fn read_only(self) -> Error {
        let instead = match self {
            Self::Fits => "an array of complex a_lm, alm (.npy)",
            _ => "a coefficient text, text (.txt)",
        };
        Error::Parameter(format!("{} is read here and not written: write {instead}", self.noun()))
    }

    /// Whether numbers are rounded to a tolerance.
    pub const fn is_lossy(self) -> bool {
        matches!(self, Self::Compact)
    }

    /// Whether a reader knows the convention of a file without being told.
    pub const fn says_convention(self) -> bool {
        !matches!(self, Self::Bshc | Self::Npy)
    }
}

impl fmt::Display for SeriesFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for SeriesFormat {
    type Err = Error;

    /// Reads the name used on the command line; [`Error::Parameter`] for any other word.
    fn from_str(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name).ok_or_else(|| {
            let names: Vec<_> = Self::ALL.iter().map(|format| format.name()).collect();
            Error::Parameter(format!(
                "`{name}` is not a format of coefficients: use one of {}",
                names.join(", ")
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_extensions_are_found_again() {
        for format in SeriesFormat::ALL {
            assert_eq!(format.name().parse::<SeriesFormat>().expect("a name"), format);
            for extension in format.extensions() {
                let path = format!("a.b/head.{}", extension.to_ascii_uppercase());
                let found = SeriesFormat::of_extension(Path::new(&path)).expect("an extension");
                assert_eq!(found.extensions(), format.extensions());
            }
        }
        for (format, instead) in
            [(SeriesFormat::Fits, "alm (.npy)"), (SeriesFormat::Icgem, "text (.txt)")]
        {
            let message = format.require_written().expect_err("read only").to_string();
            assert!(message.ends_with(instead), "{message}");
        }
        assert!("shtool".parse::<SeriesFormat>().is_err());
        assert_eq!(SeriesFormat::of_extension(Path::new("head.obj")), None);
        assert_eq!(SeriesFormat::of_extension(Path::new("head")), None);
    }
}
