"""Ending a call and measuring how soon it ends, in CPU seconds of this process. Holds no test.

Time on the wall says how busy the machine is; what the library owes its caller is to look at signals and limits before
it has worked on for 0.2 s. On an idle machine the two are the same.
"""

import signal
import time

import pytest

# A call ends before it has worked on for this long after its limit or signal: 0.2 s on the processor that the figures
# of docs/filters.md are from, and twice that here, as a test may run on one that is half as fast.
STOP_SECONDS = 2 * 0.2


class StopError(Exception):
    """What the handler of the test's signal raises."""


def repeat(call):
    """Calls without end; one call alone may be done too early."""
    while True:
        call()


def interrupt(call, after=0.1):
    """CPU seconds from a signal, which comes after `after` CPU seconds, to the exception of its handler."""

    def handle(signum, frame):
        raise StopError

    previous = signal.signal(signal.SIGPROF, handle)
    begun = time.process_time()
    try:
        signal.setitimer(signal.ITIMER_PROF, after)
        with pytest.raises(StopError):
            repeat(call)
        return time.process_time() - begun - after
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, previous)


class Looks:
    """A `stop` that notes the CPU time of each look at it, and is set after `seconds` of it."""

    def __init__(self, seconds):
        self.begun = self.last = time.process_time()
        self.seconds = seconds
        self.longest = 0.0

    def is_set(self):
        self.note()
        return self.last - self.begun > self.seconds

    def note(self):
        now = time.process_time()
        self.longest = max(self.longest, now - self.last)
        self.last = now
