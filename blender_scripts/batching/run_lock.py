"""Keeps two runs from working on the same files of one output folder at once; shards of one division may.

A run holds a locked file, which the system releases when the run ends in whatever way. Knows no jobs.
"""

import contextlib
import json
import os
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO

from .errors import JobError
from .plan import Shard
from .store import STATE_FOLDER

if os.name == "nt":
    import msvcrt

    def _lock(file: IO[bytes]) -> None:
        file.seek(1 << 20)  # beyond what is read by others
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _lock(file: IO[bytes]) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextlib.contextmanager
def hold_run_lock(output: Path, shard: Shard) -> Iterator[None]:
    """Hold the folder for this shard; JobError where another run works on the same files."""
    folder = output / STATE_FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    with _wait_for(folder / "starting.lock"):
        for other, holder in list_runs(output):
            if not shard.is_apart_from(other):
                raise JobError(
                    f"another run ({holder}) is writing into {output}; wait for it, stop it, or choose another folder"
                )
        own = open(folder / name_lock(shard), "a+b")
        # On a file system without locks the last to come wins; each result is whole all the same.
        with contextlib.suppress(OSError):
            _lock(own)
        own.truncate(0)
        own.write(json.dumps({"host": socket.gethostname(), "process": os.getpid()}).encode())
        own.flush()
    try:
        yield
    finally:
        own.close()


def name_lock(shard: Shard) -> str:
    """File name of a shard's lock."""
    return f"run-{shard.number}-of-{shard.count}.lock"


def list_runs(output: Path) -> list[tuple[Shard, str]]:
    """The runs that are at work in the folder, each with who it is."""
    runs = []
    for path in sorted((output / STATE_FOLDER).glob("run-*-of-*.lock")):
        number, _, count = path.stem.removeprefix("run-").partition("-of-")
        holder = find_holder(path)
        if holder is not None:
            runs.append((Shard(int(number), int(count)), holder))
    return runs


def is_alone(output: Path, shard: Shard) -> bool:
    """Whether no other run is at work beside the one that holds this shard."""
    return all(other == shard for other, _ in list_runs(output))


def find_holder(path: Path) -> str | None:
    """Who holds the lock file, in words; None when nobody does."""
    try:
        with open(path, "r+b") as file:
            _lock(file)
        return None
    except FileNotFoundError:
        return None
    except OSError:
        try:
            told = json.loads(path.read_bytes())
            return f"process {told['process']} on {told['host']}"
        except (OSError, ValueError, KeyError):
            return "a process that does not tell"


@contextlib.contextmanager
def _wait_for(path: Path, seconds: float = 10.0) -> Iterator[None]:
    """Hold a lock for the moment in which a run looks for others; goes on without where it cannot be had."""
    with open(path, "a+b") as file:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                _lock(file)
                break
            except OSError:
                time.sleep(0.05)
        yield
