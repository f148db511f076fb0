"""Lines put into the mesh: what a cut promises, judged by an independent checker, on real and made meshes."""

import functools

import numpy as np
import pytest

import meshes
import smooth_polylines as sp
from native.cut_checker import CutChecker, faces_by_line
from native.made_meshes import make_grid, make_sphere, make_torus
from native.surfaces import open_surface

FILTERS = ["none", "linear", "cubic", "geodesic", "fair"]
# One each, for the time it takes.
TOLERANCES = {"none": [1e-3], "linear": [1e-3, 0.0], "cubic": [0.1], "geodesic": [0.0, 0.1], "fair": [1e-3]}


@functools.cache
def open_for_cuts(name, with_faces):
    """The mesh, its checker, and triangles to pick from its largest part."""
    surface = open_surface(name)
    faces = None
    if with_faces:
        faces = meshes.load_shared_mesh(name).triangle_faces
    mesh = sp.SurfaceMesh(surface.positions, surface.triangles, faces)
    return mesh, CutChecker(surface.positions, surface.triangles, faces), surface


def as_points(triangles):
    return [(int(t), [0.3, 0.3, 0.4]) for t in triangles]


def make_lines(mesh, surface, filter_name, seed, count=3):
    """Random lines: open through two to five picks, and a closed one where it can be had."""
    rng = np.random.default_rng(seed)
    lines = []
    for i in range(count):
        picks = as_points(rng.choice(surface.largest_part, min(2 + i, len(surface.largest_part)), replace=False))
        lines.append(mesh.polyline(picks, filter=filter_name, pinned="all" if i % 2 else "ends"))
    try:
        picks = as_points(rng.choice(surface.largest_part, min(5, len(surface.largest_part)), replace=False))
        lines.append(mesh.polyline(picks, closed=True, filter=filter_name, pinned="all"))
    except (sp.CollapsedError, sp.OptionError):
        pass
    return lines


@pytest.mark.parametrize("filter_name", FILTERS)
@pytest.mark.parametrize(
    ("name", "with_faces"),
    [
        ("terrain", False),
        ("sphere", False),
        ("fan3.obj", False),
        ("hourglass_ico.obj", False),
        ("triple_vierbein.obj", False),
        ("moebius.obj", False),
        ("suzanne.obj", False),
        ("suzanne.obj", True),
        ("spot.obj", True),
        ("openscad_crash.obj", False),
        ("tray_cad.off", False),
        ("truck_nm.obj", False),
        ("cow.off", False),
        ("fertility.off", False),
        ("shark_holes.off", False),
    ],
)
def test_random_lines_cut_together(name, with_faces, filter_name):
    mesh, checker, surface = open_for_cuts(name, with_faces)
    lines = make_lines(mesh, surface, filter_name, 11)
    for tolerance in TOLERANCES[filter_name]:
        checker.check(mesh.cut(lines, tolerance), lines, tolerance)


def label_sizes(cut):
    count, labels = faces_by_line(cut.triangles, cut.line_edges)
    return count, sorted(np.bincount(labels).tolist())


def test_a_closed_line_parts_a_sphere_in_two():
    positions, triangles = make_sphere(3)
    mesh = sp.SurfaceMesh(positions, triangles)
    angles = np.linspace(0, 2 * np.pi, 7)[:-1]
    around = mesh.closest_points(np.column_stack([np.cos(angles), np.sin(angles), np.full(6, 0.31)]))
    line = mesh.polyline(around.surface_points, closed=True, filter="fair", pinned="all")
    cut = line.cut()
    CutChecker(positions, triangles).check(cut, [line], 1e-3)
    count, labels = faces_by_line(cut.triangles, cut.line_edges)
    assert count == 2
    # Above the line and below it, exactly.
    chain = cut.positions[cut.line_vertices[0]]
    for label in range(2):
        rows = cut.triangles[labels == label]
        off = np.setdiff1d(rows, cut.line_vertices[0])
        above = cut.positions[off][:, 2] > np.median(chain[:, 2])
        assert above.mean() in (0.0, 1.0) or abs(above.mean() - round(above.mean())) < 0.02


@pytest.mark.parametrize(("around_tube", "parts"), [([True], 1), ([False], 1), ([True, True], 2), ([True, False], 1)])
def test_a_torus_is_parted_as_its_loops_say(around_tube, parts):
    positions, triangles = make_torus(30, 16)
    mesh = sp.SurfaceMesh(positions, triangles)
    lines = []
    for i, is_meridian in enumerate(around_tube):
        t = np.linspace(0, 2 * np.pi, 7)[:-1]
        u, v = (np.full(6, 0.3 + 2 * i), t) if is_meridian else (t, np.full(6, 0.4))
        ring = 1 + 0.4 * np.cos(v)
        at = mesh.closest_points(np.column_stack([ring * np.cos(u), ring * np.sin(u), 0.4 * np.sin(v)]))
        lines.append(mesh.polyline(at.surface_points, closed=True, filter="geodesic", pinned="all"))
    cut = mesh.cut(lines)
    CutChecker(positions, triangles).check(cut, lines, 1e-3)
    assert label_sizes(cut)[0] == parts


def make_cross(columns):
    """Two lines over a square that cross in the middle of a cell."""
    positions, triangles = make_grid(columns)
    faces = np.arange(len(triangles)) // 2
    mesh = sp.SurfaceMesh(positions, triangles, faces)
    ends = mesh.closest_points([[0, 0.31, 0], [1, 0.52, 0], [0.37, 0, 0], [0.58, 1, 0.0]]).surface_points
    lines = [mesh.polyline(ends[:2], filter="geodesic"), mesh.polyline(ends[2:], filter="geodesic")]
    return mesh, CutChecker(positions, triangles, faces), lines


@pytest.mark.parametrize("columns", [1, 2, 5, 8])
def test_two_lines_that_cross_part_a_square_in_four(columns):
    mesh, checker, lines = make_cross(columns)
    cut = mesh.cut(lines)
    count, labels = checker.check(cut, lines, 1e-3)
    assert count == 4
    # The four corners of the square are in four parts.
    corners = [0, columns, len(mesh.positions) - 1 - columns, len(mesh.positions) - 1]
    assert len({labels[(cut.triangles == c).any(axis=1)][0] for c in corners}) == 4


def test_polygons_stay_few():
    """A straight line through quads makes two of each that it crosses; an end inside one takes one edge more."""
    mesh, checker, lines = make_cross(6)
    cut = lines[0].cut()
    checker.check(cut, lines[:1], 1e-3)
    pieces = np.bincount(cut.polygon_parents)
    crossed = {int(checker.faces[t]) for t in lines[0].segment_triangles}
    assert all(pieces[face] == 2 for face in crossed)
    assert pieces.sum() == 36 + len(crossed)
    # From the middle of a quad to the middle of another.
    short = mesh.polyline([(12, [0.2, 0.3, 0.5]), (42, [0.2, 0.3, 0.5])], filter="geodesic")
    cut = short.cut()
    checker.check(cut, [short], 1e-3)
    crossed = {int(checker.faces[t]) for t in short.segment_triangles}
    assert np.bincount(cut.polygon_parents).sum() == 36 + len(crossed)


def test_a_closed_line_inside_one_triangle():
    positions, triangles = make_grid(1)
    for faces in (None, np.zeros(2, int)):
        mesh = sp.SurfaceMesh(positions, triangles, faces)
        picks = [(0, b) for b in ([0.2, 0.6, 0.2], [0.2, 0.2, 0.6], [0.6, 0.2, 0.2])]
        line = mesh.polyline(picks, closed=True, filter="linear", pinned="all")
        cut = line.cut()
        count, _ = CutChecker(positions, triangles, faces).check(cut, [line], 1e-3)
        assert count == 2
        if faces is not None:
            assert len(cut.polygon_parents) == 3


def test_a_line_along_edges_adds_no_vertex_and_parts_quads_along_their_diagonals():
    positions, triangles = make_grid(4)
    faces = np.arange(len(triangles)) // 2
    mesh = sp.SurfaceMesh(positions, triangles, faces)
    line = mesh.polyline([(0, [1, 0, 0]), (31, [0, 1.0, 0])], filter="geodesic")
    assert np.allclose(line.points[:, 0], line.points[:, 1])
    cut = line.cut()
    count, _ = CutChecker(positions, triangles, faces).check(cut, [line], 1e-3)
    assert (len(cut.positions), count, len(cut.polygon_parents)) == (25, 2, 20)


def test_an_edge_crossed_a_hundred_times():
    positions = np.array([[0.0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, -1, 0]])
    triangles = np.array([[0, 1, 2], [1, 0, 3]])
    mesh = sp.SurfaceMesh(positions, triangles)
    x = np.linspace(0.05, 0.95, 101)
    # Up and down: barycentric parts of a point (x, +-h).
    picks = [
        (i % 2, [1 - a - 0.025, a - 0.025, 0.05] if i % 2 == 0 else [a - 0.025, 1 - a - 0.025, 0.05])
        for i, a in enumerate(x)
    ]
    line = mesh.polyline(picks, filter="geodesic", pinned="all")
    cut = line.cut()
    count, _ = CutChecker(positions, triangles).check(cut, [line], 1e-3)
    assert (cut.vertex_edges[:, 0] == 0).sum() == 100
    # Between two crossings the line and the edge enclose nothing that is cut off: no part is closed.
    assert count == 1


def test_many_lines_through_one_triangle():
    rng = np.random.default_rng(3)
    positions = np.array([[0.0, 0, 0], [1, 0, 0], [0.2, 0.9, 0.1]])
    triangles = np.array([[0, 1, 2]])
    mesh = sp.SurfaceMesh(positions, triangles)
    lines = []
    for _ in range(40):
        ends = rng.dirichlet([1, 1, 1], 2)
        ends[rng.random((2, 3)) < 0.2] = 0.0
        ends /= ends.sum(axis=1, keepdims=True)
        lines.append(mesh.polyline([(0, e) for e in ends], filter="linear"))
    for tolerance in (0.0, 1e-3, 0.03):
        cut = mesh.cut(lines, tolerance)
        CutChecker(positions, triangles).check(cut, lines, tolerance)
        assert cut.largest_move <= 6 * tolerance + 1e-11


@pytest.mark.parametrize("tolerance", [0.01, 0.03, 0.1, 0.25])
def test_crowded_lines_leave_no_sliver(tolerance):
    """Sixteen lines over two triangles: everything is apart by the tolerance, and nothing has moved far."""
    rng = np.random.default_rng(1)
    positions = np.array([[0.0, 0, 0], [1, 0, 0], [0.2, 0.9, 0.1], [1.1, 1, 0]])
    triangles = np.array([[0, 1, 2], [1, 3, 2]])
    mesh = sp.SurfaceMesh(positions, triangles)
    checker = CutChecker(positions, triangles)
    inner, moves = 0, []
    for _ in range(16):
        ends = rng.dirichlet([1, 1, 1], 32)
        ends[::4, 0] = 0
        ends /= ends.sum(axis=1, keepdims=True)
        picks = [(int(rng.integers(2)), end) for end in ends]
        lines = [mesh.polyline(picks[i : i + 2], filter="geodesic") for i in range(0, 32, 2)]
        cut = mesh.cut(lines, tolerance)
        checker.check(cut, lines, tolerance)
        inner += int((cut.vertex_barycentric > 0).all(axis=1).sum())
        moves.append(cut.largest_move / tolerance)
    assert inner > (0 if tolerance == 0.25 else 100)
    assert max(moves) < 4


def test_what_cannot_be_cut_is_refused_by_name():
    mesh, _, lines = make_cross(2)
    other, _, _ = make_cross(2)
    with pytest.raises(sp.OptionError, match=r"^lines: line 1 was made on another mesh"):
        mesh.cut([lines[0], other.polyline([0, 1])])
    for tolerance in (-1.0, 0.3, float("nan"), float("inf")):
        with pytest.raises(sp.OptionError, match=r"^tolerance: "):
            lines[0].cut(tolerance)
    for wrong in ("0.1", None, True, [0.1]):
        with pytest.raises(TypeError, match=r"^tolerance: "):
            lines[0].cut(wrong)
    for wrong in (lines[0], 3, None, [3], [None]):
        with pytest.raises(TypeError, match=r"^lines: "):
            mesh.cut(wrong)
    empty = mesh.cut([])
    assert len(empty.positions) == len(mesh.positions)
    assert (empty.triangles == mesh.triangles).all()


def test_the_same_cut_has_the_same_bytes():
    mesh, _, surface = open_for_cuts("cow.off", False)
    lines = make_lines(mesh, surface, "linear", 4)
    one, other = mesh.cut(lines), mesh.cut(lines)
    for name in ("positions", "triangles", "line_edges", "vertex_barycentric", "polygon_corners"):
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes()
        assert not getattr(one, name).flags.writeable
