"""One run: what is to be done still, having it done, keeping account of it, and the report.

Whatever does the work, this machine's processes or a cluster, is given. Holds no Blender and parses no arguments.
"""

import shutil
import time
from dataclasses import dataclass, field
from typing import Any, Protocol

from . import report, store
from .errors import StopRun
from .job_file import Job
from .plan import Item, Shard
from .progress import Progress, tell_duration


class Workforce(Protocol):
    """What does the work."""

    def start_first(self) -> dict[str, Any]:
        """Make sure that work can be done."""

    def run(self, items: list[Item]) -> Any:
        """Pairs of item and outcome."""

    def stop(self) -> None:
        """End the work at once."""


@dataclass
class State:
    """What is known of the items, and which are to be done."""

    items: list[Item]
    notes: dict[str, dict[str, Any]] = field(
        default_factory=dict
    )  # by result; of items that are done or failed for good
    to_do: list[Item] = field(default_factory=list)


def find_state(job: Job, items: list[Item], *, retry: bool = False) -> State:
    """Which items were done already, by this job on these very inputs, and how.

    retry : items with failures are to be done again, whatever the failure was
    """
    journals = store.read_journals(job.output)
    state = State(items)
    for item in items:
        note = recall_item(job, item, journals.get(item.result))
        failed = note is not None and report.judge_file(note) != "done"
        if note is None or (failed and (retry or note["transient"])):
            state.to_do.append(item)
        else:
            state.notes[item.result] = note
    return state


def recall_item(job: Job, item: Item, note: dict[str, Any] | None) -> dict[str, Any] | None:
    """What an earlier run says of the item; None when it is to be done."""
    stamp = store.stamp_input(item.input)
    has_result = (store.find_result(job.output, item.result) / store.RECORD_NAME).is_file()
    if note is not None and note["fingerprint"] == job.fingerprint and note["stamp"] == stamp is not None:
        return note if has_result or not note["saved"] else None
    if not has_result or stamp is None:
        return None
    # Results without a word in the journals, as after a crash between the two: the input's bytes decide.
    record = store.read_record(job.output, item.result)
    if record is None or record["fingerprint"] != job.fingerprint or record["input"]["bytes"] != stamp[0]:
        return None
    try:
        size, digest = store.hash_file(item.input)
    except OSError:
        return None
    if (size, digest) != (record["input"]["bytes"], record["input"]["sha256"]):
        return None
    return make_note(job, item, stamp, {"entries": record["entries"], "saved": True, "transient": False})


def make_note(job: Job, item: Item, stamp: list[int] | None, outcome: dict[str, Any]) -> dict[str, Any]:
    """What the journal keeps of an item."""
    return {
        "result": item.result,
        "fingerprint": job.fingerprint,
        "stamp": stamp,
        **{key: outcome[key] for key in ("entries", "saved", "transient")},
        "seconds": outcome.get("seconds", {}),
    }


def run_items(job: Job, state: State, workforce: Workforce, shard: Shard, progress: Progress) -> str | None:
    """Do what is to be done and write the report; None, or why it ended early. Ctrl-C ends it early too."""
    journal = store.Journal(job.output, f"{shard.number}-of-{shard.count}")
    fresh = []
    reason = None
    begin = time.monotonic()
    try:
        stamps = {item.result: store.stamp_input(item.input) for item in state.to_do}
        for item, outcome in workforce.run(state.to_do):
            note = make_note(job, item, stamps[item.result], outcome)
            if not outcome["saved"]:
                remove_stale_result(job, item)
            journal.add(note)
            state.notes[item.result] = note
            fresh.append(note)
            progress.add(item.name, note["entries"], sum(note["seconds"].values()))
            if outcome.get("stop"):
                raise StopRun(outcome["stop"])
    except KeyboardInterrupt:
        reason = "interrupted; start the same command again to go on"
    except StopRun as stop:
        reason = str(stop)
    except OSError as error:
        if error.errno not in store.FULL_ERRORS:
            raise
        reason = f"{job.output}: {error.strerror}; make room, then start the same command again to go on"
    finally:
        workforce.stop()
        journal.close()
        progress.end()
    if fresh:
        tell_times(progress, fresh, time.monotonic() - begin)
    return reason


def remove_stale_result(job: Job, item: Item) -> None:
    """A file that failed must not seem done by what an older job or input left."""
    if store.read_record(job.output, item.result) is not None:
        shutil.rmtree(store.find_result(job.output, item.result), ignore_errors=True)


def tell_times(progress: Progress, fresh: list[dict[str, Any]], seconds: float) -> None:
    """How fast the run was, and where the workers' time went."""
    total = report.sum_seconds(fresh)
    whole = sum(total.values()) or 1.0
    parts = ", ".join(f"{name} {100 * part / whole:.0f} %" for name, part in sorted(total.items(), key=lambda p: -p[1]))
    rate = 60 * len(fresh) / max(seconds, 1e-9)
    progress.say(
        f"{len(fresh)} files in {tell_duration(seconds)}: {rate:.0f} files a minute" + (f" ({parts})" if parts else "")
    )
