"""The folder of results on disk: written whole or not at all, found again, and what a run keeps beside them.

A file's results are one folder, made under another name and renamed when all of it is on the disk. Beside them `.batch`
holds the journals of runs, which say what was done and what failed. No Blender in here: workers and runs both use it.
"""

import contextlib
import errno
import hashlib
import json
import os
import shutil
import time
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

RECORD_NAME = "record.json"
STATE_FOLDER = ".batch"
PART_MARK = ".part-"
# What ends a run: nothing that comes after would fare better.
FULL_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)
HASH_CHUNK = 1 << 20


def find_result(output: Path, result: str) -> Path:
    """The folder of an item's results; it need not exist."""
    return output.joinpath(*result.split("/"))


@contextlib.contextmanager
def open_part(output: Path, result: str, token: str) -> Iterator[Path]:
    """A new folder to write an item's results into; renamed to its own name at the end, removed on a failure.

    token : of the worker, so that what it leaves half-made when it dies can be told from the work of others

    Whoever looks sees all results or none, also after a power cut: all is on the disk before the name changes.
    """
    target = find_result(output, result)
    target.parent.mkdir(parents=True, exist_ok=True)
    part = target.parent / f"{PART_MARK}{token}-{uuid.uuid4().hex[:8]}"
    part.mkdir()
    try:
        yield part
        for path in sorted(part.iterdir()):
            flush_to_disk(path)
        flush_to_disk(part)
        replace_folder(part, target)
        flush_to_disk(target.parent)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise


def replace_folder(part: Path, target: Path) -> None:
    """Rename `part` to `target`; older results of that name make way."""
    if target.is_dir():
        old = part.with_name(part.name + "-old")
        target.rename(old)
        part.rename(target)
        shutil.rmtree(old, ignore_errors=True)
    else:
        part.rename(target)


def remove_parts(output: Path) -> int:
    """Remove what killed runs left half-made; how many there were. Only where no other run is at work."""
    count = 0
    for folder, names, _ in os.walk(output):
        for name in [n for n in names if n.startswith(PART_MARK)]:
            shutil.rmtree(Path(folder) / name, ignore_errors=True)
            names.remove(name)
            count += 1
    return count


def remove_parts_of(output: Path, result: str, token: str) -> None:
    """Remove what a worker that died has left half-made of one item."""
    for part in find_result(output, result).parent.glob(f"{PART_MARK}{token}-*"):
        shutil.rmtree(part, ignore_errors=True)


def flush_to_disk(path: Path) -> None:
    """Wait until the file or folder is on the disk, where the system can tell."""
    if path.is_dir() and os.name == "nt":
        return
    # Windows flushes only what is open for writing.
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() or os.name != "nt" else os.O_RDWR)
    try:
        with contextlib.suppress(OSError if path.is_dir() else ()):
            os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_whole(path: Path, data: bytes) -> None:
    """Write a file of a run (report, summary) beside its target, then rename it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f"{PART_MARK}{uuid.uuid4().hex[:12]}-{path.name}")
    try:
        part.write_bytes(data)
        flush_to_disk(part)
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def dump_json(value: Any) -> bytes:
    """One line of JSON, always the same for the same value; what is no Unicode is escaped."""
    text = json.dumps(value, ensure_ascii=False, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return text.encode("utf-8", "backslashreplace") + b"\n"


def hash_file(path: str) -> tuple[int, str]:
    """Bytes and SHA-256 of a file."""
    digest, size = hashlib.sha256(), 0
    with open(path, "rb") as file:
        while chunk := file.read(HASH_CHUNK):
            digest.update(chunk)
            size += len(chunk)
    return size, digest.hexdigest()


def stamp_input(path: str) -> list[int] | None:
    """Size and time of change of an input: equal as long as nobody has written it; None where it cannot be seen."""
    try:
        status = os.stat(path)
    except OSError:
        return None
    return [status.st_size, status.st_mtime_ns]


def read_record(output: Path, result: str) -> dict[str, Any] | None:
    """The record in an item's results; None where there are none that are whole."""
    try:
        return json.loads((find_result(output, result) / RECORD_NAME).read_bytes())
    except (OSError, ValueError):
        return None


class Journal:
    """What a run has found out about each item, one line of JSON each, on the disk at once."""

    def __init__(self, output: Path, name: str) -> None:
        self.path = output / STATE_FOLDER / f"journal-{name}.jsonl"
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._file = open(self.path, "ab")
        if self._file.tell() > 0:
            # A line that a crash cut off must not take the next one with it.
            self._file.write(b"\n")

    def add(self, note: dict[str, Any]) -> None:
        """Append one note."""
        self._file.write(dump_json({**note, "time": round(time.time(), 3)}))
        self._file.flush()
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Release the file."""
        self._file.close()


def read_journals(output: Path) -> dict[str, dict[str, Any]]:
    """The newest note on each result, from the journals of all runs into this folder; what is cut off counts not."""
    notes: dict[str, dict[str, Any]] = {}
    for path in sorted((output / STATE_FOLDER).glob("journal-*.jsonl")):
        with contextlib.suppress(OSError):
            for line in path.read_bytes().splitlines():
                with contextlib.suppress(ValueError, KeyError, TypeError):
                    note = json.loads(line)
                    if note["time"] >= notes.get(note["result"], note)["time"]:
                        notes[note["result"]] = note
    return notes
