//! Work space of finished calls, taken up again by the next: its memory need not be asked for and cleared each time.
//!
//! Calls on several threads each get their own. Knows nothing of what is kept.

use std::sync::Mutex;

/// See the module.
#[derive(Debug, Default)]
pub struct Pool<T>(Mutex<Vec<T>>);

impl<T: Default> Pool<T> {
    /// Work space that a finished call has left, or new.
    pub fn take(&self) -> T {
        self.0.lock().ok().and_then(|mut kept| kept.pop()).unwrap_or_default()
    }

    /// Keeps work space for the next call.
    pub fn put_back(&self, used: T) {
        if let Ok(mut kept) = self.0.lock() {
            kept.push(used);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_space_goes_to_one_call_at_a_time() {
        let pool = Pool::<Vec<u8>>::default();
        pool.put_back(Vec::with_capacity(100));
        let (used, new) = (pool.take(), pool.take());
        assert_eq!((used.capacity(), new.capacity()), (100, 0));
    }
}
