"""What became of one file, and how a worker process is made to find it out: tried again when Blender crashed.

The same on one machine and on a cluster. Knows no Blender and no schedule.
"""

import os
import tempfile
import threading
from pathlib import Path
from typing import Any

from .plan import Item
from .store import remove_parts_of
from .worker_process import WorkerDied, WorkerProcess, find_worker_command

ADVICE = {
    "WorkerDiedError": "open the file in Blender to see whether it crashes there; with less memory in use, run again",
    "TimeLimitError": "raise limits.seconds, or make the mesh smaller; run again",
    "MissingFileError": "the file was there when the run was planned; run again when it is back",
    "EmptyFileError": "write or copy the file again",
    "UnreadableFileError": "see to it that this user may read the file",
    "NameNotUnicodeError": "rename the file to a name that is UTF-8",
    "NewerBlenderError": "run it with that Blender (--blender PATH), or save the file with an older one",
    "ImportFailedError": "open the file in Blender to see what is wrong with it, and export it again",
    "NoObjectError": "see the objects that the file has in the message; change the patterns of the job",
    "PickError": "correct the pick in the job, or the mark on the mesh",
    "GuideError": "correct the name of the guide in the job, or draw it nearer to the surface",
    "NoUVMapError": "unwrap the mesh, or leave out svg",
    "DiskFullError": "make room, then start the same command again: it goes on where it was",
    "InternalError": "this is a defect of Smooth Polylines: please report it with the worker's log",
}
# What another run may well not meet again.
TRANSIENT = {"WorkerDiedError", "TimeLimitError", "MissingFileError", "UnreadableFileError", "DiskFullError"}


def make_entry(
    item_name: str, error: str, message: str, *, object_name: str | None = None, line: str | None = None
) -> dict[str, Any]:
    """An entry of the report on something that failed."""
    said, _, advice = message.partition("; ")
    return {
        "file": item_name,
        "object": object_name,
        "line": line,
        "status": "failed",
        "error": error,
        "message": said,
        "advice": advice or ADVICE.get(error, "see the message"),
    }


def make_failure(item: Item, error: str, message: str) -> dict[str, Any]:
    """The outcome of a file of which nothing could be made."""
    return {
        "entries": [make_entry(item.name, error, message)],
        "saved": False,
        "transient": error in TRANSIENT,
        "seconds": {},
    }


def process_item(
    worker: WorkerProcess, item: Item, limits: dict[str, Any], *, is_check: bool = False
) -> dict[str, Any]:
    """Have `worker` do one file, or only check it; its outcome, also when Blender crashes on it or takes too long."""
    if worker.files >= limits["files_a_process"]:
        worker.close()  # a fresh Blender now and then: what one leaks does not add up over nights
    request = {"input": item.input, "name": item.name, "result": item.result, "is_check": is_check}
    answer: dict[str, Any] | WorkerDied
    for _ in range(limits["attempts"]):
        answer = worker.ask(request, limits["seconds"])
        if not isinstance(answer, WorkerDied):
            return answer
        if not is_check:
            remove_parts_of(worker.output, item.result, worker.token)
        if answer.error == "TimeLimitError":
            break
    return make_failure(item, answer.error, answer.message)


_workers = threading.local()


def process_on_node(setup: dict[str, Any], item: Item) -> dict[str, Any]:
    """`process_item` on a machine of a cluster: each thread there keeps a worker process of its own between files."""
    worker = getattr(_workers, "worker", None)
    if worker is None or _workers.setup != setup:
        if worker is not None:
            worker.close()
        log = Path(tempfile.gettempdir()) / f"smooth-polylines-batch-{os.getpid()}-{threading.get_ident()}.log"
        command = find_worker_command(setup["blender"])
        _workers.worker = worker = WorkerProcess(command, setup, log)
        _workers.setup = setup
    outcome = process_item(worker, item, worker.limits)
    return {**outcome, "process": worker.process_id}
