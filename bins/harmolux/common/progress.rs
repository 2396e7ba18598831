//! How far a run is: a bar on a terminal, a plain line now and then elsewhere; always on stderr.

use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::Duration;

use harmolux::estimators::Progress;
use indicatif::{ProgressBar, ProgressStyle};

use crate::common::{interrupt, say};

/// Seconds between plain lines.
const PLAIN_EVERY: f64 = 5.0;

/// Shows the progress of a run.
pub(crate) struct Meter {
    bar: Option<ProgressBar>,
    /// What the error is of: "median relative error".
    error_name: &'static str,
    /// When the last plain line was said, seconds.
    spoken: Mutex<f64>,
}

impl Meter {
    /// Starts to show a run.
    pub(crate) fn start(task: &'static str, error_name: &'static str) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new(1000);
            let style = ProgressStyle::with_template("{prefix} [{bar:32}] {percent:>3} %  {msg}");
            bar.set_style(
                style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "),
            );
            bar.set_prefix(task);
            bar
        });
        Self { bar, error_name, spoken: Mutex::new(0.0) }
    }

    /// Shows how far it is; asks the run to end when the user does.
    pub(crate) fn show(&self, progress: &Progress) -> ControlFlow<()> {
        match &self.bar {
            Some(bar) => {
                bar.set_position((1000.0 * progress.share) as u64);
                bar.set_message(self.line(progress));
            }
            None => self.speak(progress),
        }
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Says a plain line when the last is some time ago.
    fn speak(&self, progress: &Progress) {
        let Ok(mut spoken) = self.spoken.lock() else { return };
        if progress.elapsed.as_secs_f64() >= *spoken + PLAIN_EVERY {
            *spoken = progress.elapsed.as_secs_f64();
            say::note(&format!("{:3.0} %  {}", 100.0 * progress.share, self.line(progress)));
        }
    }

    fn line(&self, progress: &Progress) -> String {
        let elapsed = progress.elapsed.as_secs_f64();
        let rate = progress.walks as f64 / elapsed.max(1e-9);
        let error = progress
            .error
            .map_or(String::new(), |e| format!(", {} {}", self.error_name, say::percent(e)));
        let left = if progress.share > 0.01 {
            let left = elapsed * (1.0 - progress.share) / progress.share;
            format!(", about {} left", clock(left))
        } else {
            String::new()
        };
        format!(
            "{} walks at {}/s{error}, {}{left}",
            progress.walks,
            say::significant(rate, 3),
            clock(elapsed)
        )
    }

    /// Takes the bar away.
    pub(crate) fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Writes a number of seconds as people do.
pub(crate) fn clock(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{seconds:.1} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

/// Writes a duration as people do.
pub(crate) fn duration(time: Duration) -> String {
    clock(time.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_read_naturally() {
        assert_eq!(clock(3.21), "3.2 s");
        assert_eq!(clock(75.0), "1 min 15 s");
        assert_eq!(clock(7260.0), "2 h 01 min");
    }
}
