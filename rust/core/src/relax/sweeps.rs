//! Step C vertex by vertex along the line, to and fro: every vertex that is off its target moves when it is come to.
//!
//! Where many vertices are off, this is as good an order as the heap's (`heap`), and a move costs one or two targets instead of
//! four: those of the neighbours are not asked before their turn. A vertex none of whose neighbours has moved since its own
//! turn is passed over. How one vertex moves is in `swing`.
//!
//! Source: sweeps to and fro are the symmetric form of the Gauss-Seidel method.

use std::ops::{ControlFlow, Range};

use crate::filter::SlidingFilter;
use crate::relax::beads::{Beads, Neighbours};
use crate::relax::swing::{MAX_SEEKS, SlideEnd, SlideOutcome, Swing, end_of, for_each_follower, to_be_asked};

/// Targets between two calls of `on_pause`.
const TARGETS_PER_PAUSE: u64 = 1 << 13;

/// Slides the beads until no free one is further than `threshold` (barycentric units) from its target, or until
/// `move_limit` moves. `on_pause` is called now and then and may stop the work. `first`: the beads that may be off their
/// targets at first; `None`: all.
///
/// Cost: as many targets as there are vertices whose neighbours have moved, in each sweep.
pub fn relax_by_sweeps(
    beads: &mut Beads,
    filter: &impl SlidingFilter,
    threshold: f64,
    move_limit: u64,
    first: Option<&[Range<usize>]>,
    mut on_pause: impl FnMut() -> ControlFlow<()>,
) -> SlideOutcome {
    let mut due = Marks::new(beads.len());
    for i in to_be_asked(beads.len(), first) {
        due.set(i);
    }
    // Whose nearest point was followed from where it was: the curve may have come nearer elsewhere.
    let mut followed = Marks::new(beads.len());
    let mut swings = Swing::of_all(beads);
    let mut sides = Neighbours::default();
    let reach = filter.reach();
    let (mut moves, mut targets, mut seeks) = (0, 0u64, 0);
    let stopped = |moves| SlideOutcome { moves, end: SlideEnd::Stopped };
    loop {
        for forward in [true, false] {
            let mut next = if forward { due.first_from(0) } else { due.last_before(beads.len()) };
            while let Some(i) = next {
                due.clear(i);
                if !beads.is_fixed[i] {
                    targets += 1;
                    if targets % TARGETS_PER_PAUSE == 0 && on_pause().is_break() {
                        return stopped(moves);
                    }
                    let swing = &mut swings[i];
                    if swing.has_place() {
                        followed.set(i);
                    }
                    swing.aim(beads, filter, i, &mut sides);
                    if swing.way_from(beads.parameters[i], threshold) > 0.0 {
                        if moves == move_limit {
                            return stopped(moves);
                        }
                        moves += 1;
                        swing.slide(beads, i, reach > 1);
                        if swing.way_from(beads.parameters[i], threshold) > 0.0 {
                            // It was damped: its target stays, and it goes on.
                            due.set(i);
                        }
                        for_each_follower(beads, i, reach, |at| due.set(at));
                    }
                }
                next = if forward { due.first_from(i + 1) } else { due.last_before(i) };
            }
        }
        if !due.is_empty() {
            continue;
        }
        if seeks == MAX_SEEKS || followed.is_empty() {
            break;
        }
        seeks += 1;
        let mut next = followed.first_from(0);
        while let Some(i) = next {
            followed.clear(i);
            swings[i].forget_place();
            due.set(i);
            next = followed.first_from(i + 1);
        }
    }
    SlideOutcome { moves, end: end_of(beads, &swings, threshold) }
}

/// A set of vertices, of which the next one is found in a step for every 4096 between: one bit each, and one for every 64 that
/// are not all empty.
struct Marks {
    bits: Vec<u64>,
    groups: Vec<u64>,
}

const WORD: usize = u64::BITS as usize;

impl Marks {
    fn new(count: usize) -> Self {
        let words = count.div_ceil(WORD);
        Self { bits: vec![0; words], groups: vec![0; words.div_ceil(WORD)] }
    }

    #[inline]
    fn set(&mut self, i: usize) {
        self.bits[i / WORD] |= 1 << (i % WORD);
        self.groups[i / WORD / WORD] |= 1 << (i / WORD % WORD);
    }

    #[inline]
    fn clear(&mut self, i: usize) {
        let word = i / WORD;
        self.bits[word] &= !(1 << (i % WORD));
        if self.bits[word] == 0 {
            self.groups[word / WORD] &= !(1 << (word % WORD));
        }
    }

    fn is_empty(&self) -> bool {
        self.groups.iter().all(|&group| group == 0)
    }

    /// The first one from `i` on.
    #[inline]
    fn first_from(&self, i: usize) -> Option<usize> {
        let word = i / WORD;
        let here = self.bits.get(word)? & (u64::MAX << (i % WORD));
        if here != 0 {
            return Some(word * WORD + here.trailing_zeros() as usize);
        }
        let next = first_bit_from(&self.groups, word + 1)?;
        Some(next * WORD + self.bits[next].trailing_zeros() as usize)
    }

    /// The last one before `i`.
    #[inline]
    fn last_before(&self, i: usize) -> Option<usize> {
        let last = i.checked_sub(1)?;
        let word = last / WORD;
        let here = self.bits[word] & (u64::MAX >> (WORD - 1 - last % WORD));
        if here != 0 {
            return Some(word * WORD + here.ilog2() as usize);
        }
        let before = last_bit_before(&self.groups, word)?;
        Some(before * WORD + self.bits[before].ilog2() as usize)
    }
}

fn first_bit_from(words: &[u64], i: usize) -> Option<usize> {
    let start = i / WORD;
    let mut mask = u64::MAX << (i % WORD);
    for (k, &word) in words.iter().enumerate().skip(start) {
        if word & mask != 0 {
            return Some(k * WORD + (word & mask).trailing_zeros() as usize);
        }
        mask = u64::MAX;
    }
    None
}

fn last_bit_before(words: &[u64], i: usize) -> Option<usize> {
    let last = i.checked_sub(1)?;
    let mut mask = u64::MAX >> (WORD - 1 - last % WORD);
    for k in (0..=last / WORD).rev() {
        if words[k] & mask != 0 {
            return Some(k * WORD + (words[k] & mask).ilog2() as usize);
        }
        mask = u64::MAX;
    }
    None
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::slice;

    use glam::DVec3;

    use super::*;
    use crate::filter::cubic::Cubic;
    use crate::filter::linear::Linear;
    use crate::filter::{Edge, Target};
    use crate::options::{DEFAULT_SUPPORT, Knots};
    use crate::relax::heap::relax_by_heap;

    const CUBIC: Cubic = Cubic { knots: Knots::Centripetal, support: DEFAULT_SUPPORT };

    fn fence(count: usize) -> Beads {
        Beads::on_a_fence(count, 0.1)
    }

    #[test]
    fn marks_are_found_both_ways_across_words_and_groups() {
        let count = 3 * WORD * WORD + 7;
        let places = [0, 1, 63, 64, 65, 4095, 4096, 5000, 8191, 12_294];
        let mut marks = Marks::new(count);
        assert!(marks.is_empty() && marks.first_from(0).is_none() && marks.last_before(count).is_none());
        places.iter().for_each(|&i| marks.set(i));
        for i in 0..=count {
            assert_eq!(marks.first_from(i), places.iter().copied().find(|&p| p >= i), "from {i}");
            assert_eq!(marks.last_before(i), places.iter().rev().copied().find(|&p| p < i), "before {i}");
        }
        places.iter().for_each(|&i| marks.clear(i));
        assert!(marks.is_empty());
    }

    /// A filter that counts what it is asked.
    struct Counted<'a>(Cubic, &'a Cell<u64>);

    impl SlidingFilter for Counted<'_> {
        fn reach(&self) -> usize {
            self.0.reach()
        }

        fn target(&self, edge: &Edge, before: &[DVec3], after: &[DVec3], t: f64, near: Option<f64>) -> Target {
            self.1.set(self.1.get() + 1);
            self.0.target(edge, before, after, t, near)
        }

        fn measure(&self, points: &[DVec3]) -> f64 {
            self.0.measure(points)
        }
    }

    #[test]
    fn the_heap_has_nothing_left_to_do_and_asks_for_more_targets() {
        for support in [2, 3] {
            let cubic = Cubic { support, ..CUBIC };
            let (by_sweeps, by_heap, after) = (Cell::new(0), Cell::new(0), Cell::new(0));
            let (mut beads, mut slow) = (fence(200), fence(200));
            let most = 100_000;
            let go_on = || ControlFlow::Continue(());
            let outcome = relax_by_sweeps(&mut beads, &Counted(cubic, &by_sweeps), 1e-3, most, None, go_on);
            assert_eq!(outcome.end, SlideEnd::Settled);
            let heap = relax_by_heap(&mut slow, &Counted(cubic, &by_heap), 1e-3, most, None, go_on);
            assert_eq!(heap.end, SlideEnd::Settled);
            assert!(3 * by_sweeps.get() < 2 * by_heap.get(), "{by_sweeps:?} {by_heap:?}, moves {outcome:?} {heap:?}");
            let rest = relax_by_heap(&mut beads, &Counted(cubic, &after), 1e-3, most, None, go_on);
            assert_eq!(rest, SlideOutcome { moves: 0, end: SlideEnd::Settled });
        }
    }

    /// Where the map is a descent both orders end in one place.
    #[test]
    fn the_linear_filter_leads_to_where_the_heap_does() {
        let (mut beads, mut slow) = (fence(12), fence(12));
        let go_on = || ControlFlow::Continue(());
        assert_eq!(relax_by_sweeps(&mut beads, &Linear, 1e-12, 100_000, None, go_on).end, SlideEnd::Settled);
        assert_eq!(relax_by_heap(&mut slow, &Linear, 1e-12, 100_000, None, go_on).end, SlideEnd::Settled);
        for (t, other) in beads.parameters.iter().zip(&slow.parameters) {
            assert!((t - other).abs() < 1e-10, "{t} {other}");
        }
    }

    #[test]
    fn limits_pauses_and_ranges_hold() {
        let ask = |beads: &mut Beads, limit, first: Option<&[Range<usize>]>| {
            relax_by_sweeps(beads, &CUBIC, 1e-3, limit, first, || ControlFlow::Continue(()))
        };
        let mut beads = fence(60);
        assert_eq!(ask(&mut beads, 7, None), SlideOutcome { moves: 7, end: SlideEnd::Stopped });
        // What is at rest stays so, except where something near it is not.
        let mut beads = fence(600);
        assert_eq!(ask(&mut beads, 1_000_000, None).end, SlideEnd::Settled);
        let before = beads.parameters.clone();
        beads.slide(300, before[300] + 0.01);
        assert_eq!(
            ask(&mut beads, 1_000, Some(slice::from_ref(&(10..20)))),
            SlideOutcome { moves: 0, end: SlideEnd::Settled }
        );
        assert!(ask(&mut beads, 1_000, Some(slice::from_ref(&(300..301)))).moves > 0);
        assert_eq!(beads.parameters[..200], before[..200]);
        let mut asked = 0;
        let outcome = relax_by_sweeps(&mut fence(9_000), &CUBIC, 1e-3, 1_000_000, None, || {
            asked += 1;
            ControlFlow::Break(())
        });
        assert_eq!((asked, outcome.end), (1, SlideEnd::Stopped));
    }
}
