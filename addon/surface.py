# SPDX-License-Identifier: GPL-3.0-or-later
"""Opened meshes, kept for the next line as long as the mesh stays as it is.

A mesh counts as changed when its positions, faces, hidden marks or world matrix have: their checksum is taken each
time, some milliseconds for a million triangles, so no edit goes unnoticed, whoever made it. Holds no Blender object
between calls.
"""

from collections import OrderedDict
from dataclasses import dataclass
from typing import Any

import numpy as np

import bpy

from . import ahead, mesh_read, native

# Opened meshes that are kept; a scan of a million triangles takes some 200 MB.
MOST_SURFACES = 3


@dataclass(frozen=True)
class Surface:
    """A mesh object's faces, ready for lines in world space."""

    library_mesh: Any  # smooth_polylines.SurfaceMesh over the world positions
    arrays: mesh_read.MeshArrays


@dataclass(frozen=True)
class Reading:
    """What was read of a mesh, to be made ready for lines."""

    key: tuple[int, str, bool]
    fingerprint: int
    arrays: mesh_read.MeshArrays


_surfaces: OrderedDict[tuple[int, str, bool], tuple[int, Surface]] = OrderedDict()


def open_surface(
    context: bpy.types.Context | None,
    mesh_object: bpy.types.Object,
    *,
    source: str = "BASE",
    with_normals: bool = False,
) -> Surface:
    """The surface of `mesh_object` as it is now, in Edit Mode or out of it.

    source : BASE: the mesh as it is edited; EVALUATED: after its modifiers
    context : None where everything has just been evaluated, as in a handler

    Raises ObjectError, LibraryError, or the library's `smooth_polylines.Error`.
    """

    def make(found: Surface | Reading, _options: dict[str, Any]) -> Surface:
        return found if isinstance(found, Surface) else keep_surface(found, make_ready(found))

    return ahead.do(lambda: find_or_read(context, mesh_object, source=source, with_normals=with_normals), make)


def find_or_read(
    context: bpy.types.Context | None,
    mesh_object: bpy.types.Object,
    *,
    source: str = "BASE",
    with_normals: bool = False,
) -> Surface | Reading:
    """The kept surface, where the mesh is as it was; else what has been read of it, for `make_ready`."""
    native.load_library()
    if context is not None:
        # A script may have moved the object a line ago.
        context.view_layer.update()
    key = (mesh_object.session_uid, source, with_normals)
    fingerprint = mesh_read.measure_fingerprint(mesh_object, source)
    kept = _surfaces.get(key)
    if kept is not None and kept[0] == fingerprint:
        _surfaces.move_to_end(key)
        return kept[1]
    _surfaces.pop(key, None)  # before the new one is made: two large ones need not be held at once
    return Reading(key, fingerprint, mesh_read.read_mesh(mesh_object, source=source, with_normals=with_normals))


def make_ready(reading: Reading, with_tree: bool = False) -> Surface:
    """The slow part of opening, which touches nothing of Blender and so may run in a thread.

    with_tree : make what rays and nearest points are found by now, not when they are first asked for
    """
    arrays = reading.arrays
    library_mesh = native.load_library().SurfaceMesh(arrays.world_positions, arrays.triangles, arrays.triangle_faces)
    if with_tree:
        library_mesh.ray_cast(arrays.world_positions[:1], np.array([[0.0, 0.0, 1.0]]))
    return Surface(library_mesh, arrays)


def keep_surface(reading: Reading, surface: Surface) -> Surface:
    """Keep an opened surface for the next line."""
    _surfaces[reading.key] = (reading.fingerprint, surface)
    while len(_surfaces) > MOST_SURFACES:
        _surfaces.popitem(last=False)
    return surface


def forget_surfaces() -> None:
    """Free what is kept."""
    _surfaces.clear()
