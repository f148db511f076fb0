# SPDX-License-Identifier: GPL-3.0-or-later
"""Put Lines into Mesh: its panel, and one call into `seams.put`. Holds no logic of its own."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty

from .. import guard, session, settings
from ..seams import choose, put, report
from ..seams import settings as seam_settings
from .interruptible import Interruptible

SOURCES = (
    ("AUTO", "Automatic", "Picked faces where there are any in Edit Mode, else the selected curves"),
    ("CURVES", "Selected Curves", "Curves and grease pencil that are selected and lie on the mesh"),
    ("PICKS", "Picked Faces", "A line through the faces picked in Edit Mode, one after another"),
)


class MESH_OT_smooth_polyline_seam(
    Interruptible,
    seam_settings.PutSettings,
    settings.LineSettings,
    bpy.types.Operator,
):
    """Make smooth lines a part of the mesh: as seams or other marks on edges, existing ones or new ones"""

    bl_idname = "mesh.smooth_polyline_seam"
    bl_label = "Put Lines into Mesh"
    bl_options = {"REGISTER", "UNDO"}

    method: EnumProperty(
        name="Method", description="How the line gets into the mesh", items=seam_settings.METHODS, default="CUT"
    )
    lines: EnumProperty(name="Lines", description="Where the lines come from", items=SOURCES, default="AUTO")
    smooth_drawn: BoolProperty(
        name="Smooth Drawn Lines",
        description="Smooth curves that were not made by Smooth Polylines by the filter below; else they are followed",
        default=False,
    )
    max_distance: FloatProperty(
        name="Max Distance",
        description="A drawn line further from the surface than this is refused; 0: a twentieth of the mesh's diagonal",
        default=0.0,
        min=0.0,
        subtype="DISTANCE",
        unit="LENGTH",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether there can be a mesh and a line."""
        if choose.is_possible(context):
            return True
        cls.poll_message_set(choose.HOW_TO_SELECT)
        return False

    def draw(self, context: bpy.types.Context) -> None:
        """Lay out the panel of the last operation; what does not matter now is greyed out."""
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.row().prop(self, "method", expand=True)
        self.draw_marks(layout)
        row = layout.row()
        row.enabled = self.method == "CUT"
        row.prop(self, "tolerance")
        layout.prop(self, "unwrap")
        layout.separator()
        layout.prop(self, "lines")
        layout.prop(self, "smooth_drawn")
        layout.prop(self, "max_distance")
        for name in ("filter", "closed", "pinned", "detail_size"):
            layout.prop(self, name)
        self.draw_told(layout)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Put the lines into the mesh."""
        return guard.run_guarded(self, lambda: self.put_lines(context))

    def put_lines(self, context: bpy.types.Context) -> None:
        """Find mesh and lines, call the plain function, tell what came out."""
        mesh_object = choose.find_mesh_object(context)
        done = put.put_lines_into_mesh(
            context,
            mesh_object,
            self.find_lines(context, mesh_object),
            method=self.method,
            marks=seam_settings.order_marks(self.marks),
            weight=self.weight,
            tolerance=self.tolerance if self.method == "CUT" else None,
            max_distance=self.max_distance or None,
            unwrap=self.unwrap,
            **(settings.choose_line_options(self) if self.smooth_drawn else {}),
        )
        told, is_warning = report.describe(done)
        self.told = "\n".join(report.list_islands(done.islands))
        self.report({"WARNING" if is_warning else "INFO"}, told)

    def find_lines(self, context: bpy.types.Context, mesh_object: bpy.types.Object) -> list:
        """Picked faces as one line, or the selected objects."""
        has_picks = mesh_object.data.is_editmode and mesh_object.data.total_face_sel > 0
        if self.lines == "PICKS" or (self.lines == "AUTO" and has_picks):
            return [session.compute_polyline(context, mesh_object, **settings.choose_line_options(self)).line]
        return choose.find_line_objects(context)
