"""Meshes made by formula, for tests that know the answer. Holds no test."""

import numpy as np
from scipy.spatial import Delaunay


def make_square():
    """Two triangles: 0 below the diagonal from (0, 0) to (1, 1), 1 above it."""
    positions = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    return positions, np.array([[0, 1, 2], [0, 2, 3]])


def make_grid(columns, rows=None):
    """A unit square of columns x rows cells, two triangles each, all diagonals one way."""
    rows = rows or columns
    x, y = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    positions = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    lower = np.column_stack([corner, corner + 1, corner + columns + 2])
    upper = np.column_stack([corner, corner + columns + 2, corner + columns + 1])
    return positions, np.stack([lower, upper], axis=1).reshape(-1, 3)


def make_irregular_square(count, seed):
    """Delaunay triangulation of `count` random points in the unit square and of its corners."""
    rng = np.random.default_rng(seed)
    flat = np.vstack([rng.random((count, 2)), [[0, 0], [1, 0], [1, 1], [0, 1]]])
    return np.column_stack([flat, np.zeros(len(flat))]), Delaunay(flat).simplices.astype(np.int32)


def make_terrain(count, seed, height=0.15):
    """An irregular square with smooth hills."""
    positions, triangles = make_irregular_square(count, seed)
    x, y = positions[:, 0], positions[:, 1]
    positions[:, 2] = height * np.sin(7 * x) * np.cos(5 * y)
    return positions, triangles


def make_sphere(subdivisions):
    """A unit icosphere: 20 * 4**subdivisions triangles."""
    golden = (1 + 5**0.5) / 2
    positions = [
        [-1, golden, 0], [1, golden, 0], [-1, -golden, 0], [1, -golden, 0],
        [0, -1, golden], [0, 1, golden], [0, -1, -golden], [0, 1, -golden],
        [golden, 0, -1], [golden, 0, 1], [-golden, 0, -1], [-golden, 0, 1],
    ]  # fmt: skip
    triangles = [
        [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6],
        [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7],
        [9, 8, 1],
    ]  # fmt: skip
    positions = [np.array(p, float) / np.linalg.norm(p) for p in positions]
    for _ in range(subdivisions):
        middles = {}

        def middle(a, b, middles=middles):
            key = (min(a, b), max(a, b))
            if key not in middles:
                point = positions[a] + positions[b]
                positions.append(point / np.linalg.norm(point))
                middles[key] = len(positions) - 1
            return middles[key]

        finer = []
        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        triangles = finer
    return np.array(positions), np.array(triangles)


def make_torus(major, minor, radius=1.0, tube=0.4):
    """A torus of major x minor quads, two triangles each."""
    u, v = np.meshgrid(np.arange(major), np.arange(minor), indexing="ij")
    a, b = 2 * np.pi * u / major, 2 * np.pi * v / minor
    ring = radius + tube * np.cos(b)
    positions = np.stack([ring * np.cos(a), ring * np.sin(a), tube * np.sin(b)], axis=-1).reshape(-1, 3)
    i, j = u.ravel(), v.ravel()
    at = lambda i, j: (i % major) * minor + j % minor  # noqa: E731
    lower = np.column_stack([at(i, j), at(i + 1, j), at(i + 1, j + 1)])
    upper = np.column_stack([at(i, j), at(i + 1, j + 1), at(i, j + 1)])
    return positions, np.stack([lower, upper], axis=1).reshape(-1, 3)


def make_cylinder(around, along, radius=1.0, height=4.0):
    """An open cylinder of around x along quads, two triangles each."""
    u, v = np.meshgrid(np.arange(around), np.arange(along + 1), indexing="ij")
    angle = 2 * np.pi * u / around
    positions = np.stack([radius * np.cos(angle), radius * np.sin(angle), height * v / along], -1).reshape(-1, 3)
    i, j = (x.ravel() for x in np.meshgrid(np.arange(around), np.arange(along), indexing="ij"))
    at = lambda i, j: (i % around) * (along + 1) + j  # noqa: E731
    lower = np.column_stack([at(i, j), at(i + 1, j), at(i + 1, j + 1)])
    upper = np.column_stack([at(i, j), at(i + 1, j + 1), at(i, j + 1)])
    return positions, np.stack([lower, upper], axis=1).reshape(-1, 3)


def make_ladder(bottom, top):
    """One strip of triangles between two rows of points, zigzag; rung i joins vertices i and i + 1.

    ``bottom`` and ``top``: (n, 2). Vertices alternate b0 t0 b1 t1 ...; triangle i has vertices i, i + 1, i + 2.
    """
    zigzag = np.empty((len(bottom) + len(top), 3))
    zigzag[:, 2] = 0
    zigzag[0::2, :2] = bottom
    zigzag[1::2, :2] = top
    first = np.arange(len(zigzag) - 2)
    return zigzag, np.column_stack([first, first + 1, first + 2])


def make_fan(valence, closed=True, height=0.0):
    """Triangles round one vertex, which is vertex 0 at `height`, the rim on the unit circle."""
    angle = 2 * np.pi * np.arange(valence if closed else valence + 1) / valence
    rim = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))])
    first = np.arange(valence)
    after = (first + 1) % valence if closed else first + 1
    positions = np.vstack([[[0, 0, height]], rim])
    return positions, np.column_stack([np.zeros(valence, int), first + 1, after + 1])


def barycentres(positions, triangles):
    return np.asarray(positions, float)[np.asarray(triangles)].mean(axis=1)


def nearest_triangle(positions, triangles, point):
    return int(np.linalg.norm(barycentres(positions, triangles) - point, axis=1).argmin())
