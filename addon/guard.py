# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns errors into what an artist reads; the only place in the add-on that catches broadly.

Refusals (ours and the library's) become an error report and CANCELLED. Anything else is a bug: a short
message for the artist, the whole traceback for the console. Holds no logic of an operator.
"""

import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import bpy

from . import ahead, native
from .errors import AddonError

# What must end the process or the run as its sender meant it.
PASSED_ON = (KeyboardInterrupt, SystemExit, GeneratorExit, ahead.NotYet)


def run_guarded(operator: Any, work: Callable[[], None]) -> set[str]:
    """Call `work` for `operator`: {'FINISHED'}, or an error report and {'CANCELLED'}."""
    with give_window():
        message = run_quietly(work)
    if message is None:
        return {"FINISHED"}
    operator.report({"ERROR"}, message)
    return {"CANCELLED"}


@contextmanager
def give_window() -> Iterator[None]:
    """A window for operators of Blender's own that need one to know what is active: a timer and a handler have none."""
    windows = bpy.context.window_manager.windows
    if bpy.context.window is not None or len(windows) == 0:
        yield
        return
    with bpy.context.temp_override(window=windows[0]):
        yield


def run_quietly(work: Callable[[], None]) -> str | None:
    """Call `work`; None when it was done, else what to tell the artist."""
    try:
        work()
    except PASSED_ON:
        raise
    except BaseException as error:
        # BaseException, because a panic in native code is not an Exception.
        if isinstance(error, AddonError) or native.is_refusal(error):
            return str(error)
        traceback.print_exception(error)
        return (
            f"Smooth Polylines failed unexpectedly ({type(error).__name__}); nothing was changed. "
            "The system console has the details: please report them"
        )
    return None
