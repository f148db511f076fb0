"""Hostile meshes: a line that keeps every promise, or a named error; nothing hangs, nothing panics."""

import itertools

import numpy as np
import pytest

import smooth_polylines as sp
from native.invariants import SurfaceChecker
from native.made_meshes import make_fan, make_grid, make_irregular_square, make_sphere
from native.surfaces import HOSTILE, open_surface

FILTERS = ("none", "linear", "cubic", "geodesic", "fair")
NAMED = (sp.NoPathError, sp.CollapsedError, sp.OptionError)


def try_everything(positions, triangles, picks, checker=None):
    """All filters, open and closed, ends and all pinned; returns how many lines and how many errors there were."""
    mesh = sp.SurfaceMesh(positions, triangles)
    checker = checker or SurfaceChecker(positions, triangles)
    lines, errors = 0, 0
    for filter_name, closed, pinned in itertools.product(FILTERS, (False, True), ("ends", "all")):
        try:
            line = mesh.polyline(picks, filter=filter_name, closed=closed, pinned=pinned)
        except NAMED:
            errors += 1
            continue
        lines += 1
        pins = None
        if pinned == "all":
            pins = [(int(t), [1 / 3] * 3) for t in picks]
        elif closed:
            pins = []
        checker.check(line, pins=pins)
        assert line.report.stop_reason in ("converged", "converged_at_vertices", "cycle", "max_iterations")
    return lines, errors


@pytest.mark.parametrize("name", HOSTILE)
def test_random_picks_anywhere_on_a_hostile_mesh(name):
    surface = open_surface(name)
    rng = np.random.default_rng(81)
    lines = 0
    for count in (2, 4):
        picks = rng.choice(len(surface.triangles), min(count, len(surface.triangles)), replace=False).tolist()
        lines += try_everything(surface.positions, surface.triangles, picks, surface.checker)[0]
    if name not in ("fan3.obj",):
        picks = surface.random_picks(2, 82)
        lines += try_everything(surface.positions, surface.triangles, picks, surface.checker)[0]
        assert lines > 0


@pytest.mark.parametrize("name", HOSTILE)
def test_neighbours_equal_and_dead_end_picks_on_a_hostile_mesh(name):
    surface = open_surface(name)
    part = surface.largest_part
    rng = np.random.default_rng(83)
    for triangle in rng.choice(part, min(3, len(part)), replace=False).tolist():
        row = surface.dual_graph[triangle].indices.tolist() + surface.dual_graph.T.tocsr()[triangle].indices.tolist()
        for other in row:
            try_everything(surface.positions, surface.triangles, [triangle, other, triangle], surface.checker)


def make_doubled_sheet():
    """Two squares at the same place, joined along one side: barycentres coincide."""
    positions, triangles = make_grid(4)
    left = positions[:, 0] == 0
    copy = np.arange(len(positions)) + len(positions)
    copy[left] = np.flatnonzero(left)
    return np.vstack([positions, positions]), np.vstack([triangles, copy[triangles[:, ::-1]]])


def make_klein_bottle(n=12):
    u, v = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    a, b = 2 * np.pi * u / n, 2 * np.pi * v / n
    ring = 2 + np.cos(a / 2) * np.sin(b) - np.sin(a / 2) * np.sin(2 * b)
    positions = np.stack(
        [ring * np.cos(a), ring * np.sin(a), np.sin(a / 2) * np.sin(b) + np.cos(a / 2) * np.sin(2 * b)], axis=-1
    ).reshape(-1, 3)
    at = lambda i, j: (i % n) * n + ((j if i < n else -j) % n)  # noqa: E731
    triangles = []
    for i, j in itertools.product(range(n), range(n)):
        corners = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
        triangles += [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
    return positions, np.array(triangles)


def make_checkerboard():
    """Squares with holes between: neighbours touch at corners only, and are joined through every other row."""
    positions, triangles = make_grid(9)
    cell = np.repeat(np.arange(81), 2)
    keep = ~((cell // 9 % 3 == 1) & (cell % 3 == 1))
    return positions, triangles[keep]


def scale_axis(mesh, axis, factor):
    positions, triangles = mesh
    positions = positions.copy()
    positions[:, axis] *= factor
    return positions, triangles


def collapse_some(mesh, seed):
    """Some vertices moved onto a neighbour: coincident vertices and triangles without area."""
    positions, triangles = mesh
    positions = positions.copy()
    for triangle in triangles[np.random.default_rng(seed).choice(len(triangles), len(triangles) // 12, replace=False)]:
        positions[triangle[0]] = positions[triangle[1]]
    return positions, triangles


MADE = {
    "doubled sheet": make_doubled_sheet,
    "klein bottle": make_klein_bottle,
    "checkerboard": make_checkerboard,
    "closed fan of 3": lambda: make_fan(3, height=0.5),
    "closed fan of 2000": lambda: make_fan(2000, height=0.5),
    "open fan of 300": lambda: make_fan(300, closed=False),
    "flat fan of 7": lambda: make_fan(7),
    "strip": lambda: make_grid(40, 1),
    "needles": lambda: scale_axis(make_irregular_square(150, 6), 1, 1e-8),
    "all in one line": lambda: scale_axis(make_irregular_square(60, 6), 1, 0.0),
    "all in one point": lambda: (make_grid(4)[0] * 0.0, make_grid(4)[1]),
    "tiny": lambda: (make_sphere(2)[0] * 1e-6, make_sphere(2)[1]),
    "denormal": lambda: (make_sphere(1)[0] * 1e-310, make_sphere(1)[1]),
    "huge": lambda: (make_sphere(2)[0] * 1e150, make_sphere(2)[1]),
    "far away": lambda: (make_sphere(2)[0] + 1e6, make_sphere(2)[1]),
    "coincident": lambda: collapse_some(make_irregular_square(150, 8), 8),
    "coincident sphere": lambda: collapse_some(make_sphere(2), 9),
    "tetrahedron": lambda: (
        np.vstack([np.zeros(3), np.eye(3)]),
        np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]),
    ),
    "pillow": lambda: (np.eye(3), np.array([[0, 1, 2], [2, 1, 0]])),
    "the same triangle thrice": lambda: (np.eye(3), np.array([[0, 1, 2]] * 3)),
}


@pytest.mark.parametrize("name", MADE)
def test_a_made_hostile_mesh_gives_lines_or_named_errors(name):
    positions, triangles = MADE[name]()
    checker = SurfaceChecker(positions, triangles)
    rng = np.random.default_rng(84)
    for count in (2, 2, 3, 5):
        picks = rng.choice(len(triangles), min(count, len(triangles)), replace=False).tolist()
        try_everything(positions, triangles, picks, checker)


def test_coordinates_whose_squares_overflow_neither_hang_nor_panic():
    positions, triangles = make_sphere(2)
    try:
        mesh = sp.SurfaceMesh(positions * 1e300, triangles)
    except sp.MeshError:
        return
    for filter_name, closed in itertools.product(FILTERS, (False, True)):
        try:
            line = mesh.polyline([3, 100, 250], filter=filter_name, closed=closed, pinned="all")
        except NAMED:
            continue
        assert np.isfinite(line.points).all()


@pytest.mark.parametrize("seed", range(12))
def test_random_soups_give_lines_or_named_errors(seed):
    """Random triangles on few random vertices: walls, pinches, repeated and overlapping triangles everywhere."""
    rng = np.random.default_rng(seed)
    vertices = int(rng.integers(4, 30))
    triangles = np.array([rng.choice(vertices, 3, replace=False) for _ in range(int(rng.integers(1, 2 * vertices)))])
    # Rounded to a coarse lattice: coincident vertices and zero areas are common.
    positions = np.round(rng.standard_normal((vertices, 3)), int(rng.integers(0, 3)))
    checker = SurfaceChecker(positions, triangles)
    for _ in range(6):
        picks = rng.choice(len(triangles), min(len(triangles), 4)).tolist()
        distinct = [p for i, p in enumerate(picks) if i == 0 or p != picks[i - 1]]
        try_everything(positions, triangles, distinct, checker)
