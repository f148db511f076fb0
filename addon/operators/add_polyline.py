# SPDX-License-Identifier: GPL-3.0-or-later
"""Edit Mode > Face > Add Smooth Polyline: the properties, their panel, and one call into `session`.

Holds no logic of its own; names and enum items of the properties are fixed, scripts rely on them.
"""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from .. import guard, selection, session

FILTERS = (
    ("LINEAR", "Linear", "Straighten: every crossing moves to the straight line between its neighbours"),
    ("CUBIC", "Cubic", "Keep the overall shape and take out small detail"),
    ("GEODESIC", "Geodesic", "The locally shortest line on the surface, exactly"),
    ("FAIR", "Fair", "The smoothest line near the picks, whatever the triangulation"),
    ("NONE", "None", "No smoothing: through the midpoints of the edges between the picked faces"),
)
PINS = (
    ("ENDS", "Ends", "Only the two ends of an open line are passed exactly; the other picks are hints"),
    ("ALL", "All Picks", "The line passes through the centre of every picked face"),
)
SOLVERS = (
    ("AUTO", "Automatic", "The fastest that goes all the way"),
    (
        "HEAP",
        "One by One",
        "The method of the paper: one crossing at a time, the most wrong first, up to the threshold",
    ),
)
KNOTS = (
    ("CENTRIPETAL", "Centripetal", "Steps by the square root of the distances: the smoothest lines"),
    ("UNIFORM", "Uniform", "As in the paper: equal steps, whatever the distances of the crossings"),
    ("CHORDAL", "Chordal", "Steps by the distances"),
)
NOT_CONVERGED = {
    "cycle": "the line came back to an earlier state; the last one is kept",
    "max_iterations": "the limit of rounds was reached; raise Max Iterations to go on",
}


class MESH_OT_smooth_polyline_add(bpy.types.Operator):
    """Add a smooth curve on the surface, through the faces in the order they were picked"""

    bl_idname = "mesh.smooth_polyline_add"
    bl_label = "Add Smooth Polyline"
    bl_options = {"REGISTER", "UNDO"}

    filter: EnumProperty(name="Filter", description="What makes the line smooth", items=FILTERS, default="LINEAR")
    closed: BoolProperty(name="Closed", description="Join the last pick to the first", default=False)
    pinned: EnumProperty(name="Pinned", description="Picks that the line passes exactly", items=PINS, default="ENDS")
    solver: EnumProperty(name="Solver", description="How Linear and Cubic are computed", items=SOLVERS, default="AUTO")
    knots: EnumProperty(name="Knots", description="Spacing that Cubic works with", items=KNOTS, default="CENTRIPETAL")
    support: IntProperty(
        name="Support",
        description="Crossings on each side that Cubic looks at; 2: as in the paper, more: larger detail goes",
        default=2,
        min=2,
        max=16,
    )
    threshold: FloatProperty(
        name="Threshold",
        description="Error at which sliding stops, as a part of an edge: for Cubic, and for Linear one by one",
        default=1e-4,
        min=1e-12,
        max=1.0,
        soft_min=1e-8,
        soft_max=0.1,
        precision=6,
    )
    max_iterations: IntProperty(
        name="Max Iterations",
        description="Most rounds of smoothing; 0: the filter's own limit",
        default=0,
        min=0,
        soft_max=1000,
    )
    detail_size: FloatProperty(
        name="Detail Size",
        description="Fair only: wiggles much shorter than this go, longer ones stay; 0: automatic",
        default=0.0,
        min=0.0,
        subtype="DISTANCE",
        unit="LENGTH",
    )
    bevel: FloatProperty(
        name="Bevel",
        description="Radius of the tube that shows the curve; 0: automatic, from the size of the mesh",
        default=0.0,
        min=0.0,
        precision=4,
        subtype="DISTANCE",
        unit="LENGTH",
    )
    offset: FloatProperty(
        name="Offset",
        description="Distance from the surface along its normal; 0: exactly on it",
        default=0.0,
        precision=4,
        subtype="DISTANCE",
        unit="LENGTH",
    )
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
        layout.use_property_split = True
        layout.use_property_decorate = False
        is_by_heap = self.solver == "HEAP" and self.filter in {"LINEAR", "CUBIC"}
        for name, is_enabled in (
            ("filter", True),
            ("closed", True),
            ("pinned", True),
            ("detail_size", self.filter == "FAIR"),
            ("knots", self.filter == "CUBIC"),
            ("support", self.filter == "CUBIC"),
            ("solver", self.filter in {"LINEAR", "CUBIC"}),
            ("threshold", self.filter == "CUBIC" or is_by_heap),
            ("max_iterations", self.filter != "NONE"),
        ):
            row = layout.row()
            row.enabled = is_enabled
            row.prop(self, name)
        layout.separator()
        for name in ("bevel", "offset", "name"):
            layout.prop(self, name)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Make the curve from the picked faces of the active mesh."""
        return guard.run_guarded(self, lambda: self.add_polyline(context))

    def add_polyline(self, context: bpy.types.Context) -> None:
        """Translate the properties, call the session, tell what came out."""
        mesh_object = context.edit_object
        added = session.add_polyline(
            context,
            mesh_object,
            bevel=self.bevel or None,
            offset=self.offset,
            name=self.name,
            closed=self.closed,
            filter=self.filter.lower(),
            pinned=self.pinned.lower(),
            # Greyed out for the other filters, where a value left over from before must do no harm.
            solver=self.solver.lower() if self.filter in {"LINEAR", "CUBIC"} else "auto",
            knots=self.knots.lower() if self.filter == "CUBIC" else "centripetal",
            support=self.support if self.filter == "CUBIC" else 2,
            threshold=self.threshold,
            max_iterations=self.max_iterations or None,
            detail_size=(self.detail_size or None) if self.filter == "FAIR" else None,
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
