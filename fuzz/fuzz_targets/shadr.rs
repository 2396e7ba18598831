//! Reads SHADR tables without sense.
#![no_main]

use harmolux::io::coefficients::SeriesFormat;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| harmolux_fuzz::series(SeriesFormat::Shadr, data));
