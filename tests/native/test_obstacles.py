"""Lines round an ear and between ear and horn (the paper, figures 7 and 16) keep to the side that their pick is on.

The shared cow and spot have ears and horns. Two lines between the same picks, one below the ear and one between ear and
horn, enclose the ear: whoever starts on its tip and never crosses a strip must not get to the horn or the rest.
"""

import numpy as np
import pytest

import smooth_polylines as sp
from meshes import load_shared_mesh

# Points in the mesh's own units, read off the meshes: where the line starts and ends, the pick below the ear, the pick
# between ear and horn, the tips of ear and horn, and a place far away (all on the same side of the head).
HEADS = {
    "spot.obj": {
        "start": (0.10, 0.74, -0.52),
        "end": (0.10, 0.68, -0.05),
        "below": (0.33, 0.56, -0.28),
        "between": (0.27, 0.79, -0.28),
        "ear": (0.432, 0.746, -0.258),
        "horn": (0.192, 0.949, -0.288),
        "far": (0.0, -0.081, 1.049),
    },
    "cow.off": {
        "start": (0.46, 0.24, 0.015),
        "end": (0.30, 0.26, 0.015),
        "below": (0.345, 0.215, 0.10),
        "between": (0.372, 0.272, 0.083),
        "ear": (0.325, 0.277, 0.119),
        "horn": (0.414, 0.306, 0.074),
        "far": (-0.5, -0.151, 0.018),
    },
}
FILTERS = [
    {"filter": "linear"},
    {"filter": "linear", "solver": "heap"},
    {"filter": "cubic", "threshold": 1e-2},
    {"filter": "geodesic"},
]


class Head:
    """A mesh with an ear and a horn, and the triangles nearest to the named points."""

    def __init__(self, name):
        arrays = load_shared_mesh(name)
        self.triangles = arrays.triangles
        self.mesh = sp.SurfaceMesh(arrays.positions, arrays.triangles)
        middles = arrays.positions[arrays.triangles].mean(axis=1)
        self.places = {
            place: int(np.linalg.norm(middles - point, axis=1).argmin()) for place, point in HEADS[name].items()
        }
        sides = np.sort(arrays.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        _, self.edges = np.unique(sides, axis=0, return_inverse=True)
        self.edges = self.edges.reshape(-1, 3)

    def lines(self, options):
        ends = [self.places["start"], self.places["end"]]
        routes = {"free": [], "below": [self.places["below"]], "between": [self.places["between"]]}
        return {name: self.mesh.polyline([ends[0], *inner, ends[1]], **options) for name, inner in routes.items()}

    def reach(self, start, walls):
        """Triangles that can be reached from `start` across edges without entering one of `walls`."""
        by_edge = {}
        for triangle, edges in enumerate(self.edges.tolist()):
            for edge in edges:
                by_edge.setdefault(edge, []).append(triangle)
        seen, todo = {start}, [start]
        while todo:
            triangle = todo.pop()
            for edge in self.edges[triangle].tolist():
                for other in by_edge[edge]:
                    if other not in seen and other not in walls:
                        seen.add(other)
                        todo.append(other)
        return seen


@pytest.fixture(params=HEADS, scope="module")
def head(request):
    return Head(request.param)


@pytest.mark.parametrize("options", FILTERS, ids=lambda o: "-".join(map(str, o.values())))
def test_three_lines_between_the_same_picks_are_three_and_enclose_the_ear(head, options):
    lines = head.lines(options)
    # The free line takes the shortest way, over the top of the head; a pick each makes the others.
    assert len({tuple(line.strip.tolist()) for line in lines.values()}) == 3
    assert lines["free"].length < min(lines["below"].length, lines["between"].length)
    below, between = (set(lines[name].strip.tolist()) for name in ("below", "between"))
    assert head.places["ear"] not in below | between, "the line runs over the tip of the ear"
    ear = head.reach(head.places["ear"], below | between)
    assert head.places["horn"] not in ear, "the line between ear and horn has jumped over one of them"
    assert head.places["far"] not in ear, "the lines do not enclose the ear: one has jumped over it"


def test_the_strips_of_step_b_are_three_different_ones(head):
    # Pinned, as a pick in a dead end of its strip is else only a hint: the way in and out of it cancels.
    lines = head.lines({"filter": "none", "pinned": "all"})
    strips = {tuple(line.strip.tolist()) for line in lines.values()}
    assert len(strips) == 3
    for name in ("below", "between"):
        assert head.places[name] in lines[name].strip.tolist()
