"""Which files a run works on, under which names their results go, and which of them are this shard's. Opens no file."""

import glob
import os
import unicodedata
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from .errors import JobError
from .job_file import Job

SUFFIXES = (".blend", ".obj", ".ply", ".stl", ".fbx", ".gltf", ".glb", ".usd", ".usda", ".usdc", ".usdz")


@dataclass(frozen=True)
class Item:
    """One input file and the folder that its results go to."""

    index: int  # in the whole plan
    input: str  # absolute path
    name: str  # as the report names it: with /, relative to the job's folder where it lies in there
    result: str  # with /, relative to the output folder


@dataclass(frozen=True)
class Shard:
    """Every n-th file, from the i-th on, i from 1."""

    number: int
    count: int

    @classmethod
    def parse(cls, text: str) -> "Shard":
        """From "2/8"; JobError otherwise."""
        number, slash, count = text.partition("/")
        if not (slash and number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
            raise JobError(f"--shard {text}: expected i/n with i from 1 to n, as 2/8")
        return cls(int(number), int(count))

    def choose(self, items: list[Item]) -> list[Item]:
        """The items of this shard; neighbours, which are often of a size, go to different shards."""
        return items[self.number - 1 :: self.count]

    def is_apart_from(self, other: "Shard") -> bool:
        """Whether the two can never have an item in common."""
        return self.count == other.count and self.number != other.number


WHOLE = Shard(1, 1)


def make_plan(job: Job, open_file: str | None) -> list[Item]:
    """All items of the job in order of their names; JobError when there are none, or some exclude each other.

    open_file : what Blender was started with, for a job that names no inputs
    """
    if job.inputs is None:
        if not open_file:
            raise JobError(
                f'{job.path.name}: "inputs" is missing; name files, or start Blender with one: blender -b FILE -P ...'
            )
        found = {os.path.abspath(open_file): os.path.dirname(os.path.abspath(open_file))}
    else:
        found = find_inputs(job)
    items = []
    for path, root in found.items():
        name = name_input(path, job.folder, Path(root))
        items.append((name, path))
    items.sort()
    plan = [Item(index, path, show_path(path, job.folder), name) for index, (name, path) in enumerate(items)]
    refuse_collisions(plan)
    return plan


def find_inputs(job: Job) -> dict[str, str]:
    """Absolute path of each input -> the folder that its pattern starts from."""
    found: dict[str, str] = {}
    faults = []
    output = os.path.join(os.path.abspath(job.output), "")
    for index, pattern in enumerate(job.inputs or []):
        place = f"{job.path.name}: inputs[{index}]"
        path = os.path.abspath(os.path.join(job.folder, pattern))
        if os.path.isfile(path):
            if not path.lower().endswith(SUFFIXES):
                faults.append(f"{place}: {pattern} is none of the files that Blender imports ({' '.join(SUFFIXES)})")
            found.setdefault(path, os.path.dirname(path))
            continue
        if not glob.has_magic(pattern):
            faults.append(f"{place}: there is no file {pattern}" + (" (it is a folder)" if os.path.isdir(path) else ""))
            continue
        root = find_root(path)
        matches = sorted(
            match
            for match in map(os.path.abspath, glob.glob(path, recursive=True))
            if os.path.isfile(match) and match.lower().endswith(SUFFIXES) and not match.startswith(output)
        )
        if not matches:
            faults.append(f"{place}: no file of a kind that Blender imports matches {pattern}")
        for match in matches:
            found.setdefault(match, root)
    if faults:
        raise JobError(*faults)
    return found


def find_root(pattern: str) -> str:
    """The folder in which a pattern begins to vary."""
    folder = pattern
    while glob.has_magic(folder):
        folder = os.path.dirname(folder)
    return folder


def name_input(path: str, job_folder: Path, root: Path) -> str:
    """Where the results go: the input's path from the job's folder, or from its pattern's where it lies elsewhere."""
    for folder in (job_folder, root):
        try:
            return PurePosixPath(*Path(path).relative_to(folder).parts).as_posix()
        except ValueError:
            continue
    return Path(path).name


def show_path(path: str, job_folder: Path) -> str:
    """A path for the report: the same on every system where the job's folder is the same."""
    try:
        shown = Path(path).relative_to(job_folder).as_posix()
    except ValueError:
        shown = Path(path).as_posix()
    # Names that are no Unicode, as some systems allow, are shown with escapes.
    return shown.encode("utf-8", "backslashreplace").decode("utf-8")


def refuse_collisions(plan: list[Item]) -> None:
    """JobError where two results would share a folder, here or on a system that ignores case and accents' spelling."""
    seen: dict[str, Item] = {}
    for item in plan:
        key = unicodedata.normalize("NFC", item.result).casefold()
        other = seen.setdefault(key, item)
        if other is not item:
            raise JobError(
                f"inputs: {other.name} and {item.name} would share the results' folder {item.result}; "
                "put the job beside them, or make two jobs"
            )
