# SPDX-License-Identifier: GPL-3.0-or-later
"""Edit Mode > Face > Add Smooth Polyline: its panel, and one call into `session`.

Holds no logic of its own; the properties are those of `settings`, and a name.
"""

import bpy
from bpy.props import StringProperty

from .. import guard, selection, session, settings

NOT_CONVERGED = {
    "cycle": "the line came back to an earlier state; the last one is kept",
    "max_iterations": "the limit of rounds was reached; raise Max Iterations to go on",
}


class MESH_OT_smooth_polyline_add(settings.LineSettings, bpy.types.Operator):
    """Add a smooth curve on the surface, through the faces in the order they were picked"""

    bl_idname = "mesh.smooth_polyline_add"
    bl_label = "Add Smooth Polyline"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="Name of the new curve object", default=session.DEFAULT_NAME)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether there is a mesh in Edit Mode."""
        if context.mode == "EDIT_MESH":
            return True
        cls.poll_message_set("Enter Edit Mode on a mesh and pick faces, one after another")
        return False

    def draw(self, _context: bpy.types.Context) -> None:
        """Lay out the panel of the last operation; what the filter does not use is greyed out."""
        layout = self.layout
        settings.draw_line_settings(layout, self)
        layout.prop(self, "name")

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Make the curve from the picked faces of the active mesh."""
        return guard.run_guarded(self, lambda: self.add_polyline(context))

    def add_polyline(self, context: bpy.types.Context) -> None:
        """Translate the properties, call the session, tell what came out."""
        mesh_object = context.edit_object
        added = session.add_polyline(
            context,
            mesh_object,
            source=self.source,
            bevel=self.bevel or None,
            offset=self.offset,
            resample=self.resample,
            name=self.name,
            **settings.choose_line_options(self),
        )
        report = added.line.report
        told = f"Line through {len(added.picks)} picks with {len(added.line.points)} points"
        ignored = selection.find_ignored_objects(context, mesh_object)
        if ignored:
            self.report(
                {"WARNING"},
                f"{told}, on the active object {mesh_object.name} only, not on {', '.join(ignored)}",
            )
        elif report.stop_reason in NOT_CONVERGED:
            self.report({"WARNING"}, f"{told}; {NOT_CONVERGED[report.stop_reason]}")
        else:
            self.report({"INFO"}, f"{told}, {report.iterations} rounds")
