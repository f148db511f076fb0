"""What is asked of each mesh: picks of every kind, times all filters, open and closed, all kinds of pins. No test."""

import itertools
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

# Name in the table, keyword arguments. The paper's filters also by the paper's own solver.
FILTERS = {
    "none": {"filter": "none"},
    "linear": {"filter": "linear"},
    "linear, heap 1e-3": {"filter": "linear", "solver": "heap", "threshold": 1e-3},
    "linear, heap 1e-4": {"filter": "linear", "solver": "heap", "threshold": 1e-4},
    "cubic 1e-2": {"filter": "cubic", "threshold": 1e-2},
    "cubic 1e-3": {"filter": "cubic", "threshold": 1e-3},
    "cubic 1e-4": {"filter": "cubic", "threshold": 1e-4},
    "geodesic": {"filter": "geodesic"},
    "fair": {"filter": "fair"},
    "fair inf": {"filter": "fair", "detail_size": float("inf")},
}
PINS = ("ends", "all", "some")
MOST_PICKS = 200
# Moves of one vertex at a time grow with the square of the line: the paper's solver gets fewer.
MOST_PICKS_ONE_BY_ONE = 12


@dataclass(frozen=True)
class Job:
    """One line that is asked for."""

    mesh: str
    way: str
    picks_kind: str
    picks: list = field(repr=False)
    closed: bool
    pinned: object

    def options(self):
        return {**FILTERS[self.way], "closed": self.closed, "pinned": self.pinned}


def pick_sets(triangles, edge_ids, rng):
    """Picks of every kind, by the name of the kind."""
    wanted = _largest_part(edge_ids) if rng.integers(4) else np.arange(len(triangles))
    any_triangle = lambda n: rng.choice(wanted, size=n).tolist()  # noqa: E731
    owners = {}
    for triangle, edges in enumerate(edge_ids.tolist()):
        for edge in edges:
            owners.setdefault(edge, []).append(triangle)
    alone = [found[0] for found in owners.values() if len(found) == 1]
    pairs = [found for found in owners.values() if len(found) == 2]
    sets = {"two": any_triangle(2), "four": any_triangle(4)}
    if pairs:
        a, b = pairs[int(rng.integers(len(pairs)))]
        c, d = pairs[int(rng.integers(len(pairs)))]
        sets["neighbours"] = [a, b, a, c, d, d]
    if alone:
        sets["boundary"] = [alone[int(i)] for i in rng.integers(len(alone), size=4)]
    sets["equal"] = any_triangle(1) * 3
    sets["points"] = [_point(triangle, rng) for triangle in any_triangle(5)]
    sets["many"] = any_triangle(round(MOST_PICKS ** rng.uniform(0, 1)))
    return sets


def _largest_part(edge_ids):
    """Triangles of the part with most of them, where parts are joined across edges of two triangles."""
    owner = np.repeat(np.arange(len(edge_ids)), 3)
    order = np.argsort(edge_ids.ravel(), kind="stable")
    edges, triangles = edge_ids.ravel()[order], owner[order]
    is_pair = np.bincount(edges)[edges] == 2
    pairs = triangles[is_pair].reshape(-1, 2)
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(edge_ids),) * 2)
    _, labels = connected_components(graph, directed=False)
    return np.flatnonzero(labels == np.bincount(labels).argmax())


def _point(triangle, rng):
    """Inside, on an edge or at a corner; parts in 64ths, so that they are exact."""
    kind = int(rng.integers(3))
    a, b = sorted(rng.choice(np.arange(1, 64), 2, replace=False).tolist())
    parts = ([a, b - a, 64 - b], [0, a, 64 - a], [64, 0, 0])[kind]
    return triangle, tuple((np.roll(parts, int(rng.integers(3))) / 64).tolist())


def jobs_of(mesh, triangles, edge_ids, seed, every=1):
    """Every so-manieth job of one mesh, from a place that is the mesh's own."""
    rng = np.random.default_rng([seed, 7])
    turn = int(rng.integers(100))
    for kind, all_picks in pick_sets(triangles, edge_ids, rng).items():
        for way, closed, pins in itertools.product(FILTERS, (False, True), PINS):
            turn += 1
            if turn % every:
                continue
            picks = all_picks
            if "heap" in way or "cubic" in way:
                picks = picks[:MOST_PICKS_ONE_BY_ONE]
            pinned = pins
            if pins == "some":
                pinned = (rng.random(len(picks)) < 0.5).tolist()
                if not closed:
                    pinned[0] = pinned[-1] = True
            yield Job(mesh, way, kind, picks, closed, pinned)
