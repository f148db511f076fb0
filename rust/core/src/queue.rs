//! The queue of a search: the least estimate first, ties by what is put in with it.
//!
//! A search nearly always goes on with a neighbour of what it has just taken. So the last thing that was put in is held
//! beside the heap: where it is the least, the heap is not touched, and else it takes the place of the heap's least, which
//! is one walk through the heap instead of two. Holds no search.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::collections::binary_heap::PeekMut;

/// Estimate and item in one number: the bits of a float that is not negative are in its order.
type Key = u128;

/// See the module.
#[derive(Clone, Debug, Default)]
pub struct Queue {
    heap: BinaryHeap<Reverse<Key>>,
    /// Of what was put in since the last was taken, the least.
    held: Option<Key>,
}

impl Queue {
    /// Puts in `item` with an estimate that is not negative and not NaN.
    #[inline]
    pub fn push(&mut self, estimate: f64, item: u64) {
        let key = u128::from(estimate.to_bits()) << 64 | u128::from(item);
        match self.held {
            None => self.held = Some(key),
            Some(held) if key < held => {
                self.heap.push(Reverse(held));
                self.held = Some(key);
            }
            Some(_) => self.heap.push(Reverse(key)),
        }
    }

    /// Takes the least.
    #[inline]
    pub fn pop(&mut self) -> Option<(f64, u64)> {
        let key = match (self.held.take(), self.heap.peek_mut()) {
            (None, least) => PeekMut::pop(least?).0,
            (Some(held), Some(mut least)) if least.0 < held => std::mem::replace(&mut least.0, held),
            (Some(held), _) => held,
        };
        Some((f64::from_bits((key >> 64) as u64), key as u64))
    }

    /// Takes all out.
    pub fn clear(&mut self) {
        self.heap.clear();
        self.held = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_is_the_least_of_what_is_in_it() {
        let mut seed = 1u64;
        let mut random = |below: u64| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 33) % below
        };
        let (mut queue, mut expected) = (Queue::default(), BinaryHeap::new());
        for _ in 0..20_000 {
            for _ in 0..random(3) {
                // Few different estimates, so that there are ties.
                let (estimate, item) = (random(40) as f64 / 8.0, random(1000) << 32);
                queue.push(estimate, item);
                expected.push(Reverse((estimate.to_bits(), item)));
            }
            let least = expected.pop().map(|Reverse((bits, item))| (f64::from_bits(bits), item));
            assert_eq!(queue.pop(), least);
        }
        queue.push(0.0, 1);
        queue.clear();
        assert_eq!(queue.pop(), None);
    }
}
