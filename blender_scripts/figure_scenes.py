"""What the figures show: for each figure of the paper, picks on a real mesh, the lines, and the panels to draw.

Run by `figures`, inside Blender. Each function returns a Figure; how panels look is in `figure_draw`.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

import meshes
import smooth_polylines as sp
from figure_draw import LINE, PATCHES, PICK, START, STRIP, Panel, View

# Towards the camera; the shared models stand along Y and most look along Z.
FRONT_RIGHT = (0.8, 0.35, -1.0)


@dataclass
class Figure:
    """One picture and its rows of the table: (what, picks, line)."""

    name: str
    title: str
    text: str
    mesh: Any
    panels: list[Panel]
    view: View
    rows: list[tuple[str, int, Any]]
    paper: str = "not stated"
    size: tuple[int, int, int] = (520, 400, 2)
    notes: list[str] = field(default_factory=list)


class Stage:
    """A mesh with the helpers of all figures."""

    def __init__(self, name: str) -> None:
        self.source = meshes.load_shared_mesh(name)
        self.name, self.positions, self.triangles = name, self.source.positions, self.source.triangles
        self.mesh = sp.SurfaceMesh(self.positions, self.triangles)
        self.centres = self.positions[self.triangles].mean(axis=1)

    def near(self, *places: tuple[float, float, float]) -> list[int]:
        """The triangles nearest to places in space."""
        return [int(np.linalg.norm(self.centres - place, axis=1).argmin()) for place in places]

    def spread(self, count: int, first: int = 0) -> list[int]:
        """Triangles as far from each other as can be, one after another."""
        picked = [first]
        distances = np.linalg.norm(self.centres - self.centres[first], axis=1)
        while len(picked) < count:
            picked.append(int(distances.argmax()))
            distances = np.minimum(distances, np.linalg.norm(self.centres - self.centres[picked[-1]], axis=1))
        return picked

    def ring(self, count: int, axis: int, height: float) -> list[int]:
        """Triangles all round the mesh, the outermost of each direction in a slab at a share of its height."""
        low, high = self.positions[:, axis].min(), self.positions[:, axis].max()
        level = low + height * (high - low)
        near = np.flatnonzero(np.abs(self.centres[:, axis] - level) < 0.012 * (high - low))
        u, v = (self.centres[near, k] - np.median(self.centres[near, k]) for k in range(3) if k != axis)
        sector = ((np.arctan2(v, u) / (2 * np.pi) + 0.5) * count).astype(int) % count
        radius = np.hypot(u, v)
        return [int(near[sector == s][radius[sector == s].argmax()]) for s in range(count) if (sector == s).any()]

    def panel(self, lines=(), picks=(), strip=None, with_edges=False, width=0.004) -> Panel:
        """Lines as (polyline or points, colour), picks as balls, triangles of a strip in colour."""
        tubes = []
        for line, colour in lines:
            points, closed = (line.points, line.closed) if hasattr(line, "points") else line
            tubes.append((points, closed, colour, width))
        balls = [(self.centres[pick], PICK, 2.2 * width) for pick in picks]
        coloured = [] if strip is None else [(STRIP, np.unique(strip))]
        return Panel(self.positions, self.triangles, coloured, tubes, balls, with_edges)

    def view(self, direction=FRONT_RIGHT, points=None, margin=1.15) -> View:
        """Of the whole mesh, or of some points."""
        return View(direction, np.zeros(3), 1.0).of_points(self.positions if points is None else points, margin)


def figure_3_11() -> Figure:
    """Picks, strip and first polyline; the smooth polyline."""
    s = Stage("spot.obj")
    picks = s.near((0.3, 0.0, 0.75), (0.4, 0.15, 0.2), (0.38, -0.15, -0.25), (0.25, 0.55, -0.35))
    start, line = (s.mesh.polyline(picks, filter=f) for f in ("none", "linear"))
    panels = [
        s.panel([(start, START)], picks, start.strip, True),
        s.panel([(line, LINE)], picks, line.strip, True),
    ]
    text = "Picked triangles (green), the strip that joins them and the polyline through its midpoints; then smoothed."
    view = s.view((1.0, 0.25, -0.25), start.points, 1.4)
    return Figure("figure_03_11", "Figures 3 and 11", text, s, panels, view, [("linear", 4, line)])


def _stages(s: Stage, picks: list[int], rounds: tuple[int, ...], **options: Any) -> tuple[list[np.ndarray], Any]:
    line = s.mesh.polyline(picks, stages=True, **options)
    stages = line.report.stages
    return [stages[min(i, len(stages) - 1)] for i in rounds], line


def figure_4() -> Figure:
    """Stages of smoothing, coarse mesh."""
    s = Stage("cow.off")
    picks = s.near((-0.35, 0.05, 0.12), (0.35, 0.12, 0.1))
    shown, line = _stages(s, picks, (0, 1, 2, 10**6), filter="linear", solver="heap")
    panels = [s.panel([((points, False), LINE)], picks, None, True) for points in shown]
    text = "Step B, one round of steps C and D, two rounds, and the end: the paper's filter and its own heap."
    view = s.view((0.1, 0.25, 1.0), shown[0], 1.3)
    return Figure("figure_04", "Figure 4", text, s, panels, view, [("linear, heap", 2, line)])


def figure_5() -> Figure:
    """Breaks of a drawn stroke, repaired."""
    s = Stage("bunny00.off")
    low, size = s.positions.min(axis=0), np.ptp(s.positions, axis=0)
    t = np.linspace(0, 1, 60)
    drawn = np.column_stack([0.18 + 0.62 * t, 0.30 + 0.12 * np.sin(7 * t), np.full(60, 1.0)]) * size + low
    drawn = drawn[(t < 0.28) | ((t > 0.45) & (t < 0.62)) | (t > 0.78)]
    drawn = s.mesh.ray_cast(drawn, np.tile([0.0, 0, -1], (len(drawn), 1)))
    points = drawn.points[np.isfinite(drawn.distances)]
    whole, smooth = (s.mesh.stroke(points, filter=f, **o) for f, o in (("none", {}), ("fair", {})))
    torn = s.panel()
    torn.balls = [(point, START, 0.006) for point in points]
    panels = [torn, s.panel([(whole, START)]), s.panel([(smooth, LINE)])]
    text = "A drawn stroke with gaps; joined on the surface; and smoothed by `fair`."
    view = s.view((0.0, 0.05, 1.0), points, 1.35)
    return Figure("figure_05", "Figure 5", text, s, panels, view, [("fair", len(points), smooth)], size=(380, 300, 3))


def figure_6() -> Figure:
    """Pinned picks and hints."""
    s = Stage("spot.obj")
    picks = s.near((0.3, 0.0, 0.8), (0.42, 0.25, 0.35), (0.4, -0.2, 0.0), (0.3, 0.25, -0.3))
    hints, pins = (s.mesh.polyline(picks, filter="linear", pinned=p) for p in ("ends", "all"))
    panels = [s.panel([(line, LINE)], picks, line.strip, True) for line in (hints, pins)]
    text = "The same picks: only the ends pinned, the others shape the strip; all pinned, the line goes through each."
    view = s.view((1.0, 0.25, 0.0), np.vstack([hints.points, pins.points]), 1.4)
    rows = [("linear, ends pinned", 4, hints), ("linear, all pinned", 4, pins)]
    return Figure("figure_06", "Figure 6", text, s, panels, view, rows)


def figure_7_16() -> Figure:
    """Three strips round an ear and between ear and horn."""
    s = Stage("spot.obj")
    # In front of the ear, over and under it, and between ear and horn; the far ends lie behind the head.
    pairs = [
        s.near((0.22, 0.70, -0.62), (0.25, 0.72, -0.25)),
        s.near((0.22, 0.58, -0.62), (0.25, 0.50, -0.25)),
        s.near((0.10, 0.82, -0.62), (0.12, 0.85, -0.25)),
    ]
    starts = [s.mesh.polyline(pair, filter="none") for pair in pairs]
    lines = [s.mesh.polyline(pair, filter="geodesic") for pair in pairs]
    picks = [pick for pair in pairs for pick in pair]
    panels = [
        s.panel([(line, START) for line in starts], picks, np.concatenate([x.strip for x in starts]), True),
        s.panel([(line, LINE) for line in lines], picks, np.concatenate([x.strip for x in lines]), True),
    ]
    text = "Three strips round an ear and between ear and horn, none of which jumps over one; smoothed by `geodesic`."
    view = s.view((1.0, 0.5, -0.55), np.vstack([x.points for x in starts]), 1.7)
    rows = [(f"geodesic {i + 1}", 2, line) for i, line in enumerate(lines)]
    return Figure("figure_07_16", "Figures 7 and 16", text, s, panels, view, rows)


def figure_9_10() -> Figure:
    """Both filters of the paper."""
    s = Stage("bunny00.off")
    low, size = s.positions.min(axis=0), np.ptp(s.positions, axis=0)
    across = np.linspace(0.15, 0.85, 7)
    seen = np.column_stack([across, 0.33 + 0.16 * (-1.0) ** np.arange(7), np.ones(7)]) * size + low
    picks = s.mesh.ray_cast(seen, np.tile([0.0, 0, -1], (7, 1))).triangles.tolist()
    start = s.mesh.polyline(picks, filter="none")
    linear = s.mesh.polyline(picks, filter="linear")
    cubic = s.mesh.polyline(picks, filter="cubic", threshold=1e-2)
    panels = [s.panel([(x, c)], picks, width=0.006) for x, c in ((start, START), (linear, LINE), (cubic, LINE))]
    text = "Before smoothing; the linear filter straightens; the cubic filter keeps the shape and removes small detail."
    view = s.view((0.0, 0.05, 1.0), start.points, 1.3)
    rows = [("linear", len(picks), linear), ("cubic 1e-2", len(picks), cubic)]
    return Figure("figure_09_10", "Figures 9 and 10", text, s, panels, view, rows, size=(380, 360, 3))


def figure_12() -> Figure:
    """Topological steps: the strip passes to the other side of mesh vertices."""
    s = Stage("cow.off")
    picks = s.near((-0.1, 0.10, 0.12), (0.2, 0.0, 0.12))
    first = s.mesh.polyline(picks, filter="linear", solver="heap", max_iterations=1)
    last = s.mesh.polyline(picks, filter="geodesic")
    start = s.mesh.polyline(picks, filter="none")
    panels = [s.panel([(x, LINE)], picks, x.strip, True, 0.005) for x in (start, first, last)]
    text = "The strip of step B; after one round; after the last, where it passes vertices on their other side."
    view = s.view((0.1, 0.25, 1.0), start.points, 1.35)
    rows = [("linear, heap, 1 round", 2, first), ("geodesic", 2, last)]
    return Figure("figure_12", "Figure 12", text, s, panels, view, rows, size=(380, 300, 3))


def figure_13() -> Figure:
    """A loop that smoothing would make is cut out."""
    best = None
    for name in ("cow.off", "spot.obj", "camel.off"):
        s = Stage(name)
        rng = np.random.default_rng(13)
        for _ in range(150):
            picks = rng.integers(len(s.triangles), size=3).tolist()
            try:
                line = s.mesh.polyline(picks, filter="geodesic")
            except sp.Error:
                continue
            if line.report.loops_removed > 0:
                start = s.mesh.polyline(picks, filter="none")
                best = best or (s, picks, start, line)
        if best:
            break
    s, picks, start, line = best
    panels = [
        s.panel([(start, START)], picks, start.strip, True),
        s.panel([(line, LINE)], picks, line.strip, True),
    ]
    removed = line.report.loops_removed
    text = f"A way by a pick that is a hint; while it is smoothed {removed} loop(s) of the strip arise and are cut out."
    normal = np.cross(*np.diff(s.positions[s.triangles[picks[1]]], axis=0))
    view = s.view(tuple(normal / np.linalg.norm(normal) + [0, 0.2, 0]), start.points, 1.2)
    return Figure("figure_13", "Figure 13", text, s, panels, view, [("geodesic", 3, line)])


def figure_14_15() -> Figure:
    """A closed curve through 30 picks of a scan."""
    s = Stage("igea.ply")
    picks = s.ring(30, 1, 0.55)
    start = s.mesh.polyline(picks, filter="none", closed=True)
    cubic = s.mesh.polyline(picks, filter="cubic", closed=True, threshold=1e-2)
    panels = [s.panel([(x, c)], picks, width=0.003) for x, c in ((start, START), (cubic, LINE))]
    text = "A closed curve by 30 picks on a scan: before, and with the cubic filter."
    paper = "274 120 triangles, 30 picks: strip in less than 0.5 s, optimised in less than 5 s, at 1 GHz"
    view = s.view((0.5, 0.35, 1.0))
    rows = [("cubic 1e-2, closed", len(picks), cubic)]
    return Figure("figure_14_15", "Figures 14 and 15", text, s, panels, view, rows, paper)


def figure_17() -> Figure:
    """Stages of smoothing on a dense mesh."""
    s = Stage("bunny00.off")
    low, size = s.positions.min(axis=0), np.ptp(s.positions, axis=0)
    places = (low + size * p for p in ((0.15, 0.25, 0.9), (0.45, 0.5, 1.0), (0.85, 0.25, 0.8)))
    picks = s.near(*places)
    shown, line = _stages(s, picks, (0, 1, 3, 10**6), filter="cubic", threshold=1e-3)
    panels = [s.panel([((points, False), LINE)], picks) for points in shown]
    text = "Stages of the cubic filter: step B, after one round, after three, and the end."
    view = s.view((0.0, 0.2, 1.0), shown[0], 1.3)
    rows = [("cubic 1e-3", 3, line)]
    return Figure("figure_17", "Figure 17", text, s, panels, view, rows, size=(440, 340, 2))


def figure_18() -> Figure:
    """A net of 19 lines on 10 picks that parts the surface into patches."""
    s = Stage("spot.obj")
    picks = s.spread(10, s.near((0.0, 0.2, -0.6))[0])
    whole = s.mesh.network(picks, "automatic", filter="linear")
    order = sorted((line for line in whole if line), key=lambda line: line.length)[:19]
    pairs = [[_end(s, picks, line, 0), _end(s, picks, line, -1)] for line in order]
    net = s.mesh.network(picks, pairs, filter="linear", avoid_crossings=True)
    patches = net.patches()
    cut, lines = patches.cut, [line for line in net if line]
    panel = Panel(cut.positions, cut.triangles, [], [], [(s.centres[p], PICK, 0.012) for p in picks])
    for patch in range(len(patches)):
        colour = PATCHES[patch % len(PATCHES)]
        panel.coloured.append((colour, np.flatnonzero(patches.triangle_patches == patch)))
    panel.lines = [(line.points, False, (0.1, 0.1, 0.12), 0.003) for line in lines]
    views = [s.panel([(line, LINE) for line in lines], picks), panel]
    text = f"A net of {len(lines)} lines on 10 picks parts the surface into {len(patches)} patches, one colour each."
    longest = max(lines, key=lambda line: line.length)
    rows = [("linear, the longest line", 2, longest)]
    return Figure("figure_18", "Figure 18", text, s, views, s.view(), rows, "10 picks, 19 curves")


def _end(s: Stage, picks: list[int], line: Any, place: int) -> int:
    """Which pick an end of a line is at."""
    return int(np.linalg.norm(s.centres[picks] - line.points[place], axis=1).argmin())


FIGURES = (
    figure_3_11, figure_4, figure_5, figure_6, figure_7_16, figure_9_10, figure_12, figure_13, figure_14_15, figure_17,
    figure_18,
)  # fmt: skip
