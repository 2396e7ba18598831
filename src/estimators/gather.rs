//! Gathering rays: what connections leave, they find.

use std::f64::consts::PI;
use std::ops::Range;

use crate::math::{Rgb, Stream};
use crate::scene::{BrdfSample, Vertex};
use crate::surface::Hit;

use super::connect::{Batch, Beyond, Connector, Estimate, SplitLight, share};
use super::known_lights::Outlook;
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

/// The part left by mirrors below which a gathering ray, or one from the eye, plays Russian
/// roulette at each further one.
const FAINT: f64 = 0.25;

/// How often, relative to what it can return at most, what a ray finds from a receiver that is
/// asked for itself is looked at: 2 and 4 take a fifth and a quarter off the squared error of the
/// Cornell box, and a twentieth and an eighth more time.
const FIRST_LIVES: f64 = 2.0;

/// Returns what is left of the light along a ray after one more mirror, unless roulette ends it.
pub(super) fn through_mirror(left: Rgb, reflectance: Rgb, roulette: f64) -> Option<Rgb> {
    let left = left * reflectance;
    let survival = (left.luminance() / FAINT).min(1.0);
    (roulette < survival).then(|| left / survival)
}

impl<'a> Connector<'a> {
    /// Gathers, by the rays of each estimate of a level, what the connections leave; where one goes
    /// on, there is an estimate of the next level.
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
        while !batch.rays.is_empty() && !self.ends() {
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

    /// Takes up what a gathering ray has met: its light, an estimate there, and the ray that a
    /// mirror sends on.
    fn take_up(
        &self,
        batch: &mut Batch<'a>,
        mut gathered: Gathered,
        hit: Option<&(usize, Hit)>,
        outlook: Option<&Outlook>,
    ) {
        let from = &mut batch.estimates[gathered.to];
        // What is known of lights is what they send here straight.
        let outlook = outlook.filter(|_| gathered.mirrored.is_none());
        let vertex = hit.map(|(object, hit)| {
            self.scene.refined_vertex(*object, hit, -gathered.sample.direction)
        });
        if vertex.as_ref().is_some_and(|vertex| !vertex.is_sound()) {
            from.light = SplitLight::NON_FINITE;
            return;
        }
        let shines = self.shining(from, &gathered, vertex.as_ref(), outlook);
        let in_mirror = gathered.mirrored.is_some();
        *(if in_mirror { &mut from.light.indirect } else { &mut from.light.direct }) += shines;
        let Some(vertex) = vertex else { return };
        let estimate = self.look(from, &gathered, &vertex);
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

    /// Returns what a gathering ray sees shine: the unknown part of what it has met, less the known
    /// part of what is hidden from it.
    fn shining(
        &self,
        from: &Estimate,
        gathered: &Gathered,
        met: Option<&Vertex<'a>>,
        outlook: Option<&Outlook>,
    ) -> Rgb {
        let met = || met.into_iter().flat_map(|vertex| self.scene.shining(vertex));
        let mut light = Rgb::BLACK;
        for vertex in met() {
            let unknown = 1.0 - share(outlook, vertex.object);
            light += self.emission(&from.receiver, gathered, &vertex) * unknown;
        }
        for (object, known) in outlook.iter().flat_map(|outlook| outlook.objects()) {
            if met().all(|vertex| vertex.object != object) {
                light += self.hidden(&from.receiver, gathered, object) * -known;
            }
        }
        light
    }

    /// Returns the light that a gathering ray would see at an object that emits, if nothing hid it.
    fn hidden(&self, receiver: &Receiver, gathered: &Gathered, object: usize) -> Rgb {
        let BrdfSample { direction, .. } = gathered.sample;
        let surface = &self.scene.objects()[object].surface;
        let hit = surface.hit(&receiver.hit.leave(direction));
        hit.map_or(Rgb::BLACK, |hit| {
            let vertex = self.scene.refined_vertex(object, &hit, -direction);
            self.emission(receiver, gathered, &vertex)
        })
    }

    /// Returns the share of a gathering ray in the light that a surface by itself sends along it.
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

    /// Returns the estimate of what is reflected to a gathering ray, unless roulette ends it.
    fn look(
        &self,
        from: &Estimate<'a>,
        gathered: &Gathered,
        vertex: &Vertex<'a>,
    ) -> Option<Estimate<'a>> {
        if vertex.normal.dot(vertex.outgoing) <= 0.0 {
            return None;
        }
        let rest = if gathered.mirrored.is_some() {
            1.0
        } else {
            let kernel = kernel(&from.receiver, gathered, vertex);
            let peak = vertex.brdf().peak(vertex.normal, vertex.outgoing);
            1.0 - self.weighting.share(from.beyond.is_none(), kernel, peak)
        };
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

/// Returns K between a receiver and what its gathering ray found.
fn kernel(receiver: &Receiver, gathered: &Gathered, vertex: &Vertex) -> f64 {
    let cos = vertex.true_normal().dot(vertex.outgoing);
    PI * gathered.sample.density * cos / (vertex.hit.point - receiver.hit.point).length_squared()
}

impl Gatherer {
    pub(super) fn new(to: usize, rays: usize, mut stream: Stream) -> Self {
        Self { to, numbers: stream.next_4d(), rays: rays as f64, stream }
    }
}
