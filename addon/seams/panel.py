# SPDX-License-Identifier: GPL-3.0-or-later
"""Seams in the sidebar of the 3D view: buttons for what is done with lines and edge marks. Holds the layout alone."""

import bpy

from ..operators.copy_marks import MESH_OT_smooth_polyline_copy_marks, MESH_OT_smooth_polyline_mirror_marks
from ..operators.put_lines import MESH_OT_smooth_polyline_seam
from ..operators.put_net import MESH_OT_smooth_polyline_net
from . import choose, settings


class VIEW3D_PT_smooth_polyline_seams(bpy.types.Panel):
    """Seams"""

    bl_label = "Seams"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Smooth Polyline"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether something is active that can have lines or be one."""
        return choose.is_possible(context)

    def draw(self, context: bpy.types.Context) -> None:
        """A button a method; below them what is done with marks that are there."""
        layout = self.layout
        row = layout.row(align=True)
        for method, name, _ in settings.METHODS:
            row.operator(MESH_OT_smooth_polyline_seam.bl_idname, text=name).method = method
        column = layout.column(align=True)
        if context.mode == "EDIT_MESH":
            column.operator(MESH_OT_smooth_polyline_net.bl_idname)
        column.operator(MESH_OT_smooth_polyline_mirror_marks.bl_idname)
        if context.mode == "OBJECT":
            column.operator(MESH_OT_smooth_polyline_copy_marks.bl_idname)
