//! Backward path tracing: the reference that shares nothing with the walks.
//!
//! From the receiver onwards by BRDF samples; point lights are connected at every vertex, emitting
//! surfaces are met by chance and sampled by area, the samples by area taking up to as much as the
//! chance finds (c = min(1, p_area / p_chance)); Russian roulette ends a path.

use std::ops::Range;

use glam::DVec2;

use crate::math::{Rgb, Stream, sampling};
use crate::scene::{BrdfSample, Scene, Vertex};

use super::connect::SplitLight;
use super::direct;
use super::integrator::{Block, Integrator, Sum};
use super::receiver::Receiver;
use super::replicates::Watch;

/// The share of its first throughput below which a path plays Russian roulette. Where every hit
/// plays, one path in twenty of a room that reflects 0.05 brings all its indirect light, and
/// intervals hold too little.
const FAINT: f64 = 0.25;

/// Traces paths in a scene.
pub(super) struct PathTracer<'a> {
    scene: &'a Scene,
    /// Ascending sums of the emitters' powers.
    powers: Vec<f64>,
}

/// A path under way.
struct Path {
    /// What it has brought so far.
    light: SplitLight,
    throughput: Rgb,
    /// The luminance of the throughput below which it plays roulette; `None` before its first hit.
    faint: Option<f64>,
}

/// Path tracing as an integrator: the samples of a receiver are its own paths.
pub(super) struct Paths<'a> {
    tracer: PathTracer<'a>,
    receivers: &'a [Receiver<'a>],
}

impl<'a> Paths<'a> {
    /// Prepares for some receivers.
    pub(super) fn new(scene: &'a Scene, receivers: &'a [Receiver<'a>]) -> Self {
        Self { tracer: PathTracer::new(scene), receivers }
    }
}

impl<'a> Integrator<'a> for Paths<'a> {
    fn serve<'w>(
        &'w self,
        block: &Block<'w>,
        receivers: Range<usize>,
        watch: &'w Watch<'w>,
    ) -> Vec<Sum>
    where
        'a: 'w,
    {
        let serve = |receiver: usize| {
            let (seed, mut sum) = (block.seed(receiver), Sum::default());
            for index in block.indices.clone().take_while(|_| !watch.ends()) {
                let stream = &mut block.stream(seed, index);
                sum.add(self.tracer.trace(&self.receivers[receiver], stream));
            }
            sum
        };
        receivers.map(serve).collect()
    }
}

impl<'a> PathTracer<'a> {
    /// Prepares for a scene.
    pub(super) fn new(scene: &'a Scene) -> Self {
        let sum = |total: &mut f64, power: f64| {
            *total += power;
            Some(*total)
        };
        Self { scene, powers: scene.emitters().iter().map(|e| e.power).scan(0.0, sum).collect() }
    }

    /// Traces one path from a receiver; the point lights that the receiver sees itself are not
    /// counted.
    pub(super) fn trace(&self, receiver: &Receiver, stream: &mut Stream) -> SplitLight {
        let direct = self.sampled_emitter(receiver, stream);
        let light = SplitLight { direct, indirect: Rgb::BLACK };
        let mut path = Path { light, throughput: Rgb::WHITE, faint: None };
        let mut here = *receiver;
        loop {
            let [u, v, numbers @ ..] = stream.next_4d();
            let Some(sample) = here.sample([u, v]) else { return path.light };
            let Some(vertex) = self.scene.vertex(&here.hit.leave(sample.direction)) else {
                return path.light;
            };
            path.throughput *= sample.weight;
            let met = path.throughput * self.met_emitter(&here, &vertex, &sample);
            let Path { light: SplitLight { direct, indirect }, faint, .. } = &mut path;
            *(if faint.is_some() { indirect } else { direct }) += met;
            let faint = *path.faint.get_or_insert(FAINT * path.throughput.luminance());
            let Some(vertex) = self.through_mirrors(vertex, faint, numbers, &mut path, stream)
            else {
                return path.light;
            };
            here = Receiver::reflecting(&vertex);
            let lamps = direct::few_point_lights(self.scene, &here, stream);
            path.light.indirect += path.throughput * lamps;
            path.light.indirect += path.throughput * self.sampled_emitter(&here, stream);
        }
    }

    /// Follows a path through mirrors to what reflects otherwise; `None` where it ends.
    fn through_mirrors(
        &self,
        mut vertex: Vertex<'a>,
        faint: f64,
        [mut roulette, mut choice]: [f64; 2],
        path: &mut Path,
        stream: &mut Stream,
    ) -> Option<Vertex<'a>> {
        loop {
            if !vertex.is_sound() {
                path.light = SplitLight::NON_FINITE;
                return None;
            }
            let albedo = vertex.albedo();
            let mirrored = vertex.mirrored();
            let by_mirror = mirrored.map_or(0.0, |(_, reflectance)| reflectance.luminance());
            let left = path.throughput.luminance() * (albedo + by_mirror).min(1.0);
            let survival = (left / faint).min(1.0);
            // Also where nothing is left, or no number.
            if !(roulette < survival && left > 0.0) {
                return None;
            }
            let survivor = path.throughput / survival;
            let by_mirror = by_mirror / (albedo + by_mirror);
            let Some((direction, reflectance)) = mirrored.filter(|_| choice < by_mirror) else {
                path.throughput = survivor / (1.0 - by_mirror);
                return Some(vertex);
            };
            path.throughput = survivor * reflectance / by_mirror;
            vertex = self.scene.vertex(&vertex.hit.leave(direction))?;
            path.light.indirect += path.throughput * self.scene.emitted(&vertex);
            [roulette, choice, ..] = stream.next_4d();
        }
    }

    /// Returns the luminance of an emitter met by a BRDF sample, less the share of area sampling.
    fn met_emitter(&self, from: &Receiver, vertex: &Vertex, sample: &BrdfSample) -> Rgb {
        let distance2 = (vertex.hit.point - from.hit.point).length_squared();
        let rest = |v: &Vertex| (1.0 - self.density(v, distance2) / sample.density).max(0.0);
        self.scene.shining(vertex).map(|v| v.emitted() * rest(&v)).sum()
    }

    /// Samples one point on the emitting surfaces, with the share that BRDF sampling leaves.
    fn sampled_emitter(&self, receiver: &Receiver, stream: &mut Stream) -> Rgb {
        if self.powers.is_empty() {
            return Rgb::BLACK;
        }
        let [pick, u, v, _] = stream.next_4d();
        let emitter = &self.scene.emitters()[sampling::discrete(&self.powers, pick).0];
        let Some(surface) = &self.scene.objects()[emitter.object].area else { return Rgb::BLACK };
        let point = surface.sample_area(DVec2::new(u, v));
        let to_point = point.hit.point - receiver.hit.point;
        let distance2 = to_point.length_squared();
        let direction = to_point / distance2.sqrt();
        let vertex = self.scene.vertex_at(emitter.object, point.hit, -direction);
        let (emitted, response) = (vertex.emitted(), receiver.response(direction));
        let density = self.density(&vertex, distance2);
        if emitted.is_black()
            || response.is_black()
            || !density.is_finite()
            || !self.scene.sees(&receiver.hit, &vertex.hit, direction)
        {
            return Rgb::BLACK;
        }
        emitted * response / density.max(receiver.density(direction))
    }

    /// Returns the density per steradian, seen from distance sqrt(distance2), with which area
    /// sampling picks the point of a vertex.
    fn density(&self, vertex: &Vertex, distance2: f64) -> f64 {
        let emitter = self.scene.emitters().iter().find(|e| e.object == vertex.object);
        let surface = self.scene.objects()[vertex.object].area.as_ref();
        let total = self.powers.last().copied().unwrap_or(0.0);
        match (emitter, surface) {
            (Some(e), Some(s)) => {
                e.power / total * s.density(&vertex.hit) * distance2
                    / vertex.hit.normal.dot(vertex.outgoing).abs()
            }
            _ => 0.0,
        }
    }
}
