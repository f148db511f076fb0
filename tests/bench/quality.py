"""How good the lines are that were timed: lengths beside the shortest known, and turns where a line should be straight.

The turns are judged by the tests' own judge, which knows no library. Holds no timing.
"""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np

from bench.peers import Ours, length_of, place_points
from native.invariants import SurfaceChecker
from native.straightness import StraightnessJudge

# Lines are the same length when they differ by less, in parts: MeshLib has seven digits.
SAME_LENGTH = 1e-5
# A turn is judged where rounding of the library's own numbers cannot make one larger than this, radians.
MOST_NOISE = 1e-3
# The judge is written for clearness: on larger meshes it takes minutes to begin.
MOST_TRIANGLES = 300_000


def judge_lines(rung, opened):
    """For each library: lengths of lines by query, and the largest turns in degrees at crossings and at vertices."""
    lines = {name: [] for name in opened}
    turns = {name: {"edge": 0.0, "vertex": 0.0, "unplaced": 0} for name in opened}
    judge = StraightnessJudge(SurfaceChecker(rung.positions, rung.triangles))
    for pair in rung.near + rung.across + rung.more:
        for name, library in opened.items():
            picks = library.prepare(rung, pair)
            answer = library.path(picks)
            if isinstance(library, Ours):
                line, length = answer, answer.length
            elif hasattr(library, "place"):
                triangles, barycentric = library.place(answer, rung, pair)
                points = np.einsum("nc,nci->ni", barycentric, rung.positions[rung.triangles[triangles]])
                line, length = as_line(judge, points, triangles, barycentric), length_of(points)
            else:
                points = np.asarray(library.points(answer), dtype=np.float64)
                placed = place_points(opened[Ours.name].mesh, points)
                line, length = as_line(judge, points, *placed), length_of(points)
            lines[name].append(length)
            if line is None:
                turns[name]["unplaced"] += 1
                continue
            for kind, degrees in turns_of(judge, line, library.eps):
                turns[name][kind] = max(turns[name][kind], degrees)
    return {"lengths": lines, "turns": turns}


def turns_of(judge, line, eps):
    """Kind and degrees of each turn that rounding cannot explain; `eps` is that of the library's own numbers."""
    size, points = np.abs(judge.positions).max(), np.asarray(line.points)
    for i, kind, bend, slack in judge.bends(line):
        shorter = np.linalg.norm(points[[i - 1, (i + 1) % len(points)]] - points[i], axis=1).min()
        noise = max(slack, 8 * eps * size / shorter) if shorter > 0 else np.inf
        if noise < MOST_NOISE and kind in ("edge", "vertex"):
            yield kind, float(np.degrees(max(0.0, bend - noise)))


def as_line(judge, points, triangles, barycentric):
    """Points of another library with the triangles that hold them; None where two neighbours have none in common."""
    differs = np.concatenate([[True], np.linalg.norm(np.diff(points, axis=0), axis=1) > 0])
    points, triangles, barycentric = points[differs], triangles[differs], barycentric[differs]
    supports = [frozenset(judge.checker.support(int(t), b)) for t, b in zip(triangles, barycentric, strict=True)]
    segments = []
    for one, other in pairwise(supports):
        both = one | other
        held = [t for t in judge.around[next(iter(one))] if both <= judge.checker.corners(t)]
        if not held:
            return None
        segments.append(held[0])
    return SimpleNamespace(
        points=points, triangles=triangles, barycentric=barycentric, segment_triangles=segments, closed=False
    )
