//! How long an estimate runs, and how its error is known: R independent replicates, doubled until a
//! target, a time or a number is met.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::math::choice::choice;
use crate::math::hash;

/// The number of independent replicates behind every estimate.
pub const REPLICATES: usize = 32;

/// Says when to stop; the first condition that is met ends the run. With none, the run takes its
/// smallest size.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stop {
    /// Stops when the relative standard error of 95 % of the pixels (images) or the largest
    /// relative 95 % half width (sensors) is at most this; for sensors only if half as many walks
    /// came within a factor sqrt 2 of it, so that an error that is small by chance does not end the
    /// run.
    pub relative_error: Option<f64>,
    /// Stops after this time.
    pub time: Option<Duration>,
    /// Stops after this many walks in all (sensors) or per pixel (images).
    pub walks: Option<u64>,
}

/// Says why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The number of walks was reached.
    Walks,
    /// The target error was reached.
    Error,
    /// The time was up.
    Time,
    /// The observer asked to stop.
    Interrupted,
    /// The computation came to its own end: radiosity had next to no light left.
    Converged,
}

choice!(Ending, "ending":
    Walks = "walks" "",
    Error = "relative_error" "",
    Time = "time" "",
    Interrupted = "interrupted" "",
    Converged = "converged" "",
);

/// Describes an observer how far a run is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// The finished share of the run, 0 to 1, as well as it can be foreseen.
    pub share: f64,
    /// Walks so far (in all for sensors, per pixel for images).
    pub walks: u64,
    /// The error that `Stop::relative_error` is compared with, when known.
    pub error: Option<f64>,
    /// Time since the start.
    pub elapsed: Duration,
}

/// Watches a run, from any of its threads; breaking ends it with what it has.
pub type Observer<'a> = &'a (dyn Fn(&Progress) -> ControlFlow<()> + Sync);

/// Returns the seed of one use of random numbers: (seed of the run, replicate, what for).
pub(super) fn seed(run: u64, replicate: usize, purpose: u64) -> u64 {
    hash([run, replicate as u64, purpose])
}

/// Keeps the time and the targets of a run.
pub(super) struct Control {
    stop: Stop,
    started: Instant,
    known: Option<Known>,
}

/// What is known of the error.
#[derive(Debug, Clone, Copy)]
pub(super) struct Known {
    /// The error, as it is compared with the target.
    pub(super) error: f64,
    /// The walks that it was known after.
    pub(super) walks: u64,
    /// The walks after which it is compared with the target next; then after twice as many each
    /// time.
    pub(super) judged: u64,
}

impl Known {
    /// Foresees how many walks a run takes that ends at the target (the error falls as 1/sqrt).
    fn needed(&self, target: f64) -> f64 {
        let needed = (self.error / target).powi(2) * self.walks as f64;
        let doublings = (needed / self.judged as f64).log2().ceil().max(0.0);
        self.judged as f64 * doublings.exp2()
    }
}

impl Control {
    /// Starts the clock.
    pub(super) fn new(stop: Stop) -> Self {
        Self { stop, started: Instant::now(), known: None }
    }

    /// Returns the time since the start.
    pub(super) fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    /// Notes what is known of the error, for the observer.
    pub(super) fn note(&mut self, known: Option<Known>) {
        self.known = known;
    }

    /// Notes what is known of the error after a doubling; tells whether it meets the target.
    pub(super) fn meets_target(&mut self, known: Option<Known>) -> bool {
        self.note(known);
        matches!((self.stop.relative_error, known), (Some(target), Some(k)) if k.error <= target)
    }

    /// Whether the time or the walks are used up; without any condition one round is enough.
    pub(super) fn is_over(&self, walks: u64) -> Option<Ending> {
        if self.stop.walks.is_some_and(|limit| walks >= limit) {
            return Some(Ending::Walks);
        }
        self.is_late().then_some(Ending::Time)
    }

    /// Whether any condition was given.
    pub(super) fn is_open_ended(&self) -> bool {
        self.stop == Stop::default()
    }

    /// Returns how many of a run's steps, of which `done` are done, the time left is enough for; at
    /// least one.
    pub(super) fn affordable(&self, done: u64) -> u64 {
        let Some(limit) = self.stop.time.filter(|_| done > 0) else { return u64::MAX };
        let left = limit.saturating_sub(self.elapsed()).as_secs_f64();
        ((left / self.elapsed().as_secs_f64() * done as f64) as u64).max(1)
    }

    /// Whether the time is up.
    pub(super) fn is_late(&self) -> bool {
        self.stop.time.is_some_and(|limit| self.elapsed() >= limit)
    }

    /// Reports to the observer.
    pub(super) fn report(&self, walks: u64, observer: Observer) -> ControlFlow<()> {
        self.report_share(self.share(walks), walks, observer)
    }

    /// Reports to the observer what share is finished.
    pub(super) fn report_share(
        &self,
        share: f64,
        walks: u64,
        observer: Observer,
    ) -> ControlFlow<()> {
        let error = self.known.map(|known| known.error);
        observer(&Progress { share, walks, error, elapsed: self.elapsed() })
    }

    /// Foresees the finished share: of the walks, of the time, or of the walks that the target will
    /// take.
    fn share(&self, walks: u64) -> f64 {
        let by_walks = self.stop.walks.map(|limit| walks as f64 / limit as f64);
        let by_time =
            self.stop.time.map(|t| self.elapsed().as_secs_f64() / t.as_secs_f64().max(1e-9));
        let ends = self.stop.relative_error.zip(self.known);
        let by_error = ends.map(|(target, known)| walks as f64 / known.needed(target));
        [by_walks, by_time, by_error].into_iter().flatten().fold(0.0, f64::max).min(1.0)
    }
}

/// Asks from within long work, on any thread, whether the run is to end at once: its time is up, or
/// the observer breaks it.
pub(super) struct Watch<'a> {
    control: &'a Control,
    observer: Observer<'a>,
    ended: AtomicBool,
    /// When it is asked next, milliseconds since the start.
    next: AtomicU64,
    /// The walks that are done.
    walks: AtomicU64,
}

/// The milliseconds between two questions.
const ASKED_EVERY: u64 = 20;

impl<'a> Watch<'a> {
    /// Watches a run that has done so many walks.
    pub(super) fn new(control: &'a Control, observer: Observer<'a>, walks: u64) -> Self {
        let next = AtomicU64::new(control.elapsed().as_millis() as u64 + ASKED_EVERY);
        let walks = AtomicU64::new(walks);
        Self { control, observer, ended: AtomicBool::new(false), next, walks }
    }

    /// Notes the walks that are done.
    pub(super) fn note(&self, walks: u64) {
        self.walks.store(walks, Ordering::Relaxed);
    }

    /// Whether the work is to be abandoned.
    pub(super) fn ends(&self) -> bool {
        let now = self.control.elapsed().as_millis() as u64;
        let next = self.next.load(Ordering::Relaxed);
        let (old, new) = (Ordering::Relaxed, Ordering::Relaxed);
        let asks =
            now >= next && self.next.compare_exchange(next, now + ASKED_EVERY, old, new).is_ok();
        if asks {
            let walks = self.walks.load(Ordering::Relaxed);
            let broken = self.control.report(walks, self.observer).is_break();
            if broken || self.control.is_late() {
                self.ended.store(true, Ordering::Relaxed);
            }
        }
        self.has_ended()
    }

    /// Whether any work was abandoned.
    pub(super) fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Relaxed)
    }

    /// Returns why it was.
    pub(super) fn ending(&self) -> Ending {
        if self.control.is_late() { Ending::Time } else { Ending::Interrupted }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(error: f64, walks: u64, judged: u64) -> Known {
        Known { error, walks, judged }
    }

    #[test]
    fn finished_share_is_foreseen_from_the_last_error_and_the_walks_since() {
        let mut control = Control::new(Stop { relative_error: Some(0.1), ..Stop::default() });
        assert_eq!(control.share(50), 0.0);
        // 300 walks would do; the error is judged after 100, 200, 400.
        control.note(Some(known(0.1 * 3_f64.sqrt(), 100, 100)));
        assert_eq!([100, 200, 400, 500].map(|walks| control.share(walks)), [0.25, 0.5, 1.0, 1.0]);
        control.note(Some(known(0.01, 10, 100)));
        assert_eq!(control.share(50), 0.5);
        for blind in [f64::INFINITY, f64::NAN] {
            control.note(Some(known(blind, 10, 100)));
            assert!((0.0..=1.0).contains(&control.share(50)));
        }
    }

    #[test]
    fn control_ends_on_walks_time_or_error() {
        let mut control =
            Control::new(Stop { walks: Some(10), relative_error: Some(0.1), time: None });
        assert_eq!(control.is_over(9), None);
        assert_eq!(control.is_over(10), Some(Ending::Walks));
        assert!(!control.meets_target(None) && !control.meets_target(Some(known(0.2, 8, 16))));
        assert!(control.meets_target(Some(known(0.1, 8, 16))));
        assert!(!control.meets_target(Some(known(f64::NAN, 8, 16))));
        let timed = Control::new(Stop { time: Some(Duration::ZERO), ..Stop::default() });
        assert_eq!(timed.is_over(0), Some(Ending::Time));
        assert!(Control::new(Stop::default()).is_open_ended());
    }
}
