# SPDX-License-Identifier: GPL-3.0-or-later
"""Edit Mode > Face > Add Smooth Polyline: its panel, and one call into `session`.

Holds no logic of its own; the properties are those of `settings`.
"""

import bpy

from .. import active, guard, selection, session, settings
from .interruptible import Interruptible

NOT_CONVERGED = {
    "cycle": "the line came back to an earlier state; the last one is kept",
    "max_iterations": "the limit of rounds was reached; raise Max Iterations to go on",
}


class MESH_OT_smooth_polyline_add(Interruptible, settings.NewLineSettings, bpy.types.Operator):
    """Add a smooth curve on the surface, through the faces in the order they were picked"""

    bl_idname = "mesh.smooth_polyline_add"
    bl_label = "Add Smooth Polyline"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether there is a mesh in Edit Mode."""
        if active.is_editing_mesh(context):
            return True
        cls.poll_message_set("Enter Edit Mode on a mesh and pick faces, one after another")
        return False

    def draw(self, _context: bpy.types.Context) -> None:
        """Lay out the panel of the last operation; what the filter does not use is greyed out."""
        settings.draw_new_line_settings(self.layout, self)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Make the curve from the picked faces, one for each mesh that has some."""
        return guard.run_guarded(self, lambda: self.add_polylines(context))

    def add_polylines(self, context: bpy.types.Context) -> None:
        """Translate the properties, call the session, tell what came out."""
        picked = selection.list_picked_objects(context) or [active.get_edited(context)]
        all_added = session.add_polylines(
            context,
            [(mesh_object, None) for mesh_object in picked],
            **settings.choose_new_line_options(self),
            **settings.choose_line_options(self),
        )
        for added in all_added:
            self.tell(added)

    def tell(self, added: session.AddedPolyline) -> None:
        """Report how a line came out."""
        report = added.line.report
        told = f"{added.curve_object.name}: through {len(added.picks)} picks with {len(added.line.points)} points"
        if report.stop_reason in NOT_CONVERGED:
            self.report({"WARNING"}, f"{told}; {NOT_CONVERGED[report.stop_reason]}")
        else:
            self.report({"INFO"}, f"{told}, {report.iterations} rounds")
