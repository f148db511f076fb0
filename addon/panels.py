# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the settings of a curve that remembers are shown: its data in the Properties editor, and the sidebar.

Holds the layout alone: `live.memory` makes the line again when a setting changes.
"""

import textwrap

import bpy

from . import settings
from .draw_tool.operator import VIEW3D_OT_smooth_polyline_draw
from .live import memory
from .operators.update_curve import CURVE_OT_smooth_polyline_update

# Letters in a row of a narrow panel.
MESSAGE_WIDTH = 38
ICONS = {"CURRENT": "CHECKMARK", "FOUND_AGAIN": "INFO", "STALE": "ERROR"}


class CurvePanel:
    """What both panels share."""

    bl_label = "Smooth Polyline"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether the active object is a curve that remembers."""
        active = context.object
        return active is not None and active.type == "CURVE" and bool(active.data.smooth_polyline.stored)

    def draw(self, context: bpy.types.Context) -> None:
        """The state and its message, the mesh, the settings, and the button that makes the line again."""
        known = context.object.data.smooth_polyline
        layout = self.layout
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
        settings.draw_line_settings(layout, known)
        layout.operator(CURVE_OT_smooth_polyline_update.bl_idname, text="Update", icon="FILE_REFRESH")
        if context.region_data is not None:  # in the 3D view alone
            edit = layout.operator(VIEW3D_OT_smooth_polyline_draw.bl_idname, text="Edit Picks", icon="GREASEPENCIL")
            edit.curve = context.object.name


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


CLASSES = (DATA_PT_smooth_polyline, VIEW3D_PT_smooth_polyline)
