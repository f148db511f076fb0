# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps curves on a mesh that moves: by pose, shape keys, modifiers, or an edit of its vertices.

The points keep their triangles and weights; nothing is smoothed again. Only what has really moved is written. A mesh
that has been rebuilt makes the line anew, by `session.update_curve`. Holds the handlers and nothing that they need to
know.
"""

from functools import partial
from typing import Any

import bpy
from bpy.app.handlers import persistent

from .. import ahead, guard, session
from . import memory, shape


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
    with ahead.at_work(None):
        follow_each(depsgraph, changed)


def follow_each(depsgraph: bpy.types.Depsgraph, changed: set[int] | None) -> None:
    """The same, whatever called the handler."""
    for curve in list(memory.list_remembering()):
        known = memory.get_memory(curve)
        mesh_object = known.surface
        if curve.library is not None or memory.is_mesh_gone(known) or mesh_object.type != "MESH":
            continue
        # What is being edited is followed when the edit is over: until then its buffers are not to be had cheaply.
        if mesh_object.data.is_editmode:
            continue
        if changed is None:
            # Reaching a frame rebuilds nothing: in a render the levels of modifiers may differ, and pass again.
            is_rebuilt = False
        elif mesh_object.data.session_uid in changed or mesh_object.session_uid in changed:
            is_rebuilt = is_mesh_rebuilt(curve, mesh_object, depsgraph, mesh_object.data.session_uid in changed)
        else:
            continue
        guard.run_quietly(partial(follow_curve, curve, mesh_object, depsgraph, is_rebuilt))


def is_mesh_rebuilt(curve: Any, mesh_object: bpy.types.Object, depsgraph: bpy.types.Depsgraph, is_edited: bool) -> bool:
    """Whether what the line was made on has other vertices or faces now; after modifiers only their numbers count."""
    if memory.get_memory(curve).source == "EVALUATED":
        return not shape.has_counts(curve, mesh_object.evaluated_get(depsgraph).data)
    return is_edited and not memory.is_on_topology(curve, mesh_object)


def follow_curve(curve: Any, mesh_object: bpy.types.Object, depsgraph: bpy.types.Depsgraph, is_rebuilt: bool) -> None:
    """Place the points of `curve` on the evaluated mesh; where the mesh was rebuilt, make its line again first."""
    known = memory.get_memory(curve)
    if is_rebuilt:
        if known.state == "STALE":
            return
        message = guard.run_quietly(partial(session.update_curve, None, curve))
        if message is not None:
            known.state, known.message = "STALE", message
            return
    shape.place_on_shape(curve, mesh_object, depsgraph)


def register() -> None:
    """Add the handlers."""
    for handlers, handler in HANDLERS:
        handlers.append(handler)


def unregister() -> None:
    """Remove them; those that are not there do no harm."""
    for handlers, handler in HANDLERS:
        if handler in handlers:
            handlers.remove(handler)
