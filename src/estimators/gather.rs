//! Gathering rays: what connections leave, they find.

use std::f64::consts::PI;
use std::ops::Range;

use crate::math::{Rgb, Stream};
use crate::scene::{BrdfSample, Vertex};
use crate::surface::Hit;

use super::connect::{Batch, Beyond, Connector, Estimate, Light, share};
use super::flat_lights::Outlook;
use super::receiver::Receiver;

/// A gathering ray to be: the estimate it is for, and its random numbers.
pub(super) struct Gatherer {
    pub(super) to: usize,
    pub(super) numbers: [f64; 4],
    /// How many rays share what there is to gather.
    rays: f64,
    pub(super) stream: Stream,
}

/// A gathering ray's sample and the number that decides whether an estimate is made where it ends.
pub(super) struct Gathered {
    to: usize,
    sample: BrdfSample,
    roulette: f64,
    /// What mirrors have left of the light, where it has met any.
    mirrored: Option<Rgb>,
    stream: Stream,
}

/// The part left by mirrors below which a gathering ray, or one from the eye, plays Russian roulette at each further one.
const FAINT: f64 = 0.25;

/// How often, relative to what it can return at most, what a ray finds from a receiver that is asked for itself is looked at: 2 and 4 take a fifth and a
/// quarter off the squared error of the Cornell box, and a twentieth and an eighth more time.
const FIRST_LIVES: f64 = 2.0;

/// Gives what is left of the light along a ray after one more mirror, unless roulette ends it.
pub(super) fn through_mirror(left: Rgb, reflectance: Rgb, roulette: f64) -> Option<Rgb> {
    let left = left * reflectance;
    let survival = (left.luminance() / FAINT).min(1.0);
    (roulette < survival).then(|| left / survival)
}

impl<'a> Connector<'a> {
    /// Gathers, by the rays of each estimate of a level, what the connections leave; where one goes on, there is an estimate of the next level.
    pub(super) fn gather(
        &self,
        batch: &mut Batch<'a>,
        level: &Range<usize>,
        outlook: Option<&Outlook>,
    ) {
        let mirrors = self.scene.has_mirrors();
        if !mirrors && !self.weighting.gathers(level.start == 0) {
            return;
        }
        let reach = self.weighting.reach(self.scene);
        batch.rays.clear();
        batch.gathered.clear();
        for Gatherer { to, numbers: [u, v, roulette, _], rays, stream } in batch.gatherers.drain(..)
        {
            let receiver = &batch.estimates[to].receiver;
            let Some(sample) = receiver.sample([u, v]) else { continue };
            let sample = BrdfSample { weight: sample.weight / rays, ..sample };
            batch.rays.push(receiver.hit.leave(sample.direction).up_to(reach));
            batch.gathered.push(Gathered { to, sample, roulette, mirrored: None, stream });
        }
        while !batch.rays.is_empty() {
            batch.hits.clear();
            batch.hits.resize(batch.rays.len(), None);
            self.scene.hits(&batch.rays, &mut batch.hits);
            batch.rays.clear();
            let (mut gathered, hits) =
                (std::mem::take(&mut batch.gathered), std::mem::take(&mut batch.hits));
            for (gathered, hit) in gathered.drain(..).zip(&hits) {
                self.take_up(batch, gathered, hit.as_ref(), outlook);
            }
            batch.hits = hits;
            if batch.rays.is_empty() {
                batch.gathered = gathered;
            }
        }
    }

    /// Takes up what a gathering ray has met: its light, an estimate there, and the ray that a mirror sends on.
    fn take_up(
        &self,
        batch: &mut Batch<'a>,
        mut gathered: Gathered,
        hit: Option<&(usize, Hit)>,
        outlook: Option<&Outlook>,
    ) {
        let from = &mut batch.estimates[gathered.to];
        // What is known of flat lights is what they send here straight.
        let outlook = outlook.filter(|_| gathered.mirrored.is_none());
        let flat_lights = outlook.iter().flat_map(|o| o.objects());
        for (light, known) in flat_lights.filter(|(light, _)| Some(*light) != hit.map(|h| h.0)) {
            from.light.direct += self.hidden(&from.receiver, &gathered, light) * -known;
        }
        let Some((object, hit)) = hit else { return };
        let vertex = self.scene.refined_vertex(*object, hit, -gathered.sample.direction);
        if !vertex.is_sound() {
            from.light = Light::SPOILT;
            return;
        }
        let unknown = 1.0 - share(outlook, *object);
        let estimate = self.look(from, &gathered, &vertex, unknown);
        if let Some((direction, reflectance)) = vertex.mirrored() {
            let left = gathered.mirrored.unwrap_or(Rgb::WHITE);
            let [roulette, next_roulette, ..] = gathered.stream.next_4d();
            if let Some(left) = through_mirror(left, reflectance, roulette) {
                let sample = BrdfSample { direction, ..gathered.sample };
                let (to, roulette, mirrored) = (gathered.to, next_roulette, Some(left));
                let stream = gathered.stream.clone();
                batch.rays.push(vertex.hit.leave(direction));
                batch.gathered.push(Gathered { to, sample, roulette, mirrored, stream });
            }
        }
        if let Some(estimate) = estimate {
            let to = batch.estimates.len();
            batch.next_gatherers.push(Gatherer::new(to, 1, gathered.stream));
            batch.estimates.push(estimate);
        }
    }

    /// Gives the light that a gathering ray would see at an object that emits, if nothing hid it.
    fn hidden(&self, receiver: &Receiver, gathered: &Gathered, object: usize) -> Rgb {
        let BrdfSample { direction, .. } = gathered.sample;
        let surface = &self.scene.objects()[object].surface;
        let hit = surface.hit(&receiver.hit.leave(direction));
        hit.map_or(Rgb::BLACK, |hit| {
            let vertex = self.scene.refined_vertex(object, &hit, -direction);
            self.emission(receiver, gathered, &vertex)
        })
    }

    /// Gives the share of a gathering ray in the light that a surface by itself sends along it.
    fn emission(&self, receiver: &Receiver, gathered: &Gathered, vertex: &Vertex) -> Rgb {
        let emitted = vertex.emitted();
        if emitted.is_black() {
            return emitted;
        }
        if let Some(left) = gathered.mirrored {
            return gathered.sample.weight * left * emitted;
        }
        let kernel = kernel(receiver, gathered, vertex);
        let share = self.weighting.start_share(kernel, self.launcher.start_density(vertex));
        gathered.sample.weight * emitted * (1.0 - share)
    }

    /// Takes up what a gathering ray sees, of its emission the unknown part, and gives the estimate that goes on there unless roulette ends it.
    fn look(
        &self,
        from: &mut Estimate<'a>,
        gathered: &Gathered,
        vertex: &Vertex<'a>,
        unknown: f64,
    ) -> Option<Estimate<'a>> {
        if vertex.normal.dot(vertex.outgoing) <= 0.0 {
            return None;
        }
        let emission = self.emission(&from.receiver, gathered, vertex) * unknown;
        let (light, rest) = if gathered.mirrored.is_some() {
            (&mut from.light.indirect, 1.0)
        } else {
            let kernel = kernel(&from.receiver, gathered, vertex);
            let peak = vertex.brdf().peak(vertex.normal, vertex.outgoing);
            let share = self.weighting.share(from.beyond.is_none(), kernel, peak);
            (&mut from.light.direct, 1.0 - share)
        };
        *light += emission;
        // Roulette on what the vertex can return at most ends the recursion without bias.
        let lives = if from.beyond.is_none() { FIRST_LIVES } else { 1.0 };
        let survival = (lives * rest * vertex.albedo()).min(1.0);
        (survival > 0.0 && gathered.roulette < survival).then(|| {
            let weight = gathered.sample.weight * gathered.mirrored.unwrap_or(Rgb::WHITE);
            let share = rest / survival;
            let beyond = Beyond { of: gathered.to, weight, share };
            let there = Receiver::reflecting(vertex);
            Estimate::new(there, from.cloud, Some(beyond))
        })
    }
}

/// Gives K between a receiver and what its gathering ray found.
fn kernel(receiver: &Receiver, gathered: &Gathered, vertex: &Vertex) -> f64 {
    let cos = vertex.normal.dot(vertex.outgoing);
    PI * gathered.sample.density * cos / (vertex.hit.point - receiver.hit.point).length_squared()
}

impl Gatherer {
    pub(super) fn new(to: usize, rays: usize, mut stream: Stream) -> Self {
        Self { to, numbers: stream.next_4d(), rays: rays as f64, stream }
    }
}
