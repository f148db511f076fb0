"""Measures the cubic's knots and supports on the shared test meshes and prints the table of docs/filters.md.

    .venv/bin/python blender_scripts/measure_knots.py [--threshold T]... [MESH ...]

Needs the wheel, numpy and the meshes, no Blender. Each figure is a mean over the lines below; wall time is left out on
purpose, moves stand for it. Not imported by the add-on or the tests.
"""

import argparse
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

REPOSITORY = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(REPOSITORY / "tests"))

import meshes  # noqa: E402
import smooth_polylines as sp  # noqa: E402

MESHES = (
    "cow.off spot.obj fertility.off fandisk.obj shark_holes.off camel.off thingi_79741.off mountain.obj bunny00.off "
    "igea.ply"
).split()
THRESHOLDS = (1e-2, 1e-3, 1e-4)
KNOTS = ("uniform", "centripetal", "chordal")
SUPPORTS = (2, 3, 4)
SETTLED = ("converged", "converged_at_vertices")
# Half the width of the slab that a ring of picks is taken from, as a part of the mesh's extent across it.
SLAB = 0.02
RING_PICKS = 12


def choose_pick_sets(mesh):
    """Picks and whether they are closed: two random open lines and one random closed, one designed open, two rings."""
    rng = np.random.default_rng(3)
    count = len(mesh.triangles)
    random = [[int(i) for i in rng.choice(count, size, replace=False)] for size in (2, 4, 5)]
    yield random[0], False
    yield random[1], False
    yield random[2], True
    centres = mesh.positions[mesh.triangles].mean(axis=1)
    order = np.argsort(np.ptp(centres, axis=0))
    along = centres[:, order[2]]
    # From one end of the mesh to the other, over what is highest half way.
    middle = np.flatnonzero(np.abs(along - np.median(along)) <= SLAB * np.ptp(along))
    yield [int(along.argmin()), int(middle[centres[middle, order[0]].argmax()]), int(along.argmax())], False
    for across in order[1:]:
        yield choose_ring(centres, int(across)), True


def choose_ring(centres, across):
    """Triangles round the middle of the mesh, each the outermost of its direction in a slab across one axis."""
    offset = centres - (centres.max(axis=0) + centres.min(axis=0)) / 2
    near = np.flatnonzero(np.abs(offset[:, across]) <= SLAB * np.ptp(offset[:, across]))
    u, v = (offset[near, k] for k in range(3) if k != across)
    sectors = ((np.arctan2(v, u) / (2 * np.pi) + 0.5) * RING_PICKS).astype(int) % RING_PICKS
    radius = np.hypot(u, v)
    return [
        int(near[rows[radius[rows].argmax()]])
        for rows in (np.flatnonzero(sectors == s) for s in range(RING_PICKS))
        if len(rows)
    ]


def angle_between(a, b):
    """The angle of two vectors, exact also near 0 and pi."""
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), np.dot(a, b)))


class TurningMeter:
    """Knows one mesh and tells how much a line on it turns, on the surface."""

    def __init__(self, mesh):
        self.positions, self.triangles = mesh.positions, mesh.triangles
        self.around = defaultdict(list)
        for t, corners in enumerate(mesh.triangles.tolist()):
            for v in corners:
                self.around[v].append(t)

    def measure(self, line):
        """Sum of the turns at the line's points, in radians: across an edge in the unfolded triangles; at a mesh vertex
        half the difference of the angles on both sides.
        """
        points, weights, segments = line.points, line.barycentric, line.segment_triangles
        count = len(points)
        total = 0.0
        for i in range(count) if line.closed else range(1, count - 1):
            back, ahead = points[i - 1] - points[i], points[(i + 1) % count] - points[i]
            before, after = int(segments[i - 1]), int(segments[i % len(segments)])
            at_vertex = np.flatnonzero(weights[i] == 1.0)
            if len(at_vertex):
                vertex = int(self.triangles[line.triangles[i]][at_vertex[0]])
                total += self.turn_at_vertex(vertex, back, before, ahead, after)
            elif before == after:
                total += np.pi - angle_between(back, ahead)
            else:
                shared = [v for v in self.triangles[before] if v in self.triangles[after]]
                if len(shared) == 2:
                    edge = self.positions[shared[1]] - self.positions[shared[0]]
                    total += abs(np.pi - angle_between(edge, back) - angle_between(edge, ahead))
        return total

    def turn_at_vertex(self, vertex, back, before, ahead, after):
        """Half the difference of the angles on both sides; on a boundary what the one side lacks to pi."""
        sides = [self.walk(vertex, back, before, ahead, after, way) for way in (0, 1)]
        known = [side for side in sides if side is not None]
        if len(known) == 2:
            return abs(known[0] - known[1]) / 2
        return abs(np.pi - known[0]) if known else 0.0

    def walk(self, vertex, back, before, ahead, after, way):
        """The angle from the line's way back to its way ahead, round the vertex one way; None where the mesh ends."""
        here = self.positions[vertex]
        if before == after:
            between = angle_between(back, ahead)
            # One way is straight across the triangle, the other round all the rest.
            return between if way == 0 else sum(self.corner(t, vertex) for t in self.around[vertex]) - between
        spoke = [int(v) for v in self.triangles[before] if v != vertex][way]
        angle, triangle = angle_between(back, self.positions[spoke] - here), before
        for _ in self.around[vertex]:
            beyond = [t for t in self.around[vertex] if t != triangle and spoke in self.triangles[t]]
            if len(beyond) != 1:
                return None
            triangle = beyond[0]
            if triangle == after:
                return angle + angle_between(self.positions[spoke] - here, ahead)
            angle += self.corner(triangle, vertex)
            spoke = next(int(v) for v in self.triangles[triangle] if v not in (vertex, spoke))
        return None

    def corner(self, triangle, vertex):
        """A triangle's angle at one of its vertices."""
        a, b = (self.positions[v] - self.positions[vertex] for v in self.triangles[triangle] if v != vertex)
        return angle_between(a, b)


def measure_mesh(name, thresholds, rows):
    """Adds the figures of every line on one mesh to `rows`, by threshold, knots and support."""
    mesh = meshes.read_mesh(meshes.find_mesh_folder() / name)
    surface = sp.SurfaceMesh(mesh.positions, mesh.triangles)
    meter = TurningMeter(mesh)
    for picks, closed in choose_pick_sets(mesh):
        found = {}
        try:
            start = surface.polyline(picks, closed=closed, filter="none")
            turning = meter.measure(start)
            for threshold in thresholds:
                for knots in KNOTS:
                    for support in SUPPORTS:
                        options = {"knots": knots, "support": support, "threshold": threshold}
                        line = surface.polyline(picks, closed=closed, filter="cubic", **options)
                        found[threshold, knots, support] = (
                            line.length / start.length,
                            meter.measure(line) / turning,
                            100.0 * (line.report.stop_reason in SETTLED),
                            line.report.moves / len(start.points),
                        )
        except sp.CollapsedError:
            continue  # nothing to compare with: the whole set is left out
        for key, figures in found.items():
            rows[key].append(figures)


def print_table(rows):
    """Means over all lines, in Markdown."""
    print("| threshold | knots | support | length / start | turning / start | settled, % | moves a crossing |")
    print("|---|---|---|---|---|---|---|")
    for (threshold, knots, support), figures in rows.items():
        length, turning, settled, moves = np.mean(figures, axis=0)
        print(f"| {threshold:.0e} | {knots} | {support} | {length:.4f} | {turning:.4f} | {settled:.0f} | {moves:.0f} |")


def main():
    """Reads the command line, measures, prints."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mesh", nargs="*", default=MESHES, help="files in the folder of shared meshes")
    parser.add_argument("--threshold", type=float, action="append", help="barycentric units; may be repeated")
    arguments = parser.parse_args()
    rows = defaultdict(list)
    for name in arguments.mesh:
        measure_mesh(name, arguments.threshold or THRESHOLDS, rows)
        print(f"{name}: {len(next(iter(rows.values()), []))} lines so far", file=sys.stderr, flush=True)
    print_table(rows)


if __name__ == "__main__":
    main()
