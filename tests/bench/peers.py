"""One class a library: how it opens a mesh and answers between vertices. Ours is one of them.

A library that is not installed is left out and named. Every answer is the library's own object; `trace` turns it into
points with the mesh vertices that each hangs on. Holds no timing.
"""

import importlib
from importlib import metadata

import numpy as np

import smooth_polylines as sp

# What lies nearer to a side or a corner than this, in barycentric units, counts as on it: other libraries give points only.
SNAP = 1e-6


class Ours:
    """This library; `mesh` is its own object, for what only it can do."""

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

    def length(self, line):
        return line.length

    def trace(self, line):
        return line.points, line.triangles, line.barycentric


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
        return [find(self.mesh, a, b, self.start_by) for a, b in zip(picks, picks[1:], strict=False)]

    def ring(self, picks):
        return self.path([*picks, picks[0]])

    def step_b(self, picks):
        find = self.library.computeGeodesicPathApprox
        return [find(self.mesh, a, b, self.start_by) for a, b in zip(picks, picks[1:], strict=False)]

    def points(self, paths, picks):
        corners = [self.mesh.triPoint(pick) for pick in picks]
        rows = [corners[0]]
        for path, end in zip(paths, corners[1:], strict=True):
            rows += [self.mesh.edgePoint(point) for point in path] + [end]
        return np.array([[p.x, p.y, p.z] for p in rows], dtype=np.float64)


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

    def points(self, answer, picks):
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

    def points(self, answer, picks):
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

    def points(self, answer, picks):
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


def surface_point(rung, vertex):
    """A vertex as a pick of ours, through the first triangle that has it."""
    triangle, corner = divmod(int(np.flatnonzero(rung.triangles.ravel() == vertex)[0]), 3)
    return sp.SurfacePoint(triangle, np.eye(3)[corner])


def length_of(points):
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def place_points(mesh, points):
    """Triangles and snapped barycentric parts of points on our `mesh`, for libraries that give points alone."""
    found = mesh.closest_points(np.ascontiguousarray(points, dtype=np.float64))
    parts = np.where(found.barycentric < SNAP, 0.0, found.barycentric)
    return found.triangles, parts / parts.sum(axis=1, keepdims=True)
