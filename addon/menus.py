# SPDX-License-Identifier: GPL-3.0-or-later
"""The places in Blender's menus where our operators are found. Holds nothing else."""

import bpy

from .operators.add_polyline import MESH_OT_smooth_polyline_add
from .operators.copy_marks import MESH_OT_smooth_polyline_copy_marks, MESH_OT_smooth_polyline_mirror_marks
from .operators.put_lines import MESH_OT_smooth_polyline_seam
from .operators.put_net import MESH_OT_smooth_polyline_net


def draw_face_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """Edit Mode > Face."""
    menu.layout.separator()
    menu.layout.operator(MESH_OT_smooth_polyline_add.bl_idname)
    menu.layout.operator(MESH_OT_smooth_polyline_net.bl_idname)


def draw_context_menu(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    """The right-click menu of Edit Mode, while faces are being selected."""
    if context.tool_settings.mesh_select_mode[2]:
        menu.layout.separator()
        menu.layout.operator(MESH_OT_smooth_polyline_add.bl_idname)


def draw_edge_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """Edit Mode > Edge."""
    menu.layout.separator()
    menu.layout.operator(MESH_OT_smooth_polyline_seam.bl_idname)
    menu.layout.operator(MESH_OT_smooth_polyline_mirror_marks.bl_idname)


def draw_object_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """Object Mode > Object."""
    menu.layout.separator()
    menu.layout.operator(MESH_OT_smooth_polyline_seam.bl_idname)


def draw_link_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """Object Mode > Object > Link/Transfer Data."""
    menu.layout.separator()
    menu.layout.operator(MESH_OT_smooth_polyline_copy_marks.bl_idname)


ENTRIES = (
    ("VIEW3D_MT_edit_mesh_faces", draw_face_menu),
    ("VIEW3D_MT_edit_mesh_edges", draw_edge_menu),
    ("VIEW3D_MT_object", draw_object_menu),
    ("VIEW3D_MT_make_links", draw_link_menu),
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
