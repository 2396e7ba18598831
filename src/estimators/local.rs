//! Drives a survey of sensors or of rays: every walk serves every sensor (eq. 5), replicate by replicate, doubled until the stop.

use std::f64::consts::SQRT_2;
use std::ops::ControlFlow;
use std::time::Duration;

use rayon::prelude::*;

use crate::Result;
use crate::math::stats::Estimate;
use crate::math::{Randomness, Ray, Rgb, Stream, hash};
use crate::scene::{Measured, Scene, Sensor, Vertex};

use super::cloud::{self, Cloud};
use super::connect::{Batch, Connector, Estimated, Light};
use super::direct;
use super::effort::Effort;
use super::known_lights::Outlook;
use super::path::PathTracer;
use super::photon::{self, Counter};
use super::radiosity::{self, Exchange, RadiositySettings};
use super::receiver::Receiver;
use super::replicates::{Control, Ending, Known, Observer, REPLICATES, Stop, Watch, seed};
use super::walk::{Launcher, Walked};
use super::weighting::Weighting;

/// Chooses how illuminance is estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SensorEstimator {
    /// The local estimate: one walk serves all sensors (light tracing to points). At sensors that a pilot of 32 walks finds bright for the size of the
    /// scene a bounded kernel has a greater bound, so that no hit brings more than sixteen times the illuminance there.
    Local(Weighting),
    /// Backward path tracing, the reference.
    Path,
    /// Radiosity: no statistical error, that of the patches is not known. Of [`SensorSettings::stop`] only the time counts.
    Radiosity(RadiositySettings),
    /// Photons counted on a disc about each sensor. The intervals are those of the mean over the disc, not of its centre.
    Photon {
        /// The radius of the discs, metres, above 0; when left out they have a ten thousandth of the total area of the scene.
        radius: Option<f64>,
    },
}

/// Sets a survey.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorSettings {
    /// How illuminance is estimated.
    pub estimator: SensorEstimator,
    /// Where random numbers come from.
    pub randomness: Randomness,
    /// The seed: the same seed gives the same bytes on any number of threads.
    pub seed: u64,
    /// When to stop; the error is the largest relative 95 % half width over the sensors.
    pub stop: Stop,
}

/// Holds a finished survey and how it came about.
#[derive(Debug, Clone)]
pub struct Survey {
    /// One result per sensor; [`Measured::UNKNOWN`] where the time was up before any walk was
    /// served to it.
    pub results: Vec<Measured>,
    /// What each sensor received in each replicate, lx; sensors share their walks, so that replicates of one number belong together. NaN by radiosity.
    pub replicates: Vec<[f64; REPLICATES]>,
    /// Why the run ended.
    pub ending: Ending,
    /// Walks in all; the shots of radiosity.
    pub walks: u64,
    /// The share of the walks' flux that left an open scene; NaN where there are no walks of light to tell.
    pub escaped: f64,
    /// The share of all light that point lights shed on mirrors and these send on. A sensor gets none of that straight: no estimate finds a point in a
    /// mirror. A light with an extent has no such share.
    pub caustic: f64,
    /// The time it took.
    pub elapsed: Duration,
    /// How the patches exchanged light, by radiosity; then no result has a known error.
    pub radiosity: Option<Exchange>,
}

impl Survey {
    /// Gives the survey of some sensors the places they have among all: those of which `counts` is
    /// true, in order. The others have measured NaN.
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

    /// Gives the largest relative 95 % half width; those without any light count as exact. `None` when all are.
    pub fn worst(&self) -> Option<f64> {
        let lit = self.results.iter().map(|r| r.total).filter(|e| e.mean > 0.0);
        lit.map(|e| e.relative_half_width()).reduce(f64::max)
    }
}

const WALKS: u64 = 11;
const GATHER: u64 = 12;

/// Walks per replicate of the first round, and the most that are held in memory together.
const FIRST_ROUND: u64 = 8;
const LARGEST_BLOCK: u64 = 256;
/// After how many walks a survey without any light counts as exact.
const ENOUGH_IN_THE_DARK: u64 = 1 << 20;
/// How many sensors are served by a replicate before the next one.
const SERVED_TOGETHER: usize = 64;

/// What one receiver has got in one replicate, as luminances of its light: colours are not asked for, and a million receivers have 32 million of these.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    direct: f64,
    total: f64,
    /// What gathering rays brought of the total.
    gathered: f64,
    spoilt: u64,
}

/// Measures illuminance, lx, at all sensors.
///
/// # Errors
/// [`crate::Error::Parameter`] when the scene has no light, or when the estimator cannot be used: radiosity with an infinite surface, another reflection than
/// Lambert's or a number of patches out of range; photons on cylinders or without a radius.
pub fn illuminance(
    scene: &Scene,
    sensors: &[Sensor],
    settings: &SensorSettings,
    observer: Observer,
) -> Result<Survey> {
    let receivers: Vec<_> =
        sensors.par_iter().map(|s| Receiver::sensor(&scene.settled(s))).collect();
    survey(scene, &receivers, |_| Rgb::BLACK, settings, observer)
}

/// Measures luminance, cd/m2, against the direction of all rays, at the first surface that each meets (eq. 11), and at those that mirrors show there; 0 where
/// there is none. The direct part holds what the first surface emits.
///
/// # Errors
/// As [`illuminance`].
pub fn luminance(
    scene: &Scene,
    rays: &[Ray],
    settings: &SensorSettings,
    observer: Observer,
) -> Result<Survey> {
    let seen: Vec<Vec<(Vertex, Rgb)>> = rays.par_iter().map(|ray| seen(scene, ray)).collect();
    let all: Vec<(Vertex, Rgb)> = seen.iter().flatten().copied().collect();
    let receivers: Vec<_> =
        all.iter().map(|(v, left)| Receiver::reflecting(v).through(*left)).collect();
    let emitted = |i: usize| all[i].1 * scene.emitted(&all[i].0);
    let mut survey = survey(scene, &receivers, emitted, settings, observer)?;
    let (results, replicates) = (survey.results, survey.replicates);
    let mut from = 0;
    let own = seen.iter().map(|seen| {
        let range = from..from + seen.len();
        from = range.end;
        together(&results[range.clone()], &replicates[range])
    });
    (survey.results, survey.replicates) = own.unzip();
    Ok(survey)
}

/// Gives the vertices that a ray shows: the first that it meets and, with what mirrors leave of their light, those behind it.
fn seen<'a>(scene: &'a Scene, ray: &Ray) -> Vec<(Vertex<'a>, Rgb)> {
    let (mut seen, mut left) = (Vec::new(), Rgb::WHITE);
    let mut next = scene.vertex(ray);
    while let Some(vertex) = next {
        // A mirror itself shows nothing; there may be many in a row.
        if vertex.albedo() > 0.0 || !vertex.emitted().is_black() || vertex.mirrored().is_none() {
            seen.push((vertex, left));
        }
        let mirrored = vertex.mirrored().map(|(direction, reflectance)| {
            left *= reflectance;
            vertex.hit.leave(direction)
        });
        // What is left out is below the last digit of what is counted.
        next = mirrored.filter(|_| left.luminance() > f64::EPSILON).and_then(|r| scene.vertex(&r));
    }
    seen
}

/// Adds up what one ray shows; what is direct is so at the first surface.
fn together(
    results: &[Measured],
    replicates: &[[f64; REPLICATES]],
) -> (Measured, [f64; REPLICATES]) {
    if let ([result], [replicates]) = (results, replicates) {
        return (*result, *replicates);
    }
    let mut sum = [0.0; REPLICATES];
    for own in replicates {
        sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
    }
    let direct = results.first().map_or(Estimate::without_error(0.0), |first| first.direct);
    let spoilt = results.iter().map(|r| r.spoilt).sum();
    (Measured { total: Estimate::of_replicates(&sum), direct, spoilt }, sum)
}

/// Measures what receivers get from the walks, and adds what they have of their own.
fn survey(
    scene: &Scene,
    receivers: &[Receiver],
    own: impl Fn(usize) -> Rgb + Sync,
    settings: &SensorSettings,
    observer: Observer,
) -> Result<Survey> {
    let launcher = Launcher::new(scene)?;
    let mut control = Control::new(settings.stop);
    let watch = Watch::new(&control, observer, 0);
    let counts = matches!(settings.estimator, SensorEstimator::Photon { .. });
    let outlook = |receiver: &Receiver| match settings.estimator {
        SensorEstimator::Local(_) => launcher.outlook(receiver),
        _ => Outlook::default(),
    };
    // What is known of each receiver before any walk; of none that the time did not suffice for.
    let prepare = |(i, receiver): (usize, &Receiver)| {
        if watch.ends() {
            return (Rgb::BLACK, Outlook::default());
        }
        let exact = if counts { Rgb::BLACK } else { direct::point_lights(scene, receiver) };
        let outlook = outlook(receiver);
        (own(i) + exact + outlook.light, outlook)
    };
    let prepared = receivers.par_iter().enumerate().map(prepare);
    let (points, outlooks): (Vec<Rgb>, Vec<Outlook>) = prepared.unzip();
    let counters = counters(scene, receivers, settings.estimator)?;
    if let (SensorEstimator::Radiosity(radiosity), false) = (&settings.estimator, watch.has_ended())
    {
        return radiosity::survey(scene, receivers, &points, radiosity, settings.stop, observer);
    }
    let mut survey = Run {
        scene,
        launcher: &launcher,
        settings,
        receivers,
        outlooks,
        efforts: vec![Effort::default(); receivers.len()],
        weightings: Vec::new(),
        counters,
        done: vec![0; receivers.len().div_ceil(SERVED_TOGETHER)],
    };
    survey.weigh(&points, &watch);
    let mut sums = vec![[Sum::default(); REPLICATES]; receivers.len()];
    let (mut done, mut escaped) = (0, 0.0);
    let mut ending = watch.has_ended().then(|| watch.ending());
    // Whether the doubling before let expect that this one meets the target. A run that stopped at the first error that happens to be small enough would
    // stop too often at one that is too small, and its intervals would hold the truth less often than they claim.
    let mut foreseen = false;
    let mut target = settings
        .stop
        .walks
        .map_or(FIRST_ROUND, |w| w.div_ceil(REPLICATES as u64).clamp(1, FIRST_ROUND));
    let ending = loop {
        if let Some(ending) = ending {
            break ending;
        }
        let block = (target - done).min(LARGEST_BLOCK).min(control.affordable(done));
        let watch = Watch::new(&control, observer, done * REPLICATES as u64);
        escaped += survey.add_walks(done, block, &mut sums, &watch);
        if watch.has_ended() {
            break watch.ending();
        }
        done += block;
        let walks = done * REPLICATES as u64;
        let doubled = done == target;
        // Where nothing has got any light after so many walks, nothing is waited for.
        let error = largest_half_width(&points, &sums, done);
        let waits = walks < ENOUGH_IN_THE_DARK && !receivers.is_empty();
        let error = error.or_else(|| (!waits).then_some(0.0));
        let judged = if doubled { 2 * walks } else { target * REPLICATES as u64 };
        let known = error.map(|error| Known { error, walks, judged });
        let reached = doubled && control.meets_target(known) && foreseen;
        if doubled {
            let nearly = settings.stop.relative_error.map(|target| SQRT_2 * target);
            foreseen = error.zip(nearly).is_some_and(|(error, nearly)| error <= nearly);
        }
        let broken = control.report(walks, observer) == ControlFlow::Break(());
        ending = if reached {
            Some(Ending::Error)
        } else if broken {
            Some(Ending::Interrupted)
        } else if doubled && control.is_open_ended() {
            Some(Ending::Walks)
        } else {
            control.is_over(walks)
        };
        if doubled && ending.is_none() {
            survey.plan(&sums, done);
            let limit = settings.stop.walks.map_or(u64::MAX, |w| w.div_ceil(REPLICATES as u64));
            target = (2 * target).min(limit);
        }
    };
    let of = |i: usize| survey.done[i / SERVED_TOGETHER];
    let own = points.par_iter().zip(&sums).enumerate();
    Ok(Survey {
        results: own.clone().map(|(i, (p, s))| result(*p, s, of(i))).collect(),
        replicates: own.map(|(i, (p, s))| replicates(*p, s, of(i), |s| s.total)).collect(),
        ending,
        walks: done * REPLICATES as u64,
        escaped: escaped / (launcher.power() * (done.max(1) * REPLICATES as u64) as f64),
        caustic: launcher.caustic_share(settings.randomness, settings.seed),
        elapsed: control.elapsed(),
        radiosity: None,
    })
}

/// Places the discs on which photons are counted; none for another estimator.
fn counters<'a>(
    scene: &Scene,
    receivers: &[Receiver<'a>],
    estimator: SensorEstimator,
) -> Result<Vec<Counter<'a>>> {
    let SensorEstimator::Photon { radius } = estimator else { return Ok(Vec::new()) };
    let radius = photon::radius(scene, radius)?;
    receivers.iter().map(|receiver| Counter::new(scene, receiver, radius)).collect()
}

struct Run<'a> {
    scene: &'a Scene,
    launcher: &'a Launcher<'a>,
    settings: &'a SensorSettings,
    receivers: &'a [Receiver<'a>],
    /// What each receiver knows of lights of simple shapes.
    outlooks: Vec<Outlook>,
    /// How many rays gather for each.
    efforts: Vec<Effort>,
    /// How light is divided for each; for the local estimate alone.
    weightings: Vec<Weighting>,
    /// Where photons are counted.
    counters: Vec<Counter<'a>>,
    /// The walks of each replicate so far, for each [`SERVED_TOGETHER`] receivers: some have more
    /// than others where the time was up in between.
    done: Vec<u64>,
}

/// The walks of one replicate that serve sensors together.
struct Served<'w> {
    replicate: usize,
    indices: std::ops::Range<u64>,
    walks: &'w [Walked<'w>],
    clouds: &'w [Cloud<'w>],
}

fn to_clouds<'a>(walks: &[Walked<'a>]) -> Vec<Cloud<'a>> {
    let clouds = walks.chunks(cloud::WALKS);
    clouds.map(|walks| Cloud::new(walks.iter().map(|walk| walk.nodes.as_slice()))).collect()
}

impl<'a> Run<'a> {
    /// Chooses how light is divided for each sensor, from the light that is known and an uncounted
    /// pilot replicate.
    fn weigh(&mut self, points: &[Rgb], watch: &Watch) {
        let SensorEstimator::Local(weighting) = self.settings.estimator else { return };
        self.weightings = vec![weighting; self.receivers.len()];
        if !matches!(weighting, Weighting::Bounded { .. }) {
            return;
        }
        let count = cloud::WALKS as u64;
        let walks: Vec<Walked> = (0..count).map(|i| self.walk(REPLICATES, i, watch)).collect();
        let clouds = to_clouds(&walks);
        let sensors = self.receivers.len();
        let weigh = |chunk: usize| {
            let mut batch = Batch::default();
            let weigh = |sensor: usize| {
                if watch.ends() {
                    return weighting;
                }
                let mut sum = Sum::default();
                let served = Served {
                    replicate: REPLICATES,
                    indices: 0..count,
                    walks: &walks,
                    clouds: &clouds,
                };
                self.serve(sensor, served, &mut batch, &mut sum, watch);
                let found = points[sensor].luminance() + sum.total / count as f64;
                weighting.raised(found / self.launcher.power())
            };
            let from = chunk * SERVED_TOGETHER;
            (from..sensors.min(from + SERVED_TOGETHER)).map(weigh).collect::<Vec<_>>()
        };
        let chunks = (0..sensors.div_ceil(SERVED_TOGETHER)).into_par_iter();
        let weightings = chunks.flat_map_iter(weigh).collect();
        self.weightings = weightings;
    }

    /// Adds the walks `first..first + count` of every replicate to every sensor, as many as there
    /// is time for; returns the flux that escaped.
    fn add_walks(
        &mut self,
        first: u64,
        count: u64,
        sums: &mut [[Sum; REPLICATES]],
        watch: &Watch,
    ) -> f64 {
        let walk = |replicate: usize| -> Vec<Walked> {
            (first..first + count).map(|i| self.walk(replicate, i, watch)).collect()
        };
        let walks: Vec<Vec<Walked>> = match self.settings.estimator {
            SensorEstimator::Path | SensorEstimator::Radiosity(_) => Vec::new(),
            SensorEstimator::Local(_) | SensorEstimator::Photon { .. } => {
                (0..REPLICATES).into_par_iter().map(walk).collect()
            }
        };
        if watch.has_ended() {
            return 0.0;
        }
        let clouds: Vec<Vec<Cloud>> = match self.settings.estimator {
            SensorEstimator::Local(_) => walks.par_iter().map(|walks| to_clouds(walks)).collect(),
            _ => Vec::new(),
        };
        let add = |chunk: usize, sums: &mut [[Sum; REPLICATES]]| -> u64 {
            let from = chunk * SERVED_TOGETHER;
            let serve = |replicate: usize| -> Vec<Sum> {
                let own = walks.get(replicate).map_or(&[][..], Vec::as_slice);
                let clouds = clouds.get(replicate).map_or(&[][..], Vec::as_slice);
                let mut batch = Batch::default();
                let mut serve = |sensor: usize| {
                    let mut sum = Sum::default();
                    let served =
                        Served { replicate, indices: first..first + count, walks: own, clouds };
                    self.serve(sensor, served, &mut batch, &mut sum, watch);
                    sum
                };
                (from..from + sums.len()).map(&mut serve).collect()
            };
            let served: Vec<Vec<Sum>> = (0..REPLICATES).into_par_iter().map(serve).collect();
            if watch.has_ended() {
                return 0;
            }
            for (replicate, served) in served.iter().enumerate() {
                for (sums, served) in sums.iter_mut().zip(served) {
                    sums[replicate].direct += served.direct;
                    sums[replicate].total += served.total;
                    sums[replicate].gathered += served.gathered;
                    sums[replicate].spoilt += served.spoilt;
                }
            }
            count
        };
        // A replicate's walks stay at hand while they serve some sensors; few sensors keep all
        // threads busy too.
        let chunks = sums.par_chunks_mut(SERVED_TOGETHER).enumerate();
        let added: Vec<u64> = chunks.map(|(chunk, sums)| add(chunk, sums)).collect();
        self.done.iter_mut().zip(added).for_each(|(done, added)| *done += added);
        if let Some(clouds) = clouds.first() {
            self.efforts.par_iter_mut().for_each(|effort| {
                let rays = clouds.iter().map(|cloud| effort.rays_for(cloud.taken()) as u64);
                effort.rays += rays.sum::<u64>();
            });
        }
        walks.iter().flatten().map(Walked::escaped).filter(|flux| flux.is_finite()).sum()
    }

    /// Plans how many rays gather for each sensor from what was seen so far.
    fn plan(&mut self, sums: &[[Sum; REPLICATES]], walks: u64) {
        self.efforts.par_iter_mut().zip(sums).for_each(|(effort, sums)| {
            let variance = |part: fn(&Sum) -> f64| {
                let means = sums.map(|s| part(&s) / (walks - s.spoilt).max(1) as f64);
                Estimate::of_replicates(&means).standard_error.powi(2)
            };
            effort.plan(walks, variance(|s| s.total - s.gathered), variance(|s| s.gathered));
        });
    }

    /// Follows a walk; what there is no time for is cut short.
    fn walk(&self, replicate: usize, index: u64, watch: &Watch) -> Walked<'a> {
        let seed = seed(self.settings.seed, replicate, WALKS);
        let stream = &mut Stream::new(self.settings.randomness, seed, index);
        let ends = || watch.ends();
        if ends() { Walked::default() } else { self.launcher.follow(stream, &ends) }
    }

    /// Adds a block of walks, or of paths when there are none, to one sensor of one replicate, if
    /// there is time.
    fn serve<'w>(
        &'w self,
        sensor: usize,
        Served { replicate, indices, walks, clouds }: Served<'w>,
        batch: &mut Batch<'w>,
        sum: &mut Sum,
        watch: &'w Watch<'w>,
    ) {
        if watch.ends() {
            return;
        }
        let receiver = &self.receivers[sensor];
        let seed = hash([seed(self.settings.seed, replicate, GATHER), sensor as u64]);
        let stream = |index| Stream::new(self.settings.randomness, seed, index);
        let mut add = |light: Light| {
            if light.total().is_finite() {
                sum.direct += light.direct.luminance();
                sum.total += light.total().luminance();
            } else {
                sum.spoilt += 1;
            }
        };
        match self.settings.estimator {
            SensorEstimator::Path => {
                let tracer = PathTracer::new(self.scene);
                let mut indices = indices.take_while(|_| !watch.ends());
                indices.by_ref().for_each(|i| add(tracer.trace(receiver, &mut stream(i))));
            }
            // Its survey is its own.
            SensorEstimator::Radiosity(_) => {}
            SensorEstimator::Photon { .. } => {
                let counter = &self.counters[sensor];
                for walk in walks {
                    add(counter.count(walk));
                }
            }
            SensorEstimator::Local(_) => {
                let weighting = self.weightings[sensor];
                let connector = Connector::new(self.scene, self.launcher, weighting).watched(watch);
                let effort = self.efforts[sensor];
                let seed = hash([seed, effort.planned]);
                let stream = |index| Stream::new(self.settings.randomness, seed, index);
                let mut rays = effort.rays - effort.planned;
                let asked = clouds.iter().map(|cloud| {
                    let (from, count) = (rays, effort.rays_for(cloud.taken()));
                    rays += count as u64;
                    (cloud, (0..count).map(move |k| stream(from + k as u64)))
                });
                let estimated = connector.estimate(batch, receiver, &self.outlooks[sensor], asked);
                for (cloud, estimated) in clouds.iter().zip(estimated) {
                    let Estimated { light, connected, .. } = estimated;
                    sum.spoilt += cloud.spoilt() as u64;
                    if light.is_finite() {
                        let walks = cloud.walks() as f64;
                        sum.direct += light.direct.luminance() * walks;
                        sum.total += estimated.luminance() * walks;
                        let gathered = light.total() - connected.total();
                        sum.gathered += gathered.luminance() * walks;
                    } else {
                        sum.spoilt += cloud.walks() as u64;
                    }
                }
            }
        }
    }
}

/// Turns the sums of one sensor into its result.
fn result(points: Rgb, sums: &[Sum; REPLICATES], walks: u64) -> Measured {
    if walks == 0 {
        return Measured::UNKNOWN;
    }
    // Light that is taken off again can come to less than nothing by chance.
    let mean = |sum| {
        let estimate = Estimate::of_replicates(&replicates(points, sums, walks, sum));
        Estimate { mean: estimate.mean.max(0.0), ..estimate }
    };
    Measured {
        total: mean(|s| s.total),
        direct: mean(|s| s.direct),
        spoilt: sums.iter().map(|s| s.spoilt).sum(),
    }
}

/// Gives the illuminance of one sensor in each replicate, lx.
fn replicates(
    points: Rgb,
    sums: &[Sum; REPLICATES],
    walks: u64,
    sum: fn(&Sum) -> f64,
) -> [f64; REPLICATES] {
    if walks == 0 {
        return [f64::NAN; REPLICATES];
    }
    let points = points.luminance();
    sums.map(|s| points + sum(&s) / (walks - s.spoilt).max(1) as f64)
}

/// Gives the largest relative 95 % half width; sensors without any light count as exact.
fn largest_half_width(points: &[Rgb], sums: &[[Sum; REPLICATES]], walks: u64) -> Option<f64> {
    points
        .par_iter()
        .zip(sums)
        .map(|(p, s)| Estimate::of_replicates(&replicates(*p, s, walks, |s| s.total)))
        .filter(|e| e.mean > 0.0)
        .map(|e| e.relative_half_width())
        .reduce_with(f64::max)
}
