//! What memory is free, asked before much of it is taken: what does not fit is an error with a
//! message, not an abort in the middle.
//!
//! Small things are not asked for. Whoever knows beforehand that it needs much (a film, a degree,
//! a mesh, a header's counts) asks once for the sum.

use std::fmt::Display;
use std::io::{BufRead, ErrorKind, Read};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::shown_path;
use crate::{Error, Result};

/// The bytes that are given without a look at what is free.
const SMALL: u64 = 1 << 20;

/// The most bytes that are read of a line of text.
pub const MAX_LINE: usize = 1 << 26;

static LIMIT: AtomicU64 = AtomicU64::new(u64::MAX);

/// Bounds what [`ask`] gives: the whole process may take so many bytes.
pub fn limit(bytes: u64) {
    LIMIT.store(bytes, Ordering::Relaxed);
}

/// Returns the number of bytes that may still be taken: what the machine, the control groups, the
/// limits of the process and [`limit`] leave. Only Linux tells the first three.
pub fn free() -> u64 {
    let status = read("/proc/self/status");
    let now = |key: &str| kilobytes(&status, key).unwrap_or(0);
    let limits = read("/proc/self/limits");
    let machine = read("/proc/meminfo");
    let available = kilobytes(&machine, "MemAvailable:")
        .map(|bytes| bytes.saturating_add(kilobytes(&machine, "SwapFree:").unwrap_or(0)));
    let bounds = [
        (Some(LIMIT.load(Ordering::Relaxed)), now("VmData:")),
        (soft_limit(&limits, "Max data size"), now("VmData:")),
        (soft_limit(&limits, "Max address space"), now("VmSize:")),
        (available, 0),
    ];
    let left = bounds.into_iter().filter_map(|(most, taken)| Some(most?.saturating_sub(taken)));
    left.chain(left_by_groups()).min().unwrap_or(u64::MAX)
}

/// Returns what the control group of the process leaves, and each that it is in.
fn left_by_groups() -> Vec<u64> {
    let groups = read("/proc/self/cgroup");
    let own = groups.lines().find_map(|line| line.strip_prefix("0::/")).unwrap_or("");
    let number = |folder: &Path, name: &str| read(folder.join(name)).trim().parse::<u64>().ok();
    let left = |group: &Path| {
        let folder = Path::new("/sys/fs/cgroup").join(group);
        let most = number(&folder, "memory.max")?;
        Some(most.saturating_sub(number(&folder, "memory.current")?))
    };
    Path::new(own).ancestors().filter_map(left).collect()
}

/// Returns the bound on the addresses of the process (`ulimit -v`), bytes; `None` where there is
/// none, or where the system does not tell.
pub fn address_limit() -> Option<u64> {
    soft_limit(&read("/proc/self/limits"), "Max address space")
}

/// Asks for `bytes` for `what`, which is named in an error. `smaller` says what would fit, from the
/// share of the bytes that are free, and how to choose it.
///
/// # Errors
/// [`Error::Memory`] when they are not free.
pub fn ask(bytes: f64, what: impl Display, smaller: impl FnOnce(f64) -> String) -> Result<()> {
    let refused = faults::strikes();
    if !refused && bytes <= SMALL as f64 && is_given(bytes) {
        return Ok(());
    }
    let free = if refused { 0 } else { free() };
    if !refused && bytes <= free as f64 && is_given(bytes) {
        return Ok(());
    }
    // Nine tenths: the rest of the work needs some as well.
    let share = (0.9 * free as f64 / bytes).min(0.9);
    let (bytes, free) = (in_words(bytes), in_words(free as f64));
    Err(Error::Memory(format!("{what} needs {bytes}, {free} are free: {}", smaller(share))))
}

/// Asks for `each` bytes for each of `count` things, which `what` names; `advice` says how to choose
/// fewer.
///
/// # Errors
/// As [`ask`].
pub fn ask_each(count: usize, each: f64, what: impl Display, advice: &str) -> Result<()> {
    ask(each * count as f64, what, |share| {
        format!("about {:.0} of {count} would fit; {advice}", (share * count as f64).floor())
    })
}

/// Reads to the end, at most a third of what is free: what is read is decoded next to it. `path` is
/// for errors.
///
/// # Errors
/// [`Error::Memory`] when it does not end before, [`Error::Io`] when it cannot be read.
pub fn read_to_end(path: &Path, reader: impl Read) -> Result<Vec<u8>> {
    let most = free() / 3;
    let mut bytes = Vec::new();
    let read = reader.take(most.saturating_add(1)).read_to_end(&mut bytes);
    read.map_err(|e| Error::io(path, "read", e))?;
    if bytes.len() as u64 > most || faults::strikes() {
        let (path, most) = (shown_path(path), in_words(most as f64));
        return Err(Error::Memory(format!(
            "{path}: it does not end within {most}, a third of the memory that is free: take a \
             smaller file, or free some"
        )));
    }
    Ok(bytes)
}

/// Adds the next line to `line`, with its end: a line feed, a carriage return, or both. Returns the
/// bytes that were read.
///
/// # Errors
/// What the reader says, and `FileTooLarge` for a line longer than [`MAX_LINE`].
pub fn read_line(reader: &mut dyn BufRead, line: &mut Vec<u8>) -> std::io::Result<usize> {
    let read = read_half_line(reader, line)?;
    if read == 0 || line.last() != Some(&b'\r') || reader.fill_buf()?.first() != Some(&b'\n') {
        return Ok(read);
    }
    reader.consume(1);
    line.push(b'\n');
    Ok(read + 1)
}

/// Adds the next line as [`read_line`] does, but leaves the line feed behind a carriage return.
pub(crate) fn read_half_line(
    reader: &mut dyn BufRead,
    line: &mut Vec<u8>,
) -> std::io::Result<usize> {
    let start = line.len();
    loop {
        let read = line.len() - start;
        let bytes = match reader.fill_buf() {
            Ok(bytes) => &bytes[..bytes.len().min(MAX_LINE - read)],
            Err(e) if e.kind() == ErrorKind::Interrupted => continue,
            Err(e) => return Err(e),
        };
        let end = bytes.iter().position(|b| matches!(b, b'\n' | b'\r'));
        let taken = end.map_or(bytes.len(), |end| end + 1);
        line.extend_from_slice(&bytes[..taken]);
        reader.consume(taken);
        if end.is_some() || taken == 0 && read < MAX_LINE {
            return Ok(read + taken);
        }
        if taken == 0 {
            let said = format!("a line does not end within {}", in_words(MAX_LINE as f64));
            return Err(std::io::Error::new(ErrorKind::FileTooLarge, said));
        }
    }
}

/// Writes a number of bytes in units of 1000, with three digits.
pub fn in_words(bytes: f64) -> String {
    let units = ["B", "kB", "MB", "GB", "TB", "PB"];
    let power = (bytes.max(1.0).log10() / 3.0).floor().min(5.0);
    let value = bytes / 1000_f64.powf(power);
    let decimals = if power == 0.0 || value >= 100.0 { 0 } else { 1 + usize::from(value < 10.0) };
    format!("{value:.decimals$} {}", units[power as usize])
}

/// Whether the allocator gives so many bytes at present.
fn is_given(bytes: f64) -> bool {
    let mut room = Vec::<u8>::new();
    let given = bytes < isize::MAX as f64 && room.try_reserve_exact(bytes as usize).is_ok();
    // Otherwise the compiler may leave out what is not used.
    std::hint::black_box(room);
    given
}

fn read(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(path).unwrap_or_default()
}

/// Finds a number of kilobytes in lines of key and value, in bytes.
fn kilobytes(lines: &str, key: &str) -> Option<u64> {
    let value = lines.lines().find_map(|line| line.strip_prefix(key))?;
    value.trim().strip_suffix(" kB")?.parse::<u64>().ok()?.checked_mul(1024)
}

/// Finds the soft limit in the table of limits; `None` when there is none.
fn soft_limit(limits: &str, name: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(not(test))]
mod faults {
    pub(super) fn strikes() -> bool {
        false
    }
}

/// Lets the k-th request of the present thread fail.
#[cfg(test)]
pub(crate) mod faults {
    use std::cell::Cell;

    thread_local! {
        static LEFT: Cell<Option<usize>> = const { Cell::new(None) };
    }

    /// Whether the present request is the one to fail.
    pub(super) fn strikes() -> bool {
        LEFT.with(|left| {
            let now = left.get();
            left.set(now.and_then(|n| n.checked_sub(1)));
            now == Some(0)
        })
    }

    /// Runs `work` with its first request refused, then with its second, and so on, until it
    /// succeeds; returns how often it failed.
    pub(crate) fn in_turn<T>(mut work: impl FnMut() -> crate::Result<T>) -> usize {
        for k in 0.. {
            LEFT.set(Some(k));
            let done = work();
            let was_refused = LEFT.replace(None).is_none();
            match done {
                Ok(_) => {
                    assert!(!was_refused, "request {k} was refused and nobody said so");
                    return k;
                }
                Err(error) => assert!(was_refused, "{error}"),
            }
        }
        unreachable!("a usize has an end")
    }
}

#[cfg(test)]
mod tests {
    use std::io::BufReader;

    use glam::DVec3;

    use super::*;
    use crate::fit::{Check, CheckSettings, FitSettings, Resolution, fit, tessellate};
    use crate::mesh::{RepairSettings, repair};
    use crate::scene::Film;
    use crate::sh::{Coefficients, Grid, Transform};
    use crate::surface::{Intersector, MeshSurface, ShSurface};

    #[test]
    fn what_cannot_fit_is_refused_with_what_would() {
        let ask = |bytes| ask(bytes, "a film", |share| format!("{share:.0e} of it would fit"));
        assert!(ask(0.0).is_ok() && ask(1e5).is_ok() && ask(4e6).is_ok());
        for bytes in [1e17, 1e30, f64::INFINITY, f64::NAN] {
            let error = ask(bytes).expect_err("no machine has so much");
            assert!(matches!(error, Error::Memory(_)), "{error}");
            assert!(error.to_string().starts_with("a film needs "), "{error}");
        }
        let error = ask_each(10, 1e17, "ten films", "take fewer").expect_err("too much");
        assert!(error.to_string().ends_with(": about 0 of 10 would fit; take fewer"), "{error}");
    }

    #[test]
    fn every_request_that_is_refused_is_told() {
        let mut ball = Coefficients::zeros(4);
        ball.set(0, 0, 1.0, 0.0);
        let tessellated = || tessellate(&ball, DVec3::ZERO, Resolution::Icosphere { frequency: 2 });
        let finer = Resolution::Adaptive { tolerance: 0.1 };
        let mesh = tessellated().expect("small").mesh;
        for (name, requests) in [
            ("film", faults::in_turn(|| Film::new([4, 4], 2))),
            ("transform", faults::in_turn(|| Transform::new(8, Grid::minimal(8)))),
            ("mesh", faults::in_turn(tessellated)),
            ("refined mesh", faults::in_turn(|| tessellate(&ball, DVec3::ZERO, finer))),
            ("rays at a mesh", faults::in_turn(|| MeshSurface::new(mesh.clone()))),
            ("rays at a shape", faults::in_turn(|| ShSurface::new(&ball, Intersector::default()))),
            ("repair", faults::in_turn(|| repair(&mesh, &RepairSettings::default()))),
            ("check", faults::in_turn(|| Check::of(&mesh, &CheckSettings::default()))),
            ("fit", faults::in_turn(|| fit(&mesh, &FitSettings::of_degree(4)))),
        ] {
            assert!(requests > 0, "{name}");
        }
    }

    #[test]
    fn a_line_without_end_is_cut() {
        let mut endless = BufReader::new(std::io::repeat(b'1'));
        let error = read_line(&mut endless, &mut Vec::new()).expect_err("it has no end");
        assert_eq!(error.to_string(), "a line does not end within 67.1 MB");
        let (mut two, mut line) = (&b"a\nb"[..], Vec::new());
        let reads: Vec<_> = (0..3).map(|_| read_line(&mut two, &mut line).expect("read")).collect();
        assert!(reads == [2, 1, 0] && line == b"a\nb");
    }

    #[test]
    fn lines_end_at_feed_return_or_both() {
        // A buffer of one byte: an end may be cut in two.
        for capacity in [1, 64] {
            let mut text = BufReader::with_capacity(capacity, &b"a\rb\r\n\n\rc\r"[..]);
            let mut lines = Vec::new();
            loop {
                let mut line = Vec::new();
                let read = read_line(&mut text, &mut line).expect("read");
                assert_eq!(read, line.len());
                if read == 0 {
                    break;
                }
                lines.push(String::from_utf8(line).expect("text"));
            }
            assert_eq!(lines, ["a\r", "b\r\n", "\n", "\r", "c\r"]);
        }
    }

    #[test]
    fn numbers_of_bytes_read_naturally() {
        for (bytes, words) in [
            (0.0, "0 B"),
            (999.0, "999 B"),
            (2048.0, "2.05 kB"),
            (3.2e10, "32.0 GB"),
            (1e18, "1000 PB"),
        ] {
            assert_eq!(in_words(bytes), words);
        }
    }

    #[test]
    fn the_system_s_tables_are_understood() {
        let status = "VmPeak:\t  100 kB\nVmData:\t     372 kB\n";
        assert_eq!(kilobytes(status, "VmData:"), Some(372 * 1024));
        assert_eq!(kilobytes(status, "VmSize:"), None);
        let limits = "Limit                     Soft Limit           Hard Limit           Units\n\
                      Max data size             unlimited            unlimited            bytes\n\
                      Max address space         52428800             unlimited            bytes\n";
        assert_eq!(soft_limit(limits, "Max address space"), Some(52_428_800));
        assert_eq!(soft_limit(limits, "Max data size"), None);
        assert!(free() > 0);
    }

    #[test]
    fn what_does_not_end_in_time_is_an_error() {
        let whole = || read_to_end(Path::new("a"), &b"short"[..]);
        assert_eq!(whole().expect("it ends"), b"short");
        assert_eq!(faults::in_turn(whole), 1);
    }
}
