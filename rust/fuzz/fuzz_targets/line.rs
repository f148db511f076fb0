//! Fuzzing: see `judge_line`; `make fuzz` runs it.
#![no_main]

use libfuzzer_sys::fuzz_target;
use smooth_polylines_fuzz::raw::judge_line;

fuzz_target!(|data: &[u8]| judge_line(data));
