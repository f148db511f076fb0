//! Pauses in long work: the observer is asked once in so many units of it whether to go on.
//!
//! Holds no clock, as the core has none: a unit is what takes about a microsecond (a crossing, a sample, a row of a band).

use crate::error::Result;
use crate::report::{Observer, Step};
use crate::smooth::go_on;

/// Units between two calls of the observer: a few milliseconds, also where a unit is a span that has to be bent.
const UNITS_PER_PAUSE: u32 = 1024;

/// See the module.
pub struct Pauses<'a> {
    observer: &'a mut dyn Observer,
    step: Step,
    left: u32,
}

impl<'a> Pauses<'a> {
    /// For work that is a part of `step`.
    pub fn new(observer: &'a mut dyn Observer, step: Step) -> Self {
        Self { observer, step, left: UNITS_PER_PAUSE }
    }

    /// One unit is about to be done.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when the observer says so.
    #[inline]
    pub fn tick(&mut self) -> Result<()> {
        self.left -= 1;
        if self.left == 0 { self.pause() } else { Ok(()) }
    }

    /// `count` units were done or are about to be, a few thousand at most.
    ///
    /// # Errors
    /// As [`Pauses::tick`].
    #[inline]
    pub fn ticks(&mut self, count: usize) -> Result<()> {
        match u32::try_from(count) {
            Ok(count) if count < self.left => {
                self.left -= count;
                Ok(())
            }
            _ => self.pause(),
        }
    }

    /// Asks the observer now.
    ///
    /// # Errors
    /// As [`Pauses::tick`].
    pub fn pause(&mut self) -> Result<()> {
        self.left = UNITS_PER_PAUSE;
        go_on(self.observer, self.step)
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::error::Error;

    struct Counter(u32);

    impl Observer for Counter {
        fn step(&mut self, _: Step) -> ControlFlow<()> {
            self.0 += 1;
            if self.0 == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }
    }

    #[test]
    fn the_observer_is_asked_once_in_so_many_units_and_can_end_the_work() {
        let mut observer = Counter(0);
        let mut pauses = Pauses::new(&mut observer, Step::Relax);
        let done = (0..10 * UNITS_PER_PAUSE).take_while(|_| pauses.tick().is_ok()).count() as u32;
        assert_eq!((done, observer.0), (3 * UNITS_PER_PAUSE - 1, 3));
        assert_eq!(Pauses::new(&mut Counter(2), Step::Relax).pause(), Err(Error::Interrupted));
        // Several units at once: never more than were left without being asked.
        let mut observer = Counter(2);
        let mut pauses = Pauses::new(&mut observer, Step::Relax);
        assert_eq!(pauses.ticks(UNITS_PER_PAUSE as usize - 1), Ok(()));
        assert_eq!(pauses.ticks(1), Err(Error::Interrupted));
        assert_eq!(Pauses::new(&mut Counter(2), Step::Relax).ticks(usize::MAX), Err(Error::Interrupted));
    }
}
