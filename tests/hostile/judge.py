"""One line made and judged: a record of what came out. The judge is the independent checker; no test."""

import time

import numpy as np

import smooth_polylines as sp
from native.invariants import SurfaceChecker, same_line
from native.straightness import StraightnessJudge

NAMED = (sp.NoPathError, sp.CollapsedError, sp.OptionError)
STOP_REASONS = ("converged", "converged_at_vertices", "cycle", "max_iterations")
# Rounds that the paper's filters get, and what none has come near of the others (docs/hostile.md has the worst).
MOST_ROUNDS = {"none": 0, "linear": 100, "cubic": 100, "geodesic": 100_000, "fair": 100_000}


# What takes longer than this is broken, whatever it ends with.
LIMIT_SECONDS = 60


# Height of a triangle, as a share of its longest side, below which double precision cannot tell the angles of a strip:
# places in it are right to 1e-16, and its short edges give the direction.
THINNEST = 1e-7


# What a geodesic may be bent by, in radians, on a mesh with such triangles: it is found on one whose vertices were
# moved apart there, by a hundred-billionth of an edge.
FLAT_SLACK = 1e-8


class Judge:
    """Knows one mesh, opened by the library and by the checkers."""

    def __init__(self, name, positions, triangles):
        self.name = name
        self.triangles = triangles
        self.mesh = sp.SurfaceMesh(positions, triangles)
        self.checker = SurfaceChecker(positions, triangles)
        self.straightness = StraightnessJudge(self.checker)
        # Triangles without area, to what double precision can tell, and their vertices.
        p = np.asarray(positions, float)[triangles]
        sides = np.stack([p[:, 1] - p[:, 0], p[:, 2] - p[:, 1], p[:, 0] - p[:, 2]], axis=1)
        longest = np.linalg.norm(sides, axis=2).max(axis=1)
        unit = np.where(longest > 0, longest, 1)[:, None]
        height = np.linalg.norm(np.cross(sides[:, 0] / unit, sides[:, 1] / unit), axis=1)
        self.longest_edge = longest.max()
        grain = 64 * np.finfo(float).eps * np.abs(p).max(axis=(1, 2)) / unit[:, 0]
        self.is_flat = height <= np.maximum(THINNEST, grain)
        self.flat_slack = FLAT_SLACK if self.is_flat.any() else 0.0
        self.is_flat_vertex = np.zeros(len(positions), bool)
        self.is_flat_vertex[triangles[self.is_flat].ravel()] = True

    def record(self, job):
        """A dict: outcome (a stop reason, an error's name, or "BROKEN"), rounds, milliseconds, and what is broken."""
        began = time.perf_counter()
        try:
            line = self.mesh.polyline(job.picks, **job.options(), time_limit=LIMIT_SECONDS)
        except NAMED as error:
            return self._told(job, type(error).__name__, 0, began)
        except sp.Error as error:
            return self._told(job, "BROKEN", 0, began, f"{type(error).__name__}: {error}")
        told = self._told(job, line.report.stop_reason, line.report.iterations, began)
        try:
            self.check(job, line)
        except (AssertionError, StopIteration, sp.Error) as error:
            told |= {"outcome": "BROKEN", "why": f"{type(error).__name__}: {error}"}
        return told

    def _told(self, job, outcome, rounds, began, why=""):
        milliseconds = 1e3 * (time.perf_counter() - began)
        return {"way": job.way, "kind": job.picks_kind, "closed": job.closed, "pinned": str(job.pinned)[:60],
                "outcome": outcome, "rounds": rounds, "ms": milliseconds, "why": why}  # fmt: skip

    def check(self, job, line):
        """Assert all promises about one line."""
        filter_name, pins = job.options()["filter"], self._pins(job)
        report = line.report
        self.checker.check(line, pins=pins)
        assert report.stop_reason in STOP_REASONS, report.stop_reason
        assert report.iterations <= MOST_ROUNDS[filter_name], f"{report.iterations} rounds"
        if filter_name in ("geodesic", "fair"):
            assert report.stop_reason.startswith("converged"), f"{filter_name} ended with {report.stop_reason}"
        if filter_name == "geodesic":
            at = [self._position(*pin) for pin in pins]
            for place, kind, bend, slack in self.straightness.bends(line, at):
                allowed = slack + self.flat_slack + self._given_by_flat(line, place)
                is_straight = bend <= allowed or self._has_no_angles(line, place)
                assert is_straight, f"bent by {bend} at point {place} ({kind})"
        if filter_name == "fair":
            energies = np.asarray(report.energies)
            assert (np.diff(energies) <= 1e-12 * np.abs(energies[:-1])).all(), "the energy rises"
        assert same_line(self.mesh.line_from_bytes(line.to_bytes()), line), "bytes give another line"

    def _given_by_flat(self, line, place):
        """What a neighbour at triangles without area, which is right to 1e-9 of an edge, may bend the line by here."""
        count = len(line.points)
        near = [k % count for k in (place - 1, place + 1) if self._has_no_angles(line, k % count)]
        lengths = [np.linalg.norm(line.points[k] - line.points[place]) for k in near]
        return sum(1e-9 * self.longest_edge / length if length > 0 else np.inf for length in lengths)

    def _has_no_angles(self, line, place):
        """Whether triangles without area meet at a point: directions mean nothing there, and no angle can be judged."""
        support = self.checker.support(line.triangles[place], line.barycentric[place])
        if len(support) == 1:
            return bool(self.is_flat_vertex[next(iter(support))])
        segments = line.segment_triangles
        # The first point and the last of an open line have one segment.
        either = [segments[place - 1 if place or line.closed else 0], segments[min(place, len(segments) - 1)]]
        return bool(self.is_flat[either].any())

    def _pins(self, job):
        """What the line must pass, in order, as (triangle, parts)."""
        count = len(job.picks)
        flags = job.pinned
        if flags == "all":
            flags = [True] * count
        elif flags == "ends":
            flags = [not job.closed and i in (0, count - 1) for i in range(count)]
        whole = [(int(p[0]), list(p[1])) if isinstance(p, tuple) else (p, [1 / 3] * 3) for p in job.picks]
        return [pick for pick, is_pinned in zip(whole, flags, strict=True) if is_pinned]

    def _position(self, triangle, parts):
        p = self.checker.positions[self.triangles[triangle]]
        b = np.asarray(parts)
        return tuple((b[0] * p[0] + b[1] * p[1]) + b[2] * p[2])
