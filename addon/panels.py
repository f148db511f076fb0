# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the settings of a curve that remembers are shown: its data in the Properties editor, and the sidebar.

Holds the layout alone: `live.memory` makes the line again when a setting changes.
"""

import textwrap

import bpy

from . import line_data, settings
from .draw_tool.edit_picks import VIEW3D_OT_smooth_polyline_edit_picks
from .draw_tool.operator import VIEW3D_OT_smooth_polyline_draw
from .live import memory
from .operators.change_line import CURVE_OT_smooth_polyline_update, OBJECT_OT_smooth_polyline_change_output
from .seams.panel import VIEW3D_PT_smooth_polyline_seams

# Letters in a row of a narrow panel.
MESSAGE_WIDTH = 38
ICONS = {"CURRENT": "CHECKMARK", "FOUND_AGAIN": "INFO", "STALE": "ERROR"}


class CurvePanel:
    """What both panels share."""

    bl_label = "Smooth Polyline"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether the active object is a curve that remembers."""
        return memory.find_memory(context.object) is not None

    def draw(self, context: bpy.types.Context) -> None:
        """The button that edits the picks, the state and its message, the mesh, the settings."""
        line_object = context.object
        known, output = memory.find_memory(line_object), line_data.get_output(line_object.data)
        layout = self.layout
        row = layout.row()
        kind = VIEW3D_OT_smooth_polyline_edit_picks
        if context.space_data.type == "VIEW_3D":
            # Not in the sidebar, which has no view.
            row.operator_context = "INVOKE_REGION_WIN"
            kind = VIEW3D_OT_smooth_polyline_draw
        row.operator(kind.bl_idname, text="Edit Picks", icon="GREASEPENCIL").curve = line_object.name
        # A pointer that lost its object is no state that anything could have written down.
        state, message = known.state, known.message
        if memory.is_mesh_gone(known):
            state, message = "STALE", "The mesh is gone; the curve stays as it is"
        if state != "CURRENT":
            column = layout.column(align=True)
            for number, row in enumerate(textwrap.wrap(message, MESSAGE_WIDTH)):
                column.label(text=row, icon=ICONS[state] if number == 0 else "BLANK1")
        layout.use_property_split = True
        layout.prop(known, "surface")
        settings.draw_line_settings(layout, known, output)
        layout.separator()
        (kind,) = [label for name, label, _ in line_data.OUTPUTS if name == output]
        split = layout.split(factor=0.4)
        split.label(text="Output")
        split.operator_menu_enum(OBJECT_OT_smooth_polyline_change_output.bl_idname, "output", text=kind)
        layout.prop(line_object, "name")
        layout.prop_search(line_object, "smooth_polyline_collection", bpy.data, "collections", text="Collection")
        layout.prop_search(line_object, "smooth_polyline_material", bpy.data, "materials", text="Material")
        layout.operator(CURVE_OT_smooth_polyline_update.bl_idname, text="Update", icon="FILE_REFRESH")


class DATA_PT_smooth_polyline(CurvePanel, bpy.types.Panel):
    """Properties editor, the tab of the curve's data."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"


class VIEW3D_PT_smooth_polyline(CurvePanel, bpy.types.Panel):
    """Sidebar of the 3D view."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Smooth Polyline"


CLASSES = (DATA_PT_smooth_polyline, VIEW3D_PT_smooth_polyline, VIEW3D_PT_smooth_polyline_seams)
