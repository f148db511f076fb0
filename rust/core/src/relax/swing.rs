//! One vertex that slides on its edge towards its target: where that is, how it swings, and who looks at whom.
//!
//! Where crossings are uneven, the cubic's map is no descent and vertices can swing for ever. A vertex that keeps turning
//! back is damped: it goes part of the way. Damping either lets it settle at its target, or brings it to rest in the
//! middle of its swing, which the outcome tells.
//!
//! Holds what the ways of moving one vertex at a time share; which vertex moves when is theirs.

use std::ops::Range;
use std::slice;

use crate::filter::SlidingFilter;
use crate::relax::beads::{Beads, Neighbours};

/// Times that a vertex may turn back before it is damped. A vertex that settles without damping turns back less than
/// this, measured with the linear filter.
const FREE_REVERSALS: u32 = 12;

/// What every further turn leaves of a vertex's step.
const DAMPING: f64 = 0.8;

/// A vertex rests, although it is off its target, when its damped step is below this share of the threshold.
const REST: f64 = 0.01;

/// Times that nearest points which were followed are sought everywhere when nothing is left to move; once is enough, as a rule.
pub const MAX_SEEKS: u32 = 8;

/// How a relaxation ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SlideEnd {
    /// Every error is below the threshold.
    Settled,
    /// Nothing moves any more, but some vertices rest in the middle of a swing, further than the threshold from their
    /// targets.
    Swinging,
    /// The limit of moves was reached, or the caller stopped.
    Stopped,
}

/// What a relaxation did.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SlideOutcome {
    /// Vertices moved, counted once a move.
    pub moves: u64,
    /// How it ended.
    pub end: SlideEnd,
}

/// What is known of one vertex besides its place.
#[derive(Clone, Copy, Debug)]
pub struct Swing {
    target: f64,
    /// Where on the filter's curve the nearest point was found last.
    on_curve: Option<f64>,
    damping: f64,
    last_step: f64,
    reversals: u32,
}

impl Swing {
    /// One for each vertex, at rest where it is.
    pub fn of_all(beads: &Beads) -> Vec<Self> {
        let start = |&target: &f64| Self { target, on_curve: None, damping: 1.0, last_step: 0.0, reversals: 0 };
        beads.parameters.iter().map(start).collect()
    }

    /// Finds the target of vertex `i` anew.
    pub fn aim(&mut self, beads: &Beads, filter: &impl SlidingFilter, i: usize, sides: &mut Neighbours) {
        let t = beads.parameters[i];
        let four = (filter.reach() == 2).then(|| beads.four_around(i)).flatten();
        let found = four.and_then(|(others, inner)| {
            let points = others.map(|k| beads.positions[k]);
            filter.target_of_four(&beads.edges[i], &points, inner, t, self.on_curve)
        });
        let found = found.unwrap_or_else(|| {
            beads.neighbourhood(i, filter.reach(), sides);
            filter.target(&beads.edges[i], &sides.before, &sides.after, t, self.on_curve)
        });
        (self.target, self.on_curve) = (found.t, found.on_curve);
    }

    /// Whether the nearest point will be followed from where it was.
    pub fn has_place(&self) -> bool {
        self.on_curve.is_some()
    }

    /// Forgets where on the filter's curve the nearest point was, so that it is sought everywhere. Whether there was one.
    pub fn forget_place(&mut self) -> bool {
        self.on_curve.take().is_some()
    }

    /// How far the vertex at `t` would go; 0 where that is no more than `threshold`, or so little of it that the vertex rests.
    pub fn way_from(&self, t: f64, threshold: f64) -> f64 {
        let error = (self.target - t).abs();
        let way = self.damping * error;
        if error > threshold && way > REST * threshold { way } else { 0.0 }
    }

    /// Moves vertex `i` towards its target, all the way unless it is damped. A filter that looks at one neighbour a side needs
    /// no damping: its vertices turn back by rounding alone, and damping would only slow them down.
    pub fn slide(&mut self, beads: &mut Beads, i: usize, may_damp: bool) {
        let t = beads.parameters[i];
        let whole = self.target - t;
        if may_damp && whole * self.last_step < 0.0 {
            self.reversals += 1;
            if self.reversals > FREE_REVERSALS {
                self.damping *= DAMPING;
            }
        }
        self.last_step = whole;
        // Not t + 1.0 * whole, which need not be the target to the bit: targets of 0 and 1 are mesh vertices.
        let next = if self.damping == 1.0 { self.target } else { (t + self.damping * whole).clamp(0.0, 1.0) };
        beads.slide(i, next);
    }
}

/// The vertices of `first`, or all where that is `None`: those that may be off their targets when a relaxation begins.
pub fn to_be_asked(count: usize, first: Option<&[Range<usize>]>) -> impl Iterator<Item = usize> {
    let all = 0..count;
    first.unwrap_or(slice::from_ref(&all)).to_vec().into_iter().flatten()
}

/// How a relaxation that nothing is left to move in has ended.
pub fn end_of(beads: &Beads, swings: &[Swing], threshold: f64) -> SlideEnd {
    let is_off =
        |(i, swing): (usize, &Swing)| (swing.target - beads.parameters[i]).abs() > threshold && !beads.is_fixed[i];
    if swings.iter().enumerate().any(is_off) { SlideEnd::Swinging } else { SlideEnd::Settled }
}

/// Calls back with every vertex whose target depends on where vertex `i` is, `reach` neighbours a side being looked at.
#[inline(always)]
pub fn for_each_follower(beads: &Beads, i: usize, reach: usize, mut call: impl FnMut(usize)) {
    // Away from the ends of the line, where vertices look at three on one side, without walking.
    if reach == 2 && i >= 5 && i + 5 < beads.len() {
        for at in [i - 2, i - 1, i + 1, i + 2] {
            call(at);
        }
        return;
    }
    for forward in [false, true] {
        let mut at = i;
        for distance in 1..2 * reach {
            let Some(next) = beads.step(at, forward).filter(|&next| next != i) else { break };
            at = next;
            // Further away than the reach: only a vertex next to an end looks that far back.
            if distance <= reach || distance + beads.count_neighbours(at, forward, reach) <= 2 * reach {
                call(at);
            }
        }
    }
}
