"""Where `cubic` says that it has come to rest, no crossing is further than the threshold from its place: by numpy."""

import numpy as np
import pytest

from native.surfaces import open_surface

SETTLED = ("converged", "converged_at_vertices")
THRESHOLD = 1e-4
# Seeking in steps finds the nearest point to a step's square, and what is left of the last digits.
SLACK = 1e-6


def cubic_place(low, high, around, inner=1):
    """Where on the edge from `low` to `high` the point nearest the centripetal cubic through four points is.

    The vertex lies between those at `inner` and `inner + 1`.
    """
    gaps = np.sqrt(np.linalg.norm(np.diff(around, axis=0), axis=1))
    knots = np.concatenate([[0], np.cumsum(2 * gaps / gaps[inner])])
    knots -= knots[inner] + 1
    edge = high - low
    low_u, high_u = -1.0, 1.0
    for _ in range(4):
        u = np.linspace(low_u, high_u, 401)
        parts = [np.prod([(u - k) / (own - k) for k in knots if k != own], axis=0) for own in knots]
        curve = np.tensordot(np.array(parts), around, axes=(0, 0)) - low
        t = np.clip(curve @ edge / (edge @ edge), 0, 1)
        distance = np.linalg.norm(curve - t[:, None] * edge, axis=1)
        best = int(np.argmin(distance))
        low_u, high_u = u[max(best - 2, 0)], u[min(best + 2, 400)]
    return t[best]


@pytest.mark.parametrize(
    ("name", "picks"),
    [("cow.off", (4861, 1518)), ("spot.obj", (100, 4000)), ("camel.off", (0, 9000)), ("bunny00.off", (100, 20000))],
)
def test_a_line_that_has_settled_is_where_the_filter_wants_it(name, picks):
    surface = open_surface(name)
    line = surface.mesh.polyline(list(picks), filter="cubic", threshold=THRESHOLD)
    assert line.report.stop_reason in SETTLED, line.report
    points, off, judged = line.points, [], 0
    for i in range(2, len(points) - 2):
        weights = line.barycentric[i]
        near = line.barycentric[i - 2 : i + 3]
        # At mesh vertices several crossings share a point, and neighbours are not those of the list.
        if (near == 1.0).any() or np.count_nonzero(weights) != 2:
            continue
        ends = sorted(surface.triangles[line.triangles[i]][weights > 0])
        low, high = (surface.positions[v] for v in ends)
        here = np.linalg.norm(points[i] - low) / np.linalg.norm(high - low)
        place = cubic_place(low, high, points[[i - 2, i - 1, i + 1, i + 2]])
        judged += 1
        if abs(place - here) > THRESHOLD + SLACK:
            off.append((i, abs(place - here)))
    assert judged > len(points) / 3, "hardly anything was judged"
    assert not off, f"{len(off)} of {judged}: {off[:5]}"


@pytest.mark.parametrize("at_end", [False, True])
def test_what_is_left_beside_a_pin_that_has_become_an_end_is_at_rest(at_end):
    """A vertex next to an end looks at three on the other side: where a pin became one, at others than before."""
    surface = open_surface("bunny00.off")
    picks = [100, 20000, 40000, 60000]
    line = surface.mesh.polyline(picks, filter="cubic", pinned="all", threshold=1e-2)
    shorter = line.with_picks(picks[:-1] if at_end else picks[1:])
    assert shorter.report.kept_legs == 2, "no leg was made again"
    points = shorter.points if at_end else shorter.points[::-1]
    barycentric, triangles = shorter.barycentric[-2 if at_end else 1], shorter.triangles[-2 if at_end else 1]
    low, high = (surface.positions[v] for v in sorted(surface.triangles[triangles][barycentric > 0]))
    here = np.linalg.norm(points[-2] - low) / np.linalg.norm(high - low)
    place = cubic_place(low, high, points[[-5, -4, -3, -1]], inner=2)
    assert abs(place - here) <= 1e-2 + SLACK, "it stayed where it was"
