//! Fuzzing: see `judge_bytes`; `make fuzz` runs it.
#![no_main]

use libfuzzer_sys::fuzz_target;
use smooth_polylines_fuzz::raw::judge_bytes;

fuzz_target!(|data: &[u8]| judge_bytes(data));
