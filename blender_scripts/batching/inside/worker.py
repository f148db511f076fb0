"""Started by a run as a process of its own, in Blender: takes files from its input, answers on its output.

Everything that Blender prints goes to the log that the standard error is. Ends when its input does, at once: a run that
was killed leaves no worker behind.
"""

import json
import os
import queue
import sys
import tempfile
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from batching.plan import Item
from batching.worker_process import MARK


def main() -> int:
    """Answer until the input ends; the exit code."""
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)
    requests: queue.SimpleQueue[dict] = queue.SimpleQueue()
    threading.Thread(target=read_requests, args=(requests,), daemon=True).start()

    def answer(message: dict) -> None:
        # One write: a line is there whole or not at all. On a line of its own, whatever Blender printed before.
        answers.write(b"\n" + MARK + json.dumps(message).encode("ascii") + b"\n")

    start = requests.get()
    if "bpy" not in sys.modules and start["profile"] is None:
        # Before bpy is imported: a user's own Blender settings and add-ons have no part in it.
        profile = tempfile.TemporaryDirectory(prefix="smooth-polylines-batch-")
        os.environ["BLENDER_USER_RESOURCES"] = profile.name
    try:
        import bpy
    except ImportError as error:
        answer(
            {"refused": f"found no Blender in {sys.executable} ({error}); pip install bpy, or give --blender PROGRAM"}
        )
        return 1

    from batching.inside import addon_door, process_file

    try:
        package = addon_door.load_addon(is_installed=bool(bpy.app.binary_path) or start["profile"] is not None)
    except addon_door.NoAddonError as error:
        answer({"refused": str(error)})
        return 1
    processor = process_file.FileProcessor(package, start)
    answer({"blender": bpy.app.version_string, "process": os.getpid()})
    while True:
        request = requests.get()
        print(f"--- {request['name']}".encode("utf-8", "backslashreplace").decode("utf-8"), flush=True)
        is_check = request.pop("is_check")
        answer(processor.process(Item(index=0, **request), is_check=is_check))


def read_requests(requests: "queue.SimpleQueue[dict]") -> None:
    """Take the run's lines; at the end of them nobody wants an answer any more."""
    for line in sys.stdin.buffer:
        requests.put(json.loads(line))
    os._exit(0)


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
