"""Runs items on a Dask cluster that is there already: `pip install smooth-polylines[dask]`, on the nodes too.

The nodes see the job's folders and these scripts under the same paths. A node's Dask worker starts a Blender process
of its own and talks to it, so that a crash in Blender does not take the Dask worker with it; when a Dask worker or
a whole node dies, Dask gives its files to others. Knows neither reports nor resuming.
"""

import builtins
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .errors import JobError, StopRun
from .job_file import Job
from .outcome import make_failure
from .plan import Item

SCRIPTS = str(Path(__file__).resolve().parents[1])
CONNECT_SECONDS = 30


def run_item_on_node(scripts: str, setup: dict[str, Any], item_values: dict[str, Any]) -> dict[str, Any]:
    """What Dask calls on a node: finds these scripts there, and has one file done."""
    import sys  # the function travels alone: it has nothing of this module there

    if scripts not in sys.path:
        sys.path.insert(0, scripts)
    from batching import outcome, plan

    return outcome.process_on_node(setup, plan.Item(**item_values))


class Cluster:
    """The Dask cluster at `address`, as something that runs items."""

    def __init__(self, job: Job, address: str, blender: str | None, profile: str | None) -> None:
        try:
            import distributed
        except ImportError as error:
            raise JobError(
                f"--scheduler needs the package distributed ({error}); pip install 'smooth-polylines[dask]'"
            ) from error
        self._distributed = distributed
        try:
            self._client = distributed.Client(address, timeout=CONNECT_SECONDS)
        except (OSError, ValueError, TimeoutError) as error:
            raise JobError(f"--scheduler {address}: no Dask scheduler answers there ({error})") from error
        self._setup = {**job.setup, "blender": blender, "profile": profile}

    def start_first(self) -> dict[str, Any]:
        """Wait for a node; what is known of it."""
        try:
            self._client.wait_for_workers(1, timeout=CONNECT_SECONDS)
        except TimeoutError as error:
            raise JobError("the Dask scheduler has no workers; start some: dask worker ADDRESS --nthreads 1") from error
        return {}

    def run(self, items: list[Item]) -> Iterator[tuple[Item, dict[str, Any]]]:
        """Each item with its outcome, in the order in which they are done."""
        # As a function of no module that could be imported it travels whole: neither the nodes nor the scheduler need
        # to find these scripts before it runs.
        work = types.FunctionType(run_item_on_node.__code__, {"__builtins__": builtins}, run_item_on_node.__name__)
        work.__module__ = "__main__"
        futures = {self._client.submit(work, SCRIPTS, self._setup, vars(item), pure=False): item for item in items}
        for future in self._distributed.as_completed(list(futures)):
            item = futures.pop(future)
            try:
                outcome = future.result()
            except self._distributed.KilledWorker as error:
                outcome = make_failure(item, "WorkerDiedError", f"several Dask workers died on it ({error.task})")
            except self._distributed.scheduler.NoValidWorkerError as error:
                raise StopRun(f"the cluster has no worker for this ({error})") from error
            except Exception as error:
                if type(error).__name__ == "WorkerStartError":
                    raise StopRun(f"no more work can be done: {error}") from error
                outcome = make_failure(item, "InternalError", f"{type(error).__name__}: {error}")
            future.release()
            yield item, outcome

    def stop(self) -> None:
        """Take back what has not begun, and leave the cluster."""
        self._client.close()
