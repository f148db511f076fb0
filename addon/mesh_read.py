# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays of a mesh object, as the library takes them: what is visible of it, now, in Edit Mode or out of it.

Only bulk transfers of Blender's own buffers, never a Python loop over the mesh. Writes nothing that outlives
the call. Knows no picks and no lines.
"""

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

import bpy

from .errors import ObjectError

# Smallest ratio of the world matrix's singular values: below the rounding of Blender's 32-bit matrices an axis
# counts as flattened, since nothing in world space tells its points apart any more.
SMALLEST_SCALE_RATIO = float(np.finfo(np.float32).eps)


@dataclass(frozen=True)
class MeshArrays:
    """What the library needs of a mesh; rows of `triangles` are Blender's loop triangles less the hidden ones."""

    local_positions: np.ndarray  # (V, 3) float64, the object's space
    world_positions: np.ndarray  # (V, 3) float64, world space
    triangles: np.ndarray  # (F, 3) int32, rows of the positions
    triangle_faces: np.ndarray  # (F,) int32, the polygon that each triangle is a part of
    local_normals: np.ndarray | None  # (V, 3) float64, unit, the object's space; only where asked for
    world_matrix: np.ndarray  # (4, 4) float64, local to world


def read_mesh(mesh_object: bpy.types.Object, *, source: str = "BASE", with_normals: bool = False) -> MeshArrays:
    """Read `mesh_object` as it is at this moment; ObjectError when there is nothing to walk on.

    source : BASE: the mesh as it is edited; EVALUATED: after its modifiers
    """
    world_matrix = read_world_matrix(mesh_object)
    with open_current_mesh(mesh_object, source) as mesh:
        local_positions = read_positions(mesh_object, mesh, source)
        triangles, triangle_faces = read_visible_triangles(mesh)
        local_normals = read_floats(mesh.vertex_normals, "vector", len(mesh.vertices)) if with_normals else None
    if len(triangles) == 0:
        raise ObjectError(
            f"{mesh_object.name} has no visible faces; a line needs faces to lie on: add some, or reveal the "
            "hidden ones (Mesh > Show/Hide > Reveal Hidden)"
        )
    return MeshArrays(
        local_positions=local_positions,
        # A plain product: exact where the matrix is the identity, so an unmoved object's world is its own space.
        world_positions=np.ascontiguousarray(local_positions @ world_matrix[:3, :3].T + world_matrix[:3, 3]),
        triangles=triangles,
        triangle_faces=triangle_faces,
        local_normals=local_normals,
        world_matrix=world_matrix,
    )


def read_world_matrix(mesh_object: bpy.types.Object) -> np.ndarray:
    """Local to world, (4, 4) float64; ObjectError when it flattens the object or is not finite."""
    matrix = np.array(mesh_object.matrix_world, dtype=np.float64)
    if not np.isfinite(matrix).all():
        raise ObjectError(f"The transform of {mesh_object.name} is not finite; clear its location, rotation and scale")
    scales = np.linalg.svd(matrix[:3, :3], compute_uv=False)
    if scales[2] <= SMALLEST_SCALE_RATIO * scales[0]:
        raise ObjectError(
            f"{mesh_object.name} is flattened in the world (scale 0 along an axis, its own or its parents'); "
            "give it a scale other than 0 along every axis"
        )
    return matrix


@contextmanager
def open_current_mesh(mesh_object: bpy.types.Object, source: str = "BASE") -> Iterator[bpy.types.Mesh]:
    """The object's mesh with its attributes readable and up to date, also while it is being edited."""
    if source == "EVALUATED":
        evaluated = mesh_object.evaluated_get(bpy.context.evaluated_depsgraph_get())
        try:
            yield evaluated.to_mesh()
        finally:
            evaluated.to_mesh_clear()
        return
    if not mesh_object.data.is_editmode:
        yield mesh_object.data
        return
    # In Edit Mode the mesh's buffers are stale and partly out of reach; a copy of the flushed mesh shares them
    # and has them all. The selection and its history stay as they are.
    mesh_object.update_from_editmode()
    copy = mesh_object.data.copy()
    try:
        yield copy
    finally:
        bpy.data.meshes.remove(copy)  # and its shape keys with it


def read_positions(mesh_object: bpy.types.Object, mesh: bpy.types.Mesh, source: str = "BASE") -> np.ndarray:
    """Vertex positions in the object's space, (V, 3) float64: in Edit Mode those of the active shape key."""
    return read_floats(*find_positions(mesh_object, mesh, source), len(mesh.vertices))


def find_positions(
    mesh_object: bpy.types.Object, mesh: bpy.types.Mesh, source: str
) -> tuple[bpy.types.bpy_prop_collection, str]:
    """Where the positions are: rows, and the name of their property."""
    if source == "BASE" and mesh.shape_keys is not None and mesh_object.data.is_editmode:
        # What is seen and edited in Edit Mode is the active key, while the mesh itself keeps the basis.
        return mesh.shape_keys.key_blocks[mesh_object.active_shape_key_index].data, "co"
    if len(mesh.vertices) == 0:
        return mesh.vertices, "co"  # without vertices there may be no such attribute
    return mesh.attributes["position"].data, "vector"


def measure_fingerprint(mesh_object: bpy.types.Object, source: str = "BASE") -> int:
    """A checksum of all that `read_mesh` would read: equal as long as nothing of it has changed."""
    matrix = np.array(mesh_object.matrix_world, dtype=np.float64, order="C")
    with open_current_mesh(mesh_object, source) as mesh:
        positions = np.empty(3 * len(mesh.vertices), dtype=np.float32)
        rows, name = find_positions(mesh_object, mesh, source)
        rows.foreach_get(name, positions)
        checksum = zlib.crc32(positions, zlib.crc32(matrix))
        corners = read_corner_vertices(mesh)
        if len(corners) != 3 * len(mesh.polygons):
            # How many corners each polygon has, by its triangles: fifty times quicker than asking it.
            mesh.calc_loop_triangles()
            triangle_faces = np.empty(len(mesh.loop_triangles), dtype=np.int32)
            mesh.loop_triangle_polygons.foreach_get("value", triangle_faces)
            checksum = zlib.crc32(triangle_faces, checksum)
        return zlib.crc32(read_hidden(mesh), zlib.crc32(corners, checksum))


def measure_topology(mesh: bpy.types.Mesh) -> tuple[int, int, int]:
    """Vertices, polygons, and a checksum of who is joined to whom: equal for two states of a mesh that only moved."""
    return len(mesh.vertices), len(mesh.polygons), zlib.crc32(read_corner_vertices(mesh))


def read_corner_vertices(mesh: bpy.types.Mesh) -> np.ndarray:
    """The vertex of every corner, int32; a hundred times quicker than the vertices of the loop triangles."""
    corner_vertices = np.empty(len(mesh.loops), dtype=np.int32)
    if len(corner_vertices) > 0:  # without faces there is no such attribute
        mesh.attributes[".corner_vert"].data.foreach_get("value", corner_vertices)
    return corner_vertices


def read_hidden(mesh: bpy.types.Mesh) -> np.ndarray:
    """Which polygons are hidden, bool; empty when none has ever been."""
    hidden = mesh.attributes.get(".hide_poly")  # there only once something has been hidden
    is_hidden = np.empty(0 if hidden is None else len(mesh.polygons), dtype=bool)
    if hidden is not None:
        hidden.data.foreach_get("value", is_hidden)
    return is_hidden


def read_floats(rows: bpy.types.bpy_prop_collection, name: str, count: int) -> np.ndarray:
    """A vector property of `count` rows, (count, 3) float64, taken in Blender's 32 bits as one buffer."""
    values = np.empty(count * 3, dtype=np.float32)
    rows.foreach_get(name, values)
    return values.reshape(-1, 3).astype(np.float64)


def read_visible_triangles(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Blender's own loop triangles less those of hidden polygons, and the polygon of each, both int32."""
    corner_vertices = read_corner_vertices(mesh)
    if len(corner_vertices) == 3 * len(mesh.polygons):
        # Polygons have three corners at least, so these are all triangles, which Blender takes as they are; asking it
        # for each one's corners would take a hundred times as long.
        triangles = corner_vertices.reshape(-1, 3)
        triangle_faces = np.arange(len(triangles), dtype=np.int32)
    else:
        mesh.calc_loop_triangles()
        count = len(mesh.loop_triangles)
        corners = np.empty(count * 3, dtype=np.int32)
        mesh.loop_triangles.foreach_get("loops", corners)
        triangles = corner_vertices[corners].reshape(-1, 3)
        triangle_faces = np.empty(count, dtype=np.int32)
        mesh.loop_triangle_polygons.foreach_get("value", triangle_faces)

    is_hidden = read_hidden(mesh)
    if len(is_hidden) > 0:
        is_visible = ~is_hidden[triangle_faces]
        triangles, triangle_faces = triangles[is_visible], triangle_faces[is_visible]
    return np.ascontiguousarray(triangles), np.ascontiguousarray(triangle_faces)


def measure_mean_scale(world_matrix: np.ndarray) -> float:
    """How much longer lengths are in the world than in the object, on average over the axes (geometric mean)."""
    return float(np.cbrt(abs(np.linalg.det(world_matrix[:3, :3]))))
