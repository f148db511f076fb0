# SPDX-License-Identifier: GPL-3.0-or-later
"""The places in Blender's menus where our operators are found. Holds nothing else."""

import bpy

from .operators.add_polyline import MESH_OT_smooth_polyline_add


def draw_face_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """Edit Mode > Face."""
    menu.layout.separator()
    menu.layout.operator(MESH_OT_smooth_polyline_add.bl_idname)


def draw_context_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    """The right-click menu of Edit Mode, while faces are being selected."""
    if context.tool_settings.mesh_select_mode[2]:
        menu.layout.separator()
        menu.layout.operator(MESH_OT_smooth_polyline_add.bl_idname)


ENTRIES = (
    ("VIEW3D_MT_edit_mesh_faces", draw_face_menu),
    ("VIEW3D_MT_edit_mesh_context_menu", draw_context_menu),
)


def register() -> None:
    """Append our entries."""
    for menu, draw in ENTRIES:
        getattr(bpy.types, menu).append(draw)


def unregister() -> None:
    """Remove them, in reverse; entries that are not there do no harm."""
    for menu, draw in reversed(ENTRIES):
        getattr(bpy.types, menu).remove(draw)
