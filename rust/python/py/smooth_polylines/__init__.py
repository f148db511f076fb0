"""Smooth curves that lie exactly on polygon meshes.

Pick a few faces of a mesh, in order; the answer is a smooth line on the surface::

    import smooth_polylines as sp

    mesh = sp.SurfaceMesh(positions, triangles)
    line = mesh.polyline([12, 845, 99], filter="geodesic")
    line.points  # (n, 3) float64

Holds nothing but names: the classes are in the compiled module. Source of the method: G.-P. Bonneau,
S. Hahmann, Smooth Polylines on Polygon Meshes (2003).
"""

from ._native import (
    ClosestPoints,
    CollapsedError,
    Crossings,
    Cut,
    CutError,
    EdgePath,
    Error,
    InternalError,
    LimitError,
    MeshError,
    MeshReport,
    Network,
    NoPathError,
    OptionError,
    Patches,
    Polyline,
    RayHits,
    Report,
    SurfaceMesh,
    SurfacePoint,
    __version__,
    find_crossings,
)

__all__ = [
    "ClosestPoints",
    "CollapsedError",
    "Crossings",
    "Cut",
    "CutError",
    "EdgePath",
    "Error",
    "InternalError",
    "LimitError",
    "MeshError",
    "MeshReport",
    "Network",
    "NoPathError",
    "OptionError",
    "Patches",
    "Polyline",
    "RayHits",
    "Report",
    "SurfaceMesh",
    "SurfacePoint",
    "__version__",
    "find_crossings",
]
