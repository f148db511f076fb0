//! The stages of step C for the paper's filters: what brings a line to rest, how near, and with how much work.
//!
//! Every stage is followed by step D, and comes again as long as that finds something to do. Passing vertices early spares
//! most of the moves: a line that has to pass a vertex crowds there ever more slowly. Holds the order and the limits; the
//! rounds are in `smooth_sliding`.

use std::collections::VecDeque;

use crate::filter::SlidingFilter;
use crate::options::{DEFAULT_SUPPORT, Options, Solver};

/// One stage.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Stage {
    /// The paper's step C, until no crossing is further than `threshold` from its target. `moves`: those that it may take
    /// after the stage before; `None`: what is left of that one's.
    Heap {
        /// In barycentric units.
        threshold: f64,
        /// See above.
        moves: Option<u64>,
    },
    /// Steps of all crossings at once, [`STEPS_A_ROUND`] before each step D; whatever comes of them, the next stage goes on.
    Implicit {
        /// In barycentric units: where they end.
        threshold: f64,
        /// Band solves that are left.
        steps: u64,
    },
}

impl Stage {
    /// How near to rest it brings the line, in barycentric units.
    pub fn threshold(&self) -> f64 {
        let (&Self::Heap { threshold, .. } | &Self::Implicit { threshold, .. }) = self;
        threshold
    }
}

/// By heap alone step C begins with this threshold, and goes on with finer ones when step D finds nothing to do.
const FIRST_THRESHOLD: f64 = 1e-3;

/// Each finer threshold as a share of the one before.
const NEXT_THRESHOLD: f64 = 0.1;

/// Down to this threshold the heap is quick.
const COARSE_THRESHOLD: f64 = 1e-2;

/// Steps of all crossings at once before the first threshold. They take what is long on the line as far as the heap does
/// in some forty moves a crossing.
const IMPLICIT_STEPS: u64 = 24;

/// Of these, so many before vertices are passed: a line that comes to rest in a strip that it has to leave crowds at vertices, and
/// turns more in the end (by a sixth with sixteen steps in a row, measured on 29 lines).
pub const STEPS_A_ROUND: u64 = 8;

/// Lines of fewer crossings are left to the heap, which takes longer in all, but not long there: measured on 59 lines, it finds the
/// better side of more mesh vertices on coarse meshes, and shorter lines.
const FEWEST_CROSSINGS: usize = 600;

/// The same where a part of a line is made again while picks are dragged, and time counts for more.
const FEWEST_DRAFTED: usize = 250;

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
    let moves = Some(move_limit(crossings, filter.reach()));
    let mut stages = VecDeque::new();
    if by_newton {
        return VecDeque::from([Stage::Heap { threshold: last_threshold, moves }]);
    }
    let fewest = if is_draft { FEWEST_DRAFTED } else { FEWEST_CROSSINGS };
    let at_once = options.solver == Solver::Auto && filter.reach() == DEFAULT_SUPPORT && crossings >= fewest;
    if at_once && last_threshold < COARSE_THRESHOLD {
        let threshold = last_threshold.max(FIRST_THRESHOLD);
        stages.push_back(Stage::Implicit { threshold, steps: IMPLICIT_STEPS });
    }
    let mut threshold = last_threshold.max(FIRST_THRESHOLD);
    stages.push_back(Stage::Heap { threshold, moves });
    while threshold > last_threshold {
        threshold = (threshold * NEXT_THRESHOLD).max(last_threshold);
        let moves = (filter.reach() > 1).then(|| finer_move_limit(crossings, at_once));
        stages.push_back(Stage::Heap { threshold, moves });
    }
    stages
}

/// Moves that one line may take, so that it ends; `cubic` with a threshold of [`FIRST_THRESHOLD`] and more.
///
/// Measured until the threshold is met, for n crossings: `linear` at 1e-8 takes about 3 n^2 a round (22 000 for 83, 4
/// million for 1 500) and up to ten rounds. `cubic` at 1e-3 takes some 60 n to 100 n by heap alone.
fn move_limit(crossings: usize, reach: usize) -> u64 {
    let n = crossings as u64;
    20_000 + n * if reach == 1 { (20_000).max(10 * n) } else { 250 }
}

/// Moves that a `cubic` line may take for each threshold finer than [`FIRST_THRESHOLD`].
///
/// Its map is not a descent: on most long lines some crossings swing or drift for ever, whatever the limit. By heap alone
/// more moves make the line smoother at large, too; where steps of all crossings at once have done that, fewer will do.
fn finer_move_limit(crossings: usize, at_once: bool) -> u64 {
    let n = crossings as u64;
    if at_once { 5_000 + 5 * n } else { 20_000 + 30 * n }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::cubic::Cubic;
    use crate::filter::linear::Linear;
    use crate::options::Knots;

    fn thresholds(filter: &impl SlidingFilter, solver: Solver, last: f64, crossings: usize) -> Vec<f64> {
        let options = Options { solver, ..Options::default() };
        let stages = choose_stages(filter, &options, false, last, crossings, false);
        stages.iter().map(|stage| if let Stage::Heap { threshold, .. } = stage { *threshold } else { 0.0 }).collect()
    }

    #[test]
    fn all_crossings_move_at_once_first_on_long_lines_of_the_default_cubic_alone() {
        let cubic = |support| Cubic { knots: Knots::Centripetal, support };
        assert_eq!(thresholds(&cubic(2), Solver::Auto, 1e-4, 1000), [0.0, 1e-3, 1e-4]);
        assert_eq!(thresholds(&cubic(2), Solver::Auto, 5e-3, 1000), [0.0, 5e-3]);
        assert_eq!(thresholds(&cubic(2), Solver::Auto, 1e-2, 1000), [1e-2]);
        assert_eq!(thresholds(&cubic(2), Solver::Heap, 1e-4, 1000), [1e-3, 1e-4]);
        assert_eq!(thresholds(&cubic(3), Solver::Auto, 1e-4, 1000), [1e-3, 1e-4]);
        assert_eq!(thresholds(&cubic(2), Solver::Auto, 1e-4, 100), [1e-3, 1e-4]);
        assert_eq!(thresholds(&Linear, Solver::Heap, 1e-2, 1000), [1e-2]);
    }
}
