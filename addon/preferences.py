# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's preferences. Holds nothing but them."""

import bpy
from bpy.props import FloatProperty


class SmoothPolylinePreferences(bpy.types.AddonPreferences):
    """What is set once for all files"""

    bl_idname = __package__

    time_limit: FloatProperty(
        name="Time Limit",
        description="Longest time for a line that cannot be stopped by Esc: after a change of a setting; 0: no limit",
        default=20.0,
        min=0.0,
        soft_max=600.0,
        subtype="TIME_ABSOLUTE",
        unit="TIME_ABSOLUTE",
    )

    def draw(self, _context: bpy.types.Context) -> None:
        """One row."""
        self.layout.prop(self, "time_limit")


def get_time_limit() -> float | None:
    """Seconds; None: no limit, as without a window, where nobody waits."""
    if bpy.app.background:
        return None
    addon = bpy.context.preferences.addons.get(__package__)
    return (addon.preferences.time_limit or None) if addon is not None else None


CLASSES = (SmoothPolylinePreferences,)
