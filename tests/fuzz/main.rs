//! A short fuzz of every target: hundreds or thousands of inputs, the same at each run, made by
//! damaging the seeds. The folder `fuzz` asks the same of millions, led by coverage.

mod seeds;
mod targets;

use std::alloc::System;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use cap::Cap;
use harmolux::math::hash;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// The longest that an input may take, on a machine that has other things to do, too.
const LONGEST: Duration = Duration::from_secs(20);

/// What is put in the place of bytes: what numbers, counts and separators may turn into.
const WORDS: [&[u8]; 16] = [
    b"-1",
    b"0",
    b"1e308",
    b"-1e-320",
    b"nan",
    b"inf",
    b"4294967295",
    b"99999999999999999999",
    b"\n",
    b"\r",
    b" ",
    b"#",
    b"\0",
    b"\xff\xff\xff\xff",
    b"\0\0\0\x80",
    b"\x7f\xf0\0\0\0\0\0\0",
];

#[test]
fn nothing_that_is_damaged_makes_a_target_panic() {
    let seeds = seeds::all(Path::new(env!("CARGO_MANIFEST_DIR"))).expect("seeds");
    for (number, (name, inputs, target)) in targets::TARGETS.iter().enumerate() {
        let own: Vec<&[u8]> =
            seeds.iter().filter(|(t, ..)| t == name).map(|(.., b)| b.as_slice()).collect();
        assert!(!own.is_empty(), "{name} has no seed");
        for case in 0..*inputs {
            let input = damaged(&own, [number as u64, case]);
            let begun = Instant::now();
            let survived = catch_unwind(AssertUnwindSafe(|| target(&input)));
            assert!(
                survived.is_ok() && begun.elapsed() < LONGEST,
                "{name}, case {case}: {:?}",
                String::from_utf8_lossy(&input)
            );
        }
    }
}

/// Damages a seed in one to four places.
fn damaged(seeds: &[&[u8]], case: [u64; 2]) -> Vec<u8> {
    let mut drawn = 0;
    let mut draw = |below: usize| {
        drawn += 1;
        (hash([case[0], case[1], drawn]) % below.max(1) as u64) as usize
    };
    let mut bytes = seeds[draw(seeds.len())].to_vec();
    for _ in 0..=draw(4) {
        let at = draw(bytes.len());
        let end = (at + 1 + draw(16)).min(bytes.len());
        match draw(7) {
            0 if at < end => bytes[at] ^= 1 << draw(8),
            1 if at < end => bytes[at] = draw(256) as u8,
            2 => drop(bytes.drain(at..end)),
            3 => bytes.truncate(at),
            4 => {
                let repeated = bytes[at..end].repeat(1 + draw(20));
                drop(bytes.splice(at..at, repeated));
            }
            5 => drop(bytes.splice(at..end, WORDS[draw(WORDS.len())].iter().copied())),
            _ => {
                let other = seeds[draw(seeds.len())];
                let from = draw(other.len());
                drop(bytes.splice(at..end, other[from..].iter().take(64).copied()));
            }
        }
    }
    bytes
}
