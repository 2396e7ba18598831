//! One sample of every pixel: walks from the lights, an eye ray for each pixel, and how the two are
//! brought together.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec2;
use rayon::prelude::*;

use crate::math::{Aabb, Rgb, Stream, hash};
use crate::scene::{Camera, Emitter, Film, Scene, Vertex};

use super::super::cloud::{self, Cloud};
use super::super::connect::{Batch, Connector, SplitLight};
use super::super::direct;
use super::super::estimator::Estimator;
use super::super::gather::through_mirror;
use super::super::known_lights::KnownLights;
use super::super::path::PathTracer;
use super::super::receiver::Receiver;
use super::super::replicates::{Watch, seed};
use super::super::walk::Launcher;
use super::super::weighting::Weighting;
use super::{ImageSettings, splat};

/// Paths that share the eye ray of one sample; walks are as many as a cloud has.
const PATHS_PER_SAMPLE: usize = 8;
/// Rays that gather for the walks of a sample.
const RAYS_PER_SAMPLE: usize = 8;
/// Eye rays of a sample that look for surfaces that shine themselves.
const LOOKS_PER_SAMPLE: u32 = 16;
/// Clouds of walks made for each pass; pixels pick theirs at random.
const CLOUDS_PER_PASS: usize = 256;

// What random numbers are for; each has streams of its own.
const WALKS: u64 = 1;
const EYE: u64 = 2;
const GATHER: u64 = 3;
const PICK: u64 = 4;

/// Returns how many walks, or paths, a sample of a pixel takes, which is one eye ray.
pub fn walks_per_sample(estimator: &Estimator) -> usize {
    match estimator {
        Estimator::Local(_) => cloud::WALKS,
        _ => PATHS_PER_SAMPLE,
    }
}

/// One sample of every pixel, belonging to one replicate.
pub(super) struct Pass<'a> {
    scene: &'a Scene,
    connector: Connector<'a>,
    known_lights: &'a KnownLights,
    settings: &'a ImageSettings,
    /// Says which pixels take a sample, and its index.
    film: &'a Film,
    /// Holds all that shines by itself.
    lamps: Aabb,
    /// Each is made when the first pixel picks it: few pixels need few.
    clouds: Vec<OnceLock<Made<'a>>>,
    watch: &'a Watch<'a>,
    /// The rows done.
    rows: AtomicUsize,
}

/// A cloud, and the flux of its walks that left the scene.
struct Made<'a> {
    cloud: Cloud<'a>,
    escaped: Rgb,
}

impl<'a> Pass<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        launcher: &'a Launcher<'a>,
        known_lights: &'a KnownLights,
        settings: &'a ImageSettings,
        film: &'a Film,
        watch: &'a Watch<'a>,
    ) -> Self {
        let (clouds, weighting) = match settings.estimator {
            Estimator::Local(weighting) => (CLOUDS_PER_PASS, weighting),
            _ => (0, Weighting::Walk),
        };
        let connector = Connector::new(scene, launcher, weighting).watched(watch);
        let clouds = (0..clouds).map(|_| OnceLock::new()).collect();
        let bounds = |emitter: &Emitter| scene.objects()[emitter.object].surface.bounds();
        let lamps = scene.emitters().iter().map(bounds).fold(Aabb::EMPTY, Aabb::union);
        let rows = AtomicUsize::new(0);
        Self { scene, connector, known_lights, settings, film, lamps, clouds, watch, rows }
    }

    /// Returns the share of the rows that are done.
    pub(super) fn share(&self) -> f64 {
        self.rows.load(Ordering::Relaxed) as f64 / self.film.size()[1] as f64
    }

    fn cloud(&self, index: usize) -> &Cloud<'a> {
        &self.clouds[index].get_or_init(|| self.make(index)).cloud
    }

    fn make(&self, index: usize) -> Made<'a> {
        let first = (self.film.round() as usize * CLOUDS_PER_PASS + index) * cloud::WALKS;
        let launch = |i: usize| {
            let seed = seed_of(self.settings, self.film, WALKS);
            let mut stream = Stream::new(self.settings.randomness, seed, i as u64);
            let walked = self.connector.launcher.follow(&mut stream, &|| self.watch.ends());
            let escaped = walked.escape.map_or(Rgb::BLACK, |(_, flux)| flux);
            (walked.nodes, escaped)
        };
        let (walks, escaped): (Vec<_>, Vec<_>) = (first..first + cloud::WALKS).map(launch).unzip();
        Made {
            cloud: Cloud::new(walks.iter().map(Vec::as_slice)),
            escaped: escaped.into_iter().sum(),
        }
    }

    /// Returns the mean flux per walk that left the scene.
    pub(super) fn escaped(&self) -> Rgb {
        let made = || self.clouds.iter().filter_map(OnceLock::get);
        let walks = (made().count() * cloud::WALKS).max(1);
        made().map(|made| made.escaped).sum::<Rgb>() / walks as f64
    }

    /// Takes a sample of every pixel that does not rest. Returns whether all were taken: when the
    /// run is to end at once, rows are left black.
    pub(super) fn fill(&self, camera: &Camera, samples: &mut [SplitLight]) -> bool {
        let window = camera.window();
        let ([left, top], [width, height]) = (window.min(), window.size());
        let whole_width = u64::from(camera.resolution()[0]);
        let tracer = PathTracer::new(self.scene);
        samples.par_chunks_mut(width as usize).enumerate().for_each(|(row, line)| {
            let mut batch = Batch::default();
            for (column, sample) in line.iter_mut().enumerate() {
                if self.watch.ends() {
                    line.fill(SplitLight::default());
                    return;
                }
                let index = self.film.index(row * width as usize + column);
                // Places in the whole picture, so that a window has the random numbers it has
                // there.
                let (column, row) = (column as u64 + u64::from(left), row as u64 + u64::from(top));
                let corner = DVec2::new(column as f64, row as f64);
                *sample = index.map_or(SplitLight::default(), |index| {
                    let place = [row * whole_width + column, index];
                    self.sample(camera, &tracer, &mut batch, place, corner)
                });
            }
            // A walk that was left half way spoils the row that used it.
            if self.watch.has_ended() {
                line.fill(SplitLight::default());
            } else {
                self.rows.fetch_add(1, Ordering::Relaxed);
                let passes = self.film.passes() as f64 + self.share();
                let walks = walks_per_sample(&self.settings.estimator) as f64;
                self.watch.note((passes * walks) as u64);
            }
        });
        // A pass whose last row was finished before anyone asked is complete.
        self.rows.load(Ordering::Relaxed) == height as usize
    }

    /// Adds what only the walks can show to the samples of all pixels.
    pub(super) fn splat(&self, camera: &Camera, samples: &mut [SplitLight]) {
        if self.clouds.is_empty() || !self.scene.has_mirrors() {
            return;
        }
        let clouds: Vec<&Cloud> =
            (0..self.clouds.len()).into_par_iter().map(|index| self.cloud(index)).collect();
        let weight = 1.0 / clouds.iter().map(|cloud| cloud.walks()).sum::<usize>() as f64;
        let nodes = clouds.into_iter().flat_map(Cloud::nodes);
        splat::add(self.scene, camera, self.settings.filter, nodes, weight, samples);
    }

    /// Takes one sample of one pixel: an eye ray, and what the point it meets emits and reflects;
    /// through mirrors it goes on to the next point.
    fn sample<'b>(
        &'b self,
        camera: &Camera,
        tracer: &PathTracer,
        batch: &mut Batch<'b>,
        [pixel, index]: [u64; 2],
        corner: DVec2,
    ) -> SplitLight {
        let seed = hash([seed_of(self.settings, self.film, EYE), pixel]);
        let mut stream = Stream::new(self.settings.randomness, seed, index);
        let [u, v, mut roulette, _] = stream.next_4d();
        let film = |numbers| corner + 0.5 + self.settings.filter.sample(numbers);
        let (mut light, mut left) = (SplitLight::default(), Rgb::WHITE);
        if !self.lamps.is_empty() {
            let places = lattice([u, v]).map(film);
            let Some(emitted) = self.emitted(camera, batch, places) else {
                return SplitLight::NON_FINITE;
            };
            light.direct += emitted;
        }
        let Some(mut ray) = camera.ray(film([u, v])) else { return light };
        for mirrors in 0.. {
            let Some(vertex) = self.scene.vertex(&ray) else { break };
            if !vertex.is_sound() {
                return SplitLight::NON_FINITE;
            }
            // What shines straight has been looked at. Direct is what has been reflected once at
            // most.
            if mirrors > 0 {
                let emitted = left * self.scene.emitted(&vertex);
                *(if mirrors < 2 { &mut light.direct } else { &mut light.indirect }) += emitted;
            }
            if vertex.albedo() > 0.0 {
                let SplitLight { direct, indirect } =
                    self.reflected(tracer, batch, &vertex, [pixel, index, mirrors], &mut stream);
                *(if mirrors < 1 { &mut light.direct } else { &mut light.indirect }) +=
                    left * direct;
                light.indirect += left * indirect;
            }
            let Some((direction, reflectance)) = vertex.mirrored() else { break };
            let Some(rest) = through_mirror(left, reflectance, roulette) else { break };
            left = rest;
            ray = vertex.hit.leave(direction);
            [roulette, ..] = stream.next_4d();
        }
        light
    }

    /// Returns the mean luminance of what is seen, without mirrors, at places on the film to shine
    /// by itself; `None` when what is there has no sound place.
    ///
    /// A lamp is so bright that most of the error of a picture can be at its edges, if they are
    /// seen by as few rays as ask for reflected light.
    fn emitted(
        &self,
        camera: &Camera,
        batch: &mut Batch,
        places: impl ExactSizeIterator<Item = DVec2>,
    ) -> Option<Rgb> {
        let count = places.len() as f64;
        batch.rays.clear();
        let rays = places.filter_map(|place| camera.ray(place));
        batch.rays.extend(rays.filter(|ray| self.lamps.intersect(ray).is_some()));
        batch.hits.clear();
        batch.hits.resize(batch.rays.len(), None);
        self.scene.hits(&batch.rays, &mut batch.hits);
        let mut sum = Rgb::BLACK;
        for (ray, hit) in batch.rays.iter().zip(&batch.hits) {
            let Some((object, hit)) = hit else { continue };
            if self.scene.objects()[*object].emits() {
                let vertex = self.scene.refined_vertex(*object, hit, -ray.direction);
                if !vertex.is_sound() {
                    return None;
                }
                sum += self.scene.emitted(&vertex);
            }
        }
        Some(sum / count)
    }

    /// Estimates the luminance that a vertex reflects, but for what it mirrors, seen from a pixel
    /// through so many mirrors.
    fn reflected<'b>(
        &'b self,
        tracer: &PathTracer,
        batch: &mut Batch<'b>,
        vertex: &Vertex<'b>,
        [pixel, index, mirrors]: [u64; 3],
        eye: &mut Stream,
    ) -> SplitLight {
        let stream = |index| {
            let own = hash([seed_of(self.settings, self.film, GATHER), pixel]);
            let own = if mirrors == 0 { own } else { hash([own, mirrors]) };
            Stream::new(self.settings.randomness, own, index)
        };
        let receiver = Receiver::reflecting(vertex);
        let mut direct = direct::few_point_lights(self.scene, &receiver, eye);
        let streams =
            |count: usize| (0..count).map(move |k| stream(index * count as u64 + k as u64));
        let mean: SplitLight = if matches!(self.settings.estimator, Estimator::Local(_)) {
            let picked = hash([seed_of(self.settings, self.film, PICK), pixel, index]);
            let cloud = self.cloud(picked as usize % CLOUDS_PER_PASS);
            if cloud.non_finite() > 0 {
                return SplitLight::NON_FINITE;
            }
            let outlook = self.known_lights.seen_from(self.scene, &receiver);
            direct += outlook.light;
            let asked = std::iter::once((cloud, streams(RAYS_PER_SAMPLE)));
            self.connector.estimate(batch, &receiver, &outlook, asked).map(|e| e.light).sum()
        } else {
            let paths = streams(PATHS_PER_SAMPLE).map(|mut s| tracer.trace(&receiver, &mut s));
            paths.sum::<SplitLight>() / PATHS_PER_SAMPLE as f64
        };
        SplitLight { direct: direct + mean.direct, indirect: mean.indirect }
    }
}

/// Returns a Hammersley set in the unit square that is shifted, round its edges, so that it begins
/// with a given point.
fn lattice([u, v]: [f64; 2]) -> impl ExactSizeIterator<Item = [f64; 2]> {
    let share = f64::from(LOOKS_PER_SAMPLE).recip();
    (0..LOOKS_PER_SAMPLE).map(move |k| {
        let reversed = k.reverse_bits() >> (u32::BITS - LOOKS_PER_SAMPLE.ilog2());
        [u + f64::from(k) * share, v + f64::from(reversed) * share].map(f64::fract)
    })
}

/// Returns the seed of one use of random numbers in the pass that a film takes next.
///
/// Points of one scrambled sequence know of each other, so a stage that was planned by earlier ones
/// has a scramble of its own.
fn seed_of(settings: &ImageSettings, film: &Film, purpose: u64) -> u64 {
    let own = seed(settings.seed, film.replicate(), purpose);
    if film.scramble() == 0 { own } else { hash([own, film.scramble()]) }
}
