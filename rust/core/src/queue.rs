//! The queue of a search: the least estimate first, ties by what is put in with it.
//!
//! A search nearly always goes on with a neighbour of what it has just taken. So the last thing that was put in is held
//! beside the heap: where it is the least, the heap is not touched, and else it takes the place of the heap's least, which
//! is one walk through the heap instead of two. Holds no search.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::collections::binary_heap::PeekMut;

/// See the module. A key is an estimate and an item in one number: [`Queue::push`] keeps both whole, in 128 bits;
/// [`ShortKeys`] makes do with 64.
#[derive(Clone, Debug)]
pub struct Queue<K> {
    heap: BinaryHeap<Reverse<K>>,
    /// Of what was put in since the last was taken, the least.
    held: Option<K>,
}

/// Keys of half the size, which a heap compares and moves in half the time: an estimate gives up as many of its last bits as
/// items need. So estimates that are nearly equal count as equal: to 2^-34 of them among the items of a mesh of 269 000
/// triangles, to 2^-31 of 4 million, to 2^-21 of what 32 bits can tell apart. For searches that mend what was taken too early.
#[derive(Clone, Copy, Debug)]
pub struct ShortKeys {
    item_bits: u32,
}

impl ShortKeys {
    /// Keys for items below `count`, which is at most 2^32.
    pub fn of_items_below(count: usize) -> Self {
        Self { item_bits: usize::BITS - count.saturating_sub(1).leading_zeros() }
    }

    /// The key of `item` with an estimate that is not negative and not NaN.
    #[inline]
    pub fn key(self, estimate: f64, item: u32) -> u64 {
        // The bits of a float that is not negative are in its order, and the first of them is 0.
        estimate.to_bits() << 1 >> self.item_bits << self.item_bits | u64::from(item)
    }

    /// The estimate, rounded down, and the item.
    #[inline]
    pub fn split(self, key: u64) -> (f64, u32) {
        let whole = key >> self.item_bits << self.item_bits;
        (f64::from_bits(whole >> 1), (key - whole) as u32)
    }
}

impl<K> Default for Queue<K>
where
    K: Ord,
{
    fn default() -> Self {
        Self { heap: BinaryHeap::new(), held: None }
    }
}

impl Queue<u128> {
    /// Puts in `item` with an estimate that is not negative and not NaN.
    #[inline]
    pub fn push(&mut self, estimate: f64, item: u64) {
        self.push_key(u128::from(estimate.to_bits()) << 64 | u128::from(item));
    }

    /// Takes the least.
    #[inline]
    pub fn pop(&mut self) -> Option<(f64, u64)> {
        self.pop_key().map(|key| (f64::from_bits((key >> 64) as u64), key as u64))
    }
}

impl<K: Ord + Copy> Queue<K> {
    /// Puts in a key.
    #[inline]
    pub fn push_key(&mut self, key: K) {
        match self.held {
            None => self.held = Some(key),
            Some(held) if key < held => {
                self.heap.push(Reverse(held));
                self.held = Some(key);
            }
            Some(_) => self.heap.push(Reverse(key)),
        }
    }

    /// Takes the least key.
    #[inline]
    pub fn pop_key(&mut self) -> Option<K> {
        Some(match (self.held.take(), self.heap.peek_mut()) {
            (None, least) => PeekMut::pop(least?).0,
            (Some(held), Some(mut least)) if least.0 < held => std::mem::replace(&mut least.0, held),
            (Some(held), _) => held,
        })
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
        let (mut queue, mut expected) = (Queue::<u128>::default(), BinaryHeap::new());
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

    #[test]
    fn short_keys_are_in_the_order_of_estimates_and_give_the_item_back() {
        for count in [1, 2, 3, 5804, 268_686, 1 << 22, (1 << 22) + 1, 1 << 32] {
            let (keys, last) = (ShortKeys::of_items_below(count), (count - 1) as u32);
            let estimates = [0.0, 5e-324, 1e-300, 0.1, 1.0, 1.1, 1.1 * (1.0 + 1e-6), 7e9, 1e300, f64::INFINITY];
            for pair in estimates.windows(2) {
                // Estimates that differ by more than is given up: whatever the items.
                assert!(keys.key(pair[0], last) < keys.key(pair[1], 0) || pair[1] == 5e-324, "{count}: {pair:?}");
                for item in [0, last / 2, last] {
                    let (estimate, same) = keys.split(keys.key(pair[1], item));
                    assert_eq!(same, item);
                    let share = 2f64.powi(keys.item_bits as i32 - 53);
                    assert!(estimate <= pair[1] && (estimate >= pair[1] * (1.0 - share) || pair[1] < 1e-307));
                }
            }
            assert!(keys.key(f64::INFINITY, last) < u64::MAX);
        }
    }
}
