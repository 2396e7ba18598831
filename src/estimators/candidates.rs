//! Which nodes of a cloud are connected to a receiver: some, drawn in proportion to what they
//! bring, stand for all.

use fearless_simd::Level;

use super::cloud::{Cloud, Plane, Weighed};
use super::receiver::Receiver;
use super::walk::Node;
use crate::math::Rgb;
use crate::math::lanes::LANES;
use crate::scene::SplitLight;

/// Holds what the nodes of a cloud bring to a receiver if nothing hinders it.
#[derive(Default)]
pub(super) struct Candidates {
    plane: Option<Plane>,
    /// What the diffuse nodes bring to the plane.
    diffuse: Vec<Weighed>,
    /// What the other nodes bring, and by what they are drawn; all nodes when the receiver is no
    /// plane. Of many, one in every `stride` stands for its neighbours.
    others: Vec<(SplitLight, f64)>,
    stride: usize,
    first: usize,
    /// Where drawing starts, 0 to 1.
    start: f64,
}

/// How nodes are weighed.
pub(super) struct Choice {
    /// Up to which K diffuse nodes are connected in full, 1/m2.
    pub(super) limit: f64,
    /// About how many of the other nodes are weighed.
    pub(super) most: usize,
    /// A random number, 0 to 1.
    pub(super) random: f64,
}

/// Of starts on a light that seems to be seen whole one in so many stands for all, and is drawn so
/// much more seldom than by what it brings: a ray to it hardly tells anything new.
const SELDOM: usize = 8;

impl Candidates {
    /// Weighs the nodes of a cloud, diffuse ones by their K, the others by `weigh`, and returns
    /// what all bring, but for the `known` share of the light of starts. Of many others some are
    /// weighed, evenly spread from a random place.
    pub(super) fn weigh(
        &mut self,
        level: Level,
        receiver: &Receiver,
        cloud: &Cloud,
        Choice { limit, most, random }: Choice,
        weigh: impl Fn(&Node) -> Rgb,
        known: impl Fn(&Node) -> f64,
    ) -> SplitLight {
        let mut all = SplitLight::default();
        self.plane = receiver.plane();
        self.diffuse.clear();
        if let Some(plane) = &self.plane {
            all.indirect = cloud.weigh(level, plane, limit, &mut self.diffuse);
        }
        self.others.clear();
        self.stride = self.others_of(cloud).len().div_ceil(most).max(1);
        let places = random * self.stride as f64;
        self.first = places as usize;
        let seldom = places.fract() * SELDOM as f64;
        self.start = seldom.fract();
        for (number, node) in (seldom as usize..).zip(self.weighed_others(cloud)) {
            let start = node.start_density.is_some();
            let known = if start { known(node) } else { 0.0 };
            let times = if known < 1.0 { 1 } else { SELDOM };
            if !number.is_multiple_of(times) {
                self.others.push((SplitLight::default(), 0.0));
                continue;
            }
            let light = weigh(node) * (self.stride * times) as f64;
            let luminance = light.luminance();
            self.others.push(if start {
                all.direct += light * (1.0 - known);
                let light = SplitLight { direct: light, indirect: Rgb::BLACK };
                (light, luminance / times as f64)
            } else {
                all.indirect += light;
                (SplitLight { direct: Rgb::BLACK, indirect: light }, luminance)
            });
        }
        all
    }

    fn others_of<'c, 'a>(&self, cloud: &'c Cloud<'a>) -> &'c [Node<'a>] {
        if self.plane.is_some() { cloud.others() } else { cloud.nodes() }
    }

    /// Returns the others that are weighed.
    fn weighed_others<'c, 'a>(
        &self,
        cloud: &'c Cloud<'a>,
    ) -> impl Iterator<Item = &'c Node<'a>> + use<'c, 'a> {
        self.others_of(cloud).iter().skip(self.first).step_by(self.stride)
    }

    /// Hands `take` about `count` nodes, drawn at even distances from a random start along the sum
    /// of their luminances: each with as much light that the mean over starts is all.
    pub(super) fn draw(
        &self,
        cloud: &Cloud,
        count: usize,
        mut take: impl FnMut(&Node, SplitLight),
    ) {
        let others = self.others.iter().map(|(_, weight)| *weight);
        let total = self.diffuse.iter().map(|block| block.total).chain(others).sum::<f64>();
        let mut draw = Draw::new(total / count as f64, self.start);
        if let Some(plane) = &self.plane {
            for (block, weighed) in self.diffuse.iter().enumerate() {
                if draw.passes(weighed.total) {
                    continue;
                }
                for (lane, luminance) in weighed.luminances.iter().enumerate() {
                    if let Some(scale) = draw.scale(*luminance) {
                        let node = block * LANES + lane;
                        let indirect = cloud.light(node, plane, weighed) * scale;
                        take(&cloud.nodes()[node], SplitLight { direct: Rgb::BLACK, indirect });
                    }
                }
            }
        }
        for (node, (light, weight)) in self.weighed_others(cloud).zip(&self.others) {
            if let Some(scale) = draw.scale(*weight) {
                take(node, *light * scale);
            }
        }
    }
}

/// Draws at even distances along the sum of some weights.
struct Draw {
    next: f64,
    step: f64,
    sum: f64,
}

/// Below this step, numbers are too coarse to count by: all are drawn.
const FAINTEST: f64 = 1e-290;

impl Draw {
    /// Starts at a part of the first step, 0 to 1.
    fn new(step: f64, start: f64) -> Self {
        let step = if step >= FAINTEST { step } else { 0.0 };
        Self { next: start * step, step, sum: 0.0 }
    }

    /// Passes over weights with this sum when nothing is drawn there.
    #[inline]
    fn passes(&mut self, total: f64) -> bool {
        let passes = self.sum + total <= self.next;
        if passes {
            self.sum += total;
        }
        passes
    }

    /// Returns how often a weight is drawn, in units of how often it is in the mean; `None` when it
    /// is not.
    #[inline]
    fn scale(&mut self, weight: f64) -> Option<f64> {
        if self.step == 0.0 {
            return (weight > 0.0).then_some(1.0);
        }
        self.sum += weight;
        let mut times = 0_u32;
        while self.next < self.sum {
            self.next += self.step;
            times += 1;
        }
        (times > 0).then(|| f64::from(times) * self.step / weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_of_the_faintest_are_drawn() {
        for step in [0.0, 5e-324, 1e-300] {
            let mut draw = Draw::new(step, 0.7);
            assert!(!draw.passes(5e-324));
            let drawn = [5e-324, 0.0, 1e-310].map(|weight| draw.scale(weight));
            assert_eq!(drawn, [Some(1.0), None, Some(1.0)]);
        }
    }

    #[test]
    fn every_weight_is_drawn_as_often_as_it_weighs() {
        let weights = [0.5, 0.0, 3.0, 0.05, 0.0, 7.0, 0.25];
        let total: f64 = weights.iter().sum();
        let mut means = [0.0; 7];
        let starts = 10_000;
        for i in 0..starts {
            let step = total / 3.0;
            let start = (f64::from(i) + 0.5) / f64::from(starts);
            let mut draw = Draw::new(step, start);
            let mut drawn = 0.0;
            for (mean, weight) in means.iter_mut().zip(weights) {
                if let Some(scale) = draw.scale(weight) {
                    *mean += scale / f64::from(starts);
                    drawn += scale * weight;
                }
            }
            assert!((drawn - total).abs() <= 1e-12, "{drawn}");
        }
        for (mean, weight) in means.iter().zip(weights) {
            let expected = if weight > 0.0 { 1.0 } else { 0.0 };
            assert!((mean - expected).abs() <= 1e-2, "{mean} {weight}");
        }
    }
}
