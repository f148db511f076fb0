# SPDX-License-Identifier: GPL-3.0-or-later
"""Put Net into Mesh: its panel, and one call into `seams.nets`. Holds no logic of its own."""

import bpy
from bpy.props import BoolProperty, EnumProperty

from .. import active, guard, settings
from ..seams import nets, report
from ..seams import settings as seam_settings
from .interruptible import Interruptible

CONNECTIONS = (
    ("AUTOMATIC", "Automatic", "Picks that are neighbours on the surface: patches lie around the picks"),
    ("ALL", "All Pairs", "Each pick with each other one"),
    ("CHAIN", "Chain", "Each pick with the next, in the order of picking"),
    ("LOOP", "Loop", "Each pick with the next, and the last with the first"),
)
OUTPUTS = (
    ("FACE_SETS", "Face Sets", "A face set of Sculpt Mode for each patch"),
    ("MATERIALS", "Materials", "A new material for each patch, in a colour of its own"),
    ("COLORS", "Colors", "A color attribute with a colour for each patch"),
)


class MESH_OT_smooth_polyline_net(
    Interruptible,
    seam_settings.PutSettings,
    settings.LineSettings,
    bpy.types.Operator,
):
    """Join the selected faces by smooth lines, cut them into the mesh, and tell the patches between them apart"""

    bl_idname = "mesh.smooth_polyline_net"
    bl_label = "Put Net into Mesh"
    bl_options = {"REGISTER", "UNDO"}

    connections: EnumProperty(
        name="Connections", description="Which picks are joined", items=CONNECTIONS, default="AUTOMATIC"
    )
    outputs: EnumProperty(
        name="Patches",
        description="What the patches become; Shift-click for several. With the mark Seam they are UV islands",
        items=OUTPUTS,
        options={"ENUM_FLAG"},
        default={"FACE_SETS"},
    )
    crossings_as_nodes: BoolProperty(
        name="Crossings Become Picks",
        description="Where lines must cross, they start anew from the crossing",
        default=False,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether there is a mesh in Edit Mode."""
        if active.is_editing_mesh(context):
            return True
        cls.poll_message_set("Enter Edit Mode on a mesh and select the faces that shall be joined")
        return False

    def draw(self, _context: bpy.types.Context) -> None:
        """Lay out the panel of the last operation, with the patches that came out."""
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ("connections", "filter"):
            layout.prop(self, name)
        row = layout.row()
        row.enabled = self.filter == "FAIR"
        row.prop(self, "detail_size")
        layout.prop(self, "crossings_as_nodes")
        layout.column().prop(self, "outputs")
        self.draw_marks(layout)
        layout.prop(self, "tolerance")
        layout.prop(self, "unwrap")
        self.draw_told(layout)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Make the net from the selected faces of the active mesh."""
        return guard.run_guarded(self, lambda: self.put_net(context))

    def put_net(self, context: bpy.types.Context) -> None:
        """Call the plain function, tell what came out."""
        options = settings.choose_line_options(self)
        # A net's lines are open and end at their picks.
        del options["closed"], options["pinned"]
        done = nets.put_net_into_mesh(
            context,
            active.get_edited(context),
            connections=self.connections,
            outputs=[output for output in nets.OUTPUTS if output in self.outputs],
            marks=seam_settings.order_marks(self.marks),
            weight=self.weight,
            tolerance=self.tolerance,
            crossings_as_nodes=self.crossings_as_nodes,
            unwrap=self.unwrap,
            **options,
        )
        told, is_warning = report.describe_net(done)
        self.told = "\n".join([*report.list_sides(done.sides), *report.list_islands(done.lines.islands)])
        self.report({"WARNING" if is_warning else "INFO"}, told)
