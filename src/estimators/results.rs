//! What a survey found.

use std::time::Duration;

use super::replicates::{Ending, REPLICATES};
use crate::scene::Measured;

/// Holds a finished survey and how it came about.
#[derive(Debug, Clone)]
pub struct Survey {
    /// One result per sensor; [`Measured::UNKNOWN`] where the time was up before any walk was
    /// served to it.
    pub results: Vec<Measured>,
    /// What each sensor received in each replicate, lx; sensors share their walks, so that
    /// replicates of one number belong together. NaN by radiosity.
    pub replicates: Vec<[f64; REPLICATES]>,
    /// Why the run ended.
    pub ending: Ending,
    /// Walks in all; the shots of radiosity.
    pub walks: u64,
    /// The share of the walks' flux that left an open scene; NaN where there are no walks of light
    /// to tell.
    pub escaped: f64,
    /// The share of all light that point lights shed on mirrors and these send on. A sensor gets
    /// none of that straight: no estimate finds a point in a mirror. A light with an extent has no
    /// such share.
    pub caustic: f64,
    /// The time it took.
    pub elapsed: Duration,
    /// How the patches exchanged light, by radiosity; then no result has a known error.
    pub radiosity: Option<Exchange>,
}

impl Survey {
    /// Returns the survey of some sensors the places they have among all: those of which `counts`
    /// is true, in order. The others have measured NaN.
    pub fn scattered(self, counts: &[bool]) -> Self {
        let unknown = (Measured::UNKNOWN, [f64::NAN; REPLICATES]);
        let (mut results, mut replicates) = (self.results.into_iter(), self.replicates.into_iter());
        let own = |counts: &bool| {
            let measured = counts.then(|| results.next().zip(replicates.next())).flatten();
            measured.unwrap_or(unknown)
        };
        let (results, replicates) = counts.iter().map(own).unzip();
        Self { results, replicates, ..self }
    }

    /// Returns the largest relative 95 % half width; those without any light count as exact. `None`
    /// when all are.
    pub fn worst(&self) -> Option<f64> {
        let lit = self.results.iter().map(|r| r.total).filter(|e| e.mean > 0.0);
        lit.map(|e| e.relative_half_width()).reduce(f64::max)
    }
}

/// Describes how radiosity went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exchange {
    /// The number of patches; each has two sides.
    pub patches: usize,
    /// How often a patch has shot its light.
    pub shots: u64,
    /// The share of the light that is left unshot.
    pub unshot: f64,
    /// The share of the light that all patches absorbed: in a closed scene 1, but for what is
    /// unshot and the error of the patches.
    pub absorbed: f64,
}
