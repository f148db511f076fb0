# SPDX-License-Identifier: GPL-3.0-or-later
"""The library's long work, done so that Blender need not wait: in a thread, and ended by Esc.

What an operator does is written down once, as plain functions that read, compute and then write. `do` is what they
call for the computing. For a script, and when an operator is repeated from its panel, it simply does it, within the
time that the preferences allow. In a `Run`, which an operator begins when a person calls it, `do` starts a thread and
raises `NotYet`, which leads out of everything, as nothing has been written so far; when the thread is done the operator
is executed again, and `do` returns what it made. Knows no operators.
"""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

from . import native, preferences
from .errors import LimitError

Prepared = TypeVar("Prepared")
Made = TypeVar("Made")
# Of a step that is not done yet.
NOTHING = object()


class NotYet(BaseException):
    """Raised by `do` in a run: a thread is at it. No `Exception`, so that nothing takes it for a refusal."""


class Run:
    """The steps of one call of an operator: what is done already, and what a thread is at."""

    def __init__(self) -> None:
        self.done: list[tuple[Any, BaseException | None]] = []
        self.position = 0
        self.stop = threading.Event()
        self.thread: threading.Thread | None = None
        self.outcome: list[tuple[Any, BaseException | None]] = []

    def take_step(self) -> Any:
        """What the next step made, NOTHING when it is not done; its error is raised."""
        if self.position == len(self.done):
            return NOTHING
        made, error = self.done[self.position]
        self.position += 1
        if error is not None:
            raise error
        return made

    def start(self, work: Callable[[], Any]) -> None:
        """Begin the next step in a thread."""
        self.outcome = outcome = []

        def keep() -> None:
            try:
                outcome.append((work(), None))
            except BaseException as error:
                outcome.append((None, error))

        self.thread = threading.Thread(target=keep, name="smooth polylines: ahead", daemon=True)
        self.thread.start()

    def wait(self, seconds: float) -> bool:
        """Whether the step that a thread is at has ended, after waiting so long for it."""
        if self.thread is not None:
            self.thread.join(max(seconds, 0.0))
            if self.thread.is_alive():
                return False
            self.thread = None
            self.done += self.outcome
        return True

    def leave(self) -> None:
        """Have the thread stop; what it cannot stop it does in vain."""
        self.stop.set()


_run: Run | None = None


@contextmanager
def at_work(run: Run | None) -> Iterator[None]:
    """While an operator is executed: `do` belongs to its run. None: to none, as in handlers that are called amid it."""
    global _run
    before, _run = _run, run
    if run is not None:
        run.position = 0
    try:
        yield
    finally:
        _run = before


def do(prepare: Callable[[], Prepared], work: Callable[[Prepared, dict[str, Any]], Made]) -> Made:
    """What `work` makes of what `prepare` gives.

    prepare : may read Blender's data; not called again for a step that is done
    work : knows nothing of Blender; gets as second the options by which the library can be stopped

    Raises what `work` does, LimitError after the time that the preferences allow, NotYet in a run.
    """
    if _run is None:
        return do_now(prepare(), work)
    made = _run.take_step()
    if made is NOTHING:
        prepared, stop = prepare(), _run.stop
        _run.start(lambda: work(prepared, {"stop": stop}))
        raise NotYet
    return made


def do_now(prepared: Prepared, work: Callable[[Prepared, dict[str, Any]], Made]) -> Made:
    """`work`, while Blender waits."""
    limit = preferences.get_time_limit()
    try:
        return work(prepared, {} if limit is None else {"time_limit": limit})
    except native.load_library().LimitError as error:
        raise LimitError(
            f"It took longer than {limit:g} seconds and was stopped ({error}). Allow more in the add-on's preferences "
            "(Time Limit), or choose another filter or a larger Threshold"
        ) from error


def finish(run: Run, execute: Callable[[], set[str]], seconds: float) -> set[str] | None:
    """Execute an operator as far as its steps are done, waiting so long in all for threads; None: not yet done."""
    until = time.perf_counter() + seconds
    while run.wait(until - time.perf_counter()):
        try:
            with at_work(run):
                return execute()
        except NotYet:
            continue
    return None
