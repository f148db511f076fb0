"""The meshes of the benchmark, from small to large, and the queries on each: all between vertices.

Vertices, because every library takes them: each then answers exactly the same question. Holds no timing.
"""

import heapq
from dataclasses import dataclass, field

import numpy as np

import meshes

# Smallest first; the last one is igea with every triangle cut in four.
SHARED = ("cow.off", "camel.off", "bunny00.off", "igea.ply", "igea.ply, cut in four")
CUT_IN_FOUR = ", cut in four"
# A near pair is this share of the bounding box's diagonal apart, along the mesh's edges.
NEAR_SHARE = 0.03
NEAR_PAIRS = 8
ACROSS_PAIRS = 4
MORE_PAIRS = 12  # for the quality of lines
RING_PICKS = 30
LINE_PICKS = 10
STROKE_POINTS = 2000
DRAGGED = 5  # which of the line's picks moves


@dataclass
class Rung:
    """One mesh and what is asked on it."""

    name: str
    positions: np.ndarray  # (V, 3) float64
    triangles: np.ndarray  # (F, 3) int32
    near: list[tuple[int, int]] = field(default_factory=list)
    across: list[tuple[int, int]] = field(default_factory=list)
    more: list[tuple[int, int]] = field(default_factory=list)
    ring: list[int] = field(default_factory=list)
    line: list[int] = field(default_factory=list)
    dragged_line: list[int] = field(default_factory=list)
    drawn: np.ndarray | None = None  # (STROKE_POINTS, 3), near the surface

    @property
    def short_name(self):
        return self.name.split(".")[0] + (" x 4" if self.name.endswith(CUT_IN_FOUR) else "")


def has_shared_meshes():
    return meshes.find_mesh_folder().is_dir()


def load_rung(name):
    """A shared mesh, its subdivision, or (`ball of 5 cuts`) a made one; with its queries."""
    if name.startswith("ball of "):
        positions, triangles = make_ball(int(name.split()[2]))
    else:
        mesh = meshes.load_shared_mesh(name.removesuffix(CUT_IN_FOUR))
        positions, triangles = mesh.positions, mesh.triangles
        if name.endswith(CUT_IN_FOUR):
            positions, triangles = cut_in_four(positions, triangles)
    rung = Rung(name, np.ascontiguousarray(positions), np.ascontiguousarray(triangles, dtype=np.int32))
    add_queries(rung)
    return rung


def cut_in_four(positions, triangles):
    """Every triangle cut in four at the midpoints of its sides."""
    sides = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64), axis=1)
    keys, inverse = np.unique(sides[:, 0] * len(positions) + sides[:, 1], return_inverse=True)
    ends = np.stack([keys // len(positions), keys % len(positions)], axis=1)
    middles = (len(positions) + inverse).reshape(-1, 3)
    (a, b, c), (ab, bc, ca) = triangles.T, middles.T
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    cut = np.stack([np.stack(triangle, axis=1) for triangle in corners], axis=1).reshape(-1, 3)
    return np.concatenate([positions, positions[ends].mean(axis=1)]), cut.astype(np.int32)


def make_ball(cuts):
    """A ball with bumps, of 8 * 4**cuts triangles: for machines without the shared meshes, and for the test."""
    positions = np.concatenate([np.eye(3), -np.eye(3)])
    triangles = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    for _ in range(cuts):
        positions, triangles = cut_in_four(positions, triangles)
    positions /= np.linalg.norm(positions, axis=1)[:, None]
    bumps = 1 + 0.08 * np.sin(5 * positions[:, 0]) * np.cos(4 * positions[:, 1] + positions[:, 2])
    return positions * bumps[:, None] * [1.5, 1.0, 0.9], triangles.astype(np.int32)


def add_queries(rung):
    """Fill in the queries; the same for the same mesh."""
    rng = np.random.default_rng(2003)
    used = np.unique(rung.triangles)
    neighbours = Neighbours(rung)
    low, high = rung.positions[used].min(axis=0), rung.positions[used].max(axis=0)
    near = NEAR_SHARE * np.linalg.norm(high - low)
    rung.near = [(start, neighbours.first_beyond(start, near)) for start in rng.choice(used, NEAR_PAIRS).tolist()]
    for start in rng.choice(used, ACROSS_PAIRS).tolist():
        far = np.linalg.norm(rung.positions[used] - rung.positions[start], axis=1).argmax()
        rung.across.append((start, int(used[far])))
    rung.more = [tuple(rng.choice(used, 2, replace=False).tolist()) for _ in range(MORE_PAIRS)]
    # A ring round the waist: beside the surface, in the plane across the longest side of the box.
    middle, half = (low + high) / 2, (high - low) / 2
    _, one, other = np.argsort(-half)
    angles = np.linspace(0, 2 * np.pi, STROKE_POINTS, endpoint=False)
    places = np.tile(middle, (STROKE_POINTS, 1))
    places[:, one] += half[one] * np.cos(angles)
    places[:, other] += half[other] * np.sin(angles)
    rung.drawn = places
    chosen = np.linspace(0, STROKE_POINTS, RING_PICKS, endpoint=False).astype(int)
    nearest = [int(used[np.linalg.norm(rung.positions[used] - places[i], axis=1).argmin()]) for i in chosen]
    rung.ring = [v for i, v in enumerate(nearest) if v != nearest[i - 1]]
    rung.line = rung.ring[:: max(1, len(rung.ring) // LINE_PICKS)][:LINE_PICKS]
    rung.dragged_line = list(rung.line)
    others = neighbours.of(rung.line[DRAGGED])
    rung.dragged_line[DRAGGED] = next(v for v in others if v not in rung.line)


class Neighbours:
    """The vertices next to each vertex, along edges."""

    def __init__(self, rung):
        self.positions = rung.positions
        sides = rung.triangles[:, [0, 1, 1, 2, 2, 0, 1, 0, 2, 1, 0, 2]].reshape(-1, 2)
        sides = sides[np.argsort(sides[:, 0], kind="stable")]
        self.starts = np.searchsorted(sides[:, 0], np.arange(len(rung.positions) + 1))
        self.ends = sides[:, 1]

    def of(self, vertex):
        return sorted(set(self.ends[self.starts[vertex] : self.starts[vertex + 1]].tolist()))

    def first_beyond(self, start, distance):
        """The vertex nearest to `start` along edges of those at least `distance` away."""
        done, queue = set(), [(0.0, start)]
        while queue:
            walked, vertex = heapq.heappop(queue)
            if walked >= distance:
                return vertex
            if vertex in done:
                continue
            done.add(vertex)
            for other in self.of(vertex):
                step = float(np.linalg.norm(self.positions[other] - self.positions[vertex]))
                heapq.heappush(queue, (walked + step, other))
        return vertex
