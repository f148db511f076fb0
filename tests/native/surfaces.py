"""The meshes that whole families of tests run over: made ones and the shared real ones. Holds no test."""

import functools
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

import meshes
import smooth_polylines as sp
from native import made_meshes
from native.invariants import SurfaceChecker

MADE = {
    "grid": lambda: made_meshes.make_grid(12),
    "irregular square": lambda: made_meshes.make_irregular_square(400, 3),
    "terrain": lambda: made_meshes.make_terrain(900, 5),
    "sphere": lambda: made_meshes.make_sphere(3),
    "torus": lambda: made_meshes.make_torus(40, 18),
    "cylinder": lambda: made_meshes.make_cylinder(24, 16),
}
# In the order of their sizes.
SOUND = (
    "moebius.obj", "tray_cad.off", "cow.off", "spot.obj", "fertility.off", "shark_holes.off", "fandisk.obj",
    "camel.off", "mountain.obj", "bunny00.off", "igea.ply",
)  # fmt: skip
HOSTILE = (
    "fan3.obj", "hourglass_ico.obj", "triple_vierbein.obj", "suzanne.obj", "openscad_crash.obj", "truck_nm.obj",
    "thingi_79741.off",
)  # fmt: skip
ALL_SHARED = SOUND + HOSTILE


@dataclass(frozen=True)
class Surface:
    """A mesh opened by the library, and what the independent checks need of it."""

    name: str
    positions: np.ndarray
    triangles: np.ndarray
    mesh: sp.SurfaceMesh

    @functools.cached_property
    def checker(self):
        return SurfaceChecker(self.positions, self.triangles)

    @functools.cached_property
    def dual_graph(self):
        """Sparse (F, F): distance of the barycentres of triangles that share an edge of exactly two triangles."""
        edges = self.checker.edge_ids.ravel()
        order = np.argsort(edges, kind="stable")
        of_two = self.checker.edge_counts[edges[order]] == 2
        pairs = np.sort((order[of_two] // 3).reshape(-1, 2), axis=1)
        # Two triangles may share two edges: one link, or a sum of two weights would be stored.
        pairs = np.unique(pairs, axis=0)
        centres = made_meshes.barycentres(self.positions, self.triangles)
        weights = np.linalg.norm(centres[pairs[:, 0]] - centres[pairs[:, 1]], axis=1)
        n = len(self.triangles)
        return coo_matrix((weights, (pairs[:, 0], pairs[:, 1])), shape=(n, n)).tocsr()

    @functools.cached_property
    def largest_part(self):
        """Triangle ids of the part with the most triangles."""
        _, labels = connected_components(self.dual_graph, directed=False)
        return np.flatnonzero(labels == np.bincount(labels).argmax())

    def random_picks(self, count, seed):
        """Different triangles of the largest part, as Python integers."""
        rng = np.random.default_rng(seed)
        return rng.choice(self.largest_part, min(count, len(self.largest_part)), replace=False).tolist()

    @property
    def diagonal(self):
        return float(np.linalg.norm(np.ptp(self.positions, axis=0)))


@functools.cache
def open_surface(name):
    """By the key of MADE, or by the file name of a shared mesh (skipped where the folder is absent)."""
    if name in MADE:
        positions, triangles = MADE[name]()
    else:
        mesh = meshes.load_shared_mesh(name)
        positions, triangles = mesh.positions, mesh.triangles
    return Surface(name, positions, triangles, sp.SurfaceMesh(positions, triangles))
