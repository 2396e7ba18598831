//! The page: what was run, when and where, a summary, and the claims one by one.

use std::fs;
use std::path::Path;
use std::time::Duration;

use crate::claims::{Claim, Verdict};
use crate::{html, machine, markdown};

/// Holds what the page shows.
pub(crate) struct Page {
    pub(crate) claims: Vec<Claim>,
    pub(crate) full: bool,
    /// The only group that was run, if not all were.
    pub(crate) only: Option<String>,
    pub(crate) took: Duration,
}

pub(crate) const TITLE: &str = "The paper of 2012, claim by claim";

const PAPER: &str = "V. P. Budak, V. S. Zheltov, T. K. Kalakutsky, \"Local estimations of Monte \
     Carlo method with the object spectral representation in the solution of global \
     illumination\", Computer Research and Modeling 4(1), 2012, 75-84 (in Russian; quoted here in English).";

impl Page {
    /// Writes the page in both forms, and its figures beside it.
    pub(crate) fn write(&self, folder: &Path) -> std::io::Result<()> {
        fs::create_dir_all(folder)?;
        for picture in self.claims.iter().filter_map(|claim| claim.picture.as_ref()) {
            fs::write(folder.join(picture.name), &picture.bytes)?;
        }
        fs::write(folder.join("paper.md"), markdown::page(self))?;
        fs::write(folder.join("paper.html"), html::page(self))
    }

    /// Returns the command that makes the page.
    pub(crate) fn command(&self) -> String {
        let full = if self.full { " --full" } else { "" };
        let only = self.only.as_ref().map_or(String::new(), |group| format!(" --only {group}"));
        format!("cargo run --release --example reproduce_paper -- -o docs{full}{only}")
    }

    /// Returns the paragraphs above the summary.
    pub(crate) fn introduction(&self) -> [String; 4] {
        let kind = if self.full { "full" } else { "quick" };
        [
            PAPER.to_owned(),
            "Each claim is run through the public library, with the paper's words and number, ours \
             with its error, and a command that shows it. The verdict is chosen by the program \
             from the numbers."
                .to_owned(),
            format!(
                "A {kind} run of {:.0} s on {}. {}.",
                self.took.as_secs_f64(),
                machine::date(),
                machine::description()
            ),
            "Misprints that no number shows: (1) and (4) lack primes on what is integrated over, \
             and in (10) d3r is d2r."
                .to_owned(),
        ]
    }

    /// Returns the rows of the summary: claim, the paper, ours, verdict.
    pub(crate) fn summary(&self) -> Vec<[String; 4]> {
        let row = |c: &Claim| {
            let verdict = c.verdict.name().to_owned();
            [c.title.to_owned(), c.paper_number.clone(), c.ours.clone(), verdict]
        };
        self.claims.iter().map(row).collect()
    }

    /// Returns the meaning of each verdict, with how many claims have it.
    pub(crate) fn verdicts(&self) -> Vec<[String; 3]> {
        let of = |verdict: Verdict| self.claims.iter().filter(|c| c.verdict == verdict).count();
        Verdict::ALL
            .map(|v| [v.name().to_owned(), of(v).to_string(), v.meaning().to_owned()])
            .to_vec()
    }
}

/// Returns the lines that every claim has, with their heads.
pub(crate) fn lines(claim: &Claim) -> [(&'static str, String); 4] {
    [
        ("The paper", claim.paper_number.clone()),
        ("Ours", claim.ours.clone()),
        ("Error", claim.error.clone()),
        ("Verdict", claim.verdict.name().to_owned()),
    ]
}
