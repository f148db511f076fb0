"""One class a library: how it opens a mesh and answers between vertices. Ours is one of them.

A library that is not installed is left out and named. Every answer is the library's own object; `points` makes an array
of it, or `place` tells triangles and barycentric parts where the library knows them. Holds no timing.
"""

import importlib
from importlib import metadata
from itertools import pairwise

import numpy as np

import smooth_polylines as sp

# What lies nearer to a side or a corner than this, in barycentric units, counts as on it: other libraries give points
# only.
SNAP = 1e-6


class Ours:
    """Our library; `mesh` is its own object, for what only it can do."""

    name, distribution, module = "ours", "smooth-polylines", "smooth_polylines"
    eps = np.finfo(np.float64).eps

    def __init__(self, positions, triangles):
        self.mesh = sp.SurfaceMesh(positions, triangles)

    def prepare(self, rung, vertices):
        return [surface_point(rung, v) for v in vertices]

    def path(self, picks):
        return self.mesh.polyline(picks, filter="geodesic", pinned="all")

    def ring(self, picks):
        return self.mesh.polyline(picks, filter="geodesic", pinned="all", closed=True)

    def step_b(self, picks):
        return self.mesh.polyline(picks, filter="none", pinned="all")


class MeshLib:
    """MeshLib: A* along edges, then its reducePath, with its own limit of 100 sweeps. Single precision."""

    name, distribution, module = "MeshLib", "meshlib", "meshlib.mrmeshpy"
    eps = np.finfo(np.float32).eps

    def __init__(self, positions, triangles):
        self.library = importlib.import_module("meshlib.mrmeshpy")
        self.mesh = importlib.import_module("meshlib.mrmeshnumpy").meshFromFacesVerts(triangles, positions)
        self.start_by = self.library.GeodesicPathApprox.DijkstraAStar

    def prepare(self, rung, vertices):
        return [self.library.MeshTriPoint(self.mesh.topology, self.library.VertId(int(v))) for v in vertices]

    def path(self, picks):
        find = self.library.computeGeodesicPath
        return [find(self.mesh, a, b, self.start_by) for a, b in pairwise(picks)]

    def ring(self, picks):
        return self.path([*picks, picks[0]])

    def step_b(self, picks):
        find = self.library.computeGeodesicPathApprox
        return [find(self.mesh, a, b, self.start_by) for a, b in pairwise(picks)]

    def place(self, paths, rung, pair):
        """Triangles and barycentric parts of a line between two vertices: its own edges and parameters."""
        topology = self.mesh.topology
        ends = [first_corner(rung, vertex) for vertex in pair]
        rows = [ends[0]]
        for point in paths[0]:
            edge = point.e if topology.left(point.e).valid() else point.e.sym()
            share = float(point.a.a) if edge == point.e else 1 - float(point.a.a)
            triangle = int(topology.left(edge))
            corners = rung.triangles[triangle].tolist()
            parts = np.zeros(3)
            parts[corners.index(int(topology.org(edge)))] = 1 - share
            parts[corners.index(int(topology.dest(edge)))] = share
            rows.append((triangle, parts))
        triangles, parts = zip(*rows, ends[1], strict=True)
        return np.array(triangles), snap(np.array(parts))


class Potpourri3d:
    """potpourri3d: edge flips of geometry-central (FlipOut), to its own convergence."""

    name, distribution, module = "potpourri3d", "potpourri3d", "potpourri3d"
    eps = np.finfo(np.float64).eps

    def __init__(self, positions, triangles):
        self.solver = importlib.import_module("potpourri3d").EdgeFlipGeodesicSolver(positions, triangles)

    def prepare(self, rung, vertices):
        return [int(v) for v in vertices]

    def path(self, picks):
        if len(picks) == 2:
            return self.solver.find_geodesic_path(*picks)
        return self.solver.find_geodesic_path_poly(picks)

    def ring(self, picks):
        return self.solver.find_geodesic_path_poly([*picks, picks[0]])

    def points(self, answer):
        return answer


class PyGeodesic:
    """pygeodesic: exact geodesics (MMP), for small meshes."""

    name, distribution, module = "pygeodesic", "pygeodesic", "pygeodesic.geodesic"
    eps = np.finfo(np.float64).eps
    most_triangles = 25_000

    def __init__(self, positions, triangles):
        library = importlib.import_module("pygeodesic.geodesic")
        self.solver = library.PyGeodesicAlgorithmExact(positions, triangles)

    def prepare(self, rung, vertices):
        return [int(v) for v in vertices]

    def path(self, picks):
        return self.solver.geodesicDistance(*picks)[1][::-1]

    def points(self, answer):
        return answer


class PyVista:
    """pyvista: Dijkstra along the mesh's edges (VTK). No geodesic, but what a user may take for one."""

    name, distribution, module = "pyvista", "pyvista", "pyvista"
    eps = np.finfo(np.float64).eps

    def __init__(self, positions, triangles):
        self.mesh = importlib.import_module("pyvista").PolyData.from_regular_faces(positions, triangles)

    def prepare(self, rung, vertices):
        return [int(v) for v in vertices]

    def path(self, picks):
        return self.mesh.geodesic(*picks)

    def points(self, answer):
        return np.asarray(answer.points, dtype=np.float64)


class Libigl:
    """libigl: which triangles are neighbours, a part of opening a mesh; it has no lines between points."""

    name, distribution, module = "libigl", "libigl", "igl"

    def __init__(self, positions, triangles):
        self.table = importlib.import_module("igl").triangle_triangle_adjacency(triangles)


ALL = (Ours, MeshLib, Potpourri3d, PyGeodesic, PyVista, Libigl)


def find_installed():
    """Libraries that can be imported, and the names of those that cannot."""
    found, absent = [], []
    for peer in ALL:
        try:
            importlib.import_module(peer.module)
            found.append(peer)
        except ImportError:
            absent.append(peer.name)
    return found, absent


def version_of(peer):
    return metadata.version(peer.distribution)


def first_corner(rung, vertex):
    """A vertex as a triangle that has it, the first, and barycentric parts."""
    triangle, corner = divmod(int(np.flatnonzero(rung.triangles.ravel() == vertex)[0]), 3)
    return triangle, np.eye(3)[corner]


def surface_point(rung, vertex):
    """A vertex as a pick of ours."""
    return sp.SurfacePoint(*first_corner(rung, vertex))


def length_of(points):
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def place_points(mesh, points):
    """Triangles and snapped barycentric parts of points on our `mesh`, for libraries that give points alone."""
    found = mesh.closest_points(np.ascontiguousarray(points, dtype=np.float64))
    return found.triangles, snap(found.barycentric)


def snap(parts):
    parts = np.where(parts < SNAP, 0.0, parts)
    return parts / parts.sum(axis=1, keepdims=True)
