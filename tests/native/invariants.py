"""An independent checker of everything that the contract promises about a line.

Written from the contract alone, in plain numpy and loops: it calls the library for nothing but the line itself.
"""

from collections import Counter
from itertools import pairwise

import numpy as np

# Parts of a normalised point sum to 1 within the rounding of two additions and three divisions.
SUM_SLACK = 8 * np.finfo(np.float64).eps
# The length is a sum of n square roots; n is at most some thousands here.
LENGTH_SLACK = 1e-12


class SurfaceChecker:
    """Knows one mesh and checks lines on it."""

    def __init__(self, positions, triangles):
        self.positions = np.asarray(positions, np.float64)
        self.triangles = np.asarray(triangles, np.int64)
        sides = self.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        sides.sort(axis=1)
        keys = sides[:, 0] * (len(self.positions) + 1) + sides[:, 1]
        _, inverse, counts = np.unique(keys, return_inverse=True, return_counts=True)
        # Three edge ids a triangle, and how many triangles each edge has.
        self.edge_ids = inverse.reshape(-1, 3)
        self.edge_counts = counts

    def crossable_edges(self, a, b):
        """Edge ids that a line may cross from triangle a to triangle b."""
        shared = set(self.edge_ids[a].tolist()) & set(self.edge_ids[b].tolist())
        return [edge for edge in shared if self.edge_counts[edge] == 2]

    def corners(self, triangle):
        return set(self.triangles[triangle].tolist())

    def support(self, triangle, barycentric):
        """The corners that the point hangs on, with their weights: three inside, two on an edge, one at a vertex."""
        return {
            int(vertex): float(weight)
            for vertex, weight in zip(self.triangles[triangle], barycentric, strict=True)
            if weight != 0.0
        }

    def check(self, line, pins=None, step_b=None):
        """Assert every promise that can be told from the arguments given.

        `pins`: (triangle, barycentric) of the pinned picks in order; None: not told, no inner pick is pinned.
        `step_b`: the line with filter="none" for the same picks.
        """
        self._check_arrays(line)
        supports = [self.support(t, b) for t, b in zip(line.triangles.tolist(), line.barycentric.tolist(), strict=True)]
        if pins is None:
            ends = [0, -1] if not line.closed else []
            pins = [(int(line.triangles[i]), line.barycentric[i].tolist()) for i in ends]
        self._check_points(line, supports, len(pins))
        self._check_segments(line, supports, pins)
        self._check_strip(line, supports, pins)
        self._check_pins(line, supports, pins)
        # Two legs that meet in a pin at a sharp angle share triangles with good reason.
        if step_b is not None and len(pins) <= (0 if line.closed else 2):
            self._check_repeats(line, step_b)

    def _check_arrays(self, line):
        n = len(line.points)
        segments = n if line.closed else n - 1
        if n == 1:
            segments = len(line.segment_triangles)
            assert segments in (0, 1)
        for array, shape, dtype in (
            (line.points, (n, 3), np.float64),
            (line.triangles, (n,), np.int32),
            (line.barycentric, (n, 3), np.float64),
            (line.segment_triangles, (segments,), np.int32),
            (line.strip, (len(line.strip),), np.int32),
            (line.strip_bits, (len(line.strip_bits),), np.bool_),
        ):
            assert array.shape == shape, f"an array has shape {array.shape}, expected {shape}"
            assert array.dtype == dtype, f"an array has dtype {array.dtype}, expected {dtype}"
            assert not array.flags.writeable, "an array can be written to"
        for ids in (line.triangles, line.segment_triangles, line.strip):
            assert ids.size == 0 or (ids.min() >= 0 and ids.max() < len(self.triangles))
        assert len(line.strip) >= 1

    def _check_points(self, line, supports, pin_count):
        b = line.barycentric
        assert (b >= 0.0).all(), "a barycentric part is negative"
        assert (np.abs(b.sum(axis=1) - 1.0) <= SUM_SLACK).all(), "barycentric parts do not sum to 1"
        p = self.positions[self.triangles[line.triangles]]
        expected = (b[:, 0:1] * p[:, 0] + b[:, 1:2] * p[:, 1]) + b[:, 2:3] * p[:, 2]
        assert expected.tobytes() == line.points.tobytes(), "a point is not what its barycentric parts give"
        assert line.on(self.positions).tobytes() == expected.tobytes(), "on(positions) gives other points"
        inside = sum(len(support) == 3 for support in supports)
        assert inside <= pin_count, "only pins lie inside triangles"
        ring = np.vstack([line.points, line.points[:1]]) if line.closed else line.points
        length = np.linalg.norm(np.diff(ring, axis=0), axis=1).sum()
        slack = LENGTH_SLACK * max(length, np.abs(self.positions).max(initial=0.0))
        assert abs(line.length - length) <= slack, f"the length is {line.length}, the segments sum to {length}"

    def _pairs(self, line):
        n = len(line.points)
        return [(i, (i + 1) % n) for i in range(n if line.closed and n > 1 else n - 1)]

    def _check_segments(self, line, supports, pins):
        pin_supports = [self.support(*pin) for pin in pins]
        for i, j in self._pairs(line):
            corners = self.corners(line.segment_triangles[i])
            assert supports[i].keys() <= corners, f"segment {i} does not begin in its triangle"
            assert supports[j].keys() <= corners, f"segment {i} does not end in its triangle"
            assert not (len(supports[i]) == 1 and supports[i] == supports[j]), f"vertex twice at points {i}, {j}"
            if np.array_equal(line.points[i], line.points[j]):
                is_stuck = all(supports[k] in pin_supports for k in (i, j)) and self._is_flat(line.segment_triangles[i])
                is_coincident = self._has_coincident(supports[i].keys() | supports[j].keys())
                assert is_coincident or is_stuck, f"points {i}, {j} are equal"
        for before, after in zip(self._pairs(line), self._pairs(line)[1:] + self._pairs(line)[:1], strict=True):
            a, b = line.segment_triangles[before[0]], line.segment_triangles[after[0]]
            joint = before[1]
            if joint != after[0] or a == b:
                continue
            assert len(supports[joint]) < 3, f"the line changes triangle inside one at point {joint}"
            if len(supports[joint]) == 2:
                crossed = [e for e in self.crossable_edges(a, b) if self._edge_has(a, e, supports[joint])]
                assert crossed, f"point {joint} crosses no edge of both triangles, or a wall"

    def _is_flat(self, triangle):
        """No area: two pins in it may be at one place, and neither can move."""
        a, b, c = self.positions[self.triangles[triangle]]
        return not np.cross(b - a, c - a).any()

    def _has_coincident(self, vertices):
        places = {tuple(self.positions[v]) for v in vertices}
        return len(places) < len(vertices)

    def _edge_has(self, triangle, edge, support):
        side = self.edge_ids[triangle].tolist().index(edge)
        ends = {int(self.triangles[triangle][side]), int(self.triangles[triangle][(side + 1) % 3])}
        return support.keys() <= ends

    def _check_strip(self, line, supports, pins):
        strip = line.strip.tolist()
        ring = [*strip, strip[0]] if line.closed and len(strip) > 1 else strip
        for a, b in pairwise(ring):
            assert self.crossable_edges(a, b), f"the strip is broken between triangles {a} and {b}"
        around = [*strip, *strip[:2]] if line.closed and len(strip) > 2 else strip
        for a, b, c in zip(around, around[1:], around[2:], strict=False):
            if a == c and len(self.crossable_edges(a, b)) == 1:
                dead_end = any(self.support(*pin).keys() <= self.corners(b) for pin in pins)
                assert dead_end, f"the strip turns back in triangle {b}, which holds no pin"
        if not line.closed:
            assert supports[0].keys() <= self.corners(strip[0]), "the strip does not begin at the first point"
            assert supports[-1].keys() <= self.corners(strip[-1]), "the strip does not end at the last point"
        self._check_order(line, strip)

    def _check_order(self, line, strip):
        """Segments run through the strip's triangles in the strip's order."""
        found = line.segment_triangles.tolist()
        walk = iter(strip + strip if line.closed else strip)
        current = next(walk)
        for triangle in found:
            while current != triangle:
                current = next(walk, None)
                assert current is not None, f"segment triangle {triangle} is not in the strip, or out of order"

    def _check_pins(self, line, supports, pins):
        place = 0
        order = range(len(supports))
        for pin in pins:
            wanted = self.support(*pin)
            hits = [i for i in order if supports[i] == wanted]
            assert hits, f"pin {pin} is not on the line"
            if line.closed:
                continue
            later = [i for i in hits if i >= place]
            assert later, f"pin {pin} comes too early"
            place = later[0]
        if pins and not line.closed:
            assert supports[0] == self.support(*pins[0])
            assert supports[-1] == self.support(*pins[-1])

    def _check_repeats(self, line, step_b):
        """The strip repeats a triangle only where step B's route already did."""
        if max(Counter(step_b.strip.tolist()).values()) > 1:
            return
        repeated = [t for t, count in Counter(line.strip.tolist()).items() if count > 1]
        assert not repeated, f"the strip repeats triangles {repeated[:5]}, step B's did not"


def same_line(one, other):
    """Whether two lines are equal to the bit, reports apart."""
    arrays = ("points", "triangles", "barycentric", "segment_triangles", "strip", "strip_bits")
    return one.closed == other.closed and all(
        getattr(one, name).tobytes() == getattr(other, name).tobytes() for name in arrays
    )


def barycentre_pins(triangles):
    """What picks by triangle id are pinned to."""
    return [(int(t), [1 / 3] * 3) for t in triangles]
