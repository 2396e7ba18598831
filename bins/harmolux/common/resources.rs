//! What a run takes of the machine: threads and memory.

use std::num::NonZero;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::thread;

use harmolux::memory;
use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};
use signal_hook::consts::SIGABRT;

use crate::common::{exit, say};

/// The most threads that are started for each core: more have nothing to do but wait.
const MOST_PER_CORE: usize = 16;

/// The variable that names the number of threads.
const THREADS: &str = "RAYON_NUM_THREADS";

/// The variable that bounds the arenas of glibc's allocator, which take 64 MB of addresses for each
/// thread.
#[cfg(unix)]
const ARENAS: &str = "MALLOC_ARENA_MAX";

/// Lets the run end with the exit code of a failure where an allocation that nobody asked for
/// beforehand is refused: the runtime says on stderr how much it was, and aborts.
pub(crate) fn fail_when_memory_is_out() {
    let always = Arc::new(AtomicBool::new(true));
    let code = exit::Code::Failed as i32;
    if signal_hook::flag::register_conditional_shutdown(SIGABRT, code, always).is_err() {
        say::warning("aborts cannot be caught here");
    }
}

/// Bounds the memory of the process.
pub(crate) fn limit_memory(bytes: u64) {
    memory::limit(bytes);
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
        let most = getrlimit(Resource::Data);
        let limit = Rlimit { current: Some(bytes.min(most.current.unwrap_or(bytes))), ..most };
        if setrlimit(Resource::Data, limit).is_err() {
            say::warning("the system sets no limit: small requests are not bounded");
        }
    }
}

/// Reads a number of bytes such as 500M.
pub(crate) fn bytes(text: &str) -> Result<u64, String> {
    let (digits, power) = match text.char_indices().next_back() {
        Some((end, 'K' | 'k')) => (&text[..end], 10),
        Some((end, 'M' | 'm')) => (&text[..end], 20),
        Some((end, 'G' | 'g')) => (&text[..end], 30),
        Some((end, 'T' | 't')) => (&text[..end], 40),
        _ => (text, 0),
    };
    let count: Option<u64> = digits.parse().ok().filter(|count| *count > 0);
    let whole = count.and_then(|count| count.checked_mul(1 << power));
    whole.ok_or_else(|| "a number of bytes above 0, or one with K, M, G or T behind".to_owned())
}

/// Starts as many threads as are asked for, by default one per core; fewer, with a warning, where
/// these are more than are of use or than the system starts.
pub(crate) fn start_threads(asked: Option<u16>) -> Result<(), ThreadPoolBuildError> {
    #[cfg(unix)]
    if memory::address_limit().is_some() && std::env::var_os(ARENAS).is_none() {
        run_anew_with(ARENAS, 1);
    }
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let named = std::env::var(THREADS).ok().and_then(|n| n.parse().ok()).filter(|n| *n > 0);
    let wanted = asked.map(usize::from).or(named).unwrap_or(cores);
    let most = MOST_PER_CORE * cores;
    let useful = wanted.min(most);
    let possible = startable(useful);
    // Where not all could be started, the rest of the work needs some memory as well.
    let count = if possible < useful { possible / 2 } else { useful };
    let anew = cfg!(unix) && named.is_some_and(|named| named > most);
    // Else it would be said twice.
    if count < wanted && !(anew && asked.is_some()) {
        say::warning(&format!("{} threads are used instead of {wanted}", count.max(1)));
    }
    #[cfg(unix)]
    if anew {
        run_anew_with(THREADS, most);
    }
    let pool = ThreadPoolBuilder::new().num_threads(count.max(1));
    if count == 0 { pool.use_current_thread().build_global() } else { pool.build_global() }
}

/// Runs the program anew with a number in its environment, where others look for it: glibc, and the
/// coder of EXR pictures for its threads. Goes on where that cannot be done.
#[cfg(unix)]
fn run_anew_with(name: &str, number: usize) {
    use std::os::unix::process::CommandExt;
    let mut words = std::env::args_os();
    let (called, program) = (words.next().unwrap_or_default(), std::env::current_exe());
    if let Ok(program) = program {
        let mut command = std::process::Command::new(program);
        // Returns only where it failed.
        let _ = command.arg0(called).args(words).env(name, number.to_string()).exec();
    }
}

/// Tries how many of `count` threads the system starts.
fn startable(count: usize) -> usize {
    let gate = Mutex::new(());
    thread::scope(|scope| {
        // Open when this block ends, before the threads are waited for.
        let _closed = gate.lock();
        let wait = || drop(gate.lock());
        let starts = |_: &usize| thread::Builder::new().spawn_scoped(scope, wait).is_ok();
        (0..count).take_while(starts).count()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_bytes_are_read() {
        for (text, count) in [("4096", 4096), ("1k", 1024), ("500M", 500 << 20), ("2G", 2 << 30)] {
            assert_eq!(bytes(text), Ok(count));
        }
        for text in ["", "G", "0", "-1", "1.5G", "2GB", "99999999T", "é"] {
            assert!(bytes(text).is_err(), "{text}");
        }
    }

    #[test]
    fn threads_can_be_started() {
        assert_eq!(startable(3), 3);
    }
}
