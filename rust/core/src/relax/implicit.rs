//! Step C for all vertices at once: long steps of the sliding itself, taken implicitly.
//!
//! Moving one vertex at a time follows, in small steps, a motion in which each vertex goes towards its target with a speed
//! that is its distance from it. What is long on the line takes that motion long: moves grow with the square of the
//! crossings. As each target hangs on four neighbours, a long step of the same motion, taken implicitly, is one band solve.
//!
//! It is a start for moves one by one, which judge every vertex: the map is no descent, so these steps are few, and end
//! where they do no good.

use std::ops::Range;

use crate::error::Result;
use crate::filter::{FourNeighbours, SlidingFilter};
use crate::relax::banded::Banded;
use crate::relax::beads::Beads;

/// The motion's unit of time: in it a vertex among others that rest comes nearer to its target by a factor e. A step that
/// does good lets the next be longer by [`GROWTH`], one that does not is taken back and made shorter by [`SHRINKING`].
const GROWTH: f64 = 2.0;
/// See [`GROWTH`].
const SHRINKING: f64 = 0.25;
/// So short a step is kept in any case: the map may raise the errors for a while.
const SHORT_STEP: f64 = 0.5;
/// A step that would be shorter than this is given up: the equations have no solution there.
const SHORTEST_STEP: f64 = 1e-3;

/// The furthest that a vertex goes in one step, in barycentric units: what vertices do on the way decides on which side of mesh
/// vertices they come to lie. With longer steps one line of 59 lost a lobe.
const LONGEST_WAY: f64 = 0.1;

/// Fewest beads: each vertex needs four neighbours.
pub const FEWEST_BEADS: usize = 5;

/// What the steps did.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct ImplicitOutcome {
    /// Band solves.
    pub steps: u64,
    /// Whether no vertex is further from its target than the threshold.
    pub is_settled: bool,
}

/// How far the vertices are off their targets, and how the targets follow the neighbours.
#[derive(Default)]
struct Judgement {
    errors: Vec<f64>,
    slopes: Vec<[f64; 4]>,
}

/// Slides the beads by at most `most_steps` steps, the first of which is `time_step` long, until no free one is further than
/// `threshold` from its target. `time_step` becomes what the next one would be. Nothing is done by a filter that does not
/// look at four neighbours, and on fewer than [`FEWEST_BEADS`]. `on_pause` is called before each step. Cost: O(n) a step.
///
/// # Errors
/// Those of `on_pause`.
pub fn relax_implicitly(
    beads: &mut Beads,
    filter: &impl SlidingFilter,
    threshold: f64,
    most_steps: u64,
    time_step: &mut f64,
    mut on_pause: impl FnMut() -> Result<()>,
) -> Result<ImplicitOutcome> {
    let mut outcome = ImplicitOutcome::default();
    let mut on_curve = vec![None; beads.len()];
    let (mut here, mut there) = (Judgement::default(), Judgement::default());
    if beads.len() < FEWEST_BEADS || !judge(beads, filter, &mut on_curve, &mut here) {
        return Ok(outcome);
    }
    loop {
        outcome.is_settled = here.errors.iter().all(|e| e.abs() <= threshold);
        if outcome.is_settled || outcome.steps == most_steps || *time_step < SHORTEST_STEP {
            return Ok(outcome);
        }
        on_pause()?;
        outcome.steps += 1;
        let Some(step) = solve(beads, &here, *time_step) else {
            *time_step *= SHRINKING;
            continue;
        };
        let furthest = step.iter().fold(0.0, |most: f64, way| most.max(way.abs()));
        let share = if furthest > LONGEST_WAY { LONGEST_WAY / furthest } else { 1.0 };
        let start = beads.parameters.clone();
        for (i, (&t, way)) in start.iter().zip(&step).enumerate() {
            if !beads.is_fixed[i] {
                beads.slide(i, (t + share * way).clamp(0.0, 1.0));
            }
        }
        judge(beads, filter, &mut on_curve, &mut there);
        if square_sum(&there.errors) <= square_sum(&here.errors) || *time_step <= SHORT_STEP {
            std::mem::swap(&mut here, &mut there);
            if share == 1.0 {
                *time_step *= GROWTH;
            }
        } else {
            for (i, &t) in start.iter().enumerate() {
                beads.slide(i, t);
            }
            *time_step *= SHRINKING;
        }
    }
}

/// As [`relax_implicitly`] for the beads of some ranges alone, each for itself; all others stay.
///
/// # Errors
/// Those of `on_pause`.
pub fn relax_ranges_implicitly(
    beads: &mut Beads,
    ranges: &[Range<usize>],
    filter: &impl SlidingFilter,
    threshold: f64,
    most_steps: u64,
    time_step: &mut f64,
    mut on_pause: impl FnMut() -> Result<()>,
) -> Result<ImplicitOutcome> {
    let first = *time_step;
    let mut shortest = f64::INFINITY;
    let mut outcome = ImplicitOutcome { steps: 0, is_settled: true };
    for range in ranges {
        let (mut chain, places) = beads.chain_of(range, filter.reach());
        let mut own = first;
        let part = relax_implicitly(&mut chain, filter, threshold, most_steps, &mut own, &mut on_pause)?;
        shortest = shortest.min(own);
        for (k, &i) in places.iter().enumerate().filter(|&(k, _)| !chain.is_fixed[k]) {
            beads.slide(i, chain.parameters[k]);
        }
        outcome.steps += part.steps;
        outcome.is_settled &= part.is_settled;
    }
    *time_step = shortest.min(first * GROWTH.powi(most_steps as i32));
    Ok(outcome)
}

/// Finds all errors and slopes; false for a filter that has none.
fn judge(beads: &Beads, filter: &impl SlidingFilter, on_curve: &mut [Option<f64>], judgement: &mut Judgement) -> bool {
    judgement.errors.clear();
    judgement.slopes.clear();
    for (i, on_curve) in on_curve.iter_mut().enumerate() {
        let (mut error, mut slopes) = (0.0, [0.0; 4]);
        if let (false, Some((others, inner))) = (beads.is_fixed[i], beads.four_around(i)) {
            let points = others.map(|k| beads.positions[k]);
            let slides = others.map(|k| beads.edges[k].high - beads.edges[k].low);
            let t = beads.parameters[i];
            let four = FourNeighbours { points, slides, inner };
            let Some((target, of_target)) = filter.target_with_slopes(&beads.edges[i], &four, t, *on_curve) else {
                return false;
            };
            (error, slopes, *on_curve) = (target.t - t, of_target, target.on_curve);
        }
        judgement.errors.push(error);
        judgement.slopes.push(slopes);
    }
    true
}

/// The ways of all vertices in a step of that length: in it each way is what its speed will be at the end, times the step.
fn solve(beads: &Beads, here: &Judgement, time_step: f64) -> Option<Vec<f64>> {
    // Next to an end a vertex looks at three on one side.
    let half_width = if beads.closed { 2 } else { 3 };
    let mut matrix = Banded::zero(beads.len(), half_width);
    for i in 0..beads.len() {
        let Some((_, inner)) = beads.four_around(i).filter(|_| !beads.is_fixed[i]) else {
            matrix.fix(i);
            continue;
        };
        matrix.add(i, 0, 1.0 + 1.0 / time_step);
        for (m, slope) in here.slopes[i].iter().enumerate() {
            let offset = m as isize - inner as isize;
            matrix.add(i, if m <= inner { offset - 1 } else { offset }, -slope);
        }
    }
    let solution = matrix.into_solution(&here.errors, beads.closed, || Ok::<_, std::convert::Infallible>(()));
    solution.unwrap_or_else(|never| match never {})
}

fn square_sum(errors: &[f64]) -> f64 {
    errors.iter().map(|e| e * e).sum()
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use glam::DVec3;

    use super::*;
    use crate::error::Error;
    use crate::filter::Edge;
    use crate::filter::cubic::Cubic;
    use crate::filter::linear::Linear;
    use crate::options::{DEFAULT_SUPPORT, Knots};
    use crate::relax::heap::relax_by_heap;
    use crate::relax::swing::SlideEnd;

    const NO_END: &str = "nothing ends the work";

    const CUBIC: Cubic = Cubic { knots: Knots::Centripetal, support: DEFAULT_SUPPORT };

    fn fence(count: usize) -> Beads {
        Beads::on_a_fence(count, 0.2)
    }

    fn largest_error(beads: &Beads) -> f64 {
        let mut here = Judgement::default();
        assert!(judge(beads, &CUBIC, &mut vec![None; beads.len()], &mut here));
        here.errors.iter().fold(0.0, |most: f64, e| most.max(e.abs()))
    }

    #[test]
    fn a_few_steps_do_what_takes_the_heap_many_moves() {
        let mut beads = fence(200);
        let outcome = relax_implicitly(&mut beads, &CUBIC, 1e-6, 40, &mut 1.0, || Ok(())).expect(NO_END);
        assert!(outcome.is_settled && largest_error(&beads) <= 1e-6, "{outcome:?}");
        let mut slow = fence(200);
        let heap = relax_by_heap(&mut slow, &CUBIC, 1e-6, 20_000, None, || ControlFlow::Continue(()));
        assert_eq!(heap.end, SlideEnd::Stopped, "{} moves, and {} steps", heap.moves, outcome.steps);
        // The heap has nothing left to do where the steps have ended.
        let rest = relax_by_heap(&mut beads, &CUBIC, 1e-6, 20_000, None, || ControlFlow::Continue(()));
        assert_eq!((rest.moves, rest.end), (0, SlideEnd::Settled));
    }

    #[test]
    fn ranges_move_alone_and_rings_go_across_their_seam() {
        let mut beads = fence(60);
        let (before, middle) = (beads.parameters.clone(), 20..40);
        relax_ranges_implicitly(&mut beads, std::slice::from_ref(&middle), &CUBIC, 1e-6, 10, &mut 1.0, || Ok(()))
            .expect(NO_END);
        for (i, (t, was)) in beads.parameters.iter().zip(&before).enumerate() {
            assert_eq!(t == was, !middle.contains(&i), "{i}");
        }
        let mut ring = Beads { closed: true, ..Beads::default() };
        for i in 0..40 {
            let angle = i as f64 * std::f64::consts::TAU / 40.0;
            let out = DVec3::new(angle.cos(), angle.sin(), 0.0);
            ring.push(Edge { low: 5.0 * out - DVec3::Z, high: 5.0 * out + DVec3::Z }, 0.5 + 0.3 * (5.0 * angle).sin());
        }
        assert!(relax_implicitly(&mut ring, &CUBIC, 1e-6, 40, &mut 1.0, || Ok(())).expect(NO_END).is_settled);
        assert!(largest_error(&ring) <= 1e-6);
    }

    #[test]
    fn other_filters_and_short_lines_are_left_as_they_are_and_pauses_end_the_work() {
        let mut beads = fence(60);
        let before = beads.parameters.clone();
        let nothing = ImplicitOutcome::default();
        assert_eq!(relax_implicitly(&mut beads, &Linear, 1e-6, 10, &mut 1.0, || Ok(())), Ok(nothing));
        assert_eq!(relax_implicitly(&mut fence(3), &CUBIC, 1e-6, 10, &mut 1.0, || Ok(())), Ok(nothing));
        assert_eq!(
            relax_implicitly(&mut beads, &CUBIC, 1e-6, 10, &mut 1.0, || Err(Error::Interrupted)),
            Err(Error::Interrupted)
        );
        assert_eq!(beads.parameters, before);
    }
}
