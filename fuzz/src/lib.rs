//! The targets of the test suite's short fuzz, for cargo-fuzz.

use std::alloc::System;
use std::path::Path;

use cap::Cap;

#[path = "../../tests/fuzz/seeds.rs"]
mod seeds;
#[path = "../../tests/fuzz/targets.rs"]
mod targets;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Returns what to start from: target, name and bytes.
///
/// # Errors
/// A fixture that cannot be read.
pub fn seeds(
    package: &Path,
) -> Result<Vec<(&'static str, String, Vec<u8>)>, Box<dyn std::error::Error>> {
    seeds::all(package)
}

/// Gives a target some bytes.
///
/// # Panics
/// When there is no such target, or when it fails.
pub fn run(name: &str, data: &[u8]) {
    let target = targets::TARGETS.iter().find(|(n, ..)| *n == name);
    target.expect("a target of this name").2(data);
}
