"""An independent judge of locally shortest lines: straight across edges, at vertices at least pi on both sides.

Works on the arrays of a line and of its mesh alone. Holds no test.
"""

from collections import defaultdict

import numpy as np

EPS = np.finfo(np.float64).eps


def angle_between(a, b):
    """The angle of two vectors, exact also near 0 and pi (W. Kahan, Miscalculating Area and Angles, 2006)."""
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), np.dot(a, b)))


class StraightnessJudge:
    """Knows one mesh and tells how far a line on it is from locally shortest."""

    def __init__(self, checker):
        self.checker = checker
        self.positions = checker.positions
        self.triangles = checker.triangles
        self.around = defaultdict(list)
        for triangle, corners in enumerate(self.triangles.tolist()):
            for vertex in corners:
                self.around[vertex].append(triangle)

    def bends(self, line, pin_points=()):
        """For each inner point that is no pin: (place, kind, bend in radians, what rounding may cause)."""
        pins = {tuple(point) for point in pin_points}
        n = len(line.points)
        places = range(n) if line.closed else range(1, n - 1)
        size = np.abs(self.positions).max()
        for i in places:
            before, here, after = line.points[i - 1], line.points[i], line.points[(i + 1) % n]
            if tuple(here) in pins:
                continue
            a, b = int(line.segment_triangles[i - 1]), int(line.segment_triangles[i])
            support = self.checker.support(int(line.triangles[i]), line.barycentric[i])
            shorter = min(np.linalg.norm(here - before), np.linalg.norm(after - here))
            slack = max(1e-9, 8 * EPS * size / shorter) if shorter > 0 else np.inf
            if len(support) == 1:
                (vertex,) = support
                yield i, "vertex", self._bend_at_vertex(vertex, a, b, before - here, after - here), slack
            elif a != b:
                ends = [self.positions[v] for v in support]
                along = ends[1] - ends[0]
                yield i, "edge", abs(angle_between(here - before, along) - angle_between(after - here, along)), slack
            else:
                yield i, "inside", np.pi - angle_between(before - here, after - here), slack

    def _bend_at_vertex(self, vertex, a, b, towards_before, towards_after):
        """How much the smaller open side lacks to pi; 0 where both sides are closed to the line."""
        sides = [self._side_angle(vertex, a, b, towards_before, towards_after, turn) for turn in (0, 1)]
        if self._is_pinched(vertex):
            return 0.0
        return max([0.0] + [np.pi - angle for angle in sides if angle is not None])

    def _is_pinched(self, vertex):
        """Whether what is reached by crossing edges round the vertex is not all that meets there."""
        todo, seen = [self.around[vertex][0]], {self.around[vertex][0]}
        while todo:
            t = todo.pop()
            for other in self.around[vertex]:
                if other not in seen and self._spokes(vertex, t, other):
                    seen.add(other)
                    todo.append(other)
        return len(seen) < len(self.around[vertex])

    def _spokes(self, vertex, t, other):
        return [
            end
            for edge in self.checker.crossable_edges(t, other)
            if (end := self._spoke_end(vertex, t, edge)) is not None
        ]

    def _spoke_end(self, vertex, triangle, edge):
        corners = self.triangles[triangle].tolist()
        side = self.checker.edge_ids[triangle].tolist().index(edge)
        ends = {corners[side], corners[(side + 1) % 3]}
        return (ends - {vertex}).pop() if vertex in ends else None

    def _side_angle(self, vertex, a, b, towards_before, towards_after, turn):
        """Angle from the incoming to the outgoing direction, leaving triangle a by its spoke `turn`; None at an end."""
        centre = self.positions[vertex]
        spokes = [v for v in self.triangles[a].tolist() if v != vertex]
        spoke = spokes[turn]
        to_spoke = self.positions[spoke] - centre
        if a == b:
            # Both directions lie in one triangle: one side is the angle between them, the other the rest of the fan.
            if angle_between(towards_after, to_spoke) <= angle_between(towards_before, to_spoke):
                return angle_between(towards_before, towards_after)
        angle, current = angle_between(towards_before, to_spoke), a
        for _ in range(len(self.around[vertex])):
            following = [t for t in self.around[vertex] if t != current and spoke in self._spokes(vertex, current, t)]
            if not following:
                return None
            current = following[0]
            other = next(v for v in self.triangles[current].tolist() if v not in (vertex, spoke))
            to_spoke, to_other = self.positions[spoke] - centre, self.positions[other] - centre
            if current == b:
                return angle + angle_between(to_spoke, towards_after)
            angle += angle_between(to_spoke, to_other)
            spoke = other
        return None
