//! What the driver of a survey asks of an estimator.

use std::ops::Range;

use super::cloud::Cloud;
use super::connect::SplitLight;
use super::estimator::SensorSettings;
use super::replicates::{REPLICATES, Watch, seed};
use super::walk::{Launcher, Walked};
use crate::math::{Randomness, Rgb, Stream, hash};

/// The purposes of random numbers: walks, and a receiver's own samples.
const WALKS: u64 = 11;
const OWN: u64 = 12;

/// How many sensors are served by a replicate before the next one.
pub(super) const SERVED_TOGETHER: usize = 64;

/// Estimates what receivers get, sample by sample: of light walks, or of its own rays.
pub(super) trait Integrator<'a>: Sync {
    /// Returns what the samples of a block bring to each of some receivers. When `watch` ends, what
    /// it returns does not count.
    fn serve<'w>(
        &'w self,
        block: &Block<'w>,
        receivers: Range<usize>,
        watch: &'w Watch<'w>,
    ) -> Vec<Sum>
    where
        'a: 'w;

    /// Returns what it needs of each block.
    fn needs(&self) -> Needs {
        Needs::Nothing
    }

    /// Whether it finds what point lights shed straight on a receiver; else that is added exactly.
    fn finds_point_lights(&self) -> bool {
        false
    }

    /// Returns the light that a receiver is known to get without any sample, beside that of point
    /// lights.
    fn known(&self, _receiver: usize) -> Rgb {
        Rgb::BLACK
    }

    /// Looks at the receivers by an uncounted pilot, before the first block; `known` is what each
    /// is known to get.
    fn pilot(&mut self, _known: &[Rgb], _watch: &Watch) {}

    /// Notes that a block has been served; `clouds` are those of one replicate.
    fn note(&mut self, _clouds: &[Cloud]) {}

    /// Plans, from the sums after so many walks of each replicate, how samples are divided from now
    /// on.
    fn plan(&mut self, _sums: &[[Sum; REPLICATES]], _walks: u64) {}
}

/// What an integrator needs of each block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Needs {
    Nothing,
    Walks,
    /// Walks, in clouds.
    Clouds,
}

/// Some samples of one replicate.
pub(super) struct Block<'w> {
    pub(super) replicate: usize,
    pub(super) indices: Range<u64>,
    pub(super) walks: &'w [Walked<'w>],
    pub(super) clouds: &'w [Cloud<'w>],
    pub(super) randomness: Randomness,
    /// The seed of the run.
    pub(super) seed: u64,
}

impl Block<'_> {
    /// Returns the seed of a receiver's own samples.
    pub(super) fn seed(&self, receiver: usize) -> u64 {
        hash([seed(self.seed, self.replicate, OWN), receiver as u64])
    }

    /// Returns the random numbers of one sample.
    pub(super) fn stream(&self, seed: u64, index: u64) -> Stream {
        Stream::new(self.randomness, seed, index)
    }
}

/// What one receiver has got in one replicate, as luminances of its light: colours are not asked
/// for, and a million receivers have 32 million of these.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sum {
    pub(super) direct: f64,
    pub(super) total: f64,
    /// What gathering rays brought of the total.
    pub(super) gathered: f64,
    pub(super) non_finite: u64,
}

impl Sum {
    /// Adds one sample.
    pub(super) fn add(&mut self, light: SplitLight) {
        if light.total().is_finite() {
            self.direct += light.direct.luminance();
            self.total += light.total().luminance();
        } else {
            self.non_finite += 1;
        }
    }
}

impl std::ops::AddAssign for Sum {
    fn add_assign(&mut self, other: Self) {
        self.direct += other.direct;
        self.total += other.total;
        self.gathered += other.gathered;
        self.non_finite += other.non_finite;
    }
}

/// The walks of a run.
#[derive(Clone, Copy)]
pub(super) struct Walks<'a> {
    pub(super) launcher: &'a Launcher<'a>,
    pub(super) settings: &'a SensorSettings,
}

impl<'a> Walks<'a> {
    /// Follows some walks of a replicate; what there is no time for is cut short.
    pub(super) fn of_replicate(
        &self,
        replicate: usize,
        indices: Range<u64>,
        watch: &Watch,
    ) -> Vec<Walked<'a>> {
        let seed = seed(self.settings.seed, replicate, WALKS);
        let ends = || watch.ends();
        let follow = |index| {
            let stream = &mut Stream::new(self.settings.randomness, seed, index);
            if ends() { Walked::default() } else { self.launcher.follow(stream, &ends) }
        };
        indices.map(follow).collect()
    }
}
