"""Measures how many files a minute a batch does, where the time goes, and what one large file takes: the tables of
docs/batch.md.

    python blender_scripts/measure_batch.py                     some minutes
    python blender_scripts/measure_batch.py --large 5000000     one file of so many triangles, with its memory

Makes bumpy spheres in a temporary folder and runs `batch.py` over them. Needs the bpy module. Not imported by anything.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from bumpy_spheres import LINES, make_bumpy, write_binary_ply, write_stl

BATCH = Path(__file__).with_name("batch.py")
# Triangles of a mesh -> how many such files.
SIZES = {2_000: 60, 20_000: 40, 270_000: 10}
FORMATS = {"JSON, CSV, NPZ": ["json", "csv", "npz"], "and .blend": ["json", "csv", "npz", "blend"]}
PARTS = ("opening", "lines", "writing", "reading")
WRITERS = {".ply": write_binary_ply, ".stl": write_stl}


@dataclass(frozen=True)
class Measured:
    """One run."""

    rate: float  # files a minute, between the first and the last to be done
    used: float  # processor seconds of all processes
    seconds: Counter  # by the part of the work, added up over the files
    memory: int  # bytes: the most that one of the processes had at a time; 0 where the system does not say


def write_mesh(path: Path, triangle_count: int, seed: int) -> None:
    """A bumpy sphere of about so many triangles, in the form that the name says."""
    WRITERS[path.suffix](path, *make_bumpy(round((triangle_count / 2) ** 0.5) + 1, seed))


def measure(folder: Path, inputs: str, formats: list[str], processes: int) -> Measured:
    """Run a job over `inputs`."""
    output = f"out-{len(list(folder.iterdir()))}"
    job = folder / f"{output}.json"
    axes = {"forward": "y", "up": "z"}
    values = {"inputs": [inputs], "import": axes, "search_radius": 0.5, "lines": LINES}
    job.write_text(json.dumps({**values, "outputs": {"folder": output, "formats": formats}}))
    command = [sys.executable, str(BATCH), str(job), "--jobs", str(processes), "--quiet"]
    before = os.times()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    memory = 0
    if hasattr(os, "wait4"):
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        memory = usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    if process.wait() != 0:
        raise SystemExit(f"{' '.join(command)} ended with {process.returncode}")
    after = os.times()
    used = sum(getattr(after, f"children_{kind}") - getattr(before, f"children_{kind}") for kind in ("user", "system"))
    journal = folder / output / ".batch" / "journal-1-of-1.jsonl"
    notes = [json.loads(line) for line in journal.read_text().splitlines()]
    times = sorted(note["time"] for note in notes)
    seconds: Counter = Counter()
    for note in notes:
        seconds.update(note["seconds"])
    # The first of each process pays for its start.
    span = times[-1] - times[processes - 1] if len(times) > processes else 1.0
    return Measured(60 * (len(times) - processes) / span, used, seconds, memory)


def tell_throughput(folder: Path) -> None:
    """The table of sizes."""
    print(
        "| triangles | outputs | 1 process | 2 processes | processor, ms a file | Blender's import | our lines |"
        " writing |"
    )
    print("|---|---|---|---|---|---|---|---|")
    (folder / "one").mkdir()
    for triangles, count in SIZES.items():
        (folder / str(triangles)).mkdir()
        for k in range(count):
            write_mesh(folder / str(triangles) / f"mesh{k:03d}.ply", triangles, k)
        write_mesh(folder / "one" / "mesh.ply", triangles, 0)
        for title, formats in FORMATS.items():
            one, two = (measure(folder, f"{triangles}/*.ply", formats, n) for n in (1, 2))
            used_for_start = measure(folder, "one/mesh.ply", formats, 1).used
            whole = sum(one.seconds.values())
            shares = [f"{100 * one.seconds[part] / whole:.0f} %" for part in PARTS[:3]]
            each = 1000 * (one.used - used_for_start) / (count - 1)
            cells = [f"{triangles:,}", title, f"{one.rate:.0f}", f"{two.rate:.0f}", f"{each:.0f}", *shares]
            print(f"| {' | '.join(cells)} |", flush=True)


def tell_large(folder: Path, triangles: int) -> None:
    """The table of one large file, in two forms."""
    print("| one file of | outputs | seconds | Blender's import | our lines | writing | memory, GB |")
    print("|---|---|---|---|---|---|---|")
    for suffix in WRITERS:
        path = folder / f"large{suffix}"
        write_mesh(path, triangles, 0)
        size = path.stat().st_size / 1e6
        for title, formats in FORMATS.items():
            made = measure(folder, path.name, formats, 1)
            parts = [f"{made.seconds[part]:.1f}" for part in PARTS[:3]]
            cells = [
                f"{triangles:,} triangles, {suffix} ({size:.0f} MB)",
                title,
                f"{sum(made.seconds.values()):.1f}",
                *parts,
            ]
            print(f"| {' | '.join([*cells, f'{made.memory / 1e9:.1f}'])} |", flush=True)
        path.unlink()


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description="Measures the batch: the tables of docs/batch.md.")
    parser.add_argument("--large", type=int, metavar="TRIANGLES", help="one file of so many triangles instead")
    options = parser.parse_args()
    print(f"Processors: {os.cpu_count()}; busy before the first run: {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as temporary:
        if options.large:
            tell_large(Path(temporary), options.large)
        else:
            tell_throughput(Path(temporary))


if __name__ == "__main__":
    main()
