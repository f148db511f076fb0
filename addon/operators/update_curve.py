# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the line of the active curve again, on its mesh as it is now. Holds no logic of its own."""

import bpy

from .. import guard, session


class CURVE_OT_smooth_polyline_update(bpy.types.Operator):
    """Make the line again by its settings, on the mesh as it is now"""

    bl_idname = "curve.smooth_polyline_update"
    bl_label = "Update Smooth Polyline"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether the active object is a curve that remembers."""
        active = context.object
        if active is not None and active.type == "CURVE" and active.data.smooth_polyline.stored:
            return True
        cls.poll_message_set("Select a curve that was made by Smooth Polylines")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Make the line of the active curve again."""
        return guard.run_guarded(self, lambda: session.update_curve(context, context.object.data))
