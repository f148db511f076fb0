"""Paths along existing edges: on the edges, straight where edges are, on the line's side of holes, nearest of all."""

import numpy as np
import pytest

import smooth_polylines as sp
from native.cut_checker import count_edges, distances
from native.made_meshes import make_cylinder, make_grid
from native.test_cut import as_points, open_for_cuts


def make_quads(columns, rows=None):
    """A grid whose cells are quads: positions, triangles, and the quad of each triangle."""
    positions, triangles = make_grid(columns, rows)
    return positions, triangles, np.arange(len(triangles)) // 2


def polygon_edges(triangles, faces):
    """Edges that are no diagonal of a polygon."""
    if faces is None:
        return set(count_edges(triangles))
    sides = np.sort(np.asarray(triangles)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    by_edge = {}
    for i, key in enumerate(map(tuple, sides.tolist())):
        by_edge.setdefault(key, []).append(int(faces[i // 3]))
    return {key for key, own in by_edge.items() if len(own) != 2 or own[0] != own[1]}


def cost(positions, edges, line):
    """Integral of the distance from the line."""
    total = 0.0
    for a, b in edges:
        s = np.linspace(0, 1, 33)[:, None]
        points = (1 - s) * positions[a] + s * positions[b]
        d = distances(points, line.points, line.closed)
        total += np.linalg.norm(positions[b] - positions[a]) * ((d[1:] + d[:-1]) / 2).mean()
    return total


@pytest.mark.parametrize("filter_name", ["none", "linear", "geodesic", "fair"])
@pytest.mark.parametrize(
    ("name", "with_faces"),
    [("terrain", False), ("sphere", False), ("spot.obj", True), ("cow.off", False), ("shark_holes.off", False)],
)
def test_a_path_is_on_edges_near_its_line(name, with_faces, filter_name):
    mesh, checker, surface = open_for_cuts(name, with_faces)
    edges = polygon_edges(surface.triangles, checker.faces)
    rng = np.random.default_rng(5)
    for closed in (False, True):
        picks = as_points(rng.choice(surface.largest_part, 6, replace=False))
        line = mesh.polyline(picks, closed=closed, filter=filter_name, pinned="all")
        path = line.edge_path()
        assert path.closed is closed
        assert len(path.edges) == len(path.vertices) - (not closed)
        for (a, b), vertex in zip(path.edges.tolist(), path.vertices.tolist(), strict=False):
            assert a == vertex
            assert (min(a, b), max(a, b)) in edges
        # No edge is gone along and at once back.
        assert (path.vertices[2:] != path.vertices[:-2]).all()
        longest = np.ptp(surface.positions[surface.triangles[line.strip]], axis=1).max()
        off = distances(surface.positions[path.vertices], line.points, line.closed)
        assert off.max() <= path.distance["max"] + 1e-12
        assert path.distance["max"] <= 2.5 * longest
        assert path.distance["mean"] <= path.distance["max"]


def test_a_path_runs_straight_between_two_rows():
    positions, triangles, faces = make_quads(20)
    mesh = sp.SurfaceMesh(positions, triangles, faces)
    # Along y = 0.51: the row at 0.5 is nearest all the way.
    for height in (0.51, 0.52, 0.54):
        rows = mesh.closest_points([[0.02, height, 0.0], [0.98, height, 0.0]])
        line = mesh.polyline(rows.surface_points, filter="linear")
        path = line.edge_path()
        assert np.allclose(positions[path.vertices][1:-1, 1], round(height * 20) / 20)


def test_a_path_along_a_diagonal_changes_rows_no_more_than_it_must():
    positions, triangles, faces = make_quads(20)
    mesh = sp.SurfaceMesh(positions, triangles, faces)
    ends = mesh.closest_points([[0.01, 0.32, 0.0], [0.99, 0.68, 0.0]])
    path = mesh.polyline(ends.surface_points, filter="geodesic").edge_path()
    steps = np.abs(np.diff(positions[path.vertices], axis=0))
    assert np.count_nonzero(steps[:, 1] > 1e-9) == round(abs(np.ptp(positions[path.vertices][:, 1])) * 20)


@pytest.mark.parametrize("seed", range(8))
def test_a_path_is_the_nearest_of_all_on_a_small_grid(seed):
    """Against Dijkstra over the whole mesh, which on a disc has only one way round."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra

    positions, triangles, faces = make_quads(8)
    mesh = sp.SurfaceMesh(positions, triangles, faces)
    rng = np.random.default_rng(seed)
    ends = mesh.closest_points(np.column_stack([rng.random((2, 2)), np.zeros(2)]))
    line = mesh.polyline(ends.surface_points, filter="linear")
    path = line.edge_path()
    edges = sorted(polygon_edges(triangles, faces))
    lengths = np.array([np.linalg.norm(positions[b] - positions[a]) for a, b in edges])
    weights = np.array([cost(positions, [edge], line) for edge in edges]) + 1e-3 * lengths.mean() * lengths
    n = len(positions)
    graph = coo_matrix((weights, np.array(edges).T), shape=(n, n))
    best = dijkstra(graph, directed=False, indices=int(path.vertices[0]))[path.vertices[-1]]
    own = sum(weights[edges.index((min(a, b), max(a, b)))] for a, b in path.edges.tolist())
    assert own <= best * 1.02 + 1e-9


def test_a_path_round_a_tube_closes_round_it():
    positions, triangles = make_cylinder(12, 20)
    mesh = sp.SurfaceMesh(positions, triangles)
    around = mesh.closest_points([[np.cos(a), np.sin(a), 2.03] for a in np.linspace(0, 2 * np.pi, 6)[:-1]])
    path = mesh.polyline(around.surface_points, closed=True, filter="linear", pinned="all").edge_path()
    assert path.closed
    assert len(path.vertices) == 12
    assert np.allclose(positions[path.vertices][:, 2], 2.0)


def test_a_path_stays_on_its_side_of_a_hole():
    """A hole of one cell's size: the line passes it on the left, the nearest edges to the right of it are no choice."""
    positions, triangles, faces = make_quads(21)
    centre = positions[triangles].mean(axis=1)
    keep = (np.abs(centre[:, :2] - 0.5).max(axis=1) > 0.5 / 21).ravel()
    mesh = sp.SurfaceMesh(positions, triangles[keep], faces[keep])
    for side in (-1, 1):
        ends = mesh.closest_points([[0.5 + side * 0.06, 0.05, 0.0], [0.5 + side * 0.03, 0.95, 0.0]])
        line = mesh.polyline(ends.surface_points, filter="geodesic")
        path = line.edge_path()
        middle = positions[path.vertices]
        beside = middle[np.abs(middle[:, 1] - 0.5) < 0.04]
        assert len(beside)
        assert (side * (beside[:, 0] - 0.5) > 0).all()


def test_a_line_of_one_point_has_a_path_of_one_vertex():
    positions, triangles, faces = make_quads(4)
    mesh = sp.SurfaceMesh(positions, triangles, faces)
    path = mesh.polyline([3]).edge_path()
    assert len(path) == 1
    assert path.edges.shape == (0, 2)
