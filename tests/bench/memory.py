"""What a library keeps for a mesh: the growth of a fresh process that opens it. Holds no timing.

Run as a program by `bytes_a_triangle`, which is what others call. Linux only: it reads the process's resident pages.
"""

import gc
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

STATM = Path("/proc/self/statm")


def bytes_a_triangle(peer, rung):
    """[after opening, after a line across as well], bytes a triangle; None where the system does not tell."""
    if not STATM.exists():
        return None
    with tempfile.TemporaryDirectory() as folder:
        arrays = Path(folder) / "mesh.npz"
        np.savez(arrays, positions=rung.positions, triangles=rung.triangles, across=np.array(rung.across[0]))
        done = subprocess.run(
            [sys.executable, "-m", "bench.memory", peer.name, str(arrays)], check=True, capture_output=True, text=True
        )
    return [int(word) / len(rung.triangles) for word in done.stdout.split()]


def resident_bytes():
    gc.collect()
    return int(STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def measure(name, arrays):
    """Print what this process has grown by; a small mesh comes first, so that the library itself is loaded."""
    from bench.ladder import Rung, make_ball
    from bench.peers import ALL

    peer = next(p for p in ALL if p.name == name)
    small = Rung("small", *make_ball(2))
    warm = peer(small.positions, small.triangles)
    warm.path(warm.prepare(small, [0, 1]))
    with np.load(arrays) as loaded:
        rung = Rung("large", loaded["positions"], loaded["triangles"])
        picks = loaded["across"].tolist()
    before = resident_bytes()
    opened = peer(rung.positions, rung.triangles)
    after_opening = resident_bytes()
    line = opened.path(opened.prepare(rung, picks))
    after_line = resident_bytes()
    print(after_opening - before, after_line - before)
    del line


if __name__ == "__main__":
    measure(*sys.argv[1:])
