//! Times two sides in turns, on one thread: medians and quartiles, since machines drift.

use std::time::Instant;

use harmolux::{Error, Result};

/// Holds the quartiles of some numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quartiles {
    pub(crate) first: f64,
    pub(crate) median: f64,
    pub(crate) third: f64,
}

impl Quartiles {
    /// Takes the quartiles, interpolated between neighbours.
    pub(crate) fn of(values: &[f64]) -> Self {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let place = share * sorted.len().saturating_sub(1) as f64;
            let (below, above) = (place.floor() as usize, place.ceil() as usize);
            sorted[below] + place.fract() * (sorted[above] - sorted[below])
        };
        Self { first: at(0.25), median: at(0.5), third: at(0.75) }
    }

    /// Writes "median (first to third)".
    pub(crate) fn show(self, number: impl Fn(f64) -> String) -> String {
        format!("{} ({} to {})", number(self.median), number(self.first), number(self.third))
    }
}

/// Runs `work` with all parallel loops on one thread.
pub(crate) fn on_one_thread<T: Send>(work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.map_err(|error| Error::Numeric(format!("no thread to time on: {error}")))?.install(work)
}

/// Returns the seconds that `work` takes, and what it gives.
pub(crate) fn seconds<T>(work: impl FnOnce() -> Result<T>) -> Result<(f64, T)> {
    let started = Instant::now();
    let value = work()?;
    Ok((started.elapsed().as_secs_f64(), value))
}
