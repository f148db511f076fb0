"""`--check`: whether the inputs of a good job will do. Makes nothing: logs lie in a temporary folder, gone at the end.

Every input is looked at from outside first; those that pass are opened in worker processes like those of a run, which
find objects, picks and guides, and ways from pick to pick, but smooth nothing.
"""

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Any

from . import input_check
from .errors import StopRun
from .job_file import Job
from .local_pool import LocalPool
from .plan import Item
from .progress import Progress
from .worker_process import find_worker_command

ALL_GOOD, SOME_BAD = 0, 1


def check(options: argparse.Namespace, job: Job, items: list[Item], blender: str | None) -> int:
    """One line for each thing that a run would fail at, and a last one on the whole; the exit code."""
    faults = {}
    for item in items:
        fault = input_check.find_fault(item)
        if fault is not None:
            faults[item] = [f"{item.name}: {fault[0]}: {fault[1]}"]
    reason = None
    left = [item for item in items if item not in faults]
    if left and not options.check_names:
        reason = open_all(options, job, left, blender, faults)
    for item in sorted(faults, key=lambda item: item.index):
        print("\n".join(faults[item]))
    values = job.values
    bad = sum(bool(lines) for lines in faults.values())
    print(
        f"{job.path.name} is a good job: {len(items)} files ({bad} of them will fail), {len(values['lines'])} lines, "
        f"{len(values['nets'])} nets, into {job.output}"
    )
    if reason is not None:
        print(f"Ended early: {reason}", file=sys.stderr)
    return SOME_BAD if bad or reason is not None else ALL_GOOD


def open_all(
    options: argparse.Namespace, job: Job, items: list[Item], blender: str | None, faults: dict[Item, list[str]]
) -> str | None:
    """Have all `items` opened, and add what is wrong to `faults`; None, or why it ended early."""
    progress = Progress(len(items), 0, is_quiet=options.quiet, words=("to look at", "looked at"))
    with tempfile.TemporaryDirectory(prefix="smooth-polylines-check-") as logs:
        command = find_worker_command(blender)
        pool = LocalPool(job, command, options.jobs, "check", options.profile, logs=Path(logs), is_check=True)
        try:
            hello = pool.start_first()
            progress.begin(f"in Blender {hello['blender']}")
            for item, outcome in pool.run(items):
                failed = [describe(item, entry) for entry in outcome["entries"] if entry["status"] == "failed"]
                if failed:
                    faults[item] = failed
                progress.add(item.name, [], sum(outcome["seconds"].values()))
        except KeyboardInterrupt:
            return "interrupted; not all files have been opened"
        except StopRun as stop:
            return str(stop)
        finally:
            pool.stop()
            progress.end()
    return None


def describe(item: Item, entry: dict[str, Any]) -> str:
    """An entry of a report in one line."""
    where = [item.name, *[entry[key] for key in ("object", "line") if entry[key] is not None]]
    return ": ".join([*where, entry["error"], entry["message"]])
