"""An independent checker of a mesh with lines cut into it.

Written from the documentation alone, in plain numpy, SciPy and loops: it calls the library for nothing but the cut.
"""

from collections import Counter, defaultdict
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

# Sums of areas and volumes are as exact as their terms; this is the promise.
RELATIVE = 1e-9

# Of an equilateral triangle with sides of length 1.
HEIGHT = np.sqrt(3) / 2

# Distances are kept to a rounding error of the numbers, which are at most 1.
ROUNDING = 1e-14


def fan_outlines(triangles, faces):
    """Outline of each polygon, by face id, of meshes whose polygons were cut into fans in row order."""
    outlines = {}
    for face in np.unique(faces):
        rows = triangles[faces == face]
        outlines[int(face)] = [int(rows[0][0]), *rows[:, 1].tolist(), int(rows[-1][2])]
    return outlines


def sides_of(triangles):
    """Directed sides: (3 F, 2)."""
    return np.asarray(triangles)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)


def count_edges(triangles):
    """How many triangles each edge (low, high) has."""
    return Counter(map(tuple, np.sort(sides_of(triangles), axis=1).tolist()))


def loops_of(edges):
    """Number of connected parts of a set of edges."""
    if not edges:
        return 0
    ids = np.array(edges)
    names, local = np.unique(ids, return_inverse=True)
    local = local.reshape(-1, 2)
    n = len(names)
    return connected_components(coo_matrix((np.ones(len(ids)), local.T), shape=(n, n)))[0]


def vector_areas(positions, triangles):
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a) / 2


def volume(positions, triangles):
    """With the middle of the mesh as the origin, so that nothing large cancels."""
    a, b, c = (positions[triangles[:, k]] - positions.mean(axis=0) for k in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


def faces_by_line(triangles, line_edges):
    """Parts of the mesh when it is cut open along `line_edges`: their number, and the part of each triangle."""
    sides = np.sort(sides_of(triangles), axis=1).astype(np.int64)
    bound = int(sides.max(initial=0)) + 1
    keys = sides[:, 0] * bound + sides[:, 1]
    lines = np.asarray(line_edges, dtype=np.int64).reshape(-1, 2)
    keys[np.isin(keys, lines[:, 0] * bound + lines[:, 1])] = -1
    order = np.argsort(keys, kind="stable")
    joined = (keys[order][1:] == keys[order][:-1]) & (keys[order][1:] >= 0)
    a, b = order[:-1][joined] // 3, order[1:][joined] // 3
    n = len(triangles)
    return connected_components(coo_matrix((np.ones(len(a)), (a, b)), shape=(n, n)))


def part_distance(a, b):
    """Distance of barycentric points when their triangle is laid onto an equilateral one with sides of length 1."""
    return np.sqrt(((np.asarray(a) - b) ** 2).sum(axis=-1) / 2)


def segment_distance(points, a, b):
    """The same, of points (n, 3) from the segment from `a` to `b`: (n,)."""
    along = b - a
    square = along @ along
    t = np.clip((points - a) @ along / square, 0, 1) if square > 0 else np.zeros(len(points))
    return part_distance(points, a + t[:, None] * along)


def distances(points, chain, closed):
    """Of points from a chain of points: (n,)."""
    ring = np.vstack([chain, chain[:1]]) if closed or len(chain) == 1 else chain
    a, along = ring[:-1], np.diff(ring, axis=0)
    square = np.maximum((along**2).sum(axis=1), 1e-300)
    t = np.clip(np.einsum("nki,ki->nk", points[:, None] - a, along) / square, 0, 1)
    return np.linalg.norm(points[:, None] - (a + t[..., None] * along), axis=2).min(axis=1)


class CutChecker:
    """Knows one mesh and checks cuts of it."""

    def __init__(self, positions, triangles, faces=None):
        self.positions = np.ascontiguousarray(positions, np.float64)
        self.triangles = np.asarray(triangles, np.int64)
        self.faces = faces
        self.edges = count_edges(self.triangles)
        self.turns = Counter(map(tuple, sides_of(self.triangles).tolist()))
        self.diagonals = None
        self.outlines = None if faces is None else fan_outlines(self.triangles, np.asarray(faces))

    def check(self, cut, lines, tolerance):
        """Assert everything that a cut promises; returns the triangles' parts when it is opened along the lines."""
        self._check_vertices(cut, tolerance)
        self._check_triangles(cut)
        self._check_edges(cut)
        self._check_whole(cut)
        self._check_apart(cut, tolerance)
        self._check_lines(cut, lines, tolerance)
        self._check_polygons(cut)
        return faces_by_line(cut.triangles, cut.line_edges)

    def support(self, cut, vertex):
        """Old vertices that a vertex hangs on, with their weights."""
        new = vertex - len(self.positions)
        if new < 0:
            return {int(vertex): 1.0}
        corners = self.triangles[cut.vertex_triangles[new]]
        weights = cut.vertex_barycentric[new]
        return {int(v): float(w) for v, w in zip(corners, weights, strict=True) if w != 0}

    def _check_vertices(self, cut, tolerance):
        old = len(self.positions)
        assert cut.positions.dtype == np.float64
        assert cut.positions[:old].tobytes() == self.positions.tobytes(), "an old vertex was changed"
        b, p = cut.vertex_barycentric, self.positions[self.triangles[cut.vertex_triangles]]
        expected = (b[:, 0:1] * p[:, 0] + b[:, 1:2] * p[:, 1]) + b[:, 2:3] * p[:, 2]
        assert cut.positions[old:].tobytes() == expected.tobytes(), "a new vertex is not where its weights are"
        assert (b >= 0).all()
        assert np.allclose(b.sum(axis=1), 1, rtol=0, atol=1e-14)
        on_edges = defaultdict(list)
        inside = defaultdict(list)
        for i in range(len(b)):
            support = self.support(cut, old + i)
            assert 2 <= len(support) <= 3, f"new vertex {i} is an old one"
            if len(support) == 2:
                key = tuple(sorted(support))
                on_edges[key].append(support[key[1]])
            else:
                inside[int(cut.vertex_triangles[i])].append(b[i])
            told = tuple(cut.vertex_edges[i].tolist())
            if len(support) == 2 and not self._is_diagonal(*key):
                assert told == key
                assert abs(cut.vertex_parameters[i] - support[key[1]]) < 1e-15
            else:
                assert told == (-1, -1)
                assert np.isnan(cut.vertex_parameters[i])
        for key, parameters in on_edges.items():
            gaps = np.diff([0.0, *sorted(parameters), 1.0])
            assert gaps.min() >= max(tolerance - ROUNDING, 1e-13), f"vertices {gaps.min()} of edge {key} apart"
        for triangle, rows in inside.items():
            for i, row in enumerate(rows):
                for other in rows[:i]:
                    assert np.abs(row - other).max() > 0, f"the same vertex twice in triangle {triangle}"

    def _rows(self, cut, vertices, triangle):
        """Weights of a triangle's corners for vertices in it: (n, 3)."""
        corners = self.triangles[triangle].tolist()
        rows = np.zeros((len(vertices), 3))
        for row, vertex in zip(rows, vertices, strict=True):
            for v, weight in self.support(cut, vertex).items():
                row[corners.index(v)] = weight
        return rows

    def _check_apart(self, cut, tolerance):
        """No sliver comes from the lines: in each triangle everything is apart by the tolerance, without exception."""
        on_lines = set(map(tuple, cut.line_edges.tolist()))
        parents = cut.triangle_parents
        order = np.argsort(parents, kind="stable")
        groups = np.split(order, np.flatnonzero(np.diff(parents[order])) + 1)
        least = max(tolerance - ROUNDING, 1e-13)
        for own in (group for group in groups if len(group) > 1):
            triangle = parents[own[0]]
            vertices, local = np.unique(cut.triangles[own], return_inverse=True)
            rows = self._rows(cut, vertices, triangle)
            local = local.reshape(-1, 3)
            for i in range(1, len(rows)):
                gap = part_distance(rows[:i], rows[i]).min()
                assert gap >= least, f"two vertices in triangle {triangle} are {gap / tolerance} tolerances apart"
            # Inside, the whole tolerance from the sides; on a side, what an angle of 60 degrees leaves of it.
            inner = (rows > 0).all(axis=1)
            assert (rows[inner] * HEIGHT >= least).all(), f"a vertex in triangle {triangle} is too near to a side"
            assert (rows[rows > 0] * HEIGHT >= least * HEIGHT).all()
            pieces = {tuple(sorted(side)) for side in sides_of(local).tolist()}
            for a, b in sorted(pieces):
                if (vertices[a], vertices[b]) not in on_lines or ((rows[a] == 0) & (rows[b] == 0)).any():
                    continue
                others = np.delete(rows, [a, b], axis=0)
                gap = segment_distance(others, rows[a], rows[b]).min()
                assert gap >= least * HEIGHT, (
                    f"a line in {triangle} is {gap / tolerance / HEIGHT} tolerances from a vertex"
                )

    def _is_diagonal(self, a, b):
        if self.faces is None:
            return False
        if self.diagonals is None:
            by_edge = defaultdict(list)
            for side, key in enumerate(map(tuple, np.sort(sides_of(self.triangles), axis=1).tolist())):
                by_edge[key].append(self.faces[side // 3])
            self.diagonals = {key for key, own in by_edge.items() if len(own) == 2 and own[0] == own[1]}
        return (a, b) in self.diagonals

    def _check_triangles(self, cut):
        count = len(self.triangles)
        parents = cut.triangle_parents
        assert (parents[:count] == np.arange(count)).all()
        pieces = np.bincount(parents, minlength=count)
        whole = pieces[:count] == 1
        assert (cut.triangles[:count][whole] == self.triangles[whole]).all(), "an untouched triangle was changed"
        for row in np.flatnonzero(pieces[parents] > 1):
            corners = self.triangles[parents[row]].tolist()
            weights = np.zeros((3, 3))
            for k, vertex in enumerate(cut.triangles[row]):
                for v, weight in self.support(cut, vertex).items():
                    assert v in corners, f"piece {row} reaches out of its parent"
                    weights[k, corners.index(v)] = weight
            assert np.linalg.det(weights) > -1e-15, f"piece {row} is turned over"
        areas = vector_areas(cut.positions, cut.triangles)
        summed = np.zeros((count, 3))
        np.add.at(summed, parents, areas)
        expected = vector_areas(self.positions, self.triangles)
        sizes = np.ptp(self.positions[self.triangles], axis=1).max(axis=1) ** 2
        scale = np.abs(self.positions).max() ** 2 * 1e-13
        assert (np.abs(summed - expected).max(axis=1) <= RELATIVE * sizes + scale).all(), "pieces do not fill a parent"

    def _check_edges(self, cut):
        after = count_edges(cut.triangles)
        turns = Counter(map(tuple, sides_of(cut.triangles).tolist()))
        for key, count in after.items():
            if count == 2 and turns[key] == 1:
                continue
            under = tuple(sorted(self.support(cut, key[0]).keys() | self.support(cut, key[1]).keys()))
            assert len(under) == 2, f"edge {key} inside a triangle has {count} pieces"
            assert self.edges[under] == count, f"edge {key} has {count} triangles, the old one {self.edges[under]}"
            assert sorted([turns[key], turns[key[::-1]]]) == sorted([self.turns[under], self.turns[under[::-1]]])
        before = [key for key, count in self.edges.items() if count == 1]
        rim = [key for key, count in after.items() if count == 1]
        assert loops_of(before) == loops_of(rim), "the boundary was changed"

        def length(positions, edges):
            ids = np.array(edges, dtype=np.int64).reshape(-1, 2)
            return np.linalg.norm(positions[ids[:, 0]] - positions[ids[:, 1]], axis=1).sum()

        assert np.isclose(length(self.positions, before), length(cut.positions, rim), rtol=RELATIVE)

    def _check_whole(self, cut):
        def euler(triangles):
            return len(np.unique(triangles)) - len(count_edges(triangles)) + len(triangles)

        assert euler(cut.triangles) == euler(self.triangles), "the Euler characteristic was changed"
        size = np.linalg.norm(vector_areas(self.positions, self.triangles), axis=1).sum()
        after = np.linalg.norm(vector_areas(cut.positions, cut.triangles), axis=1).sum()
        assert abs(after - size) <= RELATIVE * size, f"the area went from {size} to {after}"
        if all(count == 2 for count in self.edges.values()) and max(self.turns.values()) == 1:
            before, after = volume(self.positions, self.triangles), volume(cut.positions, cut.triangles)
            assert abs(after - before) <= RELATIVE * max(abs(before), size**1.5 * 1e-3)

    def _check_lines(self, cut, lines, tolerance):
        edges = count_edges(cut.triangles)
        told = set(map(tuple, cut.line_edges.tolist()))
        assert len(told) == len(cut.line_edges)
        seen = set()
        assert len(cut.line_vertices) == len(cut.line_parameters) == len(lines)
        for line, chain, parameters in zip(lines, cut.line_vertices, cut.line_parameters, strict=True):
            chain = chain.tolist()
            ring = [*chain, chain[0]] if line.closed and len(chain) > 2 else chain
            for a, b in pairwise(ring):
                key = (min(a, b), max(a, b))
                assert key in edges, f"{key} on a line is no edge"
                seen.add(key)
            assert (np.diff(parameters) >= 0).all()
            self._check_moves(cut, line, chain, parameters, tolerance)
        assert seen == told

    def _check_moves(self, cut, line, chain, parameters, tolerance):
        """Lines are where they were, but for the stated bound, and go past all their points."""
        points = np.vstack([line.points, line.points[:1]])
        triangles = np.append(
            line.segment_triangles, line.segment_triangles[-1:] if len(line.points) > 1 else line.triangles
        )
        low = np.minimum(parameters.astype(int), len(points) - 2)
        part = (parameters - low)[:, None]
        along = (1 - part) * points[low] + part * points[low + 1]
        off = np.linalg.norm(cut.positions[chain] - along, axis=1)
        # Led through n vertices inside a triangle; the longest side of the triangle is the scale.
        inner = np.bincount(low[parameters != low], minlength=len(triangles))[: len(triangles)]
        longest = np.linalg.norm(
            np.diff(self.positions[self.triangles[triangles]][:, [0, 1, 2, 0]], axis=1), axis=2
        ).max(1)
        moves = np.sqrt(2) / HEIGHT * (1 + inner) * tolerance * longest[: len(inner)]
        nearest = np.maximum(moves, np.roll(moves, 1))
        slack = 1e-9 * longest.max()
        assert (off <= 2 * nearest[low] + slack).all(), "a vertex is not where its parameter says"
        # And every point of the line is on the chain, but for its own move.
        missed = distances(line.points, cut.positions[chain], line.closed)
        at = np.minimum(np.arange(len(missed)), len(longest) - 1)
        reach = np.maximum(longest[at], longest[at - 1])
        assert (missed <= np.sqrt(2) / HEIGHT * tolerance * reach + slack).all(), "a point of the line is missed"
        for i, triangle in enumerate(line.segment_triangles):
            own = [v for v, p in zip(chain, parameters, strict=True) if i < p < i + 1]
            if own:
                corners = self.triangles[triangle].tolist()
                ends = np.array([self._row_of(line, at, corners) for at in (i, (i + 1) % len(line.points))])
                gap = segment_distance(self._rows(cut, own, triangle), *ends).max()
                # A tolerance of 0 stands for rounding.
                limit = np.sqrt(2) * max(tolerance, 1e-12) * (1 + len(own))
                assert gap <= limit + ROUNDING, f"moved by {gap}, the limit is {limit}"
                assert gap <= cut.largest_move + ROUNDING

    def _row_of(self, line, point, corners):
        own = self.triangles[line.triangles[point]].tolist()
        weights = dict(zip(own, line.barycentric[point], strict=True))
        return np.array([weights.get(v, 0.0) for v in corners])

    def _check_polygons(self, cut):
        offsets, corners, parents = cut.polygon_offsets, cut.polygon_corners, cut.polygon_parents
        loops = [corners[offsets[i] : offsets[i + 1]].tolist() for i in range(len(parents))]
        if self.faces is None:
            assert corners.tobytes() == cut.triangles.tobytes()
            assert (parents == cut.triangle_parents).all()
            assert (cut.triangle_polygons == np.arange(len(cut.triangles))).all()
            assert (offsets == 3 * np.arange(len(cut.triangles) + 1)).all()
            return
        face_ids = np.unique(self.faces)
        assert (parents[: len(face_ids)] == face_ids).all()
        assert set(parents[len(face_ids) :].tolist()) <= set(face_ids.tolist())
        changed = set(cut.changed_polygons.tolist())
        triangle_edges = count_edges(cut.triangles)
        # Edges of polygons, and how many have each: as many as triangles there, but none at the dropped diagonals.
        counts = Counter()
        by_polygon = np.argsort(cut.triangle_polygons, kind="stable")
        starts = np.searchsorted(cut.triangle_polygons[by_polygon], np.arange(len(loops) + 1))
        for i, loop in enumerate(loops):
            assert len(set(loop)) == len(loop) >= 3, f"polygon {i} passes a vertex twice"
            members = cut.triangles[by_polygon[starts[i] : starts[i + 1]]]
            assert len(members) == len(loop) - 2, f"polygon {i} has a hole or a vertex inside"
            assert set(members.ravel().tolist()) == set(loop)
            sides = Counter(map(tuple, sides_of(members).tolist()))
            for side in zip(loop, loop[1:] + loop[:1], strict=True):
                assert sides[side] == 1, f"polygon {i} is turned over"
                counts[tuple(sorted(side))] += 1
            if i not in changed:
                assert loop == self.outlines[int(parents[i])], f"polygon {i} was changed and is not told"
        lines = set(map(tuple, cut.line_edges.tolist()))
        for key, count in triangle_edges.items():
            assert counts[key] in (0, count), f"edge {key} has {counts[key]} polygons and {count} triangles"
            assert counts[key] or key not in lines, f"the line's edge {key} is none of the polygons"
        assert set(counts) <= set(triangle_edges)
        assert (np.asarray(self.faces)[cut.triangle_parents] == parents[cut.triangle_polygons]).all()
