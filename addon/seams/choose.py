# SPDX-License-Identifier: GPL-3.0-or-later
"""Which mesh and which lines an artist means by what is selected. Reads only."""

import bpy

from .. import active
from ..errors import ObjectError
from ..live import memory
from . import strokes

HOW_TO_SELECT = "Select the curves and, last, the mesh; or pick faces in Edit Mode, one after another"


def find_mesh_object(context: bpy.types.Context) -> bpy.types.Object:
    """The mesh that is edited or active, else the one that the selected lines lie on; ObjectError when none is."""
    active_object = active.get_active(context)
    if active_object is not None and active_object.type == "MESH" and not strokes.is_line(active_object):
        return active_object
    meshes = [o for o in active.list_selected(context) if o.type == "MESH" and not strokes.is_line(o)]
    if not meshes:
        lines = find_line_objects(context)
        remembered = [known.surface for known in map(memory.find_memory, lines) if known is not None]
        parents = [o.parent for o in lines if o.parent is not None and o.parent.type == "MESH"]
        meshes = [o for o in dict.fromkeys(remembered or parents) if o is not None]
    if len(meshes) == 1:
        return meshes[0]
    if meshes:
        raise ObjectError(
            f"{len(meshes)} meshes could be meant ({', '.join(o.name for o in meshes)}); make one the active object"
        )
    raise ObjectError(f"No mesh is selected. {HOW_TO_SELECT}")


def find_line_objects(context: bpy.types.Context) -> list[bpy.types.Object]:
    """Selected curves, grease pencil and meshes of edges alone, by name: a selection has no order."""
    return sorted(
        (o for o in context.view_layer.objects if o.select_get() and strokes.is_line(o)), key=lambda o: o.name
    )


def is_possible(context: bpy.types.Context) -> bool:
    """Whether there can be a mesh and a line: cheap, for polls."""
    active_object = active.get_active(context)
    if active_object is None:
        return False
    if active_object.type == "MESH":
        return active_object.mode in {"EDIT", "OBJECT"}
    return strokes.is_line(active_object) and active.is_in_object_mode(context)
