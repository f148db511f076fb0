"""Inputs and jobs for the tests of the batch, and how it is run: as a process, as its users do. Holds no test."""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

REPOSITORY = Path(__file__).resolve().parents[2]
BATCH = REPOSITORY / "blender_scripts" / "batch.py"
SECONDS = 300

sys.path.insert(0, str(BATCH.parent))

from bumpy_spheres import LINES, make_bumpy, write_stl  # noqa: E402  isort: skip


def write_ply(path, positions, triangles):
    path.parent.mkdir(parents=True, exist_ok=True)
    head = (
        f"ply\nformat ascii 1.0\nelement vertex {len(positions)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = [" ".join(map(repr, p)) for p in positions.tolist()] + [f"3 {a} {b} {c}" for a, b, c in triangles.tolist()]
    path.write_text(head + "\n".join(rows) + "\n")


def write_obj(path, positions, triangles):
    """With its axes as in the file once imported with forward y, up z."""
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in positions.tolist()]
    rows += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles.tolist()]
    path.write_text("\n".join(rows) + "\n")


WRITERS = {".ply": write_ply, ".obj": write_obj, ".stl": write_stl}


def write_broken(folder):
    """Ten files that cannot give what is asked for, each in a way of its own: name -> name of the error."""
    folder.mkdir(parents=True, exist_ok=True)
    positions, triangles = make_bumpy(8, 0)
    flat = positions[triangles[0]]
    good = folder / "good.ply"
    write_ply(good, positions, triangles)
    text = good.read_bytes()
    good.unlink()
    (folder / "empty.ply").write_bytes(b"")
    (folder / "words.ply").write_text("this is no mesh\n")
    (folder / "cut.ply").write_bytes(text[: len(text) // 2])
    (folder / "cut.stl").write_bytes(b"".ljust(80) + (1000).to_bytes(4, "little") + bytes(200))
    (folder / "zeros.obj").write_bytes(bytes(5000))
    (folder / "points.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    (folder / "words.blend").write_text("BLENDER is what it begins with, and that is all\n" * 20)
    (folder / "words.glb").write_bytes(b"glTF" + bytes(40))
    (folder / "words.usdc").write_bytes(b"PXR-USDC" + bytes(100))
    write_ply(folder / "far.ply", flat + 100, np.array([[0, 1, 2]]))
    return {
        "empty.ply": "EmptyFileError",
        "words.ply": "ImportFailedError",
        "cut.ply": "ImportFailedError",
        "cut.stl": "ImportFailedError",
        "zeros.obj": "ImportFailedError",
        "points.obj": ("NoObjectError", "ObjectError"),
        "words.blend": "ImportFailedError",
        "words.glb": "ImportFailedError",
        "words.usdc": "ImportFailedError",
        "far.ply": "PickError",
    }


def write_inputs(folder, count, sizes=(12, 16, 20)):
    """`count` good meshes in the three formats."""
    for k in range(count):
        suffix = list(WRITERS)[k % 3]
        WRITERS[suffix](folder / f"mesh{k:03d}{suffix}", *make_bumpy(sizes[k % len(sizes)], k))


def write_job(path, **values):
    """A job at `path`; what is not given is the usual."""
    job = {
        "inputs": ["in/*"],
        "import": {"forward": "y", "up": "z"},
        "search_radius": 0.5,
        "lines": LINES,
        "outputs": {"folder": "out", "formats": ["json", "csv", "npz", "blend"]},
        **values,
    }
    path.write_text(json.dumps({k: v for k, v in job.items() if v is not None}))
    return path


def command(*arguments):
    return [sys.executable, str(BATCH), *map(str, arguments)]


def run_batch(*arguments, **options):
    """The finished process of one run."""
    return subprocess.run(command(*arguments), capture_output=True, text=True, timeout=SECONDS, **options)


def run_maker(*arguments):
    """What `make_scenes.py` tells, one object a line."""
    maker = Path(__file__).with_name("make_scenes.py")
    done = subprocess.run(
        [sys.executable, str(maker), *map(str, arguments)], capture_output=True, text=True, timeout=SECONDS
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return [json.loads(line.removeprefix("RESULT ")) for line in done.stdout.splitlines() if line.startswith("RESULT ")]


def read_report(folder, name="report.jsonl"):
    return [json.loads(line) for line in (folder / name).read_text(encoding="utf-8").splitlines()]


def count_records(folder):
    """How many results there are under `folder`, also while a run is at work in it."""
    return sum("record.json" in files and ".part-" not in where for where, _, files in os.walk(folder))


def hash_tree(folder):
    """Each file under `folder`, but for what runs keep for themselves, and a checksum of its bytes."""
    found = {}
    for where, names, files in os.walk(folder):
        if ".batch" in names:
            names.remove(".batch")
        for name in files:
            path = Path(where, name)
            found[path.relative_to(folder).as_posix()] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found
