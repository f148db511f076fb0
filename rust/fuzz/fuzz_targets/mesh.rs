//! Fuzzing: see `judge_mesh`; `make fuzz` runs it.
#![no_main]

use libfuzzer_sys::fuzz_target;
use smooth_polylines_fuzz::raw::judge_mesh;

fuzz_target!(|data: &[u8]| judge_mesh(data));
