//! The local estimate as an integrator: the walks of a block, in clouds, are connected to every
//! receiver (eq. 5), and rays of its own gather what they would bring too rarely.

use std::ops::Range;

use rayon::prelude::*;

use super::cloud::{self, Cloud};
use super::connect::{Batch, Connector, Estimated};
use super::effort::Effort;
use super::estimator::SensorSettings;
use super::integrator::{Block, Integrator, Needs, SERVED_TOGETHER, Sum, Walks};
use super::known_lights::{KnownLights, Outlook};
use super::receiver::Receiver;
use super::replicates::{REPLICATES, Watch};
use super::walk::Walked;
use super::weighting::Weighting;
use crate::math::stats::Estimate;
use crate::math::{Rgb, hash};
use crate::scene::Scene;

/// Connects walks to receivers.
pub(super) struct Local<'a> {
    scene: &'a Scene,
    walks: Walks<'a>,
    settings: &'a SensorSettings,
    receivers: &'a [Receiver<'a>],
    /// What each receiver knows of lights of simple shapes.
    outlooks: Vec<Outlook>,
    /// How many rays gather for each.
    efforts: Vec<Effort>,
    /// How light is divided for each.
    weightings: Vec<Weighting>,
}

impl<'a> Local<'a> {
    /// Prepares for some receivers; what there is no time for knows nothing.
    pub(super) fn new(
        scene: &'a Scene,
        walks: Walks<'a>,
        settings: &'a SensorSettings,
        receivers: &'a [Receiver<'a>],
        weighting: Weighting,
        watch: &Watch,
    ) -> Self {
        let known_lights = KnownLights::of(scene);
        let outlook = |receiver: &Receiver| {
            if watch.ends() { Outlook::default() } else { known_lights.seen_from(scene, receiver) }
        };
        Self {
            scene,
            walks,
            settings,
            receivers,
            outlooks: receivers.par_iter().map(outlook).collect(),
            efforts: vec![Effort::default(); receivers.len()],
            weightings: vec![weighting; receivers.len()],
        }
    }

    /// Connects the clouds of a block to one receiver.
    fn connect<'w>(
        &'w self,
        block: &Block<'w>,
        index: usize,
        batch: &mut Batch<'w>,
        watch: &'w Watch<'w>,
    ) -> Sum
    where
        'a: 'w,
    {
        let mut sum = Sum::default();
        if watch.ends() {
            return sum;
        }
        let connector = Connector::new(self.scene, self.walks.launcher, self.weightings[index]);
        let connector = connector.watched(watch);
        let effort = self.efforts[index];
        let seed = hash([block.seed(index), effort.planned]);
        let mut rays = effort.rays - effort.planned;
        let asked = block.clouds.iter().map(|cloud| {
            let (from, count) = (rays, effort.rays_for(cloud.taken()));
            rays += count as u64;
            (cloud, (0..count).map(move |k| block.stream(seed, from + k as u64)))
        });
        let (receiver, outlook) = (&self.receivers[index], &self.outlooks[index]);
        let estimated = connector.estimate(batch, receiver, outlook, asked);
        for (cloud, estimated) in block.clouds.iter().zip(estimated) {
            let Estimated { light, connected, .. } = estimated;
            sum.non_finite += cloud.non_finite() as u64;
            if light.is_finite() {
                let walks = cloud.walks() as f64;
                sum.direct += light.direct.luminance() * walks;
                sum.total += estimated.luminance() * walks;
                let gathered = light.total() - connected.total();
                sum.gathered += gathered.luminance() * walks;
            } else {
                sum.non_finite += cloud.walks() as u64;
            }
        }
        sum
    }
}

impl<'a> Integrator<'a> for Local<'a> {
    fn serve<'w>(
        &'w self,
        block: &Block<'w>,
        receivers: Range<usize>,
        watch: &'w Watch<'w>,
    ) -> Vec<Sum>
    where
        'a: 'w,
    {
        let mut batch = Batch::default();
        receivers.map(|receiver| self.connect(block, receiver, &mut batch, watch)).collect()
    }

    fn needs(&self) -> Needs {
        Needs::Clouds
    }

    fn known(&self, receiver: usize) -> Rgb {
        self.outlooks[receiver].light
    }

    /// Chooses how light is divided for each sensor.
    fn pilot(&mut self, known: &[Rgb], watch: &Watch) {
        if !self.weightings.first().is_some_and(|w| matches!(w, Weighting::Bounded { .. })) {
            return;
        }
        let count = cloud::WALKS as u64;
        let walks = self.walks.of_replicate(REPLICATES, 0..count, watch);
        let clouds = to_clouds(&walks);
        let block = Block {
            replicate: REPLICATES,
            indices: 0..count,
            walks: &walks,
            clouds: &clouds,
            randomness: self.settings.randomness,
            seed: self.settings.seed,
        };
        let receivers = self.receivers.len();
        let weigh = |chunk: usize| {
            let mut batch = Batch::default();
            let weigh = |receiver: usize| {
                let weighting = self.weightings[receiver];
                if watch.ends() {
                    return weighting;
                }
                let sum = self.connect(&block, receiver, &mut batch, watch);
                let found = known[receiver].luminance() + sum.total / count as f64;
                weighting.raised(found / self.walks.launcher.power())
            };
            let from = chunk * SERVED_TOGETHER;
            (from..receivers.min(from + SERVED_TOGETHER)).map(weigh).collect::<Vec<_>>()
        };
        let chunks = (0..receivers.div_ceil(SERVED_TOGETHER)).into_par_iter();
        let weightings = chunks.flat_map_iter(weigh).collect();
        self.weightings = weightings;
    }

    fn note(&mut self, clouds: &[Cloud]) {
        self.efforts.par_iter_mut().for_each(|effort| {
            let rays = clouds.iter().map(|cloud| effort.rays_for(cloud.taken()) as u64);
            effort.rays += rays.sum::<u64>();
        });
    }

    /// Plans how many rays gather for each sensor from what was seen so far.
    fn plan(&mut self, sums: &[[Sum; REPLICATES]], walks: u64) {
        self.efforts.par_iter_mut().zip(sums).for_each(|(effort, sums)| {
            let variance = |part: fn(&Sum) -> f64| {
                let means = sums.map(|s| part(&s) / (walks - s.non_finite).max(1) as f64);
                Estimate::of_replicates(&means).standard_error.powi(2)
            };
            effort.plan(walks, variance(|s| s.total - s.gathered), variance(|s| s.gathered));
        });
    }
}

/// Puts walks into clouds.
pub(super) fn to_clouds<'a>(walks: &[Walked<'a>]) -> Vec<Cloud<'a>> {
    let clouds = walks.chunks(cloud::WALKS);
    clouds.map(|walks| Cloud::new(walks.iter().map(|walk| walk.nodes.as_slice()))).collect()
}
