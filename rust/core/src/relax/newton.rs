//! Step C of the `linear` filter for all vertices at once: Newton on "every vertex is at its target", to 1e-10.
//!
//! Each equation couples three neighbours, so a step is one band solve. Where the heap stops at a threshold, this ends at
//! the filter's own fixed point. Started at a geodesic line it takes a handful of steps.

use crate::filter::linear::target_with_slopes;
use crate::relax::banded::Banded;
use crate::relax::beads::Beads;

/// Largest error of a vertex at the end, barycentric units.
pub const NEWTON_TOLERANCE: f64 = 1e-10;

/// Steps that are tried; measured: 3 to 11.
const MAX_STEPS: u32 = 60;

/// Halvings of a step that does not shrink the error.
const MAX_HALVINGS: u32 = 12;

/// What Newton did.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct NewtonOutcome {
    /// Band solves.
    pub steps: u64,
    /// Largest error at the end.
    pub error: f64,
    /// Whether the error is below [`NEWTON_TOLERANCE`]; if not, the beads are at the best place that was found.
    pub is_settled: bool,
}

/// Slides all beads to the fixed point of the `linear` filter near where they are.
pub fn relax_by_newton(beads: &mut Beads) -> NewtonOutcome {
    let mut errors = residual(beads, None);
    let mut error = largest(&errors);
    let mut steps = 0;
    while error > NEWTON_TOLERANCE && steps < u64::from(MAX_STEPS) {
        steps += 1;
        let mut matrix = Banded::zero(beads.len(), 1);
        residual(beads, Some(&mut matrix));
        let Some(step) = matrix.solve(&errors, beads.closed) else { break };
        let start = beads.parameters.clone();
        let mut share = 1.0;
        let mut is_better = false;
        for _ in 0..MAX_HALVINGS {
            for i in 0..beads.len() {
                beads.slide(i, (start[i] - share * step[i]).clamp(0.0, 1.0));
            }
            let new_errors = residual(beads, None);
            if square_sum(&new_errors) < square_sum(&errors) {
                error = largest(&new_errors);
                errors = new_errors;
                is_better = true;
                break;
            }
            share *= 0.5;
        }
        if !is_better {
            (0..beads.len()).for_each(|i| beads.slide(i, start[i]));
            break;
        }
    }
    NewtonOutcome { steps, error, is_settled: error <= NEWTON_TOLERANCE }
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

fn square_sum(errors: &[f64]) -> f64 {
    errors.iter().map(|e| e * e).sum()
}

fn largest(errors: &[f64]) -> f64 {
    // A value that is not a number counts as infinite.
    errors.iter().fold(0.0, |worst: f64, e| if e.is_nan() { f64::INFINITY } else { worst.max(e.abs()) })
}
