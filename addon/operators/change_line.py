# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be done to the active line: make it again, make it another kind of object. Holds no logic of its own."""

import bpy
from bpy.props import EnumProperty

from .. import active, change_output, guard, line_data, session
from ..live import memory
from .interruptible import Interruptible


class CURVE_OT_smooth_polyline_update(Interruptible, bpy.types.Operator):
    """Make the line again by its settings, on the mesh as it is now"""

    bl_idname = "curve.smooth_polyline_update"
    bl_label = "Update Smooth Polyline"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether the active object is a curve that remembers."""
        if memory.find_memory(active.get_active(context)) is not None:
            return True
        cls.poll_message_set("Select a curve that was made by Smooth Polylines")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Make the line of the active curve again."""
        return guard.run_guarded(self, lambda: session.update_curve(context, active.get_active(context).data))


class OBJECT_OT_smooth_polyline_change_output(bpy.types.Operator):
    """Make this line another kind of object, with the same name, picks and settings"""

    bl_idname = "object.smooth_polyline_change_output"
    bl_label = "Change Output of Smooth Polyline"
    bl_options = {"REGISTER", "UNDO"}

    output: EnumProperty(name="Output", description="The kind of object that the line becomes", items=line_data.OUTPUTS)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether the active object is a line that remembers, in Object Mode."""
        if active.is_in_object_mode(context) and memory.find_memory(active.get_active(context)) is not None:
            return True
        cls.poll_message_set("In Object Mode, select a curve that was made by Smooth Polylines")
        return False

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Replace the active object."""
        return guard.run_guarded(
            self, lambda: change_output.change_output(context, active.get_active(context), self.output)
        )
