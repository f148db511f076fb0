# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps curves on a mesh that moves: by pose, shape keys, modifiers, or an edit of its vertices.

The points keep their triangles and weights; nothing is smoothed again. Only what has really moved is written. A mesh
that has been rebuilt makes the line anew, by `session.update_curve`. Holds the handlers and nothing that they need to
know.
"""

from functools import partial

import numpy as np

import bpy
from bpy.app.handlers import persistent

from .. import curve_write, guard, line_points, mesh_read, session, surface_offset
from . import memory


@persistent
def on_frame(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """After a frame has been reached, in the viewport and in renders."""
    follow_all(depsgraph or bpy.context.evaluated_depsgraph_get(), None)


@persistent
def on_update(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """After something has been evaluated: only meshes whose shape has changed matter."""
    changed = {
        update.id.original.session_uid
        for update in depsgraph.updates
        if update.is_updated_geometry and isinstance(update.id, (bpy.types.Object, bpy.types.Mesh))
    }
    if changed:
        follow_all(depsgraph, changed)


HANDLERS = ((bpy.app.handlers.frame_change_post, on_frame), (bpy.app.handlers.depsgraph_update_post, on_update))


def follow_all(depsgraph: bpy.types.Depsgraph, changed: set[int] | None) -> None:
    """Follow every curve that remembers, where its mesh is among `changed` (None: whatever it is)."""
    for curve in bpy.data.curves:
        known = curve.smooth_polyline
        mesh_object = known.surface
        if not known.stored or curve.library is not None or memory.is_mesh_gone(known) or mesh_object.type != "MESH":
            continue
        # What is being edited is followed when the edit is over: until then its buffers are not to be had cheaply.
        if mesh_object.data.is_editmode:
            continue
        is_edited = changed is not None and mesh_object.data.session_uid in changed
        if changed is None or is_edited or mesh_object.session_uid in changed:
            guard.run_quietly(partial(follow_curve, curve, mesh_object, depsgraph, is_edited))


def follow_curve(
    curve: bpy.types.Curve, mesh_object: bpy.types.Object, depsgraph: bpy.types.Depsgraph, is_edited: bool
) -> None:
    """Place the points of `curve` on the evaluated mesh; nothing where modifiers change who is joined to whom."""
    known = curve.smooth_polyline
    vertices, weights, topology = memory.read_points(known.stored)
    if is_edited and list(mesh_read.measure_topology(mesh_object.data)) != topology:
        if known.state != "STALE":
            message = guard.run_quietly(lambda: session.update_curve(None, curve))
            if message is not None:
                known.state, known.message = "STALE", message
        return
    mesh = mesh_object.evaluated_get(depsgraph).data
    if [len(mesh.vertices), len(mesh.polygons)] != topology[:2]:
        return
    positions = mesh_read.read_floats(mesh.attributes["position"].data, "vector", len(mesh.vertices))
    points = line_points.place_points(vertices, weights, positions)
    if known.offset != 0.0:
        normals = mesh_read.read_floats(mesh.vertex_normals, "vector", len(mesh.vertices))
        matrix = np.array(mesh_object.matrix_world, dtype=np.float64)
        points = surface_offset.lift_points(points, vertices, weights, normals, matrix, known.offset)
    curve_write.write_points(curve, points, closed=known.closed)


def register() -> None:
    """Add the handlers."""
    for handlers, handler in HANDLERS:
        handlers.append(handler)


def unregister() -> None:
    """Remove them; those that are not there do no harm."""
    for handlers, handler in HANDLERS:
        if handler in handlers:
            handlers.remove(handler)
