# SPDX-License-Identifier: GPL-3.0-or-later
"""Places the points of a curve that remembers on the shape that its mesh has now, after modifiers.

The points keep their mesh vertices and weights; nothing is smoothed. Holds no handler.
"""

from typing import Any

import numpy as np

import bpy

from .. import line_data, line_points, mesh_read, surface_offset
from . import memory


def place_on_shape(curve: Any, mesh_object: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
    """Write the points of `curve` where they lie on the evaluated mesh; nothing where modifiers change its topology.

    A mesh in Edit Mode is left for later: its buffers are not to be had cheaply until the edit is over. So is a line
    that is being edited itself.
    """
    if mesh_object.data.is_editmode or line_data.is_being_edited(curve):
        return
    known = memory.get_memory(curve)
    vertices, weights, _ = memory.read_points(known.stored)
    mesh = mesh_object.evaluated_get(depsgraph).data
    if not has_counts(curve, mesh):
        return
    positions = mesh_read.read_floats(mesh.attributes["position"].data, "vector", len(mesh.vertices))
    points = line_points.place_points(vertices, weights, positions)
    if known.offset != 0.0:
        normals = mesh_read.read_floats(mesh.vertex_normals, "vector", len(mesh.vertices))
        matrix = np.array(mesh_object.matrix_world, dtype=np.float64)
        points = surface_offset.lift_points(points, vertices, weights, normals, matrix, known.offset)
    line_data.write_points(curve, points, closed=known.closed)


def has_counts(curve: Any, mesh: bpy.types.Mesh) -> bool:
    """Whether `mesh` has as many vertices and polygons as the mesh that the line was made on."""
    return [len(mesh.vertices), len(mesh.polygons)] == memory.read_points(memory.get_memory(curve).stored)[2][:2]
