//! Asks SH surfaces rays without sense.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| harmolux_fuzz::rays(data));
