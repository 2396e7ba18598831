//! Signals. The first that asks the run to end does so within a fraction of a second: a run that
//! holds results only in memory saves them first, any other has nothing to lose and ends where it
//! is. The second ends it at once (but a hangup, which a closed terminal may send twice). What was
//! ignored when the run began stays ignored, as under `nohup` and in a script's background job;
//! only Linux tells what was.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGXFSZ};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::exit::Code;
use super::say;

/// Whether a signal has come.
static ASKED: AtomicBool = AtomicBool::new(false);
/// Whether the run asks for it and saves by itself.
static SAVES: AtomicBool = AtomicBool::new(false);
/// Whether a file has come to the limit on the size of files; its write says so.
#[cfg(unix)]
static BEYOND: AtomicBool = AtomicBool::new(false);
/// Held while something is being written that belongs together.
static WRITING: Mutex<()> = Mutex::new(());

/// The time between two looks.
const EVERY: Duration = Duration::from_millis(20);

/// Listens from now on.
pub(crate) fn listen() {
    let listener = std::thread::Builder::new().name("signals".to_owned());
    if listener.spawn(wait).map(drop).and_then(|()| register()).is_err() {
        say::warning("signals cannot be caught here: Ctrl-C will lose the run");
    }
}

fn register() -> io::Result<()> {
    let ignored = ignored();
    let is_ignored = |signal: i32| ignored.is_some_and(|mask| mask >> (signal - 1) & 1 == 1);
    for signal in [SIGINT, SIGTERM].into_iter().filter(|signal| !is_ignored(*signal)) {
        // In this order: only the second finds that one has come.
        flag::register_conditional_shutdown(signal, Code::Interrupted as i32, &ASKED)?;
        flag::register(signal, &ASKED)?;
    }
    #[cfg(unix)]
    {
        // A terminal that is closed may send several. Where nothing tells whether it is ignored it
        // is left alone.
        if ignored.is_some() && !is_ignored(SIGHUP) {
            flag::register(SIGHUP, &ASKED)?;
        }
        // With a handler the write that goes beyond the limit fails, and says so.
        flag::register(SIGXFSZ, &BEYOND)?;
    }
    Ok(())
}

/// Returns the signals that were ignored when the run began, signal n as bit n - 1; `None` where
/// the system has no `/proc` that says so.
fn ignored() -> Option<u64> {
    ignored_by(&std::fs::read_to_string("/proc/self/status").ok()?)
}

/// Reads the mask of ignored signals of a process's status.
fn ignored_by(status: &str) -> Option<u64> {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
    u64::from_str_radix(mask.trim(), 16).ok()
}

/// Waits for the first signal, and ends a run that has nothing to save.
fn wait() {
    while !asked() {
        std::thread::sleep(EVERY);
    }
    if SAVES.load(Ordering::SeqCst) {
        say::note("interrupted: saving what there is; again to end at once");
        return;
    }
    let _whole = writing();
    say::note("interrupted");
    harmolux::io::output::remove_empty();
    std::process::exit(Code::Interrupted as i32);
}

/// Whether the run was asked to end.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::SeqCst)
}

/// Says that from now on the run has something to save, and does so when it is asked to end.
pub(crate) fn saves() {
    SAVES.store(true, Ordering::SeqCst);
}

/// Keeps a run that ends where it is from doing so until the guard is dropped: for files that
/// belong together.
pub(crate) fn writing() -> MutexGuard<'static, ()> {
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ignored_signals_are_read_from_the_status_of_a_process() {
        let status = "Name:\tharmolux\nSigBlk:\t0000000000000002\nSigIgn:\t0000000001001003\n";
        assert_eq!(ignored_by(status), Some(0x0100_1003));
        assert_eq!(ignored_by("Name:\tharmolux\n"), None);
        assert_eq!(ignored_by("SigIgn:\tnone\n"), None);
    }
}
