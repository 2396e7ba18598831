//! How far a run is, from its start on: a bar on a terminal, a plain line now and then elsewhere;
//! always on stderr.

use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

use harmolux::error::presented;
use harmolux::estimators::Progress;
use indicatif::{ProgressBar, ProgressStyle};

use crate::common::{interrupt, say};

/// The time between plain lines, and before the first.
const PLAIN_EVERY: Duration = Duration::from_millis(4800);
/// The time between two turns of the sign that a run is at work.
const TURNS_EVERY: Duration = Duration::from_millis(120);

/// The bar on the terminal, if there is one.
static BAR: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Shows the progress of a run until it is finished or dropped.
pub(crate) struct Meter {
    /// When things were first counted, and how many were done then.
    first: OnceLock<(Instant, usize)>,
    bar: Option<ProgressBar>,
    now: Arc<Mutex<Now>>,
    /// Its end ends the plain lines.
    _lines: Option<Sender<()>>,
}

/// What a run is at.
enum Now {
    /// Work whose length is not known, and when it began.
    Stage(String, Instant),
    /// A share of the whole, and how it goes.
    Share(f64, String),
}

impl Meter {
    /// Starts to show a run that begins with this.
    pub(crate) fn start(stage: &str) -> Self {
        let now = Arc::new(Mutex::new(Now::Stage(stage.to_owned(), Instant::now())));
        let bar = std::io::stderr().is_terminal().then(|| ProgressBar::new(1000));
        let lines = if bar.is_none() { speak(now.clone()) } else { None };
        if let Some(bar) = &bar {
            announce(bar, stage);
            bar.enable_steady_tick(TURNS_EVERY);
            keep(Some(bar.clone()));
        }
        Self { first: OnceLock::new(), bar, now, _lines: lines }
    }

    /// Shows that other work begins, which says nothing of its length.
    pub(crate) fn stage(&self, stage: &str) {
        if let Some(bar) = &self.bar {
            announce(bar, stage);
        }
        self.set(Now::Stage(stage.to_owned(), Instant::now()));
    }

    /// Shows how many things are done of all.
    pub(crate) fn count(&self, done: usize, all: usize, last: &str) {
        let share = done as f64 / all.max(1) as f64;
        let (since, before) = *self.first.get_or_init(|| (Instant::now(), done));
        let elapsed = since.elapsed().as_secs_f64();
        let left = if elapsed > 1.0 && before < done && done < all {
            let left = elapsed * (all - done) as f64 / (done - before) as f64;
            format!(", about {} left", clock(left))
        } else {
            String::new()
        };
        self.share(share, format!("{done} of {all}, {last}{left}"));
    }

    /// Shows how far an estimate is, whose error has this name; asks it to end when the user does.
    pub(crate) fn show(&self, progress: &Progress, error_name: &str) -> ControlFlow<()> {
        if progress.walks > 0 {
            interrupt::saves();
        }
        self.share(progress.share, line(progress, error_name));
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Shows lines above the bar of what follows, in the place of those before.
    pub(crate) fn above(&self, lines: String) {
        if let Some(bar) = &self.bar {
            bar.set_prefix(lines);
        }
    }

    fn share(&self, share: f64, text: String) {
        if let Some(bar) = &self.bar {
            bar.set_style(style("{prefix}[{bar:32}] {percent:>3} %  {msg}"));
            bar.set_position((1000.0 * share) as u64);
            bar.set_message(presented(&text));
        }
        self.set(Now::Share(share, text));
    }

    fn set(&self, now: Now) {
        if let Ok(mut place) = self.now.lock() {
            *place = now;
        }
    }
}

impl Drop for Meter {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
            keep(None);
        }
    }
}

/// Says a plain line now and then, from a thread of its own so that it comes whatever the others
/// are at, until what is returned is dropped.
fn speak(now: Arc<Mutex<Now>>) -> Option<Sender<()>> {
    let (sender, ends) = mpsc::channel();
    let lines = move || {
        while ends.recv_timeout(PLAIN_EVERY) == Err(RecvTimeoutError::Timeout) {
            let Ok(now) = now.lock() else { return };
            let line = match &*now {
                Now::Stage(stage, since) => format!("{}  {stage}", duration(since.elapsed())),
                Now::Share(share, text) => format!("{:3.0} %  {text}", 100.0 * share),
            };
            drop(now);
            say::note(&line);
        }
    };
    let speaker = std::thread::Builder::new().name("progress".to_owned());
    speaker.spawn(lines).ok().map(|_| sender)
}

/// Shows on a bar that work begins.
fn announce(bar: &ProgressBar, stage: &str) {
    bar.set_style(style("{spinner} {msg}, {elapsed}"));
    bar.reset_elapsed();
    bar.set_message(presented(stage));
}

fn style(template: &str) -> ProgressStyle {
    let style = ProgressStyle::with_template(template);
    style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> ")
}

fn keep(bar: Option<ProgressBar>) {
    if let Ok(mut place) = BAR.lock() {
        *place = bar;
    }
}

/// Writes something on stderr beside the bar.
pub(crate) fn aside(write: impl FnOnce()) {
    let bar = BAR.lock().ok().and_then(|bar| bar.clone());
    match bar {
        Some(bar) => bar.suspend(write),
        None => write(),
    }
}

fn line(progress: &Progress, error_name: &str) -> String {
    let elapsed = progress.elapsed.as_secs_f64();
    let rate = progress.walks as f64 / elapsed.max(1e-9);
    let error =
        progress.error.map_or(String::new(), |e| format!(", {error_name} {}", say::percent(e)));
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
    fn names_do_not_steer_the_terminal() {
        let bar = ProgressBar::hidden();
        let now = Arc::new(Mutex::new(Now::Share(0.0, String::new())));
        let meter = Meter { first: OnceLock::new(), bar: Some(bar.clone()), now, _lines: None };
        meter.stage("fitting a\x1b[2J\n.obj");
        assert_eq!(bar.message(), r"fitting a\u{1b}[2J\n.obj");
        meter.count(1, 2, "b\x1b[2J.obj");
        assert_eq!(bar.message(), r"1 of 2, b\u{1b}[2J.obj");
    }

    #[test]
    fn times_read_naturally() {
        assert_eq!(clock(3.21), "3.2 s");
        assert_eq!(clock(75.0), "1 min 15 s");
        assert_eq!(clock(7260.0), "2 h 01 min");
    }
}
