# SPDX-License-Identifier: GPL-3.0-or-later
"""What is active, edited and selected, also where the context does not say: in timers and handlers there is no window.

Reads only. Where Blender's context has an answer, as a pinned Properties editor gives one, that is it.
"""

from typing import Any

import bpy


def get_active(context: bpy.types.Context) -> bpy.types.Object | None:
    """The active object."""
    return read(context, "object", lambda: context.view_layer.objects.active)


def get_edited(context: bpy.types.Context) -> bpy.types.Object | None:
    """The active object, if it is in Edit Mode."""

    def find() -> bpy.types.Object | None:
        active = get_active(context)
        return active if active is not None and active.mode == "EDIT" else None

    return read(context, "edit_object", find)


def list_edited_meshes(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The mesh objects in Edit Mode, one for each mesh."""
    found = read(
        context,
        "objects_in_mode_unique_data",
        lambda: {o.data: o for o in context.view_layer.objects if o.mode == "EDIT"}.values(),
    )
    return [o for o in found if o.type == "MESH"]


def list_selected(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The selected objects that can be seen."""
    return list(
        read(
            context,
            "selected_objects",
            lambda: [o for o in context.view_layer.objects if o.select_get() and o.visible_get()],
        )
    )


def is_mesh_active(context: bpy.types.Context) -> bool:
    """Whether the active object is a mesh."""
    found = get_active(context)
    return found is not None and found.type == "MESH"


def is_editing_mesh(context: bpy.types.Context) -> bool:
    """Whether Blender is in Edit Mode of a mesh."""
    edited = get_edited(context)
    return edited is not None and edited.type == "MESH"


def is_in_object_mode(context: bpy.types.Context) -> bool:
    """Whether Blender is in Object Mode."""
    active = context.view_layer.objects.active
    return active is None or active.mode == "OBJECT"


def read(context: bpy.types.Context, name: str, find: Any) -> Any:
    """A member of the context; what `find` finds where there is none."""
    try:
        return getattr(context, name)
    except AttributeError:
        return find()
