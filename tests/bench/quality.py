"""How good the lines are that were timed: lengths beside the shortest known, and turns where a line should be straight.

The turns are judged by the tests' own judge, which knows no library. Holds no timing.
"""

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
                points, line = answer.points, answer
            else:
                points = np.asarray(library.points(answer, picks), dtype=np.float64)
                line = as_line(judge, opened[Ours.name].mesh, points)
            lines[name].append(length_of(points))
            if line is None:
                turns[name]["unplaced"] += 1
                continue
            for kind, degrees in turns_of(judge, line, library.eps):
                turns[name][kind] = max(turns[name][kind], degrees)
    return {"lengths": lines, "turns": turns}


def turns_of(judge, line, eps):
    """Kind and degrees of each turn that rounding cannot explain."""
    for _, kind, bend, slack in judge.bends(line):
        noise = slack * eps / Ours.eps
        if noise < MOST_NOISE and kind in ("edge", "vertex"):
            yield kind, float(np.degrees(max(0.0, bend - noise)))


def as_line(judge, mesh, points):
    """Points of another library with the triangles that hold them; None where two neighbours have none in common."""
    step = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.concatenate([[True], step > 0])]
    triangles, barycentric = place_points(mesh, points)
    supports = [frozenset(judge.checker.support(int(t), b)) for t, b in zip(triangles, barycentric, strict=True)]
    segments = []
    for one, other in zip(supports, supports[1:], strict=False):
        both = one | other
        held = [t for t in judge.around[next(iter(one))] if both <= judge.checker.corners(t)]
        if not held:
            return None
        segments.append(held[0])
    return SimpleNamespace(
        points=points, triangles=triangles, barycentric=barycentric, segment_triangles=segments, closed=False
    )
