"""The command: a torus of ten million triangles is opened and lines are drawn across it, in a process of its own.

Prints what it took; ends with 1 if more than twice the arrays is held (while the mesh is opened, or after the lines),
or a promise is broken. Memory is the resident set of the process, less what it was with the arrays alone. Meshes of
less than 4.2 million triangles are kept for speed instead, and held to 110 bytes a triangle.
"""

import argparse
import resource
import sys
import time

import numpy as np

import smooth_polylines as sp

MOST_TIMES_THE_ARRAYS = 2
FEWEST_SPARING = (1 << 22) + 1
MOST_BYTES_A_TRIANGLE = 110


def make_bumpy_torus(triangles):
    """Positions (V, 3) float64 and triangles (F, 3) int32, without Python loops."""
    across = int(np.sqrt(triangles / 4))
    around = triangles // (2 * across)
    i, j = np.divmod(np.arange(around * across, dtype=np.int32), np.int32(across))
    a, b = 2 * np.pi * i / around, 2 * np.pi * j / across
    tube = 0.4 + 0.02 * np.sin(17 * a) * np.cos(11 * b)
    ring = 1 + tube * np.cos(b)
    positions = np.column_stack([ring * np.cos(a), ring * np.sin(a), tube * np.sin(b)])
    after, above = (i + 1) % around, (j + 1) % across
    p, q = i * across + j, after * across + j
    r, s = after * across + above, i * across + above
    return positions, np.concatenate([np.column_stack([p, q, r]), np.column_stack([p, r, s])]).astype(np.int32)


def resident():
    """Bytes of the process now (Linux), and the most it has had."""
    with open("/proc/self/statm", encoding="ascii") as file:
        now = int(file.read().split()[1]) * resource.getpagesize()
    return now, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def main():
    parser = argparse.ArgumentParser(prog="huge", description=__doc__)
    parser.add_argument("--triangles", type=int, default=10_000_000)
    wanted = parser.parse_args().triangles
    positions, triangles = make_bumpy_torus(wanted)
    arrays = positions.nbytes + triangles.nbytes
    before, peak_before = resident()
    began = time.perf_counter()
    mesh = sp.SurfaceMesh(positions, triangles)
    opened = time.perf_counter() - began
    kept, peak = resident()
    opening = peak - before
    count = len(triangles)
    print(f"{count:,} triangles, {len(positions):,} vertices: arrays of {arrays / 1e6:,.0f} MB")
    print(f"opened in {opened:.2f} s; kept {(kept - before) / 1e6:,.0f} MB = {(kept - before) / count:.1f} bytes a "
          f"triangle = {(kept - before) / arrays:.2f} times the arrays; at most {(peak - before) / arrays:.2f} times "
          f"while opening")  # fmt: skip
    ends = [0, (len(positions) // 2) + len(positions) // 7]
    for name in ("none", "linear", "geodesic", "fair"):
        began = time.perf_counter()
        line = mesh.polyline(ends, filter=name)
        seconds = time.perf_counter() - began
        assert line.on(positions).tobytes() == line.points.tobytes()
        told = f"{line.report.iterations} rounds, {line.report.stop_reason}"
        print(f"{name}: {seconds:.2f} s, {len(line.points):,} points, length {line.length:.6f} after "
              f"{line.report.start_length:.6f}, {told}")  # fmt: skip
    now, peak = resident()
    print(f"with the lines: {(now - before) / arrays:.2f} times the arrays, at most {(peak - before) / arrays:.2f}")
    if count < FEWEST_SPARING:
        is_small = kept - before <= MOST_BYTES_A_TRIANGLE * count
    else:
        is_small = max(opening, now - before) <= MOST_TIMES_THE_ARRAYS * arrays
    if peak_before > before * 1.05:
        print(f"(making the arrays themselves had taken {peak_before / 1e6:,.0f} MB)")
    sys.exit(0 if is_small else 1)


if __name__ == "__main__":
    main()
