//! What the fuzzers have found, each as a numbered test: the bytes mean what `support::raw` makes of them.
//!
//! A find is added here with what was wrong, before it is mended; `rust/fuzz` has the targets.

mod support;

use support::raw::{judge_bytes, judge_line, judge_mesh};

/// The bytes of a find, as the fuzzer's artifact holds them.
fn bytes(hex: &str) -> Vec<u8> {
    let digit = |i: usize| u8::from_str_radix(&hex[i..i + 2], 16).expect("two hexadecimal digits");
    (0..hex.len()).step_by(2).map(digit).collect()
}

/// `fair` on needles: a sample for each half of an edge 1e-13 long, on a line a million times as long: the memory for
/// them could not be had, which ended the process.
#[test]
fn find_1_as_many_samples_as_no_memory_holds() {
    judge_line(&bytes("21602108f60000000000ff010030ffff00faff000000f6ffff32770108ffb700000000310108770108ffb7"));
}

/// Two pins in a triangle without area, at one place on two of its edges: no line can keep their points apart.
#[test]
fn find_2_pins_at_one_place_of_a_flat_triangle() {
    for hex in [
        "ee06ff0007ffef2c88ff01ffff0001000100000000000050ef41ffffffff3c0100002bf700ff01ffffcb0b",
        "21600100faffb70000005130ffffff0a000a00fa0080ff66b7006977ffff0a00fa0080ff66b7006977ffff",
        "61602108fa10002b2c0001012b2c00004545fa9688fef781b7003151452c0000004545fa1080ff6608ffb7",
        "d208107bffffbfb900ffb7290000b12b0000002b88002b3888003824103838383839007700047e00234301",
        "0108ffb704772c88101088677700007e7e7effb704772c88101088670100007e7e7e66b7006977ffee77ff",
    ] {
        judge_line(&bytes(hex));
    }
}

/// `fair` along needles 1e-13 wide had not settled after a thousand rounds, though it went on to get better.
#[test]
fn find_3_fair_on_needles_settles_late() {
    judge_line(&bytes("f8f882f882dbdb05dbdb030303030303dbff0000b70000002b00db00dbdbdbdbdbdbdbdbdbdbdbdbdbdb5b"));
}

/// A pin at the place of the first crossing, in a triangle without area, on a line that is not smoothed.
#[test]
fn find_4_a_pin_on_the_first_crossing() {
    judge_line(&bytes(
        "21404040406025dffffff62b4e7e100000ff00002400bdb70045ffffb96025ff3cffffffffffffef41ffffffff8b8b",
    ));
}

/// `fair` on a tube 1e-15 thick, of needles: a smooth curve would wind round it for ever; steps of a hundred thousand
/// edges took minutes.
#[test]
fn find_5_fair_winds_round_a_tube_of_needles() {
    judge_line(&bytes(
        "1af13030302a1a0a0a282d2d2d9a2d000094000003000000502a1a0a0a282d2d545050ffe5e595ffffff19ebcd8c0a",
    ));
}

/// A `fair` line whose strip leaves a triangle by an edge that does not hold the line's point.
#[test]
fn find_6_a_point_off_the_strips_edge() {
    judge_line(&bytes("2bff002b00ffa8ffdada32daff00f702da1341dada2bdadadbdaffdafeffffffffffdafeff30a9da14"));
}

/// `fair` between the two sides of one triangle 1e-15 high: some thousand turns round it in each of many rounds.
#[test]
fn find_7_fair_winds_round_a_needle() {
    judge_line(&bytes(
        "ff2b002b00ffa8ffff00f7bfbfbfbfbfda2bdaf700da04dadada2bdadadadadadaffffffffbfdff77dbfdf0000dada14",
    ));
}

/// Two crossings and a pin at one place of a triangle without area: one crossing was moved off the pin onto the other, and
/// off that back onto the pin.
#[test]
fn find_8_a_crossing_nudged_to_and_fro() {
    judge_line(&bytes("b9960001960000b6000000007bdfffffffffff4800000000000000fbffff00000000000000898989892b"));
}

/// A ring whose strip turned back across the seam, once a full turn round a vertex had been cut out of it.
#[test]
fn find_9_a_ring_turns_back_across_its_seam() {
    judge_line(&bytes(
        "ffd5ffd4393600d400d4ff350600363535002b35a9fffffffffafafa60fa25202941ffff25002b410034362d3653a9f2faff05fb2b",
    ));
}

/// `fair` on needles crept, each step a ten-thousandth of a piece: one had not settled after 20 000 rounds, others took seconds.
#[test]
fn find_10_fair_creeps_on_needles() {
    for hex in [
        "007d002b6a6abf4b0072000000ffffffffff4c4c4c4cffffffffffbf4bffffffffff30ffffffff402bffef",
        "5b21a7a866ada3a7a1a7a7e258080106000000f900a30072a1a7faff00aa152ba8aaaa152ba8aaf3559f58",
        "5b21a7a85e585c535e58581da368aa5eaa785e581da300aaa0a7faff00aa132ba8aaaa15a82baaf3559f50",
    ] {
        judge_line(&bytes(hex));
    }
}

/// Any short input means something to each target.
#[test]
fn nothing_and_little_are_judged() {
    for length in 0..40 {
        for fill in [0u8, 1, 77, 255] {
            let data = vec![fill; length];
            judge_line(&data);
            judge_bytes(&data);
            judge_mesh(&data);
        }
    }
}
