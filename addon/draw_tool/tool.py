# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool in the toolbars of Object and Edit Mode. Holds nothing else."""

import bpy

from .operator import VIEW3D_OT_smooth_polyline_draw

KEYMAP = ((VIEW3D_OT_smooth_polyline_draw.bl_idname, {"type": "LEFTMOUSE", "value": "PRESS"}, None),)


class DrawInObjectMode(bpy.types.WorkSpaceTool):
    """Object Mode."""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = "smooth_polylines.draw"
    bl_label = "Smooth Polyline"
    bl_description = "Click on a mesh to draw a smooth line that lies on it"
    bl_icon = "ops.curve.draw"
    bl_keymap = KEYMAP


class DrawInEditMode(DrawInObjectMode):
    """Edit Mode of meshes."""

    bl_context_mode = "EDIT_MESH"
    bl_idname = "smooth_polylines.draw_in_edit_mode"


TOOLS = (DrawInObjectMode, DrawInEditMode)
_registered: list[type] = []


def register() -> None:
    """Put the tools after Blender's own; without an interface there are no toolbars."""
    if bpy.app.background:
        return
    for tool in TOOLS:
        bpy.utils.register_tool(tool, separator=True)
        _registered.append(tool)


def unregister() -> None:
    """Take them back."""
    while _registered:
        bpy.utils.unregister_tool(_registered.pop())
