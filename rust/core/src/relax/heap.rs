//! Step C as the paper does it (section 5): the vertex that is most wrong moves first, one at a time.
//!
//! This is coordinate descent: moves grow with the square of the crossings, and a threshold stops it before its limit. It
//! is the reference that other solvers are compared with. Holds the indexed heap and the loop.
//!
//! Where crossings are uneven, the cubic's map is no descent and vertices can swing for ever. A vertex that keeps turning
//! back is damped: it goes part of the way. Damping either lets it settle at its target, or brings it to rest in the
//! middle of its swing, which the outcome tells.

use std::ops::{ControlFlow, Range};
use std::slice;

use crate::filter::SlidingFilter;
use crate::relax::beads::{Beads, Neighbours};

/// Moves between two calls of `on_pause`.
const MOVES_PER_PAUSE: u64 = 1 << 12;

/// Times that a vertex may turn back before it is damped. A vertex that settles without damping turns back less than
/// this, measured with the linear filter.
const FREE_REVERSALS: u32 = 12;

/// What every further turn leaves of a vertex's step.
const DAMPING: f64 = 0.8;

/// A vertex rests, although it is off its target, when its damped step is below this share of the threshold.
const REST: f64 = 0.01;

/// Times that all nearest points are sought again when nothing is left to move; once is enough, as a rule.
const MAX_SEEKS: u32 = 8;

/// How a relaxation ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum HeapEnd {
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
pub struct HeapOutcome {
    /// Vertices moved, counted once a move.
    pub moves: u64,
    /// How it ended.
    pub end: HeapEnd,
}

/// What is known of one vertex besides its place.
#[derive(Clone, Copy, Debug)]
struct Swing {
    target: f64,
    /// Where on the filter's curve the nearest point was found last.
    on_curve: Option<f64>,
    damping: f64,
    last_step: f64,
    reversals: u32,
}

/// Slides the beads until no free one is further than `threshold` (barycentric units) from its target, or until
/// `move_limit` moves. `on_pause` is called now and then and may stop the work. `first`: the beads that may be off their
/// targets at first; `None`: all.
///
/// Ties go to the earlier vertex. Cost: O(log n) and at most `2 reach` targets a move, one or two more next to an end.
pub fn relax_by_heap(
    beads: &mut Beads,
    filter: &impl SlidingFilter,
    threshold: f64,
    move_limit: u64,
    first: Option<&[Range<usize>]>,
    mut on_pause: impl FnMut() -> ControlFlow<()>,
) -> HeapOutcome {
    let mut heap = ErrorHeap::new(beads.len());
    let start = |&target: &f64| Swing { target, on_curve: None, damping: 1.0, last_step: 0.0, reversals: 0 };
    let mut swings: Vec<Swing> = beads.parameters.iter().map(start).collect();
    let mut sides = Neighbours::default();
    let all = 0..beads.len();
    let stopped = |moves| HeapOutcome { moves, end: HeapEnd::Stopped };
    for (count, i) in first.unwrap_or(slice::from_ref(&all)).iter().cloned().flatten().enumerate() {
        if count as u64 % MOVES_PER_PAUSE == MOVES_PER_PAUSE - 1 && on_pause().is_break() {
            return stopped(0);
        }
        judge(beads, filter, i, threshold, &mut swings[i], &mut heap, &mut sides);
    }
    let reach = filter.reach();
    let mut moves = 0;
    let mut seeks = 0;
    loop {
        let Some(i) = heap.first() else {
            // Nearest points were followed from where they were: a curve may have come nearer elsewhere.
            if seeks == MAX_SEEKS {
                break;
            }
            let sought = seek_again(beads, filter, threshold, &mut swings, &mut heap, &mut sides, &mut on_pause);
            if sought.is_break() {
                return stopped(moves);
            }
            if heap.first().is_none() {
                break;
            }
            seeks += 1;
            continue;
        };
        if moves == move_limit || (moves % MOVES_PER_PAUSE == MOVES_PER_PAUSE - 1 && on_pause().is_break()) {
            return stopped(moves);
        }
        moves += 1;
        slide(beads, i, &mut swings[i], reach > 1);
        // Its target is made from its neighbours alone, and stays.
        rank(beads, i, threshold, &swings[i], &mut heap);
        // Away from the ends of the line, where vertices look at three on one side, without walking.
        if reach == 2 && i >= 5 && i + 5 < beads.len() {
            for at in [i - 2, i - 1, i + 1, i + 2] {
                judge(beads, filter, at, threshold, &mut swings[at], &mut heap, &mut sides);
            }
            continue;
        }
        for forward in [false, true] {
            let mut at = i;
            for distance in 1..2 * reach {
                let Some(next) = beads.step(at, forward).filter(|&next| next != i) else { break };
                at = next;
                // Further away than the reach: only a vertex next to an end looks that far back.
                if distance <= reach || distance + beads.count_neighbours(at, forward, reach) <= 2 * reach {
                    judge(beads, filter, at, threshold, &mut swings[at], &mut heap, &mut sides);
                }
            }
        }
    }
    let is_off =
        |(i, swing): (usize, &Swing)| (swing.target - beads.parameters[i]).abs() > threshold && !beads.is_fixed[i];
    let end = if swings.iter().enumerate().any(is_off) { HeapEnd::Swinging } else { HeapEnd::Settled };
    HeapOutcome { moves, end }
}

/// Seeks the targets of all vertices that have one without following; those that are off their targets now are in the heap.
fn seek_again(
    beads: &Beads,
    filter: &impl SlidingFilter,
    threshold: f64,
    swings: &mut [Swing],
    heap: &mut ErrorHeap,
    sides: &mut Neighbours,
    on_pause: &mut impl FnMut() -> ControlFlow<()>,
) -> ControlFlow<()> {
    for (i, swing) in swings.iter_mut().enumerate().filter(|(_, swing)| swing.on_curve.is_some()) {
        if i as u64 % MOVES_PER_PAUSE == MOVES_PER_PAUSE - 1 {
            on_pause()?;
        }
        swing.on_curve = None;
        judge(beads, filter, i, threshold, swing, heap, sides);
    }
    ControlFlow::Continue(())
}

/// Moves vertex `i` towards its target, all the way unless it is damped. The linear filter, which looks at one neighbour a
/// side, needs no damping: its vertices turn back by rounding alone, and damping would only slow them down.
fn slide(beads: &mut Beads, i: usize, swing: &mut Swing, may_damp: bool) {
    let t = beads.parameters[i];
    let whole = swing.target - t;
    if may_damp && whole * swing.last_step < 0.0 {
        swing.reversals += 1;
        if swing.reversals > FREE_REVERSALS {
            swing.damping *= DAMPING;
        }
    }
    swing.last_step = whole;
    // Not t + 1.0 * whole, which need not be the target to the bit: targets of 0 and 1 are mesh vertices.
    let next = if swing.damping == 1.0 { swing.target } else { (t + swing.damping * whole).clamp(0.0, 1.0) };
    beads.slide(i, next);
}

/// Finds the target and error of vertex `i` anew.
fn judge(
    beads: &Beads,
    filter: &impl SlidingFilter,
    i: usize,
    threshold: f64,
    swing: &mut Swing,
    heap: &mut ErrorHeap,
    sides: &mut Neighbours,
) {
    if beads.is_fixed[i] {
        return;
    }
    let t = beads.parameters[i];
    let four = (filter.reach() == 2).then(|| beads.four_around(i)).flatten();
    let found = four.and_then(|(others, inner)| {
        let points = others.map(|k| beads.positions[k]);
        filter.target_of_four(&beads.edges[i], &points, inner, t, swing.on_curve)
    });
    let found = found.unwrap_or_else(|| {
        beads.neighbourhood(i, filter.reach(), sides);
        filter.target(&beads.edges[i], &sides.before, &sides.after, t, swing.on_curve)
    });
    (swing.target, swing.on_curve) = (found.t, found.on_curve);
    rank(beads, i, threshold, swing, heap);
}

/// Puts vertex `i` where its error belongs in the heap.
fn rank(beads: &Beads, i: usize, threshold: f64, swing: &Swing, heap: &mut ErrorHeap) {
    let error = (swing.target - beads.parameters[i]).abs();
    let step = swing.damping * error;
    heap.set(i, if error > threshold && step > REST * threshold { step } else { 0.0 });
}

/// A binary heap of vertices by error, largest first, that knows the place of each; vertices without error are not in it.
struct ErrorHeap {
    errors: Vec<f64>,
    order: Vec<u32>,
    places: Vec<u32>,
}

const ABSENT: u32 = u32::MAX;

impl ErrorHeap {
    fn new(count: usize) -> Self {
        Self { errors: vec![0.0; count], order: Vec::with_capacity(count), places: vec![ABSENT; count] }
    }

    fn first(&self) -> Option<usize> {
        self.order.first().map(|&i| i as usize)
    }

    fn is_before(&self, a: u32, b: u32) -> bool {
        let (ea, eb) = (self.errors[a as usize], self.errors[b as usize]);
        ea > eb || (ea == eb && a < b)
    }

    fn set(&mut self, i: usize, error: f64) {
        let place = self.places[i];
        if error == 0.0 {
            if place != ABSENT {
                self.remove(place as usize);
            }
            self.errors[i] = 0.0;
            return;
        }
        self.errors[i] = error;
        let place = if place == ABSENT {
            self.order.push(i as u32);
            self.places[i] = self.order.len() as u32 - 1;
            self.order.len() - 1
        } else {
            place as usize
        };
        let place = self.rise(place);
        self.sink(place);
    }

    fn remove(&mut self, place: usize) {
        let gone = self.order.swap_remove(place);
        self.places[gone as usize] = ABSENT;
        if place < self.order.len() {
            self.places[self.order[place] as usize] = place as u32;
            let place = self.rise(place);
            self.sink(place);
        }
    }

    fn swap(&mut self, a: usize, b: usize) {
        self.order.swap(a, b);
        self.places[self.order[a] as usize] = a as u32;
        self.places[self.order[b] as usize] = b as u32;
    }

    fn rise(&mut self, mut place: usize) -> usize {
        while place > 0 {
            let parent = (place - 1) / 2;
            if !self.is_before(self.order[place], self.order[parent]) {
                break;
            }
            self.swap(place, parent);
            place = parent;
        }
        place
    }

    fn sink(&mut self, mut place: usize) {
        loop {
            let mut best = place;
            for child in [2 * place + 1, 2 * place + 2] {
                if child < self.order.len() && self.is_before(self.order[child], self.order[best]) {
                    best = child;
                }
            }
            if best == place {
                return;
            }
            self.swap(place, best);
            place = best;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::{Edge, linear::Linear};
    use glam::DVec3;

    #[test]
    fn the_heap_gives_the_largest_error_first_and_ties_to_the_earlier() {
        let mut heap = ErrorHeap::new(6);
        for (i, error) in [0.3, 0.5, 0.1, 0.5, 0.0, 0.2].into_iter().enumerate() {
            heap.set(i, error);
        }
        heap.set(2, 0.6);
        heap.set(0, 0.05);
        let mut order = Vec::new();
        while let Some(i) = heap.first() {
            order.push(i);
            heap.set(i, 0.0);
        }
        assert_eq!(order, [2, 1, 3, 5, 0]);
    }

    #[test]
    fn a_line_over_parallel_edges_becomes_straight() {
        let mut beads = Beads::default();
        beads.push_fixed(DVec3::ZERO);
        for i in 1..6 {
            let x = f64::from(i);
            let edge = Edge { low: DVec3::new(x, -1.0, 0.0), high: DVec3::new(x, 3.0, 0.0) };
            beads.push(edge, if i % 2 == 0 { 0.1 } else { 0.9 });
        }
        beads.push_fixed(DVec3::new(6.0, 1.5, 0.0));
        let outcome = relax_by_heap(&mut beads, &Linear, 1e-12, 100_000, None, || ControlFlow::Continue(()));
        assert_eq!(outcome.end, HeapEnd::Settled);
        for p in &beads.positions {
            assert!((p.y - p.x / 4.0).abs() < 1e-10, "{p}");
        }
    }
}
