//! The stages of step C for the paper's filters: what brings a line to rest, how near, and with how much work.
//!
//! Every stage is followed by step D, and comes again as long as that finds something to do. Passing vertices early spares
//! most of the moves: a line that has to pass a vertex crowds there ever more slowly. Holds the order and the limits; the
//! rounds are in `smooth_sliding`.

use std::collections::VecDeque;

use crate::filter::SlidingFilter;
use crate::options::{DEFAULT_SUPPORT, Options, Solver};

/// In which order crossings move that move one at a time.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Order {
    /// The paper's: the one that is most wrong first.
    Heap,
    /// Along the line, to and fro.
    Sweeps,
}

impl Order {
    /// Sweeps, except where the paper's heap was asked for, and for `linear`, which Newton brings to rest.
    pub fn of(filter: &impl SlidingFilter, options: &Options) -> Self {
        if options.solver == Solver::Auto && filter.reach() > 1 { Self::Sweeps } else { Self::Heap }
    }
}

/// One stage.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Stage {
    /// Newton to the filter's own fixed point, with the heap where it fails; the only stage of its line. `moves`: those that
    /// the heap may take.
    Newton {
        /// In barycentric units, of the heap.
        threshold: f64,
        /// See above.
        moves: u64,
    },
    /// The paper's step C, one crossing after the other in the line's [`Order`], until none is further than `threshold` from
    /// its target. `moves`: those that it may take after the stage before; `None`: what is left of that one's.
    OneByOne {
        /// In barycentric units.
        threshold: f64,
        /// See above.
        moves: Option<u64>,
    },
    /// Some moves one by one and steps of all crossings at once, [`STEPS_A_ROUND`] before each step D; whatever comes of them,
    /// the next stage goes on.
    Implicit {
        /// In barycentric units: where they end.
        threshold: f64,
        /// Band solves that are left.
        steps: u64,
    },
    /// For lines that moves one by one have not brought to rest: steps of all crossings at once and spells of such moves in
    /// turns. Passed over where they have.
    Rest {
        /// In barycentric units.
        threshold: f64,
        /// Most band solves before each spell; they end where they do no good.
        steps: u64,
        /// Moves that are left for all spells.
        moves: u64,
    },
}

impl Stage {
    /// How near to rest it brings the line, in barycentric units.
    pub fn threshold(&self) -> f64 {
        match *self {
            Self::Newton { threshold, .. }
            | Self::OneByOne { threshold, .. }
            | Self::Implicit { threshold, .. }
            | Self::Rest { threshold, .. } => threshold,
        }
    }
}

/// One by one step C begins with this threshold, and goes on with finer ones when step D finds nothing to do.
const FIRST_THRESHOLD: f64 = 1e-3;

/// Each finer threshold as a share of the one before.
const NEXT_THRESHOLD: f64 = 0.1;

/// Down to this threshold moves one by one are quick.
const COARSE_THRESHOLD: f64 = 1e-2;

/// Steps of all crossings at once before the first threshold. They take what is long on the line as far as moves one by one do
/// in some forty a crossing. With 24 strokes take a sixth longer and turn 2 % less (measured on 78 lines).
const IMPLICIT_STEPS: u64 = 16;

/// Moves for each crossing before such steps: what is short on the line holds the steps up, and a sweep or two smooth it.
/// Measured on 78 lines: with 12 one closed line went on round its picks twice.
pub const MOVES_BEFORE_STEPS: u64 = 4;

/// Of the steps, so many before vertices are passed: a line that comes to rest in a strip that it has to leave crowds at
/// vertices, and turns more in the end (by a sixth with sixteen steps in a row, measured on 29 lines).
pub const STEPS_A_ROUND: u64 = 8;

/// Lines of fewer crossings begin with moves one by one, which take longer in all, but not long there: measured on 59 lines, they
/// find the better side of more mesh vertices on coarse meshes, and shorter lines.
const FEWEST_CROSSINGS: usize = 600;

/// No further than this a `cubic` line is brought to rest while picks are dragged. Measured on four scans: as near to the line made
/// afresh at 1e-4 as with a draft at 1e-4 (a third to two thirds of an edge at most, a twentieth on average), as straight to a
/// twentieth, in a fifth of the time; at 1e-2 drafts turn a fifth more.
const DRAFT_THRESHOLD: f64 = 5e-3;

/// Steps of all crossings at once between two spells of moves one by one, on lines that these have begun: with sixteen lines
/// turn more in the end (by a seventh, measured on 59 lines).
const STEPS_BEFORE_SPELL: u64 = 6;

/// The stages of a line of so many crossings, the last at `last_threshold`; by Newton there is but one. `is_draft`: the line
/// is made again for a while, as picks are dragged.
pub fn choose_stages(
    filter: &impl SlidingFilter,
    options: &Options,
    by_newton: bool,
    last_threshold: f64,
    crossings: usize,
    is_draft: bool,
) -> VecDeque<Stage> {
    let moves = move_limit(crossings, filter.reach());
    let mut stages = VecDeque::new();
    if by_newton {
        return VecDeque::from([Stage::Newton { threshold: last_threshold, moves }]);
    }
    // `linear`, and the paper's heap where it was asked for, go on to the end.
    let is_free = options.solver == Solver::Auto && filter.reach() > 1;
    let last_threshold = if is_draft && is_free { last_threshold.max(DRAFT_THRESHOLD) } else { last_threshold };
    let may_step = is_free && filter.reach() == DEFAULT_SUPPORT;
    let at_once = may_step && crossings >= FEWEST_CROSSINGS;
    if at_once && last_threshold < COARSE_THRESHOLD {
        let threshold = last_threshold.max(FIRST_THRESHOLD);
        stages.push_back(Stage::Implicit { threshold, steps: IMPLICIT_STEPS });
    }
    let mut threshold = last_threshold.max(FIRST_THRESHOLD);
    stages.push_back(Stage::OneByOne { threshold, moves: Some(moves) });
    while threshold > last_threshold {
        threshold = (threshold * NEXT_THRESHOLD).max(last_threshold);
        let moves = (filter.reach() > 1).then(|| finer_move_limit(crossings, at_once));
        stages.push_back(Stage::OneByOne { threshold, moves });
    }
    if may_step && !at_once && !is_draft {
        let moves = rest_move_limit(crossings);
        stages.push_back(Stage::Rest { threshold: last_threshold, steps: STEPS_BEFORE_SPELL, moves });
    }
    stages
}

/// Moves that one line may take, so that it ends; `cubic` with a threshold of [`FIRST_THRESHOLD`] and more.
///
/// Measured until the threshold is met, for n crossings: `linear` at 1e-8 takes about 3 n^2 a round (22 000 for 83, 4
/// million for 1 500) and up to ten rounds. `cubic` at 1e-3 takes some 60 n to 100 n one by one.
fn move_limit(crossings: usize, reach: usize) -> u64 {
    let n = crossings as u64;
    20_000 + n * if reach == 1 { (20_000).max(10 * n) } else { 250 }
}

/// Moves that a `cubic` line may take for each threshold finer than [`FIRST_THRESHOLD`].
///
/// Its map is not a descent: on most long lines some crossings swing or drift for long. One by one
/// more moves make the line smoother at large, too; where steps of all crossings at once have done that, fewer will do.
fn finer_move_limit(crossings: usize, at_once: bool) -> u64 {
    let n = crossings as u64;
    if at_once { 5_000 + 5 * n } else { 20_000 + 30 * n }
}

/// Moves for a short line that its first ones have not brought to rest, in spells between steps of all crossings at once.
///
/// Measured on 1,330 lines of hostile meshes at 1e-4: with these 98 % come to rest, with a quarter 95 %. Long lines would take
/// that and more, and drafts are left as their first moves left them.
fn rest_move_limit(crossings: usize) -> u64 {
    100_000 + 240 * crossings as u64
}

/// Moves of one such spell: after so many a vertex that swings is damped so much that it is better begun anew.
pub fn moves_a_spell(crossings: usize) -> u64 {
    4_000 + 40 * crossings as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::cubic::Cubic;
    use crate::filter::linear::Linear;
    use crate::options::Knots;

    /// Stand for stages of other kinds in what follows.
    const AT_ONCE: f64 = 0.0;
    /// See [`AT_ONCE`].
    const REST: f64 = -1.0;

    fn thresholds(filter: &impl SlidingFilter, solver: Solver, last: f64, crossings: usize) -> Vec<f64> {
        let options = Options { solver, ..Options::default() };
        let stages = choose_stages(filter, &options, false, last, crossings, false);
        let of = |stage: &Stage| match *stage {
            Stage::OneByOne { threshold, .. } => threshold,
            Stage::Rest { .. } => REST,
            _ => AT_ONCE,
        };
        stages.iter().map(of).collect()
    }

    #[test]
    fn all_crossings_move_at_once_first_on_long_lines_of_the_default_cubic_alone() {
        let cubic = |support| Cubic { knots: Knots::Centripetal, support };
        assert_eq!(thresholds(&cubic(2), Solver::Auto, 1e-4, 1000), [AT_ONCE, 1e-3, 1e-4]);
        assert_eq!(thresholds(&cubic(2), Solver::Auto, 5e-3, 1000), [AT_ONCE, 5e-3]);
        assert_eq!(thresholds(&cubic(2), Solver::Auto, 1e-2, 1000), [1e-2]);
        assert_eq!(thresholds(&cubic(2), Solver::Heap, 1e-4, 1000), [1e-3, 1e-4]);
        assert_eq!(thresholds(&cubic(3), Solver::Auto, 1e-4, 1000), [1e-3, 1e-4]);
        assert_eq!(thresholds(&cubic(2), Solver::Auto, 1e-4, 100), [1e-3, 1e-4, REST]);
        assert_eq!(thresholds(&Linear, Solver::Heap, 1e-2, 1000), [1e-2]);
    }

    #[test]
    fn drafts_end_early_and_are_not_brought_to_rest() {
        let cubic = Cubic { knots: Knots::Centripetal, support: DEFAULT_SUPPORT };
        let stages = |last, is_draft| choose_stages(&cubic, &Options::default(), false, last, 200, is_draft);
        let moves = Some(70_000);
        assert_eq!(stages(1e-4, true), [Stage::OneByOne { threshold: DRAFT_THRESHOLD, moves }]);
        assert_eq!(stages(1e-2, true), [Stage::OneByOne { threshold: 1e-2, moves }]);
        let rest = Stage::Rest { threshold: 1e-4, steps: STEPS_BEFORE_SPELL, moves: 148_000 };
        let finer = Stage::OneByOne { threshold: 1e-4, moves: Some(26_000) };
        assert_eq!(stages(1e-4, false), [Stage::OneByOne { threshold: 1e-3, moves }, finer, rest]);
    }
}
