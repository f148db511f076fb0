"""Strokes, and closest points against asking every triangle: in the plane, on a sphere, on scans, and their laws."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import smooth_polylines as sp
from native.invariants import same_line
from native.made_meshes import make_grid, make_sphere
from native.surfaces import open_surface

FILTERS = ["none", "linear", "cubic", "geodesic", "fair"]


def distances_to_triangles(points, corners):
    """(N, F) distances by trying the inside, the three edges and the three corners of every triangle."""
    a, b, c = (corners[None, :, k] for k in range(3))
    p = points[:, None]

    def to_segment(a, b):
        along = b - a
        square = (along**2).sum(-1)
        t = np.clip(((p - a) * along).sum(-1) / np.where(square > 0, square, 1), 0, 1)
        return np.linalg.norm(p - a - t[..., None] * along, axis=-1)

    best = np.minimum(np.minimum(to_segment(a, b), to_segment(b, c)), to_segment(c, a))
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=-1)
    inner = [(np.cross(v - u, p - u) * normal).sum(-1) > 0 for u, v in ((a, b), (b, c), (c, a))]
    above = np.abs(((p - a) * normal).sum(-1)) / np.where(size > 0, size, 1)
    return np.where(inner[0] & inner[1] & inner[2] & (size > 0), above, best)


@pytest.mark.parametrize("name", ["terrain", "torus", "cow.off", "tray_cad.off", "thingi_79741.off"])
def test_closest_points_against_every_triangle(name):
    surface = open_surface(name)
    rng = np.random.default_rng(4)
    size = surface.diagonal
    scales = rng.choice([0.0, 0.01, 0.2, 2.0], (60, 1)) * size
    points = surface.positions[rng.integers(0, len(surface.positions), 60)] + scales * rng.normal(size=(60, 3))
    found = surface.mesh.closest_points(points)
    corners = surface.positions[surface.triangles]
    expected = distances_to_triangles(points, corners).min(axis=1)
    np.testing.assert_allclose(found.distances, expected, rtol=1e-9, atol=1e-13 * size)
    assert found.points.shape == found.barycentric.shape == (60, 3)
    assert found.triangles.dtype == np.int32
    again = (found.barycentric[:, :, None] * corners[found.triangles]).sum(axis=1)
    np.testing.assert_allclose(found.points, again, rtol=0, atol=1e-13 * size)
    np.testing.assert_allclose(np.linalg.norm(found.points - points, axis=1), found.distances, rtol=1e-12, atol=0)
    assert [(p.triangle, p.barycentric) for p in found.surface_points] == [
        (t, tuple(b)) for t, b in zip(found.triangles.tolist(), found.barycentric.tolist(), strict=True)
    ]


def test_closest_points_on_vertices_and_edges_are_there_exactly():
    mesh = sp.SurfaceMesh(*make_sphere(3))
    found = mesh.closest_points(2.0 * mesh.positions)
    assert (np.sort(found.barycentric, axis=1) == [0, 0, 1]).all()
    assert (found.points == mesh.positions).all()
    lowest = np.full(len(mesh.positions), len(mesh.triangles))
    np.minimum.at(lowest, mesh.triangles, np.arange(len(mesh.triangles))[:, None].repeat(3, axis=1))
    assert (found.triangles == lowest).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64, ">f8"])
def test_closest_points_of_any_layout(dtype):
    mesh = sp.SurfaceMesh(*make_grid(4))
    points = np.array([[0.25, 0.5, 1.0], [0.5, 0.125, -2.0]])
    expected = mesh.closest_points(points)
    for given_points in (points.astype(dtype), np.asfortranarray(points.astype(dtype)), points.astype(dtype)[::1]):
        found = mesh.closest_points(given_points)
        assert (found.triangles == expected.triangles).all()
        assert (found.distances == [1.0, 2.0]).all()
    assert len(mesh.closest_points(np.zeros((0, 3)))) == 0


@pytest.mark.parametrize("call", ["stroke", "closest_points"])
def test_wrong_points_are_refused_by_name(call):
    mesh = sp.SurfaceMesh(*make_grid(4))
    ask = getattr(mesh, call)
    for wrong in (np.nan, np.inf, 1e160):
        with pytest.raises(sp.OptionError, match=r"^points: row 1 is \[0\.0, .*expected three finite numbers"):
            ask(np.array([[0, 0, 0], [0, wrong, 0]], float))
    for wrong in (np.zeros((3, 2)), np.zeros((2, 3), int), np.zeros((1, 2, 3))):
        with pytest.raises(TypeError, match=r"^points: has (shape|dtype)"):
            ask(wrong)
    for wrong in (None, "points"):
        with pytest.raises(TypeError, match=r"^points: found "):
            ask(wrong)
    with pytest.raises(sp.OptionError, match=r"^points: the mesh has no triangles"):
        getattr(sp.SurfaceMesh(np.zeros((0, 3)), np.zeros((0, 3), int)), call)(np.zeros((2, 3)))


def test_wrong_picks_of_a_stroke_are_called_points():
    mesh = sp.SurfaceMesh(*make_grid(4))
    with pytest.raises(sp.OptionError, match=r"^points: point 1 is triangle 99"):
        mesh.stroke([0, 99])
    with pytest.raises(sp.OptionError, match=r"^points: found none"):
        mesh.stroke([])
    with pytest.raises(TypeError, match=r"^points: entry 1 is of type str"):
        mesh.stroke([0, "1"])
    with pytest.raises(sp.OptionError, match=r"^pinned: found 1 flags for 2 points"):
        mesh.stroke([0, 5], pinned=[True])
    with pytest.raises(sp.OptionError, match=r"^points: a closed line needs at least 3 different points, found 2"):
        mesh.stroke([0, 5], closed=True)


@pytest.mark.parametrize("filter_name", FILTERS)
def test_every_form_of_points_gives_one_line(filter_name):
    surface = open_surface("terrain")
    rng = np.random.default_rng(3)
    places = np.linspace([0.1, 0.2, 0], [0.9, 0.7, 0], 60) + 0.01 * rng.normal(size=(60, 3))
    line = surface.mesh.stroke(places, filter=filter_name)
    surface.checker.check(line)
    assert same_line(line, surface.mesh.stroke(places.tolist(), filter=filter_name))
    found = surface.mesh.closest_points(places)
    assert same_line(line, surface.mesh.stroke(found.surface_points, filter=filter_name))
    pairs = list(zip(found.triangles.tolist(), found.barycentric.tolist(), strict=True))
    assert same_line(line, surface.mesh.stroke(pairs, filter=filter_name))
    assert line.report.stroke_distance == found.distances.max()
    assert same_line(line, surface.mesh.line_from_bytes(line.to_bytes()))


def test_an_array_of_face_ids_is_a_stroke_of_faces():
    surface = open_surface("terrain")
    ids = surface.mesh.polyline([5, 900], filter="none").strip
    line = surface.mesh.stroke(ids, filter="none")
    assert (line.strip[[0, -1]] == [5, 900]).all()
    assert line.report.stroke_distance == 0.0
    surface.checker.check(line)


@pytest.mark.parametrize("count", [3, 40, 3000])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_circle_on_a_sphere(count, noise):
    mesh = sp.SurfaceMesh(*make_sphere(4))
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    rng = np.random.default_rng(7)
    points = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)]) + noise * rng.normal(size=(count, 3))
    raw = mesh.stroke(points, closed=True, filter="none")
    assert raw.report.stroke_breaks == 0
    # A great circle; noise makes it longer.
    assert raw.length > 6.2
    if noise == 0:
        assert raw.length < 2 * math.pi
        # The plane of a walk is upright on its ends' triangles, not on the sphere.
        assert np.abs(raw.points[:, 2]).max() < 1e-3 or count == 3
    open_line = mesh.stroke(points, filter="none")
    assert open_line.length < raw.length


def test_a_jump_to_another_sheet_is_a_break():
    """Two parallel squares, joined along one side: between them step B goes round by the fold."""
    flat, triangles = make_grid(12)
    upper = flat + np.array([0, 0, 0.05])
    hinge = np.flatnonzero(flat[:, 0] == 0)
    hinge = hinge[np.argsort(flat[hinge, 1])]
    n = len(flat)
    fold = [t for a, b in pairwise(hinge) for t in ((a, b, n + b), (a, n + b, n + a))]
    mesh = sp.SurfaceMesh(np.vstack([flat, upper]), np.vstack([triangles, triangles + n, fold]))
    points = np.array([[0.5, 0.31, 0.0], [0.6, 0.33, 0.0], [0.6, 0.33, 0.04], [0.7, 0.35, 0.05]])
    line = mesh.stroke(points, filter="none")
    assert line.report.stroke_breaks == 1
    assert line.report.pops > 0
    assert line.length > 1.2
    assert line.report.stroke_distance == pytest.approx(0.01)


@pytest.mark.parametrize("filter_name", FILTERS)
def test_a_stroke_on_a_scan(filter_name):
    surface = open_surface("igea.ply")
    low, high = surface.positions.min(axis=0), surface.positions.max(axis=0)
    angle = np.linspace(0.3, 2.0, 2000)
    ray = np.column_stack([np.cos(angle), 0.2 * np.sin(9 * angle), np.sin(angle)])
    points = surface.mesh.closest_points((low + high) / 2 + 0.5 * (high - low) * ray).points
    rng = np.random.default_rng(1)
    points = points + 1e-4 * rng.normal(size=points.shape)
    line = surface.mesh.stroke(points, filter=filter_name, threshold=1e-2)
    surface.checker.check(line)
    assert line.report.stroke_distance < 1e-3
    if filter_name == "none":
        near = surface.mesh.closest_points(points).points
        # No crossing is farther from the stroke than its points are from each other, and an edge's length.
        steps = np.linalg.norm(np.diff(near, axis=0), axis=1).max()
        gaps = np.linalg.norm(line.points[:, None] - near[None], axis=2).min(axis=1)
        assert gaps.max() < steps + 1e-3
        assert line.report.stroke_breaks < 10


@pytest.mark.parametrize("filter_name", FILTERS)
def test_a_stroke_of_one_place_is_a_point(filter_name):
    line = sp.SurfaceMesh(*make_grid(4)).stroke([[0.3, 0.4, 0.2]] * 5, filter=filter_name)
    assert (len(line.points), line.length, line.report.stop_reason) == (1, 0.0, "converged")


points_strategy = st.lists(
    st.tuples(*[st.floats(-0.2, 1.2) for _ in range(2)], st.floats(-0.5, 0.5)), min_size=1, max_size=30
)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(points=points_strategy, filter_name=st.sampled_from(FILTERS))
def test_laws_of_any_stroke(points, filter_name):
    surface = open_surface("terrain")
    points = np.array(points)
    line = surface.mesh.stroke(points, filter=filter_name, threshold=1e-2)
    surface.checker.check(line)
    found = surface.mesh.closest_points(points)
    # It runs from the first point to the last.
    assert (line.points[0] == found.points[0]).all()
    assert (line.points[-1] == found.points[-1]).all()
    # Points that are given twice in a row count once.
    assert same_line(line, surface.mesh.stroke(points.repeat(2, axis=0), filter=filter_name, threshold=1e-2))
    # A stroke of points that lie on the surface is kept.
    assert surface.mesh.closest_points(found.points).distances.max() < 1e-14


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    start=st.tuples(*[st.floats(0.01, 0.99)] * 2),
    end=st.tuples(*[st.floats(0.01, 0.99)] * 2),
    count=st.integers(2, 400),
)
def test_a_straight_stroke_in_the_plane_is_straight(start, end, count):
    surface = open_surface("irregular square")
    points = np.column_stack([np.linspace(start, end, count), np.zeros(count)])
    line = surface.mesh.stroke(points, filter="none")
    assert line.length == pytest.approx(math.dist(start, end), rel=1e-9, abs=1e-12)
    assert line.report.stroke_breaks == 0


STROKE_COUNTERS = ("stroke_breaks", "pops", "strip_triangles", "iterations", "moves", "vertex_passes")
COUNTED = [
    ("none", (0, 0, 121, 0, 0, 0)),
    ("geodesic", (0, 0, 121, 6, 0, 21)),
    ("cubic", (0, 0, 121, 2, 811, 0)),
]


@pytest.mark.parametrize(("filter_name", "expected"), COUNTED)
def test_a_stroke_takes_the_counted_work(filter_name, expected):
    mesh = open_surface("cow.off").mesh
    points = mesh.positions[mesh.triangles[mesh.polyline([4861, 1518], filter="none").strip]].mean(axis=1)
    report = mesh.stroke(points[::3], filter=filter_name, threshold=1e-2).report
    assert tuple(getattr(report, name) for name in STROKE_COUNTERS) == expected
