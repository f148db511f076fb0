//! Arrays that may take gigabytes, and are freed on a thread of their own where they do.
//!
//! Giving back a gigabyte takes the system a tenth of a second and more, and millions of small arrays longer: nobody shall
//! wait for that, least of all a call that was told to stop. Knows nothing of what is held.

use std::ops::{Deref, DerefMut};
use std::thread::Builder;

/// An array that takes more bytes than this, without what its items hold, is freed aside: about a millisecond.
const LARGE_BYTES: usize = 4 << 20;

/// Items that are copied in about a microsecond.
const COPIED_PER_TICK: usize = 64;

/// A `Vec` but for how it is freed; see the module.
#[derive(Clone, PartialEq, Debug)]
pub struct LargeVec<T: Send + 'static>(Vec<T>);

impl<T: Send + 'static> LargeVec<T> {
    /// An empty one with room for `capacity` items.
    pub fn with_capacity(capacity: usize) -> Self {
        Self(Vec::with_capacity(capacity))
    }

    /// Copies of `items`; `tick` is called once in so many, and may end the work with an error.
    ///
    /// # Errors
    /// Those of `tick`.
    pub fn copied<E>(items: &[T], mut tick: impl FnMut() -> Result<(), E>) -> Result<Self, E>
    where
        T: Copy,
    {
        let mut copy = Self::with_capacity(items.len());
        for part in items.chunks(COPIED_PER_TICK) {
            tick()?;
            copy.extend_from_slice(part);
        }
        Ok(copy)
    }

    /// The array itself, which its new owner frees; an empty one is left.
    pub fn take(&mut self) -> Vec<T> {
        std::mem::take(&mut self.0)
    }

    fn is_large(&self) -> bool {
        self.0.capacity() * size_of::<T>() > LARGE_BYTES
    }
}

impl<T: Send + 'static> Default for LargeVec<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: Send + 'static> From<Vec<T>> for LargeVec<T> {
    fn from(items: Vec<T>) -> Self {
        Self(items)
    }
}

impl<T: Send + 'static> FromIterator<T> for LargeVec<T> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Self {
        Self(Vec::from_iter(items))
    }
}

impl<T: Send + 'static> Deref for LargeVec<T> {
    type Target = Vec<T>;

    fn deref(&self) -> &Vec<T> {
        &self.0
    }
}

impl<T: Send + 'static> DerefMut for LargeVec<T> {
    fn deref_mut(&mut self) -> &mut Vec<T> {
        &mut self.0
    }
}

impl<T: Send + 'static> Drop for LargeVec<T> {
    fn drop(&mut self) {
        if self.is_large() {
            let items = self.take();
            // Where no thread can be had they are freed here, with the closure.
            drop(Builder::new().spawn(move || drop(items)));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Sender, channel};
    use std::thread::{ThreadId, current};

    use super::*;

    struct TellsWhere(Sender<ThreadId>);

    impl Drop for TellsWhere {
        fn drop(&mut self) {
            self.0.send(current().id()).expect("somebody listens");
        }
    }

    #[test]
    fn large_arrays_are_freed_by_another_thread_and_small_ones_at_once() {
        let (sender, receiver) = channel();
        let array = |capacity: usize| {
            let mut array = LargeVec::with_capacity(capacity);
            array.push(TellsWhere(sender.clone()));
            array
        };
        drop(array(1));
        assert_eq!(receiver.recv(), Ok(current().id()));
        drop(array(LARGE_BYTES));
        assert!(receiver.recv().is_ok_and(|thread| thread != current().id()));
    }
}
