# SPDX-License-Identifier: GPL-3.0-or-later
"""The tool in the toolbars of Object and Edit Mode. Holds nothing else."""

import bpy

from .. import settings
from .operator import VIEW3D_OT_smooth_polyline_draw

# In the header of the tool itself; the rest is behind a button.
SHOWN = ("filter", "output", "bevel", "resample")
KEYMAP = ((VIEW3D_OT_smooth_polyline_draw.bl_idname, {"type": "LEFTMOUSE", "value": "PRESS"}, None),)


class DrawInObjectMode(bpy.types.WorkSpaceTool):
    """Object Mode."""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = "smooth_polylines.draw"
    bl_label = "Smooth Polyline"
    bl_description = "Click or draw on a mesh to make a smooth line that lies on it"
    bl_icon = "ops.curve.draw"
    bl_keymap = KEYMAP

    @staticmethod
    def draw_settings(_context: bpy.types.Context, layout: bpy.types.UILayout, tool: bpy.types.WorkSpaceTool) -> None:
        """What the next line will be: in the tool's header, the sidebar and the Properties editor."""
        wishes = tool.operator_properties(VIEW3D_OT_smooth_polyline_draw.bl_idname)
        for name in SHOWN:
            layout.prop(wishes, name)
        layout.popover("VIEW3D_PT_smooth_polyline_tool", text="More")


class DrawInEditMode(DrawInObjectMode):
    """Edit Mode of meshes."""

    bl_context_mode = "EDIT_MESH"
    bl_idname = "smooth_polylines.draw_in_edit_mode"


class VIEW3D_PT_smooth_polyline_tool(bpy.types.Panel):
    """All settings of the next line"""

    bl_space_type = "VIEW_3D"
    bl_region_type = "HEADER"
    bl_label = "Smooth Polyline"

    def draw(self, context: bpy.types.Context) -> None:
        """As in the panel of the last operation."""
        active = context.workspace.tools.from_space_view3d_mode(context.mode, create=False)
        if active is not None and active.idname in {tool.bl_idname for tool in TOOLS}:
            wishes = active.operator_properties(VIEW3D_OT_smooth_polyline_draw.bl_idname)
            settings.draw_new_line_settings(self.layout, wishes)


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
