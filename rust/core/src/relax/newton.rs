//! Step C of the `linear` filter for all vertices at once: Newton on "every vertex is at its target", to 1e-10.
//!
//! Each equation couples three neighbours, so a step is one band solve. Where the heap stops at a threshold, this ends at
//! the filter's own fixed point. Started at a geodesic line it takes a handful of steps.
//!
//! Vertices cannot leave their edges. A step that would take some beyond an end puts these there and is solved again for
//! the rest (an active set); clamped one by one after the solve, a step no longer fits together. Where a stretch is free
//! to slide, or neighbours look at each other alone, the equations are singular: then the step is damped.

use crate::error::Result;
use crate::filter::linear::target_with_slopes;
use crate::pauses::Pauses;
use crate::relax::banded::Banded;
use crate::relax::beads::Beads;

/// Largest error of a vertex at the end, barycentric units.
pub const NEWTON_TOLERANCE: f64 = 1e-10;

/// What rounding of the coordinates may do to an error, in units of eps * coordinate / edge: the figure that `geodesic`
/// allows.
const ROUNDINGS: f64 = 8.0;

/// Steps that are tried; measured: 3 to 11.
const MAX_STEPS: u32 = 60;

/// Halvings of a step that does not shrink the error.
const MAX_HALVINGS: u32 = 8;

/// Solves of one step, with ever more vertices at the ends of their edges; where these are not enough, a damped step is
/// tried.
const MAX_SOLVES: u32 = 12;

/// Dampings of the equations that are tried when a step does not shrink the error; 1 would be a step of sliding.
const DAMPINGS: [f64; 4] = [0.0, 1e-4, 1e-2, 1e-1];

/// What Newton did.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct NewtonOutcome {
    /// Band solves.
    pub steps: u64,
    /// Largest error at the end.
    pub error: f64,
    /// Whether every error is below [`NEWTON_TOLERANCE`], or what rounding makes of it; if not, the beads are at the best
    /// place that was found.
    pub is_settled: bool,
}

/// Slides all beads to the fixed point of the `linear` filter near where they are. Pauses are made between passes over all
/// beads.
///
/// # Errors
/// [`crate::Error::Interrupted`].
pub fn relax_by_newton(beads: &mut Beads, pauses: &mut Pauses) -> Result<NewtonOutcome> {
    let tolerances = tolerances(beads);
    let mut errors = residual(beads, None);
    let mut steps = 0;
    while !is_settled(&errors, &tolerances) && steps < u64::from(MAX_STEPS) {
        let mut better = None;
        for damping in DAMPINGS {
            better = step(beads, &errors, damping, &mut steps, pauses)?;
            if better.is_some() {
                break;
            }
        }
        let Some(better) = better else { break };
        errors = better;
    }
    Ok(NewtonOutcome { steps, error: largest(&errors), is_settled: is_settled(&errors, &tolerances) })
}

/// One step that shrinks the errors, and these; `None`, and the beads where they were, when there is none.
fn step(
    beads: &mut Beads,
    errors: &[f64],
    damping: f64,
    steps: &mut u64,
    pauses: &mut Pauses,
) -> Result<Option<Vec<f64>>> {
    let start = beads.parameters.clone();
    let Some(goals) = solve_within_edges(beads, errors, damping, steps, pauses)? else { return Ok(None) };
    let mut share = 1.0;
    for _ in 0..MAX_HALVINGS {
        pauses.pause()?;
        for i in 0..beads.len() {
            // Not start + 1.0 * way, which need not be the goal to the bit: goals of 0 and 1 are mesh vertices.
            beads.slide(i, if share == 1.0 { goals[i] } else { start[i] + share * (goals[i] - start[i]) });
        }
        let new_errors = residual(beads, None);
        if square_sum(&new_errors) < square_sum(errors) {
            return Ok(Some(new_errors));
        }
        share *= 0.5;
    }
    (0..beads.len()).for_each(|i| beads.slide(i, start[i]));
    Ok(None)
}

/// The parameters that a whole Newton step leads to, all in 0..=1: vertices that it would take beyond an end are held
/// there, and the rest is solved again.
fn solve_within_edges(
    beads: &Beads,
    errors: &[f64],
    damping: f64,
    steps: &mut u64,
    pauses: &mut Pauses,
) -> Result<Option<Vec<f64>>> {
    let mut matrix = Banded::zero(beads.len(), 1);
    residual(beads, Some(&mut matrix));
    (0..beads.len()).filter(|&i| !beads.is_fixed[i]).for_each(|i| matrix.add(i, 0, damping));
    let mut right = errors.to_vec();
    let mut is_held = vec![false; beads.len()];
    for _ in 0..MAX_SOLVES {
        *steps += 1;
        pauses.pause()?;
        let Some(found) = matrix.solve(&right, beads.closed) else { return Ok(None) };
        let mut has_left = false;
        for (i, held) in is_held.iter_mut().enumerate() {
            let t = beads.parameters[i];
            let goal = t - found[i];
            let end = goal.clamp(0.0, 1.0);
            if goal != end && !*held {
                (*held, has_left) = (true, true);
                matrix.fix(i);
                right[i] = t - end;
            }
        }
        if !has_left {
            return Ok(Some((0..beads.len()).map(|i| (beads.parameters[i] - found[i]).clamp(0.0, 1.0)).collect()));
        }
    }
    Ok(None)
}

/// How far each bead is from its target; with `matrix`, its derivative as well.
fn residual(beads: &Beads, mut matrix: Option<&mut Banded>) -> Vec<f64> {
    (0..beads.len())
        .map(|i| {
            let neighbours = beads.step(i, false).zip(beads.step(i, true)).filter(|_| !beads.is_fixed[i]);
            let Some((before, after)) = neighbours else {
                if let Some(matrix) = &mut matrix {
                    matrix.fix(i);
                }
                return 0.0;
            };
            let edge = &beads.edges[i];
            let slide = |j: usize| beads.edges[j].high - beads.edges[j].low;
            let t = beads.parameters[i];
            let found = target_with_slopes(
                edge,
                (beads.positions[before], slide(before)),
                (beads.positions[after], slide(after)),
                t,
            );
            let target = found.target.clamp(0.0, 1.0);
            if let Some(matrix) = &mut matrix {
                matrix.add(i, 0, 1.0);
                if target == found.target {
                    matrix.add(i, -1, -found.slopes[0]);
                    matrix.add(i, 1, -found.slopes[1]);
                }
            }
            t - target
        })
        .collect()
}

/// The error of each bead below which rounding of the positions about it tells nothing.
fn tolerances(beads: &Beads) -> Vec<f64> {
    beads
        .edges
        .iter()
        .map(|edge| {
            let size = edge.low.abs().max(edge.high.abs()).max_element();
            let rounding = ROUNDINGS * f64::EPSILON * size / edge.low.distance(edge.high);
            // An edge of zero length takes any place; its vertex stays where it is.
            if rounding.is_finite() { NEWTON_TOLERANCE.max(rounding) } else { f64::INFINITY }
        })
        .collect()
}

fn is_settled(errors: &[f64], tolerances: &[f64]) -> bool {
    errors.iter().zip(tolerances).all(|(e, &tolerance)| e.abs() <= tolerance)
}

fn square_sum(errors: &[f64]) -> f64 {
    errors.iter().map(|e| e * e).sum()
}

fn largest(errors: &[f64]) -> f64 {
    // A value that is not a number counts as infinite.
    errors.iter().fold(0.0, |worst: f64, e| if e.is_nan() { f64::INFINITY } else { worst.max(e.abs()) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::Edge;
    use crate::report::{NoObserver, Step};
    use glam::DVec3;

    fn relax(beads: &mut Beads) -> NewtonOutcome {
        relax_by_newton(beads, &mut Pauses::new(&mut NoObserver, Step::Relax)).expect("nobody interrupts")
    }

    /// Upright edges of height 1 over x = 1, 2, ..., between fixed points at height 0.5; `foot` tells where each begins.
    fn fence(count: usize, origin: DVec3, foot: impl Fn(usize) -> f64) -> Beads {
        let mut beads = Beads::default();
        let at = |x: f64, y: f64| origin + DVec3::new(x, y, 0.0);
        beads.push_fixed(at(0.0, 0.5));
        for i in 1..=count {
            let x = i as f64;
            beads.push(Edge { low: at(x, foot(i)), high: at(x, foot(i) + 1.0) }, 0.9);
        }
        beads.push_fixed(at(count as f64 + 1.0, 0.5));
        beads
    }

    #[test]
    fn a_step_beyond_an_end_stops_there_and_the_rest_fits_to_it() {
        let level = |i: usize| 0.2 * i.min(10 - i) as f64;
        let mut beads = fence(9, DVec3::ZERO, |i| if i == 5 { 1.5 } else { level(i) });
        let outcome = relax(&mut beads);
        assert!(outcome.is_settled, "{outcome:?}");
        assert_eq!(beads.parameters[5], 0.0, "the line is held up by the foot of the fifth edge");
        for (i, p) in beads.positions.iter().enumerate() {
            assert!((p.y - 0.5 - level(i)).abs() < 1e-9, "{i}: straight to both sides of it, not {p}");
        }
        assert!(outcome.steps <= 12, "{outcome:?}");
    }

    #[test]
    fn far_from_the_origin_a_line_settles_to_the_rounding_of_its_coordinates() {
        for distance in [0.0, 1e6, 1e9] {
            let mut beads = fence(40, DVec3::new(distance, -distance, 0.3 * distance), |i| 0.01 * (i % 3) as f64);
            let outcome = relax(&mut beads);
            assert!(outcome.is_settled, "{distance}: {outcome:?}");
            let allowed = NEWTON_TOLERANCE.max(1e3 * f64::EPSILON * distance);
            assert!(beads.positions.iter().all(|p| (p.y + distance - 0.5).abs() <= allowed), "{distance}");
        }
    }

    #[test]
    fn neighbours_that_look_at_each_other_alone_do_not_end_it() {
        // Two spokes of one mesh vertex, both crossed a hair beside it, and a third straight on: singular there.
        let hub = DVec3::new(1.0, 0.0, 0.0);
        let mut beads = Beads::default();
        beads.push_fixed(DVec3::new(0.0, 0.0, 0.0));
        beads.push(Edge { low: hub, high: DVec3::new(1.0, 1.0, 0.0) }, 1e-4);
        beads.push(Edge { low: hub, high: DVec3::new(1.5, 1.0, 0.0) }, 1e-4);
        beads.push(Edge { low: hub, high: DVec3::new(2.0, 1.0, 0.0) }, 1e-4);
        beads.push_fixed(DVec3::new(2.0, -0.5, 0.0));
        let outcome = relax(&mut beads);
        assert!(outcome.is_settled, "{outcome:?}");
        assert!(beads.parameters[1..4].iter().all(|&t| t <= 1e-9), "{:?}", beads.parameters);
    }
}
