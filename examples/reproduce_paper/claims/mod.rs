//! The claims of the paper, group by group, and what all of them have.

mod basis;
mod double;
mod figure_2;
mod figure_3;
mod formats;
mod head;
mod luminance;
mod normals;
mod one_walk;
mod radiosity;
mod rays;
mod sobolev;
mod time;

use std::ops::ControlFlow;
use std::path::PathBuf;

use harmolux::Result;
use harmolux::estimators::Progress;
use harmolux::fit::{Fit, FitSettings, fit};
use harmolux::io::meshes;
use harmolux::mesh::Mesh;

use crate::figures::Picture;

/// Makes the claims of a group.
type Group = fn(&Run) -> Result<Vec<Claim>>;

/// The groups in the order of the paper.
pub(crate) const GROUPS: [(&str, Group); 13] = [
    ("one_walk", one_walk::claims),
    ("figure_2", figure_2::claims),
    ("radiosity", radiosity::claims),
    ("luminance", luminance::claims),
    ("head", head::claims),
    ("normals", normals::claims),
    ("figure_3", figure_3::claims),
    ("time", time::claims),
    ("storage", formats::claims),
    ("sobolev", sobolev::claims),
    ("double", double::claims),
    ("basis", basis::claims),
    ("rays", rays::claims),
];

/// The degree that "32 harmonics" are read as.
pub(crate) const DEGREE: usize = 32;

/// Holds what all groups need.
pub(crate) struct Run {
    /// Whether more time may be taken.
    pub(crate) full: bool,
    pub(crate) mesh: Mesh,
    /// The mesh as a series of degree [`DEGREE`].
    pub(crate) head: Fit,
}

impl Run {
    pub(crate) fn new(full: bool) -> Result<Self> {
        let mesh = meshes::read(&data("head.obj"))?;
        let head = fit(&mesh, &FitSettings::of_degree(DEGREE))?;
        Ok(Self { full, mesh, head })
    }

    /// Returns the first for a quick run, the second for a full one.
    pub(crate) fn choose<T>(&self, quick: T, full: T) -> T {
        if self.full { full } else { quick }
    }
}

/// Holds one claim of the paper and what became of it.
pub(crate) struct Claim {
    pub(crate) title: &'static str,
    /// The paper's words, in English.
    pub(crate) paper_words: &'static str,
    /// Where they stand.
    pub(crate) place: &'static str,
    pub(crate) paper_number: String,
    pub(crate) ours: String,
    pub(crate) error: String,
    /// What shows it.
    pub(crate) command: String,
    pub(crate) verdict: Verdict,
    /// How it was done and what else was found, a paragraph each.
    pub(crate) notes: Vec<String>,
    pub(crate) table: Option<Table>,
    pub(crate) picture: Option<Picture>,
}

/// Holds rows of cells under a head.
pub(crate) struct Table {
    pub(crate) head: Vec<&'static str>,
    pub(crate) rows: Vec<Vec<String>>,
}

/// Says what became of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    Confirmed,
    Corrected,
    Differs,
    NotReproduced,
}

impl Verdict {
    pub(crate) const ALL: [Self; 4] =
        [Self::Confirmed, Self::Corrected, Self::Differs, Self::NotReproduced];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Confirmed => "confirmed",
            Self::Corrected => "confirmed with a correction",
            Self::Differs => "differs",
            Self::NotReproduced => "not reproduced",
        }
    }

    pub(crate) const fn meaning(self) -> &'static str {
        match self {
            Self::Confirmed => "holds as it stands, within the error",
            Self::Corrected => {
                "fails as it is printed, and holds with the correction that is named"
            }
            Self::Differs => "the direction is right, the number is another",
            Self::NotReproduced => "what we find contradicts it",
        }
    }

    /// Judges a statement that holds as it stands or not at all.
    pub(crate) const fn of(holds: bool) -> Self {
        if holds { Self::Confirmed } else { Self::NotReproduced }
    }

    /// Judges a statement that may need a correction.
    pub(crate) const fn of_printed(holds: bool, holds_corrected: bool) -> Self {
        match (holds, holds_corrected) {
            (true, _) => Self::Confirmed,
            (false, true) => Self::Corrected,
            (false, false) => Self::NotReproduced,
        }
    }

    /// Judges a number by ranges that overlap or not, and by whether its direction is right.
    pub(crate) fn of_number(paper: [f64; 2], ours: [f64; 2], same_direction: bool) -> Self {
        match (ours[0] <= paper[1] && ours[1] >= paper[0], same_direction) {
            (true, _) => Self::Confirmed,
            (false, true) => Self::Differs,
            (false, false) => Self::NotReproduced,
        }
    }
}

/// Holds the check of an equation: by how much it fails, relative to its largest value.
pub(crate) struct Equation {
    pub(crate) title: &'static str,
    pub(crate) printed_words: &'static str,
    /// What is set right; `None` where the printed form is checked alone.
    pub(crate) correction: Option<&'static str>,
    /// By how much the printed form is off.
    pub(crate) printed: f64,
    /// By how much the corrected one is off.
    pub(crate) corrected: Option<f64>,
    /// What rounding and the check itself may leave.
    pub(crate) tolerance: f64,
    /// What was compared with what.
    pub(crate) check: String,
    pub(crate) command: &'static str,
}

impl From<Equation> for Claim {
    fn from(e: Equation) -> Self {
        // NaN holds nothing.
        let holds = |off: f64| off <= e.tolerance;
        let correction = e.correction.map(|text| format!("Correction: {text}"));
        Self {
            title: e.title,
            paper_words: e.printed_words,
            place: "as printed",
            paper_number: format!("printed: off by {}", exponent(e.printed)),
            ours: match e.corrected {
                Some(off) => format!("corrected: off by {}", exponent(off)),
                None => "the printed form".to_owned(),
            },
            error: format!("tolerance {}", exponent(e.tolerance)),
            command: e.command.to_owned(),
            verdict: Verdict::of_printed(holds(e.printed), e.corrected.is_some_and(holds)),
            notes: correction.into_iter().chain([e.check]).collect(),
            table: None,
            picture: None,
        }
    }
}

/// Returns the path of a file of `data`.
pub(crate) fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

/// Lets a run go on.
pub(crate) fn go_on(_: &Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Returns the command that runs one group.
pub(crate) fn by_group(name: &str) -> String {
    format!("cargo run --release --example reproduce_paper -- -o out --only {name}")
}

/// Writes a number with this many significant digits.
pub(crate) fn digits(x: f64, count: i32) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let decimals = (count - 1 - x.abs().log10().floor() as i32).max(0);
    format!("{x:.*}", decimals as usize)
}

/// Writes a share as a percentage.
pub(crate) fn percent(share: f64, count: i32) -> String {
    format!("{} %", digits(100.0 * share, count))
}

/// Writes a number with two digits, very small and large ones with a power of ten.
pub(crate) fn exponent(x: f64) -> String {
    match x {
        0.0 => "0".to_owned(),
        x if (0.01..1000.0).contains(&x) => digits(x, 2),
        x => format!("{x:.1e}"),
    }
}

/// Writes a whole number in groups of three digits.
pub(crate) fn grouped(n: usize) -> String {
    if n < 1000 { n.to_string() } else { format!("{} {:03}", grouped(n / 1000), n % 1000) }
}

/// Returns the largest of some numbers; NaN where one is.
pub(crate) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |worst, x| if x.is_nan() || x > worst { x } else { worst })
}
