//! Gives the target that `HARMOLUX_TARGET` names what the fuzzer makes.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;

static NAME: LazyLock<String> =
    LazyLock::new(|| std::env::var("HARMOLUX_TARGET").expect("HARMOLUX_TARGET names a target"));

fuzz_target!(|data: &[u8]| harmolux_fuzz::run(&NAME, data));
