"""Runs items on this machine, in a number of worker processes at once. Knows neither reports nor resuming."""

import queue
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .errors import StopRun
from .job_file import Job
from .outcome import make_failure, process_item
from .plan import Item
from .worker_process import WorkerProcess, WorkerStartError


class LocalPool:
    """As many workers as asked for, each a process with one file's mesh in it at a time."""

    def __init__(
        self,
        job: Job,
        command: list[str],
        count: int,
        label: str,
        profile: str | None,
        *,
        logs: Path,
        is_check: bool = False,
    ) -> None:
        """`logs`: the folder for what Blender prints; `is_check`: files are only looked at."""
        self._limits = job.values["limits"]
        self._is_check = is_check
        self._workers = [
            WorkerProcess(command, {**job.setup, "profile": profile}, logs / f"worker-{label}-{k + 1}.log")
            for k in range(count)
        ]
        self._is_stopped = threading.Event()

    def start_first(self) -> dict[str, Any]:
        """Start one worker: what is wrong with all is known before anything is done. What it tells of itself."""
        self._workers[0].start()
        return self._workers[0].hello

    def run(self, items: list[Item]) -> Iterator[tuple[Item, dict[str, Any]]]:
        """Each item with its outcome, in the order in which they are done. Raises StopRun when no worker can be had."""
        waiting: queue.SimpleQueue[Item] = queue.SimpleQueue()
        for item in items:
            waiting.put(item)
        done: queue.SimpleQueue[tuple[Item, dict[str, Any]] | Exception | None] = queue.SimpleQueue()
        workers = self._workers[: max(1, len(items))]
        for worker in workers:
            threading.Thread(target=self._serve, args=(worker, waiting, done), daemon=True).start()
        serving = len(workers)
        while serving:
            # With a limit, because a wait without one does not see Ctrl-C on every system.
            try:
                result = done.get(timeout=1.0)
            except queue.Empty:
                continue
            if result is None:
                serving -= 1
            elif isinstance(result, Exception):
                raise StopRun(f"no more work can be done: {result}")
            else:
                yield result

    def _serve(self, worker: WorkerProcess, waiting: Any, done: Any) -> None:
        """Give one worker items until there are none."""
        try:
            while not self._is_stopped.is_set():
                try:
                    item = waiting.get_nowait()
                except queue.Empty:
                    break
                try:
                    outcome = process_item(worker, item, self._limits, is_check=self._is_check)
                except WorkerStartError as error:
                    done.put(error)
                    break
                except Exception as error:  # a defect in here must not lose the run
                    outcome = make_failure(item, "InternalError", f"{type(error).__name__}: {error}")
                if not self._is_stopped.is_set():
                    done.put((item, outcome))
            if not self._is_stopped.is_set():
                worker.close()
        finally:
            done.put(None)

    def stop(self) -> None:
        """End all workers at once; what they were at is not lost, but done again by the next run."""
        self._is_stopped.set()
        for worker in self._workers:
            worker.stop()
