"""Reads mesh files through meshio, or trimesh where meshio cannot: `pip install 'smooth-polylines[formats]'`.

Wavefront .obj it reads itself: meshio refuses files with more texture coordinates than vertices, as most with UV seams
have, and trimesh tears the mesh apart along those seams. Only for the command and for quick trials: the library itself
takes arrays. Knows no lines.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

HOW_TO_INSTALL = "pip install 'smooth-polylines[formats]'"
POLYGONS = ("triangle", "quad", "polygon")


class MeshFileError(Exception):
    """Why a file gives no mesh, and what to do."""


@dataclass(frozen=True)
class ReadMesh:
    """A mesh as `SurfaceMesh` takes it; faces are numbered as in the file."""

    positions: NDArray[np.float64]  # (V, 3)
    triangles: NDArray[np.int64]  # (F, 3)
    triangle_faces: NDArray[np.int64]  # (F,) the face of the file that each triangle is a part of
    reader: str


def read_mesh(path: Path) -> ReadMesh:
    r"""Read the file at `path`; MeshFileError where there is no such file, no reader, or no face in it.

    Faces with more than three corners are cut into fans, and keep their number.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "square.obj")
    ...     _ = path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    ...     read = read_mesh(path)
    >>> read.triangles.tolist(), read.triangle_faces.tolist()
    ([[0, 1, 2], [0, 2, 3]], [0, 0])
    """
    if not path.is_file():
        raise MeshFileError("there is no such file")
    if path.suffix.lower() == ".obj":
        return read_obj(path)
    faults = []
    for reader in (read_by_meshio, read_by_trimesh):
        try:
            return reader(path)
        except ImportError as error:
            faults.append(f"{error.name} is not installed ({HOW_TO_INSTALL})")
        except MeshFileError as error:
            faults.append(str(error))
    raise MeshFileError("; ".join(faults))


def read_obj(path: Path) -> ReadMesh:
    """The vertices and faces of a Wavefront file, by its own numbers; all else in it is passed over."""
    positions: list[list[float]] = []
    faces: list[list[int]] = []
    text = path.read_text(encoding="utf-8", errors="replace").replace("\\\n", " ")
    for number, row in enumerate(text.splitlines(), start=1):
        kind, *words = row.split("#")[0].split() or [""]
        try:
            if kind == "v":
                x, y, z = map(float, words[:3])
                positions.append([x, y, z])
            elif kind == "f":
                faces.append([find_corner(int(word.split("/")[0]), len(positions)) for word in words])
        except ValueError as error:
            found = " ".join(row.split())[:60]
            raise MeshFileError(f"its row {number} is no vertex or face of a Wavefront file: {found!r}") from error
    return cut_into_fans(np.array(positions, dtype=np.float64).reshape(-1, 3), faces, "smooth_polylines")


def find_corner(number: int, count: int) -> int:
    """The place of a vertex that counts from 1, or backwards from the last of `count` before it."""
    if number == 0 or number < -count:
        raise ValueError(number)
    return number - 1 if number > 0 else count + number


def read_by_meshio(path: Path) -> ReadMesh:
    """By meshio, which keeps polygons; ImportError without it."""
    import meshio

    try:
        # Its readers print, and some end the process, where they fail.
        mesh = meshio.read(path)
    except (Exception, SystemExit) as error:
        raise MeshFileError(f"meshio cannot read it ({describe(error)})") from error
    faces = [row for block in mesh.cells if block.type in POLYGONS for row in np.asarray(block.data).tolist()]
    return cut_into_fans(np.asarray(mesh.points, dtype=np.float64), faces, "meshio")


def read_by_trimesh(path: Path) -> ReadMesh:
    """By trimesh, whose faces are triangles; ImportError without it."""
    import trimesh

    try:
        mesh = trimesh.load(path, force="mesh", process=False)
    except Exception as error:
        raise MeshFileError(f"trimesh cannot read it ({describe(error)})") from error
    return cut_into_fans(np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces).tolist(), "trimesh")


def cut_into_fans(positions: NDArray[np.float64], faces: list[list[int]], reader: str) -> ReadMesh:
    """Triangles of polygons, fanned from the first corner of each."""
    if not faces:
        raise MeshFileError(f"{reader} finds no faces in it")
    if positions.shape[1] == 2:
        positions = np.column_stack([positions, np.zeros(len(positions))])
    triangles = [(face[0], face[k], face[k + 1]) for face in faces for k in range(1, len(face) - 1)]
    owners = [number for number, face in enumerate(faces) for _ in range(len(face) - 2)]
    return ReadMesh(positions, np.array(triangles, dtype=np.int64), np.array(owners, dtype=np.int64), reader)


def describe(error: BaseException) -> str:
    """An error of another library in one line."""
    words = " ".join(str(error).split())
    return words[:200] if words and words != "1" else type(error).__name__
