"""Meshes for the tests: small readers of OBJ, PLY, OFF and STL, and the folder of shared test meshes.

The folder is `../shared/meshes` beside the repository, or what SMOOTH_POLYLINES_MESHES names. The meshes are not
part of the project; a test that needs one is skipped, with a message, where there is no folder.
Holds no assertions and no Blender.
"""

import functools
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

REPOSITORY = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Mesh:
    """A polygon mesh, its polygons cut into fans of triangles."""

    name: str
    positions: np.ndarray  # (V, 3) float64
    triangles: np.ndarray  # (F, 3) int32
    triangle_faces: np.ndarray  # (F,) int32: the polygon of each triangle


def find_mesh_folder() -> Path:
    """Where the shared test meshes are expected; it need not exist."""
    return Path(os.environ.get("SMOOTH_POLYLINES_MESHES") or REPOSITORY.parent / "shared" / "meshes")


def find_shared_mesh(name: str) -> Path:
    """Path of the shared mesh `name` (with its suffix); skips the test where there is no folder of meshes."""
    folder = find_mesh_folder()
    if not folder.is_dir():
        pytest.skip(
            f"needs the test mesh {name}, but there is no folder {folder}; set SMOOTH_POLYLINES_MESHES to the folder"
        )
    path = folder / name
    if not path.is_file():
        # A folder without the mesh is a mistake somewhere, and not a machine without meshes.
        raise FileNotFoundError(f"the folder of test meshes {folder} has no {name}")
    return path


@functools.cache
def load_shared_mesh(name: str) -> Mesh:
    """Read the shared mesh `name`, once a process; its arrays cannot be written to."""
    mesh = read_mesh(find_shared_mesh(name))
    for array in (mesh.positions, mesh.triangles, mesh.triangle_faces):
        array.setflags(write=False)
    return mesh


def read_mesh(path: Path) -> Mesh:
    """Read a file by its suffix: .obj, .ply (ASCII or binary), .off, .stl (ASCII or binary)."""
    readers = {".obj": read_obj, ".ply": read_ply, ".off": read_off, ".stl": read_stl}
    positions, polygons = readers[path.suffix.lower()](path)
    triangles, triangle_faces = triangulate_fans(polygons)
    return Mesh(path.name, np.ascontiguousarray(positions, dtype=np.float64), triangles, triangle_faces)


def triangulate_fans(polygons: np.ndarray | Iterable[Sequence[int]]) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (F, 3) and the polygon of each (F,), both int32, fanned from each polygon's first corner."""
    if isinstance(polygons, np.ndarray):
        return polygons.astype(np.int32), np.arange(len(polygons), dtype=np.int32)
    triangles, faces = [], []
    for face, polygon in enumerate(polygons):
        for i in range(1, len(polygon) - 1):
            triangles.append((polygon[0], polygon[i], polygon[i + 1]))
            faces.append(face)
    return np.array(triangles, dtype=np.int32).reshape(-1, 3), np.array(faces, dtype=np.int32)


def read_obj(path: Path) -> tuple[np.ndarray, list[list[int]]]:
    """Positions and polygons of a Wavefront OBJ; texture and normal indices are passed over."""
    positions, polygons = [], []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            positions.append([float(word) for word in words[1:4]])
        elif words[0] == "f":
            corners = [int(word.split("/")[0]) for word in words[1:]]
            # Counted from 1, or backwards from the last vertex so far.
            polygons.append([c - 1 if c > 0 else len(positions) + c for c in corners])
    return np.array(positions, dtype=np.float64).reshape(-1, 3), polygons


def read_off(path: Path) -> tuple[np.ndarray, list[list[int]]]:
    """Positions and polygons of an OFF file; colours after the corners are passed over."""
    lines = (line.split("#")[0].split() for line in path.read_text(encoding="utf-8").splitlines())
    rows = iter([words for words in lines if words])
    header = next(rows)
    if not header[0].endswith("OFF"):
        raise ValueError(f"{path.name} does not begin with OFF")
    counts = header[1:] or next(rows)
    vertex_count, face_count = int(counts[0]), int(counts[1])
    positions = np.array([next(rows)[:3] for _ in range(vertex_count)], dtype=np.float64)
    polygons = []
    for _ in range(face_count):
        words = next(rows)
        polygons.append([int(word) for word in words[1 : 1 + int(words[0])]])
    return positions, polygons


PLY_TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float32": "f4",
    "float64": "f8",
}


def read_ply(path: Path) -> tuple[np.ndarray, np.ndarray | list[list[int]]]:
    """Positions and polygons of a PLY whose first elements are `vertex` and `face`, the latter one list."""
    data = path.read_bytes()
    marker = b"end_header"
    body_start = data.index(b"\n", data.index(marker)) + 1
    header = data[:body_start].decode("ascii").splitlines()
    order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[header[1].split()[1]]
    elements: dict[str, tuple[int, list[list[str]]]] = {}
    for words in (line.split() for line in header[2:]):
        if words[0] == "element":
            elements[words[1]] = (int(words[2]), [])
            last = words[1]
        elif words[0] == "property":
            elements[last][1].append(words[1:])
    if list(elements)[:2] != ["vertex", "face"] or [p[0] for p in elements["face"][1]] != ["list"]:
        raise ValueError(f"{path.name} has other elements than this small reader knows: {elements}")
    vertex_count, vertex_properties = elements["vertex"]
    face_count, ((_, count_type, index_type, _),) = elements["face"]
    names = [p[-1] for p in vertex_properties]

    if not order:
        rows = iter(data[body_start:].decode("ascii").splitlines())
        table = np.array([next(rows).split() for _ in range(vertex_count)], dtype=np.float64)
        polygons = [[int(word) for word in next(rows).split()[1:]] for _ in range(face_count)]
        return table[:, [names.index(axis) for axis in "xyz"]], polygons

    vertex_type = np.dtype([(p[-1], order + PLY_TYPES[p[0]]) for p in vertex_properties])
    vertices = np.frombuffer(data, vertex_type, vertex_count, body_start)
    positions = np.stack([vertices[axis] for axis in "xyz"], axis=1).astype(np.float64)
    face_start = body_start + vertex_count * vertex_type.itemsize
    count_dtype, index_dtype = np.dtype(order + PLY_TYPES[count_type]), np.dtype(order + PLY_TYPES[index_type])
    triangle_type = np.dtype([("count", count_dtype), ("corners", index_dtype, 3)])
    if len(data) - face_start >= face_count * triangle_type.itemsize:
        faces = np.frombuffer(data, triangle_type, face_count, face_start)
        if (faces["count"] == 3).all():
            return positions, faces["corners"]
    polygons = []
    for _ in range(face_count):
        count = int(np.frombuffer(data, count_dtype, 1, face_start)[0])
        face_start += count_dtype.itemsize
        polygons.append(np.frombuffer(data, index_dtype, count, face_start).tolist())
        face_start += count * index_dtype.itemsize
    return positions, polygons


def read_stl(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Positions and triangles of an STL, corners at exactly the same place made one vertex."""
    data = path.read_bytes()
    count = int(np.frombuffer(data, "<u4", 1, 80)[0]) if len(data) >= 84 else -1
    if len(data) == 84 + 50 * count:
        record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
        corners = np.frombuffer(data, record, count, 84)["corners"].reshape(-1, 3).astype(np.float64)
    else:
        words = (line.split() for line in data.decode("ascii").splitlines())
        corners = np.array([row[1:4] for row in words if row[:1] == ["vertex"]], dtype=np.float64)
    positions, indices = np.unique(corners, axis=0, return_inverse=True)
    return positions, indices.reshape(-1, 3)
