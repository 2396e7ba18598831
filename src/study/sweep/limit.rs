//! Which degree is enough: the smallest whose line keeps a limit.

use std::fmt;
use std::str::FromStr;

use super::row::{Column, Rendition, SweepRow};
use crate::math::Unit;
use crate::{Error, Result};

/// A limit that a degree is to keep.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepLimit {
    /// What is limited.
    pub column: Column,
    /// The most it may be, without its sign, in the unit of the column (a share of 1 for "%").
    pub at_most: f64,
    /// As it was written.
    written: String,
}

/// The names of limits: what they limit, and an example.
const NAMES: [(&str, Column, &str); 10] = [
    ("rms", Column::RelativeRms, "rms=0.5%"),
    ("max", Column::RelativeMax, "max=2%"),
    ("hausdorff", Column::HausdorffUpper, "hausdorff=2mm"),
    ("normal", Column::Normal95, "normal=3deg"),
    ("volume", Column::VolumeError, "volume=0.1%"),
    ("area", Column::AreaError, "area=1%"),
    ("inertia", Column::InertiaError, "inertia=1%"),
    ("relmse", Column::RelMse, "relmse=1e-3"),
    ("flip", Column::Flip, "flip=0.05"),
    ("lux", Column::LuxMax, "lux=1%"),
];

impl SweepLimit {
    /// Finds the smallest degree of the lines that keeps the limit.
    pub fn answer<'a>(&self, rows: &'a [SweepRow]) -> Option<&'a SweepRow> {
        let kept = |row: &&SweepRow| row[self.column].abs() <= self.at_most;
        let series = rows.iter().filter(|row| row.rendition == Rendition::Series);
        series.filter(kept).min_by_key(|row| row.degree)
    }
}

impl SweepLimit {
    /// Finds what noise alone makes of the limited quantity, the least of the lines, where that is
    /// known and more than the limit: no degree can keep it.
    pub fn noise_above(&self, rows: &[SweepRow]) -> Option<f64> {
        let noise = match self.column {
            Column::RelMse => Column::RelMseNoise,
            Column::Flip => Column::FlipNoise,
            Column::LuxMax => Column::LuxNoise,
            _ => return None,
        };
        let least = rows.iter().map(|row| row[noise].abs()).filter(|noise| !noise.is_nan());
        least.reduce(f64::min).filter(|noise| *noise > self.at_most)
    }
}

impl fmt::Display for SweepLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.written)
    }
}

impl FromStr for SweepLimit {
    type Err = Error;

    /// Reads a name and a value with its unit: rms=0.5%, hausdorff=2mm, normal=3deg, relmse=1e-3.
    fn from_str(text: &str) -> Result<Self> {
        let wrong = |why: String| Error::Parameter(format!("`{text}`: {why}"));
        let Some((name, value)) = text.split_once('=') else {
            return Err(wrong("write NAME=VALUE, such as rms=0.5%".to_owned()));
        };
        let Some((_, column, example)) = NAMES.into_iter().find(|(own, ..)| *own == name.trim())
        else {
            let names = NAMES.map(|(name, ..)| name).join(", ");
            return Err(wrong(format!("there is no limit of this name: use one of {names}")));
        };
        let value = value.trim();
        let lengths = Unit::ALL.map(|unit| (unit.name(), unit.metres()));
        let units = match column.unit() {
            "%" => &[("%", 0.01)],
            "m" => &lengths[..],
            "deg" => &[("deg", 1.0)],
            _ => &[],
        };
        let read = units.iter().chain(&[("", 1.0)]).find_map(|(unit, factor)| {
            let number = value.strip_suffix(unit)?.trim().parse::<f64>().ok()?;
            (number >= 0.0 && number.is_finite()).then_some(number * factor)
        });
        let at_most = read.ok_or_else(|| wrong(format!("write a number such as {example}")))?;
        Ok(Self { column, at_most, written: format!("{} <= {value}", name.trim()) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(degree: usize, rms: f64) -> SweepRow {
        let mut row = SweepRow::new(Rendition::Series, Some(degree));
        row[Column::RelativeRms] = rms;
        row
    }

    #[test]
    fn smallest_degree_that_keeps_a_limit_is_found() -> Result<()> {
        let rows = [row(8, 0.004), row(2, 0.1), row(4, 0.005)];
        let limit: SweepLimit = "rms = 0.5%".parse()?;
        assert_eq!(limit.answer(&rows).and_then(|row| row.degree), Some(4));
        assert_eq!("rms=0.001".parse::<SweepLimit>()?.answer(&rows), None);
        assert_eq!("lux=1%".parse::<SweepLimit>()?.answer(&rows), None);
        let mut noisy = rows.to_vec();
        noisy[0][Column::LuxNoise] = 0.11;
        assert_eq!("lux=1%".parse::<SweepLimit>()?.noise_above(&noisy), Some(0.11));
        assert_eq!("lux=20%".parse::<SweepLimit>()?.noise_above(&noisy), None);
        assert_eq!(limit.noise_above(&noisy), None);
        Ok(())
    }

    #[test]
    fn limits_have_their_units() -> Result<()> {
        for (text, value) in [
            ("hausdorff=2mm", 2e-3),
            ("hausdorff=2", 2.0),
            ("normal=3deg", 3.0),
            ("relmse=1e-3", 1e-3),
            ("volume=50%", 0.5),
        ] {
            let limit: SweepLimit = text.parse()?;
            assert!((limit.at_most - value).abs() <= 1e-15, "{text}");
        }
        for text in ["rms", "rms=", "rms=-1%", "rms=2mm", "size=1", "relmse=1%", "rms=nan"] {
            assert!(text.parse::<SweepLimit>().is_err(), "{text}");
        }
        for (_, _, example) in NAMES {
            example.parse::<SweepLimit>()?;
        }
        Ok(())
    }
}
