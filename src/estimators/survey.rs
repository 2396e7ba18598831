//! Drives a survey of sensors or of rays: every walk serves every sensor (eq. 5), replicate by
//! replicate, doubled until the stop.

use std::f64::consts::SQRT_2;
use std::ops::ControlFlow;
use std::time::Duration;

use rayon::prelude::*;

use crate::math::Rgb;
use crate::math::stats::Estimate;
use crate::scene::{Measured, Scene, Sensor};
use crate::{Result, memory};

use super::cloud::Cloud;
use super::direct;
use super::estimator::{Estimator, SensorSettings};
use super::integrator::{Block, Integrator, Needs, SERVED_TOGETHER, Sum, Walks};
use super::local::{Local, to_clouds};
use super::path::Paths;
use super::photon::Counters;
use super::radiosity;
use super::receiver::Receiver;
use super::replicates::{Control, Ending, Known, Observer, REPLICATES, Watch};
use super::results::Survey;
use super::walk::{Launcher, Walked};

/// Walks per replicate of the first round, and the most that are held in memory together.
const FIRST_ROUND: u64 = 8;
const LARGEST_BLOCK: u64 = 256;
/// After how many walks a survey without any light counts as exact.
const ENOUGH_IN_THE_DARK: u64 = 1 << 20;

/// Measures illuminance, lx, at all sensors.
///
/// # Errors
/// [`crate::Error::Parameter`] when the scene has no light, or when the estimator cannot be used:
/// radiosity with an infinite surface, another reflection than Lambert's or a number of patches out
/// of range; photons on cylinders or without a radius.
pub fn illuminance(
    scene: &Scene,
    sensors: &[Sensor],
    settings: &SensorSettings,
    observer: Observer,
) -> Result<Survey> {
    ask_for(sensors.len())?;
    let receivers: Vec<_> =
        sensors.par_iter().map(|s| Receiver::sensor(&scene.settled(s))).collect();
    survey(scene, &receivers, |_| Rgb::BLACK, settings, observer)
}

/// Measures what receivers get from the samples, and adds what they have of their own.
pub(super) fn survey(
    scene: &Scene,
    receivers: &[Receiver],
    own: impl Fn(usize) -> Rgb + Sync,
    settings: &SensorSettings,
    observer: Observer,
) -> Result<Survey> {
    let launcher = Launcher::new(scene)?;
    let walks = Walks { launcher: &launcher, settings };
    let mut control = Control::new(settings.stop);
    let watch = Watch::new(&control, observer, 0);
    let mut integrator: Box<dyn Integrator> = match settings.estimator {
        Estimator::Radiosity(radiosity) => {
            let points = |i| own(i) + direct::point_lights(scene, &receivers[i]);
            let points: Vec<Rgb> = (0..receivers.len()).into_par_iter().map(points).collect();
            let stop = settings.stop;
            return radiosity::survey(scene, receivers, &points, &radiosity, stop, observer);
        }
        Estimator::Local(weighting) => {
            Box::new(Local::new(scene, walks, settings, receivers, weighting, &watch))
        }
        Estimator::Path => Box::new(Paths::new(scene, receivers)),
        Estimator::Photon { radius } => Box::new(Counters::new(scene, receivers, radius)?),
    };
    // What is known of each receiver before any sample; of none that the time did not suffice for.
    let found = integrator.finds_point_lights();
    let exact = |i| if found { Rgb::BLACK } else { direct::point_lights(scene, &receivers[i]) };
    let known = |i| if watch.ends() { Rgb::BLACK } else { own(i) + exact(i) + integrator.known(i) };
    let known: Vec<Rgb> = (0..receivers.len()).into_par_iter().map(known).collect();
    integrator.pilot(&known, &watch);
    let ending = watch.has_ended().then(|| watch.ending());
    let mut run = Run {
        walks,
        integrator,
        known,
        sums: vec![[Sum::default(); REPLICATES]; receivers.len()],
        done: 0,
        served: vec![0; receivers.len().div_ceil(SERVED_TOGETHER)],
        escaped: 0.0,
    };
    let ending = match ending {
        Some(ending) => ending,
        None => run.go_on(&mut control, observer),
    };
    Ok(run.finished(ending, control.elapsed()))
}

/// What a place takes from its receiver to its result, with the lists on the way, bytes: measured.
const BYTES_EACH: f64 = 3200.0;

/// Asks for the receivers, sums and results of so many places.
pub(super) fn ask_for(count: usize) -> Result<()> {
    let what = format_args!("a survey of {count} places");
    memory::ask_each(count, BYTES_EACH, what, "take fewer, or take them in parts")
}

/// A survey under way.
struct Run<'a> {
    walks: Walks<'a>,
    integrator: Box<dyn Integrator<'a> + 'a>,
    /// What each receiver is known to get without any sample.
    known: Vec<Rgb>,
    sums: Vec<[Sum; REPLICATES]>,
    /// The samples of each replicate so far.
    done: u64,
    /// The same for each [`SERVED_TOGETHER`] receivers: some have more than others where the time
    /// was up in between.
    served: Vec<u64>,
    /// The flux of the walks that left the scene.
    escaped: f64,
}

impl Run<'_> {
    /// Takes samples, doubling after doubling, until the stop.
    fn go_on(&mut self, control: &mut Control, observer: Observer) -> Ending {
        let stop = self.walks.settings.stop;
        let limit = stop.walks.map_or(u64::MAX, |w| w.div_ceil(REPLICATES as u64));
        let mut target = limit.clamp(1, FIRST_ROUND);
        // Whether the doubling before let expect that this one meets the target. A run that stopped
        // at the first error that happens to be small enough would stop too often at one that is
        // too small, and its intervals would hold the truth less often than they claim.
        let mut foreseen = false;
        loop {
            let block = (target - self.done).min(LARGEST_BLOCK).min(control.affordable(self.done));
            let watch = Watch::new(control, observer, self.done * REPLICATES as u64);
            self.add(block, &watch);
            if watch.has_ended() {
                return watch.ending();
            }
            self.done += block;
            let walks = self.done * REPLICATES as u64;
            let doubled = self.done == target;
            // Where nothing has got any light after so many walks, nothing is waited for.
            let waits = walks < ENOUGH_IN_THE_DARK && !self.sums.is_empty();
            let error = self.largest_half_width().or_else(|| (!waits).then_some(0.0));
            let judged = if doubled { 2 * walks } else { target * REPLICATES as u64 };
            let known = error.map(|error| Known { error, walks, judged });
            let reached = doubled && control.meets_target(known) && foreseen;
            if doubled {
                let nearly = stop.relative_error.map(|target| SQRT_2 * target);
                foreseen = error.zip(nearly).is_some_and(|(error, nearly)| error <= nearly);
            }
            let broken = control.report(walks, observer) == ControlFlow::Break(());
            let ending = if reached {
                Some(Ending::Error)
            } else if broken {
                Some(Ending::Interrupted)
            } else if doubled && control.is_open_ended() {
                Some(Ending::Walks)
            } else {
                control.is_over(walks)
            };
            if let Some(ending) = ending {
                return ending;
            }
            if doubled {
                self.integrator.plan(&self.sums, self.done);
                target = (2 * target).min(limit);
            }
        }
    }

    /// Adds the next samples of every replicate to every receiver, as many as there is time for.
    fn add(&mut self, count: u64, watch: &Watch) {
        let indices = self.done..self.done + count;
        let needs = self.integrator.needs();
        let of = |replicate| self.walks.of_replicate(replicate, indices.clone(), watch);
        let replicates = if matches!(needs, Needs::Nothing) { 0 } else { REPLICATES };
        let walks: Vec<Vec<Walked>> = (0..replicates).into_par_iter().map(of).collect();
        if watch.has_ended() {
            return;
        }
        let clouds: Vec<Vec<Cloud>> = match needs {
            Needs::Clouds => walks.par_iter().map(|walks| to_clouds(walks)).collect(),
            Needs::Nothing | Needs::Walks => Vec::new(),
        };
        let (integrator, settings) = (self.integrator.as_ref(), self.walks.settings);
        let add = |chunk: usize, sums: &mut [[Sum; REPLICATES]]| -> u64 {
            let from = chunk * SERVED_TOGETHER;
            let serve = |replicate: usize| -> Vec<Sum> {
                let block = Block {
                    replicate,
                    indices: indices.clone(),
                    walks: walks.get(replicate).map_or(&[][..], Vec::as_slice),
                    clouds: clouds.get(replicate).map_or(&[][..], Vec::as_slice),
                    randomness: settings.randomness,
                    seed: settings.seed,
                };
                integrator.serve(&block, from..from + sums.len(), watch)
            };
            let served: Vec<Vec<Sum>> = (0..REPLICATES).into_par_iter().map(serve).collect();
            if watch.has_ended() {
                return 0;
            }
            for (replicate, served) in served.iter().enumerate() {
                for (sums, served) in sums.iter_mut().zip(served) {
                    sums[replicate] += *served;
                }
            }
            count
        };
        // A replicate's walks stay at hand while they serve some sensors; few sensors keep all
        // threads busy too.
        let chunks = self.sums.par_chunks_mut(SERVED_TOGETHER).enumerate();
        let added: Vec<u64> = chunks.map(|(chunk, sums)| add(chunk, sums)).collect();
        self.served.iter_mut().zip(added).for_each(|(served, added)| *served += added);
        if let Some(clouds) = clouds.first() {
            self.integrator.note(clouds);
        }
        let escaped = walks.iter().flatten().map(Walked::escaped).filter(|flux| flux.is_finite());
        self.escaped += escaped.sum::<f64>();
    }

    /// Returns the largest relative 95 % half width; sensors without any light count as exact.
    fn largest_half_width(&self) -> Option<f64> {
        self.known
            .par_iter()
            .zip(&self.sums)
            .map(|(p, s)| Estimate::of_replicates(&replicates(*p, s, self.done, |s| s.total)))
            .filter(|e| e.mean > 0.0)
            .map(|e| e.relative_half_width())
            .reduce_with(f64::max)
    }

    fn finished(self, ending: Ending, elapsed: Duration) -> Survey {
        let of = |i: usize| self.served[i / SERVED_TOGETHER];
        let own = self.known.par_iter().zip(&self.sums).enumerate();
        let Walks { launcher, settings } = self.walks;
        let walks = self.done.max(1) * REPLICATES as u64;
        Survey {
            results: own.clone().map(|(i, (p, s))| result(*p, s, of(i))).collect(),
            replicates: own.map(|(i, (p, s))| replicates(*p, s, of(i), |s| s.total)).collect(),
            ending,
            walks: self.done * REPLICATES as u64,
            escaped: self.escaped / (launcher.power() * walks as f64),
            caustic: launcher.caustic_share(settings.randomness, settings.seed),
            elapsed,
            radiosity: None,
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
        non_finite: sums.iter().map(|s| s.non_finite).sum(),
    }
}

/// Returns the illuminance of one sensor in each replicate, lx.
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
    sums.map(|s| points + sum(&s) / (walks - s.non_finite).max(1) as f64)
}
