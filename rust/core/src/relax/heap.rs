//! Step C as the paper does it (section 5): the vertex that is most wrong moves first, one at a time.
//!
//! This is coordinate descent: moves grow with the square of the crossings, and a threshold stops it before its limit. It
//! is the reference that other solvers are compared with. Holds the indexed heap and the loop; how one vertex moves is in
//! `swing`.

use std::ops::{ControlFlow, Range};

use crate::filter::SlidingFilter;
use crate::relax::beads::{Beads, Neighbours};
use crate::relax::swing::{MAX_SEEKS, SlideEnd, SlideOutcome, Swing, end_of, for_each_follower, to_be_asked};

/// Moves between two calls of `on_pause`.
const MOVES_PER_PAUSE: u64 = 1 << 12;

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
) -> SlideOutcome {
    let mut heap = ErrorHeap::new(beads.len());
    let mut swings = Swing::of_all(beads);
    let mut sides = Neighbours::default();
    let stopped = |moves| SlideOutcome { moves, end: SlideEnd::Stopped };
    let mut judge = |beads: &Beads, i: usize, swing: &mut Swing, heap: &mut ErrorHeap| {
        if !beads.is_fixed[i] {
            swing.aim(beads, filter, i, &mut sides);
            heap.set(i, swing.way_from(beads.parameters[i], threshold));
        }
    };
    for (count, i) in to_be_asked(beads.len(), first).enumerate() {
        if count as u64 % MOVES_PER_PAUSE == MOVES_PER_PAUSE - 1 && on_pause().is_break() {
            return stopped(0);
        }
        judge(beads, i, &mut swings[i], &mut heap);
    }
    let reach = filter.reach();
    let mut moves = 0;
    let mut seeks = 0;
    loop {
        let Some(i) = heap.first() else {
            if seeks == MAX_SEEKS {
                break;
            }
            // Nearest points were followed from where they were: a curve may have come nearer elsewhere.
            for (i, swing) in swings.iter_mut().enumerate() {
                if i as u64 % MOVES_PER_PAUSE == MOVES_PER_PAUSE - 1 && on_pause().is_break() {
                    return stopped(moves);
                }
                if swing.forget_place() {
                    judge(beads, i, swing, &mut heap);
                }
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
        swings[i].slide(beads, i, reach > 1);
        // Its target is made from its neighbours alone, and stays.
        heap.set(i, swings[i].way_from(beads.parameters[i], threshold));
        for_each_follower(beads, i, reach, |at| judge(beads, at, &mut swings[at], &mut heap));
    }
    SlideOutcome { moves, end: end_of(beads, &swings, threshold) }
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
        assert_eq!(outcome.end, SlideEnd::Settled);
        for p in &beads.positions {
            assert!((p.y - p.x / 4.0).abs() < 1e-10, "{p}");
        }
    }
}
