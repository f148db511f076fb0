# SPDX-License-Identifier: GPL-3.0-or-later
"""Smooth Polylines for Blender: registers what the other modules define, and takes it back.

Holds no logic. Scripts find theirs in `session.add_polyline`.
"""

import bpy

from . import draw_tool, live, menus, operators, panels, preferences, surface

CLASSES = (*preferences.CLASSES, *live.CLASSES, *operators.CLASSES, *draw_tool.CLASSES, *panels.CLASSES)


def register() -> None:
    """Make the operators and menu entries known; on a failure nothing stays behind."""
    try:
        for cls in CLASSES:
            bpy.utils.register_class(cls)
        live.register()
        draw_tool.register()
        menus.register()
    except BaseException:
        unregister()
        raise


def unregister() -> None:
    """Take everything back, also after a registration that failed half-way."""
    surface.forget_surfaces()
    menus.unregister()
    draw_tool.unregister()
    live.unregister()
    for cls in reversed(CLASSES):
        if cls.is_registered:
            bpy.utils.unregister_class(cls)
