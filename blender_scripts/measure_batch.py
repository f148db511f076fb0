"""Measures how many files a minute a batch does, and where the time goes: the table in docs/batch.md.

    python blender_scripts/measure_batch.py

Makes bumpy spheres of several sizes as binary PLY in a temporary folder and runs `batch.py` over them, in one worker
process and in two. Needs the bpy module. Not imported by anything.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

BATCH = Path(__file__).with_name("batch.py")
# Triangles of a mesh -> how many such files.
SIZES = {2_000: 60, 20_000: 40, 270_000: 10}
LINES = [
    {
        "name": "across",
        "filter": "geodesic",
        "picks": [{"point": [-1, 0, 0]}, {"point": [0, 0, 1]}, {"point": [1, 0, 0]}],
    },
    {
        "name": "ring",
        "filter": "fair",
        "closed": True,
        "pinned": "all",
        "picks": [{"point": [1, 0, 0]}, {"point": [0, 1, 0]}, {"point": [-1, -0.2, 0]}, {"point": [0, -1, 0.1]}],
    },
]
FORMATS = {"JSON, CSV, NPZ": ["json", "csv", "npz"], "and .blend": ["json", "csv", "npz", "blend"]}
PARTS = ("opening", "lines", "writing", "reading")


def write_mesh(path: Path, triangle_count: int, seed: int) -> None:
    """A closed bumpy sphere of about so many triangles, as binary PLY."""
    size = round((triangle_count / 2) ** 0.5)
    theta = np.linspace(0, np.pi, size + 1)
    phi = 2 * np.pi * np.arange(size) / size
    t, p = np.meshgrid(theta, phi, indexing="ij")
    radius = 1 + 0.05 * np.sin(3 * t + seed) * np.cos((2 + seed % 3) * p) * np.sin(t)
    rows = np.stack([radius * np.sin(t) * np.cos(p), radius * np.sin(t) * np.sin(p), radius * np.cos(t)], axis=-1)
    i, j = np.meshgrid(np.arange(size), np.arange(size), indexing="ij")
    corner = [(i + a) * size + (j + b) % size for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    triangles = np.stack(
        [np.stack([corner[0], corner[1], corner[2]], -1), np.stack([corner[0], corner[2], corner[3]], -1)]
    )
    table = np.zeros(triangles.size // 3, dtype=[("count", "u1"), ("corners", "<i4", 3)])
    table["count"], table["corners"] = 3, triangles.reshape(-1, 3)
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {rows.size // 3}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {len(table)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(head.encode() + rows.astype("<f4").tobytes() + table.tobytes())


def measure(folder: Path, name: str, formats: list[str], processes: int) -> tuple[float, float, Counter]:
    """Files a minute between the first and the last to be done, all processor seconds, and the seconds of each part."""
    output = f"out-{name}-{len(list(folder.iterdir()))}"
    job = folder / f"{output}.json"
    values = {"inputs": [f"{name}/*.ply"], "search_radius": 0.5, "lines": LINES}
    job.write_text(json.dumps({**values, "outputs": {"folder": output, "formats": formats}}))
    command = [sys.executable, str(BATCH), str(job), "--jobs", str(processes), "--quiet"]
    before = os.times()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
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
    return 60 * (len(times) - processes) / span, used, seconds


def main() -> None:
    """Print the table."""
    print(f"Processors: {os.cpu_count()}; busy before the first run: {os.getloadavg()[0]:.1f}")
    print(
        "| triangles | outputs | 1 process | 2 processes | processor, ms a file | Blender's import | lines | writing |"
    )
    print("|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for triangles, count in SIZES.items():
            (folder / str(triangles)).mkdir()
            for k in range(count):
                write_mesh(folder / str(triangles) / f"mesh{k:03d}.ply", triangles, k)
            (folder / "one").mkdir(exist_ok=True)
            write_mesh(folder / "one" / "mesh.ply", triangles, 0)
            for title, formats in FORMATS.items():
                rates = {n: measure(folder, str(triangles), formats, n) for n in (1, 2)}
                used, seconds = rates[1][1:]
                used_for_start = measure(folder, "one", formats, 1)[1]
                whole = sum(seconds.values())
                shares = [f"{100 * seconds[part] / whole:.0f} %" for part in PARTS[:3]]
                each = 1000 * (used - used_for_start) / (count - 1)
                cells = [f"{triangles:,}", title, f"{rates[1][0]:.0f}", f"{rates[2][0]:.0f}", f"{each:.0f}", *shares]
                print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
