"""Writes a line into a file that other programs read. Knows no meshes."""

import io
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ._native import Polyline


def write_line(path: Path, line: Polyline) -> None:
    """Write `line` to `path`, in the form that its suffix says; KeyError for one that is not in WRITERS.

    Examples
    --------
    >>> import smooth_polylines as sp, tempfile
    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> line = sp.SurfaceMesh(square, [[0, 1, 2], [0, 2, 3]]).polyline([0, 1], filter="geodesic")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_line(Path(folder, "line.obj"), line)
    ...     print(Path(folder, "line.obj").read_text().splitlines()[-1])
    l 1 2 3
    """
    path.write_bytes(WRITERS[path.suffix.lower()](line))


def make_obj(line: Polyline) -> bytes:
    """Wavefront OBJ: vertices and one line element; a closed line ends where it began."""
    rows = ["v " + " ".join(map(repr, point)) for point in line.points.tolist()]
    numbers = [*range(1, len(rows) + 1), *([1] if line.closed else [])]
    return ("\n".join([*rows, "l " + " ".join(map(str, numbers))]) + "\n").encode()


def make_csv(line: Polyline) -> bytes:
    """One row a point: its place, a triangle that holds it, and where in it."""
    rows = ["x,y,z,triangle,b0,b1,b2"]
    for point, triangle, weights in zip(
        line.points.tolist(), line.triangles.tolist(), line.barycentric.tolist(), strict=True
    ):
        rows.append(",".join([*map(repr, point), str(triangle), *map(repr, weights)]))
    return ("\n".join(rows) + "\n").encode()


def make_json(line: Polyline) -> bytes:
    """All arrays of the line, as lists."""
    values = {
        "closed": line.closed,
        "length": line.length,
        "stop_reason": line.report.stop_reason,
        "points": line.points.tolist(),
        "triangles": line.triangles.tolist(),
        "barycentric": line.barycentric.tolist(),
    }
    return (json.dumps(values) + "\n").encode()


def make_npz(line: Polyline) -> bytes:
    """All arrays of the line, for numpy."""
    buffer = io.BytesIO()
    arrays = {
        name: getattr(line, name) for name in ("points", "triangles", "barycentric", "segment_triangles", "strip")
    }
    np.savez_compressed(buffer, closed=np.array(line.closed), **arrays)
    return buffer.getvalue()


WRITERS: dict[str, Callable[[Polyline], bytes]] = {
    ".obj": make_obj,
    ".csv": make_csv,
    ".json": make_json,
    ".npz": make_npz,
}
