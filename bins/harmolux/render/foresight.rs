//! Whether a time limit suffices, judged while there is time to change it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use harmolux::estimators::{ImageSettings, Progress, walks_per_sample};

use crate::common::{progress, say};

/// Foresees whether the time suffices for two passes, without which no error is known, and says so
/// once if not.
pub(crate) struct Foresight {
    limit: Option<Duration>,
    passes: f64,
    looked: AtomicBool,
}

impl Foresight {
    /// Takes the time limit of a run.
    pub(crate) fn new(settings: &ImageSettings) -> Self {
        let passes = 2.0 * walks_per_sample(&settings.estimator) as f64;
        Self { limit: settings.stop.time, passes, looked: AtomicBool::new(false) }
    }

    /// Looks, once a tenth of the time is over, at how far the run is.
    pub(crate) fn look(&self, progress: &Progress) {
        let Some(limit) = self.limit else { return };
        let share = progress.elapsed.as_secs_f64() / limit.as_secs_f64().max(1e-9);
        if share < 0.1 || self.looked.swap(true, Ordering::Relaxed) {
            return;
        }
        let walks = progress.walks as f64 / share.max(1e-9);
        if walks < self.passes {
            say::warning(&format!(
                "at this rate {} do not suffice for two passes, so no error will be known; give \
                 it more time (`render.stop.time`), or take a smaller `--size`",
                progress::duration(limit)
            ));
        }
    }
}
